"""Equivalent permeability of runs with &flow: against the stress ratio, and its rose at the end.

femdem-plot permeability results             kxx and kyy (linear pressure), kx and ky (sides closed)
femdem-plot permeability jcm jcm_mean        several runs, a colour each
femdem-plot permeability results --x time_s  against another column of permeability.csv

The stress ratio is that of the mean stresses of the rock, xx over yy. The rose is k in each direction, n.k.n, of the last
row. Prints first and last permeability of each run and their ratio.
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style
from femdem.results import History

COMPONENTS = (
    ("kxx_m2", "-", "$k_{xx}$"),
    ("kyy_m2", "--", "$k_{yy}$"),
    ("kx_closed_m2", "-.", "$k_x$, sides closed"),
    ("ky_closed_m2", ":", "$k_y$, sides closed"),
)


def horizontal(table, column):
    """Values on the horizontal axis, and their name."""
    if column == "stress_ratio":
        with np.errstate(divide="ignore", invalid="ignore"):
            return table["stress_xx_MPa"] / table["stress_yy_MPa"], "Stress ratio xx/yy"
    return table[column], style.axis_label(column)


def rose(table):
    """Directions [radians] and permeability in each, n.k.n, of the last row."""
    angle = np.linspace(0, 2 * np.pi, 361)
    kxx, kyy, kxy = (table[name][-1] for name in ("kxx_m2", "kyy_m2", "kxy_m2"))
    return angle, kxx * np.cos(angle) ** 2 + kyy * np.sin(angle) ** 2 + kxy * np.sin(2 * angle)


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    arguments.add_argument("--x", default="stress_ratio", help="column, or stress_ratio (default)")
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    tables = [History(run.directory / "permeability.csv") for run in runs]
    figure = plt.figure(figsize=(175 * style.MM, 85 * style.MM), layout="constrained")
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2, projection="polar")
    rows = []
    for i, (table, label) in enumerate(zip(tables, labels, strict=True)):
        x, name = horizontal(table, arguments.x)
        colour = style.PALETTE[i % len(style.PALETTE)]
        for component, line, _ in COMPONENTS:
            k = table[component]
            if not (k > 0).any():
                continue
            marker = "o" if len(k) == 1 else None
            left.plot(x, k, line, color=colour, marker=marker)
            rows.append(
                [
                    label,
                    component,
                    float(k[0]),
                    float(k[-1]),
                    float(k[-1] / k[0]) if k[0] > 0 else float("nan"),
                ]
            )
        right.plot(*rose(table), color=colour, label=label)
    left.set_xlabel(name)
    left.set_ylabel("Equivalent permeability [m²]")
    left.set_yscale("log")
    right.set_title("n·k·n at the end [m²]")
    right.tick_params(labelsize=6)
    right.grid(visible=True)
    kinds = [plt.Line2D([], [], color="#555555", linestyle=line) for _, line, _ in COMPONENTS]
    place = {"loc": "upper center", "fontsize": 7, "ncol": 2}
    figure.legend(kinds, [text for _, _, text in COMPONENTS], bbox_to_anchor=(0.27, 0.0), **place)
    if len(runs) > 1:
        figure.legend(*right.get_legend_handles_labels(), bbox_to_anchor=(0.77, 0.0), **place)
    style.error_table(["run", "component", "first", "last", "last/first"], rows)
    style.save(figure, arguments.out, runs, "permeability")
