"""Bars through which waves take the same time: they part without vibrations, as rigid bodies after an elastic impact."""

from scene_motion import Motion

SPEED = 1.0


def check(results):
    motion = Motion(results)
    left, right = (motion.nodal_mass(bar).sum() for bar in ("left", "right"))
    # The stress s = v0 Z1 Z2/(Z1 + Z2), Z = rho c, at the face lasts until the waves return from both free ends at the
    # same time 2 T, T = L/c. A unit of face has the mass m = rho L = Z T, so that the momentum passed on is
    # 2 T s = 2 v0 m1 m2/(m1 + m2): v1 = v0 (m1 - m2)/(m1 + m2), v2 = v0 2 m1/(m1 + m2), and nothing goes on vibrating
    # (St Venant; Timoshenko and Goodier, Theory of Elasticity, art. 166). Equal bars exchange their velocities.
    # What is missed is dispersion: the steep front spreads over some elements, more slowly than the bar gets longer.
    for bar, expected in (
        ("left", SPEED * (left - right) / (left + right)),
        ("right", SPEED * 2 * left / (left + right)),
    ):
        found = motion.velocity(bar)[0]
        print(f"velocity of the {bar} bar: expected {expected:.6g}, found {found:.6g} m/s")
        assert abs(found - expected) < 5e-3 * SPEED, (
            f"{bar} bar: expected {expected:.6g}, found {found:.6g} m/s"
        )
    lost = abs(motion.momentum() - [left * SPEED, 0.0]).max() / (left * SPEED)
    print(f"momentum lost: {lost:.3g}; energy drift: {motion.drift() / (left * SPEED**2 / 2):.3g}")
    assert lost < 1e-12, f"{lost:.3g} of the momentum is lost"
    assert motion.drift() < 1e-3 * left * SPEED**2 / 2, f"energy drift {motion.drift()} J/m"
