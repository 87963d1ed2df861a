"""The jobs of a sweep, called by the workflow in the sweep's folder: python3 -m femdem.sweep.job mesh KEY | run KEY.

A job that fails says so in its ended.json and ends well, so that the others go on. A job that has ended with what it would start
from now is not done again, whatever the workflow believes: of a job that is interrupted as it ends, Snakemake takes the flag away.
One that outlives a sweep that was killed is waited for.
"""

import contextlib
import csv
import ctypes
import fcntl
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from femdem.places import environment
from femdem.results import Results, ResultsError
from femdem.sweep.collect import collect
from femdem.sweep.plan import Plan

ENDED, FLAG = "ended.json", "ended.flag"  # how a job ended, and that it has ended: the flag is the workflow's
LOCK = "job.lock"
DONE, FAILED = "done", "failed"
PR_SET_PDEATHSIG = 1  # of prctl, on Linux
TABLE = "table.csv"
# One run, one core: the workflow starts as many as there are cores
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def write_ended(folder, made_from, message, seconds):
    """Write ended.json; a reader sees it whole or not at all"""
    part = folder / f"{ENDED}.part"
    ended = {
        "status": FAILED if message else DONE,
        "message": message,
        "seconds": round(seconds, 3),
        "made_from": made_from,
    }
    part.write_text(json.dumps(ended) + "\n", encoding="utf-8")
    os.replace(part, folder / ENDED)


def read_ended(folder, made_from):
    """How a job ended that was made from this; a status of its own when it has not"""
    try:
        ended = json.loads((Path(folder) / ENDED).read_text(encoding="utf-8"))
        if ended["made_from"] == made_from:
            return ended
    except (OSError, ValueError, KeyError):
        pass
    return {"status": "not run", "message": "", "seconds": math.nan}


def once(plan, folder, key, work):
    """Do a job that has not ended yet, and raise its flag"""
    made_from, start = plan.made_from[key], time.monotonic()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if read_ended(folder, made_from)["status"] not in (DONE, FAILED):
            (folder / ENDED).unlink(missing_ok=True)
            message = work(plan, folder, key)
            write_ended(folder, made_from, message, time.monotonic() - start)
    (folder / FLAG).touch()


def die_with_parent():
    """Let a process that is started die with this one: what nobody waits for would be in the way of who does it again"""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def call(command, folder, log):
    """Run a command in a folder, all it says in a log; what went wrong, in a line"""
    with (folder / log).open("a", encoding="utf-8") as file:
        threads = {name: os.environ.get(name, "1") for name in THREADS}
        try:
            done = subprocess.run(
                command,
                cwd=folder,
                env={**environment(), **threads},
                stdout=file,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
                check=False,
                preexec_fn=die_with_parent,
            )
        except OSError as error:
            return f"{command[0]}: {error.strerror}"
        file.write(done.stderr)
    if done.returncode == 0:
        return ""
    errors = [line.removeprefix("error: ") for line in done.stderr.splitlines() if line.startswith("error: ")]
    if errors:
        return errors[0] + (f" (and {len(errors) - 1} more)" if len(errors) > 1 else "")
    last = done.stderr.strip().splitlines()
    ended = f"signal {-done.returncode}" if done.returncode < 0 else f"status {done.returncode}"
    return f"ended with {ended}" + (f": {last[-1]}" if last else "")


def make_mesh(plan, folder, key):
    """Run the mesh commands of a key; what went wrong"""
    (folder / "mesh.log").unlink(missing_ok=True)
    mesh = plan.meshes[key]
    for command in mesh["commands"]:
        message = call(command, folder, "mesh.log")
        if message:
            return message
    there = (folder / mesh["product"]).is_file()
    return "" if there else f"{mesh['product']} is not there after the commands that should make it"


def do_run(plan, folder, key):
    """Run the program on the deck of a key; what went wrong"""
    (folder / "output.log").unlink(missing_ok=True)
    mesh = next(run["mesh"] for run in plan.runs if run["key"] == key)
    if mesh:
        ended = read_ended(Path("meshes") / mesh, plan.made_from[mesh])
        if ended["status"] != DONE:
            return f"no mesh: {ended['message']}"
    return call([plan.program, "--quiet", "--output", "results", "deck.nml"], folder, "output.log")


def row_of(plan, place, number, run):
    """Row of the table: parameters, how it ended, what is collected"""
    folder = Path("runs") / run["key"]
    status = read_ended(place / folder, plan.made_from[run["key"]])
    status.pop("made_from", "")
    row = {"run": number, **run["parameters"], **status, "results": str(folder / "results")}
    wrong = []
    if status["status"] == DONE:
        results = Results(place / folder / "results")
        wanted = plan.collect or {f"history.{name}": f"history.{name}" for name in results.history.columns}
        for name, specification in wanted.items():
            try:
                row[name] = collect(results, specification)
            except (ResultsError, OSError, KeyError, ValueError) as error:
                wrong.append(f"{name}: {error}")
    if wrong:
        row["message"] = "; ".join([*filter(None, [row["message"]]), *wrong])
    return row


def make_table(plan, place):
    """Write table.csv of the sweep in a place, a row a run, beside the old one, and rename it; its path"""
    rows = [row_of(plan, place, number, run) for number, run in enumerate(plan.runs, start=1)]
    names = list(dict.fromkeys(name for row in rows for name in row))
    part = place / f"{TABLE}.part"
    with open(part, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names, restval="")
        writer.writeheader()
        writer.writerows(rows)
    os.replace(part, place / TABLE)
    return place / TABLE


def main():
    plan = Plan.read(".")
    what, key = sys.argv[1:]
    folder, work = {"mesh": ("meshes", make_mesh), "run": ("runs", do_run)}[what]
    once(plan, Path(folder) / key, key, work)


if __name__ == "__main__":
    main()
