"""Meshes of fracture networks: cleaning of traces drawn by hand, bad files, and block edges against a walk of our own."""

import itertools
import os
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import MultiLineString, box
from shapely.ops import unary_union

from femdem.network import make_mesh, mesh_quality, regions
from femdem.network.cleaning import Census, clean, traces_of, wedges
from femdem.network.make_traces import two_sets
from femdem.network.planar_graph import SIDE_NAMES, crossings, graph_of, knit
from femdem.network.traces import TraceError, Traces, read_traces, write_traces

TOP = Path(__file__).resolve().parent.parent
NETWORK = TOP / "input" / "network"
SHARED = TOP.parent / "shared" / "traces"
MESHER = [sys.executable, "-m", "femdem", "mesh"]
UNIT = (0.0, 0.0, 1.0, 1.0)  # the window of the hand-drawn cases [m]
UNIT_SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
SNAP, FEATURE = 1e-3, 1e-2  # their tolerances [m]
# A length or place computed twice in double precision
ROUNDING = 1e-12
# Least angle that meshes must keep [degrees]: that of the wedges, 15, less some for triangles between two of them
LEAST_ANGLE = 10.0


def drawn(*lines):
    """Traces through points: one list of points a trace."""
    segment = [[*a, *b] for points in lines for a, b in itertools.pairwise(points)]
    trace = [k for k, points in enumerate(lines) for _ in points[1:]]
    return Traces(np.array(segment, dtype=float), np.array(trace), [str(k) for k in range(len(lines))])


def cleaned(*lines, **options):
    """Cleaned graph, its census, and all changes counted together."""
    settings = {"window": UNIT, "snap": SNAP, "feature": FEATURE} | options
    graph, report = clean(drawn(*lines), **settings)
    return graph, report.census["cleaned"], sum(report.changes.values(), Counter())


def nodes(census):
    """Tips, abutments, crossings, more, ends on the boundary."""
    return census.tips, census.abutments, census.crossings, census.more, census.boundary


@pytest.mark.fast
def test_crossing_of_two_traces():
    #    \ /
    #     X
    #    / \
    graph, census, _ = cleaned([(0.2, 0.2), (0.8, 0.8)], [(0.2, 0.8), (0.8, 0.2)])
    assert nodes(census) == (4, 0, 1, 0, 0)
    assert census.branches == 4
    assert graph.fracture_length == pytest.approx(2 * 0.6 * 2**0.5, rel=ROUNDING)


@pytest.mark.fast
@pytest.mark.parametrize("gap", [0.5e-3, 0.0, -0.5e-3], ids=["short", "touching", "past"])
def test_abutment_within_the_snap_tolerance(gap):
    #         |
    #   ------+------   the upright trace ends half a millimetre short of the other, on it, or past it
    graph, census, changes = cleaned([(0.2, 0.5), (0.8, 0.5)], [(0.5, 0.9), (0.5, 0.5 + gap)])
    assert nodes(census) == (3, 1, 0, 0, 0)
    assert census.branches == 3
    assert changes["tips near a trace moved onto it"] == (gap != 0.0)
    assert graph.fracture_length == pytest.approx(0.6 + 0.4, rel=ROUNDING)


@pytest.mark.fast
def test_abutment_stays_when_the_trace_it_abuts_on_is_simplified():
    # A wavy line of 2 mm amplitude; the other trace ends on a crest, and that node stays
    wave = [(0.2 + 0.02 * k, 0.5 + 0.002 * (k % 2)) for k in range(31)]
    _, census, changes = cleaned(wave, [(0.46, 0.9), (0.46, 0.502)])
    assert nodes(census) == (3, 1, 0, 0, 0)
    assert census.branches == 3
    # Of 32 points along the wave the ends and the abutment stay
    assert changes["bends left out"] == 31 - 3


@pytest.mark.fast
def test_stub_beyond_an_abutment_is_dropped():
    graph, census, changes = cleaned([(0.2, 0.5), (0.8, 0.5)], [(0.5, 0.9), (0.5, 0.485)])
    assert nodes(census) == (3, 1, 0, 0, 0)
    assert changes["stubs dropped"] == 1
    assert graph.fracture_length == pytest.approx(1.0, rel=ROUNDING)


@pytest.mark.fast
def test_isolated_piece_is_dropped():
    _, census, changes = cleaned([(0.2, 0.2), (0.8, 0.8)], [(0.2, 0.8), (0.215, 0.8)])
    assert census.traces == 1
    assert changes["isolated pieces dropped"] == 1


@pytest.mark.fast
def test_narrow_wedge_is_merged_at_its_tip():
    #   v--------------------   3 degrees: merged until the sides are a feature apart, then a link at 60 degrees
    #     `----.___
    angle = np.radians(3.0)
    far = (0.1 + 0.8 * np.cos(angle), 0.5 - 0.8 * np.sin(angle))
    graph, census, changes = cleaned([(0.1, 0.5), (0.95, 0.5)], [(0.1, 0.5), far])
    assert changes["narrow wedges merged at their tip"] == 1
    assert nodes(census) == (3, 1, 0, 0, 0)
    link, merged = FEATURE / np.sin(np.radians(60)), FEATURE / np.sin(angle)
    # The sides are parted by a millionth more than the feature
    assert graph.fracture_length == pytest.approx(0.85 + 0.8 - merged + link, rel=1e-5)


@pytest.mark.fast
def test_wedge_at_the_boundary_is_opened():
    graph, census, changes = cleaned([(0.2, 0.0), (0.8, 0.03)])
    assert changes["narrow wedges merged at their tip"] == 1
    assert nodes(census) == (1, 0, 0, 0, 1)
    end = graph.xy[graph.side > 0][graph.degree[graph.side > 0] == 1][0]
    assert end[0] > 0.3
    assert end[1] == 0.0


@pytest.mark.fast
def test_traces_that_lie_on_others_count_once():
    # The same again, reversed; half of it a bit beside; and beyond its end
    whole = [(0.2, 0.5), (0.8, 0.5)]
    graph, census, changes = cleaned(
        whole, whole[::-1], [(0.3, 0.5002), (0.6, 0.5003)], [(0.7, 0.5), (0.9, 0.5)]
    )
    assert nodes(census) == (2, 0, 0, 0, 0)
    assert census.branches == 1
    assert census.traces == 2
    assert changes["pieces that lie on others dropped"] > 0
    assert graph.fracture_length == pytest.approx(0.7, rel=1e-5)


@pytest.mark.fast
def test_traces_at_the_boundary():
    # Along it: dropped. Short of it: extended. Through it: trimmed. Through a corner's surroundings: led to the corner.
    graph, census, changes = cleaned(
        [(0.3, 0.0004), (0.7, 0.0)],
        [(0.5, 0.2), (0.5, 0.9995)],
        [(0.2, 0.5), (-0.3, 0.6)],
        [(0.7, 0.7), (1.2, 1.2)],
    )
    assert changes["pieces along the boundary dropped"] == 1
    assert changes["ends near the boundary moved onto it"] >= 1
    assert nodes(census) == (3, 0, 0, 0, 3)
    assert graph.fracture_length == pytest.approx(0.8 + np.hypot(0.2, 0.04) + 0.3 * 2**0.5, rel=ROUNDING)


@pytest.mark.fast
def test_crossings_near_each_other_become_one_node():
    star = [[(0.5 - 0.3 * c, 0.5 - 0.3 * s + e), (0.5 + 0.3 * c, 0.5 + 0.3 * s + e)]
            for c, s, e in ((1, 0, 0.0), (0.5, 0.9, 0.001), (-0.5, 0.9, 0.004))]  # fmt: skip
    _, census, _ = cleaned(*star)
    assert nodes(census) == (6, 0, 0, 1, 0)
    assert census.branches == 6


@pytest.mark.fast
def test_cleaning_twice_changes_no_nodes(tmp_path):
    graph, report = clean(read_traces(NETWORK / "two_sets.csv"), feature=0.005)
    write_traces(tmp_path / "once.csv", traces_of(graph, [str(k) for k in range(1000)]))
    again, second = clean(read_traces(tmp_path / "once.csv"), feature=0.005)
    assert nodes(second.census["cleaned"]) == nodes(report.census["cleaned"])
    # A bend that had to stay at first may go the second time: half a feature aside over some centimetres
    assert again.fracture_length == pytest.approx(graph.fracture_length, rel=1e-5)
    assert sum(number for what, number in second.changes["feature pass"].items() if "bend" not in what) == 0


@pytest.mark.fast
def test_generated_network_is_the_one_that_ships():
    shipped = read_traces(NETWORK / "two_sets.csv")
    again, of_set = two_sets(5, 2.0, (100.0, 140.0), 3.0, 0.6, 2.0, 0.4, 4.0, p21=7.0)
    # The file is written to the nanometre
    np.testing.assert_allclose(again.segment, shipped.segment, atol=1e-9, rtol=0)
    graph = knit(graph_of(again, (0.0, 0.0, 2.0, 2.0)), 1e-9, Counter())
    strike = make_mesh.strikes(graph)
    for k, which in enumerate(of_set):
        # Five standard deviations of 3 degrees
        assert abs(strike[k] - (100.0, 140.0)[which]) < 15.0
    assert again.length / 4 == pytest.approx(7.0, abs=0.2)


# ---- Against another library ----


@pytest.mark.fast
@pytest.mark.parametrize("seed", range(5))
def test_the_planar_graph_is_that_of_shapely(seed):
    """Traces cut at their crossings: by our graph, and by shapely's union of all lines with the window's sides."""
    traces, _ = two_sets(seed, 2.0, (100.0, 140.0), 3.0, 0.6, 2.0, 0.2, 4.0, p21=10.0)
    window = box(0.0, 0.0, 2.0, 2.0)
    united = unary_union([MultiLineString(list(traces.segment.reshape(-1, 2, 2))), window.exterior])
    sides = window.exterior.buffer(1e-9)
    pieces = [piece for piece in united.intersection(window).geoms if not sides.contains(piece)]
    graph = knit(graph_of(traces, (0.0, 0.0, 2.0, 2.0)), 1e-9, Counter())
    assert graph.is_fracture.sum() == len(pieces)
    assert graph.fracture_length == pytest.approx(sum(piece.length for piece in pieces), rel=1e-9)
    degree = Counter(tuple(np.round(end, 7)) for piece in pieces for end in piece.coords)
    ours = Counter(tuple(np.round(graph.xy[n], 7)) for n in graph.edge[graph.is_fracture].ravel())
    assert sorted(ours.values()) == sorted(degree.values())


@pytest.mark.fast
def test_cleaned_fractures_lie_where_the_traces_lay():
    """Whatever cleaning does, no fracture is farther from the traces than it may move things, nor shorter by much."""
    traces = read_traces(NETWORK / "two_sets.csv")
    graph, _ = clean(traces, snap=SNAP, feature=FEATURE)
    before = MultiLineString(list(traces.segment.reshape(-1, 2, 2)))
    after = MultiLineString(list(graph.xy[graph.edge[graph.is_fracture]]))
    # A wedge's sides are merged where they are less than a feature apart, and a link parts them there
    assert after.difference(before.buffer(2 * FEATURE)).length == 0.0
    assert after.intersection(before.buffer(FEATURE)).length > 0.99 * after.length
    assert after.length == pytest.approx(graph.fracture_length, rel=1e-9)


# ---- Holes and zones ----


def with_regions(*lines, holes=(), zones=(), size=0.03):
    """Cleaned graph of traces in the unit square with holes and zones, and its census."""
    found = regions.make_regions(holes, [(np.array(zone), name) for zone, name in zones], UNIT, size, FEATURE)
    traces = regions.outside_holes(drawn(*lines), found.holes)
    graph, report = clean(traces, window=found.window, snap=SNAP, feature=FEATURE)
    return graph, report.census["cleaned"], found


@pytest.mark.fast
def test_a_hole_cuts_traces():
    # Through the middle; into the hole; beside it; all in it
    graph, census, found = with_regions(
        [(0.1, 0.5), (0.9, 0.5)],
        [(0.5, 0.5), (0.5, 0.9)],
        [(0.1, 0.2), (0.9, 0.2)],
        [(0.45, 0.5), (0.55, 0.45)],
        holes=[(0.5, 0.5, 0.15)],
    )
    assert nodes(census) == (5, 0, 0, 0, 3)
    # Sides of the polygon: 2 pi 0.15 / 0.03 = 31.4, so 32, with corners east, west and north
    assert found.holes[0].sides == 32
    assert graph.fracture_length == pytest.approx(2 * 0.25 + 0.25 + 0.8, rel=ROUNDING)
    on_hole = np.hypot(*(graph.xy[graph.side > 0] - 0.5).T) < 0.2
    assert on_hole.sum() == 32


@pytest.mark.fast
def test_traces_near_a_hole_end_on_it():
    # 4 mm short of it, and grazing it 4 mm inside its northernmost corner
    graph, census, found = with_regions(
        [(0.1, 0.5), (0.346, 0.5)], [(0.2, 0.646), (0.8, 0.646)], holes=[(0.5, 0.5, 0.15)]
    )
    assert nodes(census)[:3] == (3, 0, 0)
    assert not graph.in_hole[graph.is_fracture].any()
    ends = graph.xy[(graph.side > 0) & (graph.degree > 0)] - 0.5
    # On the polygon, between its circles
    assert (np.hypot(*ends.T) <= 0.15 + ROUNDING).all()
    assert (np.hypot(*ends.T) >= found.holes[0].inscribed - ROUNDING).all()


@pytest.mark.fast
def test_a_trace_goes_on_through_the_border_of_a_zone():
    graph, census, found = with_regions(
        [(0.1, 0.3), (0.9, 0.4)], zones=[([(0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0)], "east")]
    )
    assert nodes(census) == (2, 0, 0, 0, 0)
    assert census.branches == 1
    assert graph.fracture_length == pytest.approx(np.hypot(0.8, 0.1), rel=ROUNDING)
    assert found.zones[0][1].area == pytest.approx(0.5, rel=ROUNDING)
    # The node on the border is where they cross
    assert (np.abs(graph.xy - (0.5, 0.35)).max(axis=1) < ROUNDING).sum() == 1


@pytest.mark.fast
def test_a_trace_along_the_border_of_a_zone_stays():
    graph, census, _ = with_regions(
        [(0.2, 0.5), (0.8, 0.5)],
        [(0.3, 0.503), (0.3, 0.9)],
        zones=[([(-1, 0.5), (2, 0.5), (2, 2), (-1, 2)], "upper")],
    )
    assert nodes(census) == (3, 1, 0, 0, 0)
    assert graph.fracture_length == pytest.approx(0.6 + 0.4, rel=1e-2)
    assert (graph.line_of_edges[graph.is_fracture] >= 0).sum() == 2


@pytest.mark.fast
@pytest.mark.parametrize("end", [0.9, 1.0], ids=["tip", "on the side"])
def test_a_narrow_wedge_at_the_border_of_a_zone_is_opened(end):
    # Through the border at 4 degrees: on both sides of it the fracture leaves the border at a steep angle
    zone = [(-1, 0.5), (2, 0.5), (2, 2), (-1, 2)]
    graph, census, _ = with_regions([(0.1, 0.47), (end, 0.47 + 0.07 * (end - 0.1))], zones=[(zone, "upper")])
    assert len(wedges(graph, np.radians(15))) == 0
    assert census.tips == (2 if end < 1 else 1)


@pytest.mark.fast
def test_acute_borders_are_warned_of():
    found = regions.make_regions([], [(np.array([(0, 0), (1, 0.1), (1, 0)]), "wedge")], UNIT, 0.03, FEATURE)
    _, report = clean(drawn([(0.2, 0.5), (0.8, 0.5)]), window=found.window, snap=SNAP, feature=FEATURE)
    assert report.acute == 1
    assert report.narrow == 0
    assert any(line.startswith("warning: borders of zones") for line in report.warnings())


@pytest.mark.fast
def test_zones_overlap_in_the_order_given_and_holes_are_cut_out_of_them():
    square = [(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)]
    found = regions.make_regions(
        [(0.2, 0.5, 0.1)], [(np.array(square), "a"), (np.array([*UNIT_SQUARE]), "b")], UNIT, 0.0317, FEATURE
    )
    areas = {name: zone.area for name, zone in found.zones}
    hole = found.holes[0].area
    # Of 20 sides: the border of the square halves it
    assert found.holes[0].sides == 20
    assert areas["a"] == pytest.approx(0.36 - hole / 2, rel=1e-9)
    assert areas["b"] == pytest.approx(1 - 0.36 - hole / 2, rel=1e-9)
    assert found.holes[0].area == pytest.approx(np.pi * 0.01, rel=0.02)


@pytest.mark.fast
def test_a_zone_within_another_that_shares_its_border():
    """The heading of a tunnel, then the whole of it: what they have in common besides areas, points and lines, is no zone."""
    angle = 2 * np.pi * (np.arange(48) + 0.5) / 48
    tunnel = np.round(np.column_stack([0.5 + 0.25 * np.cos(angle), 0.5 + 0.25 * np.sin(angle)]), 6)
    heading = tunnel[tunnel[:, 1] > 0.5]
    found = regions.make_regions([], [(heading, "heading"), (tunnel, "tunnel")], UNIT, 0.03, FEATURE)
    areas = {name: zone.area for name, zone in found.zones}
    x, y = tunnel.T
    whole = 0.5 * abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1)))
    assert areas["heading"] + areas["tunnel"] == pytest.approx(whole, rel=1e-9)
    assert 0.4 * whole < areas["heading"] < 0.5 * whole
    assert all(zone.geom_type == "Polygon" for _, zone in found.zones)


def test_zones_are_read_from_files_and_texts(tmp_path):
    (tmp_path / "zone.csv").write_text("x,y\n0,0\n1,0\n1,1\n0,0\n")
    corners = [[0, 0], [1, 0], [1, 1]]
    assert regions.read_zone(str(tmp_path / "zone.csv")).tolist() == corners
    assert regions.read_zone("0,0 1,0 1,1").tolist() == corners


WRONG_REGIONS = {
    "small hole": (["--hole", "0.5", "0.5", "0.01"], "the radius must be at least the element size"),
    "hole outside": (["--hole", "0.1", "0.5", "0.2"], "it must lie in the window"),
    "holes overlap": (["--hole", "0.4", "0.5", "0.1", "--hole", "0.5", "0.5", "0.1"], "from the hole at"),
    "no zone file": (["--zone", "none.csv", "a"], "there is no such file"),
    "two corners": (["--zone", "0,0 1,1", "a"], "a zone needs three corners"),
    "letters": (["--zone", "0,0 1,x 1,1", "a"], "pairs of finite numbers"),
    "zone crosses itself": (["--zone", "0,0 1,1 1,0 0,1", "a"], "crosses itself"),
    "zone outside": (["--zone", "2,2 3,2 3,3", "a"], "nothing of it lies in the window"),
    "zone's name": (["--zone", "0,0 1,0 1,1", "left"], "the name 'left' is taken"),
    "zone twice": (["--zone", "0,0 1,0 1,1", "a", "--zone", "0,0 1,1 0,1", "a"], "the name 'a' is taken"),
    "group's name": (["--group", "hole=0:90"], "the name 'hole' is taken"),
}


@pytest.mark.fast
@pytest.mark.parametrize("case", WRONG_REGIONS)
def test_wrong_holes_and_zones_are_refused(case, tmp_path):
    (tmp_path / "cross.csv").write_text("x1,y1,x2,y2,trace\n0,0,1,1,0\n0,1,1,0,1\n")
    words, said = WRONG_REGIONS[case]
    command = [*MESHER, "cross.csv", "--size", "0.05", *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert said in done.stderr
    assert all(line.startswith("error: ") for line in done.stderr.splitlines())


@pytest.mark.fast
def test_all_wrong_options_of_the_mesher_are_said_at_once(tmp_path):
    words = [
        "none.csv",
        "--size",
        "-1",
        "--group",
        "rock=0:90",
        "--zone",
        "0,0 1,1",
        "a",
        "--zone",
        "none.csv",
        "left",
    ]
    command = [*MESHER, *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    for said in (
        "--size",
        "--group rock",
        "three corners",
        "'left' is taken",
        "no such file",
        "none.csv: cannot be read",
    ):
        assert said in done.stderr, said
    assert all(line.startswith("error: ") for line in done.stderr.splitlines())


@pytest.mark.fast
def test_lost_length_is_warned_of(tmp_path):
    _, fine = clean(read_traces(NETWORK / "two_sets.csv"), feature=0.005)
    assert fine.lost < 0.05
    assert not fine.warnings()
    _, coarse = clean(read_traces(NETWORK / "two_sets.csv"), feature=0.03)
    lost = 1 - coarse.census["cleaned"].length / coarse.census["as read"].length
    assert lost > 0.05
    assert f"warning: cleaning lost {100 * lost:.1f} %" in coarse.text()
    command = [*MESHER, NETWORK / "two_sets.csv", "--size", "0.09"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stderr.startswith("warning: cleaning lost")
    assert "warning" not in done.stdout


BAD = {
    "header": ("x,y,x2,y2,trace\n0,0,1,1,0\n", "the header is"),
    "empty": ("", "the file is empty"),
    "no rows": ("x1,y1,x2,y2,trace\n", "no segments"),
    "number": ("x1,y1,x2,y2,trace\n0,0,1,one,0\n0,0,nan,1,0\n", ":2: y2 = 'one'"),
    "columns": ("x1,y1,x2,y2,trace\n0,0,1,1\n", ":2: 4 values"),
    "outside": ("x1,y1,x2,y2,trace\n5,5,6,6,0\n", "no trace lies in the window"),
    "boundary": ("x1,y1,x2,y2,trace\n0,0,1,0,0\n", "nothing is left"),
    "point": ("x1,y1,x2,y2,trace\n0.5,0.5,0.5,0.5,0\n", "nothing is left"),
}


@pytest.mark.fast
@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_refused_with_their_reason(case, tmp_path):
    (tmp_path / "bad.csv").write_text(BAD[case][0], encoding="utf-8")
    command = [
        *MESHER,
        "bad.csv",
        "--size",
        "0.05",
        "--window",
        "0",
        "0",
        "1",
        "1",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert BAD[case][1] in done.stderr
    assert not list(tmp_path.glob("*.msh"))


@pytest.mark.fast
@pytest.mark.parametrize("text", ["rock=0:90", "set1", "set1=a:b", "=0:90"])
def test_bad_groups_are_refused(text):
    with pytest.raises(TraceError, match="--group"):
        make_mesh.parse_group(text)


def tiny_mesh():
    """Two squares of two triangles, side by side, with the line between them as a fracture."""
    #   3---4---5
    #   | / | / |
    #   0---1---2
    xy = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]], dtype=float)
    triangle = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    line = {"bottom": [[0, 1], [1, 2]], "right": [[2, 5]], "top": [[5, 4], [4, 3]], "left": [[3, 0]]}
    line = {name: np.array(lines) for name, lines in line.items()} | {"fractures": np.array([[1, 4]])}
    return mesh_quality.MeshData(xy, triangle, line)


def complaints(mesh):
    return " ".join(mesh_quality.check_mesh(mesh, (0.0, 0.0, 2.0, 1.0), 1.0, SIDE_NAMES.values()))


@pytest.mark.fast
def test_check_of_the_mesh_finds_what_is_wrong():
    assert complaints(tiny_mesh()) == ""
    mesh = tiny_mesh()
    mesh.triangle[0] = mesh.triangle[0, ::-1]
    assert "turned over" in complaints(mesh)
    mesh = tiny_mesh()
    mesh.triangle = mesh.triangle[:-1]
    assert "area" in complaints(mesh)
    assert "of 1 triangles, 2 expected" in complaints(mesh)
    mesh = tiny_mesh()
    mesh.line["fractures"] = np.array([[1, 3]])
    assert "of 0 triangles, 2 expected" in complaints(mesh)
    mesh = tiny_mesh()
    mesh.xy = np.vstack([mesh.xy, [[1.0, 0.0]]])
    mesh.triangle[2, 0] = 6
    assert "at one place" in complaints(mesh)
    mesh = tiny_mesh()
    mesh.line["set1"] = mesh.line["fractures"]
    assert "and again in" in complaints(mesh)


@pytest.mark.fast
def test_quality_of_known_triangles():
    # Equilateral, and the half square
    xy = np.array([[0, 0], [1, 0], [0.5, 0.75**0.5], [10, 0], [11, 0], [10, 1]])
    quality = mesh_quality.Quality.of(mesh_quality.MeshData(xy, np.array([[0, 1, 2], [3, 4, 5]]), {}))
    assert quality.angle == pytest.approx([60.0, 45.0])
    # Inscribed radius of the half square 1/(2 + sqrt(2)), circumscribed sqrt(2)/2
    assert quality.ratio == pytest.approx([1.0, 2 / (2 + 2**0.5) / (2**0.5 / 2)])
    assert quality.height == pytest.approx([0.75**0.5, 0.5**0.5])
    assert quality.edge == pytest.approx([1.0, 1.0])


# --- the program on meshes of networks -----------------------------------------------------------------------------


FREE = (*SIDE_NAMES.values(), "hole", "hole_1", "hole_2")  # curves that are no fractures


def mesh_file(path):
    """Nodes, triangles and lines {group: lines} of a .msh 4.1 text file, read without gmsh."""
    sections, name = {}, None
    for text in Path(path).read_text(encoding="utf-8").splitlines():
        if text.startswith("$"):
            name = None if text.startswith("$End") else text[1:]
            sections.setdefault(name, [])
        elif name:
            sections[name].append(text.split(maxsplit=2 if name == "PhysicalNames" else -1))
    names = {(int(d), int(tag)): text.strip('"') for d, tag, text in sections["PhysicalNames"][1:]}
    points, curves, _surfaces, _ = (int(n) for n in sections["Entities"][0])
    group = {}
    for row in sections["Entities"][1 + points : 1 + points + curves]:
        if int(row[7]):
            group[int(row[0])] = names[1, int(row[8])]
    place, rows = {}, iter(sections["Nodes"][1:])
    for row in rows:
        tags = [int(next(rows)[0]) for _ in range(int(row[3]))]
        place.update({tag: [float(x) for x in next(rows)[:2]] for tag in tags})
    triangles, lines = [], defaultdict(list)
    rows = iter(sections["Elements"][1:])
    for row in rows:
        elements = [[int(n) for n in next(rows)[1:]] for _ in range(int(row[3]))]
        if int(row[0]) == 2:
            triangles += elements
        elif int(row[0]) == 1:
            lines[group[int(row[1])]] += elements
    return place, triangles, lines


def walk_of_block_edges(place, triangles, lines):
    """Number of lines, length and group of each block edge: lines of fractures joined where two and no more meet."""
    fracture = [(a, b, name) for name, some in lines.items() if name not in FREE for a, b in some]
    times = Counter(frozenset(pair) for a, b, c in triangles for pair in ((a, b), (b, c), (c, a)))
    rim = {n for pair, number in times.items() if number == 1 for n in pair}
    meeting = defaultdict(list)
    for k, (a, b, _) in enumerate(fracture):
        meeting[a].append(k)
        meeting[b].append(k)
    root = list(range(len(fracture)))

    def find(k):
        while root[k] != k:
            root[k] = root[root[k]]
            k = root[k]
        return k

    for node, here in meeting.items():
        if len(here) == 2 and node not in rim and fracture[here[0]][2] == fracture[here[1]][2]:
            root[find(here[0])] = find(here[1])
    found = defaultdict(lambda: [0, 0.0, ""])
    for k, (a, b, name) in enumerate(fracture):
        edge = found[find(k)]
        edge[0] += 1
        edge[1] += float(np.hypot(*np.subtract(place[a], place[b])))
        edge[2] = name
    return list(found.values())


def deck_text(mesh, groups, rocks=("rock",)):
    """A deck with the rock and fractures of the paper's network and one very short stage."""
    joints = [
        f"&joint group='{name}', law='jcm', jrc0=9.7, jcs0_mpa=169, l0=0.2, phi_r=31 /" for name in groups
    ]
    return "\n".join(
        [
            f"&run title='a network', mesh='{mesh}', solver='explicit' /",
            *(f"&material group='{rock}', density=2700, young=30e9, poisson=0.27 /" for rock in rocks),
            *joints,
            "&boundary group='left', vx=0 /",
            "&boundary group='bottom', vy=0 /",
            "&boundary group='right', sxx=5e6, syy=5e6 /",
            "&boundary group='top', sxx=5e6, syy=5e6 /",
            "&stage name='load', move_time=1e-6 /",
        ]
    )


def run_femdem(femdem, folder, *words):
    command = [str(femdem), *words, "deck.nml"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def check_network(femdem, folder, csv, **options):
    """Mesh traces, let the program check and run the mesh, and compare its block edges with the walk's."""
    h5py = pytest.importorskip("h5py")
    words = [str(csv), "--out", str(folder / "mesh.msh"), "--cleaned", str(folder / "cleaned.csv")]
    for name, values in options.items():
        if name in ("window", "hole", "zone"):
            for one in [values] if name == "window" else values:
                words += [f"--{name}", *(str(value) for value in one)]
            continue
        for value in values if isinstance(values, list) else [values]:
            words += [f"--{name.replace('_', '-')}", str(value)]
    text = make_mesh.run(make_mesh.arguments_of(words))
    place, triangles, lines = mesh_file(folder / "mesh.msh")
    groups = [name for name in lines if name not in FREE]
    rocks = ["rock", *(name for _, name in options.get("zone", []))]
    (folder / "deck.nml").write_text(deck_text("mesh.msh", groups, rocks) + "\n", encoding="utf-8")
    run_femdem(femdem, folder, "--check")
    run_femdem(femdem, folder, "--quiet")

    walked = walk_of_block_edges(place, triangles, lines)
    os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
    with h5py.File(folder / "results" / "fields.h5") as file:
        mesh = {name: file["mesh"][name][...] for name in ("block_edge", "joints", "coordinates")}
    ends = mesh["coordinates"][mesh["joints"][:, :2]]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    block_edge = mesh["block_edge"] - mesh["block_edge"].min()
    of_program = np.bincount(block_edge, weights=length)
    assert len(of_program) == len(walked)
    assert sorted(np.bincount(block_edge)) == sorted(n for n, _, _ in walked)
    np.testing.assert_allclose(np.sort(of_program), np.sort([s for _, s, _ in walked]), rtol=1e-10)

    rows = (folder / "results" / "edges.csv").read_text(encoding="utf-8").split()[1:]
    rows = [row.split(",") for row in rows]
    assert Counter((row[1], int(row[2])) for row in rows) == Counter((name, n) for n, _, name in walked)
    # The cleaned traces are written to the nanometre, edges.csv with ten digits
    total = read_traces(folder / "cleaned.csv").length
    assert sum(float(row[3]) for row in rows) == pytest.approx(total, rel=1e-7)
    assert sum(s for _, s, _ in walked) == pytest.approx(of_program.sum(), rel=1e-12)
    xy = np.array([place[n] for n in sorted(place)])
    number = {n: k for k, n in enumerate(sorted(place))}
    corner = np.array([[number[n] for n in one] for one in triangles])
    quality = mesh_quality.Quality.of(mesh_quality.MeshData(xy, corner, {}))
    assert quality.angle.min() > LEAST_ANGLE
    return text, walked


def test_own_network_in_two_groups(femdem, tmp_path):
    _, walked = check_network(
        femdem, tmp_path, NETWORK / "two_sets.csv", size=0.04, group=["set1=80:120", "set2=120:160"]
    )
    assert {name for _, _, name in walked} == {"set1", "set2"}


def test_small_drawings_mesh_and_run(femdem, tmp_path):
    # A corner, a wedge at the boundary, a closed loop, a hairpin, a piece of one element, three through one place
    traces = drawn(
        [(0.0, 0.0), (0.5, 0.5)],
        [(0.2, 0.0), (0.8, 0.02)],
        [(0.7, 0.6), (0.8, 0.6), (0.8, 0.7), (0.7, 0.7), (0.7, 0.6)],
        [(0.1, 0.9), (0.4, 0.9), (0.1, 0.91)],
        [(0.9, 0.4), (0.93, 0.4)],
        [(0.3, 0.5), (0.7, 0.5)],
        [(0.5, 0.3), (0.502, 0.7)],
    )
    write_traces(tmp_path / "drawn.csv", traces)
    check_network(femdem, tmp_path, tmp_path / "drawn.csv", size=0.03, window=[0, 0, 1, 1])


def test_network_with_holes_and_zones(femdem, tmp_path):
    # A band across the window, a block that a fracture ends in, two holes, one of them on the border of the band
    check_network(
        femdem,
        tmp_path,
        NETWORK / "two_sets.csv",
        size=0.04,
        hole=[(1, 1, 0.25), (0.4, 0.3, 0.1)],
        zone=[("0,0.3 2,0.9 2,1.4 0,0.8", "band"), ("1.5,1.5 1.9,1.5 1.9,1.9 1.5,1.9", "block")],
    )


@pytest.mark.fast
def test_stress_around_a_hole_is_that_of_the_closed_form(femdem, tmp_path):
    # A hole in a plate under p from all sides (Kirsch): hoop stress p (1 + a^2/r^2). The plate is a square, so larger
    # by some 2 per cent than in an infinite one; constant strain in elements of a tenth of the radius gives as much
    from femdem.results import Results

    radius, size = 0.1, 0.01
    write_traces(tmp_path / "short.csv", drawn([(-0.95, 0.95), (-0.85, 0.95)]))
    words = ["short.csv", "--size", size, "--window", "-1", "-1", "1", "1", "--hole", "0", "0", radius]
    command = [*MESHER, *map(str, words), "--out", "mesh.msh"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    sides = "".join(f"&boundary group='{side}', sxx=5e6, syy=5e6 /\n" for side in SIDE_NAMES.values())
    deck = deck_text("mesh.msh", ["fractures"]).replace("solver='explicit'", "solver='implicit'").splitlines()
    kept = [line for line in deck if not line.startswith("&boundary")]
    held = "&boundary group='corner_sw', vx=0, vy=0 /\n&boundary group='corner_se', vy=0 /\n"
    (tmp_path / "deck.nml").write_text("\n".join(kept) + "\n" + held + sides, encoding="utf-8")
    run_femdem(femdem, tmp_path, "--quiet")
    fields = Results(tmp_path / "results").fields
    mesh = fields.mesh()
    distance = np.hypot(*mesh.coordinates[mesh.triangles].mean(axis=1).T)
    for inner, outer in ((1.0, 1.2), (1.5, 2.0), (3.0, 4.0)):
        ring = (distance > inner * radius) & (distance < outer * radius)
        expected = 5e6 * (1 + (radius / distance[ring]) ** 2)
        assert fields.read("stress_1")[ring].mean() == pytest.approx(expected.mean(), rel=0.04)


SHARED_CASES = {
    "lilstock_2m": {"size": 0.03},
    "lilstock_2m_all": {"size": 0.03},
    "kb11_10m": {"size": 0.1},
    "lilstock_17x8m": {"size": 0.08},
}
# Counted by those who digitised the maps: tips, abutments, crossings, nodes of five and more branches
PUBLISHED = {"lilstock_2m": (16, 21, 12, 0), "lilstock_2m_all": (0, 101, 32, 5), "kb11_10m": (30, 23, 16, 0)}


def shared(name):
    """A file of outcrop traces; they lie beside the repository and are not part of it."""
    path = SHARED / f"{name}.csv"
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    return path


@pytest.mark.parametrize("name", PUBLISHED)
def test_nodes_of_outcrops_are_found_as_published(name):
    _, report = clean(read_traces(shared(name)))
    assert nodes(report.census["snapped"])[:4] == PUBLISHED[name]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] if "17x8" in name else []) for name in SHARED_CASES]
)
def test_topology_of_outcrops(name, femdem, tmp_path):
    check_network(femdem, tmp_path, shared(name), **SHARED_CASES[name])


def test_outcrop_with_its_smallest_features(femdem, tmp_path):
    # Nothing but snapping: 4 mm branches stay
    check_network(femdem, tmp_path, shared("lilstock_2m_all"), size=0.03, feature=0.001)


@pytest.mark.long
def test_thousand_traces(femdem, tmp_path):
    traces, _ = two_sets(1, 2.0, (100.0, 140.0), 3.0, 0.6, 2.0, 0.05, 1.0, count=1000)
    write_traces(tmp_path / "thousand.csv", traces)
    check_network(femdem, tmp_path, tmp_path / "thousand.csv", size=0.015)


def test_cleaned_networks_are_planar():
    graph, report = clean(read_traces(NETWORK / "two_sets.csv"), feature=0.01)
    assert len(crossings(graph)[0]) == 0
    assert Census.of(graph) == report.census["cleaned"]
