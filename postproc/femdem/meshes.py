"""Meshes of other programs, read by meshio, as gmsh files of format 2.2 with physical groups.

Sets of elements become physical surfaces (of triangles) and curves (of lines), sets of nodes curves where edges of the
outer boundary join them, physical points otherwise. Quadratic elements keep their corners, quadrilaterals are
cut along their shorter diagonal. Whatever cannot become a mesh of the program is refused, all of it at once.
"""

import contextlib
import importlib
import io
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from femdem.exports import library
from femdem.results import ResultsError

TRIANGLES = {"triangle", "triangle6", "triangle7"}
QUADRILATERALS = {"quad", "quad8", "quad9"}
LINES = {"line", "line3", "line4"}
CORNERS = {"triangle": 3, "quad": 4, "line": 2}
POINTS = {"vertex"}
# Normals of the planes a mesh may lie in, and the two coordinates that stay
PLANES = {"xy": (2, [0, 1]), "xz": (1, [0, 2]), "yz": (0, [1, 2])}
FLAT = 1e-9  # of the size of the mesh: what its third coordinate may vary by
GMSH = {"line": 1, "triangle": 2, "point": 15}  # types of elements
DIMENSION = {"point": 0, "line": 1, "triangle": 2}
SINGLE_SURFACE = "rock"  # name of the surface of a mesh without sets
SHOWN = 5  # of what is wrong, of a kind
# Plane elements of Abaqus beside those that meshio knows, with its names for them
ABAQUS = {
    f"{kind}{nodes}{suffix}": shape
    for kind in ("CPS", "CPE", "CPEG", "CAX")
    for nodes, shape in ((3, "triangle"), (4, "quad"), (6, "triangle6"), (8, "quad8"))
    for suffix in ("", "R", "I", "H", "RH", "M", "MH", "T", "P", "RP", "RT")
}
GMSH_PHYSICAL = "gmsh:physical"


@dataclass
class Plane:
    """A mesh of triangles in a plane with named groups."""

    points: np.ndarray  # (points, 2)
    triangles: np.ndarray  # (triangles, 3)
    surfaces: dict  # name -> numbers of triangles
    lines: dict  # name -> (lines, 2)
    nodes: dict  # name -> numbers of points
    notes: list = field(default_factory=list)  # what was changed


def read(path):
    """The file as meshio has it"""
    meshio = library("meshio")
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: there is no such file")
    known = importlib.import_module("meshio.abaqus._abaqus").abaqus_to_meshio_type
    known.update({name: shape for name, shape in ABAQUS.items() if name not in known})
    said = io.StringIO()
    if path.suffix.lower() not in meshio.extension_to_filetypes:
        endings = " ".join(sorted(meshio.extension_to_filetypes))
        raise ResultsError(
            f"{path}: no mesh is read from files that end in '{path.suffix}'; meshio reads {endings}"
        )
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            return meshio.read(path)
    except SystemExit:
        reason = "meshio says: " + " ".join(said.getvalue().split())
    except Exception as error:  # meshio's readers raise whatever the file makes them stumble over
        reason = f"meshio says: {error}" if str(error) else f"meshio stopped with {type(error).__name__}"
    raise ResultsError(f"{path}: no mesh was read; {reason}")


def plane_coordinates(points, plane, scale, wrong):
    """The two coordinates in the plane [m]"""
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    normal, kept = PLANES[plane]
    size = np.ptp(points[:, kept], axis=0).max()
    if np.ptp(points[:, normal]) > FLAT * size:
        flat = [
            name
            for name, (n, k) in PLANES.items()
            if np.ptp(points[:, n]) <= FLAT * np.ptp(points[:, k], axis=0).max()
        ]
        hint = f"give --plane {flat[0]}" if flat else "it is a mesh in three dimensions: mesh a section of it"
        wrong.append(f"the points do not lie in a plane {'xyz'[normal]} = constant; {hint}")
    return scale * points[:, kept]


def cells_of(mesh, points, wrong):
    """Triangles, lines and vertices; for each block of the file, where its cells went: kind and numbers, (cells, 1 or 2)"""
    found, places, notes = {"triangle": [], "line": [], "vertex": []}, [], Counter()
    refused = Counter()
    count = Counter()
    for block in mesh.cells:
        kind, data = block.type, np.asarray(block.data)
        goal, rows = None, np.zeros((len(data), 0), dtype=int)
        if kind in TRIANGLES | QUADRILATERALS:
            goal = "triangle"
            corner = data[:, : CORNERS["triangle" if kind in TRIANGLES else "quad"]]
            if kind not in ("triangle", "quad"):
                notes["quadratic elements keep their corners alone"] += len(data)
            pieces = cut(corner, points) if kind in QUADRILATERALS else corner[:, None, :]
            if kind in QUADRILATERALS:
                notes["quadrilaterals are cut into two triangles each"] += len(data)
        elif kind in LINES:
            goal, pieces = "line", data[:, None, :2]
        elif kind in POINTS:
            goal, pieces = "vertex", data[:, None, :]
        elif len(data):
            refused[kind] += len(data)
        if goal:
            rows = count[goal] + np.arange(len(data) * pieces.shape[1]).reshape(len(data), -1)
            found[goal].append(pieces.reshape(-1, pieces.shape[2]))
            count[goal] += rows.size
        places.append((goal, rows))
    for kind, number in refused.items():
        wrong.append(
            f"{number} elements of type {kind!r}: the program has 3-node triangles in a plane; in gmsh: "
            "gmsh -2 -order 1 GEOMETRY meshes with them"
        )
    if not found["triangle"] and not refused:
        wrong.append("there are no triangles and no quadrilaterals in it")
    width = {"triangle": 3, "line": 2, "vertex": 1}
    joined = {k: np.vstack(v) if v else np.zeros((0, width[k]), dtype=int) for k, v in found.items()}
    return joined, places, [f"{number} {text}" for text, number in notes.items()]


def cut(quads, points):
    """Two triangles from each quadrilateral (quads, 2, 3), along its shorter diagonal"""
    a, b, c, d = quads.T
    first = np.hypot(*(points[a] - points[c]).T) <= np.hypot(*(points[b] - points[d]).T)
    along_ac = np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], 1)
    along_bd = np.stack([np.stack([a, b, d], 1), np.stack([b, c, d], 1)], 1)
    return np.where(first[:, None, None], along_ac, along_bd)


def element_sets(mesh, array, wrong):
    """Sets of elements: name -> list of numbers in each block; from the file's sets or from an array of whole numbers"""
    sets = {
        name: [np.asarray(numbers if numbers is not None else [], dtype=int) for numbers in blocks]
        for name, blocks in mesh.cell_sets.items()
        if not name.startswith("gmsh:")
    }
    numbered = [
        name
        for name, blocks in mesh.cell_data.items()
        if all(np.asarray(b).ndim == 1 and np.asarray(b).dtype.kind in "iu" for b in blocks)
        and name != "gmsh:geometrical"
    ]
    if array and array not in numbered:
        wrong.append(
            f"--groups {array}: there is no array of whole numbers of that name; there are: {', '.join(numbered) or 'none'}"
        )
        return sets
    if not array and not sets and numbered:
        array = GMSH_PHYSICAL if GMSH_PHYSICAL in numbered else numbered[0]
        if len(numbered) > 1 and array != GMSH_PHYSICAL:
            wrong.append(f"several arrays could be groups: choose one with --groups: {', '.join(numbered)}")
    if array:
        names = names_of_numbers(mesh)
        for k, (block, values) in enumerate(zip(mesh.cells, mesh.cell_data[array], strict=True)):
            for value in np.unique(values):
                members = np.flatnonzero(values == value)
                for name in names.get((int(value), block.dim), [str(int(value))]):
                    sets.setdefault(name, [np.zeros(0, dtype=int) for _ in mesh.cells])
                    sets[name][k] = np.union1d(sets[name][k], members)
    return sets


def names_of_numbers(mesh):
    """Names of groups by number and dimension: gmsh has one a number, Salome's MED several"""
    names = {}
    for name, value in mesh.field_data.items():
        numbers = np.asarray(value).ravel()
        if numbers.shape == (2,) and numbers.dtype.kind in "iu":
            names[int(numbers[0]), int(numbers[1])] = [name]
    for number, texts in getattr(mesh, "cell_tags", {}).items():
        names |= {(int(number), dimension): list(texts) for dimension in (0, 1, 2)}
    return names


def outer_edges(triangles):
    """Edges that belong to one triangle alone (edges, 2)"""
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, number = np.unique(edges, axis=0, return_counts=True)
    return unique[number == 1], unique[number > 1]


def surfaces_of(sets, number, chosen, wrong):
    """Physical surfaces that cover every triangle once: those chosen, or all sets but such as hold others"""
    if chosen:
        wrong += [
            f"--surfaces {name}: there is no such set of triangles; there are: {', '.join(sets) or 'none'}"
            for name in chosen
            if name not in sets
        ]
        sets = {name: sets[name] for name in chosen if name in sets}
    elif len(sets) > 1:
        # A set of everything beside sets of parts
        whole = [name for name, members in sets.items() if len(members) == number]
        rest = {name: members for name, members in sets.items() if name not in whole}
        if rest and len(np.unique(np.concatenate(list(rest.values())))) == number:
            sets = rest
        elif whole and rest:
            wrong.append(
                f"sets {', '.join(rest)} lie in {whole[0]} and do not cover it; choose with --surfaces"
            )
    if not sets:
        return {SINGLE_SURFACE: np.arange(number)}
    times = np.bincount(np.concatenate(list(sets.values())), minlength=number)
    if (times == 0).any():
        wrong.append(
            f"{(times == 0).sum()} triangles are in no set, such as number {np.flatnonzero(times == 0)[0] + 1}"
        )
    if (times > 1).any():
        both = [name for name, members in sets.items() if np.isin(np.flatnonzero(times > 1)[0], members)]
        wrong.append(
            f"{(times > 1).sum()} triangles are in several sets ({', '.join(both)}); choose with --surfaces"
        )
    return sets


def to_plane(mesh, plane="xy", scale=1.0, surfaces=(), fractures=(), groups=None):
    """A mesh of the program from one of meshio; all that is wrong is said in one ResultsError"""
    wrong = []
    points = plane_coordinates(np.asarray(mesh.points, dtype=float), plane, scale, wrong)
    cells, places, notes = cells_of(mesh, points, wrong)
    if wrong:
        raise ResultsError("\n".join(wrong))
    by_kind = {"triangle": {}, "line": {}, "vertex": {}}
    for name, blocks in element_sets(mesh, groups, wrong).items():
        for (kind, rows), numbers in zip(places, blocks, strict=True):
            if kind and len(numbers):
                by_kind[kind].setdefault(name, []).append(rows[numbers].ravel())
    sets = {
        kind: {n: np.unique(np.concatenate(v)) for n, v in found.items()} for kind, found in by_kind.items()
    }
    made = Plane(
        points,
        cells["triangle"],
        surfaces_of(sets["triangle"], len(cells["triangle"]), surfaces, wrong),
        {name: cells["line"][numbers] for name, numbers in sets["line"].items()},
        {name: np.unique(cells["vertex"][numbers]) for name, numbers in sets["vertex"].items()},
        notes,
    )
    add_node_sets(
        made,
        {name: np.asarray(nodes, dtype=int) for name, nodes in mesh.point_sets.items()},
        fractures,
        wrong,
    )
    check_lines(made, wrong)
    drop_unused(made)
    if wrong:
        raise ResultsError("\n".join(wrong))
    return made


def add_node_sets(made, node_sets, fractures, wrong):
    """Points and curves from sets of nodes: edges of the outer boundary; inner edges for the sets that are fractures"""
    outer, inner = outer_edges(made.triangles)
    known = [*node_sets, *made.lines]
    wrong += [
        f"--fracture {name}: there is no such set; there are: {', '.join(known) or 'none'}"
        for name in fractures
        if name not in known
    ]
    for name, nodes in node_sets.items():
        if name.startswith("gmsh:"):
            continue
        nodes = nodes[np.isin(nodes, made.triangles)]  # not those in the middle of edges that were quadratic
        candidates = inner if name in fractures else outer
        lines = candidates[np.isin(candidates, nodes).all(axis=1)]
        if name in fractures and not len(lines):
            wrong.append(f"--fracture {name}: no inner edge has both its ends in this set")
        if len(lines) and name not in made.lines:
            made.lines[name] = lines
        # A curve holds its nodes by itself
        if name not in fractures and not np.isin(nodes, lines).all():
            made.nodes[name] = np.union1d(made.nodes.get(name, np.zeros(0, dtype=int)), nodes)


def check_lines(made, wrong):
    """Every line is an edge of triangles and in one group"""
    outer, inner = outer_edges(made.triangles)
    edges = {tuple(edge) for edge in np.vstack([outer, inner]).tolist()}
    owner, twice, off = {}, Counter(), Counter()
    for name, lines in made.lines.items():
        for line in map(tuple, np.sort(lines, axis=1).tolist()):
            if line not in edges:
                off[name] += 1
            if owner.setdefault(line, name) != name:
                twice[owner[line], name] += 1
    wrong += [f"{number} lines of {name!r} are no edges of triangles" for name, number in off.items()]
    wrong += [
        f"{number} lines are both in {a!r} and in {b!r}; a line has one group"
        for (a, b), number in twice.items()
    ]


def drop_unused(made):
    """Leave out points that no triangle uses, and say so"""
    used = np.unique(made.triangles)
    if len(used) == len(made.points):
        return
    made.notes.append(f"{len(made.points) - len(used)} points that no triangle uses are left out")
    number = np.full(len(made.points), -1)
    number[used] = np.arange(len(used))
    made.points, made.triangles = made.points[used], number[made.triangles]
    made.lines = {name: number[lines] for name, lines in made.lines.items()}
    made.nodes = {name: number[nodes][number[nodes] >= 0] for name, nodes in made.nodes.items()}
    made.nodes = {name: nodes for name, nodes in made.nodes.items() if len(nodes)}


def write(made, path):
    """Write a gmsh file of format 2.2 in text: meshio's own has one tag a name, and a name may be of a curve and of points"""
    named, rows = [], []
    for kind, groups in (("point", made.nodes), ("line", made.lines), ("triangle", made.surfaces)):
        for name, members in groups.items():
            tag = len(named) + 1
            named.append((DIMENSION[kind], tag, name))
            cells = made.triangles[members] if kind == "triangle" else np.asarray(members)
            rows += [(GMSH[kind], tag, (np.atleast_1d(cell) + 1).tolist()) for cell in cells]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(named))]
    text += [f'{dimension} {tag} "{name}"' for dimension, tag, name in named]
    text += ["$EndPhysicalNames", "$Nodes", str(len(made.points))]
    text += [f"{k} {x!r} {y!r} 0" for k, (x, y) in enumerate(made.points.tolist(), start=1)]
    text += ["$EndNodes", "$Elements", str(len(rows))]
    for k, (kind, tag, nodes) in enumerate(rows, start=1):
        text.append(f"{k} {kind} 2 {tag} {tag} {' '.join(map(str, nodes))}")
    Path(path).write_text("\n".join([*text, "$EndElements", ""]), encoding="utf-8")


def summary(made, path):
    """What was written, for the reader"""
    low, high = made.points.min(axis=0), made.points.max(axis=0)
    lines = [f"note: {note}" for note in made.notes]
    lines.append(
        f"{path}: {len(made.points)} nodes, {len(made.triangles)} triangles, {high[0] - low[0]:g} m by {high[1] - low[1]:g} m"
    )
    for kind, groups in (("surface", made.surfaces), ("curve", made.lines), ("points", made.nodes)):
        unit = {"surface": "triangles", "curve": "edges", "points": "nodes"}[kind]
        lines += [f"  {kind:8s} '{name}': {len(members)} {unit}" for name, members in groups.items()]
    return "\n".join(lines)
