"""Slip along a straight closed crack: reference, and the comparison that the scenes of the inclined crack share.

The plate is infinite, in plane strain. Slip is found from the singular integral equation.

Slip D along -b < x < b takes shear stress off the crack:

    tau_far - tau(x) = E'/(4 pi) int D'(s)/(x - s) ds (principal value),    E' = E/(1 - nu^2).

With x = b cos(t) and D = sum d_n sin(n t) the right side is E'/(4 b) sum n d_n sin(n t)/sin(t). The faces answer with a
shear stress that is a function of the slip:

    friction alone         tau = sn tan(phi):  D = 4/E' (tau_far - sn tan(phi)) sqrt(b^2 - x^2), the first term alone
    springs alone          tau = ks D
    springs and friction   tau = min(ks D, sn tan(phi)), one behind the other: the Coulomb joint of the program

Terms are found by collocation; where the faces slide, by trying. Friction and springs side by side, tau = sn tan(phi) + ks D,
as in boundary element codes, have the equation of the springs alone with a shear stress tau_far - sn tan(phi).
"""

import sys
from pathlib import Path

import numpy as np

from femdem.kept import make
from femdem.results import Results
from scene_motion import changed_deck, run_deck

TERMS = 400
TRIALS = 100

# The crack of tests/scenes/inclined_crack
STRESS, HALF_LENGTH, ANGLE = 10e6, 0.1, 45.0
MODULUS = 30e9 / (1 - 0.27**2)
FINE, COARSE = 0.004, 0.008  # element size in the middle of the crack [m]
CENTRE_BAR, PROFILE_BAR = 0.01, 0.01
# Size is graded to the tips such that the error falls with its square: by 4 when it is halved, and more when coarse
LEAST_FALL = 3.0


def resolved(stress, angle):
    """Normal and shear stress on a crack at an angle [degrees] to a uniaxial stress."""
    psi = np.radians(angle)
    return stress * np.sin(psi) ** 2, stress * np.sin(psi) * np.cos(psi)


def reference_slip(x, half_length, modulus, shear_stress, ks, strength=np.inf, terms=TERMS):
    """Slip at places x of a crack whose faces carry min(ks D, strength); modulus is E/(1 - nu^2). All in SI units.

    With ks = inf the faces carry their strength from the start: the closed form.
    """
    angle = np.arccos(np.clip(np.asarray(x) / half_length, -1, 1))
    if np.isinf(ks):
        return 4 * half_length / modulus * (shear_stress - strength) * np.sin(angle)
    numbers = np.arange(1, terms + 1)
    places = np.pi * numbers / (terms + 1)
    shape = np.sin(np.outer(places, numbers))
    operator = modulus / (4 * half_length) * shape * numbers / np.sin(places)[:, None]
    held = np.ones(terms, dtype=bool)  # where the faces have not reached their strength
    for _ in range(TRIALS):
        carried = np.zeros(terms) if held.all() else np.where(held, 0.0, strength)
        term = np.linalg.solve(operator + ks * shape * held[:, None], shear_stress - carried)
        now_held = ks * (shape @ term) < strength
        if np.array_equal(now_held, held):
            return np.sin(np.outer(angle, numbers)) @ term
        held = now_held
    raise ArithmeticError("the part of the crack that slides was not found")


def computed_slip(fields):
    """Of a run with one crack through the origin: distance of the joint elements from it, slip [m], both by distance."""
    place = np.hypot(*fields.mesh().joint_lines.mean(axis=1).T)
    order = np.argsort(place)
    return place[order], np.abs(fields.read("shear_displacement_mm"))[order] / 1000


def slip_error(results, exact):
    """Error at the centre over the slip there; largest one on the inner 90 % over the largest slip."""
    x, slip = computed_slip(Results(results).fields)
    expected = exact(x)
    inner = x < 0.9 * HALF_LENGTH
    worst = np.abs(slip - expected)[inner].max() / expected.max()
    return slip[:2].mean() / expected[:2].mean() - 1, worst


def check_slip(fine, deck, exact):
    """Results with the fine mesh, and a run of the same deck with the coarse one, against exact(x)."""
    folder = Path(fine).parent
    mesher = [sys.executable, "make_mesh.py", "--size", COARSE, "--out", "coarse.msh"]
    assert make("coarse.msh", mesher, folder) == 0, "the coarse mesh was not made"
    changed = changed_deck(folder, deck, f"coarse_{deck}", ("crack.msh", "coarse.msh"))
    coarse = run_deck(folder, changed, f"coarse_{Path(deck).stem}", "--quiet")
    (centre, worst), (centre_coarse, _) = (slip_error(results, exact) for results in (fine, coarse))
    print(
        f"{deck}: slip at the centre off by {100 * centre:+.2f} % (elements twice as large {100 * centre_coarse:+.2f} %), "
        f"inner 90 % by {100 * worst:.2f} % of the largest slip at worst"
    )
    assert abs(centre) <= CENTRE_BAR, f"{deck}: slip at the centre is off by {100 * centre:+.2f} %"
    assert worst <= PROFILE_BAR, f"{deck}: the profile is off by {100 * worst:.2f} %"
    assert abs(centre_coarse) >= LEAST_FALL * abs(centre), (
        f"{deck}: error at the centre {100 * centre_coarse:+.2f} % with {COARSE} m, {100 * centre:+.2f} % with {FINE} m"
    )
