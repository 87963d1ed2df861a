"""Flow through fractures and rock against closed forms and references."""

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

from flow_grid import Grid, close, run, table

TOP = Path(__file__).resolve().parent.parent
NETWORK = TOP / "input" / "network"
VISCOSITY, APERTURE = 1e-3, 1e-4
CONDUCTS = APERTURE**3 / (12 * VISCOSITY)
RUN = "&run mesh = 'mesh.msh' /\n&flow /\n"
FRACTURES = "&conduit group = 'fractures', aperture_mm = 0.1 /\n"
THROUGH = (
    "&flow_boundary group = 'left', pressure = {:g} /\n&flow_boundary group = 'right', pressure = {:g} /\n"
)
# Sums of differences of pressures over the network, each with the rounding of the largest pressure
BALANCE = 1e-12
ROUNDING = 1e-10


def flow(femdem, folder, deck):
    """Run a deck of flow; its results directory."""
    done = run(femdem, folder, deck)
    assert done.returncode == 0, done.stderr
    return folder / "results"


def permeability(femdem, folder, deck):
    """Run a deck of flow; the row of permeability.csv."""
    return {name: value[0] for name, value in table(flow(femdem, folder, deck) / "permeability.csv").items()}


@pytest.mark.fast
@pytest.mark.parametrize("rock", [True, False])
def test_one_fracture_conducts_as_the_cubic_law_says(femdem, tmp_path, rock):
    grid = Grid(2.0, 1.0, 8, 4, rock)
    grid.fracture("fractures", (0, 0.5), (2, 0.5))
    grid.write(tmp_path / "mesh.msh")
    results = flow(femdem, tmp_path, RUN + FRACTURES + THROUGH.format(3e4, 1e4))
    row = table(results / "flow.csv")
    assert row["left.inflow_m2_s"][0] == close(CONDUCTS * 2e4 / 2.0, ROUNDING)
    assert abs(row["left.inflow_m2_s"] + row["right.inflow_m2_s"])[0] < BALANCE * row["left.inflow_m2_s"][0]
    found = table(results / "permeability.csv")
    assert found["kx_closed_m2"][0] == close(APERTURE**3 / 12, ROUNDING)
    assert found["kxx_m2"][0] == close(APERTURE**3 / 12, ROUNDING)
    assert found["percolates_y"][0] == 0.0
    assert found["ky_closed_m2"][0] == 0.0
    assert found["kyy_m2"][0] == pytest.approx(0.0, abs=1e-12 * found["kxx_m2"][0])


@pytest.mark.fast
@pytest.mark.parametrize(
    ("angle", "kxx", "kyy", "kxy"),
    [(0.0, 1.66667e-13, 3.33333e-13, 0.0), (30.0, 2.08333e-13, 2.91667e-13, -7.21688e-14)],
)
def test_orthogonal_sets_have_the_tensor_of_their_spacings(femdem, tmp_path, angle, kxx, kyy, kxy):
    grid = Grid(2.0, 2.0, 16, 16)
    for y in (0.25, 0.75, 1.25, 1.75):
        grid.fracture("fractures", (0, y), (2, y))
    for x in np.arange(0.125, 2.0, 0.25):
        grid.fracture("fractures", (x, 0), (x, 2))
    grid.write(tmp_path / "mesh.msh", angle, shift=(5e5, 2e5))
    row = permeability(femdem, tmp_path, RUN + FRACTURES)
    # The references have six digits; exact: a^3/(12 s), turned
    exact = APERTURE**3 / 12 / np.array([0.5, 0.25])
    turn = np.radians(angle)
    axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    tensor = axes @ np.diag(exact) @ axes.T
    found = np.array([[row["kxx_m2"], row["kxy_m2"]], [row["kxy_m2"], row["kyy_m2"]]])
    # The coordinates of a map have eight digits behind the point left
    assert np.allclose(found, tensor, rtol=1e-6, atol=1e-8 * exact.max())
    assert [row["kxx_m2"], row["kyy_m2"]] == close([kxx, kyy], 3e-6)
    assert row["kxy_m2"] == pytest.approx(kxy, rel=3e-6, abs=1e-20)
    assert [row["k1_m2"], row["k2_m2"]] == close(sorted(exact, reverse=True), 1e-6)
    assert abs(row["k1_angle_deg"]) == pytest.approx(90.0 - angle if angle else 90.0, abs=1e-4)
    if angle:
        assert np.isnan(row["kx_closed_m2"])  # no sides along the axes
    else:
        assert [row["kx_closed_m2"], row["ky_closed_m2"]] == close(list(exact), 1e-10)


@pytest.mark.fast
def test_raw_traces_of_two_sets(femdem, tmp_path):
    command = [
        TOP / "bin" / "femdem-numbers",
        NETWORK / "two_sets.csv",
        "--window",
        0,
        0,
        2,
        2,
    ]
    command += ["--lines", tmp_path / "mesh.msh", "--csv", tmp_path / "numbers.csv"]
    subprocess.run([str(word) for word in command], check=True, capture_output=True, timeout=60)
    with open(tmp_path / "numbers.csv", encoding="utf-8") as file:
        numbers = dict(line.strip().split(",") for line in file)
    # The reference is that of coordinates rounded to a micrometre; as they are it is 7.0944612
    assert float(numbers["P21_1_m"]) == close(7.0944614, 1e-7)
    nodes = [int(numbers[name]) for name in ("nodes_I", "nodes_Y", "nodes_X", "nodes_on_boundary")]
    assert nodes == [53, 0, 30, 31]
    row = permeability(femdem, tmp_path, RUN + FRACTURES)
    assert row["kx_closed_m2"] == close(4.9921414e-14, 1e-6)
    assert row["ky_closed_m2"] == close(2.0691222e-14, 1e-6)
    assert row["kxx_m2"] == close(1.2802423e-13, 1e-6)
    assert row["kyy_m2"] == close(5.9052167e-14, 1e-6)
    assert row["kxy_m2"] == close(-6.1839731e-14, 1e-6)
    assert row["imbalance"] < BALANCE
    assert row["parts_left_out"] > 0


@pytest.mark.fast
def test_joint_in_rock_both_conducting_in_parallel_and_in_series(femdem, tmp_path):
    grid = Grid(1.0, 0.5, 8, 4)
    grid.fracture("fractures", (0, 0.25), (1, 0.25))
    grid.write(tmp_path / "mesh.msh")
    rock = "&porous group = 'rock', permeability = 1e-13 /\n"
    row = permeability(femdem, tmp_path, RUN + FRACTURES + rock)
    along = 1e-13 + APERTURE**3 / 12 / 0.5
    assert row["kx_closed_m2"] == close(along, 1e-8)
    # A joint across the flow adds no resistance of its own: its pressure is one
    assert row["ky_closed_m2"] == close(1e-13, 1e-8)
    assert [row["kxx_m2"], row["kyy_m2"]] == close([along, 1e-13], 1e-8)
    assert row["kxy_m2"] == pytest.approx(0.0, abs=1e-8 * along)


@pytest.mark.fast
def test_rocks_in_series_and_a_joint_that_ends_in_rock(femdem, tmp_path):
    grid = Grid(1.0, 0.5, 8, 4)
    grid.zone["tight"] = lambda x, _: x > 0.5
    grid.write(tmp_path / "mesh.msh")
    rock = "&porous group = 'rock', permeability = 4e-13 /\n&porous group = 'tight', permeability = 1e-13 /\n"
    row = permeability(femdem, tmp_path, RUN + rock)
    assert row["kx_closed_m2"] == close(2 / (1 / 4e-13 + 1 / 1e-13), 1e-8)
    assert row["ky_closed_m2"] == close((4e-13 + 1e-13) / 2, 1e-8)
    # Joint and rock one after the other: rock that a joint along its whole width feeds
    grid = Grid(1.0, 0.5, 8, 4)
    grid.zone["closed"] = lambda x, _: x > 0.5
    grid.fracture("fractures", (0.5, 0.0), (0.5, 0.5))
    grid.fracture("fractures", (0.5, 0.25), (1.0, 0.25))
    grid.write(tmp_path / "mesh.msh")
    wide = "&conduit group = 'fractures', aperture_mm = 5 /\n"
    row = permeability(femdem, tmp_path, RUN + wide + "&porous group = 'rock', permeability = 1e-13 /\n")
    # The joint conducts 1e5 times what the rock does: half of the way has no resistance
    assert row["kx_closed_m2"] == close(2e-13, 1e-4)


@pytest.mark.fast
def test_weight_of_the_fluid_at_rest_drives_nothing(femdem, tmp_path):
    grid = Grid(1.0, 1.0, 4, 4)
    grid.fracture("fractures", (0, 0.5), (1, 0.5))
    grid.fracture("fractures", (0.5, 0), (0.5, 1))
    grid.write(tmp_path / "mesh.msh")
    deck = RUN + FRACTURES + "&porous group = 'rock', permeability = 1e-14 /\n&gravity gy = -10 /\n"
    deck += "&fluid density = 1000 /\n"
    deck += "&flow_boundary group = 'left', pressure = 2e4, pressure_dy = -1e4 /\n"
    deck += "&flow_boundary group = 'right', pressure = 2e4, pressure_dy = -1e4 /\n"
    row = table(flow(femdem, tmp_path, deck) / "flow.csv")
    assert abs(row["left.inflow_m2_s"][0]) < 1e-10 * CONDUCTS * 1e4
    with h5py.File(tmp_path / "results" / "fields.h5") as file:
        y = file["mesh/coordinates"][:, 1]
        assert file["step_000001/fluid_pressure"][:] == close(2e4 - 1e4 * y, 1e-9)
        assert abs(file["step_000001/darcy_flux"][:]).max() < 1e-10 * 1e-14 / VISCOSITY * 1e4


@pytest.mark.fast
def test_flux_and_rate_come_out_where_the_pressure_is(femdem, tmp_path):
    grid = Grid(1.0, 1.0, 8, 8)
    grid.fracture("fractures", (0, 0.5), (1, 0.5))
    grid.point("well", (0.25, 0.5))
    grid.write(tmp_path / "mesh.msh")
    deck = RUN + FRACTURES + "&porous group = 'rock', permeability = 1e-14 /\n"
    deck += "&flow_boundary group = 'left', flux = 2e-6 /\n&flow_boundary group = 'well', rate = 3e-6 /\n"
    deck += "&flow_boundary group = 'right', pressure = 1e5 /\n"
    row = table(flow(femdem, tmp_path, deck) / "flow.csv")
    assert row["left.inflow_m2_s"][0] == close(2e-6, 1e-12)
    assert row["well.inflow_m2_s"][0] == close(3e-6, 1e-12)
    assert row["right.inflow_m2_s"][0] == close(-5e-6, BALANCE)


@pytest.mark.fast
def test_parts_without_pressure_are_left_out_and_told(femdem, tmp_path):
    grid = Grid(1.0, 1.0, 8, 8)
    grid.fracture("fractures", (0, 0.5), (1, 0.5))
    grid.fracture("fractures", (0.25, 0.75), (0.75, 0.75))
    grid.point("lost", (0.5, 0.75))
    grid.write(tmp_path / "mesh.msh")
    done = run(femdem, tmp_path, RUN + FRACTURES + THROUGH.format(1e4, 0))
    assert done.returncode == 0, done.stderr
    assert (
        "1 of 2 parts of the network (4 lines) have no way to a prescribed pressure: left out" in done.stdout
    )
    with h5py.File(tmp_path / "results" / "fields.h5") as file:
        pressure = file["step_000001/fluid_pressure"][:]
        y = file["mesh/coordinates"][:, 1]
    assert np.isfinite(pressure[np.isclose(y, 0.5)]).all()
    assert np.isnan(pressure[~np.isclose(y, 0.5)]).all()
    # An inflow into it has nowhere to go
    deck = RUN + FRACTURES + THROUGH.format(1e4, 0) + "&flow_boundary group = 'lost', rate = 1e-6 /\n"
    lost = "&flow_boundary group = 'lost', rate: the node at x = 0.500000, y = 0.750000"
    for options in (["--check"], []):
        done = run(femdem, tmp_path, deck, *options)
        assert done.returncode == 2
        assert lost in done.stderr
    # Nor in a run of stages, whose fractures may open; before the pressure is there it has nowhere to go either
    deck = "&run mesh = 'mesh.msh', solver = 'implicit' /\n&flow /\n" + ROCK + JOINT + pressed()
    deck += "&flow_boundary group = 'corner_sw', pressure = 0, stage = 's10' /\n"
    deck += "&porous group = 'rock', permeability = 1e-15 /\n&flow_boundary group = 'lost', rate = 1e-6, stage = '{}' /\n"
    assert run(femdem, tmp_path, deck.format("s10"), "--check").returncode == 0
    done = run(femdem, tmp_path, deck.format("s5"), "--check")
    assert done.returncode == 2
    assert lost in done.stderr
    # Rock that breaks may join them, and rock that cannot break is dry: it depends on the run
    cohesive = "&cohesive group = 'rock', tensile_strength = 7e6, cohesion = 15e6, friction_angle = 26.6, g_i = 9, g_ii = 9 /\n"
    deck = deck.format("s10").replace("permeability = 1e-15", "permeability = 0")
    assert run(femdem, tmp_path, deck, "--check").returncode == 2
    assert run(femdem, tmp_path, deck + cohesive, "--check").returncode == 0


@pytest.mark.fast
@pytest.mark.parametrize(
    ("deck", "message"),
    [
        ("&flow_boundary group = 'left', flux = 1e-6 /\n", "no &flow_boundary gives a pressure"),
        ("&fluid viscosity = -1e-3 /\n", "viscosity = -1e-3: must be above 0"),
        ("&flow_boundary group = 'left' /\n", "one of pressure, flux and rate must be given"),
        ("&flow_boundary group = 'leff', pressure = 1 /\n", "did you mean 'left'?"),
        ("&porous group = 'left', permeability = 1e-14 /\n", "the mesh has no physical surface of that name"),
        ("&conduit group = 'top' /\n", "aperture_mm is missing"),
        ("&conduit group = 'top', aperture_mm = 1, hydraulic = 'barton' /\n", "jrc is missing"),
        ("&conduit group = 'fractures', aperture_mm = 1 /\n", "was given in line 3 already"),
    ],
)
def test_wrong_decks_of_flow_are_told(femdem, tmp_path, deck, message):
    grid = Grid(1.0, 1.0, 4, 4)
    grid.fracture("fractures", (0, 0.5), (1, 0.5))
    grid.write(tmp_path / "mesh.msh")
    done = run(femdem, tmp_path, RUN + FRACTURES + deck)
    assert done.returncode == 2
    assert message in done.stderr


@pytest.mark.fast
def test_lines_without_rock_need_an_outline(femdem, tmp_path):
    grid = Grid(1.0, 1.0, 4, 4, rock=False)
    grid.fracture("fractures", (0, 0.5), (1, 0.5))
    grid.write(tmp_path / "mesh.msh", angle=30.0)
    done = run(femdem, tmp_path, RUN + FRACTURES)
    assert done.returncode == 2
    assert "must make up a rectangle along the axes" in done.stderr
    # Flow between two sides needs none
    deck = RUN.replace("&flow /", "&flow permeability = .false. /") + FRACTURES + THROUGH.format(2e4, 0)
    row = table(flow(femdem, tmp_path, deck) / "flow.csv")
    assert row["left.inflow_m2_s"][0] == close(CONDUCTS * 2e4, ROUNDING)


@pytest.mark.fast
def test_groups_of_flow_need_flow(femdem, tmp_path):
    Grid(1.0, 1.0, 4, 4).write(tmp_path / "mesh.msh")
    rock = "&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /\n"
    rock += "&stage name = 'a', move_time = 1 /\n"
    done = run(femdem, tmp_path, "&run mesh = 'mesh.msh' /\n" + rock + FRACTURES)
    assert done.returncode == 2
    assert "&conduit has no effect without &flow" in done.stderr


JOINT = "&joint group = 'fractures', law = 'jcm', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31, a0_mm = 0.194 /\n"
ROCK = "&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /\n"
STAGES = (5, 10, 15)


def closed_form_aperture(stress):
    """Aperture of the limestone's joint of 0.2 m, eqs 5 to 7, at a normal stress [MPa]; [m]."""
    initial = 0.194
    stiffness = -7.15 + 1.75 * 9.7 + 0.02 * 169 / initial
    most = -0.1032 - 0.0074 * 9.7 + 1.135 * (169 / initial) ** -0.251
    return 1e-3 * (initial - stress * most / (stiffness * most + stress))


def pressed(stages=STAGES):
    """Boundaries and stages: all sides pressed, the same from all of them [MPa]."""
    text = "&boundary group = 'corner_sw', vx = 0, vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    for stress in stages:
        for side in ("left", "right", "bottom", "top"):
            text += f"&boundary group = '{side}', stage = 's{stress}', sxx = {stress}e6, syy = {stress}e6 /\n"
        text += f"&stage name = 's{stress}', cycles = 4, move_time = 1e-2, equilibrium = 1e-6 /\n"
    return text


@pytest.mark.fast
@pytest.mark.parametrize(
    ("hydraulic", "references"),
    [
        ("equal", (7.6749e-13, 7.3677e-13, 7.2565e-13)),
        ("barton", (1.40446e-13, 1.29428e-13, 1.25550e-13)),
        ("olsson_barton", (1.40446e-13, 1.29428e-13, 1.25550e-13)),  # nothing slips: as barton
    ],
)
def test_parallel_limestone_joints_under_stress(femdem, tmp_path, hydraulic, references):
    grid = Grid(0.2, 0.5, 4, 10)
    grid.fracture("fractures", (0, 0.25), (0.2, 0.25))
    grid.write(tmp_path / "mesh.msh")
    deck = "&run mesh = 'mesh.msh', solver = 'implicit' /\n" + ROCK + JOINT + pressed()
    deck += f"&flow hydraulic = '{hydraulic}' /\n" + THROUGH.format(1e5, 0)
    results = flow(femdem, tmp_path, deck)
    found = table(results / "permeability.csv")
    ends = [np.flatnonzero(found["stage"] == stage)[-1] for stage in (1, 2, 3)]
    apertures = np.array([closed_form_aperture(stress) for stress in STAGES])
    if hydraulic != "equal":
        apertures = 1e6 * apertures**2 / 9.7**2.5
    exact = apertures**3 / 12 / 0.5
    # The references are of apertures with five digits (0.16329 mm for 0.163287 mm at 15 MPa): up to 1.2e-4 in k
    assert exact == close(references, 1.2e-4)
    assert found["kx_closed_m2"][ends] == close(exact, 1e-4)
    assert found["kxx_m2"][ends] == close(exact, 1e-4)
    assert found["stress_yy_MPa"][ends] == close(STAGES, 1e-3)
    assert (found["imbalance"] < BALANCE).all()
    row = table(results / "flow.csv")
    flow_rate = exact * 0.5 * 1e5 / 0.2 / VISCOSITY
    assert row["left.inflow_m2_s"][ends] == close(flow_rate, 1e-4)


SHEARED = (
    "&boundary group = 'bottom', vx = 0, vy = 0 /\n&boundary group = 'top', stage = 'press', ty = -5e6 /\n"
    "&stage name = 'press', cycles = 2, move_time = 1e-2, equilibrium = 1e-6 /\n"
    "&boundary group = 'top', stage = 'shear', vx = 1e-2 /\n"
    "&stage name = 'shear', cycles = 8, move_time = 2e-2, equilibrium = 1e-5 /\n"
)


@pytest.mark.fast
@pytest.mark.parametrize("hydraulic", ["equal", "barton", "olsson_barton"])
def test_a_finished_run_conducts_as_the_run_did(femdem, tmp_path, hydraulic):
    grid = Grid(0.4, 0.2, 8, 4)
    grid.fracture("fractures", (0, 0.1), (0.4, 0.1))
    grid.write(tmp_path / "mesh.msh")
    deck = "&run mesh = 'mesh.msh', solver = 'implicit' /\n" + ROCK + JOINT + SHEARED
    asked = f"&flow hydraulic = '{hydraulic}' /\n" + THROUGH.format(1e5, 0)
    during = flow(femdem, tmp_path, deck + asked + "&output fields_every = 1 /\n")
    known = table(during / "permeability.csv")
    done = run(femdem, tmp_path, deck + asked, "--flow", "results")
    assert done.returncode == 0, done.stderr
    found = table(during / "flow" / "permeability.csv")
    assert found["time_s"] == close(known["time_s"], 1e-9)
    # Slip over peak slip is the run's integral over its steps; from the results it is that of the stress at the snapshot
    tolerance = 1e-9 if hydraulic != "olsson_barton" else 0.05
    assert found["kx_closed_m2"] == close(known["kx_closed_m2"], tolerance)
    assert found["stress_yy_MPa"] == close(known["stress_yy_MPa"], 1e-9)
    with h5py.File(during / "fields.h5") as one, h5py.File(during / "flow" / "fields.h5") as other:
        step = "step_000010"
        along = other[step]["flow_along"][:]
        assert along == close(one[step]["flow_along"][:], tolerance)
        slip = table(during / "history.csv")["fractures.shear_displacement_mm"][-1]
        assert abs(slip) > 0.5  # beyond the peak, so that the formulas differ


@pytest.mark.fast
def test_a_deck_without_flow_writes_nothing_of_it(femdem, tmp_path):
    grid = Grid(0.4, 0.2, 8, 4)
    grid.fracture("fractures", (0, 0.1), (0.4, 0.1))
    grid.write(tmp_path / "mesh.msh")
    deck = "&run mesh = 'mesh.msh', solver = 'implicit' /\n" + ROCK + JOINT + SHEARED
    results = flow(femdem, tmp_path, deck)
    assert not list(results.glob("*flow*")) + list(results.glob("perm*"))
    assert "flow" not in (results / "deck.nml").read_text(encoding="utf-8")
    with h5py.File(results / "fields.h5") as file:
        assert not {"fluid_pressure", "flow_along", "hydraulic_aperture_mm"} & set(file["step_000001"])
    done = run(femdem, tmp_path, deck, "--flow", "results")
    assert done.returncode == 2
    assert "deck.nml has no &flow" in done.stderr
    done = run(femdem, tmp_path, deck + "&flow /\n", "--flow", "results", "--check")
    assert done.returncode == 2
    assert "it goes with none of --restart, --branch and --check" in done.stderr


@pytest.mark.fast
def test_bonds_conduct_when_they_have_broken(femdem, tmp_path):
    grid = Grid(0.2, 0.2, 4, 4)
    grid.zone["weak"] = lambda _, y: abs(y - 0.1) < 0.05
    grid.write(tmp_path / "mesh.msh")
    deck = "&run mesh = 'mesh.msh', solver = 'explicit' /\n" + ROCK + ROCK.replace("'rock'", "'weak'")
    deck += (
        "&cohesive group = 'weak', insertion = 'regions', tensile_strength = 2e6, cohesion = 15e6, friction_angle = 26.6,"
        " g_i = 10, g_ii = 500 /\n"
        "&boundary group = 'bottom', vx = 0, vy = 0 /\n"
        "&boundary group = 'top', stage = 'stretch', vx = 0, vy = 5e-4 /\n"
        "&boundary group = 'top', stage = 'break', vx = 0, vy = 1e-2 /\n"
        "&stage name = 'stretch', move_time = 1e-2, rest_time = 1e-3 /\n"
        "&stage name = 'break', move_time = 1e-2, rest_time = 1e-3 /\n"
        "&explicit damping = 'local' /\n&flow /\n"
    )
    results = flow(femdem, tmp_path, deck)
    found = table(results / "permeability.csv")
    # Bonds that hold have an opening too, of their spring; they conduct nothing
    assert found["parts"][0] == 0
    assert found["kx_closed_m2"][0] == 0.0
    assert list(found["percolates_x"]) == [0.0, 1.0]
    # One straight crack, open by what the top has moved
    opening = 1e-2 * 1e-2 + 5e-4 * 1e-2
    assert found["kx_closed_m2"][1] == close(opening**3 / 12 / 0.2, 1e-4)
    with h5py.File(results / "fields.h5") as file:
        for step in ("step_000001", "step_000002"):
            broken = file[step]["damage"][:] >= 1.0
            conducts = file[step]["hydraulic_aperture_mm"][:] > 0.0
            assert not (conducts & ~broken).any()
            assert (file[step]["aperture_mm"][:][~broken] > 0.0).any()
    # After the run the cracks are found again by their places
    done = run(femdem, tmp_path, deck, "--flow", "results")
    assert done.returncode == 0, done.stderr
    after = table(results / "flow" / "permeability.csv")
    assert after["kx_closed_m2"] == close(found["kx_closed_m2"], 1e-9)
