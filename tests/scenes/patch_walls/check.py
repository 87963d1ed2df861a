"""Uniform stress above a joint whose walls do not match."""

from scene_motion import Motion, near

PRESSURE, E, NU = 1e6, 1e9, 0.25


def check(results):
    motion = Motion(results)
    # Exact: the linear displacement is in the space of the elements, and wall contact integrates a constant pressure
    # exactly over any pair of edges. Cauchy stress: the section has widened by nu (1 + nu) p/E.
    widened = 1 + NU * (1 + NU) * PRESSURE / E
    stress = motion.stress("stress_yy", "upper")
    near(stress.min(), PRESSURE / widened, 1e-6, "least stress_yy [Pa]")
    near(stress.max(), PRESSURE / widened, 1e-6, "largest stress_yy [Pa]")
    for name in ("stress_xx", "stress_xy"):
        largest = abs(motion.stress(name, "upper")).max() / PRESSURE
        print(f"largest {name} over the pressure: {largest:.3g}")
        assert largest < 1e-6, f"{name} reaches {largest:.3g} of the pressure"
