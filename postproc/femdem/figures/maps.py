"""Maps of fracture networks side by side, with common colours: the part that several scripts share."""

import csv
import io
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from femdem.figures import style

MODEL_NAMES = {"jcm": "JCM", "jcm_mean": "Model-I", "coulomb": "Model-II"}
QUANTITIES = {"shear_displacement_mm": "plasma_r", "aperture_mm": "viridis_r"}  # of the joints: colour map
# Per cent of the length beyond an end of the colours: single elements at tips and crossings would take them all
TAIL = 1.0
SHORT = 0.05  # of the map's longer side: shorter block edges are drawn thinner, or they would be dots
THIN, THICK = 0.7, 3.2  # line widths in points between the least and the largest mean of a block edge
CRACK, CRACK_WIDTH = "#e31a1c", 1.1
FAINT = "#9a9a9a"  # fractures under their coloured lines, so that pale ones are seen
PANEL_MM = 62


@dataclass
class Panel:
    """One map: a snapshot of a run."""

    run: style.Results
    step: int
    label: str

    def fractures(self):
        """Which joint elements are on fractures that were there from the start, not cohesive joints of the rock"""
        return self.run.fields.mesh(self.step).block_edge > 0

    def lines(self):
        return self.run.fields.mesh(self.step).joint_lines[self.fractures()]

    def values(self, quantity):
        return np.abs(self.run.fields.read(quantity, self.step))[self.fractures()]

    def means(self, quantity):
        """Of each joint element, the mean of its block edge"""
        return edge_means(self.block_edge(), lengths(self.lines()), self.values(quantity))

    def slenderness(self):
        """Of each joint element, the part of the full width that suits the length of its block edge"""
        return slenderness(self.block_edge(), self.lines())

    def block_edge(self):
        return self.run.fields.mesh(self.step).block_edge[self.fractures()]


def lengths(lines):
    """Lengths of lines (lines, 2 ends, 2 coordinates) [m]"""
    return np.hypot(*(lines[:, 1] - lines[:, 0]).T)


def edge_means(block_edge, length, values):
    """Of each joint element, the mean of the values on its block edge, weighted by length; its own outside block edges.

    Widths and order of lines go with it: a single element with a large value is then a change of colour on its line,
    and no dot that hides what lies around it.
    """
    whole = np.bincount(block_edge, weights=length)[block_edge]
    means = np.bincount(block_edge, weights=length * values)[block_edge] / np.where(whole > 0, whole, 1.0)
    return np.where((block_edge > 0) & (whole > 0), means, values)


def slenderness(block_edge, lines):
    """Part of the full width for the line of each joint element: less than 1 on block edges short against the map."""
    length = lengths(lines)
    whole = np.where(block_edge > 0, np.bincount(block_edge, weights=length)[block_edge], length)
    places = lines.reshape(-1, 2)
    return np.minimum(1.0, whole / (SHORT * np.ptp(places, axis=0).max()))


def inner_range(values, length, tail=TAIL):
    """Range of the values but for a share of the length [per cent] at either end."""
    order = np.argsort(values)
    share = np.cumsum(length[order])
    ends = np.searchsorted(share, share[-1] * np.array([tail, 100 - tail]) / 100)
    least, most = values[order[np.minimum(ends, len(values) - 1)]]
    return float(least), float(most)


def colour_bar(figure, drawn, axes, text, values, **options):
    """A colour bar with pointed ends where values lie beyond it, and the farthest of them written there."""
    least, most = drawn.get_clim()
    low, high = float(np.min(values)), float(np.max(values))
    # Rounding of a limit that is the extreme value itself is not beyond
    slack = 1e-9 * (most - least)
    below, above = low < least - slack, high > most + slack
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    bar = figure.colorbar(drawn, ax=axes, extend=extend[below, above], **options)
    bar.set_label(text)
    for beyond, value, place, side in ((below, low, -0.07, "top"), (above, high, 1.07, "bottom")):
        if beyond:
            bar.ax.text(
                0.5, place, f"to {value:.3g}", transform=bar.ax.transAxes, ha="center", va=side, fontsize=7
            )
    return bar


@dataclass
class Cracks:
    """Lines of the cracks of a run up to a time, and their modes."""

    lines: np.ndarray  # (cracks, 2 ends, 2 coordinates) [m]
    mode: np.ndarray


def read_cracks(run, time=np.inf):
    """The cracks in cracks.csv that were there at a time [s]; none when the run has no such file."""
    path = run.directory / "cracks.csv"
    # A run of rock that cannot break leaves the file of an older run in the same directory alone
    if not path.is_file() or not can_break(run):
        return Cracks(np.zeros((0, 2, 2)), np.array([]))
    with path.open(newline="", encoding="utf-8") as file:
        text = file.read()
    # A row that is being written is left out
    complete = io.StringIO(text[: text.rfind("\n") + 1], newline="")
    rows = [row for row in csv.DictReader(complete) if float(row["time_s"]) <= time * (1 + 1e-9)]
    centre = np.array([[float(row["x_m"]), float(row["y_m"])] for row in rows]).reshape(-1, 2)
    angle = np.radians([float(row["angle_deg"]) for row in rows])
    half = 0.5 * np.array([float(row["length_m"]) for row in rows])
    along = (half * np.array([np.cos(angle), np.sin(angle)])).T.reshape(-1, 2)
    return Cracks(np.stack([centre - along, centre + along], axis=1), np.array([row["mode"] for row in rows]))


def can_break(run):
    """Could rock break in this run? Taken so where its deck is not there."""
    try:
        # Runs of the version before call it fracture
        return bool(run.deck.all("cohesive") or run.deck.all("fracture"))
    except style.ResultsError:
        return True


def draw_cracks(axes, run, time=np.inf):
    """Draw the cracks of a run; how many there are."""
    cracks = read_cracks(run, time)
    axes.add_collection(LineCollection(cracks.lines, color=CRACK, linewidth=CRACK_WIDTH, zorder=4))
    return len(cracks.lines)


def stage_name(text):
    """Name of a stage as a title: 'phase_2b' -> 'Phase II-B'."""
    words = text.split("_")
    if words[0] == "phase" and len(words) == 2 and words[1][:1] in ("1", "2", "3"):
        number = "I" * int(words[1][0])
        return f"Phase {number}" + (f"-{words[1][1:].upper()}" if words[1][1:] else "")
    return text.replace("_", " ")


def model_name(run):
    """'JCM', 'Model-I' or 'Model-II', from the law of the run's first joint group"""
    law = run.deck.all("joint")[0].get("law", "jcm")
    return MODEL_NAMES.get(law, law)


def common_limits(panels, quantity):
    """Ends of the colours, for all panels: all values but those on a small share of the length"""
    values = np.concatenate([panel.values(quantity) for panel in panels])
    least, most = inner_range(values, np.concatenate([lengths(panel.lines()) for panel in panels]))
    least = 0.0 if quantity.startswith("shear") else least
    return least, most if most > least else least + 1.0


def draw_fractures(axes, panel, quantity, least, most):
    lines, values = panel.lines(), panel.values(quantity)
    share = np.clip((panel.means(quantity) - least) / (most - least), 0, 1)
    # Block edges with large values last, so that they are not covered; the elements of one stay together
    order = np.argsort(share, kind="stable")
    axes.add_collection(LineCollection(lines, color=FAINT, linewidth=THIN))
    drawn = LineCollection(
        lines[order],
        array=values[order],
        cmap=QUANTITIES[quantity],
        linewidth=(THIN + (THICK - THIN) * share * panel.slenderness())[order],
        capstyle="projecting",
    )
    drawn.set_clim(least, most)
    axes.add_collection(drawn)
    return drawn


def frame(axes, panel):
    """Outline of the rock, and axes that show it whole"""
    mesh = panel.run.fields.mesh(panel.step)
    axes.add_collection(
        LineCollection(mesh.coordinates[mesh.surface[mesh.surface_joint < 0]], color="#333333", linewidth=0.8)
    )
    axes.set_aspect("equal")
    low, high = mesh.coordinates.min(axis=0), mesh.coordinates.max(axis=0)
    edge = 0.02 * (high - low)
    axes.set_xlim(low[0] - edge[0], high[0] + edge[0])
    axes.set_ylim(low[1] - edge[1], high[1] + edge[1])
    axes.grid(False)


def draw_panels(panels, quantities=tuple(QUANTITIES)):
    """A row of maps a quantity, a column a panel, one colour bar a row; prints means and largest values."""
    figure, grid = plt.subplots(
        len(quantities),
        len(panels),
        squeeze=False,
        sharex=True,
        sharey=True,
        figsize=((len(panels) * PANEL_MM + 18) * style.MM, (len(quantities) * PANEL_MM + 6) * style.MM),
        constrained_layout=True,
    )
    letter = ord("a")
    table = []
    for row, quantity in zip(grid, quantities, strict=True):
        least, most = common_limits(panels, quantity)
        for axes, panel in zip(row, panels, strict=True):
            values = panel.values(quantity)
            drawn = draw_fractures(axes, panel, quantity, least, most)
            cracks = draw_cracks(axes, panel.run, panel.run.fields.times[panel.step])
            frame(axes, panel)
            axes.set_title(f"({chr(letter)}) {panel.label}", loc="left")
            letter += 1
            mean = float(np.average(values, weights=lengths(panel.lines())))
            table.append([panel.label, quantity, mean, float(values.max()), cracks])
        values = np.concatenate([panel.values(quantity) for panel in panels])
        colour_bar(figure, drawn, row, style.axis_label(quantity), values, shrink=0.9, pad=0.01)
    for axes in grid[-1]:
        axes.set_xlabel("x [m]")
    for axes in grid[:, 0]:
        axes.set_ylabel("y [m]")
    style.error_table(["run", "quantity", "mean_by_length", "largest", "cracks"], table)
    return figure


def check_labels(labels, panels):
    """Put the labels of the command line on the panels"""
    if labels is None:
        return panels
    if len(labels) != len(panels):
        raise style.ResultsError(f"{len(labels)} labels for {len(panels)} maps")
    return [Panel(panel.run, panel.step, label) for panel, label in zip(panels, labels, strict=True)]
