"""Grids of triangles with fractures along grid lines, turned by any angle: meshes for tests of flow.

    grid = Grid(width=1.0, height=0.5, columns=8, rows=4)
    grid.fracture("fractures", (0.0, 0.25), (1.0, 0.25))
    grid.write(path)

Sides are the physical curves left, right, bottom and top; the corners are the points corner_sw and corner_se.
"""

import csv
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

LINE, TRIANGLE, POINT = 1, 2, 15


class Grid:
    """A rectangle of triangles from the origin on, two for each cell."""

    def __init__(self, width, height, columns, rows, rock=True):
        self.size = np.array([width, height])
        self.cells = np.array([columns, rows])
        self.columns, self.rows = np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1)
        self.rock = rock
        self.zone = {}  # name: function of the middle of a cell, true in the zone
        self.lines = []  # group and nodes
        self.points = {"corner_sw": self.node(0, 0), "corner_se": self.node(columns, 0)}
        for name, start, end in (
            ("left", (0, 0), (0, height)),
            ("right", (width, 0), (width, height)),
            ("bottom", (0, 0), (width, 0)),
            ("top", (0, height), (width, height)),
        ):
            self.fracture(name, start, end)

    def node(self, i, j):
        """Number of a grid node"""
        return int(j * (self.cells[0] + 1) + i)

    def place(self, columns, rows):
        """Put columns and rows of nodes elsewhere: closer in some parts than in others."""
        self.columns, self.rows = np.asarray(columns, dtype=float), np.asarray(rows, dtype=float)
        self.size = np.array([self.columns[-1], self.rows[-1]])

    def at(self, place):
        """Column and row of a place"""
        found = [np.argmin(abs(lines - x)) for lines, x in zip((self.columns, self.rows), place, strict=True)]
        there = np.array([self.columns[found[0]], self.rows[found[1]]])
        assert np.allclose(there, place, atol=1e-9 * self.size.max()), f"{place} is no node of the grid"
        return np.array(found)

    def fracture(self, group, start, end):
        """Lines from place to place, along the grid"""
        a, b = self.at(start), self.at(end)
        step = np.sign(b - a)
        assert (step == 0).any(), "lines follow the grid"
        while (a != b).any():
            self.lines.append((group, self.node(*a), self.node(*(a + step))))
            a = a + step

    def part_of_side(self, group, start, end):
        """Lines of a side from place to place, away from its corner of origin, to a group of their own"""
        whole, self.lines = self.lines, []
        self.fracture(group, start, end)
        taken = {line[1:] for line in self.lines}
        self.lines = [line for line in whole if line[1:] not in taken] + self.lines

    def point(self, name, place):
        """A physical point"""
        self.points[name] = self.node(*self.at(place))

    def write(self, path, angle=0.0, shift=(0.0, 0.0)):
        """Write the mesh (gmsh 2.2), turned by an angle [degrees] about the origin and moved."""
        columns, rows = self.cells
        x, y = np.meshgrid(self.columns, self.rows)
        turn = np.radians(angle)
        u = np.cos(turn) * x - np.sin(turn) * y + shift[0]
        v = np.sin(turn) * x + np.cos(turn) * y + shift[1]
        elements, groups = [], {}

        def tag(dimension, name):
            return groups.setdefault((dimension, name), len(groups) + 1)

        for name, node in self.points.items():
            elements.append((POINT, tag(0, name), (node,)))
        for name, a, b in self.lines:
            elements.append((LINE, tag(1, name), (a, b)))
        for j in range(rows if self.rock else 0):
            for i in range(columns):
                middle = (
                    0.5 * (self.columns[i] + self.columns[i + 1]),
                    0.5 * (self.rows[j] + self.rows[j + 1]),
                )
                zone = next((name for name, inside in self.zone.items() if inside(*middle)), "rock")
                a, b, c, d = (
                    self.node(i, j),
                    self.node(i + 1, j),
                    self.node(i + 1, j + 1),
                    self.node(i, j + 1),
                )
                # Diagonals alternate, so that neither direction is preferred
                pair = [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
                elements += [(TRIANGLE, tag(2, zone), nodes) for nodes in pair]
        text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
        text += [f'{dimension} {number} "{name}"' for (dimension, name), number in groups.items()]
        text += ["$EndPhysicalNames", "$Nodes", str(u.size)]
        places = zip(u.ravel().tolist(), v.ravel().tolist(), strict=True)
        text += [f"{n} {a:.17g} {b:.17g} 0" for n, (a, b) in enumerate(places, start=1)]
        text += ["$EndNodes", "$Elements", str(len(elements))]
        for n, (kind, number, nodes) in enumerate(elements, start=1):
            text.append(f"{n} {kind} 2 {number} {number} " + " ".join(str(node + 1) for node in nodes))
        Path(path).write_text("\n".join([*text, "$EndElements", ""]), encoding="utf-8")


def run(femdem, folder, deck, *options, timeout=120):
    """Run a deck in a folder; the finished process."""
    (folder / "deck.nml").write_text(deck, encoding="utf-8")
    command = [str(femdem), *options, "deck.nml"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=timeout, check=False)


def snapshots(femdem, folder, deck, timeout=120):
    """Run a deck; places of the nodes of its results, times, and the fields of each snapshot by name."""
    done = run(femdem, folder, deck, timeout=timeout)
    assert done.returncode == 0, done.stderr
    with h5py.File(folder / "results" / "fields.h5") as file:
        steps = sorted(name for name in file if name.startswith("step_"))
        times = np.array([file[step].attrs["time_s"] for step in steps])
        fields = [{name: file[step][name][:] for name in file[step]} for step in steps]
        return file["mesh/coordinates"][:], times, fields


def close(value, relative):
    """Relative alone: permeabilities are far below pytest's absolute tolerance"""
    return pytest.approx(value, rel=relative, abs=0.0)


def table(path):
    """Columns of a CSV table as arrays."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
