"""Maps of fracture networks side by side, with common colours: the part that several scripts share."""

import csv
from dataclasses import dataclass

import figure_style as style
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

MODEL_NAMES = {"jcm": "JCM", "jcm_mean": "Model-I", "coulomb": "Model-II"}
QUANTITIES = {  # quantity of the joints: colour map, per cent of the length above the end of its colours
    "shear_displacement_mm": ("plasma_r", 0.5),
    "aperture_mm": ("viridis_r", 0.5),
}
THIN, THICK = 0.7, 3.6  # line widths in points between the least and the largest value
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


@dataclass
class Cracks:
    """Lines of the cracks of a run up to a time, and their modes."""

    lines: np.ndarray  # (cracks, 2 ends, 2 coordinates) [m]
    mode: np.ndarray


def read_cracks(run, time=np.inf):
    """The cracks in cracks.csv that were there at a time [s]; none when the run has no such file."""
    path = run.directory / "cracks.csv"
    if not path.is_file():
        return Cracks(np.zeros((0, 2, 2)), np.array([]))
    with path.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["time_s"]) <= time * (1 + 1e-9)]
    centre = np.array([[float(row["x_m"]), float(row["y_m"])] for row in rows]).reshape(-1, 2)
    angle = np.radians([float(row["angle_deg"]) for row in rows])
    half = 0.5 * np.array([float(row["length_m"]) for row in rows])
    along = (half * np.array([np.cos(angle), np.sin(angle)])).T.reshape(-1, 2)
    return Cracks(np.stack([centre - along, centre + along], axis=1), np.array([row["mode"] for row in rows]))


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
    """Ends of the colours: all values but the largest few; and whether there are some beyond"""
    values = np.concatenate([panel.values(quantity) for panel in panels])
    least = 0.0 if quantity.startswith("shear") else float(values.min())
    most = float(np.percentile(values, 100 - QUANTITIES[quantity][1]))
    return least, most if most > least else least + 1.0, bool(values.max() > most)


def draw_fractures(axes, lines, values, quantity, least, most):
    share = np.clip((values - least) / (most - least), 0, 1)
    order = np.argsort(share)  # large values last, so that they are not covered
    axes.add_collection(LineCollection(lines, color=FAINT, linewidth=THIN))
    drawn = LineCollection(
        lines[order],
        array=values[order],
        cmap=QUANTITIES[quantity][0],
        linewidth=(THIN + (THICK - THIN) * share)[order],
        capstyle="round",
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
        least, most, beyond = common_limits(panels, quantity)
        for axes, panel in zip(row, panels, strict=True):
            values, lines = panel.values(quantity), panel.lines()
            drawn = draw_fractures(axes, lines, values, quantity, least, most)
            cracks = draw_cracks(axes, panel.run, panel.run.fields.times[panel.step])
            frame(axes, panel)
            axes.set_title(f"({chr(letter)}) {panel.label}", loc="left")
            letter += 1
            length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
            mean = float(np.average(values, weights=length))
            table.append([panel.label, quantity, mean, float(values.max()), cracks])
        bar = figure.colorbar(drawn, ax=row, shrink=0.9, extend="max" if beyond else "neither", pad=0.01)
        bar.set_label(style.axis_label(quantity))
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
