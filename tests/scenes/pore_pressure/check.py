"""Terzaghi: rock and joint feel the total stress less the pressure, with Biot coefficient 1; less of it with a smaller one."""

from pathlib import Path

from scene_motion import Motion, changed_deck, near, run_deck

TOTAL, SIDE, FLUID = 1e6, 0.4e6, 0.4e6
PORE = "&pore_pressure group = 'all', pressure = 0.4e6, biot = 1 /\n"


def stresses(motion, biot, name):
    # The stretch of the section, some 1e-4, is not in the formula
    near(motion.history["joint.normal_stress_MPa"][-1], (TOTAL - FLUID) / 1e6, 1e-3, f"{name}: joint [MPa]")
    for block in ("block_1", "block_2"):
        vertical, across = motion.stress("stress_yy", block), motion.stress("stress_xx", block)
        near(vertical.mean(), TOTAL - biot * FLUID, 1e-3, f"{name}: stress_yy of {block} [Pa]")
        assert abs(vertical - vertical.mean()).max() < 1e-3 * TOTAL, "stress_yy is not uniform"
        assert abs(across - (SIDE - biot * FLUID)).max() < 1e-3 * TOTAL, (
            "stress_xx is not the side's less the pressure"
        )


def check(results):
    folder = Path(results).parent
    stresses(Motion(results), 1.0, "biot 1")
    half = changed_deck(folder, "pore.nml", "half.nml", ("biot = 1", "biot = 0.5"))
    stresses(Motion(run_deck(folder, half, "half")), 0.5, "biot 0.5")
    histories = []
    for name, text in (("dry", ""), ("no_pressure", PORE.replace("0.4e6", "0"))):
        deck = changed_deck(folder, "pore.nml", f"{name}.nml", (PORE, text))
        histories.append((run_deck(folder, deck, name) / "history.csv").read_bytes())
    assert histories[0] == histories[1], "a pressure of zero changes the dry answer"
