"""Stresses under a column's own weight."""

import numpy as np

from scene_motion import Motion

HEIGHT, DENSITY, GRAVITY, YOUNG, NU, ROWS = 10.0, 2700.0, 9.81, 1e9, 0.25, 20


def check(results):
    motion = Motion(results)
    middle = motion.mesh.coordinates[motion.mesh.triangles][:, :, 1].mean(axis=1)
    row = (middle / (HEIGHT / ROWS)).astype(int)
    vertical, horizontal = (motion.stress(name, "rock") for name in ("stress_yy", "stress_xx"))
    bottom = DENSITY * GRAVITY * HEIGHT
    # Equilibrium of what lies above the middle of a row of elements: its mean stress_yy is rho g times the depth, the
    # lumped weight being right too. Between smooth walls stress_xx = nu/(1 - nu) stress_yy. Tolerance: strains of 2e-4
    # that change the sections, and the unbalanced force.
    for i in range(ROWS):
        mean = np.average(vertical[row == i], weights=motion.area[row == i])
        lateral = np.average(horizontal[row == i], weights=motion.area[row == i])
        depth = HEIGHT - (i + 0.5) * HEIGHT / ROWS
        expected = DENSITY * GRAVITY * depth
        assert abs(mean - expected) < 3e-4 * bottom, f"stress_yy at depth {depth}: {mean} for {expected}"
        assert abs(lateral - NU / (1 - NU) * expected) < 3e-4 * bottom, (
            f"stress_xx at depth {depth}: {lateral}"
        )
        if i == 0:
            print(f"stress_yy in the lowest row: expected {expected:.6g}, found {mean:.6g} Pa")
    # Settlement of the top rho g H^2/(2 M), M the oedometer modulus; exact at the nodes of a one-dimensional column
    x = motion.mesh.coordinates
    top = motion.fields.read("displacement")[np.isclose(x[:, 1], HEIGHT), 1].mean()
    modulus = YOUNG * (1 - NU) / ((1 + NU) * (1 - 2 * NU))
    expected = -DENSITY * GRAVITY * HEIGHT**2 / (2 * modulus)
    print(f"settlement: expected {expected:.6g}, found {top:.6g} m ({top / expected - 1:+.2e})")
    assert abs(top - expected) < 3e-4 * abs(expected), f"settlement {top} for {expected}"
