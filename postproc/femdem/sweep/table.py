"""Tables of parameters: lists in CSV files; lists, grids and Latin hypercubes in YAML files.

A parameter is a variable of the deck, GROUP.VARIABLE or GROUP[NAME].VARIABLE, or an argument of the mesh script, mesh.ARGUMENT.
"""

import csv
import itertools
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from femdem.results import ResultsError

KINDS = ("list", "grid", "latin")
KEYS = {"kind", "parameters", "rows", "samples", "seed", "collect"}


@dataclass
class Table:
    """Rows of parameters, and what to collect: name -> specification."""

    rows: list
    collect: dict = field(default_factory=dict)


def read_table(path):
    """Read a CSV or YAML file"""
    path = Path(path)
    if not path.is_file():
        raise ResultsError(f"{path}: there is no such file")
    if path.suffix.lower() == ".csv":
        table = Table(read_csv(path))
    elif path.suffix.lower() in (".yaml", ".yml"):
        table = read_yaml(path)
    else:
        raise ResultsError(f"{path}: a table of parameters ends in .csv, .yaml or .yml")
    if not table.rows:
        raise ResultsError(f"{path}: it has no rows")
    return table


def read_csv(path):
    """A header of parameters, and a run a row"""
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    if not rows:
        raise ResultsError(f"{path}: the file is empty")
    names = [name.strip() for name in rows[0]]
    wrong = [f"{path}: {name!r} is there twice" for name in set(names) if names.count(name) > 1]
    wrong += [
        f"{path}: row {k} has {len(row)} values for {len(names)} names"
        for k, row in enumerate(rows[1:], start=1)
        if len(row) != len(names)
    ]
    if wrong:
        raise ResultsError("\n".join(wrong))
    return [dict(zip(names, (value.strip() for value in row), strict=True)) for row in rows[1:]]


def read_yaml(path):
    """kind: list, grid or latin; parameters; what to collect"""
    try:
        import yaml
    except ImportError as error:
        raise ResultsError(
            f"{path}: Python has no module {error.name}; the extra 'sweep' brings it: pip install './postproc[sweep]'"
        ) from error
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ResultsError(f"{path}: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict):
        raise ResultsError(f"{path}: it must hold kind: and parameters:")
    wrong = [f"unknown key {key!r}; there are: {', '.join(sorted(KEYS))}" for key in data if key not in KEYS]
    kind = data.get("kind", "list" if "rows" in data else "grid")
    if kind not in KINDS:
        wrong.append(f"kind: {kind!r} must be one of {', '.join(KINDS)}")
    if kind == "list" and not isinstance(data.get("rows"), list):
        wrong.append("kind: list needs rows:, a list of {parameter: value}")
    if kind != "list" and not isinstance(data.get("parameters"), dict):
        wrong.append(f"kind: {kind} needs parameters:, parameter: values")
    if not isinstance(data.get("collect", {}), dict):
        wrong.append("collect: must be name: what")
    if not wrong:
        try:
            rows = {"list": listed, "grid": grid, "latin": latin}[kind](data)
            return Table(rows, {str(k): str(v) for k, v in data.get("collect", {}).items()})
        except ResultsError as error:
            wrong = str(error).splitlines()
    raise ResultsError("\n".join(f"{path}: {text}" for text in wrong))


def listed(data):
    """Rows as they are"""
    if not all(isinstance(row, dict) for row in data["rows"]):
        raise ResultsError("rows: each must be {parameter: value, ...}")
    return data["rows"]


def grid(data):
    """Every combination of values, the last parameter running fastest"""
    values = [values_of(name, what) for name, what in data["parameters"].items()]
    return [dict(zip(data["parameters"], row, strict=True)) for row in itertools.product(*values)]


def values_of(name, what):
    """Values of a parameter of a grid: a list, one value, from-to-step or low-high-number"""
    if isinstance(what, list):
        return what
    if not isinstance(what, dict):
        return [what]
    if {"from", "to"} <= set(what) <= {"from", "to", "step"}:
        start, end, step = what["from"], what["to"], what.get("step", 1)
        if not step > 0 or end < start:
            raise ResultsError(f"{name}: from {start} to {end} in steps of {step} has no values")
        number = math.floor((end - start) / step * (1 + 1e-12) + 1e-9) + 1
        return [start + k * step for k in range(number)]
    if {"low", "high", "number"} <= set(what) <= {"low", "high", "number", "scale"}:
        return [scaled(name, what, u) for u in np.linspace(0.0, 1.0, what["number"])]
    raise ResultsError(
        f"{name}: a grid has a list of values, {{from, to, step}} or {{low, high, number, scale: linear or log}}"
    )


def scaled(name, what, share):
    """Value at a share, 0 to 1, of a range"""
    low, high, scale = what["low"], what["high"], what.get("scale", "linear")
    if scale == "log" and low > 0.0 and high > 0.0:
        return float(low * (high / low) ** share)
    if scale != "linear":
        raise ResultsError(f"{name}: scale {scale!r} must be linear, or log with low and high above 0")
    return float(low + share * (high - low))


def latin(data):
    """A Latin hypercube: each parameter's range in as many parts as there are samples, one sample in each"""
    from scipy.stats import qmc

    samples, seed = data.get("samples"), data.get("seed", 0)
    if not isinstance(samples, int) or samples < 1:
        raise ResultsError(f"samples: {samples!r} must be a whole number, 1 or more")
    points = qmc.LatinHypercube(d=len(data["parameters"]), seed=seed).random(samples)
    rows = []
    for point in points:
        row = {}
        for (name, what), share in zip(data["parameters"].items(), point, strict=True):
            if isinstance(what, list):
                row[name] = what[min(int(share * len(what)), len(what) - 1)]
            elif isinstance(what, dict) and {"low", "high"} <= set(what) <= {"low", "high", "scale"}:
                row[name] = scaled(name, what, float(share))
            else:
                raise ResultsError(
                    f"{name}: kind: latin has a list of choices or {{low, high, scale: linear or log}}"
                )
        rows.append(row)
    return rows
