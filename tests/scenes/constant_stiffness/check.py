"""Integrate d sn/du = K tan(d)/(1 + K/knn) along with the mobilisation, and compare."""

from pathlib import Path

import numpy as np
from jcm import Joint
from scene_motion import Motion, changed_deck, run_deck

# The implicit step takes the pressure at its end: first order in the increment of 5 micrometres
TOLERANCE = 5e-3
STEP = 2e-4  # mm, of the integration
# The base is held everywhere: mass scaling does not touch what moves
EXPLICIT = [
    ("'implicit'", "'explicit'"),
    ("move_time = 1 /", "move_time = 0.01, equilibrium = 1e-6, max_rest_time = 0.1 /"),
    (
        "move_time = 5e-4 /",
        "move_time = 5e-4 /\n&explicit damping = 'local', mass_scaling = 'step', scaled_step = 5e-6 /",
    ),
]


STIFF = ("young = 150e6", "young = 600e6")
FREE = ("&boundary group = 'block_top', stage = 'shear', vy = 0 /\n", "")


def check(results):
    folder = Path(results).parent
    compare(Motion(results).history, 15)
    for stiffness, name, changes in (
        (60, "implicit_60", [STIFF]),
        (0, "implicit_0", [FREE]),
        (15, "explicit_15", EXPLICIT),
        (60, "explicit_60", [STIFF, *EXPLICIT]),
        (0, "explicit_0", [FREE, *EXPLICIT]),
    ):
        print(f"{name}: ", end="")
        deck = changed_deck(folder, "stiffness.nml", f"{name}.nml", *changes)
        compare(Motion(run_deck(folder, deck, name, "--quiet")).history, stiffness)


def compare(history, stiffness):
    u = history["joint.shear_displacement_mm"]
    stress, dilation = integrate(u, history["joint.normal_stress_MPa"][0], stiffness)
    for name, expected in (("normal_stress_MPa", stress), ("dilation_mm", dilation)):
        error = abs(history[f"joint.{name}"] - expected).max() / abs(expected).max()
        print(f"K = {stiffness} MPa/mm: {name} within {100 * error:.3f} % of its largest value")
        assert error < TOLERANCE, f"K = {stiffness} MPa/mm: {name} is {100 * error:.2f} % off"


def integrate(u, stress, stiffness):
    """Normal stress and dilation at the slips u, by the mid-point rule."""
    joint = Joint(jrc0=10, jcs0=100, l0=0.1, phi_r=30, length=0.1)
    kn0, vm = joint.initial_stiffness, joint.largest_closure

    def rates(ratio, stress):
        knn = (stress + kn0 * vm) ** 2 / (kn0 * vm**2)  # eq 11
        slope = float(joint.dilation_slope(ratio, stress))
        return 1 / float(joint.peak_displacement(stress)), stiffness * slope / (1 + stiffness / knn), slope

    found = [(stress, 0.0)]
    ratio = dilation = slipped = 0.0
    for target in u[1:]:
        steps = max(1, int(np.ceil((target - slipped) / STEP)))
        du = (target - slipped) / steps
        for _ in range(steps):
            first = rates(ratio, stress)
            middle = rates(ratio + 0.5 * du * first[0], stress + 0.5 * du * first[1])
            ratio, stress, dilation = (
                ratio + du * middle[0],
                stress + du * middle[1],
                dilation + du * middle[2],
            )
        slipped = target
        found.append((stress, dilation))
    return np.array(found).T
