#!/usr/bin/env python3
"""Build and run the benchmarks of the three kernels: rock forces, contact search, joint law; one thread each.

    python3 tests/bench/kernels.py [--repeat 5] [--results results/bench] [--figure manual/figures/bench_kernels]

Every benchmark runs --repeat times; the median counts, and least and largest are written beside it. Writes kernels.csv
(kernel, case, size, median, least, largest, unit) and one figure. Nothing is asserted: speed belongs to the machine.
"""

import argparse
import csv
import os
import statistics
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(TOP / "postproc"))
import matplotlib.pyplot as plt  # noqa: E402

from femdem.figures import style  # noqa: E402

BUILD = TOP / "build"
KERNELS = ("solid", "nbs", "jcm")
MILLION = 1e6
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
HEADER = ["kernel", "case", "size", "median", "least", "largest", "unit"]


def build():
    """Build the benchmark programs of the release build."""
    if not (BUILD / "CMakeCache.txt").exists():
        subprocess.run(["cmake", "--preset", "release"], cwd=TOP, check=True, stdout=subprocess.DEVNULL)
    targets = [f"femdem_bench_{kernel}" for kernel in KERNELS]
    command = ["cmake", "--build", BUILD, "--parallel", "2", "--target", *targets]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def run_once(kernel, folder):
    """Rows (case, size, value, unit) of one run of a benchmark."""
    program = next(BUILD.rglob(f"femdem_bench_{kernel}"))
    subprocess.run(
        [program], cwd=folder, check=True, stdout=subprocess.DEVNULL, env={**os.environ, **ONE_THREAD}
    )
    with open(folder / f"bench_{kernel}.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if kernel == "solid":
        return [
            ("total", int(row["triangles"]), float(row["triangle_steps_per_second"]), "1/s") for row in rows
        ]
    if kernel == "nbs":
        return [
            (
                f"size ratio {float(row['size_ratio']):g}",
                int(row["segments"]),
                float(row["time_per_segment_ns"]),
                "ns",
            )
            for row in rows
        ]
    return [(row["path"], 0, float(row["updates_per_second"]), "1/s") for row in rows]


def measure(kernel, folder, repeat):
    """Rows of kernels.csv for one kernel."""
    found = defaultdict(list)
    for _ in range(repeat):
        for case, size, value, unit in run_once(kernel, folder):
            found[case, size, unit].append(value)
    return [
        [kernel, case, size, statistics.median(values), min(values), max(values), unit]
        for (case, size, unit), values in found.items()
    ]


def bars(axes, x, part, index, label, scale=1.0):
    """Medians with a bar from the least to the largest."""
    median = [row[3] / scale for row in part]
    below = [(row[3] - row[4]) / scale for row in part]
    above = [(row[5] - row[3]) / scale for row in part]
    axes.errorbar(
        x,
        median,
        yerr=[below, above],
        color=style.PALETTE[index],
        marker=style.MARKERS[index],
        capsize=2,
        label=label,
    )


def draw(rows, out):
    """One panel a kernel."""
    figure, (solid, nbs, jcm) = plt.subplots(
        1, 3, figsize=(190 * style.MM, 65 * style.MM), layout="constrained"
    )
    part = [row for row in rows if row[0] == "solid"]
    bars(solid, [row[2] for row in part], part, 0, None, MILLION)
    solid.set(
        xscale="log", xlabel="Triangles", ylabel="Million triangles a second", title="Forces of the rock"
    )
    for index, case in enumerate(dict.fromkeys(row[1] for row in rows if row[0] == "nbs")):
        part = [row for row in rows if row[0] == "nbs" and row[1] == case]
        # Times of a whole search, in milliseconds
        part = [[*row[:3], *(value * row[2] / MILLION for value in row[3:6])] for row in part]
        label = "one size" if case == "size ratio 1" else case.replace("size ratio", "sizes 1 to")
        bars(nbs, [row[2] for row in part], part, index, label)
        first, last = part[1], part[-1]
        nbs.plot(
            [first[2], last[2]], [first[3], first[3] * last[2] / first[2]], "--", color="#999999", zorder=1
        )
    nbs.plot([], [], "--", color="#999999", label="in proportion")
    nbs.set(
        xscale="log", yscale="log", xlabel="Segments", ylabel="Time of a search [ms]", title="Contact search"
    )
    nbs.legend()
    part = [row for row in rows if row[0] == "jcm"]
    places = list(range(len(part)))
    points = [row[3] / MILLION for row in part]
    jcm.plot(points, places, linestyle="none", marker="o", color=style.PALETTE[0])
    for point, place in zip(points, places, strict=True):
        jcm.annotate(f"{point:.3g}", (point, place), xytext=(0, 5), textcoords="offset points", ha="center")
    jcm.set_yticks(places, [row[1].replace(", ", ",\n").replace(" the peak", "\nthe peak") for row in part])
    jcm.invert_yaxis()
    jcm.set(xscale="log", xlim=(1, 1000), ylim=(len(part) - 0.5, -0.7), xlabel="Million updates a second")
    jcm.set_title("Joint law")
    solid.set_ylim(0, 1.15 * max(row[5] for row in rows if row[0] == "solid") / MILLION)
    style.save(figure, out, None, None)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, default=5, help="runs of each benchmark (default 5)")
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench", help="where CSV files go")
    parser.add_argument("--figure", type=Path, help="figure without suffix (default: kernels in --results)")
    arguments = parser.parse_args()
    folder = arguments.results.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    build()
    rows = [row for kernel in KERNELS for row in measure(kernel, folder, arguments.repeat)]
    style.error_table(HEADER, rows, folder / "kernels.csv")
    draw(rows, arguments.figure or folder / "kernels")


if __name__ == "__main__":
    main()
