"""Strength as the explicit scene's; the energy account closes to rounding before the peak; the collapse is told."""

import math
from pathlib import Path

import numpy as np
from scene import read_history

WIDTH, RATE = 0.5, 0.1
COHESION, FRICTION = 15e6, math.radians(26.6)
# Forces of an increment are taken as the mean of its start and end; found: 1e-11 of the work put in
ENERGY = 1e-6


def check(results):
    history = read_history(results / "history.csv")
    time = np.concatenate([[0.0], history["time_s"]])
    work = np.concatenate([[0.0], history["external_J"]])
    stress = np.diff(work) / (np.diff(time) * RATE * WIDTH)
    expected = 2 * COHESION * math.cos(FRICTION) / (1 - math.sin(FRICTION))
    print(f"strength: found {stress.max() / 1e6:.2f} MPa ({stress.max() / expected - 1:+.2%})")
    assert abs(stress.max() / expected - 1) < 0.1, (
        f"strength {stress.max() / 1e6:.2f}, expected {expected / 1e6:.2f} MPa"
    )
    peak = int(stress.argmax())
    residual = abs(history["residual_J"][peak]) / history["external_J"][peak]
    print(f"energy residual at the peak: {residual:.1e} of the work put in")
    assert residual < ENERGY, f"energy residual {residual:.1e}"
    assert history["fracture_J"][peak] > 0, "nothing has softened before the peak"
    log = (Path(results) / "run.log").read_text(encoding="utf-8")
    for words in ("no equilibrium found at time", "steps of pseudo-time"):
        assert words in log, f"the collapse is not told: no '{words}' in run.log"
