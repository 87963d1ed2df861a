"""Kill the run midway (SIGKILL), read what is there, restart it, and compare with the run that was left alone."""

from pathlib import Path

import numpy as np

from scene_motion import Results
from scene_restart import go_on, kill_midway, same_fields, same_tables

ROWS = 30  # of 80: in the middle of the second stage


def check(results):
    folder = Path(results).parent
    killed = kill_midway(folder, "restart.nml", "history.csv", ROWS)
    left = Results(killed)
    assert ROWS <= len(left.history) < 80, f"{len(left.history)} rows after the kill"
    # The snapshot of the last row may not have been written yet
    assert len(left.fields.steps) >= ROWS // 5 - 1, "snapshots are missing after the kill"
    assert np.isfinite(left.fields.read("displacement")).all(), "the last snapshot is not whole"
    print(f"killed after {len(left.history)} rows, {len(left.fields.steps)} snapshots")
    go_on(folder, "restart.nml", killed)
    same_tables(results, killed, "history.csv")
    same_fields(results, killed, "displacement", "velocity", "stress_xx", "shear_stress_MPa")
