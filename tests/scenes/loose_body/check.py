"""The message names the stage and the place; held by weak springs, the balanced load has its answer."""

from pathlib import Path

from scene_motion import Motion, changed_deck, near, output_says, run_deck


def check(results):
    folder = Path(results).parent
    output_says(results, "stage 'load'", "nothing holds", "x = ", "y = ", "loose_bodies", "explicit")
    end = "&stage name = 'load', move_time = 1 /"
    deck = changed_deck(folder, "loose.nml", "held.nml", (end, end + "\n&implicit loose_bodies = 'hold' /"))
    motion = Motion(run_deck(folder, deck, "held", "--quiet"))
    near(motion.history["joint.normal_stress_MPa"][-1], 1.0, 1e-3, "normal stress of the held blocks [MPa]")
