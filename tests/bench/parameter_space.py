#!/usr/bin/env python3
"""Run single joints all over the parameter space of the joint law through the whole program, and compare.

    python3 tests/bench/parameter_space.py [--runs 240] [--processes 2] [--results results/bench/parameter_space]

JRC0 2 to 20, JCS0 2 to 200 MPa, normal stress 0.01 to 20 MPa, phi_r 25 to 35 degrees, length 0.05 to 2 m (a Latin
hypercube; JCS, stress and length by their logarithms). Each run: two rigid blocks with one joint, closed under the normal
stress, then sheared to five times the peak displacement (implicit solver). Shear stress is compared with eq 13, dilation with
the integral of eq 18, closure with eq 5b, by femdem.jcm.

Runs where a guard of the law acts (manual/theory_joints.md, 7) are outside its validity and are reported apart.
Writes parameter_space.csv (one row a run), parameter_space_summary.csv and a figure. --keep leaves the folders of the runs.
"""

import argparse
import csv
import functools
import math
import multiprocessing
import shutil
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(TOP / "postproc"), str(TOP / "tests" / "scenes" / "_meshes")]
import matplotlib.pyplot as plt  # noqa: E402
from rectangles import make_mesh  # noqa: E402
from scipy.stats import qmc  # noqa: E402

from femdem.figures import style  # noqa: E402
from femdem.jcm import Joint  # noqa: E402
from femdem.results import Results  # noqa: E402

PROGRAM = TOP / "build" / "femdem"
# name: least, largest, by its logarithm?
SPACE = {
    "jrc0": (2.0, 20.0, False),
    "jcs0_mpa": (2.0, 200.0, True),
    "sn_mpa": (0.01, 20.0, True),
    "phi_r": (25.0, 35.0, False),
    "length_m": (0.05, 2.0, True),
}
L0 = 0.1  # m, the usual laboratory sample
ELEMENTS = 5  # along the joint
TRAVEL, CYCLES_TO_PEAK = 5, 40  # in peak displacements; load increments to the peak
ERRORS = {
    "shear_stress_%": "shear stress, % of the peak (eq 13)",
    "dilation_%": "dilation, % of the largest (eq 18)",
    "closure_%": "closure, % (eq 5b)",
    "normal_stress_%": "normal stress, % of the load",
}
HEADER = [*SPACE, "jrcn", "jcsn_mpa", "up_mm", "guards", "status", *ERRORS, "seconds"]
TIMEOUT = 300

DECK = """! One joint between two rigid blocks.
&run title = 'One joint', mesh = 'scene.msh', solver = 'implicit' /
&material group = 'base', density = 2000, young = 1e13, poisson = 0 /
&material group = 'block', density = 2000, young = 1e13, poisson = 0 /
&joint
  group = 'joint', law = 'jcm', jrc0 = {jrc0:.17g}, jcs0_mpa = {jcs0_mpa:.17g}, l0 = {l0}, phi_r = {phi_r:.17g},
  peak = 'eq15', post_peak = 'table', coupling = 'paper',
/
&boundary group = 'base', vx = 0, vy = 0 /
&boundary group = 'block', vx = 0 /
&boundary group = 'block', stage = 'shear', vx = {velocity:.17g} /
&boundary group = 'block_top', ty = {traction:.17g} /
&stage name = 'load', move_time = 1 /
&stage name = 'shear', cycles = {cycles}, move_time = 1e-3 /
"""


def sample(runs, seed):
    """A Latin hypercube: one dictionary a run."""
    unit = qmc.LatinHypercube(len(SPACE), seed=seed).random(runs)
    values = {}
    for column, (name, (least, largest, by_logarithm)) in zip(unit.T, SPACE.items(), strict=True):
        if by_logarithm:
            values[name] = least * (largest / least) ** column
        else:
            values[name] = least + (largest - least) * column
    return [{name: float(values[name][i]) for name in SPACE} for i in range(runs)]


def run_point(point, folder):
    """Run one joint in its folder; returns the exit status and the last line of errors."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    joint = reference(point)
    length, travel = point["length_m"], TRAVEL * float(joint.peak_displacement(point["sn_mpa"])) / 1000
    overhang, height = max(0.2 * length, 1.5 * travel), 0.2 * length
    make_mesh(
        [
            ("base", -overhang, -height, overhang, height, 1, 1, False),
            ("base", 0.0, -height, length, height, ELEMENTS, 1, False),
            ("base", length, -height, overhang, height, 1, 1, False),
            ("block", 0.0, 0.0, length, height, ELEMENTS, 1, False),
        ],
        str(folder / "scene.msh"),
        joint=True,
    )
    cycles = TRAVEL * CYCLES_TO_PEAK
    text = DECK.format(
        **point, l0=L0, cycles=cycles, velocity=travel / cycles / 1e-3, traction=-1e6 * point["sn_mpa"]
    )
    (folder / "joint.nml").write_text(text, encoding="utf-8")
    command = [PROGRAM, "--quiet", "--output", folder / "results", folder / "joint.nml"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return "timeout", ""
    return done.returncode, "".join(done.stderr.splitlines()[-1:])


def reference(point):
    """The law of a point, from the post-processing's own program."""
    return Joint(
        jrc0=point["jrc0"], jcs0=point["jcs0_mpa"], l0=L0, phi_r=point["phi_r"], length=point["length_m"]
    )


def largest_errors(point, results):
    """Largest difference from the law along the run, in per cent, in the order of ERRORS."""
    joint, sn = reference(point), point["sn_mpa"]
    history = Results(results).history
    u, tau, stress, dilation, closure = (
        history.joint("joint", name)
        for name in (
            "shear_displacement_mm",
            "shear_stress_MPa",
            "normal_stress_MPa",
            "dilation_mm",
            "closure_mm",
        )
    )
    expected = joint.dilation(u, sn)
    # Where the law knows no dilation, per cent of a thousandth of the peak displacement
    scale = np.max(np.abs(expected)) or 1e-3 * float(joint.peak_displacement(sn))
    return [
        100 * float(np.max(np.abs(tau - joint.shear_stress(u, sn)))) / float(joint.peak_shear_stress(sn)),
        100 * float(np.max(np.abs(dilation - expected))) / scale,
        100 * float(np.max(np.abs(closure / joint.closure(sn) - 1))),
        100 * float(np.max(np.abs(stress / sn - 1))),
    ]


def one_row(numbered, folder, keep):
    """Run a point and compare: one row of the CSV."""
    number, point = numbered
    place = folder / f"run_{number:04d}"
    joint = reference(point)
    sn = point["sn_mpa"]
    start = time.monotonic()
    status, message = run_point(point, place)
    seconds = time.monotonic() - start
    errors = largest_errors(point, place / "results") if status == 0 else [math.nan] * len(ERRORS)
    if status != 0:
        print(f"{place}: status {status}: {message}", flush=True)
    elif not keep:
        shutil.rmtree(place)
    known = [joint.jrcn, joint.jcsn, float(joint.peak_displacement(sn))]
    return [*point.values(), *known, "+".join(joint.guards(sn)), status, *errors, seconds]


def summarise(rows):
    """Header and rows: median, 95 % quantile and worst of each error, inside and outside the law's validity."""
    table = []
    at = {name: HEADER.index(name) for name in HEADER}
    parts = {
        "inside validity": [row for row in rows if not row[at["guards"]]],
        "outside (a guard acts)": [row for row in rows if row[at["guards"]]],
    }
    for part, chosen in parts.items():
        done = [row for row in chosen if row[at["status"]] == 0]
        for name, text in ERRORS.items():
            errors = [row[at[name]] for row in done]
            if errors:
                quantiles = [float(np.quantile(errors, q)) for q in (0.5, 0.95, 1.0)]
                table.append([part, len(chosen), len(chosen) - len(done), text, *quantiles])
    return ["part", "runs", "failed", "largest error along a run", "median", "95_%", "worst"], table


def draw(rows, out):
    """Share of runs against error, and where in the space the guards act."""
    at = {name: HEADER.index(name) for name in HEADER}
    figure, (share, space) = plt.subplots(1, 2, figsize=(180 * style.MM, 80 * style.MM), layout="constrained")
    for index, (name, label) in enumerate(zip(ERRORS, ("shear stress", "dilation", "closure"), strict=False)):
        for inside, line in ((True, "-"), (False, ":")):
            errors = [
                row[at[name]] for row in rows if row[at["status"]] == 0 and (not row[at["guards"]]) == inside
            ]
            if errors:
                errors = np.maximum(np.sort(errors), 1e-10)
                percent = 100 * np.arange(1, len(errors) + 1) / len(errors)
                share.step(
                    errors,
                    percent,
                    line,
                    where="post",
                    color=style.PALETTE[index],
                    label=label if inside else None,
                )
    share.plot([], [], ":", color="#555555", label="a guard acts")
    share.set(xscale="log", xlabel="Largest error along a run [%]", ylabel="Runs with at most this error [%]")
    share.legend(loc="upper left", fontsize=7)
    # Where several guards act, the first is drawn
    first = [row[at["guards"]].split("+")[0] for row in rows]
    names = ["", *(name for name, _ in Counter(first).most_common() if name)]
    for index, name in enumerate(names):
        part = [row for row, guard in zip(rows, first, strict=True) if guard == name]
        space.plot(
            [row[at["sn_mpa"]] / row[at["jcsn_mpa"]] for row in part],
            [row[at["jrcn"]] for row in part],
            linestyle="none",
            marker=style.MARKERS[index % len(style.MARKERS)],
            markersize=3,
            color=style.PALETTE[index % len(style.PALETTE)],
            label=name or "inside validity",
        )
    space.set(
        xscale="log",
        xlabel="Normal stress over wall strength, sn/JCSn",
        ylabel="Roughness JRCn",
        ylim=(0, 30),
    )
    space.legend(loc="upper right", ncol=2, fontsize=7, columnspacing=1, handletextpad=0)
    style.save(figure, out, None, None)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=240, help="number of runs (default 240)")
    parser.add_argument("--seed", type=int, default=2016, help="seed of the Latin hypercube")
    parser.add_argument("--processes", type=int, default=2, help="runs at the same time")
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench" / "parameter_space")
    parser.add_argument("--figure", type=Path, help="figure without suffix (default: in --results)")
    parser.add_argument("--keep", action="store_true", help="keep decks and results of all runs")
    arguments = parser.parse_args()
    if not PROGRAM.exists():
        sys.exit(f"error: {PROGRAM} is missing; build first (./run.sh does)")
    folder = arguments.results.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    work = functools.partial(one_row, folder=folder, keep=arguments.keep)
    with multiprocessing.Pool(arguments.processes) as pool:
        rows = list(pool.imap(work, enumerate(sample(arguments.runs, arguments.seed))))
    with open(folder / "parameter_space.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([HEADER, *rows])
    style.error_table(*summarise(rows), folder / "parameter_space_summary.csv")
    draw(rows, arguments.figure or folder / "parameter_space")


if __name__ == "__main__":
    main()
