"""Holes and zones of other rock in the window of a network: from what the user gives to the lines a mesh must follow.

A hole is a circle cut out of the mesh; the mesh has a regular polygon with its corners on the circle. A zone is a polygon
whose rock has a physical surface of its own. Where zones overlap the first counts; holes are cut out of all.
"""

import csv
import itertools
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from femdem.network.planar_graph import COINCIDENT, Window
from femdem.network.traces import TraceError, Traces

LEAST_SIDES = 16  # of the polygon of a hole
HOLE = "hole"


@dataclass
class Hole:
    """A circular opening, as a regular polygon."""

    x: float  # centre [m]
    y: float
    radius: float  # [m]
    sides: int
    name: str  # of its physical curve

    @property
    def corners(self):
        """Corners of the polygon, anticlockwise (sides, 2) [m]."""
        angle = 2 * np.pi * np.arange(self.sides) / self.sides
        return np.column_stack([self.x + self.radius * np.cos(angle), self.y + self.radius * np.sin(angle)])

    @property
    def area(self):
        """Of the polygon [m2]."""
        return self.sides / 2 * self.radius**2 * np.sin(2 * np.pi / self.sides)

    @property
    def perimeter(self):
        """Of the polygon [m]."""
        return 2 * self.sides * self.radius * np.sin(np.pi / self.sides)

    @property
    def inscribed(self):
        """Radius of the circle within the polygon [m]."""
        return self.radius * np.cos(np.pi / self.sides)


@dataclass
class Regions:
    """Holes, zones and the lines that part them."""

    holes: list = field(default_factory=list)
    zones: list = field(default_factory=list)  # (name, shapely polygon within the window, without the holes)
    window: Window = None

    def name_at(self, point, rock):
        """Name of the rock at a shapely point."""
        return next((name for name, polygon in self.zones if polygon.contains(point)), rock)


def add_options(parser):
    """The options that say which rock is meshed: window, holes and zones."""
    parser.add_argument(
        "--window",
        type=float,
        nargs=4,
        metavar=("X0", "Y0", "X1", "Y1"),
        help="rectangle to mesh (m; default: extent of the traces)",
    )
    parser.add_argument(
        "--hole",
        action="append",
        default=[],
        type=float,
        nargs=3,
        metavar=("X", "Y", "R"),
        help="circular opening (m), with the physical curve 'hole' ('hole_1', 'hole_2', ... when there are several; repeat)",
    )
    parser.add_argument(
        "--zone",
        action="append",
        default=[],
        nargs=2,
        metavar=("POLYGON", "NAME"),
        help="rock with a physical surface of its own: a CSV file of corners (header x,y) or 'x,y x,y x,y' (repeat)",
    )


def read_zone(text):
    """Corners of a zone (corners, 2) [m]: of a CSV file with the header x,y, or of a text 'x,y x,y x,y ...'."""
    path = Path(text)
    if path.is_file():
        try:
            with path.open(newline="", encoding="utf-8-sig") as file:
                rows = [row for row in csv.reader(file) if any(word.strip() for word in row)]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise TraceError(f"{path}: cannot be read: {error}") from error
        if not rows or [word.strip().lower() for word in rows[0]] != ["x", "y"]:
            raise TraceError(f"{path}: the first line of a zone must be x,y")
        rows = rows[1:]
    elif "," in text:
        rows = [word.split(",") for word in text.replace(";", " ").split()]
    else:
        raise TraceError(f"--zone {text}: there is no such file, and it is no polygon 'x,y x,y x,y'")
    try:
        corners = np.array([[float(word) for word in row] for row in rows]).reshape(len(rows), -1)
    except ValueError:
        corners = np.full((1, 2), np.nan)
    if len(corners) and (corners.ndim != 2 or corners.shape[1:] != (2,) or not np.isfinite(corners).all()):
        raise TraceError(f"--zone {text}: its corners must be pairs of finite numbers, x,y")
    if len(corners) > 1 and (corners[0] == corners[-1]).all():
        corners = corners[:-1]
    if len(corners) < 3:
        raise TraceError(f"--zone {text}: a zone needs three corners, this one has {len(corners)}")
    return corners


def make_holes(circles, window, size, feature):
    """Holes from circles (x, y, radius) [m]; all that is wrong with them is said in one TraceError."""
    wrong, holes = [], []
    for k, (x, y, radius) in enumerate(circles):
        text = f"--hole {x:g} {y:g} {radius:g}"
        if not np.isfinite([x, y, radius]).all() or not radius >= size:
            wrong.append(f"{text}: the radius must be at least the element size, {size:g} m")
            continue
        room = min(x - window[0], window[2] - x, y - window[1], window[3] - y) - radius
        if not room >= feature:
            wrong.append(f"{text}: it must lie in the window, at least {feature:g} m from its sides")
        for other in holes:
            if np.hypot(x - other.x, y - other.y) < radius + other.radius + feature:
                wrong.append(
                    f"{text}: it must be at least {feature:g} m from the hole at ({other.x:g}, {other.y:g})"
                )
        name = HOLE if len(circles) == 1 else f"{HOLE}_{k + 1}"
        sides = max(LEAST_SIDES, int(np.ceil(2 * np.pi * radius / size)))
        holes.append(Hole(x, y, radius, sides, name))
    if wrong:
        raise TraceError("\n".join(wrong))
    return holes


def make_regions(circles, polygons, window, size, feature):
    """Regions of holes (x, y, radius) [m] and zones (corners (corners, 2) [m], name) in a window."""
    if not circles and not polygons:
        return Regions(window=Window(window))
    from shapely.geometry import Polygon, box

    holes = make_holes(circles, window, size, feature)
    cut = [Polygon(hole.corners) for hole in holes]
    rest = box(*window)
    for hole in cut:
        rest = rest.difference(hole)
    wrong, zones = [], []
    for corners, name in polygons:
        zone = Polygon(corners)
        if not zone.is_valid or not zone.area > 0.0:
            wrong.append(f"--zone {name}: its border crosses itself or has no area")
            continue
        part = areas_of(rest.intersection(zone))
        if not part.area > feature**2:
            wrong.append(f"--zone {name}: nothing of it lies in the window and outside other zones")
            continue
        rest = rest.difference(part)
        zones.append((name, part))
    if wrong:
        raise TraceError("\n".join(wrong))
    lines, of_hole = border_lines(window, cut, [part for _, part in zones])
    window = Window(window, lines, of_hole, [(hole.x, hole.y, hole.inscribed) for hole in holes])
    return Regions(holes, zones, window)


def areas_of(shape):
    """The areas of what two areas share, without the points and lines where they only touch."""
    from shapely.geometry import Polygon
    from shapely.ops import unary_union

    return unary_union([part for part in getattr(shape, "geoms", [shape]) if isinstance(part, Polygon)])


def border_lines(window, holes, zones):
    """Straight pieces of the borders inside the window that meet at their ends only, and the hole each is of or -1."""
    from shapely.geometry import Point
    from shapely.ops import unary_union

    near = COINCIDENT * max(window[2] - window[0], window[3] - window[1])
    noded = unary_union([polygon.boundary for polygon in [*holes, *zones]])
    pieces = getattr(noded, "geoms", [noded])
    lines = np.array([pair for piece in pieces for pair in itertools.pairwise(piece.coords)])
    # Ends that differ by rounding become one, those on the sides of the window lie there exactly
    ends = lines.reshape(-1, 2)
    group = cKDTree(ends).query_ball_point(ends, near)
    ends = ends[[min(members) for members in group]]
    for axis in (0, 1):
        for side in (window[axis], window[axis + 2]):
            ends[np.abs(ends[:, axis] - side) < near, axis] = side
    lines = ends.reshape(-1, 2, 2)
    corner = np.array(window, dtype=float)
    on_side = (lines == corner[:2]).all(axis=1) | (lines == corner[2:]).all(axis=1)
    lines = lines[~on_side.any(axis=1) & (lines[:, 0] != lines[:, 1]).any(axis=1)]
    of_hole = np.full(len(lines), -1)
    for k, middle in enumerate(lines.mean(axis=1)):
        for h, hole in enumerate(holes):
            if hole.boundary.distance(Point(middle)) < near:
                of_hole[k] = h
    return lines, of_hole


def outside_holes(traces, holes):
    """The parts of the traces outside the polygons of holes."""
    segment, trace = traces.segment, traces.trace
    for hole in holes:
        corners = hole.corners
        along = np.roll(corners, -1, axis=0) - corners
        inward = np.column_stack([-along[:, 1], along[:, 0]])
        start, end = segment[:, :2], segment[:, 2:]
        # Depth behind each side, at both ends: inside between the last entry and the first exit
        first = (start @ inward.T) - (corners * inward).sum(axis=1)
        last = (end @ inward.T) - (corners * inward).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = first / (first - last)
        enter = np.where((first < 0) & (last > 0), part, np.where((first <= 0) & (last <= 0), 2.0, 0.0)).max(
            axis=1
        )
        leave = np.where((first > 0) & (last < 0), part, 1.0).min(axis=1)
        inside = enter < leave
        enter, leave = np.where(inside, enter, 1.0)[:, None], np.where(inside, leave, 1.0)[:, None]
        before = np.hstack([start, np.where(enter == 1.0, end, start + enter * (end - start))])
        after = np.hstack([start + leave * (end - start), end])
        keep_before, keep_after = enter[:, 0] > 0.0, leave[:, 0] < 1.0
        order = np.concatenate([np.flatnonzero(keep_before), np.flatnonzero(keep_after) + 0.5])
        segment = np.vstack([before[keep_before], after[keep_after]])
        trace = np.concatenate([trace[keep_before], trace[keep_after]])
        place = np.argsort(order, kind="stable")
        segment, trace = segment[place], trace[place]
    return Traces(segment, trace, traces.name)
