"""The bodies are rigid: the pressure of the walls is stiffness times closure, to 5 % of Young's modulus, 48 times the strength."""

import numpy as np

from scene_motion import Results, near

LENGTH, YOUNG, FACTOR, SIZE = 0.1, 0.8e9, 20.0, 0.02
PRESS, SHEAR, MORE = 2e-3, 0.2, 0.02  # speeds [m/s]
PRESSED, SHEARED, STEP = 1e-4, 6e-4, 4e-5  # durations of the stages, and of a cycle of the last [s]


def check(results):
    history = Results(results).history
    more = history["stage"] == 3
    work = np.diff(
        np.concatenate([history["external_J"][history["stage"] == 2][-1:], history["external_J"][more]])
    )
    force = work / (MORE * STEP)
    left = LENGTH - SHEAR * SHEARED
    closure = PRESS * PRESSED + MORE * STEP * (np.arange(more.sum()) + 0.5)
    expected = FACTOR * YOUNG / SIZE * closure * left
    near(force[-1] / left, 38.2e6, 0.02, "pressure at the end")
    error = np.abs(force[1:] / expected[1:] - 1).max()
    assert error < 0.01, f"the pressure is off by {error:.1e}"
