"""Blocks that are rigid compared with their contact part with the velocities of an elastic impact."""

from scene_motion import Motion

SPEED = 0.01


def check(results):
    motion = Motion(results)
    left, right = (motion.nodal_mass(bar).sum() for bar in ("left", "right"))
    # Momentum and energy of rigid bodies; what goes into vibrations is below 1e-4 of the energy.
    for bar, expected in (
        ("left", SPEED * (left - right) / (left + right)),
        ("right", SPEED * 2 * left / (left + right)),
    ):
        found = motion.velocity(bar)[0]
        print(f"velocity of the {bar} bar: expected {expected:.6g}, found {found:.6g} m/s")
        assert abs(found - expected) < 5e-3 * abs(expected or SPEED), (
            f"{bar} bar: expected {expected:.6g}, found {found:.6g} m/s"
        )
    lost = abs(motion.momentum() - [left * SPEED, 0.0]).max() / (left * SPEED)
    print(f"momentum lost: {lost:.3g}; energy drift: {motion.drift() / (left * SPEED**2 / 2):.3g}")
    assert lost < 1e-12, f"{lost:.3g} of the momentum is lost"
    assert motion.drift() < 1e-3 * left * SPEED**2 / 2, f"energy drift {motion.drift()} J/m"
