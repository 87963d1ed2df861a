"""Numbers of a fracture network from its traces as they are, and the network as a mesh of lines without rock.

    femdem-numbers two_sets.csv --window 0 0 2 2
    femdem-numbers traces.csv --csv numbers.csv --figure ternary.png --lines network.msh

Nodes: I (tips), Y (abutments), X (crossings), those of five and more branches, those where traces leave the window.
Branches are the pieces between nodes. P20 is the number of traces and P21 their length for each square metre. With N_I
tips and so on, a branch has (N_Y 3 + N_X 4)/N_B connected ends (0 to 2) and a trace 2 (N_Y + N_X)/N_L connections,
N_L = (N_I + N_Y)/2 (Sanderson and Nixon 2015, J Struct Geol 72:55). Nodes on the boundary count in neither.

The mesh of lines (gmsh 2.2) has the physical curve 'fractures' and the window's sides 'left', 'right', 'bottom' and 'top'.
"""

import argparse
import csv
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from femdem.network.cleaning import Census, checked_window
from femdem.network.planar_graph import BOTTOM, COINCIDENT, LEFT, RIGHT, TOP, graph_of, knit
from femdem.network.traces import TraceError, clip, read_traces

BAD_INPUT, FAILED = 2, 1
CURVES = {"left": LEFT, "right": RIGHT, "bottom": BOTTOM, "top": TOP}
FRACTURES = "fractures"


@dataclass
class NetworkNumbers:
    """What a network is made of."""

    census: Census
    window: tuple  # x0, y0, x1, y1 [m]

    @property
    def area(self):
        """Of the window [m2]"""
        x0, y0, x1, y1 = self.window
        return (x1 - x0) * (y1 - y0)

    @property
    def p20(self):
        """Traces for each square metre [1/m2]"""
        return self.census.traces / self.area

    @property
    def p21(self):
        """Length of traces for each square metre [1/m]"""
        return self.census.length / self.area

    @property
    def connections_per_branch(self):
        """Ends of a branch that are connected, in the mean (0 to 2)"""
        census = self.census
        ends = census.tips + 3 * census.abutments + 4 * census.crossings
        return 2 * (3 * census.abutments + 4 * census.crossings) / ends if ends else 0.0

    @property
    def connections_per_trace(self):
        """Connections of a trace with others, in the mean"""
        census = self.census
        lines = (census.tips + census.abutments) / 2
        return 2 * (census.abutments + census.crossings) / lines if lines else 0.0

    def rows(self):
        """Name and value of all numbers."""
        census = self.census
        return {
            "traces": census.traces,
            "branches": census.branches,
            "length_m": census.length,
            "area_m2": self.area,
            "P20_1_m2": self.p20,
            "P21_1_m": self.p21,
            "nodes_I": census.tips,
            "nodes_Y": census.abutments,
            "nodes_X": census.crossings,
            "nodes_of_5_and_more": census.more,
            "nodes_on_boundary": census.boundary,
            "connections_per_branch": self.connections_per_branch,
            "connections_per_trace": self.connections_per_trace,
        }


def exact_graph(traces, window=None):
    """The planar graph of traces as they are (nodes nearer than 1e-9 of the window are one), and their length [m]."""
    window = checked_window(window or traces.extent)
    clipped = clip(traces, window)
    if len(clipped.segment) == 0:
        raise TraceError("no trace lies in the window (%g, %g) to (%g, %g) m" % tuple(window))  # noqa: UP031
    size = max(window[2] - window[0], window[3] - window[1])
    return knit(graph_of(clipped, window), COINCIDENT * size, Counter()), clipped.length


def numbers_of(graph, length=None):
    """The numbers of a planar graph in its window; length of its traces [m], if it is to be counted before nodes were joined."""
    census = Census.of(graph)
    if length is not None:
        census.length = length
    return NetworkNumbers(census, tuple(graph.window))


def write_numbers(path, columns):
    """A CSV table of several networks: {name: NetworkNumbers}."""
    with Path(path).open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["quantity", *columns])
        rows = [numbers.rows() for numbers in columns.values()]
        for name in rows[0]:
            table.writerow([name, *(f"{row[name]:.10g}" for row in rows)])


def write_line_mesh(path, graph):
    """The graph as a mesh of lines without triangles (gmsh 2.2, text)."""
    names = [FRACTURES, *CURVES]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
    lines += [f'1 {tag} "{name}"' for tag, name in enumerate(names, start=1)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(graph.xy))]
    lines += [f"{n} {x:.17g} {y:.17g} 0" for n, (x, y) in enumerate(graph.xy.tolist(), start=1)]
    lines += ["$EndNodes", "$Elements", str(len(graph.edge))]
    tags = {trace: names.index(name) + 1 for name, trace in CURVES.items()}
    for e, (trace, (a, b)) in enumerate(zip(graph.trace.tolist(), graph.edge.tolist(), strict=True), start=1):
        tag = 1 if trace >= 0 else tags[trace]
        lines.append(f"{e} 1 2 {tag} {tag} {a + 1} {b + 1}")
    lines.append("$EndElements")
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def draw_ternary(path, columns):
    """Shares of I, Y and X nodes of networks {name: NetworkNumbers} in a triangle, with lines of equal connection."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    height = np.sqrt(3) / 2
    corner = {"I": (0.5, height), "Y": (0.0, 0.0), "X": (1.0, 0.0)}

    def place(tips, abutments, crossings):
        total = tips + abutments + crossings
        share = np.array([tips, abutments, crossings]) / total
        return share @ np.array([corner["I"], corner["Y"], corner["X"]])

    figure, axes = plt.subplots(figsize=(4.2, 3.9))
    outline = np.array([corner["I"], corner["Y"], corner["X"], corner["I"]])
    axes.plot(*outline.T, color="black", linewidth=1)
    for level in (1.0, 1.2, 1.4, 1.6, 1.8):
        # Connections per branch c: 2 (3 Y + 4 X) = c (I + 3 Y + 4 X), a straight line from the side I-Y to the side I-X
        ends = [
            place(2 * 3 - 3 * level, level, 0.0),
            place(2 * 4 - 4 * level, 0.0, level),
        ]
        axes.plot(*np.array(ends).T, color="0.75", linewidth=0.8)
        axes.annotate(
            f"{level:g}", ends[1], xytext=(4, 0), textcoords="offset points", fontsize=7, color="0.4"
        )
    for name, (x, y) in corner.items():
        offset = {"I": (0, 5), "Y": (-9, -4), "X": (9, -4)}[name]
        axes.annotate(name, (x, y), xytext=offset, textcoords="offset points", ha="center", weight="bold")
    for name, numbers in columns.items():
        census = numbers.census
        if census.tips + census.abutments + census.crossings == 0:
            continue
        axes.plot(*place(census.tips, census.abutments, census.crossings), "o", markersize=6, label=name)
    axes.legend(loc="upper left", fontsize=8, frameon=False)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title("Shares of nodes; grey: connections per branch", fontsize=9)
    figure.savefig(path, dpi=200, bbox_inches="tight")
    plt.close(figure)


def arguments_of(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="femdem-numbers", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("traces", nargs="+", help="files of traces (CSV, GeoJSON, GeoPackage, shapefile)")
    parser.add_argument(
        "--window",
        nargs=4,
        type=float,
        metavar=("X0", "Y0", "X1", "Y1"),
        help="rectangle to cut out (m; default: extent of the traces)",
    )
    parser.add_argument("--csv", help="table to write")
    parser.add_argument("--figure", help="ternary plot to draw")
    parser.add_argument("--lines", help="mesh of lines to write (gmsh 2.2; one file of traces)")
    return parser.parse_args(words)


def main(words=None):
    arguments = arguments_of(words)
    try:
        if arguments.lines and len(arguments.traces) > 1:
            raise TraceError("--lines takes one file of traces")
        graphs = {
            Path(path).stem: exact_graph(read_traces(path), arguments.window) for path in arguments.traces
        }
        columns = {name: numbers_of(*graph) for name, graph in graphs.items()}
        for name, numbers in columns.items():
            print(name)
            for quantity, value in numbers.rows().items():
                print(f"  {quantity:24} {value:.8g}")
        if arguments.csv:
            write_numbers(arguments.csv, columns)
        if arguments.figure:
            draw_ternary(arguments.figure, columns)
        if arguments.lines:
            write_line_mesh(arguments.lines, next(iter(graphs.values()))[0])
    except (TraceError, OSError) as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        sys.exit(BAD_INPUT)


if __name__ == "__main__":
    main()
