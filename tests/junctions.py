#!/usr/bin/env python3
"""Junctions of fractures: the answer must not know how the mesh was drawn, and corners must not pass through each other.

    python3 tests/junctions.py --kind X --angle 59 --size 0.05 --solver implicit --law coulomb
    python3 tests/junctions.py --kind T --angle 45 --slip 3 --variants mirrored turned_90
    python3 tests/junctions.py --series --out junctions.csv
    python3 tests/junctions.py --refine --out refine.csv

A square of rock holds a junction of fractures in its middle. Small slip: the arms end in the rock, the square is loaded by a
far-field stress. Large slip (--slip, in elements): the arms cut the square into blocks, those above the through fracture
are pressed down and driven along it.

The same scene is run as drawn and as variants of the mesh: mirrored (x -> -x), turned by 90 and 180 degrees, renumbered.
Coordinates change sign and place only, so that a variant is the same scene to the last bit; loads turn with it. Joint
elements are matched by their place, and their values are brought back to the scene as drawn: slip and shear stress keep
their sign when the scene is turned (a wall turned by half a turn is the other wall), and change it in a mirror.

What is compared is the mean of slip, aperture and normal stress over each block edge: the difference over the largest of
the scene (`scene`), which the bar of 1e-3 is for, and over the edge's own (`edge`), which is large where an edge hardly slips
and says little there. Rock in rock is measured from the deformed triangles: the deepest place of the overlap of the blocks
(mm), against the closure of the joints plus 1 % of the slip.
"""

import argparse
import itertools
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postproc"))
from femdem_results import Results

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


def junction_mesh(kind, angle, size, length=0.3, side=1.0, cut=False, strike=0.0, coarse=None):
    """A square with a junction in its middle, and the directions of the arms. With cut the arms reach the boundary.

    size at the arms; coarse at the boundary (not given: size). Groups: rock, frac, left, right, bottom, top, corner_sw,
    corner_se; with cut each side is parted at the arms: left_1, left_2, ... anticlockwise, and rim_sides_of says whose.
    """
    return _junction_mesh(kind, float(angle), size, length, side, cut, strike, coarse)


@lru_cache(maxsize=64)
def _junction_mesh(kind, angle, size, length, side, cut, strike, coarse):
    import gmsh

    arms = arms_of(kind, angle, strike)
    half = side / 2
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        corners = {"sw": (-half, -half), "se": (half, -half), "ne": (half, half), "nw": (-half, half)}
        rim = [(np.arctan2(y, x) % (2 * np.pi), geo.addPoint(x, y, 0), (x, y)) for x, y in corners.values()]
        tags = {name: point for name, (_, point, _) in zip(corners, rim, strict=True)}
        centre = geo.addPoint(0, 0, 0)
        curves, rim_arms = [], []
        for arm in np.radians(arms):
            along = np.array([np.cos(arm), np.sin(arm)])
            reach = half / np.abs(along).max() if cut else length
            end = reach * along
            if cut:
                end = np.where(np.abs(np.abs(end) - half) < 1e-12, np.sign(end) * half, end)
            at_corner = [p for _, p, place in rim if cut and np.hypot(*(end - place)) < 1e-9]
            point = at_corner[0] if at_corner else geo.addPoint(*end, 0)
            curves.append(geo.addLine(centre, point))
            if cut and not at_corner:
                rim.append((arm % (2 * np.pi), point, tuple(end)))
                rim_arms.append(point)
        rim.sort()
        outline = [geo.addLine(one[1], other[1]) for one, other in zip(rim, rim[1:] + rim[:1], strict=True)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(outline)])
        geo.synchronize()
        gmsh.model.mesh.embed(1, curves, 2, surface)
        names = {}
        for line, one, other in zip(outline, rim, rim[1:] + rim[:1], strict=True):
            middle = (np.array(one[2]) + other[2]) / 2
            sides = {"left": -middle[0], "right": middle[0], "bottom": -middle[1], "top": middle[1]}
            name = max(sides, key=sides.get)
            if cut:
                # Named by the block too: the sector its middle is in
                name += f"_{sector_of(middle[None, :], arms)[0] + 1}"
            names.setdefault(name, []).append(line)
        names["frac"] = curves
        for name, lines in names.items():
            gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, lines), name)
        for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
            gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
        if coarse is None:
            gmsh.option.setNumber("Mesh.MeshSizeMin", size)
            gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        else:
            mesh_field = gmsh.model.mesh.field
            distance = mesh_field.add("Distance")
            mesh_field.setNumbers(distance, "EdgesList", curves)
            mesh_field.setNumber(distance, "NNodesByEdge", 400)
            graded = mesh_field.add("Threshold")
            mesh_field.setNumber(graded, "InField" if gmsh.__version__ >= "4.8" else "IField", distance)
            for option, value in zip(
                ("SizeMin", "SizeMax", "DistMin", "DistMax"),
                (size, coarse, length / 5, side / 2),
                strict=True,
            ):
                mesh_field.setNumber(graded, option, value)
            mesh_field.setAsBackgroundMesh(graded)
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.model.mesh.generate(2)
        return _mesh_of_gmsh(names, surface, {f"corner_{name}": tags[name] for name in ("sw", "se")}), arms
    finally:
        gmsh.finalize()


def _mesh_of_gmsh(names, surface, points):
    """The present model of gmsh as a Mesh, without nodes that no triangle has."""
    import gmsh

    tag, place, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tag.max()) + 1, dtype=int)
    number[tag.astype(int)] = np.arange(len(tag))

    def elements(dimension, entity, corners):
        nodes = gmsh.model.mesh.getElements(dimension, entity)[2][0]
        return number[nodes.astype(int)].reshape(-1, corners)

    xy = place.reshape(-1, 3)[:, :2].copy()
    triangles = elements(2, surface, 3)
    lines = {name: np.vstack([elements(1, curve, 2) for curve in curves]) for name, curves in names.items()}
    nodes = {name: int(elements(0, point, 1)[0, 0]) for name, point in points.items()}
    used, back = np.unique(triangles, return_inverse=True)
    new = np.full(len(xy), -1)
    new[used] = np.arange(len(used))
    mesh = Mesh(
        xy[used],
        back.reshape(-1, 3),
        {name: new[line] for name, line in lines.items()},
        {name: int(new[node]) for name, node in nodes.items()},
    )
    assert (areas(mesh.xy, mesh.triangles) > 0).all()
    return mesh


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


def small_slip(kind, angle, size, cycles=4, stress=(4e6, 8e6, 0.0), strike=25.0, **mesh_options):
    """Arms that end in the rock, under a far-field stress (sxx, syy, sxy) [Pa], compression positive."""
    mesh, arms = junction_mesh(kind, angle, size, strike=strike, **mesh_options)
    sxx, syy, sxy = stress
    boundaries = [
        {"group": side, "sxx": sxx, "syy": syy, "sxy": sxy} for side in ("left", "right", "bottom", "top")
    ]
    # The stress is in balance: these hold what it leaves free, and carry nothing
    boundaries += [{"group": "corner_sw", "vx": 0.0, "vy": 0.0}]
    far = mesh.xy[mesh.points["corner_se"]] - mesh.xy[mesh.points["corner_sw"]]
    boundaries += [{"group": "corner_se", "vy" if abs(far[0]) > abs(far[1]) else "vx": 0.0}]
    return Scene(mesh, arms, mesh_options.get("length", 0.3), boundaries, [("load", cycles)], size)


def large_slip(kind, angle, size, slip, cycles=20, pressure=5e6, side=1.0):
    """Blocks above the through fracture pressed down, then driven along it by `slip` elements.

    The arms cut the square. Blocks above the stem (and above the first arm of a Y or a kink) move; the others are held at
    the boundary. Y and kink move away from the arm, which opens.
    """
    mesh, arms = junction_mesh(kind, angle, size, side=side, cut=True)
    way = -1.0 if kind in ("Y", "kink") else 1.0
    stem = int(np.flatnonzero(arms == 180.0)[0])
    # Sector k lies below arm k: those between the first arm and the stem move
    moving = range(1, stem + 1)
    boundaries = []
    for name in mesh.lines:
        if name == "frac":
            continue
        where, sector = name.split("_")
        if int(sector) - 1 not in moving:
            boundaries.append({"group": name, "vx": 0.0, "vy": 0.0})
            continue
        normal = {"left": (1, 0), "right": (-1, 0), "top": (0, -1), "bottom": (0, 1)}[where]
        load = {"tx": 0.5 * pressure * normal[0]} if normal[0] else {"ty": pressure * normal[1]}
        boundaries.append({"group": name, "stage": "load", **load})
        boundaries.append({"group": name, "stage": "slide", "vx": way * slip * size / cycles})
    boundaries = [boundary for boundary in boundaries if boundary]
    return Scene(mesh, arms, side / 2, boundaries, [("load", 2), ("slide", cycles)], size)


def deck_text(scene, variant, solver, law, coupling="paper", contact="wall", options=""):
    """The deck of a scene in a variant; options: further groups, or a dictionary of texts by group name."""
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
        lines.append("&explicit damping = 'local' /")
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
    moved: np.ndarray  # after it (nodes, 2) [m]
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
    moved = mesh.coordinates + fields.read("displacement")
    triangles = mesh.triangles[:, ::-1] if variant.mirrors else mesh.triangles
    return Answer(
        middle=line.mean(axis=1),
        length=np.hypot(*(line[:, 1] - line[:, 0]).T),
        edge=mesh.block_edge - 1,
        values=values,
        xy=mesh.coordinates @ back,
        moved=moved @ back,
        triangles=triangles,
        table=table,
        seconds=seconds,
        log=(Path(directory) / "run.log").read_text(encoding="utf-8"),
    )


# --- measures -------------------------------------------------------------------------------------------------------------


def in_order_of(answer, reference):
    """The answer with joints and block edges numbered as in the reference: matched by place."""
    from scipy.spatial import cKDTree

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

    Slips less than a hundredth of the largest are left out of the second.
    """
    answer = in_order_of(answer, reference)
    found = {}
    for name in QUANTITIES:
        one, other = answer.of_edges(name), reference.of_edges(name)
        # Means of magnitudes too, as in edges.csv
        pairs = [(one, other)]
        if name in reference.table:
            pairs.append((answer.table[name], reference.table[name]))
        if name == "slip":
            pairs.append((answer.table["slip_size"], reference.table["slip_size"]))
        scene = edge = 0.0
        for a, b in pairs:
            largest = np.abs(b).max()
            off = np.abs(a - b)
            scene = max(scene, off.max() / largest if largest else float(off.max() > 0))
            felt = np.abs(b) > LEAST * largest
            edge = max(edge, (off[felt] / np.abs(b[felt])).max() if felt.any() else 0.0)
        found[name] = (float(scene), float(edge))
    return found


@dataclass
class Overlap:
    """Rock in rock around a junction."""

    area: float = 0.0  # m2
    depth: float = 0.0  # deepest place [mm]
    place: tuple = (0.0, 0.0)  # of it [m]
    allowed: float = 0.0  # closure plus 1 % of the slip [mm]
    between: list = field(default_factory=list)  # sectors that overlap, with area [mm2] and depth [mm]


def overlap(answer, scene, reach=None):
    """Overlap of the blocks between the arms, from the deformed triangles.

    A block is what lies between two arms, out to `reach` (m; not given: 0.8 of the arms). The depth is that of the
    deepest corner of the overlap in either of the two blocks: how far it is to the block's boundary.
    """
    from shapely.geometry import MultiPolygon, Point, Polygon
    from shapely.ops import unary_union

    reach = reach or 0.8 * scene.reach
    centre = answer.xy[answer.triangles].mean(axis=1)
    near = np.hypot(*centre.T) < reach
    sector = sector_of(centre, scene.arms)
    blocks = {}
    for k in np.unique(sector[near]):
        chosen = answer.triangles[near & (sector == k)]
        blocks[int(k)] = unary_union([Polygon(answer.moved[nodes]) for nodes in chosen])
    result = Overlap(allowed=allowed_overlap(answer))
    for one, other in itertools.combinations(sorted(blocks), 2):
        common = blocks[one].intersection(blocks[other])
        if common.area == 0.0:
            continue
        parts = [common] if isinstance(common, Polygon) else getattr(common, "geoms", [])
        deepest = 0.0
        for part in parts:
            if not isinstance(part, (Polygon, MultiPolygon)):
                continue
            for corner in part.exterior.coords:
                depth = 1e3 * max(Point(corner).distance(blocks[k].boundary) for k in (one, other))
                deepest = max(deepest, depth)
                if depth > result.depth:
                    result.depth, result.place = depth, tuple(corner)
        result.area += common.area
        result.between.append((one, other, 1e6 * common.area, deepest))
    return result


def allowed_overlap(answer):
    """Largest closure of a joint element plus 1 % of the largest slip [mm]"""
    return float(answer.values["closure"].max() + CORNER * answer.values["slip_size"].max())


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
        return large_slip(kind, angle, size, slip, cycles or 20)
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
        + f"{'slip mm':>10}{'overlap mm':>12}{'allowed':>10}"
    )
    for row in rows:
        if row["message"]:
            print(f"{row['variant']:28}{row['message']}")
            continue
        print(
            f"{row['variant']:28}"
            + "".join(f"{row[c]:20.2e}" for c in columns)
            + f"{row['largest_slip_mm']:10.4g}{row['overlap_mm']:12.4g}{row['allowed_mm']:10.4g}"
        )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
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
    arguments = parser.parse_args()
    scene = scene_of(arguments.kind, arguments.angle, arguments.size, arguments.slip, arguments.cycles)
    with tempfile.TemporaryDirectory() as temporary:
        rows, reference = compare(
            scene,
            arguments.folder or temporary,
            arguments.variants,
            solver=arguments.solver,
            law=arguments.law,
            coupling=arguments.coupling,
            contact=arguments.contact,
        )
    print_rows(rows)
    if reference is not None:
        print("\njoint elements at the junction")
        names = list(reference.values)
        print(f"{'arm':>8}" + "".join(f"{name:>15}" for name in names))
        for row in at_crossing(reference, scene):
            print(f"{row['arm']:8.1f}" + "".join(f"{row[name]:15.5g}" for name in names))


if __name__ == "__main__":
    main()
