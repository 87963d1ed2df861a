"""Traces of a random network of two fracture sets in a square; the same seed gives the same network.

    femdem-traces --seed 7 --out two_sets.csv

Straight traces strike 100 or 140 degrees (clockwise from north, y), with some scatter. Lengths follow a power law
n(l) ~ l**-exponent between the shortest and the longest. Centres are spread evenly over a square wide enough that the
window has no rim, and traces are added until their length per area in the window (P21) reaches the one given, or until
so many as given lie in the window. Lengths are in metres, angles in degrees.
"""

import argparse
import sys
from collections import Counter

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.special import ndtri

from femdem.network.planar_graph import COINCIDENT, SIDE_BIT, graph_of, knit
from femdem.network.traces import TraceError, Traces, clip, write_traces

STRIKES = (100.0, 140.0)  # of Lei, Latham & Xiang (2016), section 4
DRAWN_AT_ONCE = 64
MOST_DRAWN = 10_000_000  # centres, before giving up


def power_law(uniform, exponent, shortest, longest):
    """Lengths whose density falls as length**-exponent, from numbers even in 0 to 1 (inverse of the distribution)."""
    if exponent == 1.0:
        return shortest * (longest / shortest) ** uniform
    power = 1.0 - exponent
    return (shortest**power + uniform * (longest**power - shortest**power)) ** (1.0 / power)


def two_sets(seed, side, strikes, scatter, share, exponent, shortest, longest, p21=None, count=None):
    """Traces in a square of a side [m], the first set a share of their number, until p21 [1/m] or count is reached."""
    random = np.random.default_rng(seed)
    window = (0.0, 0.0, side, side)
    kept, of_set, drawn, length = [], [], 0, 0.0
    while drawn < MOST_DRAWN:
        # Everything of one trace is drawn in one row, so that traces do not depend on how many are drawn at once
        number = random.random((DRAWN_AT_ONCE, 5))
        turn = scatter * ndtri(number[:, 4])
        drawn += DRAWN_AT_ONCE
        which = (number[:, 0] >= share).astype(int)
        strike = np.radians(np.array(strikes)[which] + turn)
        half = power_law(number[:, 1], exponent, shortest, longest)[:, None] / 2
        along = half * np.stack([np.sin(strike), np.cos(strike)], axis=1)
        centre = -longest / 2 + (side + longest) * number[:, 2:4]
        # To the micrometre, as digitised traces are
        for ends, one in zip(np.round(np.hstack([centre - along, centre + along]), 6), which, strict=True):
            inside = clip(Traces(ends[None, :], np.array([0]), ["0"]), window)
            if len(inside.segment) == 0:
                continue
            kept.append(inside.segment[0])
            of_set.append(int(one))
            length += inside.length
            if (p21 is not None and length >= p21 * side**2) or (count is not None and len(kept) >= count):
                names = [str(k) for k in range(len(kept))]
                return Traces(np.array(kept), np.arange(len(kept)), names), np.array(of_set)
    raise TraceError("too many traces are needed; make them longer or fewer")


def spans(traces, side):
    """Does a connected cluster of traces join left and right, bottom and top? (two answers)"""
    graph = knit(graph_of(traces, (0.0, 0.0, side, side)), COINCIDENT * side, Counter())
    edge = graph.edge[graph.is_fracture]
    n = len(graph.xy)
    _, cluster = connected_components(coo_matrix((np.ones(len(edge)), edge.T), shape=(n, n)), directed=False)
    at = [set(cluster[(graph.side & bit > 0) & (graph.degree > 0)]) for bit in SIDE_BIT.values()]
    return bool(at[0] & at[1]), bool(at[2] & at[3])


def arguments_of(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="femdem-traces", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, required=True, help="seed of the random numbers")
    parser.add_argument("--out", required=True, help="CSV file to write")
    parser.add_argument("--side", type=float, default=2.0, help="side of the square (m; default 2)")
    parser.add_argument(
        "--strikes", type=float, nargs=2, default=STRIKES, help="of the two sets (default 100 140)"
    )
    parser.add_argument(
        "--scatter", type=float, default=3.0, help="standard deviation of the strike (default 3)"
    )
    parser.add_argument(
        "--share", type=float, default=0.6, help="share of traces in the first set (default 0.6)"
    )
    parser.add_argument("--exponent", type=float, default=2.0, help="of the power law of lengths (default 2)")
    parser.add_argument("--shortest", type=float, default=0.4, help="shortest trace (m; default 0.4)")
    parser.add_argument("--longest", type=float, default=4.0, help="longest trace (m; default 4)")
    stop = parser.add_mutually_exclusive_group()
    stop.add_argument("--p21", type=float, default=7.0, help="length of traces per area (1/m; default 7)")
    stop.add_argument("--traces", type=int, help="number of traces, in place of --p21")
    return parser.parse_args(words)


def main(words=None):
    arguments = arguments_of(words)
    side, shortest, longest = arguments.side, arguments.shortest, arguments.longest
    if not (side > 0.0 and 0.0 < shortest < longest):
        sys.exit("error: --side must be positive, and --shortest between 0 and --longest")
    if not (0.0 <= arguments.share <= 1.0 and arguments.scatter >= 0.0 and arguments.p21 > 0.0):
        sys.exit("error: --share must be between 0 and 1, --scatter not negative and --p21 positive")
    if arguments.traces is not None and arguments.traces < 1:
        sys.exit("error: --traces must be 1 at least")
    try:
        traces, of_set = two_sets(
            arguments.seed,
            side,
            arguments.strikes,
            arguments.scatter,
            arguments.share,
            arguments.exponent,
            shortest,
            longest,
            p21=arguments.p21 if arguments.traces is None else None,
            count=arguments.traces,
        )
        write_traces(arguments.out, traces)
    except (TraceError, OSError) as error:
        sys.exit(f"error: {error}")
    counts = np.bincount(of_set, minlength=2)
    across, upward = spans(traces, side)
    print(f"{arguments.out}: {len(of_set)} traces, {counts[0]} and {counts[1]} of the two sets")
    print(
        f"P21 {traces.length / side**2:.3f} 1/m; mean length in the window {traces.length / len(of_set):.3f} m"
    )
    print(f"joined left to right: {'yes' if across else 'no'}; bottom to top: {'yes' if upward else 'no'}")


if __name__ == "__main__":
    main()
