"""In-situ stress: rock and joints that are under stress before anything moves, and a tunnel dug in it."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from femdem.places import module
from femdem.results import History
from test_excavation import EXPLICIT, LARGER, ROCK, SMALLER, Snapshot, across, make_mesh, principal, run
from test_repeat import assert_same, stop_and_go_on

INPUT = Path(__file__).resolve().parent.parent / "input"
NETWORK, TUNNEL = INPUT / "network" / "two_sets.csv", INPUT / "tunnel"
HELD = "&boundary group = 'outer', vx = 0, vy = 0 /\n"
DIG = (
    "&stage name = 'rest', move_time = 0.02 /\n&stage name = 'top', move_time = 0.02, remove = 'heading' /\n"
)
DIG += "&stage name = 'dig', move_time = 0.02, cycles = 2, remove = 'core' /\n"
REST = "&stage name = 'rest', move_time = 0.02 /\n"


def in_situ(angle=0.0):
    """10 and 5 MPa, the larger turned by an angle from x [degrees]."""
    mean, half, twice = 0.5 * (LARGER + SMALLER), 0.5 * (LARGER - SMALLER), np.radians(2 * angle)
    xx, yy, xy = mean + half * np.cos(twice), mean - half * np.cos(twice), half * np.sin(twice)
    return f"&in_situ sxx = {float(xx)!r}, syy = {float(yy)!r}, sxy = {float(xy)!r} /\n"


@pytest.mark.fast
@pytest.mark.parametrize(
    ("solver", "angle"), [("implicit", 0), ("relaxation", 0), ("explicit", 0), ("implicit", 37)]
)
def test_kirsch(solver, angle, femdem, tmp_path):
    """Nothing moves before the tunnel is dug; then the wall moves by all of Kirsch's displacement.

    Measured with 48 elements around the wall and a rigid circle 40 m around: stresses to 0.6 %, displacements to 2.4 and 5.7 %,
    which are -0.7 and 0.0 % with 96 elements, -0.3 and 0.0 % with 192.
    """
    make_mesh(
        tmp_path,
        "--sectors",
        "48",
        "--rings",
        "30",
        "--outer",
        "40",
        *(() if angle else ("--quarter",)),
        "--turn",
        str(angle),
    )
    sides = "" if angle else "&boundary group = 'below', vy = 0 /\n&boundary group = 'left', vx = 0 /\n"
    text = ROCK + HELD + sides + in_situ(angle) + DIG
    if solver == "explicit":
        text = EXPLICIT + text.replace("0.02", "0.02, equilibrium = 1e-4")
    results = run(femdem, tmp_path, text, solver)
    before, after = Snapshot(results, 0), Snapshot(results)
    assert np.abs(before.displacement).max() < 1e-12
    assert principal(before.stress) == pytest.approx(LARGER, rel=1e-12)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, s], [-s, c]])  # into the axes of the stress
    if angle:
        largest = principal(after.stress).max()
        assert largest == pytest.approx(25e6, rel=0.03)
    else:
        radius = np.array([1.0, 1.5, 2.0, 3.0])
        assert across(after, radius, 30, 40.0) == pytest.approx(
            np.array([25.0, 14.8148, 12.3438, 10.9259]) * 1e6, rel=0.01
        )
    moved = [
        turn @ after.displacement_at(place @ turn) for place in (np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    ]
    assert -1e3 * moved[0][0] == pytest.approx(0.5207, rel=0.03)
    assert -1e3 * moved[1][1] == pytest.approx(0.1143, rel=0.06)
    history = History(results / "history.csv")
    assert abs(history["residual_J"][-1]) < 1e-4 * history["strain_J"][-1]


COULOMB = "law = 'coulomb', friction_angle = 35, kn_mpa_mm = 50, ks_mpa_mm = 20, l0 = 1, short_edges = 'l0'"
JCM = "jrc0 = 12, jcs0_mpa = 80, sigma_c_mpa = 100, phi_r = 30, l0 = 0.1"
LAWS = {
    "coulomb": COULOMB,
    "penalty": COULOMB + ", normal = 'penalty'",
    "jcm": JCM,
    "coupled": JCM + ", coupling = 'coupled'",
    "hysteresis": JCM + ", closure_cycle = 'hysteresis'",
    "third": JCM + ", closure_cycle = '3'",
    "walls": JCM + ", normal_stress = 'walls'",
    "dilatant": COULOMB.replace("'coulomb'", "'dilatant_coulomb'")
    + ", dilation_angle = 5, coupling = 'coupled'",
}


@pytest.mark.fast
@pytest.mark.parametrize("law", LAWS)
def test_joints_start_in_balance(law, femdem, tmp_path):
    """A joint at 30 degrees to the larger stress has 6.25 MPa across and 2.165 MPa along it, by whatever law: nothing moves."""
    make_mesh(tmp_path, "--outer", "8", "--rings", "12", "--sectors", "24", "--joint", "--turn", "30")
    results = run(
        femdem, tmp_path, ROCK + HELD + in_situ() + f"&joint group = 'joint', {LAWS[law]} /\n" + REST
    )
    rest = Snapshot(results)
    assert np.abs(rest.displacement).max() < 1e-11
    history = History(results / "history.csv")
    assert history["joint.normal_stress_MPa"][0] == pytest.approx(6.25, rel=1e-9)
    assert history["joint.shear_stress_MPa"][0] == pytest.approx(5 * np.sqrt(3) / 4, rel=1e-9)
    assert "unbalanced force" in (results / "run.log").read_text()


@pytest.mark.fast
def test_a_tunnel_across_a_joint_as_if_it_had_been_loaded(femdem, tmp_path):
    """With a linear joint the way into the stress does not matter: stresses after digging are those of a disc that was loaded."""
    make_mesh(tmp_path, "--outer", "8", "--rings", "12", "--joint", "--turn", "30")
    joint = f"&joint group = 'joint', {COULOMB.replace('35', '60')} /\n&implicit loose_bodies = 'hold' /\n"
    far = f"&boundary group = 'outer', sxx = {LARGER}, syy = {SMALLER} /\n"
    found = [
        Snapshot(run(femdem, tmp_path, ROCK + joint + far + more + DIG, name=name))
        for name, more in (("loaded", ""), ("in_situ", in_situ()))
    ]
    assert found[1].stress == pytest.approx(found[0].stress, abs=5e-4 * LARGER)
    assert found[1].joint_stress == pytest.approx(found[0].joint_stress, abs=5e-4 * LARGER / 1e6)


@pytest.mark.fast
def test_stress_that_grows_with_depth(femdem, tmp_path):
    """Rock under its own weight, with a free surface on top: the vertical stress grows by density times gravity."""
    mesh = Path(__file__).resolve().parent / "scenes" / "_meshes" / "rectangles.py"
    command = [sys.executable, mesh, "--out", tmp_path / "tunnel.msh", "--joint", "rock,0,-40,50,40,5,5"]
    subprocess.run([*command, "rock,0,-50,50,10,5,1"], check=True, timeout=60)
    weight = 2700 * 9.81
    text = ROCK.splitlines()[0] + "\n&gravity gy = -9.81 /\n&output fields_every = 1 /\n"
    text += "".join(
        f"&boundary group = 'rock_{side}', v{'y' if side == 'bottom' else 'x'} = 0 /\n"
        for side in ("bottom", "left")
    )
    text += "&boundary group = 'rock_right', vx = 0 /\n"
    text += f"&in_situ sxx = 0, syy = 0, sxx_gradient = {0.5 * weight}, syy_gradient = {weight} /\n" + REST
    rest = Snapshot(run(femdem, tmp_path, text))
    assert np.abs(rest.displacement).max() < 1e-10
    assert rest.stress[:, 1] == pytest.approx(-weight * rest.centre[:, 1], rel=1e-9)
    assert rest.stress[:, 0] == pytest.approx(-0.5 * weight * rest.centre[:, 1], rel=1e-9)
    # Without the weight it is not in balance, and the log says so
    results = run(femdem, tmp_path, text.replace("gy = -9.81", "gy = 0"), name="light")
    assert "the in-situ stress is not in balance" in (results / "run.log").read_text()


@pytest.mark.fast
def test_rock_that_may_break_holds_it_in_its_bonds(femdem, tmp_path):
    make_mesh(tmp_path, "--outer", "8", "--rings", "6", "--sectors", "24")
    bonds = "&cohesive group = 'all', tensile_strength = 3e6, cohesion = 12e6, friction_angle = 35, g_i = 50, g_ii = 200, "
    bonds += "insertion = 'everywhere' /\n"
    results = run(femdem, tmp_path, ROCK + HELD + in_situ(20) + bonds + REST)
    assert np.abs(Snapshot(results).displacement).max() < 1e-10
    assert len((results / "cracks.csv").read_text().splitlines()) == 1


@pytest.mark.fast
def test_a_network_in_balance(femdem, tmp_path):
    """Where joints cross each wall has the pressure of its own joint up to the crossing: no force is left at any node."""
    mesh = tmp_path / "tunnel.msh"
    command = [*module("femdem.network.make_mesh"), NETWORK, "--size", "0.08", "--out", mesh]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    text = (
        ROCK.splitlines()[0]
        + "\n"
        + in_situ(30)
        + f"&joint group = 'fractures', {COULOMB.replace('35', '70')} /\n"
        + REST
    )
    for side in ("left", "right", "bottom", "top"):
        text += f"&boundary group = '{side}', vx = 0, vy = 0 /\n"
    rest = Snapshot(run(femdem, tmp_path, text))
    assert np.abs(rest.displacement).max() < 1e-10


@pytest.mark.fast
@pytest.mark.parametrize("law", ["jcm", "coupled"])
@pytest.mark.parametrize("solver", ["implicit", "explicit", "relaxation"])
def test_stopped(solver, law, femdem, tmp_path):
    """A run that starts under in-situ stress, in which rock is taken out later, ends with the same bytes when it is stopped, in the
    first stage, where joints too weak for their stress slip, and beyond."""
    make_mesh(tmp_path, "--outer", "8", "--rings", "12", "--sectors", "24", "--joint", "--turn", "30")
    joint = f"&joint group = 'joint', {LAWS[law].replace('phi_r = 30', 'phi_r = 15')} /\n"
    time = "1e-3" if solver == "explicit" else "0.02"
    stages = (
        DIG.replace("0.02 /", "0.02, cycles = 40 /")
        .replace("cycles = 2,", "cycles = 40,")
        .replace("0.02", time)
    )
    text = ROCK + HELD + in_situ() + joint + "&output fields_every = 10 /\n" + stages
    whole = run(femdem, tmp_path, text, solver, name="whole")
    assert "cannot carry their part of the in-situ stress" in (whole / "run.log").read_text()
    stopped = tmp_path / "stopped"
    assert stop_and_go_on(femdem, tmp_path / "whole.nml", stopped, 15) >= 2
    assert_same(whole, stopped, ("history.csv", "edges.csv", "fields.xdmf"))
    one, two = Snapshot(whole), Snapshot(stopped)
    for name in ("stress", "displacement", "joint_stress"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name


WRONG = {
    "no syy": ("&in_situ sxx = 1e6 /\n", "&in_situ syy is missing"),
    "wrong unit": ("&in_situ sxx = 1e13, syy = 0 /\n", "&in_situ sxx = 1e13: must be"),
    "twice": (in_situ() + in_situ(), "&in_situ"),
    "potential": (
        in_situ() + f"&joint group = 'joint', {COULOMB}, contact = 'potential' /\n",
        "cannot start under &in_situ: use 'wall'",
    ),
    "velocity": (
        in_situ() + f"&joint group = 'joint', {COULOMB}, friction = 'velocity' /\n",
        "cannot start under &in_situ: use 'slider'",
    ),
}


@pytest.mark.fast
@pytest.mark.parametrize("name", WRONG)
def test_wrong(name, femdem, tmp_path):
    more, message = WRONG[name]
    make_mesh(tmp_path, "--outer", "8", "--rings", "6", "--sectors", "24", "--joint")
    said = run(femdem, tmp_path, ROCK + HELD + more + REST, "explicit", status=2)
    assert message in said, said


@pytest.mark.fast
def test_a_joint_too_weak_for_it(femdem, tmp_path):
    """A joint with less friction than the stress asks for is named, and slips until the rock holds what it does not."""
    make_mesh(tmp_path, "--outer", "8", "--rings", "12", "--sectors", "24", "--joint", "--turn", "30")
    weak = f"&joint group = 'joint', {COULOMB.replace('35', '10')} /\n"
    results = run(femdem, tmp_path, ROCK + HELD + in_situ() + weak + REST)
    assert "28 of 28 joint elements of 'joint' cannot carry" in (results / "run.log").read_text()
    history = History(results / "history.csv")
    friction = history["joint.shear_stress_MPa"][0] / history["joint.normal_stress_MPa"][0]
    assert friction == pytest.approx(np.tan(np.radians(10)), rel=1e-6)
    assert np.abs(Snapshot(results).displacement).max() > 1e-6


def test_the_shipped_tunnel(femdem, tmp_path):
    """The example, on a coarse mesh: it starts in balance, comes to rest, and its wall is free of normal stress in the mean."""
    command = [
        sys.executable,
        TUNNEL / "make_mesh.py",
        "--out",
        tmp_path / "tunnel.msh",
        "--size",
        "0.9",
        "--p21",
        "0.3",
    ]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    deck = tmp_path / "tunnel.nml"
    deck.write_text(
        (TUNNEL / "tunnel.nml").read_text().replace("cycles = 10", "cycles = 3"), encoding="utf-8"
    )
    results = tmp_path / "out"
    subprocess.run([femdem, "--quiet", "--output", results, deck], check=True, timeout=300)
    before, after = Snapshot(results, 0), Snapshot(results)
    assert np.abs(before.displacement).max() < 1e-9
    assert after.removed > 0
    assert after.joint_removed.any()
    near = np.argsort(np.hypot(*(after.centre - 15.0).T))[:30]
    radial = after.centre[near] - 15.0
    radial /= np.hypot(*radial.T)[:, None]
    xx, yy, xy = after.stress[near].T
    normal = xx * radial[:, 0] ** 2 + yy * radial[:, 1] ** 2 + 2 * xy * radial[:, 0] * radial[:, 1]
    assert abs(normal.mean()) < 0.2 * 7.5e6
