"""The shear force, step by step, from the work of the drive: it softens to the residual friction and goes on from there.

Bonds act over the whole length, walls where they overlap: when the walls take over, the force falls by what has slid off over the
length, and with every step by what slides off in it. What slides off stores nothing any more: that pushes it on.
"""

import csv

import numpy as np

from scene_motion import Results, near

RATE, STEP, LENGTH = 0.2, 5e-7, 0.1
START = 1e-4  # of the shearing [s]
CLOSURE = 2e-3 * START  # what the pressing stage has pushed the walls into each other [m]
YOUNG, FACTOR, SIZE, FRICTION = 30e9, 20.0, 0.02, np.tan(np.radians(20))


def check(results):
    history = Results(results).history
    shear = history["stage"] == 2
    # Work over way: the mean of the forces at the start and the end of a step, N per m of thickness
    time = history["time_s"][shear][:-1]
    force = np.diff(history["external_J"][shear]) / (RATE * STEP)
    with open(results / "cracks.csv", encoding="utf-8") as file:
        broken = np.array([float(row["time_s"]) for row in csv.DictReader(file)])
    assert len(broken) == 5, f"{len(broken)} of 5 joints have broken"
    assert np.ptp(broken) < STEP, "the joints do not part together"
    parted = int(np.searchsorted(time, broken[0] - 0.5 * STEP))
    assert 100 < parted < len(time) - 100, "the joints part too early or too late"

    # The bodies are rigid: pressure is stiffness times closure, friction follows
    friction = FRICTION * FACTOR * YOUNG / SIZE * CLOSURE * LENGTH
    near(force[parted - 2], friction, 1e-7, "friction in the bonds, before")
    left = 1 - RATE * (time + 0.5 * STEP - START) / LENGTH
    stored = 0.5 * FACTOR * YOUNG / SIZE * CLOSURE**2  # J/m for each metre of wall, or N/m
    force_after = friction * left - stored
    near(force[parted], force_after[parted], 1e-6, "friction of the walls, after")
    near(force[-1], force_after[-1], 1e-6, "friction of the walls, at the end")
    error = np.abs(force[parted:] / force_after[parted:] - 1).max()
    assert error < 1e-6, f"the friction of the walls is off by {error:.1e}"
    # The contact has got what the bonds stored, and loses what slides off
    near(
        history["contact_J"][-1],
        stored * LENGTH * (1 - left[parted] + left[-1]),
        1e-5,
        "what the walls store",
    )
