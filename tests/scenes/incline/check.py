"""A block on an incline: above the friction angle it slides as a rigid block would, below it stays."""

import math
from pathlib import Path

import numpy as np

from scene_motion import Motion, changed_deck, near, run_deck

GRAVITY = 9.81
FRICTION = math.tan(math.radians(30))
LOAD, SLIDE, LATER = 0.04, 0.1, 0.02


def along(motion, step):
    """Displacement along the base (its bottom edge tells its direction)"""
    return motion.displacement("block", step) @ direction(motion)


def direction(motion):
    x = motion.mesh.coordinates
    base = np.unique(motion.mesh.triangles[motion.triangle_name == "base"])
    # The base is much longer than high: its longest diagonal is off its direction, so take the principal axis
    points = x[base] - x[base].mean(axis=0)
    axis = np.linalg.svd(points, full_matrices=False)[2][0]
    return axis * np.sign(axis[0])


def check(results):
    folder = Path(results).parent
    motion = Motion(results)
    # While the weight grows linearly over T, so do driving force and friction: v = a T/2 at its end. Then the constant
    # acceleration a = g (sin 40 - mu cos 40).
    acceleration = GRAVITY * (math.sin(math.radians(40)) - FRICTION * math.cos(math.radians(40)))
    way = abs(along(motion, 1) - along(motion, 0))
    expected = acceleration * (LOAD / 2 * SLIDE + SLIDE**2 / 2)
    near(way, expected, 5e-3, "displacement while sliding [m]")
    near(
        np.linalg.norm(motion.velocity("block")),
        acceleration * (LOAD / 2 + SLIDE + LATER),
        5e-3,
        "velocity [m/s]",
    )
    work = motion.nodal_mass("block").sum() * GRAVITY * math.sin(math.radians(40)) * way
    print(f"energy drift: {motion.drift() / work:.3g}")
    assert motion.drift() <= 1e-3 * work, (
        f"energy drift {motion.drift() / work:.3g} of the work of the weight"
    )

    deck = changed_deck(folder, "slides.nml", "stays.nml", *stays(folder))
    motion = Motion(run_deck(folder, deck, "stays"))
    creep = abs(motion.displacement("block", 2) - motion.displacement("block", 1)).max()
    print(f"below the friction angle, creep in {LATER} s [m]: {creep:.3g}")
    assert creep < 1e-10, f"the block creeps {creep:.3g} m in {LATER} s below the friction angle"
    assert abs(along(motion, 2)) < 1e-4, "the block moved more than it leans elastically"

    # Eq 4 has no stick (manual, verification): the same block creeps, and what holds is a chatter between +-mu fn.
    deck = changed_deck(folder, "stays.nml", "velocity.nml", ("friction = 'slider'", "friction = 'velocity'"))
    motion = Motion(run_deck(folder, deck, "velocity"))
    velocity_creep = abs(motion.displacement("block", 2) - motion.displacement("block", 1)).max()
    print(
        f"the same with the velocity law (eq 4) [m]: {velocity_creep:.3g}, {velocity_creep / LATER:.3g} m/s"
    )
    assert velocity_creep > 100 * creep, "the velocity law holds as well as the slider: say so in the manual"


def stays(folder):
    """Changes of the deck that make the incline 20 degrees steep"""
    x, y = (GRAVITY * f(math.radians(20)) for f in (math.sin, math.cos))
    given = "gx = 6.3057463 , gy = -7.5148960"
    if given not in (Path(folder) / "slides.nml").read_text(encoding="utf-8"):
        # The base itself is inclined, by 40 degrees: gravity turned back by 20 degrees happens to have the same components
        given = "gx = 0, gy = -9.81"
    return [(given, f"gx = {x:.8f}, gy = {-y:.8f}")]
