"""Readers of a results directory: history, fields, block edges, provenance and the effective deck.

    results = Results("results")
    u = results.history["joint.shear_displacement_mm"]
    stress = results.fields.read("stress_xx", step=-1)
    print(results.fields.provenance["commit"])

Numbers of nodes, triangles, joints and groups start at 0, block edges at 1. All can be read while the run goes on.
"""

import csv
import io
import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

# The run writes without locks; a reader must not leave one either.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
import h5py


class ResultsError(Exception):
    """Something asked for is not in the results; the message says what is."""


def _table(path):
    """Names and columns of a CSV file; a last row that is being written is left out."""
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: there is no such file; is {path.parent} a results directory?")
    with path.open(newline="", encoding="utf-8") as file:
        text = file.read()
    complete = text[: text.rfind("\n") + 1]
    rows = list(csv.reader(io.StringIO(complete, newline="")))
    if not rows:
        raise ResultsError(f"{path}: the file is empty")
    names = [name.strip() for name in rows[0]]
    rows = [row for row in rows[1:] if len(row) == len(names)]
    return names, [[row[i] for row in rows] for i in range(len(names))]


class History:
    """history.csv: `history["time_s"]`, `history.joint("G", "shear_stress_MPa")`."""

    def __init__(self, path):
        self.path = Path(path)
        names, columns = _table(path)
        self.columns = names
        self._data = {
            name: np.array([float(value) for value in column])
            for name, column in zip(names, columns, strict=True)
        }

    def __len__(self):
        return len(self._data[self.columns[0]])

    def __contains__(self, name):
        return name in self._data

    def __getitem__(self, name):
        if name not in self._data:
            raise ResultsError(f"{self.path}: no column {name!r}; there are: {', '.join(self.columns)}")
        return self._data[name]

    @property
    def groups(self):
        """Names of the joint groups"""
        suffix = ".shear_displacement_mm"
        return [name[: -len(suffix)] for name in self.columns if name.endswith(suffix)]

    def group(self, name=None):
        """The group asked for, or the only one"""
        if not self.groups:
            raise ResultsError(f"{self.path}: the run has no joints")
        if name is None:
            if len(self.groups) > 1:
                raise ResultsError(
                    f"{self.path}: several joint groups, choose one with --group: {', '.join(self.groups)}"
                )
            return self.groups[0]
        if name not in self.groups:
            raise ResultsError(f"{self.path}: no joint group {name!r}; there are: {', '.join(self.groups)}")
        return name

    def joint(self, group, quantity):
        """Column of a joint group"""
        return self[f"{group}.{quantity}"]

    def to_pandas(self):
        """The table as a pandas.DataFrame"""
        from femdem import exports

        return exports.history_frame(self)


@dataclass
class Edges:
    """edges.csv: one entry a block edge in each array."""

    id: np.ndarray
    group: np.ndarray
    joints: np.ndarray
    length_m: np.ndarray
    mean_shear_displacement_mm: np.ndarray
    largest_shear_displacement_mm: np.ndarray
    mean_aperture_mm: np.ndarray
    largest_aperture_mm: np.ndarray
    path: Path | None = None

    @classmethod
    def names(cls):
        """Names of the columns"""
        return [name for name in cls.__dataclass_fields__ if name != "path"]

    @classmethod
    def read(cls, path):
        names, columns = _table(path)
        table = dict(zip(names, columns, strict=True))
        missing = [name for name in cls.names() if name not in table]
        if missing:
            raise ResultsError(f"{path}: no column {', '.join(missing)}")
        return cls(
            **{
                name: np.array(table[name])
                if name == "group"
                else np.array(table[name], dtype=int if name in ("id", "joints") else float)
                for name in cls.names()
            },
            path=Path(path),
        )

    @classmethod
    def at(cls, fields, step, last):
        """The block edges at a snapshot; numbers, groups and lengths are those of the last output"""
        mesh = fields.mesh(step)
        lines = mesh.joint_lines
        length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
        number = len(last)
        inside = mesh.block_edge > 0
        place = mesh.block_edge[inside] - 1
        whole = np.bincount(place, weights=length[inside], minlength=number)
        found = {}
        for name in ("shear_displacement_mm", "aperture_mm"):
            values = np.abs(fields.read(name, step))[inside]
            found[f"mean_{name}"] = (
                np.bincount(place, weights=length[inside] * values, minlength=number) / whole
            )
            largest = np.full(number, -np.inf)
            np.maximum.at(largest, place, values)
            found[f"largest_{name}"] = largest
        return cls(last.id, last.group, last.joints, last.length_m, **found, path=last.path)

    def __len__(self):
        return len(self.id)

    def columns(self):
        """The columns by name"""
        return {name: getattr(self, name) for name in self.names()}

    def mesh(self):
        """The mesh whose block edges these are: that of the last snapshot in the same directory"""
        if self.path is None:
            raise ResultsError(
                "these block edges were not read from a results directory: their mesh is not known"
            )
        return Fields(self.path.with_name("fields.h5")).mesh()

    def to_pandas(self):
        """The table as a pandas.DataFrame, the number of the block edge as its index"""
        from femdem import exports

        return exports.edges_frame(self)

    def to_geopandas(self, crs=None):
        """The same with the line of each block edge, as a geopandas.GeoDataFrame

        crs: coordinate system of the mesh, such as 'EPSG:2056'
        """
        from femdem import exports

        return exports.edges_geoframe(self, crs)


# Fields that say what was taken out, and arrays of the mesh with an entry for each triangle or joint
REMOVED = {"triangles": "removed", "joints": "joint_removed"}
OF_PLACE = {
    "triangles": "triangles",
    "triangle_group": "triangles",
    "joints": "joints",
    "joint_group": "joints",
    "block_edge": "joints",
}


@dataclass
class Mesh:
    """The mesh of a snapshot."""

    coordinates: np.ndarray  # (nodes, 2) m
    triangles: np.ndarray  # (triangles, 3)
    triangle_group: np.ndarray
    joints: np.ndarray  # (joints, 4) A, B on the lower wall, A', B' on the upper
    joint_group: np.ndarray
    block_edge: np.ndarray
    surface: np.ndarray  # (surface edges, 2)
    surface_joint: np.ndarray  # in the file's numbers, which count joints that were taken out too
    group_name: list = field(default_factory=list)

    @property
    def joint_lines(self):
        """Mid-lines of the joints (joints, 2 ends, 2 coordinates) [m]"""
        x = self.coordinates
        return 0.5 * (x[self.joints[:, :2]] + x[self.joints[:, 2:]])


class Fields:
    """fields.h5: `fields.read("displacement", step=-1)`, `fields.mesh()`, `fields.times`, `fields.provenance`."""

    def __init__(self, path):
        self.path = Path(path)
        if not self.path.is_file():
            raise ResultsError(f"{self.path}: there is no such file")
        try:
            with h5py.File(self.path, "r") as file:
                self.provenance = {name: _plain(value) for name, value in file.attrs.items()}
                self.steps = sorted(name for name in file if name.startswith("step_"))
                self.times = np.array([file[name].attrs["time_s"] for name in self.steps])
                self.stages = [_plain(file[name].attrs["stage"]) for name in self.steps]
                self.cycles = np.array([file[name].attrs["cycle"] for name in self.steps], dtype=int)
        except (OSError, RuntimeError, KeyError) as error:
            raise ResultsError(f"{self.path}: cannot be read ({error}){self._half_way()}") from error

    def _half_way(self):
        """What to do about a file that a run was closing when it was killed"""
        if not self.path.with_name(self.path.name + ".writing").exists():
            return ""
        return "; a run was writing it when it was killed: when that goes on (--restart) all that was complete in it is kept"

    def open(self):
        """The file, for reading"""
        try:
            return h5py.File(self.path, "r")
        except OSError as error:
            raise ResultsError(f"{self.path}: cannot be read ({error})") from error

    def _step(self, step):
        if not self.steps:
            raise ResultsError(f"{self.path}: no snapshot yet")
        try:
            return self.steps[step]
        except IndexError:
            raise ResultsError(f"{self.path}: no snapshot {step}; there are {len(self.steps)}") from None

    def _mesh_group(self, file, step):
        if not self.steps and step == -1:
            return "mesh"
        return _plain(file[self._step(step)].attrs["mesh"])

    def names(self, step=-1):
        """Fields of a snapshot and of its mesh: name -> (place, unit, description)"""
        with self.open() as file:
            found = {}
            groups = [file[self._mesh_group(file, step)]]
            if self.steps:
                groups.append(file[self._step(step)])
            for group in groups:
                for name, dataset in group.items():
                    if "place" in dataset.attrs:
                        attrs = dataset.attrs
                        found[name] = tuple(_plain(attrs[key]) for key in ("place", "unit", "description"))
            return found

    def _there(self, file, step, place):
        """Triangles or joints of a snapshot that have not been taken out; all of any other place"""
        name = REMOVED.get(place, "")
        if not (self.steps and name) or name not in file[self._step(step)]:
            return slice(None)
        return file[self._step(step)][name][...] < 0.5

    def read(self, name, step=-1):
        """A field of a snapshot (by position, -1: the last); vectors as (entities, 2)

        Rock that was taken out is left out; `removed` and `joint_removed` say which triangles and joints of the file that is.
        """
        known = self.names(step)
        if name not in known:
            raise ResultsError(f"{self.path}: no field {name!r}; there are: {', '.join(sorted(known))}")
        with self.open() as file:
            group = file[self._step(step)] if self.steps else None
            if group is None or name not in group:
                group = file[self._mesh_group(file, step)]
            values = group[name][...]
            if name not in REMOVED.values():
                values = values[self._there(file, step, known[name][0])]
        return values[:, :2] if values.ndim == 2 else values

    def mesh_name(self, step=-1):
        """Group of the mesh of a snapshot; the same as long as nothing breaks"""
        with self.open() as file:
            return self._mesh_group(file, step).strip("/")

    def to_pyvista(self, step=-1):
        """A snapshot as a pyvista.MultiBlock with the blocks 'rock' and 'joints'"""
        from femdem import exports

        return exports.multiblock(self, step)

    def mesh(self, step=-1):
        """The mesh of a snapshot, without what was taken out of it"""
        with self.open() as file:
            group = file[self._mesh_group(file, step)]
            arrays = {name: group[name][...] for name in Mesh.__dataclass_fields__ if name != "group_name"}
            for name, place in OF_PLACE.items():
                arrays[name] = arrays[name][self._there(file, step, place)]
            return Mesh(**arrays, group_name=[_plain(name) for name in group["group_name"][...]])


def _plain(value):
    """Text of an attribute, or its number"""
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if isinstance(value, np.generic) else value


# ---- The effective deck -------------------------------------------------------------------------------------------


def parse_deck(text):
    """Groups of a deck in its order: [(name, {variable: value}), ...]; names in lower case."""
    groups, current = [], None
    for line in text.splitlines():
        line = _without_comment(line).strip()
        if not line:
            continue
        if line.startswith("&"):
            name, _, line = line[1:].partition(" ")
            current = (name.lower(), {})
            groups.append(current)
        if current is None:
            continue
        for piece in _pieces(line):
            if piece == "/":
                current = None
                break
            key, separator, value = piece.partition("=")
            if separator:
                current[1][key.strip().lower()] = _value(value.strip())
    return groups


def _without_comment(line):
    """The line up to an exclamation mark outside quotes"""
    quote = ""
    for i, letter in enumerate(line):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter == "!":
            return line[:i]
    return line


def _pieces(line):
    """Parts between commas, and the slash that ends a group, outside quotes"""
    piece, quote = "", ""
    for letter in line:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in ",/":
            if piece.strip():
                yield piece.strip()
            piece = ""
            if letter == "/":
                yield "/"
                return
            continue
        piece += letter
    if piece.strip():
        yield piece.strip()


def _value(text):
    if text[:1] in ("'", '"'):
        quote = text[0]
        return text[1:-1].replace(2 * quote, quote).rstrip()
    if text.lower() in (".true.", "t", "true"):
        return True
    if text.lower() in (".false.", "f", "false"):
        return False
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text.lower().replace("d", "e"))
    except ValueError:
        return text


class Deck:
    """The effective deck deck.nml."""

    def __init__(self, path):
        self.path = Path(path)
        if not self.path.is_file():
            raise ResultsError(f"{self.path}: there is no effective deck beside the results")
        self.groups = parse_deck(self.path.read_text(encoding="utf-8"))

    def all(self, name):
        """Every group of that name"""
        return [variables for group, variables in self.groups if group == name]

    def joint(self, group):
        """The &joint group of a joint group of the mesh"""
        for variables in self.all("joint"):
            if variables.get("group") == group:
                return variables
        raise ResultsError(f"{self.path}: no &joint with group = {group!r}")

    @property
    def title(self):
        run = self.all("run")
        return str(run[0].get("title", "")) if run else ""


class Results:
    """A results directory; files are read when asked for."""

    def __init__(self, directory):
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise ResultsError(f"{self.directory}: there is no such directory")

    @property
    def history(self):
        return History(self.directory / "history.csv")

    @property
    def fields(self):
        return Fields(self.directory / "fields.h5")

    @property
    def edges(self):
        return Edges.read(self.directory / "edges.csv")

    @property
    def deck(self):
        return Deck(self.directory / "deck.nml")

    @property
    def label(self):
        """What to call the run in a legend"""
        try:
            return self.deck.title or self.directory.name
        except ResultsError:
            return self.directory.name

    def reference_joint(self, group, length=None, cycle=None):
        """The joint law of a group with the properties of the deck, for curves to compare with.

        The effective length is the one given, else that of the group's block edges, which must then be equal
        (law = 'jcm_mean': the mean length of all block edges). The closure is that of the loading cycle given, else of
        the deck's; of a joint that goes through the cycles it must be given.
        """
        from femdem.jcm import Joint

        deck = self.deck.joint(group)
        law = deck.get("law", "jcm")
        if law not in ("jcm", "jcm_mean"):
            raise ResultsError(
                f"{self.deck.path}: group {group!r} follows law = {law!r}, not the empirical law"
            )
        if length is None:
            edges = self.edges
            lengths = edges.length_m[edges.group == group] if law == "jcm" else edges.length_m
            if len(lengths) == 0:
                raise ResultsError(f"{self.directory / 'edges.csv'}: no block edge of group {group!r}")
            if law == "jcm" and np.ptp(lengths) > 1e-6 * np.max(lengths):
                raise ResultsError(
                    f"group {group!r} has block edges from {lengths.min():.4g} to {lengths.max():.4g} m: "
                    "no one length to compare with; give it with --length"
                )
            length = float(np.mean(lengths))
        missing = [name for name in ("jrc0", "jcs0_mpa", "l0", "phi_r") if name not in deck]
        if missing:
            raise ResultsError(f"{self.deck.path}: &joint of {group!r} lacks {', '.join(missing)}")
        cycle = cycle or deck.get("closure_cycle", 3)
        if cycle == "hysteresis":
            raise ResultsError(
                f"{self.deck.path}: the closure of {group!r} goes through the loading cycles: no one curve to compare "
                "with; femdem-plot cycles draws them"
            )
        defaults = {"peak": "eq15", "post_peak": "table", "short_edges": "extrapolate", "max_angle": 70.0}
        return Joint(
            jrc0=deck["jrc0"],
            jcs0=deck["jcs0_mpa"],
            l0=deck["l0"],
            phi_r=deck["phi_r"],
            length=length,
            a0=deck.get("a0_mm"),
            sigma_c=deck.get("sigma_c_mpa"),
            closure_cycle=int(cycle),
            **{name: deck.get(name, value) for name, value in defaults.items()},
        )
