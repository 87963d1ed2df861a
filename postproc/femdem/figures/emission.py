"""Acoustic emission: the number of cracks above each magnitude (Gutenberg and Richter), and the magnitudes in time.

femdem-plot emission results --out emission
femdem-plot emission results --cluster 1e-4 0.1

With --cluster cracks that follow each other within a time and a distance are one event (Hazzard and Young 2004): its moment tensor
is the sum of theirs, its width the sum of their lengths. Prints the b value by the largest likelihood (Aki 1965, with the bin's
half width of Utsu) above the magnitude of completeness: the fullest bin, or --least. Magnitudes are those of cracks.csv, each for a
crack as wide as it is long.
"""

import csv

import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from femdem.figures import style

BIN = 0.1  # width of the bins of magnitudes
LEAST = 1e-3  # moment of an event in which nothing has moved [N m]
FEWEST = 10  # cracks that a b value is worth


def magnitudes(moment, width):
    """Moment magnitudes (Hanks and Kanamori 1979) of tensors xx, yy, xy, zz per metre of thickness (n, 4) [N m/m]"""
    size = np.sqrt(0.5 * (moment**2 @ np.array([1.0, 1.0, 2.0, 1.0])))
    return 2 / 3 * (np.log10(np.maximum(size * width, LEAST)) - 9.1)


def clusters(time, place, within, apart):
    """Number of the cluster of each crack: linked to those that broke within a time [s] and a distance [m] of it"""
    pairs = cKDTree(place).query_pairs(apart, output_type="ndarray")
    pairs = pairs[np.abs(time[pairs[:, 0]] - time[pairs[:, 1]]) <= within]
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(time), len(time)))
    return connected_components(graph, directed=False)[1]


def read_events(run, cluster=None):
    """Times [s] and magnitudes of the cracks of a run, or of their clusters (time [s], distance [m])"""
    path = run.directory / "cracks.csv"
    if not path.is_file():
        raise style.ResultsError(f"{path}: there is no such file; rock breaks where the deck has a &cohesive")
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if rows and "magnitude" not in rows[0]:
        raise style.ResultsError(f"{path}: has no magnitudes; it is of an earlier version")
    time, x, y, length, magnitude = (
        np.array([float(row[name]) for row in rows])
        for name in ("time_s", "x_m", "y_m", "length_m", "magnitude")
    )
    if cluster is None or not rows:
        return time, magnitude
    number = clusters(time, np.column_stack([x, y]), *cluster)
    moment = np.array([[float(row[f"m{name}_N"]) for name in ("xx", "yy", "xy", "zz")] for row in rows])
    first = np.full(number.max() + 1, np.inf)
    np.minimum.at(first, number, time)
    summed = np.stack([np.bincount(number, column) for column in moment.T], axis=1)
    return first, magnitudes(summed, np.bincount(number, length))


def b_value(magnitude, least=None):
    """Magnitude of completeness, b value and its standard error (none where there are too few cracks)"""
    bins = np.round(magnitude / BIN).astype(int)
    if least is None:
        values, count = np.unique(bins, return_counts=True)
        least = values[np.argmax(count)] * BIN
    above = bins[bins >= round(least / BIN)] * BIN
    if len(above) < FEWEST or np.ptp(above) == 0:
        return least, None, None
    b = np.log10(np.e) / (above.mean() - (least - 0.5 * BIN))
    return least, b, b / np.sqrt(len(above))


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    arguments.add_argument("--least", type=float, help="magnitude above which all cracks are there")
    arguments.add_argument(
        "--cluster",
        type=float,
        nargs=2,
        metavar=("TIME", "DISTANCE"),
        help="cracks that make one event [s, m]",
    )
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    figure, (axes, history) = plt.subplots(
        1, 2, figsize=(1.55 * style.WIDTH_MM * style.MM, style.HEIGHT_MM * style.MM), constrained_layout=True
    )
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        time, magnitude = read_events(run, arguments.cluster)
        colour = style.PALETTE[i % len(style.PALETTE)]
        print(f"{label}: {len(magnitude)} {'events' if arguments.cluster else 'cracks'}")
        if not len(magnitude):
            continue
        order = np.sort(magnitude)
        axes.step(order, len(order) - np.arange(len(order)), where="pre", color=colour, label=label)
        history.plot(time, magnitude, "o", markersize=2.5, color=colour)
        least, b, error = b_value(magnitude, arguments.least)
        print(f"{label}: largest magnitude {order[-1]:.2f}, complete from {least:.1f}")
        if b is None:
            print(f"{label}: too few cracks for a b value")
            continue
        print(f"{label}: b = {b:.2f} +- {error:.2f}")
        above = np.array([least, order[-1]])
        number = np.sum(order >= least - 0.5 * BIN)
        axes.plot(above, number * 10 ** (-b * (above - least)), "--", color=colour, label=f"b = {b:.2f}")
    axes.set_yscale("log")
    axes.set_xlabel("Magnitude M")
    axes.set_ylabel("Events of M and more" if arguments.cluster else "Cracks of M and more")
    if axes.get_legend_handles_labels()[0]:
        axes.legend()
    history.set_xlabel("Time [s]")
    history.set_ylabel("Magnitude")
    style.save(figure, arguments.out, runs, "emission")
