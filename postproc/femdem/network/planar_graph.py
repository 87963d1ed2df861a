"""Planar graph of a fracture network in a rectangle: nodes, straight edges, and the operations that make it planar.

The sides of the rectangle are edges of the graph like the fractures, so that a fracture near the boundary is treated
like one near another fracture. An edge of the boundary has a negative trace (LEFT to TOP). So have the lines inside it
that the mesh must follow, borders of holes and zones: FIRST_LINE and less. Their ends stay where they are.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

LEFT, RIGHT, BOTTOM, TOP = -1, -2, -3, -4  # traces of the sides
SIDE_NAMES = {LEFT: "left", RIGHT: "right", BOTTOM: "bottom", TOP: "top"}
SIDE_BIT = {LEFT: 1, RIGHT: 2, BOTTOM: 4, TOP: 8}
CORNERS = np.array([5, 6, 10, 9])  # bits of the corners, anticlockwise from the origin
SIDES = 15  # bits of all sides
ON_LINE, FIXED = 16, 32  # bits of nodes on lines that the mesh must follow, and of the ends of these lines
FIRST_LINE = -5  # trace of the first of these lines; the next has -6, and so on
COINCIDENT = 1e-9  # of the window's size: nodes nearer than this are one in traces as they were read
MOST_ROUNDS = 400  # of knitting; a few dozen are usual


class EndlessError(Exception):
    """Changes that undo each other: cleaning with these tolerances does not come to an end."""


class Window(tuple):
    """Rectangle x0, y0, x1, y1 [m], with the lines in it that the mesh must follow.

    line: ends (lines, 2, 2) [m]; lines meet each other and the sides at their ends only. of_hole: which hole each is
    the border of, -1 for borders between rocks. hole: centre and radius of the largest circle in each hole [m].
    """

    def __new__(cls, sides, line=(), of_hole=(), hole=()):
        window = super().__new__(cls, sides)
        window.line = np.array(line, dtype=float).reshape(-1, 2, 2)
        window.of_hole = np.array(of_hole, dtype=int)
        window.hole = list(hole)
        return window


def lines_at(window, xy):
    """On which lines of a window points lie (points, lines)."""
    line = getattr(window, "line", np.zeros((0, 2, 2)))
    start, along = line[:, 0], line[:, 1] - line[:, 0]
    beyond = xy[:, None] - start
    part = np.clip((beyond * along).sum(axis=2) / (along**2).sum(axis=1), 0.0, 1.0)
    off = np.hypot(*np.moveaxis(beyond - part[..., None] * along, 2, 0))
    return off < COINCIDENT * max(window[2] - window[0], window[3] - window[1])


def are_corners(side):
    """Do nodes with these bits stay where they are: corners of the window, ends of lines?"""
    return np.isin(side & SIDES, CORNERS) | (side & FIXED > 0)


@dataclass
class Graph:
    """Nodes and edges. Operations return a new graph."""

    xy: np.ndarray  # places of the nodes (nodes, 2) [m]
    side: np.ndarray  # bits of the sides that each node is on, ON_LINE, FIXED (nodes)
    edge: np.ndarray  # nodes of each edge (edges, 2)
    trace: np.ndarray  # trace of each edge, negative for the boundary (edges)
    window: tuple  # x0, y0, x1, y1 [m]; a Window where there are lines in it

    @property
    def lines_of_nodes(self):
        """On which lines of the window each node is, by its bit and its place (nodes, lines)."""
        found = np.zeros((len(self.xy), len(getattr(self.window, "line", ()))), dtype=bool)
        on_line = self.side & ON_LINE > 0
        if found.shape[1] and on_line.any():
            found[on_line] = lines_at(self.window, self.xy[on_line])
        return found

    @property
    def line_of_edges(self):
        """Line of the window that each edge is a part of, -1 for none (edges)."""
        on = self.lines_of_nodes
        if not on.any():
            return np.full(len(self.edge), -1)
        both = on[self.edge[:, 0]] & on[self.edge[:, 1]]
        return np.where(both.any(axis=1), both.argmax(axis=1), -1)

    @property
    def in_hole(self):
        """Does the middle of each edge lie in a hole? (edges)"""
        middle = self.xy[self.edge].mean(axis=1)
        inside = np.zeros(len(self.edge), dtype=bool)
        for x, y, radius in getattr(self.window, "hole", ()):
            inside |= np.hypot(middle[:, 0] - x, middle[:, 1] - y) < radius * (1 - COINCIDENT)
        return inside

    @property
    def is_fracture(self):
        """Is it an edge of a fracture? (edges)"""
        return self.trace >= 0

    @property
    def degree(self):
        """Number of fracture edges at each node (nodes)."""
        return np.bincount(self.edge[self.is_fracture].ravel(), minlength=len(self.xy))

    @property
    def lengths(self):
        """Length of each edge [m]."""
        return np.hypot(*(self.xy[self.edge[:, 1]] - self.xy[self.edge[:, 0]]).T)

    @property
    def fracture_length(self):
        """Length of all fracture edges together [m]."""
        return float(self.lengths[self.is_fracture].sum())

    @property
    def size(self):
        """Longer side of the window [m]."""
        return max(self.window[2] - self.window[0], self.window[3] - self.window[1])


def graph_of(traces, window):
    """Graph of clipped traces and the window's sides, not yet planar."""
    x0, y0, x1, y1 = window
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    side = CORNERS.copy()
    ends, place = np.unique(traces.segment.reshape(-1, 2), axis=0, return_inverse=True)
    fixed = np.unique(getattr(window, "line", np.zeros((0, 2, 2))).reshape(-1, 2), axis=0)
    for k, corner in enumerate(corners):
        at_corner = (fixed == corner).all(axis=1)
        side[k] |= (ON_LINE | FIXED) * int(at_corner.any())
        fixed = fixed[~at_corner]
    of_fixed = ON_LINE | FIXED | (fixed == [x0, y0]) @ [1, 4] | (fixed == [x1, y1]) @ [2, 8]
    edge = place.reshape(-1, 2) + 4 + len(fixed)
    return Graph(
        np.vstack([corners, fixed, ends]),
        np.concatenate([side, of_fixed, np.zeros(len(ends), dtype=int)]).astype(int),
        np.vstack([[[0, 1], [1, 2], [2, 3], [3, 0]], edge]),
        np.concatenate([[BOTTOM, RIGHT, TOP, LEFT], traces.trace]),
        window if isinstance(window, Window) else tuple(window),
    )


def tidy(graph, counts):
    """Drop edges without length, edges that are there already, edges along the boundary, and unused nodes.

    The boundary is drawn anew, from corner to corner through the nodes where fractures end, and so are the lines in the
    window. A fracture along the border of a zone stays; one along that of a hole, or in the hole, does not.
    """
    side = graph.side[graph.edge]
    along = side[:, 0] & side[:, 1] & SIDES != 0
    if graph.lines_of_nodes.any():
        line = graph.line_of_edges
        along |= (line >= 0) & (graph.window.of_hole[line] >= 0) | graph.in_hole
    along &= graph.is_fracture & (graph.edge[:, 0] != graph.edge[:, 1])
    counts["pieces along the boundary dropped"] += int(along.sum())
    graph = Graph(graph.xy, graph.side, graph.edge[~along], graph.trace[~along], graph.window)
    edge, trace = boundary_drawn(graph)
    keep = edge[:, 0] != edge[:, 1]
    # The boundary first, then traces in order, then lines: the first edge between two nodes stays
    precedence = np.where(trace > FIRST_LINE, trace, np.iinfo(int).max)
    order = np.flatnonzero(keep)[np.argsort(precedence[keep], kind="stable")]
    _, first = np.unique(np.sort(edge[order], axis=1), axis=0, return_index=True)
    doubled = np.ones(len(order), dtype=bool)
    doubled[first] = False
    counts["pieces that lie on others dropped"] += int((doubled & (trace[order] > FIRST_LINE)).sum())
    order = np.sort(order[first])
    edge, trace = edge[order], trace[order]
    used = np.zeros(len(graph.xy), dtype=bool)
    used[edge.ravel()] = True
    number = np.cumsum(used) - 1
    return Graph(graph.xy[used], graph.side[used], number[edge], trace, graph.window)


def boundary_drawn(graph):
    """Edges and their traces, with new edges for the boundary."""
    edge, trace = [graph.edge[graph.is_fracture]], [graph.trace[graph.is_fracture]]
    wanted = (graph.degree > 0) | are_corners(graph.side)
    for which, bit in SIDE_BIT.items():
        nodes = np.flatnonzero(wanted & (graph.side & bit > 0))
        nodes = nodes[np.argsort(graph.xy[nodes, 1 if which in (LEFT, RIGHT) else 0], kind="stable")]
        edge.append(np.stack([nodes[:-1], nodes[1:]], axis=1))
        trace.append(np.full(len(nodes) - 1, which))
    for k, on in enumerate(graph.lines_of_nodes.T):
        start, end = graph.window.line[k]
        nodes = np.flatnonzero(wanted & on)
        nodes = nodes[np.argsort((graph.xy[nodes] - start) @ (end - start), kind="stable")]
        edge.append(np.stack([nodes[:-1], nodes[1:]], axis=1))
        trace.append(np.full(len(nodes) - 1, FIRST_LINE - k))
    return np.vstack(edge), np.concatenate(trace)


def knit(graph, tolerance, counts):
    """Make the graph planar with nothing nearer than the tolerance [m].

    Nodes near each other become one; tips near an edge are moved onto it; edges are led through other nodes near them;
    edges that cross get a node there. Repeated until there is nothing left to do, since each change may bring about
    another.
    """
    graph = tidy(graph, counts)
    for _ in range(MOST_ROUNDS):
        for change in (merge_nodes, split_at_nodes, split_at_crossings):
            graph, changed = change(graph, tolerance, counts)
            if changed:
                graph = tidy(graph, counts)
                break
        else:
            return graph
    raise EndlessError(f"cleaning does not come to an end with the tolerance {tolerance:g} m")


def merge_nodes(graph, tolerance, counts):
    """Join pairs of nodes nearer than the tolerance, the nearest pairs first, each node once."""
    pairs = cKDTree(graph.xy).query_pairs(tolerance, output_type="ndarray")
    if len(pairs) == 0:
        return graph, False
    distance = np.hypot(*(graph.xy[pairs[:, 0]] - graph.xy[pairs[:, 1]]).T)
    xy, side = graph.xy.copy(), graph.side.copy()
    rank = node_ranks(graph)
    becomes = np.arange(len(xy))
    taken = np.zeros(len(xy), dtype=bool)
    on = graph.lines_of_nodes
    for i, j in pairs[np.lexsort((pairs[:, 1], pairs[:, 0], distance))]:
        if taken[i] or taken[j] or not may_join(side, on, i, j):
            continue
        taken[i] = taken[j] = True
        both = side[i] | side[j]
        place = (
            (xy[i] + xy[j]) / 2
            if rank[i] == rank[j] and rank[i] < 4
            else xy[i]
            if rank[i] > rank[j]
            else xy[j]
        )
        xy[i], side[i], becomes[j] = on_sides(place, both, graph.window), both, i
        counts["nodes near each other joined"] += 1
    return Graph(xy, side, becomes[graph.edge], graph.trace, graph.window), bool(taken.any())


def may_join(side, on, i, j):
    """May two nodes become one and stay on the sides and lines that they are on?"""
    if not (side[i] | side[j]) & ON_LINE:
        return True
    if side[i] & side[j] & FIXED:
        return False
    if (side[i] | side[j]) & FIXED:
        fixed, other = (i, j) if side[i] & FIXED else (j, i)
        return not side[other] & SIDES & ~side[fixed] and (not side[other] & ON_LINE or (on[i] & on[j]).any())
    if side[i] & side[j] & ON_LINE:
        return (on[i] & on[j]).any() and not (side[i] | side[j]) & SIDES
    return not (side[i] | side[j]) & SIDES


def node_ranks(graph):
    """Which of two nodes stays where it is: a corner, then the boundary, a junction, a bend, a tip (nodes)."""
    degree = graph.degree
    corner = are_corners(graph.side)
    return np.select([corner, graph.side > 0, degree > 2, degree == 2], [4, 3, 2, 1], 0)


def on_sides(place, side, window):
    """A place moved onto the sides it belongs to."""
    x, y = place
    x = window[0] if side & 1 else window[2] if side & 2 else x
    y = window[1] if side & 4 else window[3] if side & 8 else y
    return np.array([x, y])


def split_at_nodes(graph, tolerance, counts):
    """Split edges at nodes nearer than the tolerance; tips and nodes near the boundary move onto the edge."""
    node, edge, part, distance = nodes_near_edges(graph, tolerance)
    if len(node) == 0:
        return graph, False
    xy, side, degree = graph.xy.copy(), graph.side.copy(), graph.degree
    moved = np.zeros(len(xy), dtype=bool)
    existing = {(min(i, j), max(i, j)) for i, j in graph.edge.tolist()}
    cuts = {}
    # Boundary first, then the nearest: a node moves once
    for k in np.lexsort((distance, graph.trace[edge] >= 0)):
        n, e = int(node[k]), int(edge[k])
        boundary, line = graph.trace[e] < 0, graph.trace[e] <= FIRST_LINE
        if moved[n] or moved[graph.edge[e]].any():
            continue
        # What is on a line or a side already stays there, though another comes near at an acute angle
        if (line and side[n]) or (boundary and side[n] & ON_LINE):
            continue
        if line:
            a, b = graph.xy[graph.edge[e]]
            side[n] |= ON_LINE
            xy[n] = a + part[k] * (b - a)
            counts["nodes near a border moved onto it"] += int(distance[k] > COINCIDENT * graph.size)
        elif boundary:
            side[n] |= SIDE_BIT[graph.trace[e]]
            xy[n] = on_sides(xy[n], side[n], graph.window)
            kind = "ends" if degree[n] == 1 else "bends"
            # What touches already is no change
            counts[f"{kind} near the boundary moved onto it"] += int(distance[k] > COINCIDENT * graph.size)
        elif degree[n] == 1 and side[n] == 0:
            a, b = graph.xy[graph.edge[e]]
            xy[n] = a + part[k] * (b - a)
            counts["tips near a trace moved onto it"] += int(distance[k] > COINCIDENT * graph.size)
        elif not shortens(graph, existing, e, n):
            continue
        else:
            counts["traces led through a node near them"] += int(distance[k] > COINCIDENT * graph.size)
        moved[n] = True
        cuts.setdefault(e, []).append((part[k], n))
    return cut_edges(graph, xy, side, cuts), bool(cuts)


def shortens(graph, existing, edge, node):
    """Are the edges that lead an edge through a node new only where they are shorter than it?

    Otherwise three nodes hardly farther apart than the tolerance would exchange the sides of their triangle for ever.
    """
    ends = graph.edge[edge].tolist()
    new = [end for end in ends if (min(end, node), max(end, node)) not in existing]
    length = np.hypot(*(graph.xy[ends[1]] - graph.xy[ends[0]]))
    return all(np.hypot(*(graph.xy[end] - graph.xy[node])) < length for end in new)


def split_at_crossings(graph, tolerance, counts):  # noqa: ARG001 - one form for all changes
    """Give edges that cross a node where they do."""
    first, second, place, part = crossings(graph)
    if len(first) == 0:
        return graph, False
    counts["crossings found"] += len(first)
    cuts = {}
    for k, (i, j) in enumerate(zip(first, second, strict=True)):
        cuts.setdefault(int(i), []).append((part[k, 0], len(graph.xy) + k))
        cuts.setdefault(int(j), []).append((part[k, 1], len(graph.xy) + k))
    boundary = np.minimum(graph.trace[first], graph.trace[second])
    new_side = np.array([ON_LINE if t <= FIRST_LINE else SIDE_BIT.get(t, 0) for t in boundary.tolist()])
    place = np.array([on_sides(p, s, graph.window) for p, s in zip(place, new_side, strict=True)])
    return cut_edges(graph, np.vstack([graph.xy, place]), np.concatenate([graph.side, new_side]), cuts), True


def cut_edges(graph, xy, side, cuts):
    """Replace edges by chains through nodes: cuts is {edge: [(part of its length, node)]}."""
    keep = np.ones(len(graph.edge), dtype=bool)
    keep[list(cuts)] = False
    new_edge, new_trace = [], []
    for e, nodes in cuts.items():
        chain = [graph.edge[e, 0], *[n for _, n in sorted(nodes)], graph.edge[e, 1]]
        new_edge += list(itertools.pairwise(chain))
        new_trace += [graph.trace[e]] * (len(chain) - 1)
    edge = np.vstack([graph.edge[keep], np.array(new_edge, dtype=int).reshape(-1, 2)])
    trace = np.concatenate([graph.trace[keep], np.array(new_trace, dtype=int)])
    return Graph(xy, side, edge, trace, graph.window)


def nodes_near_edges(graph, tolerance):
    """Nodes within a tolerance [m] of the inside of an edge that is not theirs: node, edge, part, distance [m]."""
    cells = EdgeCells(graph, tolerance)
    node, edge = cells.nodes_and_edges()
    start = graph.xy[graph.edge[edge, 0]]
    along = graph.xy[graph.edge[edge, 1]] - start
    beyond = graph.xy[node] - start
    squared = (along**2).sum(axis=1)
    part = (along * beyond).sum(axis=1) / squared
    distance = np.abs(along[:, 0] * beyond[:, 1] - along[:, 1] * beyond[:, 0]) / np.sqrt(squared)
    own = (graph.edge[edge] == node[:, None]).any(axis=1)
    # A node that is on this side of the boundary already is at one of its nodes
    near = (distance < tolerance) & (part > 0.0) & (part < 1.0) & ~own
    return node[near], edge[near], part[near], distance[near]


def crossings(graph):
    """Pairs of edges that cross: first, second, place (pairs, 2) [m], part of each edge's length (pairs, 2)."""
    first, second = EdgeCells(graph, 0.0).edge_pairs()
    a, b = graph.xy[graph.edge[first, 0]], graph.xy[graph.edge[second, 0]]
    r, s = graph.xy[graph.edge[first, 1]] - a, graph.xy[graph.edge[second, 1]] - b
    shared = (graph.edge[first][:, :, None] == graph.edge[second][:, None, :]).any(axis=(1, 2))
    turn = cross(r, s)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.stack([cross(b - a, s) / turn, cross(b - a, r) / turn], axis=1)
    meets = ~shared & (turn != 0.0) & (part > 0.0).all(axis=1) & (part < 1.0).all(axis=1)
    return first[meets], second[meets], a[meets] + part[meets, :1] * r[meets], part[meets]


def cross(r, s):
    """Component out of the plane of the product of vectors (n, 2)."""
    return r[..., 0] * s[..., 1] - r[..., 1] * s[..., 0]


class EdgeCells:
    """Square cells over the edges, to find what is near them in linear time."""

    def __init__(self, graph, reach):
        self.graph = graph
        lengths = graph.lengths
        area = (graph.window[2] - graph.window[0]) * (graph.window[3] - graph.window[1])
        self.origin = graph.xy.min(axis=0) - reach
        self.cell = max(lengths.mean(), 4 * reach, np.sqrt(area / (4 * len(lengths))))
        ends = graph.xy[graph.edge]
        low = self.index(ends.min(axis=1) - reach)
        high = self.index(ends.max(axis=1) + reach)
        wide = high - low + 1
        self.columns = int(high[:, 0].max()) + 2
        count = wide[:, 0] * wide[:, 1]
        edge = np.repeat(np.arange(len(count)), count)
        place = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
        column = low[edge, 0] + place % wide[edge, 0]
        row = low[edge, 1] + place // wide[edge, 0]
        # Only the cells that the edge passes, not all of the rectangle around it
        centre = self.origin + (np.stack([column, row], axis=1) + 0.5) * self.cell
        along = ends[edge, 1] - ends[edge, 0]
        beside = np.abs(cross(along, centre - ends[edge, 0])) / np.maximum(lengths[edge], 1e-300)
        passes = beside <= 0.7072 * self.cell + reach
        edge, cell = edge[passes], (row * self.columns + column)[passes]
        order = np.argsort(cell, kind="stable")
        self.edge, self.of_cell = edge[order], cell[order]

    def index(self, points):
        """Column and row of the cell of each point (points, 2)."""
        return np.floor((points - self.origin) / self.cell).astype(int)

    def nodes_and_edges(self):
        """Every node with every edge in its cell."""
        place = self.index(self.graph.xy)
        cell = place[:, 1] * self.columns + place[:, 0]
        first = np.searchsorted(self.of_cell, cell, side="left")
        count = np.searchsorted(self.of_cell, cell, side="right") - first
        node = np.repeat(np.arange(len(cell)), count)
        offset = np.arange(len(node)) - np.repeat(np.cumsum(count) - count, count)
        return node, self.edge[first[node] + offset]

    def edge_pairs(self):
        """Every pair of edges that share a cell, once."""
        last = np.searchsorted(self.of_cell, self.of_cell, side="right")
        here = np.arange(len(self.of_cell))
        count = last - here - 1
        first = np.repeat(here, count)
        offset = np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
        pairs = np.sort(np.stack([self.edge[first], self.edge[first + 1 + offset]], axis=1), axis=1)
        pairs = np.unique(pairs, axis=0)
        return pairs[:, 0], pairs[:, 1]


def branches(graph):
    """Chains of fracture edges between nodes that are not mere bends: a list of (nodes, edges), in order.

    A bend is a node inside the window where two fracture edges meet; a closed chain starts at any of its bends.
    """
    fracture = np.flatnonzero(graph.is_fracture)
    at_node = [[] for _ in range(len(graph.xy))]
    for e in fracture:
        for n in graph.edge[e]:
            at_node[n].append(int(e))
    bend = (graph.degree == 2) & (graph.side == 0)
    visited = np.zeros(len(graph.edge), dtype=bool)
    found = []
    starts = [n for n in range(len(graph.xy)) if at_node[n] and not bend[n]]
    for start in starts + [int(graph.edge[e, 0]) for e in fracture]:
        for e in at_node[start]:
            if visited[e]:
                continue
            nodes, edges = [start], []
            while not visited[e]:
                visited[e] = True
                edges.append(e)
                nodes.append(int(graph.edge[e].sum() - nodes[-1]))
                if bend[nodes[-1]]:
                    e = sum(at_node[nodes[-1]]) - e
            found.append((nodes, edges))
    return found
