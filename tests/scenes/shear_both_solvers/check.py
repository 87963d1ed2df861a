"""The same box driven slowly by the explicit solver."""

from pathlib import Path

import numpy as np

from scene_motion import Motion, run_deck


def check(results):
    folder = Path(results).parent
    implicit = Motion(results).history
    explicit = Motion(run_deck(folder, "shear_6cm_explicit.nml", "explicit", "--quiet", timeout=600)).history
    # Both settle under the load first; the slip between is that of the joint's elastic shear. Driven at 20 mm/s the
    # explicit run has waves of some parts in a thousand
    for name, tolerance in (("shear_stress_MPa", 0.01), ("normal_stress_MPa", 0.01), ("dilation_mm", 0.01)):
        ours, theirs = implicit[f"joint.{name}"], explicit[f"joint.{name}"]
        theirs = np.interp(
            implicit["joint.shear_displacement_mm"], explicit["joint.shear_displacement_mm"], theirs
        )
        inside = implicit["joint.shear_displacement_mm"] < explicit["joint.shear_displacement_mm"][-1]
        error = np.sqrt(np.mean((ours - theirs)[inside] ** 2)) / abs(theirs).max()
        print(f"{name}: rms difference {100 * error:.3f} % of the largest value")
        assert error < tolerance, f"{name}: explicit and implicit differ by {100 * error:.2f} % rms"
