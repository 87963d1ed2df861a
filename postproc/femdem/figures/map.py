"""A map of a field of the rock, of a quantity of the joints, or of both.

femdem-plot map results --rock stress_1
femdem-plot map results --joints aperture_mm --step 3 --out aperture
femdem-plot map results --rock displacement --joints shear_displacement_mm --magnitude
femdem-plot map results --list
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap

from femdem.figures import maps, style

TAILS = (
    1.0  # per cent of the triangles left out at either end of the rock's colours: corners would take them all
)
THIN, THICK = 0.8, 3.4  # line widths in points between the least and the largest mean of a block edge
CASING = 0.9  # width in points of the dark line on either side of a joint whose colour may be pale
QUIET = LinearSegmentedColormap.from_list("quiet", ["#f7f7f7", "#8a8a8a"])  # for rock under coloured joints
PASCALS = 1e6  # in a megapascal
# Lengths and velocities in the unit that gives values of everyday size: largest value below which, factor, prefix
FINER = {"m": ((1e-4, 1e6, "µ"), (0.1, 1e3, "m")), "mm": ((1e-2, 1e3, "µ"),)}


def chosen_field(fields, mesh, name, step, magnitude):
    """Values on triangles or joints, and the text of the colour bar"""
    component = None
    if name.endswith((".x", ".y")):
        name, component = name[:-2], "xy".index(name[-1])
    values = fields.read(name, step)
    place, unit, _ = fields.names(step)[name]
    text = style.axis_label(name).partition(" [")[0]
    if values.ndim == 2:
        values = np.hypot(*values.T) if component is None else values[:, component]
        text += "" if component is None else f" in {'xy'[component]}"
    if magnitude:
        values = np.abs(values)
    if unit == "Pa":
        values, unit = values / PASCALS, "MPa"
    values, unit = in_finer_unit(values, unit)
    if place == "nodes":
        values = values[mesh.triangles].mean(axis=1)
    return place, values, text if unit in ("1", "-") else f"{text} [{unit}]"


def in_finer_unit(values, unit):
    """Values and their unit: millimetres or micrometres where metres would be small fractions"""
    length, per, second = unit.partition("/")
    largest = float(np.max(np.abs(values), initial=0.0))
    for below, factor, prefix in FINER.get(length, ()):
        if 0.0 < largest < below:
            return values * factor, f"{prefix}m{per}{second}"
    return values, unit


def colours(values, limits):
    """Colour map and its range: diverging about zero where there are both signs"""
    least, largest = limits or (float(np.min(values)), float(np.max(values)))
    if least < 0 < largest and limits is None:
        largest = max(-least, largest)
        return style.DIVERGING, -largest, largest
    if least == largest:
        largest = least + (abs(least) if least else 1.0)
    return style.SEQUENTIAL, least, largest


def draw_rock(figure, axes, corners, values, text, limits, under_joints):
    colour_map, least, largest = colours(
        np.clip(values, *np.percentile(values, [TAILS, 100 - TAILS])), limits
    )
    if under_joints:
        colour_map = QUIET
    drawn = PolyCollection(
        corners, array=values, cmap=colour_map, edgecolor="face", linewidth=0.1, rasterized=True
    )
    drawn.set_clim(least, largest)
    axes.add_collection(drawn)
    maps.colour_bar(figure, drawn, axes, text, values, shrink=0.8)


def draw_joints(figure, axes, mesh, shown, values, text, limits, width):
    """The joint elements shown; single ones with extreme values are neither thick nor the end of the colours"""
    lines, length = mesh.joint_lines[shown], maps.lengths(mesh.joint_lines[shown])
    colour_map, least, largest = colours(np.clip(values, *maps.inner_range(values, length)), limits)
    means = maps.edge_means(mesh.block_edge[shown], length, np.abs(values))
    span = max(abs(least), abs(largest))
    share = np.clip(means / span, 0, 1) * maps.slenderness(mesh.block_edge[shown], lines)
    widths = width if width else THIN + (THICK - THIN) * share
    # Block edges with large values last, so that they are not covered.
    order = np.argsort(means, kind="stable")
    if colour_map == style.DIVERGING:
        casing = (widths if width else widths[order]) + CASING
        axes.add_collection(LineCollection(lines[order], color="#333333", linewidth=casing, capstyle="butt"))
    drawn = LineCollection(
        lines[order],
        array=values[order],
        cmap=colour_map if colour_map == style.DIVERGING else "plasma_r",
        linewidth=widths if width else widths[order],
        capstyle="projecting",
    )
    drawn.set_clim(least, largest)
    axes.add_collection(drawn)
    maps.colour_bar(figure, drawn, axes, text, values, shrink=0.8)


def main(words=None):
    arguments = style.parser(__name__, __doc__, several=False)
    arguments.add_argument("--rock", help="field on nodes or triangles; a vector's component: displacement.x")
    arguments.add_argument("--joints", help="quantity of the joints")
    arguments.add_argument("--step", type=int, default=-1, help="snapshot, from 0 (default: last)")
    arguments.add_argument("--magnitude", action="store_true", help="draw absolute values")
    arguments.add_argument(
        "--rock-limits", nargs=2, type=float, help="range of the rock's colours, in the colour bar's unit"
    )
    arguments.add_argument(
        "--joint-limits", nargs=2, type=float, help="range of the joints' colours, in the colour bar's unit"
    )
    arguments.add_argument(
        "--width", type=float, help="width of all joint lines in points (default: by the value)"
    )
    arguments.add_argument(
        "--deformed", type=float, default=0.0, help="displacements drawn this many times (0)"
    )
    arguments.add_argument("--cracks", action="store_true", help="draw the cracks of cracks.csv in red")
    arguments.add_argument("--list", action="store_true", help="list the fields and stop")
    arguments = arguments.parse_args(words)
    run = style.Results(arguments.results)
    fields = run.fields
    if arguments.list or not (arguments.rock or arguments.joints):
        for name, (place, unit, description) in fields.names(arguments.step).items():
            print(f"{name:28s} {place:10s} [{unit}] {description}")
        return
    mesh = fields.mesh(arguments.step)
    if arguments.deformed:
        mesh.coordinates = mesh.coordinates + arguments.deformed * fields.read("displacement", arguments.step)

    figure, axes = plt.subplots(constrained_layout=True)
    corners = mesh.coordinates[mesh.triangles]
    axes.add_collection(
        LineCollection(mesh.coordinates[mesh.surface[mesh.surface_joint < 0]], color="#333333", linewidth=0.8)
    )
    if arguments.rock:
        place, values, text = chosen_field(fields, mesh, arguments.rock, arguments.step, arguments.magnitude)
        if place == "joints":
            raise style.ResultsError(f"{arguments.rock} is a quantity of the joints: use --joints")
        draw_rock(figure, axes, corners, values, text, arguments.rock_limits, bool(arguments.joints))
    # Cohesive joints of the rock are no fractures; they are shown where there is nothing else
    shown = mesh.block_edge > 0
    if not shown.any():
        shown = np.ones(len(mesh.joints), dtype=bool)
    if arguments.joints and not len(mesh.joints):
        if not arguments.rock:
            raise style.ResultsError(f"there are no joints at this time: {arguments.joints} cannot be drawn")
        print(f"there are no joints at this time: {arguments.joints} is not drawn")
    elif arguments.joints:
        place, values, text = chosen_field(
            fields, mesh, arguments.joints, arguments.step, arguments.magnitude
        )
        if place != "joints":
            raise style.ResultsError(f"{arguments.joints} is a field on {place}: use --rock")
        draw_joints(figure, axes, mesh, shown, values[shown], text, arguments.joint_limits, arguments.width)
    elif len(mesh.joints):
        axes.add_collection(LineCollection(mesh.joint_lines[shown], color="#222222", linewidth=0.6))
    if arguments.cracks:
        number = maps.draw_cracks(axes, run, fields.times[arguments.step])
        print(f"{number} broken joints")
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.02)
    axes.grid(False)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    time = fields.times[arguments.step]
    axes.set_title(
        f"{maps.stage_name(fields.stages[arguments.step])}, cycle {fields.cycles[arguments.step]}, t = {time:.4g} s"
    )
    style.save(figure, arguments.out, [run], "map")
