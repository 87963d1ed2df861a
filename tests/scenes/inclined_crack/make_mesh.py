#!/usr/bin/env python3
"""A square of rock with one straight inclined crack in the middle, elements finest at its tips.

python3 make_mesh.py --size 0.004 --out crack.msh

SIZE is that of the elements in the middle of the crack. Towards a tip they shrink with the root of the distance, to
2 SIZE^2/HALF_LENGTH at the tip; away from the crack they grow. The singular stress at the tips then costs no more
accuracy than the middle does: the error of the slip falls with SIZE^2. With elements of one size it falls with SIZE.
"""

import argparse
import math

import gmsh

GRADING = 2.0  # growth of the element size per unit distance from the crack, times size over half-length
COARSEST = 10  # largest element over the side of the square is one over this
TIP = 4.0  # the root starts this many SIZE^2/HALF_LENGTH behind the tip


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--half-length", type=float, default=0.1, help="half-length of the crack (m; default 0.1)"
    )
    parser.add_argument(
        "--strike", type=float, default=45.0, help="angle of the crack from x (degrees; default 45)"
    )
    parser.add_argument("--side", type=float, default=16.0, help="side of the square (m; default 16)")
    parser.add_argument("--size", type=float, required=True, help="element size (m)")
    parser.add_argument(
        "--uniform", action="store_true", help="elements of one size along the crack, its tips included"
    )
    parser.add_argument("--out", required=True, help="mesh file")
    make_mesh(parser.parse_args())


def size_field(given, tip):
    """Element size as gmsh wants it; one tip is at (x, y), the other opposite."""
    b, h = given.half_length, given.size
    near = f"{h}"
    if not given.uniform:
        to_tip = (
            f"sqrt((x-{s * tip[0]})*(x-{s * tip[0]}) + (y-{s * tip[1]})*(y-{s * tip[1]}))" for s in (1, -1)
        )
        near = f"{h}*sqrt(Min(1, (Min({', '.join(to_tip)}) + {TIP * h * h / b})/{b}))"
    far = f"{GRADING * h / b}*Max(0, sqrt(x*x + y*y) - {b})"
    return f"Min({given.side / COARSEST}, {near} + {far})".replace("--", "+")


def make_mesh(given):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geo = gmsh.model.geo
    half = given.side / 2
    corners = [
        geo.addPoint(x, y, 0.0) for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))
    ]
    sides = [geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(sides)])
    tip = [given.half_length * f(math.radians(given.strike)) for f in (math.cos, math.sin)]
    crack = geo.addLine(geo.addPoint(-tip[0], -tip[1], 0.0), geo.addPoint(*tip, 0.0))
    geo.synchronize()
    gmsh.model.mesh.embed(1, [crack], 2, surface)
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
    field = gmsh.model.mesh.field.add("MathEval")
    gmsh.model.mesh.field.setString(field, "F", size_field(given, tip))
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
