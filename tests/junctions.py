#!/usr/bin/env python3
"""Junctions of fractures: the answer must not know how the mesh was drawn, and corners must not pass through each other.

    python3 tests/junctions.py --kind X --angle 59 --size 0.05 --solver implicit --law coulomb
    python3 tests/junctions.py --kind T --angle 45 --slip 3 --variants mirrored turned_90
    python3 tests/junctions.py --series --out junctions.csv [--kinds T X --solvers implicit --laws jcm ...]
    python3 tests/junctions.py --jump --out jump.csv
    python3 tests/junctions.py --refine --out refine.csv
    python3 tests/junctions.py --network two_sets.csv --size 0.03

A square of rock holds a junction of fractures in its middle. Small slip: the arms end in the rock, the square is loaded by a
far-field stress. Large slip (--slip, in elements): the arms cut the square into blocks, those above the through fracture
are pressed down and driven along it.

The same scene is run as drawn and as variants of the mesh: mirrored (x -> -x), turned by 90 and 180 degrees, renumbered.
Coordinates change sign and place only, so that a variant is the same scene to the last bit; loads turn with it. Joint
elements are matched by their place, and their values are brought back to the scene as drawn: slip and shear stress keep
their sign when the scene is turned (a wall turned by half a turn is the other wall), and change it in a mirror.

--series runs the whole matrix of kinds, angles, solvers and laws, small and large slip, and writes a row for each variant.
--jump takes one mesh of a junction at 60 degrees and turns its arms from 59 to 61 in steps of 0.2: what changes in a step beyond
the mean of the steps on either side is a jump. --refine presses the plate with crossing faults of `x_crossing` at elements of
50 to 6.25 mm and loads of 0.15 to 30 MPa, in wall contact and in potential contact. --network runs a map of traces through
phases I and II-B in every drawing.

What is compared is the mean of slip, aperture and normal stress over each block edge: the difference over the largest of
the scene (`scene`), which the bar of 1e-3 is for, and over the edge's own (`edge`), which is large where an edge hardly slips
and says little there. Rock in rock is measured from the deformed triangles: the deepest place of the overlap of the blocks
(mm) at ten times of the run, against the closure of the joints plus 1 % of the slip then.
"""

import argparse
import csv
import itertools
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import gmsh
import numpy as np
from scipy.spatial import cKDTree
from shapely.geometry import Point, Polygon
from shapely.ops import polygonize, unary_union

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postproc"))
from femdem.network.make_mesh import set_option
from femdem.network.mesh_quality import triangle_edges
from femdem.places import environment, module
from femdem.results import Results

TOP = Path(__file__).resolve().parent.parent
KINDS = ("T", "X", "Y", "star", "kink")
ANGLES = (15, 30, 45, 59, 61, 75, 90)
SOLVERS = ("implicit", "relaxation", "explicit")
LAWS = {
    "jcm": "law = 'jcm', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31, a0_mm = 0.194",
    "jcm_mean": "law = 'jcm_mean', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31, a0_mm = 0.194",
    "coulomb": "law = 'coulomb', friction_angle = 31, kn_mpa_mm = 100, ks_mpa_mm = 30, a0_mm = 0.194",
}
QUANTITIES = {"slip": "mm", "aperture": "mm", "normal_stress": "MPa"}
# What the issue asks for: difference between variants; overlap over closure, as part of the slip
SAME, CORNER = 1e-3, 1e-2
# Slips below this part of the scene's largest are not compared edge by edge
LEAST = 1e-2
EXACT = 1e-9  # of a coordinate: variants move nodes without rounding


# --- meshes ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mesh:
    """A mesh as written to a file: triangles of one rock, named lines and points."""

    xy: np.ndarray  # (nodes, 2) m
    triangles: np.ndarray  # (triangles, 3), anticlockwise
    lines: dict  # name -> (lines, 2)
    points: dict  # name -> node

    def write(self, path):
        """As gmsh 2.2, with every digit of the coordinates."""
        names = [(0, name) for name in self.points] + [(1, name) for name in self.lines] + [(2, "rock")]
        tag = {name: k for k, (_, name) in enumerate(names, 1)}
        rows = [(15, tag[name], [node]) for name, node in self.points.items()]
        rows += [(1, tag[name], line) for name, lines in self.lines.items() for line in lines]
        rows += [(2, tag["rock"], triangle) for triangle in self.triangles]
        text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
        text += [f'{dimension} {tag[name]} "{name}"' for dimension, name in names]
        text += ["$EndPhysicalNames", "$Nodes", str(len(self.xy))]
        text += [f"{k} {x + 0.0!r} {y + 0.0!r} 0" for k, (x, y) in enumerate(self.xy.tolist(), 1)]
        text += ["$EndNodes", "$Elements", str(len(rows))]
        text += [
            f"{k} {kind} 2 {group} {group} " + " ".join(str(node + 1) for node in nodes)
            for k, (kind, group, nodes) in enumerate(rows, 1)
        ]
        Path(path).write_text("\n".join([*text, "$EndElements", ""]), encoding="utf-8")


def arms_of(kind, angle, strike=0.0):
    """Directions of the arms of a junction, anticlockwise from x, in increasing order [degrees].

    T and X: a through fracture and one or two arms at the angle to it. Y: a stem and two arms with the angle between them.
    star: an X with a fifth arm half-way in the widest sector above. kink: two arms that turn by the angle.
    """
    arms = {
        "T": (0, angle, 180),
        "X": (0, angle, 180, 180 + angle),
        "Y": (angle / 2, 180, 360 - angle / 2),
        "star": (0, angle, 90 + angle / 2, 180, 180 + angle),
        "kink": (angle, 180),
    }[kind]
    return np.sort((np.array(arms, dtype=float) + strike) % 360)


def junction_mesh(arms, size, length=0.3, sides=(1.0, 1.0), cut=False, coarse=None):
    """A rectangle about the origin with a junction of arms [degrees] there.

    length of the arms [m], one or one for each; with cut they reach the boundary instead. size at the arms; coarse at the
    boundary (not given: size). Groups: rock, frac, left, right, bottom, top, corner_sw, corner_se; with cut the sides are
    parted at the arms, and named by side and sector: left_1, left_2, ...
    """
    lengths = tuple(np.broadcast_to(length, len(arms)).tolist())
    return _junction_mesh(tuple(map(float, arms)), float(size), lengths, sides, cut, coarse)


@lru_cache(maxsize=64)
def _junction_mesh(arms, size, lengths, sides, cut, coarse):
    half = np.array(sides) / 2
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        corners = {"sw": (-1, -1), "se": (1, -1), "ne": (1, 1), "nw": (-1, 1)}
        places = {name: half * signs for name, signs in corners.items()}
        rim = [(place, geo.addPoint(*place, 0)) for place in places.values()]
        corner_point = {f"corner_{name}": rim[k][1] for k, name in enumerate(("sw", "se"))}
        centre = geo.addPoint(0, 0, 0)
        curves = []
        for arm, length in zip(np.radians(arms), lengths, strict=True):
            along = np.array([np.cos(arm), np.sin(arm)])
            end = along * (np.min(half / np.maximum(np.abs(along), 1e-12)) if cut else length)
            known = [point for place, point in rim if cut and np.hypot(*(end - place)) < EXACT]
            point = known[0] if known else geo.addPoint(*end, 0)
            curves.append(geo.addLine(centre, point))
            if cut and not known:
                rim.append((end, point))
        rim.sort(key=lambda entry: np.arctan2(entry[0][1], entry[0][0]))
        following = rim[1:] + rim[:1]
        outline = [geo.addLine(one[1], other[1]) for one, other in zip(rim, following, strict=True)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(outline)])
        geo.synchronize()
        gmsh.model.mesh.embed(1, curves, 2, surface)
        names = {}
        for line, one, other in zip(outline, rim, following, strict=True):
            middle = (one[0] + other[0]) / 2
            x, y = middle / half
            name = max({"left": -x, "right": x, "bottom": -y, "top": y}.items(), key=lambda side: side[1])[0]
            if cut:
                name += f"_{sector_of(middle[None, :], np.array(arms))[0]}"
            names.setdefault(name, []).append(line)
        names["frac"] = curves
        set_sizes(curves, size, coarse, min(lengths) / 5, half.min())
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.model.mesh.generate(2)
        groups = {1: names, 2: {"rock": [surface]}, 0: {name: [tag] for name, tag in corner_point.items()}}
        return mesh_of_gmsh(groups)
    finally:
        gmsh.finalize()


def set_sizes(curves, size, coarse, near, far):
    """Elements of a size, or of one that grows from size within `near` of the curves to coarse at `far` [m]."""
    for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", coarse or size)
    if coarse is None:
        return
    fields = gmsh.model.mesh.field
    distance, graded = fields.add("Distance"), fields.add("Threshold")
    set_option(fields.setNumbers, distance, ("EdgesList", "CurvesList"), curves)
    set_option(fields.setNumber, distance, ("NNodesByEdge", "NumPointsPerCurve", "Sampling"), 400)
    set_option(fields.setNumber, graded, ("IField", "InField"), distance)
    for option, value in (("SizeMin", size), ("SizeMax", coarse), ("DistMin", near), ("DistMax", far)):
        fields.setNumber(graded, option, value)
    fields.setAsBackgroundMesh(graded)


def mesh_of_gmsh(groups):
    """The present model of gmsh as a Mesh, without nodes that no triangle has; groups: dimension -> name -> entities."""
    tag, place, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tag.max()) + 1, dtype=int)
    number[tag.astype(int)] = np.arange(len(tag))

    def elements(dimension, entities):
        found = [gmsh.model.mesh.getElements(dimension, entity)[2][0] for entity in entities]
        return number[np.concatenate(found).astype(int)].reshape(-1, dimension + 1)

    xy = place.reshape(-1, 3)[:, :2].copy()
    triangles = elements(2, groups[2]["rock"])
    used, back = np.unique(triangles, return_inverse=True)
    new = np.full(len(xy), -1)
    new[used] = np.arange(len(used))
    mesh = Mesh(
        xy[used],
        back.reshape(-1, 3),
        {name: new[elements(1, curves)] for name, curves in groups[1].items()},
        {name: int(new[elements(0, points)[0, 0]]) for name, points in groups[0].items()},
    )
    assert (areas(mesh.xy, mesh.triangles) > 0).all()
    return mesh


def read_mesh(path):
    """A mesh file of one rock, by way of gmsh."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        groups = {0: {}, 1: {}, 2: {}}
        for dimension, tag in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dimension, tag)
            groups[dimension][name] = gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
        return mesh_of_gmsh(groups)
    finally:
        gmsh.finalize()


def areas(xy, triangles):
    """Signed areas of triangles [m2]"""
    a, b, c = xy[triangles].transpose(1, 0, 2)
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def sector_of(xy, arms):
    """Sector between two arms that each place is in, 0 between the last arm and the first (places)"""
    angle = np.degrees(np.arctan2(xy[:, 1], xy[:, 0])) % 360
    return np.searchsorted(arms, angle) % len(arms)


# --- variants -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Variant:
    """Another drawing of the same scene: places x -> matrix x, numbers shuffled with a seed."""

    name: str
    matrix: tuple = ((1, 0), (0, 1))
    seed: int | None = None

    @property
    def array(self):
        return np.array(self.matrix)

    @property
    def mirrors(self):
        return np.linalg.det(self.array) < 0


VARIANTS = {
    variant.name: variant
    for variant in (
        Variant("drawn"),
        Variant("mirrored", ((-1, 0), (0, 1))),
        Variant("turned_90", ((0, -1), (1, 0))),
        Variant("turned_180", ((-1, 0), (0, -1))),
        Variant("renumbered", seed=1),
        Variant("mirrored_turned_renumbered", ((0, 1), (1, 0)), seed=2),
    )
}


def changed_mesh(mesh, variant):
    """The mesh of a variant; node order of mirrored triangles is reversed."""
    triangles = mesh.triangles[:, ::-1] if variant.mirrors else mesh.triangles
    # Sums of a product and an exact zero: no coordinate is rounded
    mesh = replace(mesh, xy=mesh.xy @ variant.array.T.astype(float), triangles=triangles)
    return mesh if variant.seed is None else renumbered(mesh, np.random.default_rng(variant.seed))


def renumbered(mesh, random):
    """Nodes, triangles, lines and groups in another order; triangles begin with another corner, lines at another end."""
    order = random.permutation(len(mesh.xy))
    new = np.empty(len(order), dtype=int)
    new[order] = np.arange(len(order))
    triangles = new[mesh.triangles][random.permutation(len(mesh.triangles))]
    first = random.integers(3, size=len(triangles))
    triangles = triangles[np.arange(len(triangles))[:, None], (first[:, None] + np.arange(3)) % 3]
    lines = {}
    for name in random.permutation(list(mesh.lines)).tolist():
        line = new[mesh.lines[name]][random.permutation(len(mesh.lines[name]))]
        flip = random.integers(2, size=len(line)).astype(bool)
        lines[name] = np.where(flip[:, None], line[:, ::-1], line)
    points = {name: int(new[node]) for name, node in mesh.points.items()}
    return Mesh(mesh.xy[order], triangles, lines, points)


def changed_group(variables, variant):
    """A boundary's vectors and stresses in the variant: v -> R v, S -> R S R'. A component not given stays so."""
    matrix = variant.array
    changed = {
        key: value
        for key, value in variables.items()
        if key not in ("vx", "vy", "tx", "ty", "sxx", "syy", "sxy")
    }
    for x, y in (("vx", "vy"), ("tx", "ty")):
        for row, name in enumerate((x, y)):
            column = int(np.flatnonzero(matrix[row])[0])
            if (x, y)[column] in variables:
                changed[name] = matrix[row, column] * variables[(x, y)[column]] + 0.0
    if "sxx" in variables:
        shear = variables.get("sxy", 0.0)
        stress = matrix @ np.array([[variables["sxx"], shear], [shear, variables["syy"]]]) @ matrix.T
        changed |= {"sxx": stress[0, 0], "syy": stress[1, 1], "sxy": stress[0, 1] + 0.0}
    return changed


# --- scenes ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    """A mesh with its loads: what is the same for every variant."""

    mesh: Mesh
    arms: np.ndarray  # directions of the arms from the origin [degrees]
    reach: float  # of the arms [m]
    boundaries: list  # variables of each &boundary
    stages: list  # (name, cycles)
    size: float  # of elements at the arms [m]
    young: float = 30e9
    material: str = "density = 2700, poisson = 0.27"


def far_field(mesh, stress):
    """Boundaries of a far-field stress (sxx, syy, sxy) [Pa], compression positive, on all sides."""
    sxx, syy, sxy = stress
    sides = [
        {"group": side, "sxx": sxx, "syy": syy, "sxy": sxy} for side in ("left", "right", "bottom", "top")
    ]
    # The stress is in balance: two corners hold what it leaves free, and carry nothing
    assert {"corner_sw", "corner_se"} <= set(mesh.points)
    return [*sides, {"group": "corner_sw", "vx": 0.0, "vy": 0.0}, {"group": "corner_se", "vy": 0.0}]


def small_slip(kind, angle, size, cycles=4, stress=(4e6, 8e6, 0.0), strike=25.0, length=0.3):
    """Arms that end in the rock, under a far-field stress."""
    arms = arms_of(kind, angle, strike)
    mesh = junction_mesh(arms, size, length)
    return Scene(mesh, arms, length, far_field(mesh, stress), [("load", cycles)], size)


def large_slip(kind, angle, size, slip, cycles=20, pressure=5e6, side=1.0):
    """Blocks above the through fracture pressed down, then driven along it by `slip` elements.

    The arms cut the square. Blocks above the stem and the first arm move; the others are held at the boundary. Y and kink
    move away from their first arm, which opens.
    """
    arms = arms_of(kind, angle)
    mesh = junction_mesh(arms, size, sides=(side, side), cut=True)
    way = -1.0 if kind in ("Y", "kink") else 1.0
    # Sector k ends at arm k: those between the first arm and the stem move
    moving = range(1, int(np.flatnonzero(arms == 180.0)[0]) + 1)
    load = {"left": ("tx", 0.5), "right": ("tx", -0.5), "top": ("ty", -1.0)}
    boundaries = []
    for name in mesh.lines:
        if name == "frac":
            continue
        where, sector = name.split("_")
        if int(sector) in moving:
            key, factor = load[where]
            boundaries.append({"group": name, "stage": "load", key: factor * pressure})
            boundaries.append({"group": name, "stage": "slide", "vx": way * slip * size / cycles})
        else:
            boundaries.append({"group": name, "vx": 0.0, "vy": 0.0})
    return Scene(mesh, arms, side / 2, boundaries, [("load", 2), ("slide", cycles)], size)


def abutment(size=0.1):
    """A fracture that meets another at 58 degrees between rollers, `junction_t58` of the issue."""
    arms = np.array([0.0, 58.0, 180.0])
    mesh = junction_mesh(arms, size, length=(0.6, 0.4, 0.6), sides=(2.0, 1.0))
    boundaries = [
        {"group": "bottom", "vy": 0.0},
        {"group": "left", "vx": 0.0},
        {"group": "right", "pressure": 4e6},
        {"group": "top", "pressure": 8e6},
    ]
    return Scene(mesh, arms, 0.4, boundaries, [("load", 4)], size, material="density = 2700, poisson = 0.25")


def crossing_faults(size=0.045, load=15e6, cycles=5):
    """Two faults that cross at 60 degrees in a wide plate pressed along their bisector, `x_crossing` of the issue."""
    arms = np.array([60.0, 120.0, 240.0, 300.0])
    mesh = junction_mesh(arms, size, length=0.5, sides=(6.0, 6.0), coarse=0.6)
    return Scene(mesh, arms, 0.5, far_field(mesh, (0.0, load, 0.0)), [("load", cycles)], size, young=3e9)


def network(traces, size, folder):
    """A map of traces under the stresses of phases I and II-B, its mesh by femdem-mesh."""
    out = Path(folder) / "network.msh"
    command = [
        *module("femdem.network.make_mesh"),
        Path(traces).resolve(),
        "--size",
        str(size),
        "--out",
        out.resolve(),
    ]
    subprocess.run(command, env=environment(), check=True, capture_output=True)
    mesh = read_mesh(out)
    # Variants turn about the origin: any, for coordinates that are multiples of the least distance between numbers
    phases = (("phase_1", (5e6, 5e6, 0.0)), ("phase_2b", (15e6, 5e6, 0.0)))
    boundaries = []
    for phase, stress in phases:
        for boundary in far_field(mesh, stress):
            held = boundary["group"].startswith("corner")
            if not held:
                boundaries.append({**boundary, "stage": phase})
            elif phase == "phase_1":
                boundaries.append(boundary)
    mesh = replace(mesh, lines={"frac" if name == "fractures" else name: v for name, v in mesh.lines.items()})
    return Scene(mesh, np.zeros(0), 0.0, boundaries, [(phase, 10) for phase, _ in phases], size)


def turned_arms(scene, arms):
    """The scene with its arms turned to other directions, the mesh drawn with them: the same triangles, a little deformed.

    Angles are stretched between arms, the corners of the square stay, and places keep their part of the way to the boundary.
    """
    half = np.abs(scene.mesh.xy).max(axis=0)
    rim = np.degrees(np.arctan2(half[1] * np.array([1, 1, -1, -1]), half[0] * np.array([1, -1, -1, 1]))) % 360

    def reach(angle):
        along = np.abs([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        return np.min(half[:, None] / np.maximum(along, 1e-12), axis=0)

    old, new = np.append(scene.arms, rim), np.append(arms, rim)
    order = np.argsort(old)
    old, new = old[order], new[order]
    assert (np.diff(new) > 0).all(), "an arm would pass a corner"
    knots = [np.concatenate([k[-1:] - 360, k, k[:1] + 360]) for k in (old, new)]
    angle = np.degrees(np.arctan2(*scene.mesh.xy.T[::-1])) % 360
    turned = np.interp(angle, *knots)
    far = np.hypot(*scene.mesh.xy.T) * reach(turned) / reach(angle)
    xy = far[:, None] * np.stack([np.cos(np.radians(turned)), np.sin(np.radians(turned))], axis=1)
    # The boundary stays where it is to the last bit
    for axis in range(2):
        on = np.abs(np.abs(scene.mesh.xy[:, axis]) - half[axis]) < EXACT
        xy[on, axis] = scene.mesh.xy[on, axis]
    mesh = replace(scene.mesh, xy=xy)
    assert (areas(mesh.xy, mesh.triangles) > 0).all(), "turned too far"
    return replace(scene, mesh=mesh, arms=np.array(arms))


def deck_text(scene, variant, solver, law, coupling="paper", contact="wall", damping="local", options=""):
    """The deck of a scene in a variant; damping: of the explicit solver; options: further groups, or a dictionary of texts by group
    name."""
    joint = LAWS.get(law, law)
    if contact == "potential":
        joint += ", contact = 'potential', normal = 'penalty'"
    angle = next(
        (part.split("=")[1] for part in joint.split(",") if "friction_angle" in part or "phi_r" in part), "0"
    )
    lines = [
        f"&run title = 'junction, {variant.name}', mesh = 'mesh.msh', solver = '{solver}' /",
        f"&material group = 'rock', young = {scene.young!r}, {scene.material} /",
        f"&joint group = 'frac', {joint}, coupling = '{coupling}' /",
        f"&contact friction_angle = {angle} /",
    ]
    for boundary in scene.boundaries:
        values = changed_group(boundary, variant)
        texts = (
            f"{key} = '{v}'" if isinstance(v, str) else f"{key} = {float(v)!r}" for key, v in values.items()
        )
        lines.append("&boundary " + ", ".join(texts) + " /")
    # A velocity is displacement a cycle; the explicit solver has its own seconds
    for name, cycles in scene.stages:
        rest = ", equilibrium = 1e-5, max_rest_time = 0.2" if solver == "explicit" else ""
        lines.append(f"&stage name = '{name}', cycles = {cycles}, move_time = {MOVE[solver]!r}{rest} /")
    if solver == "explicit":
        lines.append(f"&explicit damping = '{damping}' /")
    # Rock in rock is looked for ten times a stage
    every = max(1, max(cycles for _, cycles in scene.stages) // 10)
    lines.append(f"&output fields_every = {every} /")
    return "\n".join([*lines, options, ""])


MOVE = {"implicit": 1.0, "relaxation": 1.0, "explicit": 1e-2}


# --- runs -----------------------------------------------------------------------------------------------------------------


class RunError(Exception):
    """A run that failed; the message is its last words."""


@dataclass
class Answer:
    """What a run found, in the frame of the scene as drawn."""

    middle: np.ndarray  # of the joint elements before any motion (joints, 2) [m]
    length: np.ndarray  # (joints) [m]
    edge: np.ndarray  # block edge of each joint, from 0 (joints)
    values: dict  # name -> (joints): slip (signed), slip_size, aperture, normal_stress, shear_stress, opening, closure, dilation
    xy: np.ndarray  # before any motion (nodes, 2) [m]
    moved: list  # at each snapshot (nodes, 2) [m]
    closure: list  # of the joints then: what their walls overlap (joints) [mm]
    largest_slip: list  # then [mm]
    triangles: np.ndarray
    table: dict  # of edges.csv: mean slip, largest slip, mean aperture, largest aperture of each block edge
    seconds: float = 0.0
    log: str = ""

    def of_edges(self, name):
        """Mean of a quantity over each block edge, weighted by length (block edges)"""
        total = np.bincount(self.edge, self.length)
        return np.bincount(self.edge, self.length * self.values[name]) / total


def run(scene, variant, folder, solver="implicit", law="jcm", timeout=600, **options):
    """Run a scene in a variant; the answer as drawn. RunError when it fails."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    moved = scaled_velocities(scene, MOVE[solver])
    changed_mesh(scene.mesh, variant).write(folder / "mesh.msh")
    (folder / "deck.nml").write_text(deck_text(moved, variant, solver, law, **options), encoding="utf-8")
    command = [program(), "--quiet", "--output", "results", "deck.nml"]
    start = time.monotonic()
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=timeout, check=False
        )
    except subprocess.TimeoutExpired:
        raise RunError(f"not done after {timeout} s") from None
    said = done.stdout + done.stderr
    if done.returncode != 0:
        words = [line.strip() for line in said.splitlines() if line.strip()]
        raise RunError(f"status {done.returncode}: {' '.join(words[-6:])}")
    return read_answer(folder / "results", variant, time.monotonic() - start)


def scaled_velocities(scene, move_time):
    """The scene with velocities that give the displacement of a cycle in another time."""
    boundaries = [
        {key: value / move_time if key in ("vx", "vy") else value for key, value in boundary.items()}
        for boundary in scene.boundaries
    ]
    return replace(scene, boundaries=boundaries)


def program():
    return os.environ.get("FEMDEM", str(TOP / "build" / "femdem"))


def read_answer(directory, variant, seconds=0.0):
    """The last snapshot of a run, brought back to the scene as drawn."""
    results = Results(directory)
    fields, mesh = results.fields, results.fields.mesh()
    back = variant.array.astype(float)  # x as drawn = R' x, which is x R for rows
    sign = -1.0 if variant.mirrors else 1.0
    line = mesh.coordinates[mesh.joints[:, :2]] @ back
    slip = sign * fields.read("shear_displacement_mm")
    values = {
        "slip": slip,
        "slip_size": np.abs(slip),
        "shear_stress": sign * fields.read("shear_stress_MPa"),
        "normal_stress": fields.read("normal_stress_MPa"),
        "aperture": fields.read("aperture_mm"),
        "opening": fields.read("opening_mm"),
        "closure": fields.read("closure_mm"),
        "dilation": fields.read("dilation_mm"),
    }
    edges = results.edges
    order = np.argsort(edges.id)
    table = {
        name: getattr(edges, column)[order]
        for name, column in (
            ("slip_size", "mean_shear_displacement_mm"),
            ("largest_slip", "largest_shear_displacement_mm"),
            ("aperture", "mean_aperture_mm"),
            ("largest_aperture", "largest_aperture_mm"),
        )
    }
    steps = range(len(fields.steps))
    triangles = mesh.triangles[:, ::-1] if variant.mirrors else mesh.triangles
    return Answer(
        middle=line.mean(axis=1),
        length=np.hypot(*(line[:, 1] - line[:, 0]).T),
        edge=mesh.block_edge - 1,
        values=values,
        xy=mesh.coordinates @ back,
        moved=[(mesh.coordinates + fields.read("displacement", step)) @ back for step in steps],
        closure=[closure_of_walls(mesh, fields.read("displacement", step)) for step in steps],
        largest_slip=[float(np.abs(fields.read("shear_displacement_mm", step)).max()) for step in steps],
        triangles=triangles,
        table=table,
        seconds=seconds,
        log=(Path(directory) / "run.log").read_text(encoding="utf-8"),
    )


# --- measures -------------------------------------------------------------------------------------------------------------


def in_order_of(answer, reference):
    """The answer with joints and block edges numbered as in the reference: matched by place."""
    off, which = cKDTree(answer.middle).query(reference.middle)
    assert len(answer.middle) == len(reference.middle), "another number of joint elements"
    assert off.max() < EXACT, f"a joint element is {off.max():.1e} m from its place"
    pairs = {(int(answer.edge[k]), int(e)) for k, e in zip(which, reference.edge, strict=True)}
    assert len(pairs) == len(set(reference.edge)) == len(set(answer.edge)), (
        "block edges of other joint elements"
    )
    old = np.empty(len(pairs), dtype=int)
    for mine, other in pairs:
        old[other] = mine
    return replace(
        answer,
        middle=answer.middle[which],
        length=answer.length[which],
        edge=reference.edge,
        values={name: value[which] for name, value in answer.values.items()},
        table={name: value[old] for name, value in answer.table.items()},
    )


def differences(answer, reference):
    """Per quantity: largest difference of block edges' means over the largest of the scene, and over the edge's own.

    Slip is compared signed and in size, as in edges.csv; its own of an edge is the mean size. Edges that slip less than a
    hundredth of the largest are left out of the second.
    """
    answer = in_order_of(answer, reference)
    pairs = {name: [(answer.of_edges(name), reference.of_edges(name))] for name in QUANTITIES}
    pairs["slip"].append((answer.table["slip_size"], reference.table["slip_size"]))
    pairs["aperture"].append((answer.table["aperture"], reference.table["aperture"]))
    found = {}
    for name, compared in pairs.items():
        own = np.abs(compared[-1][1])
        off = np.max([np.abs(one - other) for one, other in compared], axis=0)
        largest = own.max()
        felt = own > LEAST * largest
        found[name] = (
            float(off.max() / largest) if largest else float(off.max() > 0),
            float((off[felt] / own[felt]).max()) if felt.any() else float(off.max() > 0),
        )
    return found


def mean_difference(answer, reference):
    """Largest relative difference of the means of slip (its size), aperture and normal stress over all joints."""
    found = 0.0
    for name in ("slip_size", "aperture", "normal_stress"):
        one, other = (np.average(a.values[name], weights=a.length) for a in (answer, reference))
        found = max(found, abs(one - other) / abs(other) if other else float(one != other))
    return float(found)


@dataclass
class Overlap:
    """Rock in rock around a junction: the two blocks, and the snapshot, that pass what is allowed most."""

    area: float = 0.0  # of all blocks then [m2]
    depth: float = 0.0  # deepest place of the two [mm]
    place: tuple = (0.0, 0.0)  # of it [m]
    allowed: float = 0.0  # closure plus 1 % of the slip [mm]


def overlap(answer, scene, reach=None):
    """Overlap of the blocks between the arms at the snapshot where it passes what is allowed most.

    A block is what lies between two arms, out to `reach` (m; not given: 0.8 of the arms). The depth is that of the deepest
    corner of the overlap in either of the two blocks: how far it is to the block's boundary. Blocks may overlap by the
    closure of the arm between them and 1 % of the slip; where a block lies between them, which tapers to nothing at the
    junction, by the closures on either side of it; the two blocks of a kink by what the corner of one is in the other when
    the walls of both arms have closed. Nothing for a network, which has no arms.
    """
    if not len(scene.arms):
        return Overlap()
    reach = reach or 0.8 * scene.reach
    centre = answer.xy[answer.triangles].mean(axis=1)
    near = np.hypot(*centre.T) < reach
    triangles, sector = answer.triangles[near], sector_of(centre[near], scene.arms)
    outlines = [outline_of(triangles[sector == k]) for k in range(len(scene.arms))]
    worst = Overlap(allowed=np.inf)
    for moved, closure, slip in zip(answer.moved, answer.closure, answer.largest_slip, strict=True):
        of_arm = closure_of_arms(answer, closure, scene.arms)
        blocks = [unary_union(list(polygonize(moved[edges].tolist()))) for edges in outlines]
        pairs = list(itertools.combinations(range(len(blocks)), 2))
        found = [
            _overlap(blocks[i], blocks[j], _between(of_arm, scene.arms, i, j) + CORNER * slip)
            for i, j in pairs
        ]
        deepest = max(found, key=lambda one: one.depth - one.allowed)
        if deepest.depth - deepest.allowed > worst.depth - worst.allowed:
            worst = replace(deepest, area=sum(one.area for one in found))
    return worst


def outline_of(triangles):
    """Edges that only one of the triangles has (edges, 2)"""
    edges, times = triangle_edges(triangles)
    return edges[times == 1]


def _overlap(one, other, allowed):
    common = one.intersection(other)
    result = Overlap(allowed=float(allowed), area=common.area)
    for part in getattr(common, "geoms", [common]):
        if not isinstance(part, Polygon):
            continue
        for corner in part.exterior.coords:
            depth = 1e3 * max(Point(corner).distance(block.boundary) for block in (one, other))
            if depth > result.depth:
                result.depth, result.place = depth, tuple(corner)
    return result


def _between(of_arm, arms, one, other):
    """Closures of the arms from one sector to another, the way with fewer of them (as many: the larger sum)."""
    if len(arms) == 2:
        return corner_behind(of_arm, arms)
    # Sector k ends at arm k
    ways = (of_arm[one:other], np.concatenate([of_arm[other:], of_arm[:one]]))
    return min((len(way), -way.sum()) for way in ways)[1] * -1


def corner_behind(closure, arms):
    """How deep the corner of a block is in the only other one, where the walls of both arms have closed."""
    # The rock left free is a cone; c1 and c2 behind its sides
    c1, c2 = closure
    turn = np.radians(arms[1] - arms[0])
    cosine = -np.cos(turn)  # of the angle between the normals of its sides
    if min(c1, c2) <= cosine * max(c1, c2):
        return max(c1, c2)
    return float(np.sqrt(c1**2 + c2**2 - 2 * c1 * c2 * cosine) / abs(np.sin(turn)))


def closure_of_walls(mesh, displacement):
    """How far the walls of each joint element overlap at either end (joints, 2) [mm]: at a junction more than in the mean."""
    line = np.diff(mesh.coordinates[mesh.joints[:, :2]], axis=1)[:, 0]
    along = line / np.hypot(*line.T)[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    apart = displacement[mesh.joints[:, 2:]] - displacement[mesh.joints[:, :2]]
    return -1e3 * np.einsum("jec,jc->je", apart, normal)


def closure_of_arms(answer, closure, arms):
    """Largest closure along each arm (arms) [mm]."""
    direction = np.degrees(np.arctan2(answer.middle[:, 1], answer.middle[:, 0])) % 360
    arm = np.abs((arms - direction[:, None] + 180) % 360 - 180).argmin(axis=1)
    return np.array([max(0.0, closure[arm == k].max()) for k in range(len(arms))])


def at_crossing(answer, scene):
    """Joint elements that touch the junction: arm and values, a row each."""
    near = np.hypot(*answer.middle.T) < 0.51 * answer.length
    direction = np.degrees(np.arctan2(answer.middle[:, 1], answer.middle[:, 0])) % 360
    rows = []
    for k in np.flatnonzero(near):
        off = np.abs((scene.arms - direction[k] + 180) % 360 - 180)
        rows.append(
            {
                "arm": float(scene.arms[off.argmin()]),
                **{name: float(v[k]) for name, v in answer.values.items()},
            }
        )
    return sorted(rows, key=lambda row: row["arm"])


# --- command line ---------------------------------------------------------------------------------------------------------


def scene_of(kind, angle, size, slip=0.0, cycles=None):
    """Small slip (0) or a slip of so many elements"""
    if slip:
        # Blocks of a star are driven point first: in steps well below the reach of their corners, half an element
        return large_slip(kind, angle, size, slip, cycles or (30 if kind == "star" else 20))
    return small_slip(kind, angle, size, cycles or 4)


def compare(scene, folder, variants=tuple(VARIANTS), **options):
    """Rows for a scene, one a variant: differences from the scene as drawn, overlap, time, or why it failed."""
    rows, reference = [], None
    for name in ("drawn", *(v for v in variants if v != "drawn")):
        row = {"variant": name}
        try:
            answer = run(scene, VARIANTS[name], Path(folder) / name, **options)
        except RunError as error:
            rows.append({**row, "message": str(error)})
            if name == "drawn":
                break
            continue
        reference = reference or answer
        rock = overlap(answer, scene)
        for quantity, (of_scene, of_edge) in differences(answer, reference).items():
            row[f"{quantity}_scene"], row[f"{quantity}_edge"] = of_scene, of_edge
        row |= {
            "means": mean_difference(answer, reference),
            "largest_slip_mm": float(answer.values["slip_size"].max()),
            "overlap_mm": rock.depth,
            "allowed_mm": rock.allowed,
            "overlap_mm2": 1e6 * rock.area,
            "seconds": answer.seconds,
            "message": "",
        }
        rows.append(row)
    return rows, reference


def print_rows(rows):
    columns = [f"{quantity}_{over}" for quantity in QUANTITIES for over in ("scene", "edge")]
    print(
        f"{'variant':28}"
        + "".join(f"{c:>20}" for c in columns)
        + f"{'means':>10}{'slip mm':>10}{'overlap mm':>12}{'allowed':>10}"
    )
    for row in rows:
        if row["message"]:
            print(f"{row['variant']:28}{row['message']}")
            continue
        print(
            f"{row['variant']:28}"
            + "".join(f"{row[c]:20.2e}" for c in columns)
            + f"{row['means']:10.1e}{row['largest_slip_mm']:10.4g}{row['overlap_mm']:12.4g}{row['allowed_mm']:10.4g}"
        )


def series(arguments, folder):
    """Rows of the whole matrix, as they are found."""
    # The implicit solver first: others are compared with it
    solvers = sorted(arguments.solvers, key=lambda solver: solver != "implicit")
    by_implicit = None
    for kind, angle, law, slip, solver in itertools.product(
        arguments.kinds, arguments.angles, arguments.laws, arguments.slips, solvers
    ):
        scene = scene_of(kind, angle, arguments.size, slip, arguments.cycles)
        options = {"coupling": arguments.coupling, "contact": arguments.contact}
        rows, reference = compare(
            scene, folder, arguments.variants, solver=solver, law=law, timeout=arguments.timeout, **options
        )
        head = {"kind": kind, "angle": angle, "law": law, "slip": slip, "solver": solver, **options}
        for row in rows:
            yield {**head, **row}
        if solver == "implicit":
            by_implicit = reference
        elif reference is not None and by_implicit is not None:
            off = differences(reference, by_implicit)  # both as drawn
            row = {f"{name}_{over}": off[name][k] for name in off for k, over in enumerate(("scene", "edge"))}
            yield {**head, "variant": "against_implicit", **row, "message": ""}


JUMP_ANGLES = tuple(59 + 0.2 * k for k in range(11))


def jump(kind, folder, slip=0.0, size=0.05, strike=25.0, **options):
    """Largest step of each quantity between 59 and 61 degrees beyond the mean of the steps before and after it, over the
    largest of the scene; on one mesh whose arms are turned."""
    scene = scene_of(kind, 60.0, size, slip)
    strike = 0.0 if slip else strike
    answers = []
    for angle in JUMP_ANGLES:
        turned = turned_arms(scene, arms_of(kind, angle, strike))
        answers.append(run(turned, VARIANTS["drawn"], Path(folder) / f"{angle:g}", **options))
    found = {}
    for name in QUANTITIES:
        values = np.array([answer.of_edges(name) for answer in answers])
        steps = np.diff(values, axis=0)
        beyond = steps[1:-1] - (steps[:-2] + steps[2:]) / 2
        found[name] = float(np.abs(beyond).max() / np.abs(values).max())
    return found


def jumps(arguments, folder):
    """Rows of the jumps at 60 degrees."""
    for kind, law, slip, solver in itertools.product(
        arguments.kinds, arguments.laws, arguments.slips, arguments.solvers
    ):
        row = {"kind": kind, "law": law, "slip": slip, "solver": solver}
        options = {"solver": solver, "law": law, "coupling": arguments.coupling, "contact": arguments.contact}
        try:
            off = jump(kind, folder, slip, arguments.size, timeout=arguments.timeout, **options)
            yield {**row, **off, "message": ""}
        except RunError as error:
            yield {**row, "message": str(error)}


REFINE_SIZES = (0.05, 0.025, 0.0125, 0.00625)
REFINE_LOADS = (0.15e6, 1.5e6, 15e6, 30e6)
DISTANCES = (0.02, 0.05, 0.1, 0.2, 0.35)  # from the crossing [m]
# As stiff as what the potential has at these sizes: the slip is the faults', not the springs'
STIFF = "law = 'coulomb', friction_angle = 20, kn_mpa_mm = 1e4, ks_mpa_mm = 1e4"
SOFT = "law = 'coulomb', friction_angle = 20, kn_mpa_mm = 1e3, ks_mpa_mm = 1"


def refined(size, load, contact, folder, law=STIFF, cycles=5, timeout=1800):
    """Slip over load of crossing faults [mm/MPa]: of each arm in the mean, and at distances from the crossing."""
    scene = crossing_faults(size, load, cycles)
    solver = "implicit" if contact == "wall" else "relaxation"
    answer = run(scene, VARIANTS["drawn"], folder, solver, law, contact=contact, timeout=timeout)
    rock = overlap(answer, scene)
    direction = np.degrees(np.arctan2(*answer.middle.T[::-1])) % 360
    far, slip = np.hypot(*answer.middle.T), answer.values["slip_size"] / (load / 1e6)
    row, at = {}, []
    for arm in scene.arms:
        on = np.flatnonzero(np.abs(direction - arm) < 1.0)
        on = on[np.argsort(far[on])]
        row[f"arm_{arm:.0f}"] = float(np.average(slip[on], weights=answer.length[on]))
        at.append(np.interp(DISTANCES, far[on], slip[on]))
    row["mean"] = float(np.mean(list(row.values())))
    row |= {f"at_{d:g}": float(value) for d, value in zip(DISTANCES, np.mean(at, axis=0), strict=True)}
    largest = float(answer.values["slip_size"].max())
    return row | {
        "largest_slip_mm": largest,
        "overlap_mm": rock.depth,
        "allowed_mm": rock.allowed,
        "seconds": answer.seconds,
    }


def refinement(arguments, folder):
    """Rows of wall contact and potential contact at every size and load, and what the two differ by."""
    law = SOFT if arguments.soft else STIFF
    for size, load in itertools.product(arguments.sizes, arguments.loads):
        head, means = {"size": size, "load_MPa": load / 1e6}, {}
        for contact in arguments.contacts:
            try:
                row = refined(size, load, contact, folder, law, timeout=arguments.timeout)
                means[contact] = row["mean"]
                yield {**head, "contact": contact, **row, "message": ""}
            except RunError as error:
                yield {**head, "contact": contact, "message": str(error)}
        if len(means) == 2:
            off = means["wall"] / means["potential"] - 1
            yield {**head, "contact": "wall over potential - 1", "mean": off, "message": ""}


def write_rows(rows, path):
    """Rows to a CSV file and, shorter, to the screen, as they come."""
    rows = iter(rows)
    kept = []
    for row in rows:
        kept.append(row)
        print(" ".join(f"{v:.3g}" if isinstance(v, float) else str(v) for v in row.values()), flush=True)
        names = list(dict.fromkeys(name for one in kept for name in one if name != "message"))
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, [*names, "message"], restval="")
            writer.writeheader()
            writer.writerows(kept)
    return kept


def arguments_of(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--series", action="store_true", help="the whole matrix")
    what.add_argument("--jump", action="store_true", help="from 59 to 61 degrees")
    what.add_argument("--refine", action="store_true", help="crossing faults, finer and finer")
    what.add_argument("--network", help="a map of traces (CSV)")
    parser.add_argument("--kind", choices=KINDS, default="X")
    parser.add_argument("--angle", type=float, default=59.0, help="degrees (default 59)")
    parser.add_argument("--size", type=float, default=0.05, help="element size (m; default 0.05)")
    parser.add_argument(
        "--slip", type=float, default=0.0, help="large slip, in elements (default 0: small slip)"
    )
    parser.add_argument("--cycles", type=int, help="load increments (default 4; large slip 20)")
    parser.add_argument("--solver", choices=SOLVERS, default="implicit")
    parser.add_argument("--law", choices=list(LAWS), default="jcm")
    parser.add_argument("--coupling", choices=("paper", "coupled"), default="paper")
    parser.add_argument("--contact", choices=("wall", "potential"), default="wall")
    parser.add_argument("--variants", nargs="+", choices=list(VARIANTS), default=list(VARIANTS))
    parser.add_argument("--folder", type=Path, help="where the runs go (default: a folder that is removed)")
    parser.add_argument("--out", help="CSV file of --series, --jump and --refine")
    parser.add_argument("--timeout", type=float, default=600, help="of a run (s; default 600)")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="of --series and --jump")
    parser.add_argument("--angles", nargs="+", type=float, default=ANGLES, help="of --series")
    parser.add_argument("--laws", nargs="+", choices=list(LAWS), default=list(LAWS))
    parser.add_argument("--solvers", nargs="+", choices=SOLVERS, default=SOLVERS)
    parser.add_argument("--slips", nargs="+", type=float, default=(0.0, 3.0), help="in elements; 0: small")
    parser.add_argument("--sizes", nargs="+", type=float, default=REFINE_SIZES, help="of --refine (m)")
    parser.add_argument("--loads", nargs="+", type=float, default=REFINE_LOADS, help="of --refine (Pa)")
    parser.add_argument("--contacts", nargs="+", default=("wall", "potential"), help="of --refine")
    parser.add_argument(
        "--soft", action="store_true", help="--refine with the springs of x_crossing (walls only)"
    )
    return parser.parse_args(words)


def main():
    arguments = arguments_of()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        for chosen, rows in (("series", series), ("jump", jumps), ("refine", refinement)):
            if getattr(arguments, chosen):
                write_rows(rows(arguments, folder), arguments.out or f"{chosen}.csv")
                return
        if arguments.network:
            folder.mkdir(parents=True, exist_ok=True)
            scene = network(arguments.network, arguments.size, folder)
        else:
            scene = scene_of(
                arguments.kind, arguments.angle, arguments.size, arguments.slip, arguments.cycles
            )
        rows, reference = compare(
            scene,
            folder,
            arguments.variants,
            solver=arguments.solver,
            law=arguments.law,
            coupling=arguments.coupling,
            contact=arguments.contact,
            timeout=arguments.timeout,
        )
    print_rows(rows)
    if reference is not None and len(scene.arms):
        print("\njoint elements at the junction")
        names = list(reference.values)
        print(f"{'arm':>8}" + "".join(f"{name:>15}" for name in names))
        for row in at_crossing(reference, scene):
            print(f"{row['arm']:8.1f}" + "".join(f"{row[name]:15.5g}" for name in names))


if __name__ == "__main__":
    main()
