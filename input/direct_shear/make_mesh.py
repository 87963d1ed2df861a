#!/usr/bin/env python3
"""Mesh of the direct shear box: a rough joint between two blocks, each in a steel half-box.

The upper block (the joint's length, 10 mm high) lies on a longer lower block. The steel encloses both
blocks from a small gap above and below the joint, so that the box drives the joint from close by.
Sizes are in metres. Elements have the given size along the joint and grow away from it.

    python3 make_mesh.py --length 0.06 --size 0.001 --out shear_6cm.msh
"""

import argparse
import sys

import gmsh

BLOCK_HEIGHT = 0.010  # of each block: the steel is near, so the normal stress on the joint stays even
STEEL = 0.012  # wall thickness of the half-boxes
GAP = 0.002  # between the steel and the joint
OVERHANG = 0.012  # of the lower block beyond the joint, on either side
COARSE = 0.006  # element size far from the joint
GROWTH = 0.25  # growth of the element size per unit distance from the joint


def rectangle(x0, y0, x1, y1):
    """Add a rectangle and return its surface."""
    return gmsh.model.occ.addRectangle(x0, y0, 0.0, x1 - x0, y1 - y0)


def build_geometry(length):
    """Blocks and half-boxes as conforming surfaces; returns the surfaces of each group."""
    upper = [rectangle(0.0, 0.0, length, BLOCK_HEIGHT)]
    lower = [rectangle(-OVERHANG, -BLOCK_HEIGHT, length + OVERHANG, 0.0)]
    upper_box = [
        rectangle(-STEEL, GAP, 0.0, BLOCK_HEIGHT + STEEL),
        rectangle(length, GAP, length + STEEL, BLOCK_HEIGHT + STEEL),
        rectangle(0.0, BLOCK_HEIGHT, length, BLOCK_HEIGHT + STEEL),
    ]
    left, right = -OVERHANG, length + OVERHANG
    lower_box = [
        rectangle(left - STEEL, -BLOCK_HEIGHT - STEEL, left, -GAP),
        rectangle(right, -BLOCK_HEIGHT - STEEL, right + STEEL, -GAP),
        rectangle(left, -BLOCK_HEIGHT - STEEL, right, -BLOCK_HEIGHT),
    ]
    names = {"upper_block": upper, "lower_block": lower, "upper_box": upper_box, "lower_box": lower_box}
    pieces = [(2, s) for group in names.values() for s in group]
    _, parents = gmsh.model.occ.fragment(pieces, [])
    gmsh.model.occ.synchronize()
    new_surfaces = dict(zip(pieces, parents, strict=True))
    return {name: [tag for s in group for _, tag in new_surfaces[2, s]] for name, group in names.items()}


def curves_at(axis, value):
    """Curves of the model that lie on the line x = value (axis 0) or y = value (axis 1)."""
    found = []
    for _, tag in gmsh.model.getEntities(1):
        box = gmsh.model.getBoundingBox(1, tag)
        if abs(box[axis] - value) < 1e-6 and abs(box[axis + 3] - value) < 1e-6:
            found.append(tag)
    return found


def make_mesh(length, size, path):
    """Write the mesh of the box for a joint of the given length and element size along it [m]."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    surfaces = build_geometry(length)
    for name, tags in surfaces.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), name)

    def inside(tag):
        box = gmsh.model.getBoundingBox(1, tag)
        return box[0] > -1e-6 and box[3] < length + 1e-6

    joint = [tag for tag in curves_at(1, 0.0) if inside(tag)]
    curves = {
        "joint": joint,
        "top": curves_at(1, BLOCK_HEIGHT + STEEL),
        "bottom": curves_at(1, -BLOCK_HEIGHT - STEEL),
        "right": curves_at(0, length + OVERHANG + STEEL),
    }
    for name, tags in curves.items():
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, tags), name)

    # Small along the joint and where the upper block will slide on the lower one
    field = gmsh.model.mesh.field
    graded = field.add("MathEval")
    field.setString(graded, "F", f"Min({COARSE}, {size} + {GROWTH}*Abs(y))")
    field.setAsBackgroundMesh(graded)
    for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.optimize("Laplace2D")
    gmsh.write(path)
    triangles = sum(len(t) for t in gmsh.model.mesh.getElements(2)[1])
    gmsh.finalize()
    return triangles


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--length", type=float, default=0.06, help="joint length in m (default 0.06)")
    parser.add_argument(
        "--size", type=float, default=0.001, help="element size along the joint in m (default 0.001)"
    )
    parser.add_argument("--out", default="shear_6cm.msh", help="mesh file to write")
    arguments = parser.parse_args()
    if not 0.0 < arguments.size <= arguments.length / 4:
        sys.exit("error: --size must be positive and at most a quarter of --length")
    triangles = make_mesh(arguments.length, arguments.size, arguments.out)
    print(f"{arguments.out}: {triangles} triangles")


if __name__ == "__main__":
    main()
