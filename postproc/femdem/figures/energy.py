"""The energy balance of a run: work of the loads, where it went, and what is missing.

femdem-plot energy results --out energy
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style

PARTS = {
    "external_J": ("work of the loads", "#000000"),
    "strain_J": ("strain", style.PALETTE[0]),
    "contact_J": ("joints and contact", style.PALETTE[2]),
    "friction_J": ("friction", style.PALETTE[1]),
    "damping_J": ("damping", style.PALETTE[3]),
    "kinetic_J": ("kinetic", style.PALETTE[4]),
    "fracture_J": ("cracks", style.PALETTE[5]),
    "absorbed_J": ("waves that left", "#888888"),
}
#: Columns that are drawn only where something is in them
FEW = ("fracture_J", "absorbed_J")


def main(words=None):
    arguments = style.parser(__name__, __doc__, several=False)
    arguments.add_argument("--x", default="time_s", help="column on the horizontal axis (default: time_s)")
    arguments = arguments.parse_args(words)
    run = style.Results(arguments.results)
    history = run.history
    x = history[arguments.x]

    figure, (top, bottom) = plt.subplots(
        2,
        1,
        sharex=True,
        gridspec_kw={"height_ratios": [3, 1]},
        figsize=(style.WIDTH_MM * style.MM, 1.2 * style.HEIGHT_MM * style.MM),
    )
    # Few runs have cracks or sides that absorb
    parts = {
        name: part
        for name, part in PARTS.items()
        if name not in FEW or (name in history.columns and np.any(history[name]))
    }
    for name, (label, colour) in parts.items():
        top.plot(x, history[name], color=colour, label=label)
    top.set_ylabel("Energy [J]")
    top.legend(ncol=2)
    largest = max(float(np.max(np.abs(history[name]))) for name in parts)
    residual = 100 * history["residual_J"] / (largest if largest > 0 else 1.0)
    bottom.plot(x, residual, color="#000000", linewidth=1.0)
    bottom.axhline(0, color="#555555", linewidth=0.7)
    bottom.set_ylabel("Missing\n[% of largest]")
    bottom.set_xlabel(style.axis_label(arguments.x))
    figure.align_ylabels()
    worst = float(residual[np.argmax(np.abs(residual))])
    print(f"largest energy {largest:.6g} J, worst residual {worst:.3g} % of it")
    style.save(figure, arguments.out, [run], "energy")
