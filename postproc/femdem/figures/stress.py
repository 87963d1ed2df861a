"""Stress in the rock: largest and least compression as colours, with ticks along the largest compression.

femdem-plot stress phase_2b

Prints the mean stress of the rock, weighted by area, and the range of both principal stresses.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from femdem.figures import maps, style

PASCALS = 1e6  # in a megapascal
TAILS = (
    1.0  # per cent of the area left out at either end of the colours: tips and corners would take them all
)
TICKS = 22  # ticks of the direction along the longer side
FIELDS = {"stress_1": "Largest compression [MPa]", "stress_3": "Least compression [MPa]"}


def areas(mesh):
    corner = mesh.coordinates[mesh.triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def limits(values, area):
    """Range that leaves out a share of the area at either end"""
    order = np.argsort(values)
    share = np.cumsum(area[order]) / area.sum()
    ends = np.searchsorted(share, [TAILS / 100, 1 - TAILS / 100])
    return (float(values[order[k]]) for k in np.minimum(ends, len(values) - 1))


def direction_ticks(mesh, angle):
    """Short lines along the largest compression, one a cell of a grid: that of the triangle nearest to its middle"""
    centre = mesh.coordinates[mesh.triangles].mean(axis=1)
    low, high = mesh.coordinates.min(axis=0), mesh.coordinates.max(axis=0)
    cell = (high - low).max() / TICKS
    place = np.floor((centre - low) / cell).astype(int)
    off = np.hypot(*(centre - low - (place + 0.5) * cell).T)
    chosen = {}
    for k in np.argsort(-off):
        chosen[tuple(place[k])] = k
    k = np.array(list(chosen.values()))
    half = 0.35 * cell * np.column_stack([np.cos(angle[k]), np.sin(angle[k])])
    return np.stack([centre[k] - half, centre[k] + half], axis=1)


def main(words=None):
    arguments = style.parser(__name__, __doc__, several=False)
    arguments.add_argument("--step", type=int, default=-1, help="snapshot, from 0 (default: last)")
    arguments = arguments.parse_args(words)
    run = style.Results(arguments.results)
    fields, step = run.fields, arguments.step
    mesh = fields.mesh(step)
    area = areas(mesh)
    figure, grid = plt.subplots(
        1,
        2,
        sharey=True,
        figsize=(1.55 * style.WIDTH_MM * style.MM, 0.9 * style.HEIGHT_MM * style.MM),
        constrained_layout=True,
    )
    corners = mesh.coordinates[mesh.triangles]
    panel = maps.Panel(run, step, "")
    ticks = direction_ticks(mesh, np.radians(fields.read("stress_1_angle_deg", step)))
    for axes, letter, (name, text) in zip(grid, "ab", FIELDS.items(), strict=True):
        values = fields.read(name, step) / PASCALS
        least, most = limits(values, area)
        drawn = PolyCollection(
            corners, array=values, cmap=style.SEQUENTIAL, edgecolor="face", linewidth=0.1, rasterized=True
        )
        drawn.set_clim(least, most if most > least else least + 1.0)
        axes.add_collection(drawn)
        axes.add_collection(LineCollection(panel.lines(), color="white", linewidth=1.6))
        axes.add_collection(LineCollection(panel.lines(), color="#111111", linewidth=0.7))
        maps.draw_cracks(axes, run, fields.times[step])
        if name == "stress_1":
            axes.add_collection(LineCollection(ticks, color="#f2f2f2", linewidth=0.8))
        maps.frame(axes, panel)
        axes.set_title(f"({letter}) {maps.stage_name(fields.stages[step])}", loc="left")
        axes.set_xlabel("x [m]")
        maps.colour_bar(figure, drawn, axes, text, values, shrink=0.85, pad=0.01)
        print(f"{name}: {values.min():.4g} to {values.max():.4g} MPa")
    grid[0].set_ylabel("y [m]")
    for name in ("stress_xx", "stress_yy", "stress_xy"):
        mean = float(np.average(fields.read(name, step), weights=area)) / PASCALS
        print(f"mean {name}: {mean:.5g} MPa")
    style.save(figure, arguments.out, [run], "stress")
