#!/usr/bin/env python3
"""Mesh of rock beside a well with a notch, and a line ahead of it along which a crack may run.

    bin/python3 make_mesh.py --out injection.msh

The well is a point of the left side, about which the other half of the crack mirrors this one. Notch and line are physical curves
'notch' and 'path', the well the physical point 'well', the lower corner of the left side 'foot'. Lengths are in metres.
"""

import argparse
from pathlib import Path

import gmsh


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--out", type=Path, default=Path("injection.msh"))
    arguments.add_argument("--notch", type=float, default=0.1, help="half-length of the notch")
    arguments.add_argument("--path", type=float, default=1.5, help="how far a crack may run from the well")
    arguments.add_argument("--extent", type=float, default=15.0, help="of the rock, from the well")
    arguments.add_argument("--size", type=float, default=0.05, help="of the elements along notch and line")
    chosen = arguments.parse_args()

    gmsh.initialize(["-v", "2"])
    add, far = gmsh.model.geo, chosen.extent
    coarse = far / 6
    foot, right_foot = add.addPoint(0, -far, 0, coarse), add.addPoint(far, -far, 0, coarse)
    right_head, head = add.addPoint(far, far, 0, coarse), add.addPoint(0, far, 0, coarse)
    well = add.addPoint(0, 0, 0, chosen.size)
    tip, end = add.addPoint(chosen.notch, 0, 0, chosen.size), add.addPoint(chosen.path, 0, 0, chosen.size)
    bottom, right = add.addLine(foot, right_foot), add.addLine(right_foot, right_head)
    top = add.addLine(right_head, head)
    upper, lower = add.addLine(head, well), add.addLine(well, foot)
    notch, path = add.addLine(well, tip), add.addLine(tip, end)
    for line, length in ((notch, chosen.notch), (path, chosen.path - chosen.notch)):
        add.mesh.setTransfiniteCurve(line, round(length / chosen.size) + 1)
    surface = add.addPlaneSurface([add.addCurveLoop([bottom, right, top, upper, lower])])
    add.synchronize()
    gmsh.model.mesh.embed(1, [notch, path], 2, surface)
    for dimension, name, parts in (
        (1, "bottom", [bottom]),
        (1, "right", [right]),
        (1, "top", [top]),
        (1, "left", [upper, lower]),
        (1, "notch", [notch]),
        (1, "path", [path]),
        (0, "well", [well]),
        (0, "foot", [foot]),
        (2, "rock", [surface]),
    ):
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, parts), name)
    # Elements grow evenly away from the line
    growth = gmsh.model.mesh.field.add("MathEval")
    beyond = f"(Abs(x - {chosen.path}) + (x - {chosen.path})) / 2"
    gmsh.model.mesh.field.setString(growth, "F", f"{chosen.size} + 0.15 * Sqrt(({beyond})^2 + y^2)")
    gmsh.model.mesh.field.setAsBackgroundMesh(growth)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(chosen.out))
    gmsh.finalize()


if __name__ == "__main__":
    main()
