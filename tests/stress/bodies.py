"""Meshes of the stress tests: a stack of layers, its triangles in rows and columns, with joints between layers where asked for;
and runs of the program on them."""

import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(TOP / "postproc"))
from femdem.results import Results  # noqa: E402

LINE, TRIANGLE = 1, 2


class Stack:
    """Layers from below: (name, height, rows of squares); joints between layers whose numbers are in `joints`.

    Curves: 'bottom', 'top', 'sides', 'joint'; surfaces: the names of the layers.
    """

    def __init__(self, layers, width=1.0, columns=4, joints=()):
        self.groups = {"bottom": (1, 1), "top": (1, 2), "sides": (1, 3)}
        self.nodes, self.elements = [], []
        rows = [0.0]
        owner = []
        borders = {}
        for number, (name, height, count) in enumerate(layers):
            self.groups.setdefault(name, (2, 10 + number))
            rows += [rows[-1] + height * (i + 1) / count for i in range(count)]
            owner += [self.groups[name][1]] * count
            borders[number] = len(rows) - 1
        self.columns, self.rows = columns, len(rows) - 1
        self.nodes = [(width * i / columns, y) for y in rows for i in range(columns + 1)]
        for j in range(self.rows):
            for i in range(columns):
                self._square(i, j, owner[j])
            self._line(3, (0, j), (0, j + 1))
            self._line(3, (columns, j), (columns, j + 1))
        for i in range(columns):
            self._line(1, (i, 0), (i + 1, 0))
            self._line(2, (i, self.rows), (i + 1, self.rows))
            for joint in joints:
                self.groups["joint"] = (1, 4)
                self._line(4, (i, borders[joint]), (i + 1, borders[joint]))
        self.fixed_rows = {0, self.rows, *(borders[joint] for joint in joints)}

    def at(self, i, j):
        return j * (self.columns + 1) + i + 1

    def _line(self, group, a, b):
        self.elements.append((LINE, group, (self.at(*a), self.at(*b))))

    def _square(self, i, j, group):
        a, b, c, d = self.at(i, j), self.at(i + 1, j), self.at(i + 1, j + 1), self.at(i, j + 1)
        cut = ((a, b, c), (a, c, d)) if (i + j) % 2 == 0 else ((a, b, d), (b, c, d))
        self.elements += [(TRIANGLE, group, nodes) for nodes in cut]

    def move(self, change):
        """Every node to change(x, y); a change that turns triangles over turns their order too"""
        old = self.nodes
        self.nodes = [change(x, y) for x, y in old]
        (ax, ay), (bx, by), (cx, cy) = (change(*point) for point in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
        if (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) < 0:
            self.elements = [
                (kind, group, nodes[::-1] if kind == TRIANGLE else nodes)
                for kind, group, nodes in self.elements
            ]
        return self

    def jitter(self, part, seed):
        """Inner nodes anywhere within a part of the spacing, those of borders along these"""
        chance = random.Random(seed)
        dx = abs(self.nodes[1][0] - self.nodes[0][0])
        dy = abs(self.nodes[self.columns + 1][1] - self.nodes[0][1])
        for j in range(self.rows + 1):
            for i in range(1, self.columns):
                x, y = self.nodes[self.at(i, j) - 1]
                x += part * dx * chance.uniform(-1, 1)
                if j not in self.fixed_rows:
                    y += part * dy * chance.uniform(-1, 1)
                self.nodes[self.at(i, j) - 1] = (x, y)
        return self

    def shake(self, part, seed):
        """Nodes on no curve anywhere within a part of the spacing"""
        chance = random.Random(seed)
        dx = abs(self.nodes[1][0] - self.nodes[0][0])
        dy = abs(self.nodes[self.columns + 1][1] - self.nodes[0][1])
        on_curve = {n for kind, _, nodes in self.elements if kind == LINE for n in nodes}
        self.nodes = [
            (x, y)
            if number in on_curve
            else (x + part * dx * chance.uniform(-1, 1), y + part * dy * chance.uniform(-1, 1))
            for number, (x, y) in enumerate(self.nodes, start=1)
        ]
        return self

    def curve(self, name, tag, places):
        """A curve of a group along places (column, row) that follow each other"""
        self.groups[name] = (1, tag)
        for a, b in zip(places[:-1], places[1:], strict=True):
            self._line(tag, a, b)
        return self

    def add(self, other, tags):
        """Another body beside this one: its surfaces, with other numbers of their groups"""
        offset = len(self.nodes)
        new = {other.groups[name][1]: tag for name, tag in tags.items()}
        self.groups.update({name: (2, tag) for name, tag in tags.items()})
        self.nodes += other.nodes
        self.elements += [
            (kind, new[group], tuple(n + offset for n in nodes))
            for kind, group, nodes in other.elements
            if kind == TRIANGLE
        ]
        return self

    def renumber(self, seed):
        """Nodes and elements in another order"""
        chance = random.Random(seed)
        order = list(range(len(self.nodes)))
        chance.shuffle(order)
        new = {old + 1: place + 1 for place, old in enumerate(order)}
        self.nodes = [self.nodes[old] for old in order]
        self.elements = [(k, g, tuple(new[n] for n in nodes)) for k, g, nodes in self.elements]
        chance.shuffle(self.elements)
        return self

    def regroup(self):
        """Groups with other numbers, in another order"""
        old = {tag: name for name, (_, tag) in self.groups.items()}
        names = sorted(self.groups, reverse=True)
        self.groups = {name: (self.groups[name][0], 50 + i) for i, name in enumerate(names)}
        self.elements = [(k, self.groups[old[g]][1], nodes) for k, g, nodes in self.elements]
        return self

    def text(self):
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(self.groups))]
        lines += [f'{dimension} {tag} "{name}"' for name, (dimension, tag) in self.groups.items()]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.nodes))]
        lines += [f"{n} {x!r} {y!r} 0" for n, (x, y) in enumerate(self.nodes, start=1)]
        lines += ["$EndNodes", "$Elements", str(len(self.elements))]
        for n, (kind, group, nodes) in enumerate(self.elements, start=1):
            lines.append(f"{n} {kind} 2 {group} {group} " + " ".join(map(str, nodes)))
        return "\n".join([*lines, "$EndElements", ""])


def shaken(text, part, seed):
    """A mesh file (gmsh 4.1) with its nodes inside surfaces anywhere within a part of the shortest edge that ends there"""
    chance = random.Random(seed)
    lines = text.split("\n")

    def blocks(name):
        """Heads of the blocks of a section, with the number of the line behind each"""
        at = lines.index(f"${name}") + 2
        while not lines[at].startswith("$"):
            head = [int(word) for word in lines[at].split()]
            yield head, at + 1
            at += 1 + head[3] * (2 if name == "Nodes" else 1)

    place, line_of, inside = {}, {}, []
    for (dimension, _, _, count), at in blocks("Nodes"):
        for tag, number in zip(lines[at : at + count], range(at + count, at + 2 * count), strict=True):
            place[tag.strip()] = [float(word) for word in lines[number].split()]
            line_of[tag.strip()] = number
            if dimension == 2:
                inside.append(tag.strip())
    shortest = dict.fromkeys(place, float("inf"))
    for (dimension, _, _, count), at in blocks("Elements"):
        for line in lines[at : at + count] if dimension == 2 else ():
            nodes = line.split()[1:]
            for a, b in zip(nodes, [*nodes[1:], nodes[0]], strict=True):
                length = math.dist(place[a], place[b])
                shortest[a], shortest[b] = min(shortest[a], length), min(shortest[b], length)
    for tag in inside:
        x, y, z = place[tag]
        reach = part * shortest[tag]
        lines[line_of[tag]] = (
            f"{x + reach * chance.uniform(-1, 1)!r} {y + reach * chance.uniform(-1, 1)!r} {z!r}"
        )
    return "\n".join(lines)


class Run:
    """The program on a mesh and a deck; its status, what it said, and its results while the folder lasts"""

    def __init__(self, mesh, deck, timeout=300, options=()):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = folder = Path(self._folder.name)
        (folder / "mesh.msh").write_text(mesh if isinstance(mesh, str) else mesh.text())
        (folder / "deck.nml").write_text(deck)
        program = os.environ.get("FEMDEM", TOP / "build" / "femdem")
        done = subprocess.run(
            [program, *options, "deck.nml"],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        self.status, self.said = done.returncode, done.stdout + done.stderr
        self.results = Results(folder / "results") if (folder / "results" / "history.csv").exists() else None

    @property
    def history(self):
        return self.results.history

    def field(self, name, step=-1):
        return self.results.fields.read(name, step)

    def top(self, step=-1):
        """Mean displacement of the nodes of the highest row before any motion"""
        x = self.results.fields.mesh().coordinates
        return self.field("displacement", step)[
            x[:, 1] > x[:, 1].max() - 1e-6 * (x[:, 1].max() - x[:, 1].min())
        ].mean(axis=0)

    def needed(self):
        """The run itself, when it ended well"""
        if self.status != 0:
            raise RuntimeError(f"status {self.status}: {self.said.splitlines()[-1] if self.said else ''}")
        return self
