"""Run a scene (mesh script, deck, program) and compare quantities of its history with references.

A scene is a folder with a case.toml; tests/scenes/_template/case.toml explains every key.
"""

import csv
import importlib.util
import math
import os
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parent.parent
SCENES = TOP / "tests" / "scenes"
MARKS = ("fast", "normal", "long")
CASE_KEYS = {"title", "mark", "from", "mesh", "deck", "arguments", "timeout", "status", "check"}
CHECK_KEYS = {"quantity", "reference", "tolerance", "relative_tolerance", "why"}
DEFAULT_TIMEOUT = 300


class SceneError(Exception):
    """A scene that cannot be run, or a quantity that cannot be computed."""


@dataclass
class Check:
    """One quantity and what it must be."""

    quantity: str
    reference: float
    tolerance: float
    why: str


@dataclass
class Case:
    """A scene's case.toml, checked."""

    folder: Path
    title: str
    mark: str
    sources: list
    mesh: list
    deck: str
    arguments: list
    timeout: float
    status: int
    checks: list

    @property
    def name(self):
        return self.folder.name


def find_cases(scenes=SCENES):
    """All scenes, by name; folders that start with an underscore are no scenes."""
    files = sorted(path for path in scenes.glob("*/case.toml") if not path.parent.name.startswith("_"))
    return [read_case(path) for path in files]


def read_case(path):
    """Read and check a case.toml; all it has wrong is reported together."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    wrong = [f"unknown key '{key}'" for key in data if key not in CASE_KEYS]
    wrong += [f"no '{key}'" for key in ("title", "mark", "deck") if key not in data]
    if data.get("mark") not in MARKS:
        wrong.append(f"mark must be one of {', '.join(MARKS)}")
    checks = []
    for number, entry in enumerate(data.get("check", []), start=1):
        wrong += [f"check {number}: unknown key '{key}'" for key in entry if key not in CHECK_KEYS]
        wrong += [
            f"check {number}: no '{key}'" for key in ("quantity", "reference", "why") if key not in entry
        ]
        if ("tolerance" in entry) == ("relative_tolerance" in entry):
            wrong.append(f"check {number}: needs tolerance or relative_tolerance")
        if not wrong:
            reference = evaluate(entry["reference"], {})
            tolerance = evaluate(entry.get("tolerance", 0.0), {})
            tolerance += abs(reference) * evaluate(entry.get("relative_tolerance", 0.0), {})
            checks.append(Check(entry["quantity"], reference, tolerance, entry["why"]))
    sources = [data["from"]] if isinstance(data.get("from"), str) else data.get("from", [])
    folders = [path.parent, *(TOP / source for source in sources)]
    if not data.get("check") and not any((folder / "check.py").exists() for folder in folders):
        wrong.append("nothing is checked: no [[check]] and no check.py")
    if wrong:
        raise SceneError(f"{path}: " + "; ".join(wrong))
    return Case(
        folder=path.parent,
        title=data["title"],
        mark=data["mark"],
        sources=sources,
        mesh=[data["mesh"]] if isinstance(data.get("mesh"), str) else data.get("mesh", []),
        deck=data["deck"],
        arguments=data.get("arguments", []),
        timeout=data.get("timeout", DEFAULT_TIMEOUT),
        status=data.get("status", 0),
        checks=checks,
    )


def run_case(case, femdem, workspace):
    """Run a scene in a copy of its folder; the results directory."""
    folder = Path(workspace) / case.name
    if folder.exists():
        shutil.rmtree(folder)
    for source in [TOP / name for name in case.sources] + [case.folder]:
        shutil.copytree(source, folder, dirs_exist_ok=True)
    if case.mesh:
        run_command(mesh_command(case.mesh), folder, case.timeout, expected_status=0)
    results = folder / "results"
    command = [femdem, *case.arguments, "--output", results, case.deck]
    run_command(command, folder, case.timeout, expected_status=case.status)
    return results


def mesh_command(words):
    """A script of the scene, or a command of the Python package: femdem-mesh ..."""
    if words[0].startswith("femdem-"):
        return [sys.executable, "-m", "femdem", words[0].removeprefix("femdem-"), *words[1:]]
    return [sys.executable, *words]


def run_command(command, folder, timeout, expected_status):
    command = [str(word) for word in command]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join([str(TOP / "postproc"), str(TOP / "tests")]))
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False
        )
    except subprocess.TimeoutExpired as late:
        raise SceneError(f"{' '.join(command)}\n  in {folder}: not done after {timeout} s") from late
    (folder / "output.txt").write_text(done.stdout + done.stderr, encoding="utf-8")
    if done.returncode != expected_status:
        end = "\n".join((done.stdout + done.stderr).splitlines()[-20:])
        message = f"status {done.returncode}, expected {expected_status}"
        raise SceneError(f"{' '.join(command)}\n  in {folder}: {message}\n{end}")


def complaints_about(case, results):
    """What in the results is not as the case wants it: one text each, none when all is well."""
    complaints = []
    history = read_history(results / "history.csv") if case.checks else {}
    for check in case.checks:
        try:
            found = float(evaluate(check.quantity, history))
        except (SceneError, TypeError, ValueError) as error:
            complaints.append(f"{check.quantity}: {error}")
            continue
        # A NaN compares false with everything: ask for what is right, not for what is wrong.
        if not abs(found - check.reference) <= check.tolerance:
            complaints.append(
                f"{check.quantity}: expected {check.reference:.6g} within {check.tolerance:.3g}, "
                f"found {found:.6g} ({check.why})"
            )
    # In the copy a check.py may also come from another scene, by way of `from`
    if (results.parent / "check.py").exists():
        try:
            load_check(results.parent / "check.py").check(results)
        except AssertionError as error:
            complaints.append(f"check.py: {error}")
    return complaints


def load_check(path):
    """The scene's own check.py as a module."""
    specification = importlib.util.spec_from_file_location(f"check_{path.parent.name}", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def read_history(path):
    """Columns of a history.csv by name, as arrays; lines that start with # are comments."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if line.strip() and not line.startswith("#")))
    if len(rows) < 2:
        raise SceneError(f"{path} has no rows")
    columns = zip(*rows[1:], strict=True)
    return {
        name.strip(): np.array(column, dtype=float) for name, column in zip(rows[0], columns, strict=True)
    }


def evaluate(expression, columns):
    """Value of a quantity: a number, or an expression of column names and the functions below.

    Column names hold dots, so they are replaced by plain names first, the longest first.
    """
    if not isinstance(expression, str):
        return float(expression)
    names = {}
    text = expression
    for number, column in enumerate(sorted(columns, key=len, reverse=True)):
        pattern = rf"(?<![\w.]){re.escape(column)}(?![\w.])"
        text, count = re.subn(pattern, f"column_{number}", text)
        if count:
            names[f"column_{number}"] = columns[column]
    functions = {
        "first": lambda x: x[0],
        "last": lambda x: x[-1],
        "largest": np.max,
        "smallest": np.min,
        "mean": np.mean,
        # y where x first reaches a value, by linear interpolation between rows
        "where": value_where,
        **{
            name: getattr(np, name) for name in ("sqrt", "abs", "exp", "log10", "sin", "cos", "tan", "arctan")
        },
        "radians": np.radians,
        "degrees": np.degrees,
        "pi": math.pi,
        "__builtins__": {},
    }
    try:
        return eval(text, functions, names)  # the expression is a file of this repository
    except (NameError, SyntaxError, AttributeError, IndexError) as error:
        known = f"; columns are {', '.join(columns)}" if columns else ""
        raise SceneError(f"cannot compute '{expression}': {error}{known}") from error


def value_where(y, x, value):
    """y at the first place where x passes the given value."""
    side = np.sign(x - value)
    here = np.flatnonzero(side == 0)
    crossings = np.flatnonzero(side[:-1] * side[1:] < 0)
    if here.size and (not crossings.size or here[0] <= crossings[0]):
        return y[here[0]]
    if not crossings.size:
        raise SceneError(f"the column never reaches {value}")
    i = crossings[0]
    return y[i] + (y[i + 1] - y[i]) * (value - x[i]) / (x[i + 1] - x[i])
