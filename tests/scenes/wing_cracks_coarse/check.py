"""Wing cracks leave the tips of a closed flaw at 70.5 degrees: both tips of one coarse mesh."""

import math

import numpy as np

from scene_wings import wing_angles


def check(results):
    angles = wing_angles(results)
    # Direction of the largest hoop stress in mode II: cos(theta) = 1/3 (Erdogan and Sih 1963)
    expected = math.degrees(math.acos(1 / 3))
    print(f"angles {angles[0]:.1f}, {angles[1]:.1f}: expected {expected:.1f}, mean {np.mean(angles):.1f}")
    assert abs(np.mean(angles) - expected) < 8, f"mean angle {np.mean(angles):.1f}, expected {expected:.1f}"
