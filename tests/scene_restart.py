"""Runs that are killed and go on: for the check.py of scenes about restarts."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np

from femdem.results import Results

ATTEMPTS = 5


def rows(path):
    """Rows of a table below its heading; 0 when there is no table"""
    return path.read_text(encoding="utf-8").count("\n") - 1 if path.exists() else 0


def kill_midway(folder, deck, table, enough):
    """Start a deck again and kill it (SIGKILL) as soon as a table of its results has enough rows; the results directory.

    On a busy machine the run may end before it is killed; then once more."""
    killed = Path(folder) / "killed"
    command = [os.environ["FEMDEM"], "--quiet", "--output", killed, deck]
    for _ in range(ATTEMPTS):
        shutil.rmtree(killed, ignore_errors=True)
        with subprocess.Popen(command, cwd=folder) as run:
            while run.poll() is None and rows(killed / table) < enough:
                time.sleep(0.005)
            run.kill()
        if run.returncode != 0:
            return killed
    raise AssertionError("the run ended before it could be killed")


def go_on(folder, deck, killed):
    """Restart a killed run from its checkpoint, in its own results directory."""
    command = [
        os.environ["FEMDEM"],
        "--quiet",
        "--restart",
        killed / "checkpoint.h5",
        "--output",
        killed,
        deck,
    ]
    assert subprocess.run(command, cwd=folder, timeout=120, check=False).returncode == 0, (
        "the restarted run failed"
    )


def same_tables(one, other, *tables):
    """Assert that tables are the same, byte for byte."""
    for table in tables:
        assert (one / table).read_bytes() == (other / table).read_bytes(), (
            f"another {table} after the restart"
        )


def same_fields(one, other, *names, every=True):
    """Assert that two runs have the same snapshots (of the same numbers), and the same fields in the last one."""
    a, b = Results(one).fields, Results(other).fields
    assert not every or a.steps == b.steps, "the restarted run has other snapshots"
    for name in names:
        found, expected = b.read(name), a.read(name)
        assert np.array_equal(found, expected), f"{name} differs after the restart"
        assert np.isfinite(found).all(), f"{name} is not finite"
