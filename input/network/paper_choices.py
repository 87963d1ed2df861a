#!/usr/bin/env python3
"""Slip of the network with the paper's own numerics, against the time that the stresses of phase II-B are held.

    python3 paper_choices.py [--cases paper slider ...] [--models jcm jcm_mean coulomb] [--results DIR]

Each run is paper_choices.nml with values changed. Meshes, decks and results go to DIR (results/network/paper_choices), with
slip_against_time.csv (a row a cycle of each run), summary.csv (a row a run) and the figure. Runs that are there already are
kept (--again repeats them). The whole takes about 40 minutes on one core; the implicit case a few seconds.

  paper       potential contact, 20 E, friction against the velocity (eq 4), held for 40 ms
  slider      the same with friction by spring and slider
  sudden      the slider's with phase II-B as one ramp of 0.5 ms in place of ten: waves overshoot the stresses
  more_stress the slider's with 18 MPa in place of 15 MPa
  steep       the paper's with a friction angle of 60 degrees (Model-II): the creep stays
  half_step   the paper's with half the time step (JCM and Model-II)
  finer       the paper's with elements of 40 mm in place of 60 mm (JCM and Model-II)
  everywhere  the paper's with a cohesive joint on every edge, in rock that can break, at its own step
  held_everywhere  the slider's with joints everywhere (JCM and Model-II)
  implicit    wall contact with the joint's own stiffness, spring and slider, implicit solver
"""

import argparse
import csv
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
TOP = HERE.parent.parent
sys.path.insert(0, str(TOP / "postproc"))
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from femdem.figures import maps, style  # noqa: E402
from femdem.network.run_network import CRACKS, MODELS  # noqa: E402
from femdem.places import environment, module, program  # noqa: E402

DECK = HERE / "paper_choices.nml"
TRACES = HERE / "two_sets.csv"
MESH = "mesh = 'two_sets_60mm.msh'"
HELD = "name = 'held', cycles = 20"
SHORT = (HELD, "name = 'held', cycles = 5")
LOADED = "name = 'phase_2b', cycles = 10, move_time = 5e-4, rest_time = 5e-4"
SUDDEN = "name = 'phase_2b', move_time = 5e-4, rest_time = 9.5e-3"
STEP = "scaled_step = 5.3e-7"
SCALED = f", mass_scaling = 'step', {STEP}"
EXPLICIT = f"&explicit damping = 'viscous'{SCALED} /\n"
EQ_4 = "friction = 'velocity'"
WALLS_OF_PAPER = f"contact = 'potential', normal = 'penalty', {EQ_4}, normal_stress = 'walls'"
WALLS_OF_OURS = "contact = 'wall', normal = 'joint', friction = 'slider', normal_stress = 'contact'"
END = "fields_every = 1 /\n"
EVERYWHERE = CRACKS.replace("group = 'rock'", "group = 'rock', insertion = 'everywhere'")
MS, MM_S = 1e3, 1e3  # of a second; of a mm/ms
# Panels of the figure, a style of line a case
PANELS = (("paper", "half_step"), ("everywhere", "finer"), ("slider", "sudden", "more_stress"))
LINES = ("-", ":", "-.")
COMMON = 10.0  # ms: what all explicit cases are held for
CREEP_FROM = 0.5  # the creep is that of the last part of the time held


@dataclass(frozen=True)
class Case:
    """What differs from the deck: changes of its text, element size [m], joint models"""

    label: str
    changes: tuple = ()
    size: float = 0.06
    models: tuple = MODELS


CASES = {
    "paper": Case("eq 4"),
    "slider": Case("slider", ((EQ_4, "friction = 'slider'"),)),
    "sudden": Case("slider, sudden", ((EQ_4, "friction = 'slider'"), (LOADED, SUDDEN), SHORT)),
    "more_stress": Case(
        "slider, 18 MPa", ((EQ_4, "friction = 'slider'"), ("sxx = 15e6", "sxx = 18e6"), SHORT)
    ),
    "steep": Case(
        "eq 4, 60 degrees", (("phi_r = 31", "phi_r = 31, friction_angle = 60"), SHORT), models=("coulomb",)
    ),
    "half_step": Case(
        "eq 4, half the step", ((STEP, "scaled_step = 2.65e-7"), SHORT), models=("jcm", "coulomb")
    ),
    "finer": Case(
        "eq 4, 40 mm", ((STEP, "scaled_step = 3.5e-7"), SHORT), size=0.04, models=("jcm", "coulomb")
    ),
    "everywhere": Case("eq 4, joints everywhere", ((SCALED, ""), (END, END + EVERYWHERE), SHORT)),
    "held_everywhere": Case(
        "slider, joints everywhere",
        ((EQ_4, "friction = 'slider'"), (SCALED, ""), (END, END + EVERYWHERE), SHORT),
        models=("jcm", "coulomb"),
    ),
    "implicit": Case(
        "implicit",
        (
            ("solver = 'explicit'", "solver = 'implicit'"),
            (WALLS_OF_PAPER, WALLS_OF_OURS),
            (f"&contact {EQ_4} /\n", ""),
            (EXPLICIT, ""),
            (HELD, "name = 'held', cycles = 1"),
        ),
    ),
}


def deck(case, model, mesh):
    """Text of the deck of a case and a joint model"""
    text = DECK.read_text(encoding="utf-8")
    for old, new in (*case.changes, ("law = 'jcm'", f"law = '{model}'"), (MESH, f"mesh = '{mesh}'")):
        if old not in text:
            sys.exit(f"error: {DECK}: '{old}' is not there")
        text = text.replace(old, new)
    return text


def run(arguments, name, model):
    """Mesh and run; the results directory"""
    case, folder = CASES[name], arguments.results
    results = folder / name / model
    log = results / "run.log"
    if not arguments.again and log.exists() and "\ndone " in log.read_text(encoding="utf-8"):
        return results
    mesh = folder / f"two_sets_{case.size * 1000:g}mm.msh"
    if not mesh.exists():
        command = module("femdem.network.make_mesh", TRACES, "--size", case.size, "--out", mesh)
        subprocess.run([str(word) for word in command], check=True, env=environment())
    path = folder / f"{name}_{model}.nml"
    path.write_text(deck(case, model, mesh.name), encoding="utf-8")
    start = time.monotonic()
    if subprocess.run([arguments.femdem, "--quiet", "--output", results, path], check=False).returncode != 0:
        sys.exit(f"error: the run of {path} failed; what it says stands above and in {log}")
    print(f"{name} {model}: {time.monotonic() - start:.0f} s", flush=True)
    return results


@dataclass
class Course:
    """A run by cycle. Means over the block edges, over those longer than the mean, and over the fractures by length [mm]"""

    time: np.ndarray  # ms
    held: np.ndarray  # ms since the end of phase II-B, negative before
    slip: np.ndarray  # cycles, 3
    aperture: np.ndarray  # cycles, 3

    @property
    def loaded(self):
        """The cycle that ends phase II-B"""
        return int(np.argmin(np.abs(self.held)))


def course(results):
    """Read a run"""
    fields = style.Results(results).fields
    slip, aperture = [], []
    for step in range(len(fields.steps)):
        mesh = fields.mesh(step)
        edge = mesh.block_edge
        on = edge > 0
        length = np.hypot(*np.diff(mesh.joint_lines, axis=1)[on, 0].T)
        edges = np.bincount(edge[on], length)[1:]
        long = edges > edges.mean()
        for name, means in (("shear_displacement_mm", slip), ("aperture_mm", aperture)):
            value = np.abs(fields.read(name, step)[on])
            of_edges = np.bincount(edge[on], value * length)[1:] / edges
            means.append((of_edges.mean(), of_edges[long].mean(), np.average(value, weights=length)))
    loaded = fields.times[max(i for i, stage in enumerate(fields.stages) if stage == "phase_2b")]
    return Course(MS * fields.times, MS * (fields.times - loaded), np.array(slip), np.array(aperture))


def creep(found):
    """Creep of the mean slip over the last part of the time held [mm/s]; its straight line in time"""
    late = found.held >= CREEP_FROM * found.held[-1]
    if late.sum() < 2:
        return 0.0
    return MM_S * np.polyfit(found.held[late], found.slip[late, 0], 1)[0]


def label(model):
    return maps.MODEL_NAMES[model]


def write_tables(folder, courses):
    """A row a cycle, and a row a run"""
    means = [f"{q}_{of}_mm" for q in ("slip", "aperture") for of in ("edges", "long_edges", "by_length")]
    with open(folder / "slip_against_time.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["case", "model", "time_ms", "held_ms", *means])
        for (name, model), found in courses.items():
            for row in zip(found.time, found.held, found.slip, found.aperture, strict=True):
                numbers = (f"{x:.6g}" for x in (*row[:2], *row[2], *row[3]))
                writer.writerow([name, label(model), *numbers])
    rows = []
    for (name, model), found in courses.items():
        rows.append(
            [
                name,
                label(model),
                float(found.slip[found.loaded, 0]),
                float(np.interp(COMMON, found.held, found.slip[:, 0])),
                float(found.held[-1]),
                float(found.slip[-1, 0]),
                float(creep(found)),
                float(found.aperture[-1, 0]),
            ]
        )
    header = [
        "case",
        "model",
        "slip_loaded_mm",
        f"slip_{COMMON:g}_ms_mm",
        "held_ms",
        "slip_held_mm",
        "creep_mm_s",
        "aperture_held_mm",
    ]
    style.error_table(header, rows, folder / "summary.csv")


def draw(out, courses):
    """Slip against time: a colour a joint model, a style of line a case; the implicit solver as dashed lines"""
    figure, grid = plt.subplots(
        1,
        len(PANELS),
        sharex=True,
        sharey=True,
        figsize=(1.6 * style.WIDTH_MM * style.MM, 0.85 * style.HEIGHT_MM * style.MM),
        constrained_layout=True,
    )
    models = sorted({model for _, model in courses}, key=MODELS.index)
    for axes, cases, letter in zip(grid, PANELS, "abc", strict=True):
        for (name, model), found in courses.items():
            colour = style.PALETTE[MODELS.index(model)]
            if name == "implicit":
                axes.axhline(found.slip[-1, 0], color=colour, linestyle="--", linewidth=0.9)
            elif name in cases:
                axes.plot(found.time, found.slip[:, 0], LINES[cases.index(name)], color=colour)
                axes.axvline(found.time[found.loaded], color="#999999", linewidth=0.7)
        entries = [(CASES[name].label, line) for name, line in zip(cases, LINES, strict=False)]
        if any(name == "implicit" for name, _ in courses):
            entries.append((CASES["implicit"].label, "--"))
        handles = [plt.Line2D([], [], color="#555555", linestyle=line, label=text) for text, line in entries]
        if axes is grid[-1]:
            handles += [
                plt.Line2D([], [], color=style.PALETTE[MODELS.index(m)], label=label(m)) for m in models
            ]
        axes.legend(handles=handles, loc="upper left")
        axes.set_title(f"({letter})", loc="left")
        axes.set_xlabel("Time [ms]")
    grid[0].set_ylabel("Mean shear displacement of block edges [mm]")
    style.save(figure, out, None, None)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), help="cases (default: all)")
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS), help="default: all")
    parser.add_argument("--results", type=Path, default=TOP / "results" / "network" / "paper_choices")
    parser.add_argument("--femdem", type=Path, default=program(), help="program (default: build/femdem)")
    parser.add_argument("--again", action="store_true", help="repeat runs that are there already")
    arguments = parser.parse_args()
    arguments.results.mkdir(parents=True, exist_ok=True)
    courses = {
        (name, model): course(run(arguments, name, model))
        for name in arguments.cases
        for model in arguments.models
        if model in CASES[name].models
    }
    write_tables(arguments.results, courses)
    draw(arguments.results / "paper_choices", courses)


if __name__ == "__main__":
    main()
