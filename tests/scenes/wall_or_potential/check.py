"""Wall contact and potential contact give the same mean stresses of one joint."""

from pathlib import Path

import numpy as np

from scene_motion import Results, changed_deck, near, run_deck


def check(results):
    folder = Path(results).parent
    deck = changed_deck(folder, "shear.nml", "potential.nml", ("contact = 'wall'", "contact = 'potential'"))
    runs = {"wall": results, "potential": run_deck(folder, deck, "potential")}
    mean = {}
    for name, directory in runs.items():
        history = Results(directory).history
        late = history["time_s"] > 0.016  # the joint slides all along
        normal, shear = (history[f"joint.{q}_stress_MPa"] for q in ("normal", "shear"))
        # Coulomb: all of the joint slides, so that the mean shear stress is tan(30) times the mean normal stress, and
        # the mean normal stress carries the load on the top
        near(np.mean(shear[late] / normal[late]), np.tan(np.radians(30)), 5e-3, f"friction, {name} contact")
        near(normal[late].mean(), 1.0, 5e-3, f"normal stress, {name} contact [MPa]")
        mean[name] = shear[late].mean()
    near(mean["potential"], mean["wall"], 5e-3, "shear stress, potential against wall contact [MPa]")
