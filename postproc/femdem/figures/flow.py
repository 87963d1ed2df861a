"""Pressure of the fluid (colour) and flow (width of the lines) in a network, one map a run.

femdem-plot flow results                 the last snapshot of a run with &flow and &flow_boundary
femdem-plot flow results --step 0        another snapshot
femdem-plot flow phase_1 phase_2b        side by side, with common colours and widths

Rock that conducts is coloured too. Fractures without pressure, which nothing leads to, are grey. Prints the total of the
inflows, and the share of all flow times length that the lines with the largest tenth of the flows carry.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from femdem.figures import style

THIN, THICK = 0.35, 5.0  # widths of lines in points, from nothing to the largest flow
FAINT = "#b0b0b0"
PANEL_MM = 72
KILO = 1e3


def read_map(run, step):
    """Lines, flow along each, pressure at their ends, and the rock with its pressure."""
    fields = run.fields
    known = fields.names(step)
    if "fluid_pressure" not in known:
        raise style.ResultsError(
            f"{run.directory}: no fluid_pressure; the deck must have a &flow and a &flow_boundary"
        )
    mesh = fields.mesh(step)
    pressure = fields.read("fluid_pressure", step)
    conducts = fields.read("hydraulic_aperture_mm", step) > 0
    return {
        "x": mesh.coordinates,
        "triangles": mesh.triangles,
        "lines": mesh.joint_lines[conducts],
        "along": np.abs(fields.read("flow_along", step))[conducts],
        "ends": pressure[mesh.joints[conducts][:, :2]],
        "pressure": pressure,
        "rock": "darcy_flux" in known,
        "flux": fields.read("darcy_flux", step) if "darcy_flux" in known else None,
    }


def draw(axes, found, span, most):
    """One map; what the colours belong to."""
    norm = plt.Normalize(*span)
    if found["rock"]:
        # Triangles with a corner that has no pressure do not conduct
        whole = np.isfinite(found["pressure"][found["triangles"]]).all(axis=1)
        axes.tripcolor(
            *found["x"].T,
            np.nan_to_num(found["pressure"] / KILO),
            triangles=found["triangles"][whole],
            shading="gouraud",
            cmap=style.SEQUENTIAL,
            norm=norm,
            alpha=0.6,
            rasterized=True,
        )
    reached = np.isfinite(found["ends"]).all(axis=1)
    axes.add_collection(LineCollection(found["lines"][~reached], colors=FAINT, linewidths=0.8))
    order = np.flatnonzero(reached)[np.argsort(found["along"][reached])]
    width = THIN + (THICK - THIN) * found["along"][order] / (most if most > 0 else 1.0)
    drawn = LineCollection(
        found["lines"][order],
        array=found["ends"][order].mean(axis=1) / KILO,
        cmap=style.SEQUENTIAL,
        norm=norm,
        linewidths=width,
        capstyle="round",
    )
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    places = found["x"] if len(found["triangles"]) else found["lines"].reshape(-1, 2)
    low, high = places.min(axis=0), places.max(axis=0)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [m]")
    return drawn


def tell(label, found):
    """Print how channelled the flow is."""
    length = np.hypot(*(found["lines"][:, 1] - found["lines"][:, 0]).T)
    carried = found["along"] * length
    order = np.argsort(found["along"])[::-1]
    top = order[: max(1, int(np.ceil(0.1 * len(order))))]
    share = carried[top].sum() / carried.sum() if carried.sum() > 0 else float("nan")
    print(f"{label}: largest flow {found['along'].max(initial=0.0):.4g} m2/s; "
          f"a tenth of the lines carries {100 * share:.1f} %")  # fmt: skip


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    arguments.add_argument("--step", type=int, default=-1, help="snapshot, from 0 (default: the last)")
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    maps = [read_map(run, arguments.step) for run in runs]
    pressures = np.concatenate([found["pressure"][np.isfinite(found["pressure"])] for found in maps])
    span = (pressures.min() / KILO, pressures.max() / KILO) if len(pressures) else (0.0, 1.0)
    most = max(found["along"].max(initial=0.0) for found in maps)
    size = ((PANEL_MM * len(maps) + 25) * style.MM, (PANEL_MM + 12) * style.MM)
    figure, panels = plt.subplots(
        1, len(maps), figsize=size, squeeze=False, sharey=True, layout="constrained"
    )
    for axes, found, label in zip(panels[0], maps, labels, strict=True):
        drawn = draw(axes, found, span, most)
        axes.set_title(label if len(label) < 45 else label[:42] + "...")
        tell(label, found)
    panels[0][0].set_ylabel("y [m]")
    figure.colorbar(drawn, ax=panels, label="Pressure of the fluid [kPa]", shrink=0.85)
    widths = [
        plt.Line2D([], [], color="#555555", linewidth=THIN + (THICK - THIN) * part) for part in (0.1, 0.5, 1)
    ]
    names = [f"{part * most:.2g} m²/s" for part in (0.1, 0.5, 1)]
    figure.legend(
        widths, names, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=3, title="Flow along fractures"
    )
    style.save(figure, arguments.out, runs, "flow")
