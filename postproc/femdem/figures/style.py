"""The look that all figures share, and the parts that are the same in each."""

import argparse
import csv
import os
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from cycler import cycler

from femdem.results import Results, ResultsError

# Okabe and Ito's palette, told apart by colour-blind readers and, by its lightness, mostly in grey
PALETTE = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X"]
# Numbers in one hue from light to dark; signed numbers from blue through white to red
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"
WIDTH_MM, HEIGHT_MM = 130, 95
MM = 1 / 25.4  # inches
DOTS_PER_INCH = 200
LONGEST_NAME = 80  # of the runs in the name of a figure of several

plt.rcParams.update(
    {
        "figure.figsize": (WIDTH_MM * MM, HEIGHT_MM * MM),
        "figure.dpi": DOTS_PER_INCH,
        "savefig.dpi": DOTS_PER_INCH,
        "savefig.bbox": "tight",
        "savefig.pad_inches": 0.03,
        "font.family": "sans-serif",
        "font.size": 9,
        "axes.labelsize": 9,
        "axes.titlesize": 9,
        "legend.fontsize": 8,
        "xtick.labelsize": 8,
        "ytick.labelsize": 8,
        "axes.prop_cycle": cycler(color=PALETTE),
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.linewidth": 0.7,
        "axes.grid": True,
        "grid.color": "#dddddd",
        "grid.linewidth": 0.5,
        "axes.axisbelow": True,
        "lines.linewidth": 1.4,
        "lines.markersize": 4.5,
        "legend.frameon": False,
        "pdf.fonttype": 42,
    }
)

# Names of the history's columns on an axis: name, unit
AXIS_NAME = {
    "shear_displacement": "Shear displacement",
    "shear_stress": "Shear stress",
    "normal_stress": "Normal stress",
    "dilation": "Dilation",
    "closure": "Closure",
    "aperture": "Aperture",
    "time": "Time",
    "stress_xx": "Normal stress in x",
    "stress_yy": "Normal stress in y",
    "stress_xy": "Shear stress xy",
    "stress_1": "Largest compression",
    "stress_3": "Least compression",
    "stress_1_angle": "Direction of the largest compression",
}
UNITS = ("mm", "MPa", "s", "J", "deg", "m", "m2")
UNIT_TEXT = {"deg": "degrees", "m2": "m²"}


def axis_label(column):
    """Text of an axis from a name that ends in its unit: 'G.shear_stress_MPa' -> 'Shear stress, G [MPa]'."""
    group, _, name = column.rpartition(".")
    stem, _, unit = name.rpartition("_")
    if unit not in UNITS:
        stem, unit = name, ""
    unit = UNIT_TEXT.get(unit, unit)
    text = AXIS_NAME.get(stem, stem.replace("_", " ").capitalize())
    if group:
        text += f", {group}"
    return f"{text} [{unit}]" if unit else text


def numeric(axes, x, y, index, label):
    """A computed curve: a line."""
    axes.plot(x, y, color=PALETTE[index % len(PALETTE)], label=label)


def empirical(axes, x, y, index, label):
    """Points of the empirical law: open markers on top of the lines."""
    axes.plot(
        x,
        y,
        linestyle="none",
        marker=MARKERS[index % len(MARKERS)],
        markerfacecolor="white",
        markeredgecolor=PALETTE[index % len(PALETTE)],
        markeredgewidth=1.0,
        label=label,
        zorder=3,
    )


def comparison_legend(axes, labels, **options):
    """One entry a run, and two in grey that say what lines and markers are."""
    line = plt.Line2D([], [], color="#555555")
    points = plt.Line2D(
        [],
        [],
        color="#555555",
        linestyle="none",
        marker="o",
        markerfacecolor="white",
        markeredgecolor="#555555",
    )
    runs = [
        plt.Line2D(
            [],
            [],
            color=PALETTE[i % len(PALETTE)],
            marker=MARKERS[i % len(MARKERS)],
            markerfacecolor="white",
        )
        for i in range(len(labels))
    ]
    if len(labels) == 1:
        # The one run is told by the figure's title or caption
        runs, labels = [], []
    return axes.legend([*runs, line, points], [*labels, "computed", "empirical law"], **options)


def place(runs, name):
    """Path without suffix of a figure that is given none: in the run's own directory, or, of several, beside them."""
    if len(runs) == 1:
        return Path(runs[0].directory) / "figures" / name
    directories = [Path(run.directory).resolve() for run in runs]
    common = Path(os.path.commonpath([directory.parent for directory in directories]))
    names = "+".join("_".join(directory.relative_to(common).parts) for directory in directories)
    names = names if len(names) <= LONGEST_NAME else f"{len(runs)}_runs"
    folder = common / "figures"
    return (
        folder.relative_to(Path.cwd()) if folder.is_relative_to(Path.cwd()) else folder
    ) / f"{name}_{names}"


def save(figure, out, runs, name):
    """Write PDF and PNG and print their paths. `out` is a path without suffix; None: that of place(runs, name)."""
    stem = Path(out) if out else place(runs, name)
    if stem.suffix in (".pdf", ".png"):
        stem = stem.with_suffix("")
    stem.parent.mkdir(parents=True, exist_ok=True)
    for suffix in (".pdf", ".png"):
        path = stem.with_name(stem.name + suffix)
        figure.savefig(path)
        print(path)
    plt.close(figure)


def parser(module, description, several=True):
    """Arguments that all figures share; a figure is named by its module."""
    made = argparse.ArgumentParser(
        prog=f"femdem-plot {module.rpartition('.')[2]}",
        description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    if several:
        made.add_argument("results", nargs="+", help="results directories")
        made.add_argument("--labels", nargs="+", help="one label a directory (default: title of the deck)")
    else:
        made.add_argument("results", help="results directory")
    made.add_argument(
        "--out",
        help="path of the figure without suffix (default: figures/ in the results, or beside them when they are several)",
    )
    return made


def joint_arguments(made, reference=True):
    """Arguments of the figures of one joint group"""
    made.add_argument("--group", help="joint group (default: the only one)")
    if reference:
        made.add_argument("--length", type=float, help="effective length in m (default: from edges.csv)")
        made.add_argument("--csv", help="write the table of errors to this file too")


def open_results(arguments):
    """The runs and their labels"""
    runs = [Results(directory) for directory in arguments.results]
    labels = arguments.labels or [run.label for run in runs]
    if len(labels) != len(runs):
        raise ResultsError(f"{len(labels)} labels for {len(runs)} results directories")
    # Runs of one deck in several directories share a title.
    if len(set(labels)) < len(labels):
        labels = [run.directory.name for run in runs]
    return runs, labels


def error_table(heading, rows, path=None):
    """Print a table, and write it as CSV where asked for."""
    texts = [[f"{value:.4g}" if isinstance(value, float) else str(value) for value in row] for row in rows]
    widths = [max(len(line[i]) for line in [heading, *texts]) for i in range(len(heading))]
    for line in [heading, *texts]:
        print("  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)))
    if path:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        with open(path, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([heading, *rows])
        print(path)
