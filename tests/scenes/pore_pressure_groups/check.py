"""Which cracks and bonds a pore pressure acts on, and how much of it."""

from pathlib import Path

import numpy as np

from scene_motion import Motion, changed_deck, near, run_deck

FLUID, STRENGTH = 8e6, 7e6
FREE = "&pore_pressure group = 'right', pressure = 8e6, biot = 0 /"


def cracks(results):
    return len((Path(results) / "cracks.csv").read_text().splitlines()) - 1


def largest_stress(motion, body):
    return max(np.abs(motion.stress(f"stress_{ij}", body)).max() for ij in ("xx", "yy", "xy"))


def check(results):
    folder = Path(results).parent
    motion = Motion(results)
    for body in ("left", "mid", "right"):
        assert largest_stress(motion, body) < 1e-6 * FLUID, f"{body} feels the fluid of 'right' without biot"
    assert cracks(results) == 0

    # Free rock full of fluid: the skeleton carries a tension of biot p, in triangles and bonds alike; 4 MPa hold
    half = changed_deck(
        folder, "pore.nml", "half.nml", (FREE, "&pore_pressure group = 'all', pressure = 8e6, biot = 0.5 /")
    )
    results = run_deck(folder, half, "half")
    motion = Motion(results)
    for body in ("left", "mid", "right"):
        # The bonds that open make the middle wider than its neighbours, which hold it back by a percent
        near(motion.stress("stress_xx", body).mean(), -0.5 * FLUID, 0.02, f"{body}: stress_xx [Pa]")
        near(motion.stress("stress_yy", body).mean(), -0.5 * FLUID, 0.02, f"{body}: stress_yy [Pa]")
    # A bond's stiffness is penalty_factor E over the size of its elements: 1/3 m and the like
    opening = motion.fields.read("opening_mm")
    assert opening.min() > 0, f"bonds open {opening} mm"
    assert opening.max() < 2 * 0.5 * FLUID / (20 * 30e9) * 1e3, f"bonds open {opening} mm"
    assert cracks(results) == 0

    # A surface of its own goes before 'all': no fluid in the middle
    dry = changed_deck(
        folder,
        "half.nml",
        "dry.nml",
        ("biot = 0.5 /", "biot = 0.5 /\n&pore_pressure group = 'mid', pressure = 0 /"),
    )
    motion = Motion(run_deck(folder, dry, "dry"))
    assert np.abs(motion.stress("stress_yy", "mid").mean()) < 0.1 * FLUID

    # More than the strength breaks the bonds
    full = changed_deck(folder, "half.nml", "full.nml", ("biot = 0.5 /", "biot = 1 /"))
    run_deck(folder, full, "full", status=1)
    said = (folder / "full.txt").read_text()
    assert "no rest at" in said, f"bonds hold {FLUID} Pa beyond their strength {STRENGTH} Pa\n{said}"
