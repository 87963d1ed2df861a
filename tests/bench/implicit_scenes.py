#!/usr/bin/env python3
"""Whole implicit runs of a fracture network, from 1e4 to 1e6 unknowns: time, where it goes, memory, threads.

    python3 tests/bench/implicit_scenes.py [--sizes 0.02 0.01 0.005] [--threads 1 2] [--traces input/network/two_sets.csv]
        [--phase phase_2b] [--cycles 5] [--cracks] [--results results/bench]

Sizes are those of the elements at the fractures (two_sets: 0.0018 has 1e6 unknowns). The runs are phase I, and phase II-B
after it with --phase phase_2b, in --cycles increments each. Writes implicit_scenes.csv: triangles, unknowns, joint elements,
threads, user time of the whole program and time by the clock [s], iterations, factorisations, memory of the factors and of the
program [MB], and the share of each kind of work in per cent, as the run tells them; and the figure bench_implicit_scenes. Prints
how time and memory grow with the unknowns: the exponent of a power law through the first and the last size. Nothing is
asserted: speed belongs to the machine.
"""

import argparse
import csv
import math
import os
import re
import subprocess
import sys
import time
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(TOP / "postproc"))
import matplotlib.pyplot as plt  # noqa: E402

from femdem.figures import style  # noqa: E402

CRACKS = "&cohesive group = 'all', tensile_strength = 7e6, cohesion = 15e6, friction_angle = 26.6, g_i = 100, g_ii = 500 /\n"
MEBIBYTE = 1024


def measure(folder, mesh, threads, arguments):
    """A row of implicit_scenes.csv."""
    text = (TOP / "input" / "network" / f"{arguments.phase}.nml").read_text(encoding="utf-8")
    text = re.sub(r"mesh = '[^']*'", f"mesh = '{mesh.name}'", text)
    text = re.sub(r"cycles = \d+", f"cycles = {arguments.cycles}", text)
    deck = folder / "deck.nml"
    deck.write_text(text + (CRACKS if arguments.cracks else ""), encoding="utf-8")
    command = [TOP / "build" / "femdem", "--quiet", "--output", folder / "out", deck]
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
    begin = time.perf_counter()
    process = subprocess.Popen([str(word) for word in command], env=environment)
    _, status, usage = os.wait4(process.pid, 0)
    clock = time.perf_counter() - begin
    if status:
        raise SystemExit(f"{' '.join(map(str, command))}: status {os.waitstatus_to_exitcode(status)}")
    log = (folder / "out" / "run.log").read_text(encoding="utf-8")

    def number(pattern):
        return int(re.search(pattern, log).group(1))

    shares = dict(re.findall(r"^time +(\S+) +[\d.]+ s +([\d.]+) %$", log, re.MULTILINE))
    return {
        "triangles": number(r"(\d+) triangles"),
        "unknowns": number(r"implicit +(\d+) unknowns"),
        "joints": number(r"(\d+) joint elements"),
        "threads": threads,
        "user_s": round(usage.ru_utime, 2),
        "clock_s": round(clock, 2),
        "iterations": number(r"(\d+) iterations,"),
        "factorisations": number(r"(\d+) factorisations"),
        "factors_mb": number(r"factors take (\d+) MB"),
        "program_mb": usage.ru_maxrss // MEBIBYTE,
    } | shares


def draw(rows, out):
    """Time and memory against the number of unknowns."""
    figure, axes = plt.subplots(figsize=(90 * style.MM, 65 * style.MM), layout="constrained")
    for threads in sorted({row["threads"] for row in rows}):
        part = [row for row in rows if row["threads"] == threads]
        axes.plot(
            [row["unknowns"] for row in part],
            [row["user_s"] for row in part],
            marker="o",
            linestyle="-" if threads == 1 else "--",
            color=style.PALETTE[0],
            label=f"user time (s), {threads} thread{'s' * (threads > 1)}",
        )
    part = [row for row in rows if row["threads"] == rows[0]["threads"]]
    for index, (name, label) in enumerate(
        (("program_mb", "program (MB)"), ("factors_mb", "factors (MB)")), 1
    ):
        axes.plot(
            [row["unknowns"] for row in part],
            [row[name] for row in part],
            marker="s",
            color=style.PALETTE[index],
            label=label,
        )
    axes.set(xscale="log", yscale="log", xlabel="Unknowns", ylabel="Time, memory")
    axes.legend(loc="upper left")
    axes.set_ylim(top=30 * max(row["program_mb"] for row in rows))
    style.save(figure, out, None, None)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=float, nargs="+", default=[0.02, 0.01, 0.005])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--traces", type=Path, default=TOP / "input" / "network" / "two_sets.csv")
    parser.add_argument("--phase", choices=("phase_1", "phase_2b"), default="phase_1")
    parser.add_argument("--cycles", type=int, default=5, help="increments of a phase")
    parser.add_argument("--cracks", action="store_true", help="rock may break")
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench", help="where files go")
    arguments = parser.parse_args()
    folder = arguments.results.resolve() / "implicit_scenes"
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for size in arguments.sizes:
        mesh = folder / f"{arguments.traces.stem}_{size:g}.msh"
        if not mesh.exists():
            mesher = [
                TOP / "bin" / "femdem-mesh",
                arguments.traces,
                "--size",
                str(size),
                "--out",
                mesh,
            ]
            subprocess.run(mesher, check=True, stdout=subprocess.DEVNULL)
        for threads in arguments.threads:
            rows.append(measure(folder, mesh, threads, arguments))
            print(rows[-1], flush=True)
    names = list(dict.fromkeys(name for row in rows for name in row))
    with open(arguments.results / "implicit_scenes.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, arguments.results / "bench_implicit_scenes")
    one = [row for row in rows if row["threads"] == arguments.threads[0]]
    for name in ("user_s", "factors_mb", "program_mb") if len(one) > 1 else ():
        ratio = math.log(one[-1][name] / one[0][name]) / math.log(one[-1]["unknowns"] / one[0]["unknowns"])
        print(f"{name}: grows as n^{ratio:.2f}")


if __name__ == "__main__":
    main()
