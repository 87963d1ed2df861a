"""Local damping, viscous damping and mass scaling are ways to one and the same equilibrium."""

from pathlib import Path

from scene_motion import Motion, changed_deck, near, run_deck

LOCAL = "damping = 'local', damping_factor = 0.8"


def check(results):
    folder = Path(results).parent
    reference = Motion(results).displacement("block_4")[1]
    # Each run ends at an unbalanced force ratio of 1e-9; the slowest mode then carries some 1e-8 of the displacement
    for name, settings in (
        ("viscous", "damping = 'viscous', damping_factor = 1"),
        ("scaled", LOCAL + ", mass_scaling = 'step', scaled_step = 4e-4"),
    ):
        deck = changed_deck(folder, "stack.nml", f"{name}.nml", (LOCAL, settings), ("= 0.5", "= 20"))
        motion = Motion(run_deck(folder, deck, name))
        print(f"{name}: {int(motion.history['step'][-1])} steps")
        near(motion.displacement("block_4")[1], reference, 1e-6, f"settlement, {name} [m]")
