"""Traces from GeoJSON, GeoPackage and shapefile; numbers of a network."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from femdem.network.network_numbers import exact_graph, numbers_of, write_line_mesh
from femdem.network.traces import TraceError, read_traces

TOP = Path(__file__).resolve().parent.parent


def geojson(path, features, **more):
    """Write a file of features [(properties, geometry type, coordinates)]"""
    data = {
        "type": "FeatureCollection",
        "features": [
            {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": points}}
            for properties, kind, points in features
        ],
    }
    path.write_text(json.dumps({**data, **more}), encoding="utf-8")
    return path


BENT = ({"trace": "a"}, "LineString", [[0, 0], [1, 0.5], [2, 0.5, 17.0]])
TWO = ({"name": "b"}, "MultiLineString", [[[0, 1], [2, 1]], [[0, 1.5], [2, 1.6]]])
DOT = ({}, "Point", [1, 1])


@pytest.mark.tools
def test_geojson_gives_what_the_same_csv_gives(tmp_path):
    traces = read_traces(geojson(tmp_path / "map.geojson", [BENT, TWO, DOT]))
    (tmp_path / "map.csv").write_text(
        "x1,y1,x2,y2,trace\n0,0,1,0.5,a\n1,0.5,2,0.5,a\n0,1,2,1,b\n0,1.5,2,1.6,b\n", encoding="utf-8"
    )
    same = read_traces(tmp_path / "map.csv")
    assert traces.name == same.name == ["a", "b"]
    assert np.array_equal(traces.segment, same.segment)
    assert np.array_equal(traces.trace, same.trace)


@pytest.mark.tools
def test_features_without_a_name_have_their_number(tmp_path):
    nameless = [({}, *BENT[1:]), (None, *TWO[1:])]
    assert read_traces(geojson(tmp_path / "map.json", nameless)).name == ["0", "1"]


@pytest.mark.tools
def test_bad_geojson_is_told(tmp_path):
    path = tmp_path / "map.geojson"
    degrees = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    for make, message in (
        (lambda: path.write_text("{", encoding="utf-8"), "map.geojson:1: this is no GeoJSON"),
        (lambda: path.write_text("[]", encoding="utf-8"), "there is no type"),
        (lambda: geojson(path, [DOT]), r"there are no lines in the file \(1 other geometries\)"),
        (lambda: geojson(path, [BENT], crs=degrees), "its coordinates are degrees"),
        (lambda: geojson(path, [({}, "LineString", [["x", 0], [1, 1]])]), "are no numbers"),
        (path.unlink, "cannot be read"),
    ):
        make()
        with pytest.raises(TraceError, match=message):
            read_traces(path)


@pytest.mark.tools
@pytest.mark.parametrize("suffix", [".gpkg", ".shp"])
def test_layers_by_the_library(tmp_path, suffix):
    path = tmp_path / f"map{suffix}"
    try:
        from pyogrio import raw
        from shapely.geometry import LineString
    except ModuleNotFoundError:
        path.touch()
        with pytest.raises(TraceError, match="GeoPackages and shapefiles need pyogrio"):
            read_traces(path)
        return
    lines = [LineString([[0, 0], [1, 0.5]]), LineString([[0, 1], [2, 1]])]
    lines = np.array([line.wkb for line in lines], dtype=object)
    names = np.array(["a", "b"], dtype=object)
    raw.write(path, lines, [names], ["trace"], geometry_type="LineString", crs="EPSG:32630")
    traces = read_traces(path)
    assert traces.name == ["a", "b"]
    assert np.array_equal(traces.segment, [[0, 0, 1, 0.5], [0, 1, 2, 1]])


@pytest.mark.tools
def test_numbers_of_a_small_network(tmp_path):
    # Two crossing traces, one that abuts, one apart; two ends on the window's sides
    path = tmp_path / "map.csv"
    path.write_text(
        "x1,y1,x2,y2,trace\n0,1,3,1,a\n1,0.5,1,1.5,b\n2,1,2,1.5,c\n2.5,0.25,2.75,0.25,d\n", encoding="utf-8"
    )
    graph, length = exact_graph(read_traces(path), (0, 0, 3, 2))
    rows = numbers_of(graph, length).rows()
    assert [rows[name] for name in ("nodes_I", "nodes_Y", "nodes_X", "nodes_on_boundary")] == [5, 1, 1, 2]
    assert (rows["traces"], rows["branches"]) == (4, 7)
    assert rows["P20_1_m2"] == pytest.approx(4 / 6)
    assert rows["P21_1_m"] == pytest.approx((3 + 1 + 0.5 + 0.25) / 6)
    # (3 Y + 4 X) over half of (I + 3 Y + 4 X) branches; 2 (Y + X) over half of (I + Y) traces
    assert rows["connections_per_branch"] == pytest.approx(7 / 6)
    assert rows["connections_per_trace"] == pytest.approx(4 / 3)


@pytest.mark.tools
def test_a_mesh_of_lines_has_fractures_and_sides(tmp_path):
    path = tmp_path / "map.csv"
    path.write_text("x1,y1,x2,y2,trace\n0,1,3,1,a\n1,0.5,1,1.5,b\n", encoding="utf-8")
    write_line_mesh(tmp_path / "lines.msh", exact_graph(read_traces(path), (0, 0, 3, 2))[0])
    text = (tmp_path / "lines.msh").read_text(encoding="utf-8")
    assert '1 1 "fractures"' in text
    elements = [line.split() for line in text.split("$Elements\n")[1].splitlines()[1:-1]]
    tags = [int(words[3]) for words in elements]
    # Four pieces of the cross; left and right in two each
    assert [tags.count(tag) for tag in (1, 2, 3, 4, 5)] == [4, 2, 2, 1, 1]


@pytest.mark.tools
def test_network_numbers_says_what_is_wrong(tmp_path):
    command = [TOP / "bin" / "femdem-numbers", tmp_path / "none.csv"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "none.csv: cannot be read" in done.stderr
