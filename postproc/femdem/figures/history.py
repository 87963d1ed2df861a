"""Any columns of the history of one or several runs.

femdem-plot history results --y joint.shear_stress_MPa joint.normal_stress_MPa
femdem-plot history a b --x joint.shear_displacement_mm --y joint.aperture_mm
femdem-plot history results --list
"""

import matplotlib.pyplot as plt

from femdem.figures import style

LINES = ["-", "--", ":", "-."]


def quantity(column):
    """What a column is, without its unit"""
    return style.axis_label(column).partition(" [")[0]


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    arguments.add_argument("--x", default="time_s", help="column on the horizontal axis (default: time_s)")
    arguments.add_argument("--y", nargs="+", help="columns on the vertical axis")
    arguments.add_argument("--log", action="store_true", help="logarithmic vertical axis")
    arguments.add_argument("--list", action="store_true", help="list the columns and stop")
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    if arguments.list or not arguments.y:
        print("\n".join(runs[0].history.columns))
        return

    figure, axes = plt.subplots()
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        history = run.history
        for j, column in enumerate(arguments.y):
            # One run: a colour a column. Several: a colour a run, a dash a column.
            colour = style.PALETTE[(j if len(runs) == 1 else i) % len(style.PALETTE)]
            line = "-" if len(runs) == 1 else LINES[j % len(LINES)]
            parts = ([label] if len(runs) > 1 else []) + ([quantity(column)] if len(arguments.y) > 1 else [])
            axes.plot(
                history[arguments.x], history[column], line, color=colour, label=", ".join(parts) or None
            )
    units = {style.axis_label(column).rpartition("[")[2] for column in arguments.y}
    if len(arguments.y) == 1:
        axes.set_ylabel(style.axis_label(arguments.y[0]))
    elif len(units) == 1:
        axes.set_ylabel(f"[{units.pop()}")
    axes.set_xlabel(style.axis_label(arguments.x))
    if arguments.log:
        axes.set_yscale("log")
    if len(runs) > 1 or len(arguments.y) > 1:
        axes.legend()
    style.save(figure, arguments.out, runs, "history")
