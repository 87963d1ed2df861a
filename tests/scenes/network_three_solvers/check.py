"""Means of shear stress, shear displacement and aperture, at the end of both phases, over all joints and over block edges.

Implicit and relaxation solver with the same increments find the same state. Their own error is that of the increment: a joint
sees the whole slip of one at the normal stress of its end, which is of first order. The explicit solver follows the path
itself, so it is compared with many increments.

How the explicit solver is driven: smooth ramps of 0.3 s, for the slowest blocks swing in some 0.05 s, more slowly with masses
raised; viscous damping, for local damping holds back slow motion together with the waves and so bends the path of
friction; masses raised until a step of 2.5e-6 s is stable. The slow swinging that viscosity leaves is then brought to rest with
local damping. With masses for 5e-6 s this much viscosity does not hold what short pieces of wall at crossings feed (flutter,
manual/theory_explicit.md): blocks there swing to the end of the ramp, and slip on one block edge or another with it.
"""

from pathlib import Path

import numpy as np

from femdem.results import Results
from scene_motion import changed_deck, run_deck

QUANTITIES = ("shear_stress_MPa", "shear_displacement_mm", "aperture_mm")
STAGES = [f"&stage name = '{name}', cycles = 10, move_time = 1e-2 /\n" for name in ("phase_1", "phase_2b")]
RAMPS = [
    f"&stage name = '{name}', move_time = 0.3, equilibrium = 1e-5, max_rest_time = 2e-2 /\n"
    for name in ("phase_1", "phase_2b")
]
VISCOUS = (
    "&explicit damping = 'viscous', damping_factor = 0.2, mass_scaling = 'step', scaled_step = 2.5e-6 /\n"
)
LOCAL = "&explicit damping = 'local', damping_factor = 0.8, mass_scaling = 'step', scaled_step = 2.5e-6 /\n"
HOLD = "".join(
    f"&boundary group = '{side}', stage = 'hold', sxx = 15e6, syy = 5e6 /\n"
    for side in ("left", "right", "bottom", "top")
)
HOLD += "&stage name = 'hold', move_time = 1e-4, equilibrium = 1e-5, max_rest_time = 2 /\n"
MANY = 640
BAR = 0.01  # means of the three solvers
SAME = 1e-4  # implicit and relaxation, the same increments; found: 1e-5, what their tolerances leave
AT_REST = 1e-5
# With increments cut to a quarter the error of first order falls to a quarter; to less, as MANY has its own
LEAST_FALL = 2.5


class State:
    """Magnitudes on the joints in a snapshot."""

    def __init__(self, results, step=-1):
        fields = Results(results).fields
        mesh = fields.mesh()
        self.length = np.hypot(*(mesh.joint_lines[:, 1] - mesh.joint_lines[:, 0]).T)
        self.edge = mesh.block_edge
        self.joints = {name: np.abs(fields.read(name, step)) for name in QUANTITIES}

    def mean(self, name):
        return np.average(self.joints[name], weights=self.length)

    def edges(self, name):
        """Mean over each block edge."""
        sums = [np.bincount(self.edge, weights) for weights in (self.length * self.joints[name], self.length)]
        there = sums[1] > 0
        return sums[0][there] / sums[1][there]


def compare(mine, theirs, what):
    """Print the differences; those of the means."""
    found = {}
    for name in QUANTITIES:
        found[name] = mine.mean(name) / theirs.mean(name) - 1
        edges, other = mine.edges(name), theirs.edges(name)
        of_edges, rms = (
            edges.mean() / other.mean() - 1,
            np.sqrt(np.mean((edges - other) ** 2) / np.mean(other**2)),
        )
        print(
            f"{what}, {name}: mean {100 * found[name]:+.3f} %, mean of block edges {100 * of_edges:+.3f} %, "
            f"each block edge {100 * rms:.2f} % rms"
        )
    return found


def agree(mine, theirs, what, bar):
    for name, difference in compare(mine, theirs, what).items():
        assert abs(difference) <= bar, f"{what}: mean {name} differs by {100 * difference:+.3f} %"


def solved(folder, name, solver, stages, extra=""):
    """States after phases I and II-B of a run with other stages and solver, and its directory."""
    changes = (("solver = 'implicit'", f"solver = '{solver}'"), *zip(STAGES, stages, strict=True))
    deck = changed_deck(folder, "network.nml", f"{name}.nml", *changes)
    with open(folder / deck, "a", encoding="utf-8") as file:
        file.write(extra)
    results = run_deck(folder, deck, name, "--quiet", timeout=1200)
    return [State(results, step) for step in (0, 1)], results


def check(results):
    folder = Path(results).parent
    implicit = [State(results, step) for step in (0, 1)]
    relaxation, _ = solved(folder, "relaxation", "relaxation", STAGES)
    many, _ = solved(folder, "many", "implicit", [s.replace("= 10,", f"= {MANY},") for s in STAGES])
    quarter, _ = solved(
        folder, "quarter", "implicit", [s.replace("= 10,", f"= {MANY // 4},") for s in STAGES]
    )
    sixteenth, _ = solved(
        folder, "sixteenth", "implicit", [s.replace("= 10,", f"= {MANY // 16},") for s in STAGES]
    )
    explicit, moving = solved(folder, "explicit", "explicit", RAMPS, VISCOUS)

    text = (folder / "explicit.nml").read_text(encoding="utf-8")
    (folder / "hold.nml").write_text(text.replace(VISCOUS, HOLD + LOCAL), encoding="utf-8")
    held = run_deck(folder, "hold.nml", "hold", "--quiet", "--branch", str(moving / "checkpoint.h5"))
    ratios = [Results(run).history["unbalanced_ratio"][-1] for run in (moving, held)]
    print(f"explicit: unbalanced force ratio {ratios[0]:.1e} after the ramp, {ratios[1]:.1e} at rest")
    assert ratios[1] <= AT_REST, f"explicit: unbalanced force ratio {ratios[1]:.1e}"

    for phase, name in enumerate(("I", "II-B")):
        agree(relaxation[phase], implicit[phase], f"{name}, relaxation, implicit, both 10 increments", SAME)
        compare(implicit[phase], many[phase], f"{name}, implicit, 10 increments against {MANY}")
        coarse = compare(
            sixteenth[phase], many[phase], f"{name}, implicit, {MANY // 16} increments against {MANY}"
        )
        fine = compare(
            quarter[phase], many[phase], f"{name}, implicit, {MANY // 4} increments against {MANY}"
        )
        if phase == 0:
            for quantity in QUANTITIES:
                assert abs(coarse[quantity]) > LEAST_FALL * abs(fine[quantity]), (
                    f"{quantity}: {coarse}, {fine}"
                )
        agree(
            explicit[phase], many[phase], f"{name}, explicit after its ramp, implicit, {MANY} increments", BAR
        )
    agree(State(held), many[1], f"II-B, explicit at rest, implicit, {MANY} increments", BAR)
    agree(State(held), implicit[1], "II-B, explicit at rest, implicit, 10 increments", BAR)
