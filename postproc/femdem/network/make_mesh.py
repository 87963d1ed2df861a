"""Mesh of a fracture network: cleans traces, embeds them in a rectangle and grades the mesh towards them.

    femdem-mesh two_sets.csv --size 0.015 --out two_sets.msh

The mesh has the physical surface 'rock', the physical curve 'fractures' (or more, see --group), the physical curves
'left', 'right', 'bottom' and 'top', and the physical points 'corner_sw', 'corner_se', 'corner_ne', 'corner_nw'; with --hole
and --zone also curves of openings and surfaces of other rock. What cleaning changed and the worst elements are printed.
Lengths are in metres, angles in degrees.
"""

import argparse
import itertools
import os
import sys
from collections import Counter
from pathlib import Path

import gmsh
import numpy as np

from femdem.network.cleaning import MIN_ANGLE, checked_window, clean, traces_of
from femdem.network.mesh_quality import MeshData, Quality, check_mesh
from femdem.network.planar_graph import FIRST_LINE, SIDE_NAMES, Graph, branches, nodes_near_edges
from femdem.network.regions import HOLE, add_options, make_regions, outside_holes, read_zone
from femdem.network.traces import TraceError, read_traces, write_traces

FEATURE = 0.35  # default least feature over the element size at fractures
COARSE = 4.0  # default element size far away over that at fractures
GRADING = 0.3  # default growth of the element size per unit distance
SAMPLES = 2  # points a size along fractures, from which distance is measured
NARROWER = 1.4  # step between the sizes at narrow places
ROOMY = 1.5  # size at a narrow place over its width: one element fits without being halved
ALGORITHMS = (6, 5, 1)  # of gmsh, tried in turn: frontal, Delaunay, adaptive
BAD_INPUT, FAILED = 2, 1  # exit status
SURFACE, FRACTURES = "rock", "fractures"
CORNERS = {(0, 0): "corner_sw", (1, 0): "corner_se", (1, 1): "corner_ne", (0, 1): "corner_nw"}  # east, north?


class MeshError(Exception):
    """gmsh gave no mesh that the program would take."""


def is_taken(name):
    """Is it the name of a group that every mesh may have?"""
    own = (SURFACE, FRACTURES, *SIDE_NAMES.values(), *CORNERS.values())
    return name in own or name == HOLE or name.startswith(f"{HOLE}_")


def parse_zones(pairs, groups):
    """Zones of --zone FILE_OR_POLYGON NAME: (corners, name); what is wrong with any is said in one TraceError."""
    zones, wrong = [], []
    for text, name in pairs:
        if not name.strip() or is_taken(name) or name in groups or name in [other for _, other in zones]:
            wrong.append(f"--zone {text} {name}: the name '{name}' is taken")
        try:
            zones.append((read_zone(text), name))
        except TraceError as error:
            wrong.append(str(error))
    if wrong:
        raise TraceError("\n".join(wrong))
    return zones


def parse_group(text):
    """A --group: NAME=FROM:TO, strikes in degrees, or NAME=trace:A,B,..., names of traces."""
    name, equals, what = text.partition("=")
    name = name.strip()
    if not equals or not name:
        raise TraceError(f"--group {text}: it must be NAME=FROM:TO (strikes) or NAME=trace:A,B,... (traces)")
    if is_taken(name):
        raise TraceError(f"--group {text}: the name '{name}' is taken")
    if what.startswith("trace:"):
        return name, {word.strip() for word in what.removeprefix("trace:").split(",")}
    try:
        start, end = (float(word) for word in what.split(":"))
    except ValueError:
        raise TraceError(
            f"--group {text}: '{what}' is neither FROM:TO in degrees nor trace:A,B,..."
        ) from None
    return name, (start, end)


def strikes(graph):
    """Strike of each trace, clockwise from north, 0 to 180 degrees: the axial mean weighted by length."""
    doubled = {}
    along = graph.xy[graph.edge[:, 1]] - graph.xy[graph.edge[:, 0]]
    for trace, (x, y), length in zip(graph.trace, along, graph.lengths, strict=True):
        if trace >= 0:
            turned = length * np.exp(2j * np.arctan2(x, y))
            doubled[int(trace)] = doubled.get(int(trace), 0.0) + turned
    return {trace: float(np.degrees(np.angle(value)) / 2 % 180.0) for trace, value in doubled.items()}


def groups_of_traces(graph, names, choices):
    """Name of the physical curve of each trace: the first group that it fits, or 'fractures'."""
    group = {}
    for trace, strike in strikes(graph).items():
        group[trace] = FRACTURES
        for name, choice in choices:
            fits = (
                names[trace] in choice
                if isinstance(choice, set)
                else (strike - choice[0]) % 180.0 <= choice[1] - choice[0]
            )
            if fits:
                group[trace] = name
                break
    return group


def halve_single_edges(graph, size):
    """Give isolated fractures of one element a node in the middle: an element between two tips cannot open."""
    degree, lengths = graph.degree, graph.lengths
    xy, edge, trace, side = list(graph.xy), graph.edge.copy(), graph.trace, list(graph.side)
    new = []
    for nodes, edges in branches(graph):
        tips = all(degree[n] == 1 and graph.side[n] == 0 for n in (nodes[0], nodes[-1]))
        if tips and len(edges) == 1 and lengths[edges[0]] < 2 * size:
            a, b = edge[edges[0]]
            xy.append((graph.xy[a] + graph.xy[b]) / 2)
            side.append(0)
            edge[edges[0], 1] = len(xy) - 1
            new.append((len(xy) - 1, b, trace[edges[0]]))
    if not new:
        return graph
    new = np.array(new)
    return Graph(
        np.array(xy),
        np.array(side),
        np.vstack([edge, new[:, :2]]),
        np.concatenate([trace, new[:, 2]]),
        graph.window,
    )


def build_geometry(graph, group, regions):
    """Points, lines and surfaces of the cleaned network in gmsh; the gmsh points and lines of the graph."""
    geo = gmsh.model.geo
    point = [geo.addPoint(x, y, 0.0) for x, y in graph.xy]
    line = [geo.addLine(point[a], point[b]) for a, b in graph.edge]
    surfaces = {}
    embedded = []
    for name, loops, inside in faces(graph, line, regions):
        surfaces.setdefault(name, []).append(geo.addPlaneSurface([geo.addCurveLoop(loop) for loop in loops]))
        embedded.append(([line[e] for e in inside], surfaces[name][-1]))
    geo.synchronize()
    for lines, surface in embedded:
        gmsh.model.mesh.embed(1, lines, 2, surface)
    members = {}
    for e, trace in enumerate(graph.trace.tolist()):
        name = curve_name(trace, group, regions)
        if name:
            members.setdefault(name, []).append(line[e])
    for name in sorted(members, key=lambda name: (name in SIDE_NAMES.values(), name)):
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, members[name]), name)
    for name, tags in surfaces.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), name)
    for (east, north), name in CORNERS.items():
        corner = (graph.window[2 * east], graph.window[1 + 2 * north])
        node = int(np.argmin(np.hypot(*(graph.xy - corner).T)))
        gmsh.model.setPhysicalName(0, gmsh.model.addPhysicalGroup(0, [point[node]]), name)
    return point, line


def curve_name(trace, group, regions):
    """Physical curve of an edge of a trace; none for borders between rocks."""
    if trace > FIRST_LINE:
        return SIDE_NAMES[trace] if trace < 0 else group[trace]
    hole = regions.window.of_hole[FIRST_LINE - trace]
    return regions.holes[hole].name if hole >= 0 else ""


def faces(graph, line, regions):
    """Faces of the rock: physical surface, loops of gmsh lines (the outer first), edges of fractures inside."""
    fracture = graph.is_fracture
    if not regions.holes and not regions.zones:
        return [(SURFACE, [boundary_loop(graph, line)], np.flatnonzero(fracture))]
    from shapely.geometry import Point
    from shapely.geometry.polygon import orient
    from shapely.ops import polygonize
    from shapely.prepared import prep

    border = ~fracture | (graph.line_of_edges >= 0)
    number = {tuple(place): n for n, place in enumerate(graph.xy.tolist())}
    tag = {}
    for e, (a, b) in enumerate(graph.edge.tolist()):
        tag[a, b], tag[b, a] = line[e], -line[e]
    middle = [Point(*place) for place in graph.xy[graph.edge].mean(axis=1)]
    found = []
    for polygon in map(orient, polygonize(graph.xy[graph.edge[border]].tolist())):
        place = polygon.representative_point()
        if any(np.hypot(place.x - hole.x, place.y - hole.y) < hole.inscribed for hole in regions.holes):
            continue
        rings = [
            [number[corner] for corner in ring.coords] for ring in (polygon.exterior, *polygon.interiors)
        ]
        loops = [[tag[pair] for pair in itertools.pairwise(ring)] for ring in rings]
        inside = prep(polygon)
        edges = [e for e in np.flatnonzero(~border) if inside.contains(middle[e])]
        found.append((regions.name_at(place, SURFACE), loops, edges))
    return found


def boundary_loop(graph, line):
    """Lines of the boundary, anticlockwise, with a minus sign where they run the other way."""
    centre = np.array([graph.window[0] + graph.window[2], graph.window[1] + graph.window[3]]) / 2
    loop = []
    for e in np.flatnonzero(~graph.is_fracture):
        a, b = graph.xy[graph.edge[e]] - centre
        sign = 1 if a[0] * b[1] - a[1] * b[0] > 0 else -1
        a = a if sign > 0 else b
        loop.append((float(np.arctan2(a[1], a[0])), sign * line[e]))
    return [tag for _, tag in sorted(loop)]


def add_threshold(distance, size, coarse, grading):
    """A field of gmsh: the size at distance 0, growing to the coarse one."""
    field = gmsh.model.mesh.field
    threshold = field.add("Threshold")
    set_option(field.setNumber, threshold, ("IField", "InField"), distance)
    set_option(field.setNumber, threshold, ("LcMin", "SizeMin"), size)
    set_option(field.setNumber, threshold, ("LcMax", "SizeMax"), coarse)
    field.setNumber(threshold, "DistMin", 0.0)
    field.setNumber(threshold, "DistMax", max((coarse - size) / grading, 1e-6 * size))
    return threshold


def narrow_places(graph, point, size):
    """gmsh points where the network is narrower than an element, by the smaller size [m] that fits there.

    Narrow is a node with a short edge, or near an edge that is not its own. Sizes are rounded to few values.
    """
    room = np.full(len(graph.xy), np.inf)
    np.minimum.at(room, graph.edge.ravel(), np.repeat(graph.lengths, 2))
    node, edge, _, distance = nodes_near_edges(graph, size)
    np.minimum.at(room, node, distance)
    ends = graph.edge[edge].ravel()
    away = np.hypot(*(graph.xy[ends] - graph.xy[np.repeat(node, 2)]).T)
    np.minimum.at(room, ends, np.maximum(away, np.repeat(distance, 2)))
    steps = np.floor(np.log(size / (ROOMY * room)) / np.log(NARROWER))
    narrow = {}
    for n in np.flatnonzero(steps > 0):
        narrow.setdefault(size / NARROWER ** int(steps[n]), []).append(point[n])
    return narrow


def set_sizes(graph, point, line, size, coarse, grading):
    """Element sizes: that given along fractures and holes, less at narrow places, growing with the distance from them."""
    field = gmsh.model.mesh.field
    by_samples = {}
    on_line = np.flatnonzero(graph.trace <= FIRST_LINE)
    of_hole = [e for e in on_line if graph.window.of_hole[FIRST_LINE - graph.trace[e]] >= 0]
    for e in [*np.flatnonzero(graph.is_fracture), *of_hole]:
        # Powers of two, so that a few fields do for all lengths
        samples = 2 ** int(np.ceil(np.log2(2 + SAMPLES * graph.lengths[e] / size)))
        by_samples.setdefault(samples, []).append(line[e])
    thresholds = []
    for samples, lines in by_samples.items():
        distance = field.add("Distance")
        set_option(field.setNumbers, distance, ("EdgesList", "CurvesList"), lines)
        set_option(field.setNumber, distance, ("NNodesByEdge", "NumPointsPerCurve", "Sampling"), samples)
        thresholds.append(add_threshold(distance, size, coarse, grading))
    for smaller, points in narrow_places(graph, point, size).items():
        distance = field.add("Distance")
        set_option(field.setNumbers, distance, ("NodesList", "PointsList"), points)
        thresholds.append(add_threshold(distance, smaller, coarse, grading))
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", thresholds)
    field.setAsBackgroundMesh(least)
    for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)


def set_option(setter, field, names, value):
    """Set an option of a field by the first of its names that this version of gmsh knows."""
    for name in names[:-1]:
        try:
            setter(field, name, value)
        except Exception:  # gmsh raises plain exceptions, or ValueError, as its version has it
            continue
        return
    setter(field, names[-1], value)


def read_mesh(path):
    """Read a mesh file back, as the program will see it."""
    gmsh.clear()
    gmsh.open(str(path))
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    number = np.full(int(tags.max()) + 1, -1)
    number[tags.astype(int)] = np.arange(len(tags))
    triangles = [number[t.astype(int)].reshape(-1, 3) for t in gmsh.model.mesh.getElements(2)[2]]
    lines = {}
    for dimension, tag in gmsh.model.getPhysicalGroups(1):
        name = gmsh.model.getPhysicalName(dimension, tag)
        parts = []
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
            parts += [number[n.astype(int)].reshape(-1, 2) for n in gmsh.model.mesh.getElements(1, entity)[2]]
        lines[name] = np.vstack(parts)
    surfaces, count = {}, 0
    for _, entity in gmsh.model.getEntities(2):
        of_entity = sum(len(tags) for tags in gmsh.model.mesh.getElements(2, entity)[1])
        for group in gmsh.model.getPhysicalGroupsForEntity(2, entity):
            surfaces.setdefault(gmsh.model.getPhysicalName(2, group), []).append(
                np.arange(count, count + of_entity)
            )
        count += of_entity
    surfaces = {name: np.concatenate(numbers) for name, numbers in surfaces.items()}
    return MeshData(xyz.reshape(-1, 3)[:, :2], np.vstack(triangles), lines, surfaces)


def write_mesh(graph, group, size, coarse, grading, path, regions):
    """Mesh the cleaned network and write the file, when it is one the program will take; the mesh.

    The file is written under another name, read back and checked, and only then put in its place. Where gmsh's first
    algorithm gives no sound mesh, the others are tried.
    """
    part = Path(f"{path}.part.msh")
    reasons = []
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        for algorithm in ALGORITHMS:
            gmsh.clear()
            point, line = build_geometry(graph, group, regions)
            set_sizes(graph, point, line, size, coarse, grading)
            gmsh.option.setNumber("Mesh.Algorithm", algorithm)
            try:
                gmsh.model.mesh.generate(2)
                gmsh.model.mesh.optimize("Laplace2D", niter=3)
                gmsh.write(str(part))
                mesh = read_mesh(part)
                areas = {name: zone.area for name, zone in regions.zones}
                sides = SIDE_NAMES.values()
                wrong = check_mesh(mesh, graph.window, graph.fracture_length, sides, regions.holes, areas)
            except Exception as error:  # gmsh raises plain exceptions
                wrong = [str(error)]
            if not wrong:
                os.replace(part, path)
                return mesh
            reasons.append(f"gmsh algorithm {algorithm}: " + "; ".join(wrong[:5]))
    finally:
        gmsh.finalize()
        part.unlink(missing_ok=True)
    raise MeshError("no sound mesh was found; try another --size or --feature\n" + "\n".join(reasons))


def draw(path, traces, graph, mesh, quality, places=4):
    """Draw the mesh with the traces as read and as cleaned, and the surroundings of the worst elements."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    worst = []
    for k in np.argsort(quality.angle, kind="stable"):
        if all(
            np.hypot(*(quality.centre[k] - quality.centre[j])) > 10 * np.median(quality.edge) for j in worst
        ):
            worst.append(k)
        if len(worst) == places:
            break
    figure = plt.figure(figsize=(16, 8), layout="constrained")
    grid = figure.add_gridspec(2, 4)
    axes = [figure.add_subplot(grid[:, :2])] + [
        figure.add_subplot(grid[k // 2, 2 + k % 2]) for k in range(places)
    ]
    fractures = graph.xy[graph.edge[graph.is_fracture]]
    for number, axis in enumerate(axes):
        axis.triplot(*mesh.xy.T, mesh.triangle, color="0.7", linewidth=0.2 if number == 0 else 0.6)
        wide = 0.8 if number == 0 else 1.8
        axis.add_collection(
            LineCollection(traces.segment.reshape(-1, 2, 2), colors="tab:orange", linewidths=wide)
        )
        axis.add_collection(LineCollection(fractures, colors="k", linewidths=wide))
        axis.set_aspect("equal")
        axis.set_xlabel("x (m)")
        axis.set_ylabel("y (m)")
    axes[0].set_xlim(graph.window[0], graph.window[2])
    axes[0].set_ylim(graph.window[1], graph.window[3])
    axes[0].set_title(f"{len(mesh.triangle)} triangles; black: cleaned, orange: as read")
    for axis, k in zip(axes[1:], worst, strict=False):
        reach = 6 * np.median(quality.edge)
        x, y = quality.centre[k]
        axis.set_xlim(x - reach, x + reach)
        axis.set_ylim(y - reach, y + reach)
        axis.plot(x, y, "r.")
        axis.set_title(f"least angle {quality.angle[k]:.1f}°")
    figure.savefig(path, dpi=130)
    plt.close(figure)


def arguments_of(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="femdem-mesh", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("traces", help="CSV file of traces: x1,y1,x2,y2,trace")
    parser.add_argument("--size", type=float, required=True, help="element size at fractures (m)")
    parser.add_argument("--coarse", type=float, help=f"largest element size (m; default {COARSE:g} sizes)")
    parser.add_argument(
        "--grading",
        type=float,
        default=GRADING,
        help=f"growth of the size per distance (default {GRADING:g})",
    )
    parser.add_argument("--out", help="mesh file to write (default: the traces' name with .msh)")
    add_options(parser)
    parser.add_argument("--snap", type=float, help="snap tolerance (m; default 5e-4 of the shorter side)")
    parser.add_argument(
        "--feature", type=float, help=f"least feature that stays (m; default {FEATURE:g} sizes)"
    )
    parser.add_argument("--simplify", type=float, help="tolerance of simplifying (m; default half a feature)")
    parser.add_argument(
        "--stub", type=float, help="shorter dangling ends are dropped (m; default two features)"
    )
    parser.add_argument(
        "--min-angle", type=float, default=MIN_ANGLE, help=f"least angle of wedges (default {MIN_ANGLE:g})"
    )
    parser.add_argument(
        "--group",
        action="append",
        default=[],
        metavar="NAME=FROM:TO",
        help="physical curve for traces that strike FROM to TO degrees from north, or NAME=trace:A,B (repeat)",
    )
    parser.add_argument("--cleaned", help="CSV file to write the cleaned traces to")
    parser.add_argument("--figure", help="picture to draw: the mesh and its worst places")
    parser.add_argument("--report", help="text file to write the report to, too")
    parser.add_argument(
        "--worst", type=int, default=5, help="how many of the worst elements are listed (default 5)"
    )
    return parser.parse_args(words)


def read_input(arguments, coarse):
    """Groups, zones and traces of the command line; all that is wrong with any is said in one TraceError."""
    wrong = []

    def attempt(function, *given):
        try:
            return function(*given)
        except TraceError as error:
            wrong.append(str(error))
            return None

    if not arguments.size > 0.0 or not coarse >= arguments.size or not arguments.grading > 0.0:
        wrong.append("--size and --grading must be positive, and --coarse not less than --size")
    choices = [attempt(parse_group, text) for text in arguments.group]
    zones = attempt(parse_zones, arguments.zone, [choice[0] for choice in choices if choice])
    traces = attempt(read_traces, arguments.traces)
    if arguments.window:
        attempt(checked_window, arguments.window)
    if wrong:
        raise TraceError("\n".join(wrong))
    return choices, zones, traces


def run(arguments):
    """Do what the command line asks for; the report's text."""
    size = arguments.size
    coarse = COARSE * size if arguments.coarse is None else arguments.coarse
    out = arguments.out or str(Path(arguments.traces).with_suffix(".msh").name)
    choices, zones, traces = read_input(arguments, coarse)
    feature = FEATURE * size if arguments.feature is None else arguments.feature
    window = checked_window(arguments.window or traces.extent)
    regions = make_regions(arguments.hole, zones, window, size, feature)
    graph, report = clean(
        outside_holes(traces, regions.holes),
        window=regions.window,
        snap=arguments.snap,
        feature=feature,
        simplify=arguments.simplify,
        stub=arguments.stub,
        min_angle=arguments.min_angle,
    )
    graph = halve_single_edges(graph, size)
    group = groups_of_traces(graph, traces.name, choices)
    if arguments.cleaned:
        write_traces(arguments.cleaned, traces_of(graph, traces.name))
    mesh = write_mesh(graph, group, size, coarse, arguments.grading, out, regions)
    quality = Quality.of(mesh)
    if arguments.figure:
        draw(arguments.figure, traces, graph, mesh, quality)
    count = Counter(group.values())
    curves = [
        f"'{name}': {len(lines)} edges" + (f", {count[name]} traces" if name in count else "")
        for name, lines in mesh.line.items()
    ]
    if regions.zones:
        curves += [f"'{name}': {len(triangles)} triangles" for name, triangles in mesh.surface.items()]
    text = "\n".join(
        [f"traces: {arguments.traces}", report.text(), f"mesh: {out}", quality.text(arguments.worst), *curves]
    )
    if arguments.report:
        Path(arguments.report).write_text(text + "\n", encoding="utf-8")
    return text


def main(words=None):
    arguments = arguments_of(words)
    try:
        for line in run(arguments).splitlines():
            print(line, file=sys.stderr if line.startswith("warning: ") else sys.stdout)
    except (TraceError, OSError) as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except ModuleNotFoundError as error:
        print(f"error: Python has no module {error.name}; --hole and --zone need shapely", file=sys.stderr)
        sys.exit(FAILED)
    except MeshError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(FAILED)


if __name__ == "__main__":
    main()
