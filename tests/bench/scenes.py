#!/usr/bin/env python3
"""Whole explicit runs of a specimen, from 2e3 to 1e6 triangles: speed, where the time goes, threads.

    python3 tests/bench/scenes.py [--sizes 0.0218 0.0099 0.005 0.0034] [--threads 1 2] [--work 1e8] [--results results/bench]

Sizes are those of the elements of a specimen of 0.5 m by 1 m (0.0011: 1e6 triangles). Each is run as rock alone and with joints
on every edge, for about --work triangle-steps. Writes scenes.csv: kind, triangles, threads, user time of the whole program,
speed by the clock while it steps, and the share of each kind of work in per cent, as the run tells them; and the figure
bench_scenes. Prints how speed goes with size: the exponent of a power law through the first and the last size. Nothing is
asserted: speed belongs to the machine.
"""

import argparse
import csv
import math
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(TOP / "postproc"))
import matplotlib.pyplot as plt  # noqa: E402

from femdem.figures import style  # noqa: E402

SPECIMENS = TOP / "tests" / "scenes" / "_specimens" / "specimens.py"
DECK = """&run title = 'Speed', mesh = '{mesh}', solver = 'explicit', threads = {threads}, long = .true. /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /
{cohesive}
&boundary group = 'bottom', vy = 0.01 /
&boundary group = 'top', vy = -0.01 /
&stage name = 'compress', move_time = {time}, profile = 'constant' /
"""
JOINTS = (
    "&cohesive group = 'all', insertion = 'everywhere', tensile_strength = 7e6, cohesion = 15e6, "
    "friction_angle = 26.6, g_i = 100, g_ii = 500 /"
)
KINDS = {"rock": "", "joints": JOINTS}


def run(folder, mesh, kind, threads, time):
    """The log of a run, and its user time [s]."""
    deck = folder / "deck.nml"
    text = DECK.format(mesh=mesh.name, threads=threads, cohesive=KINDS[kind], time=time)
    deck.write_text(text, encoding="utf-8")
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [TOP / "build" / "femdem", "--quiet", "--output", folder / "out", deck]
    subprocess.run(command, check=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    log = (folder / "out" / "run.log").read_text(encoding="utf-8")
    return log, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def measure(folder, mesh, kind, threads, work):
    """A row of scenes.csv: a run of some steps tells how long one of the wanted work has to be."""
    trial = 2e-5
    log, _ = run(folder, mesh, kind, threads, trial)
    triangles = int(re.search(r"(\d+) triangles", log).group(1))
    steps = int(re.search(r"^done +(\d+) steps", log, re.MULTILINE).group(1))
    log, user = run(folder, mesh, kind, threads, trial * max(1.0, work / (triangles * steps)))
    speed = float(re.search(r"^speed +(\S+) million", log, re.MULTILINE).group(1))
    shares = dict(re.findall(r"^time +(\S+) +[\d.]+ s +([\d.]+) %$", log, re.MULTILINE))
    return {
        "kind": kind,
        "triangles": triangles,
        "threads": threads,
        "user_s": user,
        "million_a_second": speed,
    } | shares


def draw(rows, out):
    """Speed against size, a line for each kind and number of threads."""
    figure, axes = plt.subplots(figsize=(90 * style.MM, 65 * style.MM), layout="constrained")
    names = {"rock": "rock alone", "joints": "joints on every edge"}
    for index, kind in enumerate(KINDS):
        for threads in sorted({row["threads"] for row in rows}):
            part = [row for row in rows if row["kind"] == kind and row["threads"] == threads]
            axes.plot(
                [row["triangles"] for row in part],
                [row["million_a_second"] for row in part],
                marker="o",
                linestyle="-" if threads == 1 else "--",
                color=style.PALETTE[index],
                label=f"{names[kind]}, {threads} thread{'s' * (threads > 1)}",
            )
    axes.set(xscale="log", yscale="log", xlabel="Triangles", ylabel="Million triangle-steps a second")
    axes.set_ylim(bottom=2)
    axes.legend()
    style.save(figure, out, None, None)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=float, nargs="+", default=[0.0218, 0.0099, 0.005, 0.0034])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--work", type=float, default=1e8, help="triangle-steps of a run")
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench", help="where files go")
    arguments = parser.parse_args()
    folder = arguments.results.resolve() / "scenes"
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for size in arguments.sizes:
        mesh = folder / f"specimen_{size:g}.msh"
        if not mesh.exists():
            mesher = [sys.executable, SPECIMENS, "rectangle", "--size", str(size), "--out", mesh]
            subprocess.run(mesher, check=True, stdout=subprocess.DEVNULL)
        for kind in KINDS:
            rows += [measure(folder, mesh, kind, threads, arguments.work) for threads in arguments.threads]
            print(rows[-1], flush=True)
    names = list(dict.fromkeys(name for row in rows for name in row))
    with open(arguments.results / "scenes.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, arguments.results / "bench_scenes")
    for kind in KINDS:
        one = [row for row in rows if row["kind"] == kind and row["threads"] == arguments.threads[0]]
        if len(one) < 2:
            continue
        ratio = one[-1]["million_a_second"] / one[0]["million_a_second"]
        print(
            f"{kind}: speed goes as n^{math.log(ratio) / math.log(one[-1]['triangles'] / one[0]['triangles']):.2f}"
        )


if __name__ == "__main__":
    main()
