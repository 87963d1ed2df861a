"""Slip along the crack against 4(1 - nu^2)/E (tau - sn tan phi) sqrt(b^2 - x^2)."""

import numpy as np
from scene_motion import Motion, near

STRESS, FRICTION, STRIKE, HALF_LENGTH = 10e6, 15.0, 45.0, 0.1
E, NU = 30e9, 0.27


def check(results):
    fields = Motion(results).fields
    mesh = fields.mesh()
    place = mesh.joint_lines.mean(axis=1)
    x = np.hypot(*place.T)
    slip = np.abs(fields.read("shear_displacement_mm")) / 1000
    # psi: between the crack and the stress, which is along y
    psi = np.radians(90 - STRIKE)
    normal, shear = STRESS * np.sin(psi) ** 2, STRESS * np.sin(psi) * np.cos(psi)
    driving = shear - normal * np.tan(np.radians(FRICTION))
    exact = 4 * (1 - NU**2) / E * driving * np.sqrt(np.maximum(HALF_LENGTH**2 - x**2, 0))
    centre = np.argsort(x)[:2]
    # Bar of 2 %; found 1.1 % too little, which halves with the element size (h/b 4, 2, 1 %: 2.0, 1.1, 0.57 %)
    near(slip[centre].mean(), exact[centre].mean(), 0.02, "slip at the centre [m]")
    inside = x < 0.9 * HALF_LENGTH
    worst = np.max(np.abs(slip - exact)[inside]) / exact.max()
    print(f"worst difference over the inner 90 %: {100 * worst:.2f} % of the slip at the centre")
    assert worst < 0.03, f"the profile is off by {100 * worst:.2f} %"
    pressure = fields.read("normal_stress_MPa")[inside] * 1e6
    near(pressure.mean(), normal, 0.02, "mean normal stress on the crack [Pa]")
