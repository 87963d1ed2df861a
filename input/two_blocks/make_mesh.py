#!/usr/bin/env python3
"""Two blocks, one on the other, with a fracture between them: how to give a gmsh mesh the groups that a deck names.

    bin/python3 make_mesh.py --size 0.01 --out two_blocks.msh

manual/tutorial_4.md goes through it. Lengths are in metres.
"""

import argparse

import gmsh

WIDTH, HEIGHT = 0.2, 0.1  # of each block


def blocks():
    """The two blocks as surfaces that share the curve between them; (lower, upper, fracture)."""
    occ = gmsh.model.occ
    lower = occ.addRectangle(0.0, 0.0, 0.0, WIDTH, HEIGHT)
    upper = occ.addRectangle(0.0, HEIGHT, 0.0, WIDTH, HEIGHT)
    left, right = occ.addPoint(0.0, HEIGHT, 0.0), occ.addPoint(WIDTH, HEIGHT, 0.0)
    line = occ.addLine(left, right)
    # Whatever lies on each other becomes one: surfaces that touch share their curves, curves cut each other
    _, pieces = occ.fragment([(2, lower), (2, upper)], [(1, line)])
    occ.synchronize()
    (lower, upper), fracture = (tags_of(pieces[k]) for k in (0, 1)), tags_of(pieces[2])
    return lower, upper, fracture


def tags_of(entities):
    """Numbers of entities (dimension, number)."""
    return [tag for _, tag in entities]


def curves_at(box):
    """Curves that lie in a box (x0, y0, x1, y1)."""
    x0, y0, x1, y1 = box
    slack = 1e-6
    found = gmsh.model.getEntitiesInBoundingBox(
        x0 - slack, y0 - slack, -slack, x1 + slack, y1 + slack, slack, dim=1
    )
    return tags_of(found)


def name_group(dimension, tags, name):
    """Make a physical group. (Debian's gmsh 4.8 has no `name` argument of addPhysicalGroup yet.)"""
    group = gmsh.model.addPhysicalGroup(dimension, tags)
    gmsh.model.setPhysicalName(dimension, group, name)


def make_mesh(size, path):
    """Mesh the blocks and write the file."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        lower, upper, fracture = blocks()
        name_group(2, lower + upper, "rock")
        name_group(1, fracture, "fracture")
        name_group(1, curves_at((0, 0, WIDTH, 0)), "bottom")
        name_group(1, curves_at((0, 2 * HEIGHT, WIDTH, 2 * HEIGHT)), "top")
        name_group(1, curves_at((0, 0, 0, HEIGHT)) + curves_at((WIDTH, 0, WIDTH, HEIGHT)), "lower_sides")
        name_group(1, curves_at((0, HEIGHT, 0, 2 * HEIGHT)), "upper_left")
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", type=float, default=0.01, help="element size (m; default 0.01)")
    parser.add_argument("--out", default="two_blocks.msh", help="mesh file to write (default two_blocks.msh)")
    arguments = parser.parse_args()
    make_mesh(arguments.size, arguments.out)
    print(f"{arguments.out}: made")


if __name__ == "__main__":
    main()
