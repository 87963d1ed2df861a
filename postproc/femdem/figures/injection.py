"""A crack that fluid drives: aperture and pressure along it at every output, its length and the largest pressure in time.

femdem-plot injection results
femdem-plot injection results --confined 20e6 --from 0 0

Distances are from the place of the largest pressure at the end, or --from. Pressures are shown beyond --confined, the stress that
closes the crack. Dashed: how far the fluid has come, where it lags behind the tip. Prints length, aperture and pressure at the end.
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style

MEGA = 1e6
FULL = 0.99  # saturation from which on a node counts as full


def read_steps(run):
    """Times [s], and of each output what conducts: coordinates, places of the elements, apertures [mm], pressures, saturations"""
    fields = run.fields
    with fields.open() as file:
        names = sorted(name for name in file if name.startswith("step_"))
        times = [float(file[name].attrs["time_s"]) for name in names]
    steps = []
    for step in range(len(times)):
        known = fields.names(step)
        if "fluid_pressure" not in known:
            raise style.ResultsError(
                f"{run.directory}: no fluid_pressure; the deck must have a &flow and a &flow_boundary"
            )
        mesh = fields.mesh(step)
        conducts = fields.read("hydraulic_aperture_mm", step) > 0
        steps.append(
            {
                "x": mesh.coordinates,
                "middle": mesh.joint_lines[conducts].mean(axis=1),
                "nodes": np.unique(mesh.joints[conducts][:, :2]),
                "length": np.linalg.norm(np.diff(mesh.joint_lines[conducts], axis=1)[:, 0], axis=1),
                "aperture": fields.read("aperture_mm", step)[conducts],
                "pressure": fields.read("fluid_pressure", step),
                "saturation": fields.read("fluid_saturation", step) if "fluid_saturation" in known else None,
            }
        )
    return np.array(times), steps


def along(step, start):
    """Distances of elements and nodes from a place, in order, with what they have"""
    elements = np.linalg.norm(step["middle"] - start, axis=1)
    nodes = np.linalg.norm(step["x"][step["nodes"]] - start, axis=1)
    order, node_order = np.argsort(elements), np.argsort(nodes)
    found = step["nodes"][node_order]
    return elements[order], step["aperture"][order], nodes[node_order], found


def main(words=None):
    arguments = style.parser(__name__, __doc__, several=False)
    arguments.add_argument("--confined", type=float, default=0.0, help="stress that closes the crack [Pa]")
    arguments.add_argument(
        "--from", dest="start", type=float, nargs=2, metavar=("X", "Y"), help="place of the well [m]"
    )
    arguments = arguments.parse_args(words)
    run = style.Results(arguments.results)
    times, steps = read_steps(run)
    last = steps[-1]
    start = arguments.start
    if start is None:
        start = last["x"][last["nodes"][np.nanargmax(last["pressure"][last["nodes"]])]]
    figure, (apertures, pressures, growth) = plt.subplots(
        1, 3, figsize=(2.2 * style.WIDTH_MM * style.MM, style.HEIGHT_MM * style.MM), constrained_layout=True
    )
    colours = plt.get_cmap(style.SEQUENTIAL)(np.linspace(0.15, 0.9, len(times)))
    lengths, fronts, largest = [], [], []
    for step, colour in zip(steps, colours, strict=True):
        distance, aperture, node_distance, nodes = along(step, np.array(start))
        pressure = (step["pressure"][nodes] - arguments.confined) / MEGA
        apertures.plot(distance, aperture, color=colour)
        pressures.plot(node_distance, pressure, color=colour)
        lengths.append(node_distance.max(initial=0.0))
        largest.append(np.nanmax(pressure) if len(nodes) else np.nan)
        full = np.ones(len(nodes), bool) if step["saturation"] is None else step["saturation"][nodes] > FULL
        fronts.append(node_distance[full].max(initial=0.0))
    bar = figure.colorbar(
        plt.cm.ScalarMappable(plt.Normalize(times[0], times[-1]), style.SEQUENTIAL), ax=pressures
    )
    bar.set_label("Time [s]")
    growth.plot(times, lengths, "o-", color=style.PALETTE[0], markersize=3, label="length")
    if last["saturation"] is not None:
        growth.plot(times, fronts, "--", color=style.PALETTE[0], label="fluid")
    growth.legend(loc="lower right")
    beside = growth.twinx()
    beside.plot(times, largest, "s-", color=style.PALETTE[1], markersize=3)
    beside.grid(visible=False)
    net = "Net pressure [MPa]" if arguments.confined else "Pressure [MPa]"
    beside.set_ylabel(f"Largest {net[0].lower()}{net[1:]}", color=style.PALETTE[1])
    for axes, name in ((apertures, "Aperture [mm]"), (pressures, net)):
        axes.set_xlabel("From the well [m]")
        axes.set_ylabel(name)
    growth.set_xlabel("Time [s]")
    growth.set_ylabel("Length [m]", color=style.PALETTE[0])
    print(
        f"{run.label}: at {times[-1]:.4g} s {lengths[-1]:.4g} m long, the fluid at {fronts[-1]:.4g} m, "
        f"{last['aperture'].max():.4g} mm wide, {largest[-1]:.4g} MPa"
    )
    style.save(figure, arguments.out, [run], "injection")
