"""The mesh of a run with its fractures and groups, and the quality of its triangles.

femdem-plot mesh results --out mesh
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Patch

from femdem.figures import style

FILLS = ["#f1efe8", "#e0e7ee", "#efe3dc", "#e3ece0", "#ece3ee"]
# Edges of the triangles are drawn thinner the more there are
THICK_EDGE, MANY_TRIANGLES = 0.35, 4000


def quality(mesh):
    """4 sqrt(3) area / sum of squared edges (1: equilateral, 0: flat), and the shortest edge [m], of each triangle"""
    corner = mesh.coordinates[mesh.triangles]
    edge = np.roll(corner, -1, axis=1) - corner
    squared = np.sum(edge**2, axis=2)
    area = 0.5 * (edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0])
    return 4 * np.sqrt(3) * area / np.sum(squared, axis=1), np.sqrt(np.min(squared, axis=1))


def main(words=None):
    arguments = style.parser(__name__, __doc__, several=False)
    arguments.add_argument(
        "--step", type=int, default=-1, help="snapshot whose mesh is drawn (default: last)"
    )
    arguments.add_argument("--no-edges", action="store_true", help="leave out the edges of the triangles")
    arguments = arguments.parse_args(words)
    run = style.Results(arguments.results)
    mesh = run.fields.mesh(arguments.step)
    value, shortest = quality(mesh)

    figure, (axes, side) = plt.subplots(
        1,
        2,
        gridspec_kw={"width_ratios": [2.2, 1]},
        figsize=(1.3 * style.WIDTH_MM * style.MM, style.HEIGHT_MM * style.MM),
        constrained_layout=True,
    )
    legend = []
    width = 0 if arguments.no_edges else THICK_EDGE * min(1.0, np.sqrt(MANY_TRIANGLES / len(mesh.triangles)))
    for i, group in enumerate(np.unique(mesh.triangle_group)):
        chosen = mesh.triangles[mesh.triangle_group == group]
        colour = FILLS[i % len(FILLS)]
        axes.add_collection(
            PolyCollection(mesh.coordinates[chosen], facecolor=colour, edgecolor="#9a9a9a", linewidth=width)
        )
        name = mesh.group_name[group] if group >= 0 else "no group"
        legend.append(Patch(facecolor=colour, edgecolor="#9a9a9a", label=name))
    for i, group in enumerate(np.unique(mesh.joint_group)):
        chosen = mesh.joint_group == group
        lines = LineCollection(
            mesh.joint_lines[chosen], color=style.PALETTE[i % len(style.PALETTE)], linewidth=1.3
        )
        axes.add_collection(lines)
        name = mesh.group_name[group] if group >= 0 else "no group"
        legend.append(plt.Line2D([], [], color=style.PALETTE[i % len(style.PALETTE)], label=name))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.02)
    axes.grid(False)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(handles=legend, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=4)

    side.hist(value, bins=np.linspace(0, 1, 26), color=style.PALETTE[0])
    side.set_xlabel("Quality (1: equilateral)")
    side.set_ylabel("Triangles")
    side.set_xlim(0, 1)
    print(f"{len(mesh.triangles)} triangles, {len(mesh.coordinates)} nodes, {len(mesh.joints)} joints")
    print(
        f"quality: least {value.min():.3f}, mean {value.mean():.3f}; shortest edge {1000 * shortest.min():.4g} mm"
    )
    style.save(figure, arguments.out, [run], "mesh")
