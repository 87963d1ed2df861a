#!/usr/bin/env python3
"""Mesh of a block whose right side leans, for waves that meet a side at an angle.

    python3 tilted.py --out scene.msh --angle 45 [--length 1] [--height 1] [--size 0.05]

The block has its corners at (0, 0), (length, 0), (length + height tan(angle), height) and (0, height): a plane wave along x
meets the right side at that angle. Physical surface rock, physical curves bottom, right, top, left.
"""

import argparse
import math

import gmsh

SIDES = ("bottom", "right", "top", "left")


def make_mesh(path, angle, length=1.0, height=1.0, size=0.05):
    """Write the mesh; the angle in degrees."""
    places = [
        (0.0, 0.0),
        (length, 0.0),
        (length + height * math.tan(math.radians(angle)), height),
        (0.0, height),
    ]
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    points = [gmsh.model.geo.addPoint(x, y, 0.0, size) for x, y in places]
    lines = [gmsh.model.geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
    gmsh.model.geo.synchronize()
    groups = [(1, [line], name) for line, name in zip(lines, SIDES, strict=True)] + [(2, [surface], "rock")]
    for dimension, tags, name in groups:
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.finalize()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", required=True, help="mesh to write")
    parser.add_argument("--angle", type=float, default=0.0, help="of the right side to y [degrees]")
    parser.add_argument("--length", type=float, default=1.0, help="of the bottom [m]")
    parser.add_argument("--height", type=float, default=1.0, help="[m]")
    parser.add_argument("--size", type=float, default=0.05, help="of the elements [m]")
    given = vars(parser.parse_args())
    make_mesh(given.pop("out"), given.pop("angle"), **given)
