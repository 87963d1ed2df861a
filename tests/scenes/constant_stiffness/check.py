"""Integrate d sn/du = K tan(d)/(1 + K/knn) along with the mobilisation, and compare."""

import re
from pathlib import Path

import numpy as np

from femdem.jcm import Joint
from scene_motion import Motion, changed_deck, run_deck

# Found 0.06 %, by the explicit solver
TOLERANCE = 1e-3
# Increments of 5 micrometres and second order: 0.0004 %
IMPLICIT_TOLERANCE = 2e-5
# Halved increments leave a quarter of the error, of second order; the slope of Table 1 jumps at its nodes
LEAST_FALL = 3.0
# Relaxation and implicit solver, the same increments: what their tolerances leave
SAME = 1e-5
# In 8 increments of 0.25 mm under 10 MPa, which took 374 and 30 increments
FEW = 16
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
    compare(Motion(results).history, 15, IMPLICIT_TOLERANCE)
    for stiffness, name, changes in (
        (60, "implicit_60", [STIFF]),
        (0, "implicit_0", [FREE]),
        (15, "explicit_15", EXPLICIT),
        (60, "explicit_60", [STIFF, *EXPLICIT]),
        (0, "explicit_0", [FREE, *EXPLICIT]),
    ):
        print(f"{name}: ", end="")
        deck = changed_deck(folder, "stiffness.nml", f"{name}.nml", *changes)
        tolerance = TOLERANCE if "explicit" in name else IMPLICIT_TOLERANCE
        compare(Motion(run_deck(folder, deck, name, "--quiet")).history, stiffness, tolerance)
    check_order(folder)
    check_work(folder)


def check_order(folder):
    """Long increments, not halved for their slip: errors fall with their square, and relaxation finds the same."""
    before = None
    for cycles in (4, 8, 16, 32):
        few = (
            "cycles = 400, move_time = 5e-4 /",
            f"cycles = {cycles}, move_time = {0.2 / cycles} /\n&implicit largest_slip = 1e6 /",
        )
        deck = changed_deck(folder, "stiffness.nml", f"few_{cycles}.nml", STIFF, few)
        history = Motion(run_deck(folder, deck, f"few_{cycles}", "--quiet")).history
        print(f"{cycles} increments: ", end="")
        error = compare(history, 60, 1)
        if before:
            assert before > LEAST_FALL * error, f"{cycles} increments: {error}, with half as many {before}"
        before = error
        if cycles == 16:
            relaxed = changed_deck(folder, deck, "relaxed.nml", ("'implicit'", "'relaxation'"))
            theirs = Motion(run_deck(folder, relaxed, "relaxed", "--quiet")).history
            for name in ("joint.normal_stress_MPa", "joint.dilation_mm", "joint.shear_stress_MPa"):
                apart = abs(theirs[name] - history[name]).max() / abs(history[name]).max()
                print(f"{name}: relaxation and implicit solver {apart:.1e} apart")
                assert apart < SAME, f"{name}: {apart}"


def check_work(folder):
    """8 increments of 0.25 mm under 10 MPa: as many increments, and few factorisations."""
    changes = (
        STIFF,
        ("ty = -1e6", "ty = -10e6"),
        (
            "cycles = 400, move_time = 5e-4 /",
            "cycles = 8, move_time = 0.025 /\n&implicit largest_slip = 1e6 /",
        ),
    )
    run = run_deck(folder, changed_deck(folder, "stiffness.nml", "long.nml", *changes), "long", "--quiet")
    text = (run / "run.log").read_text(encoding="utf-8")
    factorisations = int(re.search(r"(\d+) factorisations", text).group(1))
    steps = int(re.search(r"done +(\d+) steps", text).group(1))
    print(f"8 long increments: {steps} increments with the load, {factorisations} factorisations")
    assert steps == 9, f"{steps} increments"
    assert factorisations <= FEW, f"{factorisations} factorisations"
    compare(Motion(run).history, 60, TOLERANCE)


def compare(history, stiffness, tolerance):
    """The error of the normal stress."""
    u = history["joint.shear_displacement_mm"]
    errors = []
    stress, dilation = integrate(u, history["joint.normal_stress_MPa"][0], stiffness)
    for name, expected in (("normal_stress_MPa", stress), ("dilation_mm", dilation)):
        error = abs(history[f"joint.{name}"] - expected).max() / abs(expected).max()
        print(f"K = {stiffness} MPa/mm: {name} within {100 * error:.5f} % of its largest value")
        assert error < tolerance, f"K = {stiffness} MPa/mm: {name} is {100 * error:.5f} % off"
        errors.append(error)
    return errors[0]


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
