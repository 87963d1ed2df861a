#!/usr/bin/env python3
"""A crack that fluid without viscosity opens (KGD, toughness): half-length, opening and pressure against the similarity solution.

    python3 tests/bench/kgd.py [--size 0.005] [--lengths 0.1 0.15 0.2] [--steps 10] [--enters 0.1] [--strength 5e6]
        [--results results/bench/kgd]

Elements of --size along the line, a notch of 40 mm, rock ten times as far as the crack gets. The times are those at which a crack
without a cohesive zone has the --lengths; the first is reached in --steps steps. Writes kgd.csv: time, and half-length,
opening at the middle and pressure as found, by the similarity solution, and by the same cohesive law in rock without a mesh
(cohesive_crack.py) at the length found; and the figure bench_kgd. Nothing is asserted. Some minutes.
"""

import argparse
import csv
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(TOP / "postproc"), str(TOP / "tests")]
import matplotlib as mpl  # noqa: E402

mpl.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import flow_grid  # noqa: E402
from cohesive_crack import Rock, cohesive_crack  # noqa: E402
from fluid_crack import NOTCH_OPEN, POISSON, RATE, YOUNG, half_a_crack, injection  # noqa: E402

PROGRAM = TOP / "build" / "femdem"
NOTCH = 0.04
COLUMNS = "time_s,l_m,w_mm,p_MPa,l_similarity_m,w_similarity_mm,p_similarity_MPa,l_cohesive_m,w_cohesive_mm,p_cohesive_MPa"


def time_of(rock, length):
    """When a crack without a zone is so long [s]"""
    return (length / rock.griffith(1.0)[0]) ** 1.5 / RATE


def rows_of(arguments, folder):
    """Run it; a row for each time"""
    rock = Rock(YOUNG / (1 - POISSON**2), 30.0, arguments.strength)
    times = [time_of(rock, length) for length in arguments.lengths]
    notch, longest = round(NOTCH / arguments.size), round(1.25 * max(arguments.lengths) / arguments.size)
    well = half_a_crack(
        folder, arguments.size, notch, longest, extent=10 * max(arguments.lengths), growth=1.3
    )
    deck = injection(times, arguments.steps).replace(
        "max_passes", f"fluid_enters = {arguments.enters}, max_passes"
    )
    deck = deck.replace("tensile_strength = 5e6", f"tensile_strength = {arguments.strength}")
    x, _, found = flow_grid.snapshots(PROGRAM, folder, deck, timeout=None)
    place = np.flatnonzero(np.isclose(x, well).all(axis=1))[0]
    for time, fields in zip(times, found, strict=True):
        wet = arguments.size * (fields["hydraulic_aperture_mm"] > 0).sum()
        opening = 1e-3 * fields["aperture_mm"].max() - NOTCH_OPEN
        openings, pressure, length = cohesive_crack(rock, wet, arguments.size / 2, arguments.enters)
        yield [
            time,
            *(wet, 1e3 * opening, 1e-6 * fields["fluid_pressure"][place]),
            *np.array(rock.griffith(RATE * time)) * (1, 1e3, 1e-6),
            *(length, 1e3 * openings[0], 1e-6 * pressure),
        ]


def draw(rows, path):
    """Half-length, opening and pressure in time"""
    rows = np.array(rows)
    figure, axes = plt.subplots(1, 3, figsize=(9, 3), layout="constrained")
    for axis, column, label in zip(
        axes, (1, 2, 3), ("half-length [m]", "opening [mm]", "pressure [MPa]"), strict=True
    ):
        axis.plot(rows[:, 0], rows[:, column + 3], "k-", label="similarity solution")
        axis.plot(rows[:, 0], rows[:, column + 6], "k--", label="cohesive law, no mesh")
        axis.plot(rows[:, 0], rows[:, column], "o", label="program")
        axis.set_xlabel("time [s]")
        axis.set_ylabel(label)
    axes[0].legend(loc="lower right", fontsize="small")
    figure.savefig(path, dpi=150)


def main(argv=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", type=float, default=0.005)
    parser.add_argument("--lengths", type=float, nargs="+", default=[0.1, 0.15, 0.2])
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--enters", type=float, default=0.1)
    parser.add_argument("--strength", type=float, default=5e6)
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench" / "kgd")
    arguments = parser.parse_args(argv)
    arguments.results.mkdir(parents=True, exist_ok=True)
    rows = list(rows_of(arguments, arguments.results))
    with open(arguments.results / "kgd.csv", "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS.split(","), *rows])
    draw(rows, arguments.results / "bench_kgd.png")
    for row in rows:
        over = [100 * (row[k] / row[k + 3] - 1) for k in (1, 2, 3)]
        print(
            f"{row[0]:.3f} s: l {row[1]:.4f} m ({over[0]:+.1f} %), w {row[2]:.4f} mm ({over[1]:+.1f} %), "
            f"p {row[3]:.4f} MPa ({over[2]:+.1f} %); cohesive law: p {row[9]:.4f} MPa"
        )


if __name__ == "__main__":
    main()
