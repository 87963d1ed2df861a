"""The whole curve against eq 13, and the energy account."""

import numpy as np

from femdem.jcm import Joint
from scene_motion import Motion

NORMAL_STRESS = 0.0245


def check(results):
    history = Motion(results).history
    joint = Joint(jrc0=15, jcs0=2, l0=0.06, phi_r=32, length=0.06)
    u, tau = history["joint.shear_displacement_mm"], history["joint.shear_stress_MPa"]
    error = (tau - joint.shear_stress(u, NORMAL_STRESS)) / joint.peak_shear_stress(NORMAL_STRESS)
    rms = np.sqrt(np.mean(error**2))
    print(f"error of the shear stress: {100 * rms:.3f} % rms, {100 * abs(error).max():.2f} % at most")
    assert rms < 5e-3, f"rms error {100 * rms:.3f} % of the peak"
    residual, external = history["residual_J"][-1], history["external_J"][-1]
    # Forces are taken as the mean of start and end of each increment, exact to second order
    assert abs(residual) < 1e-5 * external, f"energy residual {residual:.3g} J of {external:.3g} J"
