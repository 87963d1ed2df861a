#!/usr/bin/env python3
"""Traces of a random network of any sort, from a seed: the same seed gives the same network.

    python3 tests/make_network.py --seed 7 --out network.csv
    python3 tests/make_network.py --seed 7 --side 1 --p21 40 --out dense.csv --figure dense.png

femdem-traces draws the two straight sets of the paper; this one draws what else a map can have: one to four
sets, some at acute angles to each other; lengths by a power law; traces that curve and waver; later traces that end on
older ones, and others that branch off them at acute angles; ends that stop just short of another trace or just past it;
places rounded to the micrometre, so that abutments touch only nearly. What is not given on the command line is drawn with
the seed too. Lengths are in metres, angles in degrees.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postproc"))
from femdem.network.make_traces import power_law
from femdem.network.traces import TraceError, Traces, clip, write_traces

STEPS = 40  # of a trace along the side of the square
MOST_TRACES = 100_000  # tried, before giving up
DIGITS = 6  # of a place, as digitised traces have


@dataclass(frozen=True)
class Recipe:
    """What a network is drawn by."""

    side: float  # of the square [m]
    p21: float  # length of traces per area [1/m]
    strikes: tuple  # of the sets, clockwise from north
    scatter: float  # standard deviation of the strike
    exponent: float  # of the power law of lengths
    shortest: float
    longest: float
    bend: float  # standard deviation of how much a trace turns over the side of the square
    waver: float  # amplitude of its direction
    abut: float  # part of the meetings with an older trace at which a later one ends
    branch: float  # part of the traces that begin on an older one, at an acute angle
    loose: float  # part of the ends on another trace that stop short of it or go past


def recipe_of(seed, side=None, p21=None):
    """The recipe of a seed; side and p21 as given, or drawn: 0.5 to 4 m, 6 to 20 times a trace across it, 40 1/m at most."""
    random = np.random.default_rng([seed, 0])
    sets = int(random.integers(1, 5))
    strikes = random.uniform(0, 180, sets)
    # Half of the networks have two sets at an acute angle
    if sets > 1 and random.random() < 0.5:
        strikes[1] = strikes[0] + random.uniform(15, 35)
    number = random.uniform(0, 1, 10)
    side = float(side or 0.5 * 8.0 ** number[0])
    return Recipe(
        side=side,
        p21=float(p21 or min(40.0, (6 + 14 * number[1]) / side)),
        strikes=tuple((strikes % 180).tolist()),
        scatter=2 + 10 * number[2],
        exponent=1.5 + 1.5 * number[3],
        shortest=side * (0.1 + 0.1 * number[4]),
        longest=side * (1 + number[5]),
        bend=40 * number[6],
        waver=12 * number[7],
        abut=0.3 + 0.65 * number[8],
        branch=0.3 * number[9],
        loose=0.1,
    )


def course(random, recipe, start, direction, length):
    """Places along a trace that sets out from start in a direction [radians clockwise from north], at even steps."""
    steps = max(2, int(np.ceil(length / recipe.side * STEPS)))
    along = np.linspace(0, length, steps + 1)
    bend = np.radians(recipe.bend) / recipe.side * random.standard_normal()
    wave = recipe.side * random.uniform(0.3, 1.0)
    phase = random.uniform(0, 2 * np.pi)
    middle = (along[:-1] + along[1:]) / 2
    turn = np.sin(2 * np.pi * middle / wave + phase) - np.sin(phase)
    heading = direction + bend * middle + np.radians(recipe.waver) * turn
    step = length / steps * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    return np.vstack([start, start + np.cumsum(step, axis=0)])


def meetings(line, segments):
    """Where a line meets segments (n, 4): its steps, and parts of them, in order (meetings), (meetings)"""
    step = np.diff(line, axis=0)[:, None]
    along = segments[None, :, 2:] - segments[None, :, :2]
    apart = segments[None, :, :2] - line[:-1, None]
    cross = step[..., 0] * along[..., 1] - step[..., 1] * along[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        on_line = (apart[..., 0] * along[..., 1] - apart[..., 1] * along[..., 0]) / cross
        on_other = (apart[..., 0] * step[..., 1] - apart[..., 1] * step[..., 0]) / cross
    which = np.nonzero((on_line > 0) & (on_line <= 1) & (on_other >= 0) & (on_other <= 1))
    part = on_line[which]
    order = np.lexsort((part, which[0]))
    return which[0][order], part[order]


def ended(random, recipe, line, segments, begins_on):
    """The line up to the older trace that it ends on, if it does; one that begins on another does not meet it there."""
    for k, part in zip(*meetings(line, segments), strict=True):
        if begins_on and k == 0:
            continue
        if random.random() < recipe.abut:
            end = line[k] + part * (line[k + 1] - line[k])
            if random.random() < recipe.loose:
                # Up to a hundredth of the side short of it or past it
                step = line[k + 1] - line[k]
                end = end + random.uniform(-0.01, 0.01) * recipe.side * step / np.hypot(*step)
            return np.vstack([line[: k + 1], end])
    return line


def draw_network(seed, side=None, p21=None):
    """Traces of the network of a seed in a square from the origin, and its recipe."""
    recipe = recipe_of(seed, side, p21)
    random = np.random.default_rng([seed, 1])
    window = (0.0, 0.0, recipe.side, recipe.side)
    older, inside, length = np.zeros((0, 4)), [], 0.0
    for _ in range(MOST_TRACES):
        size = power_law(random.random(), recipe.exponent, recipe.shortest, recipe.longest)
        strike = np.radians(random.choice(recipe.strikes) + recipe.scatter * random.standard_normal())
        if len(older) and random.random() < recipe.branch:
            # It leaves an older trace at an acute angle, to either side
            ends = older[random.integers(len(older))]
            start = ends[:2] + random.random() * (ends[2:] - ends[:2])
            strike = np.arctan2(*(ends[2:] - ends[:2])) + np.radians(random.uniform(12, 40)) * random.choice(
                [-1, 1]
            )
            line = ended(random, recipe, course(random, recipe, start, strike, size), older, begins_on=True)
        else:
            # It grows both ways from its middle, in a square so wide that the window has no rim
            reach = recipe.side + recipe.longest
            start = -recipe.longest / 2 + reach * random.random(2)
            ways = [course(random, recipe, start, strike + turn, size / 2) for turn in (0, np.pi)]
            ways = [ended(random, recipe, way, older, begins_on=False) for way in ways]
            line = np.vstack([ways[1][:0:-1], ways[0]])
        line = np.round(line, DIGITS)
        line = line[np.append(True, (np.diff(line, axis=0) != 0).any(axis=1))]
        if len(line) < 2:
            continue
        segments = np.hstack([line[:-1], line[1:]])
        part = clip(Traces(segments, np.zeros(len(segments), dtype=int), ["0"]), window)
        if len(part.segment) == 0:
            continue
        older = np.vstack([older, segments])
        inside.append(part.segment)
        length += part.length
        if length >= recipe.p21 * recipe.side**2:
            number = np.repeat(np.arange(len(inside)), [len(segment) for segment in inside])
            return Traces(np.vstack(inside), number, [str(k) for k in range(len(inside))]), recipe
    raise TraceError("too many traces are needed; make them longer or fewer")


def draw(path, traces, recipe):
    """A picture of the traces."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    figure, axes = plt.subplots(figsize=(6, 6), layout="constrained")
    axes.add_collection(LineCollection(traces.segment.reshape(-1, 2, 2), colors="k", linewidths=0.8))
    axes.set(xlim=(0, recipe.side), ylim=(0, recipe.side), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, required=True, help="seed of the random numbers")
    parser.add_argument("--out", required=True, help="CSV file to write")
    parser.add_argument("--side", type=float, help="side of the square (m; default: 0.5 to 4, by the seed)")
    parser.add_argument("--p21", type=float, help="length of traces per area (1/m; default: by the seed)")
    parser.add_argument("--figure", help="picture to draw")
    arguments = parser.parse_args()
    if not all(value is None or value > 0 for value in (arguments.side, arguments.p21)):
        sys.exit("error: --side and --p21 must be positive")
    try:
        traces, recipe = draw_network(arguments.seed, arguments.side, arguments.p21)
        write_traces(arguments.out, traces)
    except (TraceError, OSError) as error:
        sys.exit(f"error: {error}")
    if arguments.figure:
        draw(arguments.figure, traces, recipe)
    strikes = ", ".join(f"{strike:.0f}" for strike in recipe.strikes)
    print(
        f"{arguments.out}: {traces.used} traces in {recipe.side:.3g} m, P21 {traces.length / recipe.side**2:.3g} 1/m"
    )
    print(
        f"sets strike {strikes}; {recipe.abut:.0%} of meetings end a trace, {recipe.branch:.0%} branch off another"
    )


if __name__ == "__main__":
    main()
