"""Slip against the integral equation: springs alone, and springs of 150 MPa/mm that slide at 30 degrees of friction.

With friction the middle slides and the ends, where there is little slip, are held: both parts must be there.
"""

from pathlib import Path

import numpy as np

from femdem.results import Results
from scene_crack import (
    ANGLE,
    HALF_LENGTH,
    MODULUS,
    STRESS,
    TERMS,
    check_slip,
    computed_slip,
    reference_slip,
    resolved,
)
from scene_motion import changed_deck, run_deck

SPRINGS, STIFFER, FRICTION = 60e9, 150e9, 30.0  # Pa/m, degrees
# The tip of the part that slides lies between two places of collocation
REFERENCE_CONVERGED = 1e-4


def check(results):
    folder = Path(results).parent
    normal, shear = resolved(STRESS, ANGLE)
    strength = normal * np.tan(np.radians(FRICTION))
    check_reference(shear, strength)
    check_slip(results, "springs.nml", lambda x: reference_slip(x, HALF_LENGTH, MODULUS, shear, SPRINGS))

    changes = (
        ("friction_angle = 80", f"friction_angle = {FRICTION:g}"),
        ("ks_mpa_mm = 60", "ks_mpa_mm = 150"),
    )
    changed_deck(folder, "springs.nml", "friction.nml", *changes)
    both = run_deck(folder, "friction.nml", "friction", "--quiet")
    check_slip(
        both, "friction.nml", lambda x: reference_slip(x, HALF_LENGTH, MODULUS, shear, STIFFER, strength)
    )
    _, slip = computed_slip(Results(both).fields)
    held = np.mean(STIFFER * slip < 0.99 * strength)
    assert 0.1 < held < 0.9, f"{100 * held:.0f} % of the crack is held by its springs: no test of both"


def check_reference(shear, strength):
    """The reference has enough terms, and soft and stiff springs lead to the closed forms."""
    x = np.linspace(0, 0.9 * HALF_LENGTH, 10)

    def found(ks, limit=np.inf, terms=TERMS):
        return reference_slip(x, HALF_LENGTH, MODULUS, shear, ks, limit, terms)

    for ks, limit in ((SPRINGS, np.inf), (STIFFER, strength)):
        error = np.abs(found(ks, limit) / found(ks, limit, 2 * TERMS) - 1).max()
        print(f"reference with ks = {ks:g} Pa/m: twice the terms change it by {error:.1e}")
        assert error < REFERENCE_CONVERGED
    free = np.abs(found(1e-6 * SPRINGS) / found(np.inf, 0.0) - 1).max()
    stiff = np.abs(found(1e4 * STIFFER, strength) / found(np.inf, strength) - 1).max()
    print(
        f"soft springs against the free crack: {free:.1e}; stiff ones with friction against friction: {stiff:.1e}"
    )
    assert free < 1e-5
    assert stiff < 1e-5
