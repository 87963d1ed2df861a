#!/usr/bin/env python3
"""A square of rock with one straight inclined crack in the middle, elements growing with the distance from it.

python3 make_mesh.py --half-length 0.1 --strike 45 --side 4 --size 0.002 --out crack.msh
"""

import argparse
import math

import gmsh

GRADING = 0.15  # growth of the element size per unit distance
COARSE = 20  # largest element over the side of the square is one over this


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--half-length", type=float, required=True, help="half-length of the crack (m)")
    parser.add_argument("--strike", type=float, required=True, help="angle of the crack from x (degrees)")
    parser.add_argument("--side", type=float, required=True, help="side of the square (m)")
    parser.add_argument("--size", type=float, required=True, help="element size at the crack (m)")
    parser.add_argument("--out", required=True, help="mesh file")
    given = parser.parse_args()
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geo = gmsh.model.geo
    half = given.side / 2
    corners = [
        geo.addPoint(x, y, 0.0) for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))
    ]
    sides = [geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(sides)])
    along = [given.half_length * f(math.radians(given.strike)) for f in (math.cos, math.sin)]
    crack = geo.addLine(geo.addPoint(-along[0], -along[1], 0.0), geo.addPoint(*along, 0.0))
    geo.synchronize()
    gmsh.model.mesh.embed(1, [crack], 2, surface)
    gmsh.model.mesh.setTransfiniteCurve(crack, round(2 * given.half_length / given.size) + 1)
    for dimension, tags, name in (
        (2, [surface], "rock"),
        (1, [crack], "crack"),
        (1, sides[0:1], "bottom"),
        (1, sides[1:2], "right"),
        (1, sides[2:3], "top"),
        (1, sides[3:4], "left"),
        (0, corners[0:1], "corner_sw"),
        (0, corners[1:2], "corner_se"),
    ):
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)
    size = f"{given.size} + {GRADING}*max(0, sqrt(x*x + y*y) - {given.half_length})"
    field = gmsh.model.mesh.field.add("MathEval")
    gmsh.model.mesh.field.setString(
        field, "F", f"min({given.side / COARSE}, {size})".replace("min", "Min").replace("max", "Max")
    )
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.mesh.generate(2)
    gmsh.write(given.out)
    gmsh.finalize()


if __name__ == "__main__":
    main()
