"""Histograms of the mean aperture and the mean shear displacement of the block edges of several runs.

femdem-plot edge_histograms jcm/phase_2b jcm_mean/phase_2b coulomb/phase_2b

Prints mean, median and largest of the block edges' means, for all edges and for those longer than the mean length.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from femdem.figures import maps, style

BINS = 14
MOST = 98  # per cent of the block edges inside the axis; the last bar takes those beyond
QUANTITIES = {
    "mean_aperture_mm": "Mean aperture [mm]",
    "mean_shear_displacement_mm": "Mean shear displacement [mm]",
}
HEADER = ["run", "quantity", "edges", "mean", "median", "largest", "mean_of_long_edges"]


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    arguments.add_argument("--bins", type=int, default=BINS, help=f"number of bins (default {BINS})")
    arguments.add_argument("--csv", help="write the table to this file too")
    arguments = arguments.parse_args(words)
    runs = [style.Results(directory) for directory in arguments.results]
    labels = arguments.labels or [maps.model_name(run) for run in runs]
    if len(labels) != len(runs):
        raise style.ResultsError(f"{len(labels)} labels for {len(runs)} results directories")
    edges = [run.edges for run in runs]
    figure, grid = plt.subplots(
        1,
        2,
        figsize=(1.35 * style.WIDTH_MM * style.MM, 0.8 * style.HEIGHT_MM * style.MM),
        constrained_layout=True,
    )
    table = []
    for axes, (quantity, text) in zip(grid, QUANTITIES.items(), strict=True):
        values = [getattr(table_of, quantity) for table_of in edges]
        everything = np.concatenate(values)
        least = 0.0 if "shear" in quantity else float(everything.min())
        most = max(float(np.percentile(everything, MOST)), least + 1e-9)
        bins = np.linspace(least, most, arguments.bins + 1)
        # Bars of the runs stand beside each other in every bin: none covers another
        axes.hist(
            [np.minimum(value, most) for value in values],
            bins=bins,
            color=[style.PALETTE[i % len(style.PALETTE)] for i in range(len(runs))],
            rwidth=0.85,
        )
        for i, (table_of, value, label) in enumerate(zip(edges, values, labels, strict=True)):
            axes.axvline(
                value.mean(), color=style.PALETTE[i % len(style.PALETTE)], linestyle="--", linewidth=1.1
            )
            long = table_of.length_m > table_of.length_m.mean()
            table.append(
                [
                    label,
                    quantity,
                    len(value),
                    float(value.mean()),
                    float(np.median(value)),
                    float(value.max()),
                    float(value[long].mean()) if long.any() else float("nan"),
                ]
            )
        beyond = int((everything > most).sum())
        axes.set_xlabel(text)
        if beyond:
            note = f"last bars: {beyond} beyond"
            axes.text(
                1.0, -0.2, note, transform=axes.transAxes, ha="right", va="top", fontsize=6.5, color="#555555"
            )
        axes.set_ylabel("Block edges")
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    handles = [
        plt.Rectangle((0, 0), 1, 1, color=style.PALETTE[i % len(style.PALETTE)]) for i in range(len(runs))
    ]
    handles.append(plt.Line2D([], [], color="#555555", linestyle="--", linewidth=1.1))
    grid[1].legend(handles, [*labels, "mean"])
    style.error_table(HEADER, table, arguments.csv)
    style.save(figure, arguments.out, runs, "edge_histograms")
