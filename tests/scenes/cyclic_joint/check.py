"""Each loading closes by what its cycle says; a joint that slides back has tan(phi_r - d), and no closed cycle gives out energy."""

from pathlib import Path

import numpy as np
from scene_motion import Motion, changed_deck, run_deck

# Bandis et al. 1983, JRC 15, JCS 2 MPa, a0 0.3 mm: largest closure of cycles 1 to 3 [mm], initial stiffness [MPa/mm] by eq 6
LARGEST = (1.02794, 0.44158, 0.49081)
STIFFNESS = -7.15 + 1.75 * 15 + 0.02 * 2 / 0.3
LEAST, MOST = 1e-3, 1.0  # MPa
ROUNDING = 6e-6  # mm, of the largest closures, each to half of its last digit
RESIDUAL = np.tan(np.radians(32))
STEP = 0.01  # mm, of the shear
REACH = 1.5  # mm


def check(results):
    check_closure(Motion(results).history)
    folder = Path(results).parent
    weaker = run(folder, "shear", ())
    symmetric = run(folder, "symmetric", [("reversal = 'barton'", "reversal = 'symmetric'")])
    check_way_back(weaker, symmetric)
    for history in (weaker, symmetric):
        check_energy(history)


def run(folder, name, changes):
    deck = changed_deck(folder, "shear.nml", f"{name}_run.nml", *changes)
    return Motion(run_deck(folder, deck, name, "--quiet")).history


def curve(cycle, stress):
    """Closure of a cycle, eq 5b."""
    largest = LARGEST[cycle - 1]
    return stress * largest / (STIFFNESS * largest + stress)


def check_closure(history):
    """Between the stresses it turns at, each loading closes and each unloading opens by one of the curves."""
    closure, stress = history["joint.closure_mm"], history["joint.normal_stress_MPa"]
    turns = [closure[40 * stage - 1] for stage in range(1, 8)]
    assert np.allclose(
        [stress[40 * stage - 1] for stage in range(1, 8)], [MOST, LEAST] * 3 + [MOST], rtol=1e-6
    )
    assert abs(turns[0] - curve(1, MOST)) < ROUNDING, "first loading"
    ways = [(2, -1), (2, 1), (2, -1), (3, 1), (3, -1), (3, 1)]
    for n, (cycle, sense) in enumerate(ways):
        expected = sense * (curve(cycle, MOST) - curve(cycle, LEAST))
        assert abs(turns[n + 1] - turns[n] - expected) < ROUNDING, (
            f"way {n + 2}: {turns[n + 1] - turns[n]}, {expected}"
        )
        assert sense * (turns[n + 1] - turns[n]) > 0
    assert turns[1] > 0.003, "the first unloading leaves closure that stays"


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
