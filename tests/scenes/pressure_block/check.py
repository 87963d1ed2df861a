"""Uniform stress under pressure all round, and the strain that belongs to it, at a strain of several per cent."""

from scene_motion import Motion, near

PRESSURE, E, NU = 5e7, 1e9, 0.25


def check(results):
    motion = Motion(results)
    # Cauchy stress = pressure in every element, to the unbalanced force (1e-9)
    for name in ("stress_xx", "stress_yy"):
        near(motion.stress(name, "block").min(), PRESSURE, 1e-6, f"least {name} [Pa]")
        near(motion.stress(name, "block").max(), PRESSURE, 1e-6, f"largest {name} [Pa]")
    assert abs(motion.stress("stress_xy", "block")).max() < 1e-6 * PRESSURE, "stress_xy is not zero"
    # Stretch s: the law gives the nominal stress 2 (mu + lambda)(s - 1), the pressure on the shrunken sides is -p s
    modulus = E / ((1 + NU) * (1 - 2 * NU))
    stretch = modulus / (modulus + PRESSURE)
    x, u = motion.mesh.coordinates, motion.fields.read("displacement")
    for axis in (0, 1):
        sides = [u[x[:, axis] == end(x[:, axis]), axis].mean() for end in (min, max)]
        length = x[:, axis].max() - x[:, axis].min()
        near(1 + (sides[1] - sides[0]) / length, stretch, 1e-6, f"stretch along axis {axis}")
