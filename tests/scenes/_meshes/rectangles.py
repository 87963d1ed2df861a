#!/usr/bin/env python3
"""Mesh of rectangles, for scenes whose answer is known.

    python3 rectangles.py --out scene.msh [--turn DEGREES] [--joint] NAME,X0,Y0,WIDTH,HEIGHT,NX,NY[,free] ...

Each rectangle becomes a physical surface NAME with the physical curves NAME_bottom, NAME_right, NAME_top, NAME_left.
NX and NY are the numbers of edges along its sides; inside it is a grid of alternating triangles or, with `free`, an
unstructured mesh. Rectangles share nothing: two that touch are two bodies with nodes of their own. With --joint, a side
that two rectangles have in common is one curve of the physical group `joint` (and of no other), to be split by the
program; between rectangles of the same name it is no curve at all: they are one body. --turn rotates everything
anticlockwise about the origin.
"""

import argparse
import math

import gmsh

SIDES = ("bottom", "right", "top", "left")


class Outline:
    """Points and lines of the model; with sharing, those in the same place are one."""

    def __init__(self, turn, share):
        self.cosine, self.sine = math.cos(turn), math.sin(turn)
        self.share = share
        self.points = {}
        self.lines = {}

    def point(self, body, x, y):
        key = (None if self.share else body, round(x, 9), round(y, 9))
        if key not in self.points:
            place = (self.cosine * x - self.sine * y, self.sine * x + self.cosine * y, 0.0)
            self.points[key] = gmsh.model.geo.addPoint(*place)
        return self.points[key]

    def line(self, start, end, edges):
        """The line between two points, negative when it was made the other way round; and whether it was there."""
        if (end, start) in self.lines:
            return -self.lines[end, start], True
        self.lines[start, end] = gmsh.model.geo.addLine(start, end)
        gmsh.model.geo.mesh.setTransfiniteCurve(self.lines[start, end], edges + 1)
        return self.lines[start, end], False


def make_mesh(rectangles, path, turn=0.0, joint=False):
    """Write the mesh; rectangles: (name, x0, y0, width, height, nx, ny, free)."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    outline = Outline(math.radians(turn), joint)
    curves, surfaces, curves_of, shared, inner = {}, {}, {}, [], []
    for body, (name, x0, y0, width, height, nx, ny, free) in enumerate(rectangles):
        corners = [(x0, y0), (x0 + width, y0), (x0 + width, y0 + height), (x0, y0 + height)]
        points = [outline.point(body, *corner) for corner in corners]
        loop = []
        for side in range(4):
            tag, known = outline.line(points[side], points[(side + 1) % 4], nx if side % 2 == 0 else ny)
            loop.append(tag)
            if known and curves_of.get(-tag) != name:
                shared.append(-tag)
            elif known:
                inner.append(-tag)
            curves_of[abs(tag)] = name
            curves.setdefault(f"{name}_{SIDES[side]}", []).append(abs(tag))
        surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(loop)])
        if not free:
            gmsh.model.geo.mesh.setTransfiniteSurface(surface, "AlternateRight")
        surfaces.setdefault(name, []).append(surface)
    gmsh.model.geo.synchronize()
    for name, tags in surfaces.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), name)
    curves = {name: [tag for tag in tags if tag not in shared + inner] for name, tags in curves.items()}
    curves["joint"] = shared
    for name, tags in curves.items():
        if tags:
            gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, tags), name)
    for option in ("FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.mesh.generate(2)
    gmsh.write(path)
    gmsh.finalize()


def read_rectangle(text):
    words = text.split(",")
    if len(words) not in (7, 8) or words[7:] not in ([], ["free"]):
        raise argparse.ArgumentTypeError("NAME,X0,Y0,WIDTH,HEIGHT,NX,NY[,free]")
    numbers = [float(word) for word in words[1:5]]
    return (words[0], *numbers, int(words[5]), int(words[6]), len(words) == 8)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "rectangles", nargs="+", type=read_rectangle, metavar="NAME,X0,Y0,WIDTH,HEIGHT,NX,NY[,free]"
    )
    parser.add_argument("--turn", type=float, default=0.0, help="rotation about the origin in degrees")
    parser.add_argument("--joint", action="store_true", help="sides in common become the curve `joint`")
    parser.add_argument("--out", default="scene.msh", help="mesh file to write")
    arguments = parser.parse_args()
    make_mesh(arguments.rectangles, arguments.out, arguments.turn, arguments.joint)


if __name__ == "__main__":
    main()
