"""The front of a P-wave travels at sqrt(M/rho), with the stress rho c V behind it."""

import math

from scene_motion import Motion, near

DENSITY, YOUNG, NU, SPEED = 2500.0, 1e9, 0.25, 0.1


def check(results):
    motion = Motion(results)
    wave = math.sqrt(YOUNG * (1 - NU) / ((1 + NU) * (1 - 2 * NU)) / DENSITY)
    first, second = front(motion, 0), front(motion, 1)
    # The front spreads over some elements by dispersion; its place is that of a sharp front with the same momentum
    near((second - first) / (motion.fields.times[1] - motion.fields.times[0]), wave, 5e-3, "wave speed [m/s]")
    near(second, 0.8, 5e-3, "place of the front after 0.8 m/c [m]")
    # Momentum balance at the front; the mean over the bar behind it takes out the ripple that follows a steep front
    middle = motion.mesh.coordinates[motion.mesh.triangles][:, :, 0].mean(axis=1)
    near(
        motion.stress("stress_xx", "bar")[middle < 0.6].mean(),
        DENSITY * wave * SPEED,
        5e-3,
        "stress behind [Pa]",
    )


def front(motion, step):
    """Length of bar that has the velocity V and as much momentum as there is"""
    return motion.momentum(step)[0] / SPEED / motion.nodal_mass().sum()  # of a bar 1 m long
