"""What is right and how good a triangle mesh of a fracture network is: checks of the mesh file, and its worst elements."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

EXACT = 1e-9  # relative: lengths and areas of the mesh against those of the geometry
LEAST_AREA = 1e-9  # of the longest edge squared: triangles with less have none (the program refuses them)


@dataclass
class MeshData:
    """A mesh as read from its file."""

    xy: np.ndarray  # nodes (nodes, 2) [m]
    triangle: np.ndarray  # corners, numbered from 0 (triangles, 3)
    line: dict  # nodes of the lines of each physical curve (lines, 2)
    surface: dict = field(default_factory=dict)  # numbers of the triangles of each physical surface


def triangle_edges(triangle):
    """Edges of triangles, each once with its lower node first, and how many triangles have it."""
    pairs = np.sort(triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(pairs, axis=0, return_counts=True)


def line_length(mesh, lines):
    """Length of lines together [m]."""
    return float(np.hypot(*(mesh.xy[lines[:, 1]] - mesh.xy[lines[:, 0]]).T).sum())


def check_mesh(mesh, window, fracture_length, sides, holes=(), surfaces=None):
    """All that is wrong with a mesh, one text each; none when the program will take it.

    Triangles with area that turn one way, whose areas add up to the window's and whose free edges are the window's
    sides, neither overlap nor leave gaps nor have hanging nodes. holes: with name, area [m2] and perimeter [m]; their
    curves are free edges too. surfaces: area of each physical surface [m2].
    """
    sides = [*sides, *(hole.name for hole in holes)]
    wrong = []
    if len(mesh.triangle) == 0:
        return ["there are no triangles"]
    edges, shared = triangle_edges(mesh.triangle)
    area, longest = doubled_areas(mesh) / 2, side_lengths(mesh).max(axis=1)
    flat = int((area <= LEAST_AREA * longest**2).sum())
    if flat:
        wrong.append(f"{flat} triangles have no area or are turned over")
    width, height = window[2] - window[0], window[3] - window[1]
    whole = width * height - sum(hole.area for hole in holes)
    if abs(area.sum() - whole) > EXACT * whole:
        wrong.append(f"the triangles have an area of {area.sum():.12g} m2, the window {whole:.12g} m2")
    for name, expected in (surfaces or {}).items():
        found = area[mesh.surface.get(name, np.zeros(0, dtype=int))].sum()
        if abs(found - expected) > EXACT * whole:
            wrong.append(f"the triangles of '{name}' have an area of {found:.12g} m2, not {expected:.12g} m2")
    if (shared > 2).any():
        wrong.append(f"{int((shared > 2).sum())} edges have more than two triangles")
    unused = len(mesh.xy) - len(np.unique(mesh.triangle))
    if unused:
        wrong.append(f"{unused} nodes are of no triangle")
    double = len(cKDTree(mesh.xy).query_pairs(EXACT * max(width, height)))
    if double:
        wrong.append(f"{double} pairs of nodes are at one place")
    number = {(int(a), int(b)): int(n) for (a, b), n in zip(edges, shared, strict=True)}
    group_of = {}
    for name, lines in mesh.line.items():
        for a, b in np.sort(lines, axis=1).tolist():
            expected = 1 if name in sides else 2
            if number.get((a, b), 0) != expected:
                wrong.append(
                    f"a line of '{name}' at ({mesh.xy[a, 0]:.6g}, {mesh.xy[a, 1]:.6g}) is an edge of "
                    f"{number.get((a, b), 0)} triangles, {expected} expected"
                )
            if (a, b) in group_of:
                wrong.append(f"a line is in '{group_of[a, b]}' and again in '{name}'")
            group_of[a, b] = name
    free = int((shared == 1).sum())
    on_sides = sum(len(mesh.line.get(name, [])) for name in sides)
    if free != on_sides:
        wrong.append(f"{free} edges are free, {on_sides} are on the sides of the window")
    perimeter = sum(line_length(mesh, mesh.line[name]) for name in sides if name in mesh.line)
    around = 2 * (width + height) + sum(hole.perimeter for hole in holes)
    if abs(perimeter - around) > EXACT * perimeter:
        wrong.append(f"the sides are {perimeter:.12g} m long, those of the window {around:.12g} m")
    meshed = sum(line_length(mesh, lines) for name, lines in mesh.line.items() if name not in sides)
    if abs(meshed - fracture_length) > EXACT * fracture_length:
        wrong.append(
            f"fractures are {meshed:.12g} m long in the mesh, {fracture_length:.12g} m in the cleaned traces"
        )
    return wrong


def doubled_areas(mesh):
    """Twice the area of each triangle, negative when it runs clockwise [m2]."""
    a, b, c = (mesh.xy[mesh.triangle[:, k]] for k in range(3))
    r, s = b - a, c - a
    return r[:, 0] * s[:, 1] - r[:, 1] * s[:, 0]


def side_lengths(mesh):
    """Lengths of the sides of each triangle, the side opposite to each corner (triangles, 3) [m]."""
    corner = mesh.xy[mesh.triangle]
    return np.stack(
        [np.hypot(*(corner[:, (k + 1) % 3] - corner[:, (k + 2) % 3]).T) for k in range(3)], axis=1
    )


@dataclass
class Quality:
    """Measures of each triangle."""

    angle: np.ndarray  # least angle [degrees]
    ratio: np.ndarray  # twice the radius of the inscribed over that of the circumscribed circle
    height: np.ndarray  # least height [m]; the stable step of an explicit run goes with it
    edge: np.ndarray  # shortest side [m]
    centre: np.ndarray  # (triangles, 2) [m]

    @classmethod
    def of(cls, mesh):
        """Measure a mesh."""
        side = side_lengths(mesh)
        doubled = np.abs(doubled_areas(mesh))
        short, middle, long = np.sort(side, axis=1).T
        # Between the longer sides b, c: b c sin = twice the area, b c cos = (b^2 + c^2 - a^2)/2
        angle = np.degrees(np.arctan2(2 * doubled, middle**2 + long**2 - short**2))
        perimeter = side.sum(axis=1)
        # Radii: inscribed 2 A / perimeter, circumscribed a b c / (4 A)
        ratio = 4 * doubled**2 / (perimeter * side.prod(axis=1))
        return cls(angle, ratio, doubled / long, short, mesh.xy[mesh.triangle].mean(axis=1))

    def text(self, worst):
        """The report as lines of text, with the worst elements of two kinds."""
        lines = [
            f"triangles            {len(self.angle)}",
            f"least angle          {self.angle.min():.2f} degrees"
            f" ({(self.angle < 10).sum()} below 10, {(self.angle < 20).sum()} below 20)",
            f"least radius ratio   {self.ratio.min():.4f} (mean {self.ratio.mean():.3f})",
            f"shortest edge        {1e3 * self.edge.min():.4g} mm",
            f"least height         {1e3 * self.height.min():.4g} mm"
            f" (1 % have less than {1e3 * np.quantile(self.height, 0.01):.4g} mm,"
            f" half less than {1e3 * np.median(self.height):.4g} mm)",
        ]
        for title, measure in (
            ("least angle", self.angle),
            ("least height: they limit the stable step", self.height),
        ):
            lines.append(f"worst elements, {title}:")
            lines.append("           x           y     angle    height   shortest edge   ratio")
            for k in np.argsort(measure, kind="stable")[:worst]:
                lines.append(
                    f"  {self.centre[k, 0]:10.5f}  {self.centre[k, 1]:10.5f}  {self.angle[k]:6.2f}°"
                    f"  {1e3 * self.height[k]:6.3f} mm   {1e3 * self.edge[k]:9.3f} mm  {self.ratio[k]:6.4f}"
                )
        return "\n".join(lines)
