"""Normal stress against closure of one or several runs, with the empirical law (eq 5) as points.

    femdem-plot closure results_closure --out closure

Prints, for each row of the history, the closure, that of eq 5b at the same stress, and the difference in per cent.
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style

POINTS = 15
TABLE = ["run", "sn_MPa", "closure_mm", "eq5b_mm", "error_%"]


def draw_closure(axes, runs, labels, group=None, length=None):
    """Draw the curves with their empirical points; returns the header and rows of the table of errors."""
    table = []
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        history = run.history
        name = history.group(group)
        closure = history.joint(name, "closure_mm")
        stress = history.joint(name, "normal_stress_MPa")
        loaded = stress > 0
        if not np.any(loaded):
            raise style.ResultsError(f"{history.path}: no normal stress on group {name!r}")
        closure, stress = closure[loaded], stress[loaded]
        law = run.reference_joint(name, length)
        style.numeric(axes, np.concatenate([[0], closure]), np.concatenate([[0], stress]), i, label)
        at = np.linspace(0, np.max(stress), POINTS)
        style.empirical(axes, law.closure(at), at, i, label)
        expected = law.closure(stress)
        for s, v, e in zip(stress, closure, expected, strict=True):
            table.append([label, float(s), float(v), float(e), float(100 * (v - e) / e)])
    axes.set_xlabel("Closure [mm]")
    axes.set_ylabel("Normal stress [MPa]")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    style.comparison_legend(axes, labels)
    return TABLE, table


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    style.joint_arguments(arguments)
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    figure, axes = plt.subplots()
    header, table = draw_closure(axes, runs, labels, arguments.group, arguments.length)
    style.error_table(header, table, arguments.csv)
    style.save(figure, arguments.out, runs, "closure")
