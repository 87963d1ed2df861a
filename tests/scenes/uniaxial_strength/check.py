"""The largest mean stress is the strength of the Mohr-Coulomb law; the modulus below is that of plane strain."""

import math

import numpy as np

from scene import read_history

WIDTH, RATE = 0.5, 0.1
COHESION, FRICTION, YOUNG, POISSON = 15e6, math.radians(26.6), 30e9, 0.27


def check(results):
    history = read_history(results / "history.csv")
    time = np.concatenate([[0.0], history["time_s"]])
    work = np.concatenate([[0.0], history["external_J"]])
    stress = np.diff(work) / (np.diff(time) * RATE * WIDTH)
    expected = 2 * COHESION * math.cos(FRICTION) / (1 - math.sin(FRICTION))
    print(
        f"strength: expected {expected / 1e6:.2f}, found {stress.max() / 1e6:.2f} MPa ({stress.max() / expected - 1:+.2%})"
    )
    assert abs(stress.max() / expected - 1) < 0.1, (
        f"strength {stress.max() / 1e6:.2f}, expected {expected / 1e6:.2f} MPa"
    )
    # Half-way to the strength nothing has been cut yet: the strain energy is that of the continuous rock
    half = int(np.searchsorted(stress, expected / 2))
    strain = RATE * history["time_s"][half]
    energy = 0.5 * YOUNG / (1 - POISSON**2) * strain**2 * WIDTH
    error = history["strain_J"][half] / energy - 1
    print(f"modulus at half the strength: {error:+.2e}")
    assert abs(error) < 5e-3, f"the modulus is off by {error:.2e}"
