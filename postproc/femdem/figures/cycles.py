"""Cyclic closure (normal stress against closure) or cyclic shear (shear stress and dilation against slip) of runs.

    femdem-plot cycles results/closure --of closure --out closure_cycles
    femdem-plot cycles results/symmetric results/barton --of shear --labels symmetric barton

Closure is drawn with the curves of the three loading cycles from zero. Prints the work of shear per area over each closed
cycle, or the closure at each turn of the normal stress.
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style

DASHES = [(5, 2), (2, 2), (1, 2)]
POINTS = 200
KPA = 1e3
CLOSED = 1e-6  # mm: slip that is the same


def turns(values):
    """Rows at which a quantity turns, and its last one."""
    sense = np.sign(np.diff(values))
    return [*(np.flatnonzero(sense[1:] * sense[:-1] < 0) + 1), len(values) - 1]


def draw_closure(axes, runs, labels, group, length=None):
    """Paths of all runs over the curves of the first one's cycles; returns header and rows of the turns."""
    table = []
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        history = run.history
        name = history.group(group)
        closure = np.insert(history.joint(name, "closure_mm"), 0, 0)
        stress = np.insert(history.joint(name, "normal_stress_MPa"), 0, 0)
        if i == 0:
            at = np.linspace(0, np.max(stress), POINTS)
            for cycle, dashes in enumerate(DASHES, start=1):
                law = run.reference_joint(name, length, cycle)
                axes.plot(
                    law.closure(at), at, color="#888888", linewidth=1, dashes=dashes, label=f"cycle {cycle}"
                )
        axes.plot(closure, stress, color=style.PALETTE[i % len(style.PALETTE)], label=label)
        table += [[label, float(stress[row]), float(closure[row])] for row in turns(stress)]
    axes.set_xlabel("Closure [mm]")
    axes.set_ylabel("Normal stress [MPa]")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend()
    return ["run", "sn_MPa", "closure_mm"], table


def draw_shear(axes, runs, labels, group):
    """Shear stress and dilation of all runs; returns header and rows of the work between equal slips."""
    table = []
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        history = run.history
        name = history.group(group)
        slip, shear, dilation = (
            history.joint(name, key) for key in ("shear_displacement_mm", "shear_stress_MPa", "dilation_mm")
        )
        # Dashes let runs be seen that lie below
        look = {
            "color": style.PALETTE[i % len(style.PALETTE)],
            "linestyle": "-" if i == 0 else (0, DASHES[0]),
            "label": label,
        }
        axes[0].plot(slip, KPA * shear, **look)
        axes[1].plot(slip, dilation, **look)
        for first, last in closed_cycles(slip):
            mean = 0.5 * (shear[first + 1 : last + 1] + shear[first:last])
            table.append(
                [label, float(slip[first]), float(KPA * np.sum(mean * np.diff(slip[first : last + 1])))]
            )
    axes[0].set_ylabel("Shear stress [kPa]")
    axes[1].set_ylabel("Dilation [mm]")
    for each in axes:
        each.set_xlabel("Shear displacement [mm]")
    axes[1].legend(loc="upper center")
    return ["run", "slip_mm", "work_J_m2"], table


def closed_cycles(slip):
    """Pairs of rows at which the slip turns at the same value."""
    rows = turns(slip)
    pairs = ((first, last) for k, first in enumerate(rows) for last in rows[k + 1 :])
    return [(first, last) for first, last in pairs if abs(slip[first] - slip[last]) < CLOSED]


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    arguments.add_argument(
        "--of", choices=("closure", "shear"), required=True, help="what goes through cycles"
    )
    style.joint_arguments(arguments)
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    if arguments.of == "closure":
        figure, axes = plt.subplots()
        header, table = draw_closure(axes, runs, labels, arguments.group, arguments.length)
    else:
        figure, axes = plt.subplots(
            1, 2, figsize=(1.5 * style.WIDTH_MM * style.MM, 0.75 * style.HEIGHT_MM * style.MM)
        )
        header, table = draw_shear(axes, runs, labels, arguments.group)
        figure.tight_layout()
    style.error_table(header, table, arguments.csv)
    style.save(figure, arguments.out, runs, f"cyclic_{arguments.of}")
