"""Dilation against shear displacement of one or several runs, with eq 18 integrated along the path as points.

femdem-plot dilation results_6cm results_12cm --labels "6 cm" "12 cm" --out dilation
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style
from femdem.figures.shear import points_along, shear_path

TABLE = ["run", "sn_kPa", "length_m", "largest_eq18_mm", "rms_%_of_largest", "worst_%", "worst_at_mm"]


def draw_dilation(axes, runs, labels, group=None, length=None, normal_stress=None):
    """Draw the curves with their empirical points; returns the header and rows of the table of errors.

    The normal stress [MPa] of eq 18 is the mean of the history unless given; length [m] that of the block edge.
    """
    table = []
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        history = run.history
        name = history.group(group)
        u, _, sn, moved = shear_path(history, name, normal_stress)
        dilation = history.joint(name, "dilation_mm")[moved]
        law = run.reference_joint(name, length)
        style.numeric(axes, np.concatenate([[0], u]), np.concatenate([[0], dilation]), i, label)
        at = points_along(law, sn, np.max(u))
        style.empirical(axes, at, law.dilation(at, sn), i, label)
        reference = law.dilation(u, sn)
        largest = float(np.max(np.abs(reference)))
        error = 100 * (dilation - reference) / largest
        worst = int(np.argmax(np.abs(error)))
        rms = float(np.sqrt(np.mean(error**2)))
        table.append([label, 1000 * sn, law.length, largest, rms, float(error[worst]), float(u[worst])])
    axes.axhline(0, color="#555555", linewidth=0.7)
    axes.set_xlabel("Shear displacement [mm]")
    axes.set_ylabel("Dilation [mm]")
    axes.set_xlim(left=0)
    style.comparison_legend(axes, labels)
    return TABLE, table


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    style.joint_arguments(arguments)
    arguments.add_argument(
        "--normal-stress", type=float, help="normal stress of eq 18 in MPa (default: mean of the history)"
    )
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    figure, axes = plt.subplots()
    header, table = draw_dilation(
        axes, runs, labels, arguments.group, arguments.length, arguments.normal_stress
    )
    style.error_table(header, table, arguments.csv)
    style.save(figure, arguments.out, runs, "dilation")
