"""Cleaning of fracture traces: from digitised lines to a planar graph that a mesh of a given size can follow.

    graph, report = clean(read_traces("two_sets.csv"), feature=0.005)
    print(report.text())

Two passes. The first mends what digitising leaves: it snaps within a small tolerance, splits at crossings and drops
what lies double. The second removes what is smaller than the least feature, which is tied to the size of the elements:
it simplifies branches, drops stubs, contracts short branches and opens or merges narrow wedges.
"""

import itertools
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from femdem.network.planar_graph import (
    COINCIDENT,
    FIRST_LINE,
    FIXED,
    ON_LINE,
    SIDES,
    EndlessError,
    Graph,
    Window,
    branches,
    crossings,
    graph_of,
    knit,
    nodes_near_edges,
    tidy,
)
from femdem.network.traces import TraceError, Traces, clip

SNAP = 5e-4  # of the window's shorter side: default snap tolerance, 1 mm in 2 m
MIN_ANGLE = 15.0  # default least angle between fractures at a node [degrees]
LINK_ANGLE = np.radians(60.0)  # angle at which a rerouted fracture meets the other
LOSS = 0.05  # part of the traces' length whose loss is warned of
MOST_ROUNDS = 200  # of removing features
ROUNDS_OF_WEDGES = 100  # of them, in which wedges are opened
SMALLER = (1.0, 0.9, 0.8, 0.65, 0.5, 0.3, 0.1)  # parts of the feature that are tried in turn
HALVINGS = 4  # of the tolerance of a branch that would cross another


@dataclass
class Census:
    """What a network consists of."""

    traces: int
    branches: int
    length: float  # [m]
    tips: int  # I nodes
    abutments: int  # Y nodes
    crossings: int  # X nodes
    more: int  # nodes of five and more branches
    boundary: int  # nodes on the boundary where fractures end

    @classmethod
    def of(cls, graph):
        """Count a planar graph."""
        degree = graph.degree
        of_hole = getattr(graph.window, "of_hole", np.zeros(0, dtype=int)) >= 0
        inside = (graph.side & SIDES == 0) & ~graph.lines_of_nodes[:, of_hole].any(axis=1)
        # A fracture goes on through the border of a zone
        through = inside & (graph.side & ON_LINE > 0) & (degree == 2)
        return cls(
            traces=len(np.unique(graph.trace[graph.is_fracture])),
            branches=len(branches(graph)) - int(through.sum()),
            length=graph.fracture_length,
            tips=int((inside & (degree == 1)).sum()),
            abutments=int((inside & (degree == 3)).sum()),
            crossings=int((inside & (degree == 4)).sum()),
            more=int((inside & (degree > 4)).sum()),
            boundary=int((~inside & (degree > 0)).sum()),
        )


@dataclass
class Report:
    """What cleaning found and changed."""

    settings: dict = field(default_factory=dict)
    census: dict = field(default_factory=dict)  # Census by name of the state
    changes: dict = field(default_factory=dict)  # Counter of changes by name of the pass
    moved: float = 0.0  # largest distance of a point of the traces from the cleaned network [m]
    narrow: int = 0  # wedges below the least angle that remain
    acute: int = 0  # places where borders of zones or sides of the window meet at less than the least angle

    @property
    def lost(self):
        """Part of the traces' length in the window that is not in the cleaned network."""
        return 1.0 - self.census["cleaned"].length / self.census["as read"].length

    def warnings(self):
        """What the user should look at, one line each."""
        found = []
        if self.acute:
            found.append(
                f"warning: borders of zones meet each other or the window's sides at less than the least angle {self.acute} times;"
                " they stay as they are, and triangles are as narrow there"
            )
        if self.lost <= LOSS:
            return found
        read, left = (self.census[state].length for state in ("as read", "cleaned"))
        return [
            *found,
            f"warning: cleaning lost {100 * self.lost:.1f} % of the length of the traces ({read:.4g} m read, {left:.4g} m left);"
            " a smaller --size, --feature or --stub keeps more",
        ]

    def text(self):
        """The report as lines of text."""
        lines = ["settings: " + ", ".join(f"{name} {value}" for name, value in self.settings.items())]
        rows = [
            ("traces", "traces", "d"),
            ("branches", "branches", "d"),
            ("length_m", "length", ".6f"),
            ("free_tips_I", "tips", "d"),
            ("abutments_Y", "abutments", "d"),
            ("crossings_X", "crossings", "d"),
            ("nodes_of_5+", "more", "d"),
            ("ends_on_boundary", "boundary", "d"),
        ]
        lines.append(f"{'':18}" + "".join(f"{name:>14}" for name in self.census))
        for name, attribute, form in rows:
            values = [format(getattr(census, attribute), form) for census in self.census.values()]
            lines.append(f"{name:18}" + "".join(f"{value:>14}" for value in values))
        for name, counter in self.changes.items():
            lines.append(f"changes, {name}:")
            done = [f"  {number:6d}  {what}" for what, number in counter.items() if number]
            lines += done or ["          none"]
        lines.append(
            f"the cleaned network passes within {1e3 * self.moved:.3g} mm of every point of the traces"
        )
        lines.append(f"wedges below the least angle that remain: {self.narrow}")
        return "\n".join(lines + self.warnings())


def clean(traces, window=None, snap=None, feature=None, simplify=None, stub=None, min_angle=MIN_ANGLE):
    """Clean traces; the graph and the report.

    window: rectangle x0, y0, x1, y1 [m], default the extent of the traces; a Window may have holes and zones. snap:
    tolerance of the first pass [m]. feature: least distance between what is not joined in the second pass [m], default
    4 snap. simplify: tolerance of the simplification of branches [m], default half a feature. stub: shorter dangling ends
    are dropped [m], default twice the feature. min_angle: least angle of a wedge [degrees].
    """
    window = checked_window(window or traces.extent)
    size = max(window[2] - window[0], window[3] - window[1])
    snap = SNAP * min(window[2] - window[0], window[3] - window[1]) if snap is None else snap
    feature = 4 * snap if feature is None else max(feature, snap)
    simplify = feature / 2 if simplify is None else simplify
    stub = 2 * feature if stub is None else stub
    check_settings(snap, feature, simplify, stub, min_angle, window)
    report = Report()
    report.settings = {
        "window": "({:g}, {:g}) to ({:g}, {:g}) m".format(*window),
        "snap": f"{1e3 * snap:g} mm",
        "least feature": f"{1e3 * feature:g} mm",
        "simplify": f"{1e3 * simplify:g} mm",
        "stub": f"{1e3 * stub:g} mm",
        "least angle": f"{min_angle:g} degrees",
    }
    first, second = Counter(), Counter()
    report.changes = {"snap pass": first, "feature pass": second}

    clipped = clip(traces, window)
    if len(clipped.segment) == 0:
        raise TraceError("no trace lies in the window (%g, %g) to (%g, %g) m" % tuple(window))  # noqa: UP031
    first["traces outside the window dropped"] = len(traces.name) - clipped.used
    first["pieces outside the window dropped"] = len(traces.segment) - len(clipped.segment)
    report.census["as read"] = Census.of(knit(graph_of(clipped, window), COINCIDENT * size, Counter()))
    # Counted before anything is joined, so that the length that goes is seen
    report.census["as read"].length = clipped.length
    graph = knit(graph_of(clipped, window), snap, first)
    graph = drop_stubs(graph, snap, first)
    report.census["snapped"] = Census.of(graph)
    check_left(graph)

    graph = simplify_branches(graph, simplify, snap, second)
    graph = remove_what_can_be(graph, feature, stub, np.radians(min_angle), report)
    second = report.changes["feature pass"]
    graph = knit(graph, COINCIDENT * size, Counter())
    check_left(graph)
    second["traces that vanished"] = report.census["snapped"].traces - len(
        np.unique(graph.trace[graph.is_fracture])
    )
    report.census["cleaned"] = Census.of(graph)
    report.narrow = len(wedges(graph, np.radians(min_angle)))
    report.acute = len(wedges(graph, np.radians(min_angle), of_borders=True))
    report.moved = farthest(clipped, graph, feature)
    return graph, report


def check_left(graph):
    """Refuse a network without fractures."""
    if not graph.is_fracture.any():
        raise TraceError(
            "nothing is left of the traces: all are shorter than the least feature or lie on the boundary"
        )


def checked_window(window):
    """The window as four numbers (or as the Window it is), refused when it has no area."""
    window = window if isinstance(window, Window) else tuple(float(x) for x in window)
    if len(window) != 4 or not all(np.isfinite(window)) or window[0] >= window[2] or window[1] >= window[3]:
        raise TraceError(f"the window {window} has no area; give x0 y0 x1 y1 with x0 < x1 and y0 < y1")
    return window


def check_settings(snap, feature, simplify, stub, min_angle, window):
    """Refuse settings that make no sense."""
    least = 10 * COINCIDENT * max(window[2] - window[0], window[3] - window[1])
    shorter = min(window[2] - window[0], window[3] - window[1])
    if not snap >= least:
        raise TraceError(f"the snap tolerance {snap:g} m is too small; it must be at least {least:g} m")
    if not feature <= shorter / 8:
        raise TraceError(
            f"the least feature {feature:g} m is too large for the window; {shorter / 8:g} m is the most"
        )
    if not 0.0 <= simplify <= feature:
        raise TraceError(
            f"the tolerance of simplifying {simplify:g} m must be between 0 and the feature {feature:g} m"
        )
    if not stub >= 0.0:
        raise TraceError(f"the length of stubs {stub:g} m must not be negative")
    if not 0.0 <= min_angle <= 30.0:
        raise TraceError(f"the least angle {min_angle:g} degrees must be between 0 and 30")


def drop_stubs(graph, shortest, counts):
    """Drop dangling branches and isolated ones shorter than a length [m], until there are none."""
    while True:
        degree, lengths = graph.degree, graph.lengths
        keep = np.ones(len(graph.edge), dtype=bool)
        for nodes, edges in branches(graph):
            free = [degree[n] == 1 and graph.side[n] == 0 for n in (nodes[0], nodes[-1])]
            if not any(free) or lengths[edges].sum() >= shortest:
                continue
            keep[edges] = False
            counts["isolated pieces dropped" if all(free) else "stubs dropped"] += 1
        if keep.all():
            return graph
        graph = tidy(Graph(graph.xy, graph.side, graph.edge[keep], graph.trace[keep], graph.window), counts)


def simplify_branches(graph, tolerance, snap, counts):
    """Leave out bends of each branch that are nearer than the tolerance [m] to the line without them.

    The nodes at the ends of a branch stay. A branch that would then cross another one or come near a node that is not
    its own is simplified less, or not at all.
    """
    chains = branches(graph)
    widths = np.full(len(chains), tolerance)
    fixed = graph.edge[~graph.is_fracture]
    for attempt in range(HALVINGS + 1):
        kept = [
            douglas_peucker(graph.xy[nodes], w, trace_changes(graph, edges))
            for (nodes, edges), w in zip(chains, widths, strict=True)
        ]
        edge, owner, trace = [], [], []
        for c, ((nodes, edges), places) in enumerate(zip(chains, kept, strict=True)):
            edge += [(nodes[i], nodes[j]) for i, j in itertools.pairwise(places)]
            trace += [graph.trace[edges[i]] for i in places[:-1]]
            owner += [c] * (len(places) - 1)
        trial = Graph(
            graph.xy,
            graph.side,
            np.vstack([fixed, np.array(edge).reshape(-1, 2)]),
            np.concatenate([graph.trace[~graph.is_fracture], trace]).astype(int),
            graph.window,
        )
        owner = np.concatenate([np.full(len(fixed), -1), owner]).astype(int)
        wrong = conflicts(trial, owner, snap)
        if attempt < HALVINGS and len(wrong):
            widths[wrong] = widths[wrong] / 2 if attempt < HALVINGS - 1 else 0.0
            continue
        break
    counts["bends left out"] += int(sum(len(n) for n, _ in chains) - sum(len(k) for k in kept))
    counts["branches simplified less, not to touch others"] += int((widths < tolerance).sum())
    return tidy(trial, counts)


def trace_changes(graph, edges):
    """Places along a branch where one trace ends and another goes on: they stay, so that groups end where they do."""
    return [0, *(np.flatnonzero(np.diff(graph.trace[edges])) + 1).tolist(), len(edges)]


def conflicts(graph, owner, snap):
    """Branches with edges that cross others, or repeat them, or pass a node within the snap tolerance [m]."""
    first, second, _, _ = crossings(graph)
    wrong = set(owner[first]) | set(owner[second])
    used = graph.degree > 0
    node, edge, _, _ = nodes_near_edges(graph, snap)
    wrong |= set(owner[edge[used[node]]])
    _, place, number = np.unique(np.sort(graph.edge, axis=1), axis=0, return_inverse=True, return_counts=True)
    wrong |= set(owner[number[place] > 1])
    return sorted(wrong - {-1})


def douglas_peucker(xy, tolerance, fixed):
    """Places in a chain of points that keep it within the tolerance [m], the fixed ones (first and last too) among them.

    A closed chain keeps its farthest points, since it needs three corners.
    """
    keep = set(fixed)
    if len(xy) > 3 and (xy[0] == xy[-1]).all():
        far = int(np.argmax(np.hypot(*(xy - xy[0]).T)))
        third = int(np.argmax(distances(xy, xy[0], xy[far])))
        keep |= {far, third}
    corners = sorted(keep)
    parts = list(itertools.pairwise(corners))
    while parts:
        i, j = parts.pop()
        if j - i < 2:
            continue
        distance = distances(xy[i + 1 : j], xy[i], xy[j])
        k = int(np.argmax(distance))
        if distance[k] > tolerance:
            keep.add(i + 1 + k)
            parts += [(i, i + 1 + k), (i + 1 + k, j)]
    return sorted(keep)


def distances(points, a, b):
    """Distances of points from the segment a-b [m]."""
    along = b - a
    squared = along @ along
    part = np.clip((points - a) @ along / squared, 0.0, 1.0) if squared > 0 else np.zeros(len(points))
    return np.hypot(*(points - a - part[:, None] * along).T)


def remove_what_can_be(graph, feature, stub, min_angle, report):
    """Remove features; where that would not come to an end, with a smaller least feature, which the report says."""
    for part in SMALLER:
        counts = report.changes["feature pass"].copy()
        try:
            graph = remove_features(graph, part * feature, stub, min_angle, counts)
        except EndlessError:
            continue
        report.changes["feature pass"] = counts
        if part < 1.0:
            report.settings["least feature"] += f", reduced to {1e3 * part * feature:g} mm to come to an end"
        return graph
    raise TraceError(
        "the traces cannot be cleaned with these settings; try another least feature or snap tolerance"
    )


def remove_features(graph, feature, stub, min_angle, counts):
    """Knit with the least feature [m], drop stubs [m] and open wedges [rad] until nothing changes any more."""
    for attempt in range(MOST_ROUNDS):
        before = sum(counts.values())
        graph = drop_stubs(knit(graph, feature, counts), stub, counts)
        if attempt < ROUNDS_OF_WEDGES:
            graph = open_wedges(graph, feature, min_angle, counts)
        if sum(counts.values()) == before:
            return graph
    raise EndlessError(f"cleaning does not come to an end with the feature {feature:g} m")


def wedges(graph, min_angle, of_borders=False):
    """Pairs of edges that leave a node at less than an angle [rad]: (node, edge, edge, angle).

    One of the edges at least is of a fracture, or, of_borders, none: sides and borders of zones stay as they were given.
    """
    ends = np.concatenate([graph.edge[:, 0], graph.edge[:, 1]])
    other = np.concatenate([graph.edge[:, 1], graph.edge[:, 0]])
    number = np.tile(np.arange(len(graph.edge)), 2)
    direction = np.arctan2(*(graph.xy[other] - graph.xy[ends]).T[::-1])
    order = np.lexsort((direction, ends))
    ends, number, direction = ends[order], number[order], direction[order]
    first = np.flatnonzero(np.r_[True, ends[1:] != ends[:-1]])
    count = np.diff(np.r_[first, len(ends)])
    following = np.arange(len(ends)) + 1
    following[first + count - 1] = first
    angle = (direction[following] - direction) % (2 * np.pi)
    narrow = (angle < min_angle) & (following != np.arange(len(ends)))
    narrow &= of_borders == ((graph.trace[number] < 0) & (graph.trace[number[following]] < 0))
    return [
        (int(ends[k]), int(number[k]), int(number[following[k]]), float(angle[k]))
        for k in np.flatnonzero(narrow)
    ]


def open_wedges(graph, feature, min_angle, counts):
    """Merge the tip of each wedge until its sides are a feature [m] apart, and end it there at a steep angle.

        v-----------------------------a        v-------p---------------------a
            `---.__                       ->          /
                   `---.__                           q.__
                          `---b                          `---b

    One side stays where it is: the boundary, or the side that goes straight on beyond v, or the longer one.
    """
    found = wedges(graph, min_angle)
    touched = np.zeros(len(graph.edge), dtype=bool)
    touched_node = np.zeros(len(graph.xy), dtype=bool)
    xy, side = list(graph.xy), graph.side.copy()
    added_edge, added_trace = [], []
    straight = straightness(graph)
    for v, e, f, angle in sorted(found, key=lambda wedge: wedge[3]):
        stay, bend = (
            (e, f) if staying_rank(graph, straight, v, e) >= staying_rank(graph, straight, v, f) else (f, e)
        )
        a, b = (int(graph.edge[k].sum() - v) for k in (stay, bend))
        if touched[stay] or touched[bend] or touched_node[[v, a, b]].any():
            continue
        along, beside = graph.xy[a] - graph.xy[v], graph.xy[b] - graph.xy[v]
        long, wide = np.hypot(*along), np.hypot(*beside)
        apart = feature * (1 + 1e-6)
        ends_within = wide * np.sin(angle) < apart and wide <= long
        # What is on another side or line cannot be led to this one
        elsewhere = ON_LINE if graph.trace[stay] > FIRST_LINE else ON_LINE | SIDES
        if ends_within and graph.trace[stay] < 0 and side[b] & elsewhere:
            continue
        touched[[stay, bend]] = touched_node[[v, a, b]] = True
        if ends_within:
            # The bent side ends within the wedge: the other is led through its end
            added_edge += [(v, b), (b, a)]
            added_trace += [graph.trace[stay]] * 2
            if graph.trace[stay] < 0:
                side[b] |= side[v] & side[a] & ~FIXED
                xy[b] = graph.xy[v] + along * (along @ beside) / long**2
        elif long * np.sin(angle) < apart:
            added_edge += [(v, a), (a, b)]
            added_trace += [graph.trace[stay], graph.trace[bend]]
        else:
            out = apart / np.sin(angle)
            back = out * np.cos(angle) - apart / np.tan(LINK_ANGLE)
            p = graph.xy[v] + along * (back / long)
            q = graph.xy[v] + beside * (out / wide)
            xy += [p, q]
            on_side = side[v] & side[a] & ~FIXED if graph.trace[stay] < 0 else 0
            side = np.append(side, [on_side, 0])
            added_edge += [(v, len(xy) - 2), (len(xy) - 2, a), (len(xy) - 2, len(xy) - 1), (len(xy) - 1, b)]
            added_trace += [graph.trace[stay]] * 2 + [graph.trace[bend]] * 2
        if graph.trace[stay] <= FIRST_LINE and graph.window.of_hole[FIRST_LINE - graph.trace[stay]] < 0:
            # The fracture goes on along the border of a zone, or it would end there
            added_edge.append((v, b if ends_within else a if long * np.sin(angle) < apart else len(xy) - 2))
            added_trace.append(graph.trace[bend])
        counts["narrow wedges merged at their tip"] += 1
    edge = np.vstack([graph.edge[~touched], np.array(added_edge, dtype=int).reshape(-1, 2)])
    trace = np.concatenate([graph.trace[~touched], np.array(added_trace, dtype=int)])
    return tidy(Graph(np.array(xy), side, edge, trace, graph.window), counts)


def straightness(graph):
    """For each end of each edge, the cosine of the bend to the edge that goes on straightest beyond it."""
    best = {}
    at_node = [[] for _ in range(len(graph.xy))]
    for e, (i, j) in enumerate(graph.edge):
        at_node[i].append(e)
        at_node[j].append(e)
    for n, edges in enumerate(at_node):
        if len(edges) < 2:
            continue
        far = graph.edge[edges].sum(axis=1) - n
        direction = graph.xy[far] - graph.xy[n]
        direction /= np.hypot(*direction.T)[:, None]
        cosine = -direction @ direction.T
        np.fill_diagonal(cosine, -2.0)
        for k, e in enumerate(edges):
            best[n, e] = float(cosine[k].max())
    return best


def staying_rank(graph, straight, node, edge):
    """How much an edge of a wedge should stay where it is: the boundary first, then what goes straight on."""
    if graph.trace[edge] < 0:
        return 9.0
    # Bends of less than a few degrees count alike; then the longer side stays
    length = np.hypot(*(graph.xy[graph.edge[edge, 1]] - graph.xy[graph.edge[edge, 0]]))
    return round(straight.get((node, edge), -1.0), 1) + 1e-3 * length / graph.size


def farthest(traces, graph, feature):
    """Largest distance of a point of the traces from the cleaned fractures and the boundary [m]."""
    spacing = feature / 4
    points = sample(traces.segment[:, :2], traces.segment[:, 2:], spacing)
    tree = cKDTree(sample(graph.xy[graph.edge[:, 0]], graph.xy[graph.edge[:, 1]], spacing))
    distance, _ = tree.query(points)
    return float(distance.max())


def sample(start, end, spacing):
    """Points along segments, at most a spacing [m] apart."""
    pieces = np.maximum(1, np.ceil(np.hypot(*(end - start).T) / spacing).astype(int))
    of = np.repeat(np.arange(len(start)), pieces + 1)
    place = np.arange(len(of)) - np.repeat(np.cumsum(pieces + 1) - pieces - 1, pieces + 1)
    part = place / pieces[of]
    return start[of] + part[:, None] * (end[of] - start[of])


def traces_of(graph, names):
    """The cleaned fractures as traces, the rows of each in order along its chains."""
    segment, trace = [], []
    for t in np.unique(graph.trace[graph.is_fracture]):
        one = graph.trace == t
        part = Graph(graph.xy, np.zeros_like(graph.side), graph.edge[one], graph.trace[one], graph.window)
        for nodes, edges in branches(part):
            places = graph.xy[nodes]
            segment.append(np.hstack([places[:-1], places[1:]]))
            trace += [t] * len(edges)
    return Traces(np.vstack(segment), np.array(trace), names)
