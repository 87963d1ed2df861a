"""The stack is as stiff as rock and joints in series: 1/E_eff = 1/E' + 1/(k s)."""

from scene_motion import Motion, near

PRESSURE, E, NU, STIFFNESS, SIZE = 1e6, 1e9, 0.25, 4e9, 0.25


def check(results):
    motion = Motion(results)
    # Plane strain, free to widen: E' = E/(1 - nu^2). From the middle of the lowest block to that of the highest there are
    # three blocks and three joints: shortening 3 s p/E_eff. The rock's law is linear in the stretch and the load keeps
    # its direction and size, so that the answer is exact; what is left is the unbalanced force (1e-9) and round-off.
    # The joints feel the Cauchy stress: the section has widened by the lateral strain nu (1 + nu) p/E = 3e-4.
    widened = 1 + NU * (1 + NU) * PRESSURE / E
    shortening = motion.displacement("block_1")[1] - motion.displacement("block_4")[1]
    stiffness = 3 * SIZE * PRESSURE / shortening
    near(stiffness, 1 / ((1 - NU**2) / E + 1 / (STIFFNESS * SIZE * widened)), 1e-6, "E_eff [Pa]")
    near(
        motion.history["joint.normal_stress_MPa"][-1],
        PRESSURE / 1e6 / widened,
        1e-6,
        "normal stress of the joints [MPa]",
    )
    for block in ("block_1", "block_4"):
        stress = motion.stress("stress_yy", block)
        near(stress.min(), PRESSURE / widened, 1e-6, f"least stress_yy of {block} [Pa]")
        near(stress.max(), PRESSURE / widened, 1e-6, f"largest stress_yy of {block} [Pa]")
        assert abs(motion.stress("stress_xx", block)).max() < 1e-6 * PRESSURE, "stress_xx is not zero"
