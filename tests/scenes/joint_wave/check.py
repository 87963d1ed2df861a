"""Closure of a joint under a wave: d delta/dt = 2 v_i - 2 sigma(delta)/z (Zhao and Cai 2001)."""

import numpy as np
from scipy.integrate import solve_ivp

from scene_motion import Results, near

IMPEDANCE = 2500 * 2000  # z = rho c [Pa s/m]
ARRIVAL, RISE, STRESS = 0.5e-3, 0.5e-3, 1e6
JRC, JCS, APERTURE = 10, 50, 10 / 50  # the joint has its laboratory length; eq 10 with JCS0 = sigma_c [mm]
STIFFNESS = -7.15 + 1.75 * JRC + 0.02 * JCS / APERTURE  # eq 6 [MPa/mm]
LARGEST = -0.1032 - 0.0074 * JRC + 1.1350 * (JCS / APERTURE) ** -0.2510  # eq 7 [mm]


def check(results):
    history = Results(results).history
    time, found = history["time_s"], history["joint.closure_mm"]

    # The incident wave, unchanged as it comes, and the reflected one: the joint's stress is sigma = z (v_i - v_r)
    # on the left and z v_t on the right, d delta/dt the difference of the walls' velocities v_i + v_r - v_t.
    def rate(t, closure):
        incident = STRESS * np.clip((t - ARRIVAL) / RISE, 0, 1) / IMPEDANCE
        stress = 1e6 * STIFFNESS * closure / (1 - closure / LARGEST)  # eq 5a
        return 1e3 * (2 * incident - 2 * stress / IMPEDANCE)

    wanted = solve_ivp(rate, (0, time[-1]), [0.0], t_eval=time, max_step=1e-6, rtol=1e-8).y[0]
    worst = abs(found - wanted).max() / wanted.max()
    print(f"largest difference of the closure over the largest closure: {worst:.3g}")
    near(found[-1], wanted[-1], 5e-3, "closure at the end [mm]")
    # Dispersion rounds the kinks of the incident wave over some elements
    assert worst < 5e-3, f"the closure differs by {worst:.3g} of the largest"
