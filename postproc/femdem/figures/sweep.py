"""Distributions of the numbers that a sweep collected, in a panel each, by the values of a parameter.

femdem-plot sweep realisations/table.csv --columns slip_2b_mm aperture_2b_mm --by joint.law

Prints number, mean, standard deviation and quantiles of each. Runs that failed are left out, and counted.
"""

import argparse
import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from femdem.figures import maps, style

BINS = 16
QUANTILES = (0.1, 0.5, 0.9)
HEADER = ["column", "value", "runs", "mean", "std", *(f"q{100 * q:.0f}" for q in QUANTILES)]
WIDEST = 3  # panels in a row
# More than this between least and largest, all above zero: a logarithmic axis
DECADES = 30.0


def read(path):
    """Rows of table.csv that are done, and how many are not"""
    path = Path(path)
    if not path.is_file():
        raise style.ResultsError(f"{path}: there is no such file; femdem-sweep writes it")
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows or "status" not in rows[0]:
        raise style.ResultsError(f"{path}: it is no table of a sweep")
    done = [row for row in rows if row["status"] == "done"]
    if not done:
        raise style.ResultsError(f"{path}: no run is done")
    return done, len(rows) - len(done)


def numbers(rows, column):
    """Values of a column, not a number where there is none"""
    if column not in rows[0]:
        raise style.ResultsError(f"no column {column!r}; there are: {', '.join(rows[0])}")
    return np.array([float(row[column]) if row[column] else np.nan for row in rows])


def collected(rows):
    """Names of the columns after those of every sweep"""
    names = list(rows[0])
    return names[names.index("results") + 1 :]


def draw(axes, column, values, by):
    """Histogram of a column, bars of the kinds beside each other, their means as dashed lines; rows of the table"""
    kinds = list(dict.fromkeys(by))
    sets = [values[[one == kind for one in by]] for kind in kinds]
    sets = [one[np.isfinite(one)] for one in sets]
    everything = np.concatenate(sets)
    if not len(everything):
        raise style.ResultsError(f"{column}: there are no numbers in it")
    low, high = float(everything.min()), float(everything.max())
    logarithmic = low > 0.0 and high > DECADES * low
    bins = (
        np.geomspace(low, high, BINS + 1)
        if logarithmic
        else np.linspace(low, high if high > low else low + 1.0, BINS + 1)
    )
    colours = [style.PALETTE[i % len(style.PALETTE)] for i in range(len(kinds))]
    axes.hist(sets, bins=bins, color=colours, rwidth=0.85)
    if logarithmic:
        axes.set_xscale("log")
    else:
        axes.xaxis.set_major_locator(MaxNLocator(5))
    for one, colour in zip(sets, colours, strict=True):
        if len(one):
            axes.axvline(one.mean(), color=colour, linestyle="--", linewidth=1.1)
    axes.set_xlabel(style.axis_label(column))
    axes.set_ylabel("Runs")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    return [
        [
            column,
            kind,
            len(one),
            float(one.mean()),
            float(one.std()),
            *(float(q) for q in np.quantile(one, QUANTILES)),
        ]
        for kind, one in zip(kinds, sets, strict=True)
        if len(one)
    ]


def main(words=None):
    parser = argparse.ArgumentParser(
        prog="femdem-plot sweep", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", help="table.csv of a sweep")
    parser.add_argument("--columns", nargs="+", help="columns to draw (default: all that were collected)")
    parser.add_argument("--by", help="parameter whose values are told apart by colour")
    parser.add_argument(
        "--out", help="path of the figure without suffix (default: figures/sweep beside the table)"
    )
    parser.add_argument("--csv", help="write the table of means and quantiles to this file too")
    arguments = parser.parse_args(words)
    rows, failed = read(arguments.table)
    columns = arguments.columns or collected(rows)
    if not columns:
        raise style.ResultsError(f"{arguments.table}: nothing was collected")
    if arguments.by and arguments.by not in rows[0]:
        raise style.ResultsError(f"no column {arguments.by!r}; there are: {', '.join(rows[0])}")
    by = [row[arguments.by] if arguments.by else "" for row in rows]
    across = 2 if len(columns) == 4 else min(len(columns), WIDEST)
    down = -(-len(columns) // across)
    figure, grid = plt.subplots(
        down,
        across,
        squeeze=False,
        figsize=(0.75 * across * style.WIDTH_MM * style.MM, 0.75 * down * style.HEIGHT_MM * style.MM),
        constrained_layout=True,
    )
    table = []
    for axes, column in zip(grid.ravel(), columns, strict=False):
        table += draw(axes, column, numbers(rows, column), by)
    for axes in grid.ravel()[len(columns) :]:
        axes.remove()
    if arguments.by:
        kinds = list(dict.fromkeys(by))
        handles = [
            plt.Rectangle((0, 0), 1, 1, color=style.PALETTE[i % len(style.PALETTE)])
            for i in range(len(kinds))
        ]
        handles.append(plt.Line2D([], [], color="#555555", linestyle="--", linewidth=1.1))
        labels = [*(maps.MODEL_NAMES.get(kind, kind) for kind in kinds), "mean"]
        grid[0, 0].legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=len(labels))
    style.error_table(HEADER, table, arguments.csv)
    print(f"{len(rows)} runs, {failed} more not done or failed")
    style.save(figure, arguments.out or Path(arguments.table).parent / "figures" / "sweep", [], "sweep")
