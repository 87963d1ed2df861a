#!/usr/bin/env python3
"""Mesh of a disc with a round core, in rings and sectors, for a tunnel whose answer is known.

    python3 tunnel.py --out tunnel.msh [--sectors 48] [--rings 24] [--outer 20] [--quarter] [--turn DEGREES] [--joint] [--hole]

The core, of radius 1, is the physical surface `core`, its inner half `heading`, the rest `rock`; between core and rock lies the
physical curve `wall`, around all the curve `outer`. Rings grow outwards with their radius. --quarter meshes the first quadrant,
with the curves `below` (y = 0) and `left` (x = 0). --joint lays the physical curve `joint` through the whole disc along the x axis.
--hole leaves out core and heading. --turn rotates everything anticlockwise about the origin.
"""

import argparse

import numpy as np

CORE_RINGS = 4  # rings of the core for 24 of the rock


def radii(rings, outer):
    """Radii of the circles of nodes: the core's, then the rock's from 1 to the outer one."""
    core = np.linspace(0.0, 1.0, max(2, round(CORE_RINGS * rings / 24)) + 1)[1:-1]
    return np.concatenate([core, outer ** np.linspace(0.0, 1.0, rings + 1)])


def make_mesh(sectors, rings, outer, quarter, joint, hole, turn):
    """Nodes (n, 2), triangles by surface, lines by curve."""
    radius = radii(rings, outer)
    wall = int(np.flatnonzero(radius >= 1.0 - 1e-12)[0])
    columns = sectors // 4 + 1 if quarter else sectors
    angle = 2.0 * np.pi * np.arange(columns) / sectors
    nodes = [(0.0, 0.0)] + [(r * np.cos(a), r * np.sin(a)) for r in radius for a in angle]

    def at(circle, column):
        """Node of a circle; -1 is the centre."""
        return 0 if circle < 0 else 1 + circle * columns + column % columns

    surfaces, curves = {"heading": [], "core": [], "rock": []}, {"wall": [], "outer": []}
    for column in range(columns - 1 if quarter else columns):
        for circle in range(-1, len(radius) - 1):
            a, b = at(circle, column), at(circle + 1, column)
            c, d = at(circle + 1, column + 1), at(circle, column + 1)
            name = "rock" if circle >= wall else "core" if 2 * circle + 2 > wall else "heading"
            if circle < 0:
                surfaces[name].append((a, b, c))
            else:  # diagonals alternate, so that no direction is stiffer
                pairs = [(a, b, c), (a, c, d)] if (circle + column) % 2 else [(a, b, d), (b, c, d)]
                surfaces[name] += pairs
        curves["wall"].append((at(wall, column), at(wall, column + 1)))
        curves["outer"].append((at(len(radius) - 1, column), at(len(radius) - 1, column + 1)))
    if quarter:
        for name, column in (("below", 0), ("left", columns - 1)):
            curves[name] = [(at(circle - 1, column), at(circle, column)) for circle in range(len(radius))]
    if joint:
        across = [at(circle, columns // 2) for circle in range(len(radius) - 1, -1, -1)] + [0]
        across += [at(circle, 0) for circle in range(len(radius))]
        curves["joint"] = list(zip(across[:-1], across[1:], strict=True))
    if hole:
        del surfaces["core"], surfaces["heading"]
        curves = {
            name: [line for line in lines if all(node > wall * columns for node in line)]
            for name, lines in curves.items()
        }
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return np.array(nodes) @ np.array([[cosine, sine], [-sine, cosine]]), surfaces, curves


def write_mesh(path, nodes, surfaces, curves):
    """The file, in format 2.2 of gmsh."""
    groups = [(1, name, cells) for name, cells in curves.items()]
    groups += [(2, name, cells) for name, cells in surfaces.items()]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    lines += [f'{dimension} {tag} "{name}"' for tag, (dimension, name, _) in enumerate(groups, start=1)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += [f"{number} {x:.17g} {y:.17g} 0" for number, (x, y) in enumerate(nodes, start=1)]
    cells = [(d, tag, cell) for tag, (d, _, members) in enumerate(groups, start=1) for cell in members]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [
        f"{number} {dimension} 2 {tag} {tag} " + " ".join(str(node + 1) for node in cell)
        for number, (dimension, tag, cell) in enumerate(cells, start=1)
    ]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join([*lines, "$EndElements", ""]))


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--out", required=True)
    arguments.add_argument("--sectors", type=int, default=48, help="around the whole circle; a multiple of 4")
    arguments.add_argument("--rings", type=int, default=24, help="of the rock")
    arguments.add_argument("--outer", type=float, default=20.0, help="radius of the disc [m]")
    arguments.add_argument("--quarter", action="store_true")
    arguments.add_argument("--joint", action="store_true")
    arguments.add_argument("--hole", action="store_true")
    arguments.add_argument("--turn", type=float, default=0.0, help="degrees")
    chosen = arguments.parse_args()
    if chosen.sectors % 4 or (chosen.quarter and chosen.joint):
        arguments.error("--sectors must be a multiple of 4, and a quarter has no joint")
    write_mesh(
        chosen.out,
        *make_mesh(
            chosen.sectors,
            chosen.rings,
            chosen.outer,
            chosen.quarter,
            chosen.joint,
            chosen.hole,
            chosen.turn,
        ),
    )


if __name__ == "__main__":
    main()
