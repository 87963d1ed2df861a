"""The message names stage and place and says what to do; below the friction angle the same block comes to rest."""

import math
from pathlib import Path

from scene_motion import Motion, changed_deck, near, run_deck

GRAVITY, ANGLE, DENSITY = 9.81, math.radians(20), 2700


def check(results):
    folder = Path(results).parent
    said = (folder / "output.txt").read_text(encoding="utf-8")
    for word in ("does not come to rest", "stage 'load'", "x = ", "y = ", "explicit"):
        assert word in said, f"'{word}' is missing in: {said}"

    x, y = GRAVITY * math.sin(ANGLE), GRAVITY * math.cos(ANGLE)
    change = ("gx = 6.3057463 , gy = -7.5148960", f"gx = {x:.8f}, gy = {-y:.8f}")
    motion = Motion(
        run_deck(folder, changed_deck(folder, "slides.nml", "stays.nml", change), "stays", "--quiet")
    )
    assert motion.history["unbalanced_ratio"][-1] <= 1e-6, "the block is not at rest"
    moved = motion.displacement("block")
    print(f"the block moved by {1e6 * moved[0]:.3g} um along the base and {1e6 * moved[1]:.3g} um across it")
    # It falls through the gap of 1 um, and leans and settles elastically: some rho g h^2/E
    settled = 1e-6 + DENSITY * GRAVITY * 0.15**2 / 1e8
    assert abs(moved).max() < 10 * settled, "the block moved more than it leans elastically"
    near(-moved[1] / abs(moved[1]), 1, 0, "sense of the settlement")
