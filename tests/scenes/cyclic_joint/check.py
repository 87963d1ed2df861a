"""Each loading closes by what its cycle says; a joint that slides back has tan(phi_r - d), and no closed cycle gives out energy."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scene_motion import Motion, changed_deck, run_deck

LEAST = 1e-3  # MPa, where unloading ends
RELATIVE = 1e-6  # of the normal stress

RESIDUAL = np.tan(np.radians(32))
STEP = 0.01  # mm, of the shear
REACH = 1.5  # mm


@dataclass
class Curves:
    """Closure by loading cycle: largest closures [mm] and initial stiffness [MPa/mm], and what rounding leaves of them [mm]."""

    largest: tuple
    stiffness: float
    most: float  # MPa, where loading ends
    rounding: float

    def closure(self, cycle, stress):
        """Eq 5b"""
        largest = self.largest[cycle - 1]
        return stress * largest / (self.stiffness * largest + stress)


# Bandis et al. 1983, JRC 15, JCS 2 MPa, a0 0.3 mm; stiffness by eq 6
CAST = Curves((1.02794, 0.44158, 0.49081), -7.15 + 1.75 * 15 + 0.02 * 2 / 0.3, 1.0, 6e-6)
# JRC 9.7, JCS 169 MPa, a0 0.194 mm: largest closures that give 0.0692, 0.0389 and 0.0311 mm at 20 MPa
LIMESTONE_STIFFNESS = -7.15 + 1.75 * 9.7 + 0.02 * 169 / 0.194
LIMESTONE = Curves(
    tuple(1 / (1 / v - LIMESTONE_STIFFNESS / 20) for v in (0.0692, 0.0389, 0.0311)),
    LIMESTONE_STIFFNESS,
    20.0,
    1.1e-4,
)
TO_LIMESTONE = [
    (
        "jrc0 = 15, jcs0_mpa = 2, l0 = 0.1, phi_r = 32, a0_mm = 0.3",
        "jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.1, phi_r = 31, a0_mm = 0.194",
    ),
    *((f"'load_{n}', pressure = 1e6", f"'load_{n}', pressure = 20e6") for n in range(1, 5)),
]


def check(results):
    folder = Path(results).parent
    check_closure(Motion(results).history, CAST, ways=[(2, -1), (2, 1), (2, -1), (3, 1), (3, -1), (3, 1)])
    # Its third cycle is the stiffest: unloading goes down the curve that the next loading goes up
    deck = changed_deck(folder, "closure.nml", "limestone.nml", *TO_LIMESTONE)
    limestone = Motion(run_deck(folder, deck, "limestone", "--quiet")).history
    check_closure(limestone, LIMESTONE, ways=[(2, -1), (2, 1), (3, -1), (3, 1), (3, -1), (3, 1)])
    weaker = run(folder, "shear", ())
    symmetric = run(folder, "symmetric", [("reversal = 'barton'", "reversal = 'symmetric'")])
    check_way_back(weaker, symmetric)
    for history in (weaker, symmetric):
        check_energy(history)


def run(folder, name, changes):
    deck = changed_deck(folder, "shear.nml", f"{name}_run.nml", *changes)
    return Motion(run_deck(folder, deck, name, "--quiet")).history


def check_closure(history, curves, ways):
    """Between the stresses it turns at, each loading closes and each unloading opens by one of the curves."""
    closure, stress = history["joint.closure_mm"], history["joint.normal_stress_MPa"]
    turns = [closure[40 * stage - 1] for stage in range(1, 8)]
    reached = [stress[40 * stage - 1] for stage in range(1, 8)]
    assert np.allclose(reached, [curves.most, LEAST] * 3 + [curves.most], rtol=RELATIVE), (
        f"stresses {reached}"
    )
    assert abs(turns[0] - curves.closure(1, curves.most)) < curves.rounding, "first loading"
    for n, (cycle, sense) in enumerate(ways):
        found = turns[n + 1] - turns[n]
        expected = sense * (curves.closure(cycle, curves.most) - curves.closure(cycle, LEAST))
        assert abs(found - expected) < curves.rounding, f"way {n + 2}: {found}, {expected}"
    assert turns[1] > 0.06 * turns[0], "the first unloading leaves closure that stays"


def check_way_back(weaker, symmetric):
    """The same on the way out; back down the slope of the dilation the friction angle is less by it, but no less than nothing."""
    out = slice(0, 151)
    same = "joint.shear_stress_MPa", "joint.dilation_mm"
    assert all(np.allclose(weaker[key][out], symmetric[key][out], rtol=1e-9, atol=1e-12) for key in same)
    slip, dilation = weaker["joint.shear_displacement_mm"], weaker["joint.dilation_mm"]
    friction = weaker["joint.shear_stress_MPa"] / weaker["joint.normal_stress_MPa"]
    # Where both slide: from 1.25 mm on back they are elastic for a quarter of a millimetre
    rows = [row for row in range(152, 300) if 0.15 < slip[row] < 1.0]
    slope = np.array(
        [(dilation[row + 1] - dilation[row - 1]) / (slip[row + 1] - slip[row - 1]) for row in rows]
    )
    expected = np.maximum(0, np.tan(np.arctan(RESIDUAL) - np.arctan(slope)))
    error = np.sort(np.abs(-friction[rows] - expected))
    # At the peak the slope jumps: a central difference sees a mean of both in the two rows beside it
    assert error[-3] < 2e-5, f"sliding back: {error[-3]}"
    assert np.all(weaker[same[0]][rows] > 0.5 * symmetric[same[0]][rows]), "hardly weaker"
    # On the other side it is as strong as ever
    assert abs(weaker["joint.shear_stress_MPa"][350] - symmetric["joint.shear_stress_MPa"][350]) < 1e-7


def check_energy(history):
    """From the end of the first way out over a closed cycle back to it: work of shear less what lifted the load."""
    slip, shear = history["joint.shear_displacement_mm"], history["joint.shear_stress_MPa"]
    first, last = 150, 750
    assert np.allclose(slip[[first, last]], REACH, rtol=1e-9)
    assert abs(history["joint.dilation_mm"][first] - history["joint.dilation_mm"][last]) < 1e-6
    work = np.sum(0.5 * (shear[first + 1 : last + 1] + shear[first:last]) * np.diff(slip[first : last + 1]))
    assert work > 0, f"a closed cycle gives out {-work} MPa mm"
    print(f"work of a closed cycle {1e3 * work:.2f} J/m2")
