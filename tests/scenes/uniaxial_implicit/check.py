"""Strength as the explicit scene's; energy closes before the peak; the collapse is told; relaxation finds the same."""

import math
from pathlib import Path

import numpy as np

from scene import read_history
from scene_motion import changed_deck, near, run_deck

WIDTH, RATE = 0.5, 0.1
COHESION, FRICTION = 15e6, math.radians(26.6)
# Forces of an increment are taken as the mean of its start and end; found: 1e-11 of the work put in
ENERGY = 1e-6
# Implicit and relaxation solver, up to the peak. Found: 3e-10 in the work put in, 5e-7 in that on bonds
SAME = 1e-4


def check(results):
    history = read_history(results / "history.csv")
    # The last row is that of the collapse, no rest
    at_rest = history["unbalanced_ratio"] < 1e-4
    assert not at_rest[-1], "the collapse is not recorded"
    history = {name: values[at_rest] for name, values in history.items()}
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
    for words in ("no rest at time", "load level"):
        assert words in log, f"the collapse is not told: no '{words}' in run.log"

    folder = Path(results).parent
    before_peak = ("cycles = 60, move_time = 3e-4", f"cycles = {peak + 1}, move_time = 3e-4")
    deck = changed_deck(folder, "compress.nml", "relaxation.nml", ("'implicit'", "'relaxation'"), before_peak)
    other = read_history(run_deck(folder, deck, "relaxation", "--quiet") / "history.csv")
    for name in ("external_J", "fracture_J"):
        near(other[name][peak], history[name][peak], SAME, f"{name} at the peak, relaxation against implicit")
