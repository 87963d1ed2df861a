"""Traces from files of geographic information systems: GeoJSON by Python alone, GeoPackage and shapefile by pyogrio.

Lines are taken, what else is in the file is counted and left out. Coordinates are metres, x east, y north: a file in degrees is
refused. A trace is a feature; its name is the property `trace`, `name` or `id`, or its number in the file.
"""

import json
from pathlib import Path

import numpy as np

GEOJSON, LAYERS = (".geojson", ".json"), (".gpkg", ".shp")
NAMES = ("trace", "name", "id")
IN_DEGREES = ("CRS84", "EPSG:4326", "EPSG::4326", "WGS 84")


class FormatError(Exception):
    """The file cannot be used; the message says why."""


def read_lines(path):
    """Lines of a file: [(name, points (points, 2))], and how many geometries are no lines."""
    path = Path(path)
    features = geojson_features(path) if path.suffix.lower() in GEOJSON else layer_features(path)
    lines, others = [], 0
    for number, (properties, geometry) in enumerate(features):
        name = next(
            (str(properties[key]) for key in NAMES if properties.get(key) not in (None, "")), str(number)
        )
        found, left = lines_of(geometry)
        others += left
        for points in found:
            try:
                places = np.array([point[:2] for point in points], dtype=float).reshape(-1, 2)
            except (TypeError, ValueError) as error:
                raise FormatError(f"{path}: the coordinates of feature {name} are no numbers") from error
            if not np.isfinite(places).all():
                raise FormatError(f"{path}: a coordinate of feature {name} is not finite")
            lines.append((name, places))
    return lines, others


def lines_of(geometry):
    """Lists of points of a geometry as in GeoJSON, and the number of its parts that are no lines."""
    kind = (geometry or {}).get("type")
    if kind == "LineString":
        return [geometry["coordinates"]], 0
    if kind == "MultiLineString":
        return list(geometry["coordinates"]), 0
    if kind == "GeometryCollection":
        parts = [lines_of(part) for part in geometry["geometries"]]
        return [line for lines, _ in parts for line in lines], sum(left for _, left in parts)
    return [], 1


def geojson_features(path):
    """Properties and geometry of the features of a GeoJSON file."""
    try:
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    except json.JSONDecodeError as error:
        raise FormatError(f"{path}:{error.lineno}: this is no GeoJSON: {error.msg}") from error
    if not isinstance(data, dict) or "type" not in data:
        raise FormatError(f"{path}: this is no GeoJSON: there is no type")
    refuse_degrees(path, json.dumps(data.get("crs", "")))
    try:
        if data["type"] == "FeatureCollection":
            return [(one.get("properties") or {}, one["geometry"]) for one in data["features"]]
        if data["type"] == "Feature":
            return [(data.get("properties") or {}, data["geometry"])]
    except (KeyError, AttributeError, TypeError) as error:
        raise FormatError(f"{path}: this is no GeoJSON: a feature lacks {error}") from error
    return [({}, data)]


def layer_features(path):
    """Properties and geometry of the features of a GeoPackage or shapefile, its first layer."""
    try:
        from pyogrio import raw
        from pyogrio.errors import DataSourceError
        from shapely import wkb
        from shapely.geometry import mapping
    except ModuleNotFoundError as error:
        raise FormatError(
            f"{path}: Python has no module {error.name}; GeoPackages and shapefiles need pyogrio and shapely"
            " (or save the traces as GeoJSON)"
        ) from error
    try:
        meta, _, geometry, fields = raw.read(path)
    except DataSourceError as error:
        raise FormatError(f"{path}: cannot be read: {error}") from error
    refuse_degrees(path, str(meta["crs"]))
    names = [str(name).lower() for name in meta["fields"]]
    shapes = [mapping(wkb.loads(bytes(shape))) if shape else None for shape in geometry]
    return [
        ({name: column[i] for name, column in zip(names, fields, strict=True)}, shape)
        for i, shape in enumerate(shapes)
    ]


def refuse_degrees(path, reference):
    """Coordinates in degrees make no network."""
    if any(word in reference for word in IN_DEGREES):
        raise FormatError(
            f"{path}: its coordinates are degrees; save it in a projection in metres, such as UTM"
        )
