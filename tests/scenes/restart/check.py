"""Kill the run midway (SIGKILL), read what is there, restart it, and compare with the run that was left alone."""

import os
import subprocess
import time
from pathlib import Path

import numpy as np
from scene_motion import Results

ROWS = 30  # of 80: in the middle of the second stage


def check(results):
    folder = Path(results).parent
    whole = (Path(results) / "history.csv").read_text(encoding="utf-8")
    killed = folder / "killed"
    for restart in (False, True):
        arguments = ["--restart", killed / "checkpoint.h5"] if restart else []
        command = [os.environ["FEMDEM"], "--quiet", *arguments, "--output", killed, "restart.nml"]
        with subprocess.Popen(command, cwd=folder) as run:
            if restart:
                assert run.wait(timeout=120) == 0, "the restarted run failed"
                break
            while run.poll() is None and rows(killed / "history.csv") < ROWS:
                time.sleep(0.005)
            assert run.poll() is None, "the run ended before it could be killed"
            run.kill()
        left = Results(killed)
        assert ROWS <= len(left.history) < 80, f"{len(left.history)} rows after the kill"
        # The snapshot of the last row may not have been written yet
        assert len(left.fields.steps) >= ROWS // 5 - 1, "snapshots are missing after the kill"
        assert np.isfinite(left.fields.read("displacement")).all(), "the last snapshot is not whole"
        print(f"killed after {len(left.history)} rows, {len(left.fields.steps)} snapshots")
    assert (killed / "history.csv").read_text(encoding="utf-8") == whole, (
        "the restarted run has another history"
    )
    a, b = Results(results).fields, Results(killed).fields
    assert a.steps == b.steps, "the restarted run has other snapshots"
    for name in ("displacement", "velocity", "stress_xx", "shear_stress_MPa"):
        assert (a.read(name) == b.read(name)).all(), f"{name} differs after the restart"


def rows(path):
    return path.read_text(encoding="utf-8").count("\n") - 1 if path.exists() else 0
