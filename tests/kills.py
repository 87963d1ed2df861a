#!/usr/bin/env python3
"""Runs that are killed (SIGKILL) at random moments, once or twice in a row, and go on: the same results as of a run left alone.

    python3 tests/kills.py                                   # 100 for each solver, without cracks and with them
    python3 tests/kills.py --solvers explicit --kills 20 --seed 3

Compared are history, block edges, cracks and fields.xdmf, byte for byte, and the arrays of all snapshots, bit for bit. The
exit status is 1 when one differs.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

import fuzz

TOP = Path(__file__).resolve().parent.parent

CRACKS = "&cohesive group = 'all', tensile_strength = {0}, cohesion = {1}, friction_angle = 30, g_i = 20, g_ii = 60 /\n"
# Strengths and shear load with which edges are cut one after the other; with the explicit solver four of them break
STRENGTH = {"explicit": (2e5, 1.2e6), "implicit": (2e5, 1.6e6), "relaxation": (2e5, 1.6e6)}
SHEAR = {"explicit": "tx = 2e6", "implicit": "tx = 1e6", "relaxation": "tx = 1e6"}
CYCLES = {"explicit": 40, "implicit": 40, "relaxation": 40}


def deck(solver, cracks):
    text = f"&run mesh = 'box.msh', solver = '{solver}' /\n" + fuzz.ROCK + fuzz.JOINTS[0]
    if cracks:
        text += CRACKS.format(*STRENGTH[solver])
    loads = fuzz.REST.replace("move_time = 2e-3, cycles = 2", f"move_time = 1e-3, cycles = {CYCLES[solver]}")
    loads = loads.replace("tx = 1e6", SHEAR[solver]).replace("cycles = 2\n", f"cycles = {CYCLES[solver]}\n")
    return (
        text
        + loads
        + fuzz.SOLVERS[solver].replace("= 50", "= 500")
        + fuzz.OUTPUT.replace("fields_every = 1", "fields_every = 50")
    )


def write(folder, solver, cracks):
    (folder / "box.msh").write_text(fuzz.MESH)
    (folder / "deck.nml").write_text(deck(solver, cracks))


def command(program, output, restart):
    checkpoint = ["--restart", f"{output}/checkpoint.h5"] if restart else []
    return [program, "--quiet", *checkpoint, "--output", output, "deck.nml"]


def finish(program, folder, output, restart):
    done = subprocess.run(
        command(program, output, restart),
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"status {done.returncode}: {done.stderr}")


def kill_after(program, folder, output, restart, seconds):
    """Start a run and kill it; whether it was still going on"""
    with subprocess.Popen(
        command(program, output, restart), cwd=folder, stderr=subprocess.DEVNULL
    ) as process:
        try:
            process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            return True
    return False


def arrays(path):
    """All arrays of the snapshots by their path, and the times"""
    found = {}
    with h5py.File(path) as file:
        for step in sorted(name for name in file if name.startswith("step_")):
            found[step] = np.array(file[step].attrs["time_s"])
            found.update({f"{step}/{name}": np.array(file[step][name]) for name in file[step]})
    return found


def difference(one, other):
    """What differs between two results directories; '' when nothing does"""
    for name in ("history.csv", "edges.csv", "cracks.csv", "fields.xdmf", "joints.xdmf"):
        if (one / name).exists() != (other / name).exists():
            return f"{name} is missing"
        if (one / name).exists() and (one / name).read_bytes() != (other / name).read_bytes():
            return name
    a, b = arrays(one / "fields.h5"), arrays(other / "fields.h5")
    if a.keys() != b.keys():
        return "the snapshots"
    return next((name for name in a if not np.array_equal(a[name], b[name])), "")


def series(program, solver, cracks, kills, chance):
    """Kill a run many times; how many were killed, and what differed (list of texts)"""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(folder, solver, cracks)
        start = time.monotonic()
        finish(program, folder, "whole", False)
        duration = time.monotonic() - start
        killed, differ = 0, []
        for number in range(kills):
            output = f"killed_{number}"
            for _ in range(chance.choice((1, 2))):
                restart = (folder / output / "checkpoint.h5").exists()
                killed += kill_after(program, folder, output, restart, chance.uniform(0.0, duration))
            finish(program, folder, output, (folder / output / "checkpoint.h5").exists())
            what = difference(folder / "whole", folder / output)
            if what:
                differ.append(f"kill {number}: {what}")
    return killed, differ


def main(argv=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--solvers", nargs="+", default=list(CYCLES), choices=list(CYCLES))
    parser.add_argument("--kills", type=int, default=100, help="runs that are killed, for each (100)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", type=Path, default=TOP / "build" / "femdem")
    arguments = parser.parse_args(argv)
    failed = 0
    for solver in arguments.solvers:
        for cracks in (False, True):
            chance = random.Random(f"{arguments.seed} {solver} {cracks}")
            killed, differ = series(arguments.program.resolve(), solver, cracks, arguments.kills, chance)
            kind = "with cracks" if cracks else "no cracks"
            print(
                f"{solver}, {kind}: {arguments.kills} runs, {killed} kills, {len(differ)} differ", flush=True
            )
            for text in differ[:5]:
                print(f"  {text}")
            failed += len(differ)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
