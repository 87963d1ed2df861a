"""Kill the run (SIGKILL) in either stage, read what is there, restart it, and compare with the run that was left alone."""

from pathlib import Path

import numpy as np

from scene_motion import Results
from scene_restart import go_on, kill_midway, same_fields, same_tables

# Of 80: in the first stage, where the block comes down on the rock, and in the second, where it hops and slides. Not beside a
# snapshot (every fifth): fields.h5 cannot be read when a kill comes while one is written; a restart then sets it aside
# (manual/promises.md)
ROWS = 12, 32, 57


def check(results):
    for rows in ROWS:
        check_kill(results, rows)


def check_kill(results, rows):
    folder = Path(results).parent
    killed = kill_midway(folder, "restart.nml", "history.csv", rows)
    left = Results(killed)
    assert rows <= len(left.history) < 80, f"{len(left.history)} rows after the kill"
    # The snapshot of the last row may not have been written yet
    assert len(left.fields.steps) >= rows // 5 - 1, "snapshots are missing after the kill"
    assert np.isfinite(left.fields.read("displacement")).all(), "the last snapshot is not whole"
    print(f"killed after {len(left.history)} rows, {len(left.fields.steps)} snapshots")
    go_on(folder, "restart.nml", killed)
    same_tables(results, killed, "history.csv")
    same_fields(results, killed, "displacement", "velocity", "stress_xx", "shear_stress_MPa")
