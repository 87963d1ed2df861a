"""Junctions of fractures do not know how their mesh was drawn, and corners do not pass through each other.

tests/junctions.py has the scenes, says how differences and overlaps are measured, and runs more of them.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from shapely.geometry import Point, Polygon

import junctions
from femdem.results import History
from scene import TOP

MAP = TOP / "input" / "network" / "two_sets.csv"
SIZE = 0.05
# Beyond what the changes on either side of 60 degrees explain: on one mesh, with walls that meet alike, below 1e-3
NO_JUMP = 1e-3
# Wall contact against potential contact
CONTACTS = 0.02


def check_rows(rows, edges=None):
    """Every variant as drawn: of the scene's largest to 1e-3; with `edges`, means to 1e-3 and each block edge to that."""
    junctions.print_rows(rows)
    assert not [row["message"] for row in rows if row["message"]]
    for row in rows:
        for quantity in junctions.QUANTITIES:
            over = "scene" if edges is None else "edge"
            off = row[f"{quantity}_{over}"]
            assert off <= (edges or junctions.SAME), f"{row['variant']}: {quantity} differs by {off:.1e}"
        if edges is not None:
            assert row["means"] <= junctions.SAME, f"{row['variant']}: means differ by {row['means']:.1e}"
        assert row["overlap_mm"] <= row["allowed_mm"], f"{row['variant']}: rock in rock"


def check(scene, folder, variants=tuple(junctions.VARIANTS), edges=None, **options):
    rows, _ = junctions.compare(scene, folder, variants, **options)
    check_rows(rows, edges)


@pytest.fixture
def folder(tmp_path, femdem):
    assert femdem.is_file()
    return tmp_path


# The harness itself


@pytest.mark.tools
@pytest.mark.parametrize("kind", junctions.KINDS)
@pytest.mark.parametrize("name", junctions.VARIANTS)
def test_variants_are_the_same_mesh(name, kind):
    variant = junctions.VARIANTS[name]
    scene = junctions.large_slip(kind, 30, 0.1, 1)
    changed = junctions.changed_mesh(scene.mesh, variant)
    assert (junctions.areas(changed.xy, changed.triangles) > 0).all()

    def places(mesh, nodes, matrix):
        """Corners of elements as a set: no number, no order, no rounding"""
        return {frozenset(map(tuple, corners)) for corners in (mesh.xy @ matrix + 0.0)[nodes].tolist()}

    back = variant.array.astype(float)
    as_drawn = np.eye(2)
    assert places(changed, changed.triangles, back) == places(scene.mesh, scene.mesh.triangles, as_drawn)
    for group, lines in scene.mesh.lines.items():
        assert places(changed, changed.lines[group], back) == places(scene.mesh, lines, as_drawn)
    for group, node in scene.mesh.points.items():
        assert places(changed, [[changed.points[group]]], back) == places(scene.mesh, [[node]], as_drawn)
    assert (name == "drawn") == np.array_equal(changed.xy, scene.mesh.xy)


@pytest.mark.tools
def test_loads_turn_with_the_mesh():
    turned = junctions.VARIANTS["turned_90"]
    mirrored = junctions.VARIANTS["mirrored"]
    assert junctions.changed_group({"group": "g", "vx": 2.0}, turned) == {"group": "g", "vy": 2.0}
    assert junctions.changed_group({"group": "g", "vy": 2.0}, turned) == {"group": "g", "vx": -2.0}
    assert junctions.changed_group({"tx": 1.0, "ty": 2.0}, mirrored) == {"tx": -1.0, "ty": 2.0}
    stress = {"sxx": 1.0, "syy": 2.0, "sxy": 3.0}
    assert junctions.changed_group(stress, turned) == {"sxx": 2.0, "syy": 1.0, "sxy": -3.0}
    assert junctions.changed_group(stress, mirrored) == {"sxx": 1.0, "syy": 2.0, "sxy": -3.0}
    assert junctions.changed_group({"pressure": 5.0}, turned) == {"pressure": 5.0}


def blocks_of(mesh, shift, closures):
    """An answer in which what lies right of x = 0 moves by `shift` [m], then by as much again; closures [mm] of the joint."""
    right = mesh.xy[mesh.triangles].mean(axis=1)[:, 0] > 0
    triangles = np.where(right[:, None], mesh.triangles + len(mesh.xy), mesh.triangles)
    line = mesh.xy[mesh.lines["frac"]]
    return junctions.Answer(
        middle=line.mean(axis=1),
        length=np.hypot(*(line[:, 1] - line[:, 0]).T),
        edge=np.zeros(len(line), dtype=int),
        values={},
        xy=np.vstack([mesh.xy, mesh.xy]),
        moved=[np.vstack([mesh.xy, mesh.xy + part * np.array(shift)]) for part in (1, 2)],
        closure=[np.full(len(line), closure) for closure in closures],
        largest_slip=[10.0, 10.0],
        triangles=triangles,
        table={},
    )


@pytest.mark.tools
def test_overlap_is_how_deep_rock_is_in_rock():
    arms = np.array([90.0, 270.0])
    mesh = junctions.junction_mesh(arms, 0.1, cut=True)
    scene = junctions.Scene(mesh, arms, 0.5, [], [], 0.1)
    rock = junctions.overlap(blocks_of(mesh, (-1e-3, 0.0), [0.5, 3.0]), scene)
    # The first snapshot passes what is allowed, 1 % of the slip included; the deeper second one does not
    assert rock.depth == pytest.approx(1.0, rel=1e-9)
    assert rock.allowed == pytest.approx(0.5 + 0.1, rel=1e-9)
    assert rock.area == pytest.approx(1e-3 * 0.8, rel=0.2)  # walls out to 0.8 of the arms, by whole triangles
    rock = junctions.overlap(blocks_of(mesh, (-1e-3, 0.0), [0.5, 0.7]), scene)
    assert rock.depth == pytest.approx(2.0, rel=1e-9)
    apart = junctions.overlap(blocks_of(mesh, (1e-3, 0.0), [0.0, 0.0]), scene)
    assert apart.depth == apart.area == 0.0


@pytest.mark.tools
@pytest.mark.parametrize("turn", [30, 80, 90, 120, 165])
@pytest.mark.parametrize("closure", [(0.07, 0.06), (0.01, 0.06), (0.05, 0.0)])
def test_the_corner_of_a_kink_is_as_deep_as_both_closures_make_it(turn, closure):
    arms = np.array([180.0 - turn, 180.0])
    along = np.stack([np.cos(np.radians(arms)), np.sin(np.radians(arms))], axis=1)
    inward = np.array([[-along[0, 1], along[0, 0]], [along[1, 1], -along[1, 0]]])
    corner = np.linalg.solve(inward, -np.array(closure))
    free = Polygon([(0, 0), *(10 * along).tolist()])
    assert junctions.corner_behind(closure, arms) == pytest.approx(Point(corner).distance(free), rel=1e-9)


@pytest.mark.tools
def test_a_turned_arm_is_where_it_should_be():
    scene = junctions.large_slip("X", 60, 0.1, 1)
    arms = junctions.arms_of("X", 57)
    turned = junctions.turned_arms(scene, arms)
    nodes = np.unique(turned.mesh.lines["frac"])
    nodes = nodes[np.hypot(*turned.mesh.xy[nodes].T) > 1e-9]
    angle = np.degrees(np.arctan2(*turned.mesh.xy[nodes].T[::-1])) % 360
    off = np.abs((angle[:, None] - arms + 180) % 360 - 180).min(axis=1)
    assert off.max() < 1e-9
    assert np.abs(turned.mesh.xy).max() == 0.5


# What the issue asks for

SOME = ("mirrored", "turned_90", "renumbered")
FAST = [("T", 59, 0.0), ("kink", 59, 0.0), ("X", 59, 3.0)]
CASES = list(itertools.product(junctions.KINDS, junctions.ANGLES, (0.0, 3.0)))


def mark_of(case):
    """On either side of 60 degrees, and a sharp one: the others are long, and so are stars that slip far but one."""
    if case in FAST:
        return pytest.param(*case, marks=pytest.mark.fast)
    usual = case[1] in (30, 59, 61) and case not in (("star", 30, 3.0), ("star", 61, 3.0))
    usual = usual or case == ("X", 90, 3.0)
    return case if usual else pytest.param(*case, marks=pytest.mark.long)


@pytest.mark.parametrize(("kind", "angle", "slip"), map(mark_of, CASES))
def test_the_drawing_does_not_matter(kind, angle, slip, folder):
    variants = SOME if slip else tuple(junctions.VARIANTS)
    check(junctions.scene_of(kind, angle, SIZE, slip), folder, variants)


@pytest.mark.fast
@pytest.mark.parametrize(("kind", "angle", "size"), [("X", 90, 0.1), ("star", 75, 0.07)])
def test_far_past_the_peak(kind, angle, size, folder):
    """Whether rest is found at the end of so long an increment is chance: what is too long is cut either way, and half of it
    begins with corners as they were. Apertures differed by 3.6 and 1.3 per cent."""
    check(junctions.scene_of(kind, angle, size, 3.0), folder)


@pytest.mark.parametrize("law", ["jcm_mean", "coulomb"])
@pytest.mark.parametrize(("kind", "slip"), itertools.product(junctions.KINDS, (0.0, 3.0)))
def test_the_drawing_does_not_matter_to_any_law(kind, slip, law, folder):
    # Rounding decides 2e-3 of the aperture of this star with the implicit solver (manual/theory_coupling.md)
    solver = "relaxation" if (kind, slip, law) == ("star", 3.0, "jcm_mean") else "implicit"
    check(junctions.scene_of(kind, 59, SIZE, slip), folder, SOME, law=law, solver=solver)


@pytest.mark.parametrize("kind", junctions.KINDS)
def test_the_drawing_does_not_matter_to_walls_that_ride(kind, folder):
    check(junctions.scene_of(kind, 59, SIZE), folder, coupling="coupled")


@pytest.mark.parametrize("solver", ["relaxation", "explicit"])
@pytest.mark.parametrize(("kind", "angle"), [("T", 59), ("X", 30), ("kink", 59)])
def test_the_drawing_does_not_matter_to_any_solver(kind, angle, solver, folder):
    check(junctions.scene_of(kind, angle, SIZE), folder, SOME, solver=solver)


def mark_far(case):
    return case if case in (("X", 90), ("X", 45)) else pytest.param(*case, marks=pytest.mark.long)


@pytest.mark.parametrize(
    ("kind", "angle"), map(mark_far, [("X", 90), ("X", 45), ("X", 15), ("T", 59), ("kink", 30)])
)
def test_relaxation_slips_as_far_as_the_implicit_solver(kind, angle, folder):
    """Mean aperture to 0.1 %, slip of each block edge to 1 %: both follow the law past its peak in the same increments."""
    scene = junctions.scene_of(kind, angle, SIZE, 3.0)
    implicit, relaxation = (
        junctions.run(scene, junctions.VARIANTS["drawn"], folder / solver, solver)
        for solver in ("implicit", "relaxation")
    )
    apertures = [np.average(one.values["aperture"], weights=one.length) for one in (implicit, relaxation)]
    assert apertures[1] == pytest.approx(apertures[0], rel=1e-3)
    assert junctions.differences(relaxation, implicit)["slip"][1] <= 1e-2


@pytest.mark.long
@pytest.mark.parametrize("law", junctions.LAWS)
@pytest.mark.parametrize("solver", ["relaxation", "explicit"])
@pytest.mark.parametrize(("kind", "angle"), itertools.product(junctions.KINDS, junctions.ANGLES))
def test_the_drawing_does_not_matter_long(kind, angle, solver, law, folder):
    for slip in (0.0, 3.0):
        check(junctions.scene_of(kind, angle, SIZE, slip), folder, solver=solver, law=law)


# The star that slips far takes longest with the JCM
SLOW_JUMP = ("jcm", 3.0, "star")
JUMPS = [
    pytest.param(*case, marks=pytest.mark.long if case == SLOW_JUMP else ())
    for case in itertools.product(("jcm", "coulomb"), (0.0, 3.0), junctions.KINDS)
]


@pytest.mark.parametrize(("law", "slip", "kind"), JUMPS)
def test_no_jump_at_sixty_degrees(law, slip, kind, folder):
    off = junctions.jump(kind, folder, slip, SIZE, law=law)
    print(kind, law, slip, off)
    assert max(off.values()) <= NO_JUMP


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["implicit", "relaxation"])
@pytest.mark.parametrize("angle", [60, 75])
def test_a_drive_cut_into_more_steps(angle, solver, folder):
    """Which corners hold does not depend on how little the first increment drives them (1.4 times the stress once)."""
    found = []
    for cycles in (20, 320):
        scene = junctions.large_slip("X", angle, 0.1, 0.1, cycles=cycles)
        junctions.run(scene, junctions.VARIANTS["drawn"], folder, solver, law="coulomb")
        history = History(folder / "results" / "history.csv")
        names = ("strain_J", "frac.shear_displacement_mm", "frac.shear_stress_MPa", "frac.normal_stress_MPa")
        found.append([history[name][-1] for name in names])
    assert found[1] == pytest.approx(found[0], rel=5e-3)


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["implicit", "relaxation"])
@pytest.mark.parametrize(("kind", "angle", "law"), [("X", 45, "jcm"), ("star", 59, "coulomb")])
def test_a_drive_that_turns(kind, angle, law, solver, folder):
    """Corners that hold since the load let go when the drive is against them: potential contact has no more strain energy. They
    lifted the blocks above once, with 1381 J/m in place of 468 and 2206 in place of 379."""
    scene = junctions.large_slip(kind, angle, SIZE, 0.1)
    scene = replace(scene, stages=[(name, min(count, 8)) for name, count in scene.stages])
    strain = []
    for contact, by in (("wall", solver), ("potential", "relaxation")):
        options = {"options": "&relaxation max_steps = 400000 /"} if by == "relaxation" else {}
        junctions.run(
            scene, junctions.VARIANTS["drawn"], folder / contact, by, law, contact=contact, **options
        )
        strain.append(History(folder / contact / "results" / "history.csv")["strain_J"].max())
    assert strain[0] == pytest.approx(strain[1], rel=0.15)


@pytest.mark.fast
def test_corners_of_a_motion_give_out_no_energy(folder):
    """The explicit solver presses corners back so that the rock follows."""
    found = {}
    for solver in ("implicit", "explicit"):
        scene = junctions.large_slip("X", 75, 0.1, 0.25, cycles=2)
        junctions.run(scene, junctions.VARIANTS["drawn"], folder / solver, solver, law="coulomb")
        found[solver] = History(folder / solver / "results" / "history.csv")
    still, moving = found["implicit"], found["explicit"]
    assert moving["strain_J"][-1] == pytest.approx(still["strain_J"][-1], rel=0.02)
    assert moving["corners_J"].min() > -100  # -12.8 kJ once
    assert moving["damping_J"][-1] < moving["friction_J"][-1]


@pytest.mark.fast
@pytest.mark.parametrize("law", ["jcm", "coulomb"])
def test_corners_do_not_feed_a_motion_that_nothing_damps(law, folder):
    """Loaded in four smooth moves, each followed by 0.2 s of swinging: tens of periods of the slowest motion."""
    scene = junctions.small_slip("X", 75, 0.1)
    junctions.run(scene, junctions.VARIANTS["drawn"], folder, "explicit", law=law, damping="none")
    history = History(folder / "results" / "history.csv")
    work = history["external_J"][-1]
    print(law, history["kinetic_J"].max() / work, history["corners_J"].min() / work)
    assert history["corners_J"].min() >= -1e-5 * work  # -0.3 times the work once
    assert history["kinetic_J"][-1] <= 1e-3 * work  # the run failed once
    assert np.abs(history["residual_J"]).max() <= 1e-4 * work


@pytest.mark.fast
def test_an_abutment_at_58_degrees(folder):
    """Slip of the arms was 0.024, 0.034, 0.027 mm, and 0.006, 0.027, 0.015 when mirrored."""
    check(junctions.abutment(), folder)


@pytest.mark.fast
@pytest.mark.parametrize("size", [0.045, 0.02])
def test_corners_of_crossing_faults(size, folder):
    """Opposite corners overlapped by 0.83 mm at 1.5 mm of slip: now at most by the closure, not even 1 % of the slip."""
    scene = junctions.crossing_faults(size)
    answer = junctions.run(scene, junctions.VARIANTS["drawn"], folder, law=junctions.SOFT)
    rock = junctions.overlap(answer, scene)
    slip = answer.values["slip_size"].max()
    print(
        f"{rock.depth:.3g} mm overlap at {slip:.3g} mm slip; {rock.allowed - junctions.CORNER * slip:.3g} mm closure"
    )
    assert slip > 1.0
    # Opposite corners have two closures between them
    assert rock.allowed < 0.1
    assert rock.depth <= rock.allowed


def walls_over_potential(angle, size, load, folder):
    """Mean slip of the arms of a crossing in wall contact over that in potential contact, springs as stiff as the potential."""
    scene = junctions.small_slip("X", angle, size, stress=(load / 8, load, 0.0))
    means = [
        np.abs(
            junctions.run(
                scene, junctions.VARIANTS["drawn"], folder / contact, solver, junctions.STIFF, contact=contact
            ).of_edges("slip")
        ).mean()
        for contact, solver in (("wall", "implicit"), ("potential", "relaxation"))
    ]
    return means[0] / means[1]


@pytest.mark.parametrize("load", [0.8e6, 8e6])
@pytest.mark.parametrize("angle", [59, 75])
def test_walls_and_potential_of_a_crossing(angle, load, folder):
    """At any load: what corners hold is proportional to it. Crossing faults that slip alike are no such scene: the potential
    lets one of them cut the other (manual/testing.md)."""
    assert walls_over_potential(angle, SIZE, load, folder) == pytest.approx(1, abs=CONTACTS)


@pytest.mark.long
@pytest.mark.parametrize("load", [0.15e6, 1.5e6, 15e6, 30e6])
@pytest.mark.parametrize("size", [0.05, 0.025, 0.0125])
def test_walls_and_potential_of_a_crossing_long(size, load, folder):
    assert walls_over_potential(59, size, load, folder) == pytest.approx(1, abs=CONTACTS)


@pytest.mark.fast
@pytest.mark.parametrize("size", [0.05, 0.025])
def test_slip_of_crossing_faults_is_proportional_to_load(size, folder):
    """It fell from 0.142 to 0.080 mm/MPa with the load: corners passed through each other, the less the more load."""
    slips = [junctions.refined(size, load, "wall", folder / f"{load:g}")["mean"] for load in (0.15e6, 30e6)]
    assert slips[1] == pytest.approx(slips[0], rel=5e-3)


@pytest.mark.parametrize("size", [0.08, pytest.param(0.015, marks=pytest.mark.long)])
@pytest.mark.parametrize("law", [pytest.param("jcm", marks=pytest.mark.fast), "jcm_mean", "coulomb"])
def test_the_drawing_does_not_matter_to_a_network(size, law, folder):
    """Means to 1e-3, every block edge to 1 %."""
    scene = junctions.network(MAP, size, folder)
    check(scene, folder, ["mirrored", "turned_90", "turned_180"], edges=0.01, law=law)
