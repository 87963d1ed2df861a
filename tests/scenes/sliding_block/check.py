"""The block stops after v0^2/(2 mu g), then holds."""

import math

from scene_motion import Motion, near

GRAVITY = 9.81
SPEED = 0.5
FRICTION = math.tan(math.radians(30))


def check(results):
    motion = Motion(results)
    # Newton: the friction mu m g is the only horizontal force, so that m v0^2/2 = mu m g s.
    # Snapshots: 0 load, 1 lead, 2 slide, 3 rest, 4 later. The measured way includes the elastic lean of the block,
    # about mu rho g H^2/(3 G) = 1e-5 m.
    way = motion.displacement("block", 2)[0] - motion.displacement("block", 1)[0]
    near(way, SPEED**2 / (2 * FRICTION * GRAVITY), 5e-3, "stop distance [m]")
    # A spring-slider holds: what is left is the last of the elastic waves (damped), below a billionth of the way
    creep = abs(motion.displacement("block", 4) - motion.displacement("block", 3)).max()
    print(f"creep in 0.04 s [m]: {creep:.3g}")
    assert creep < 1e-9 * way, f"the block creeps {creep:.3g} m in 0.04 s"
    start = motion.nodal_mass("block").sum() * SPEED**2 / 2
    print(f"energy drift: {motion.drift() / start:.3g}")
    assert motion.drift() <= 1e-3 * start, f"energy drift {motion.drift() / start:.3g} of the initial energy"
