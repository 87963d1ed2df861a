#!/usr/bin/env python3
"""Meshes of specimens that break, unstructured; --seed gives another mesh of the same specimen.

    python3 specimens.py rectangle --width 0.5 --height 1 --size 0.05 --seed 1
    python3 specimens.py disc --width 1 --flat 10 --size 0.035 --path 0.25
    python3 specimens.py flaw --width 3.2 --height 6.4 --flaw 0.8 --angle 0 --size 0.015 --coarse 0.2 --path 0.25

The surface is `rock`; sides are `bottom`, `right`, `top`, `left`. The disc is loaded on `top` and `bottom`, arcs of --flat
degrees. The flaw, of the given length and inclined by --angle degrees, is the curve `flaw`; with --path the mesh has
edges straight ahead of its tips over that length, and a disc has them up and down from its centre.
Another seed puts a few nodes at other random places.
"""

import argparse
import math
import random

import gmsh

# Random nodes keep this many element sizes from each other and from the outline, and cover that many squared each
APART, COVER = 3.0, 6.0


def rectangle(arguments):
    """Four sides round the origin; the surface."""
    half = arguments.width / 2, arguments.height / 2
    corners = [
        gmsh.model.geo.addPoint(x * half[0], y * half[1], 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    sides = [gmsh.model.geo.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(sides)])
    curves = {name: [side] for name, side in zip(("bottom", "right", "top", "left"), sides, strict=True)}
    inside = (lambda x, y: min(half[0] - abs(x), half[1] - abs(y))), half
    return surface, curves, inside


def disc(arguments):
    """A disc of diameter --width with two arcs to load it."""
    radius, half = arguments.width / 2, math.radians(arguments.flat) / 2
    angles = [
        math.pi / 2 - half,
        math.pi / 2 + half,
        math.pi,
        1.5 * math.pi - half,
        1.5 * math.pi + half,
        2 * math.pi,
    ]
    centre = gmsh.model.geo.addPoint(0, 0, 0)
    points = [gmsh.model.geo.addPoint(radius * math.cos(a), radius * math.sin(a), 0) for a in angles]
    arcs = [gmsh.model.geo.addCircleArc(points[i], centre, points[(i + 1) % 6]) for i in range(6)]
    surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(arcs)])
    if arguments.path > 0:
        ends = [gmsh.model.geo.addPoint(0, k * arguments.path, 0) for k in (-1, 1)]
        line = gmsh.model.geo.addLine(*ends)
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.embed(1, [line], 2, surface)
    curves = {"top": arcs[:1], "left": arcs[1:3], "bottom": arcs[3:4], "right": arcs[4:]}
    inside = (lambda x, y: radius - math.hypot(x, y)), (radius, radius)
    return surface, curves, inside


def add_flaw(arguments, surface, curves):
    """The flaw and the edges ahead of it; the tips."""
    along = math.cos(math.radians(arguments.angle)), math.sin(math.radians(arguments.angle))
    half = arguments.flaw / 2
    tips = [gmsh.model.geo.addPoint(k * half * along[0], k * half * along[1], 0) for k in (-1, 1)]
    flaw = gmsh.model.geo.addLine(*tips)
    ahead = []
    if arguments.path > 0:
        for k, tip in zip((-1, 1), tips, strict=True):
            reach = k * (half + arguments.path)
            ahead.append(
                gmsh.model.geo.addLine(tip, gmsh.model.geo.addPoint(reach * along[0], reach * along[1], 0))
            )
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.embed(1, [flaw, *ahead], 2, surface)
    curves["flaw"] = [flaw]
    return [(k * half * along[0], k * half * along[1]) for k in (-1, 1)], tips, [flaw, *ahead], along


def scatter(arguments, surface, inside, tips, along):
    """Random nodes: over the whole specimen, or round the tips of a flaw."""
    chance = random.Random(arguments.seed)
    depth, half = inside
    points = []
    wanted = int(4 * half[0] * half[1] / (COVER * arguments.size) ** 2) if not tips else 12
    for _ in range(20 * wanted):
        if len(points) == wanted:
            break
        if tips:
            tip = chance.choice(tips)
            far, angle = chance.uniform(APART, 4 * APART) * arguments.size, chance.uniform(0, 2 * math.pi)
            x, y = tip[0] + far * math.cos(angle), tip[1] + far * math.sin(angle)
            if abs(x * along[1] - y * along[0]) < APART * arguments.size:
                continue
        else:
            x, y = (chance.uniform(-h, h) for h in half)
        if depth(x, y) < APART * arguments.size:
            continue
        if any(math.hypot(x - a, y - b) < APART * arguments.size for a, b in points):
            continue
        points.append((x, y))
    nodes = [gmsh.model.geo.addPoint(x, y, 0) for x, y in points]
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.embed(0, nodes, 2, surface)


def set_sizes(arguments, tips, lines):
    """Element size: one everywhere, or fine round the flaw's path (its tips, without a path) and coarse far away."""
    field = gmsh.model.mesh.field
    if not lines:
        field.add("MathEval", 1)
        field.setString(1, "F", str(arguments.size))
        field.setAsBackgroundMesh(1)
        return
    field.add("Distance", 1)
    if arguments.path > 0:
        field.setNumbers(1, "EdgesList", lines)
        field.setNumber(1, "NNodesByEdge", 200)
    else:
        field.setNumbers(1, "NodesList", tips)
    field.add("Threshold", 2)
    fine = arguments.fine
    for name, value in (
        ("IField", 1),
        ("LcMin", arguments.size),
        ("LcMax", arguments.coarse),
        ("DistMin", fine),
        ("DistMax", 3 * fine),
    ):
        field.setNumber(2, name, value)
    field.setAsBackgroundMesh(2)


def make_mesh(arguments):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for option in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.CharacteristicLength{option}", 0)
    surface, curves, inside = disc(arguments) if arguments.kind == "disc" else rectangle(arguments)
    gmsh.model.geo.synchronize()
    tips, tip_nodes, lines, along = [], [], [], (1.0, 0.0)
    if arguments.kind == "flaw":
        tips, tip_nodes, lines, along = add_flaw(arguments, surface, curves)
    if arguments.seed > 0:
        scatter(arguments, surface, inside, tips, along)
    for name, tags in curves.items():
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, tags), name)
    gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [surface]), "rock")
    set_sizes(arguments, tip_nodes, lines)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.mesh.generate(2)
    gmsh.write(arguments.out)
    gmsh.finalize()


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", choices=("rectangle", "disc", "flaw"))
    for name, default, meaning in (
        ("width", 0.5, "width or diameter [m]"),
        ("height", 1.0, "height [m]"),
        ("size", 0.05, "element size [m]"),
        ("flat", 10.0, "loaded arc [degrees]"),
        ("flaw", 0.5, "length of the flaw [m]"),
        ("angle", 0.0, "inclination of the flaw [degrees]"),
        ("path", 0.0, "edges ahead of the tips; of a disc, along the loaded diameter from the centre [m]"),
        ("fine", 0.05, "distance from the flaw up to which elements are fine [m]"),
        ("coarse", 0.2, "element size far from the flaw [m]"),
    ):
        parser.add_argument(f"--{name}", type=float, default=default, help=meaning)
    parser.add_argument("--seed", type=int, default=0, help="another mesh; 0: no random nodes")
    parser.add_argument("--out", default="scene.msh", help="mesh file to write")
    make_mesh(parser.parse_args())


if __name__ == "__main__":
    main()
