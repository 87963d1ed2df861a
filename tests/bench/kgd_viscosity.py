#!/usr/bin/env python3
"""A crack that a viscous fluid opens in confined rock (KGD, viscosity) against the similarity solution.

    python3 tests/bench/kgd_viscosity.py [--sizes 0.05 0.025] [--confined 20e6] [--viscosity 0.1] [--times 2.5 5 10]
        [--step 0.08] [--results results/bench/kgd_viscosity]

Writes kgd_viscosity.csv: size of the elements and time, and half-length, opening at the middle and pressure there beyond the
confining stress as found, by the similarity solution, and by the same laws in rock without a mesh (viscous_crack.py); and the
figure bench_kgd_viscosity, with the crack along its length. Nothing is asserted. One to three minutes.
"""

import argparse
import csv
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(TOP / "postproc"), str(TOP / "tests")]
import h5py  # noqa: E402
import matplotlib as mpl  # noqa: E402

mpl.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import flow_grid  # noqa: E402
from fluid_crack import crack_found, viscous_injection, viscous_mesh  # noqa: E402
from viscous_crack import Case, viscous_crack  # noqa: E402

PROGRAM = TOP / "build" / "femdem"
QUANTITIES = ("l_m", "w_mm", "p_MPa")
UNITS = (1, 1e3, 1e-6)
LABELS = ("half-length [m]", "opening at the middle [mm]", "net pressure at the middle [MPa]")


def rows_of(case, times, step, folder):
    """A row for each time; along the crack at the last one: places of the nodes, pressures, middles of the elements, openings"""
    folder.mkdir(parents=True, exist_ok=True)
    well = viscous_mesh(folder, case, 1.3 * case.similarity(max(times))[0])
    deck = viscous_injection(case, times, step)
    x, _, found = flow_grid.snapshots(PROGRAM, folder, deck, timeout=None)
    rows = []
    for time, fields, alone in zip(times, found[2:], viscous_crack(case, times), strict=True):
        program = np.array(crack_found(case, well, x, fields))
        rows.append(
            [
                case.size,
                time,
                *np.ravel(
                    [program * UNITS, case.similarity(time) * np.array(UNITS), alone * np.array(UNITS)]
                ),
            ]
        )
    last = found[-1]
    on_line = np.isclose(x[:, 1], well[1]) & np.isfinite(last["fluid_pressure"])
    nodes, order = np.unique(x[on_line, 0], return_index=True)
    pressure = 1e-6 * (last["fluid_pressure"][on_line][order] - case.confined)
    with h5py.File(folder / "results" / "fields.h5") as file:
        middle = x[file["mesh/joints"][:, :2], 0].mean(axis=1)
    conducts = last["hydraulic_aperture_mm"] > 0
    opening = last["aperture_mm"] - 1e3 * case.notch_open * (middle < case.notch)
    order = np.argsort(middle[conducts])
    profile = nodes, pressure, middle[conducts][order], opening[conducts][order]
    return rows, profile


def draw(rows, profile, path):
    """Half-length, opening and pressure in time, and the crack at the last one"""
    rows = np.array(rows)
    figure, axes = plt.subplots(2, 3, figsize=(10, 6), layout="constrained")
    times = np.linspace(0.2, 1, 50) * rows[:, 1].max()
    for k, axis in enumerate(axes[0]):
        coarse = rows[rows[:, 0] == rows[:, 0].max()]
        power = (2 / 3, 1 / 3, -1 / 3)[k]
        last = coarse[-1]
        axis.plot(times, last[5 + k] * (times / last[1]) ** power, "k-", label="similarity solution")
        for number, of_size in enumerate(np.unique(rows[:, 0])[::-1]):
            there = rows[rows[:, 0] == of_size]
            axis.plot(there[:, 1], there[:, 2 + k], "os^"[number], label=f"program, {1e3 * of_size:g} mm")
            axis.plot(
                there[:, 1],
                there[:, 8 + k],
                "x+1"[number],
                color="0.4",
                label=f"no mesh, {1e3 * of_size:g} mm",
            )
        axis.set_xlabel("time [s]")
        axis.set_ylabel(LABELS[k])
    axes[0, 0].legend(fontsize="small")
    x, pressure, middle, opening = profile
    axes[1, 0].plot(middle, opening, ".-")
    axes[1, 0].set_ylabel("opening [mm]")
    axes[1, 1].plot(x, pressure, ".-")
    axes[1, 1].set_ylabel("net pressure [MPa]")
    for axis in axes[1, :2]:
        axis.set_xlabel("from the well [m]")
        axis.set_title(f"at {rows[:, 1].max():g} s, {1e3 * rows[:, 0].min():g} mm", fontsize="medium")
    for number, of_size in enumerate(np.unique(rows[:, 0])[::-1]):
        there = rows[rows[:, 0] == of_size]
        for k, name in enumerate(("half-length", "opening", "net pressure")):
            over = 100 * (there[:, 2 + k] / there[:, 5 + k] - 1)
            axes[1, 2].plot(
                there[:, 1],
                over,
                "os^"[k] + ("--", "-", ":")[number % 3],
                label=f"{name}, {1e3 * of_size:g} mm",
            )
    axes[1, 2].axhline(0, color="0.7", linewidth=0.8)
    axes[1, 2].set_xlabel("time [s]")
    axes[1, 2].set_ylabel("over the similarity solution [%]")
    axes[1, 2].legend(fontsize="x-small")
    figure.savefig(path, dpi=150)


def main(argv=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=float, nargs="+", default=[0.05, 0.025])
    parser.add_argument("--confined", type=float, default=20e6)
    parser.add_argument("--viscosity", type=float, default=0.1)
    parser.add_argument("--times", type=float, nargs="+", default=[2.5, 5.0, 10.0])
    parser.add_argument("--step", type=float, default=0.08, help="longest step of time [s]")
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench" / "kgd_viscosity")
    arguments = parser.parse_args(argv)
    arguments.results.mkdir(parents=True, exist_ok=True)
    rows = []
    for size in sorted(arguments.sizes, reverse=True):
        case = Case(size=size, confined=arguments.confined, viscosity=arguments.viscosity)
        more, profile = rows_of(
            case, arguments.times, arguments.step, arguments.results / f"{1e3 * size:g}_mm"
        )
        rows += more
    columns = [
        "size_m",
        "time_s",
        *(f"{name}{of}" for of in ("", "_similarity", "_no_mesh") for name in QUANTITIES),
    ]
    columns = [name.replace("_m_", "_").replace("_mm_", "_").replace("_MPa_", "_") for name in columns]
    with open(arguments.results / "kgd_viscosity.csv", "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])
    draw(rows, profile, arguments.results / "bench_kgd_viscosity.png")
    print(f"dimensionless toughness {case.toughness():.2f}")
    for row in rows:
        over = [f"{100 * (row[2 + k] / row[5 + k] - 1):+.1f} %" for k in range(3)]
        alone = [f"{100 * (row[2 + k] / row[8 + k] - 1):+.1f} %" for k in range(3)]
        print(
            f"{1e3 * row[0]:g} mm, {row[1]} s: l {row[2]:.3f} m, w {row[3]:.4f} mm, p {row[4]:.3f} MPa: {', '.join(over)}; "
            f"over the same without a mesh {', '.join(alone)}"
        )


if __name__ == "__main__":
    main()
