"""Friction alone: slip along the crack against 4(1 - nu^2)/E (tau - sn tan phi) sqrt(b^2 - x^2)."""

import numpy as np

from femdem.results import Results
from scene_crack import ANGLE, HALF_LENGTH, MODULUS, STRESS, check_slip, reference_slip, resolved
from scene_motion import near

FRICTION = 15.0


def check(results):
    normal, shear = resolved(STRESS, ANGLE)
    strength = normal * np.tan(np.radians(FRICTION))
    check_slip(
        results, "crack.nml", lambda x: reference_slip(x, HALF_LENGTH, MODULUS, shear, np.inf, strength)
    )
    fields = Results(results).fields
    inner = np.hypot(*fields.mesh().joint_lines.mean(axis=1).T) < 0.9 * HALF_LENGTH
    pressure = fields.read("normal_stress_MPa")[inner] * 1e6
    near(pressure.mean(), normal, 0.002, "mean normal stress on the crack [Pa]")
