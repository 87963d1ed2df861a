"""Two-way coupling: the pressure of the fluid pushes walls and rock."""

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

from flow_grid import Grid, run, table

TOP = Path(__file__).resolve().parent.parent
RUN = "&run mesh = 'mesh.msh', solver = 'implicit' /\n"
ROCK = "&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /\n"
JOINT = "&joint group = 'fractures', law = 'jcm', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31, a0_mm = 0.194 /\n"
PRESSED = (
    "&boundary group = 'corner_sw', vx = 0, vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    + "".join(
        f"&boundary group = '{side}', sxx = 5e6, syy = 5e6 /\n" for side in ("left", "right", "bottom", "top")
    )
)
STAGE = "&stage name = '{}', cycles = 4, move_time = 1e-2, equilibrium = 1e-6 /\n"
STAGES = STAGE.format("press") + STAGE.format("fill")
FILLED = "&flow_boundary group = '{}', pressure = {:g}, stage = 'fill' /\n"
TWO_WAY = "&flow coupling = 'two-way', permeability = .false. /\n"


def block(folder):
    grid = Grid(0.4, 0.2, 16, 8)
    grid.fracture("fractures", (0, 0.1), (0.4, 0.1))
    grid.write(folder / "mesh.msh")


def results(femdem, folder, deck, *options):
    """Run; the last snapshot's fields and the history."""
    done = run(femdem, folder, deck, *options)
    assert done.returncode == 0, done.stderr
    with h5py.File(folder / "results" / "fields.h5") as file:
        step = file[sorted(name for name in file if name.startswith("step_"))[-1]]
        fields = {name: step[name][:] for name in step}
        fields["x"] = file["mesh/coordinates"][:]
        fields["joints"] = file["mesh/joints"][:]
    return fields, table(folder / "results" / "history.csv")


@pytest.mark.fast
def test_one_pressure_is_a_prescribed_pore_pressure(femdem, tmp_path):
    block(tmp_path)
    deck = RUN + ROCK + JOINT + PRESSED + STAGES
    known, _ = results(
        femdem, tmp_path, deck + "&pore_pressure group = 'fractures', stage = 'fill', pressure = 2e6 /\n"
    )
    found, _ = results(
        femdem, tmp_path, deck + TWO_WAY + FILLED.format("left", 2e6) + FILLED.format("right", 2e6)
    )
    assert found["normal_stress_MPa"] == pytest.approx(known["normal_stress_MPa"], rel=1e-8)
    assert found["aperture_mm"] == pytest.approx(known["aperture_mm"], rel=1e-8)
    assert found["displacement"] == pytest.approx(
        known["displacement"], abs=1e-8 * abs(known["displacement"]).max()
    )


@pytest.mark.fast
def test_rock_has_the_part_of_biot(femdem, tmp_path):
    block(tmp_path)
    deck = RUN + ROCK + JOINT + PRESSED + STAGES
    pore = "&pore_pressure group = 'all', stage = 'fill', pressure = 2e6, biot = 0.6 /\n"
    known, _ = results(femdem, tmp_path, deck + pore)
    porous = "&porous group = 'rock', permeability = 1e-15, biot = 0.6 /\n"
    filled = "".join(FILLED.format(side, 2e6) for side in ("left", "right"))
    found, _ = results(femdem, tmp_path, deck + TWO_WAY + porous + filled)
    assert found["stress_yy"] == pytest.approx(known["stress_yy"], rel=1e-7)
    assert found["normal_stress_MPa"] == pytest.approx(known["normal_stress_MPa"], rel=1e-7)


@pytest.mark.fast
def test_pressure_and_apertures_agree(femdem, tmp_path):
    block(tmp_path)
    deck = RUN + ROCK + JOINT + PRESSED + STAGES + TWO_WAY
    deck += FILLED.format("left", 4e6) + FILLED.format("right", 0)
    found, history = results(femdem, tmp_path, deck)
    left = found["x"][found["joints"][:, 0], 0]
    order = np.argsort(left)
    aperture = found["aperture_mm"][order]
    ends = found["fluid_pressure"][found["joints"][order, :2]]
    # The same flow through every element: the drop of pressure goes with 1/a^3
    drop = ends[:, 0] - ends[:, 1]
    assert drop * aperture**3 == pytest.approx((drop * aperture**3).mean(), rel=1e-9)
    assert aperture[0] > 1.05 * aperture[-1]
    # What the walls and the fluid carry is the load, 5 MPa over the joint; loads follow the walls a little
    carried = history["fractures.normal_stress_MPa"][-1] + 1e-6 * ends.mean()
    assert carried == pytest.approx(5.0, rel=1e-3)
    row = table(tmp_path / "results" / "flow.csv")
    one_way, _ = results(femdem, tmp_path, deck.replace("two-way", "one-way"))
    before = table(tmp_path / "results" / "flow.csv")
    # Walls that the fluid pushes apart conduct more
    assert row["left.inflow_m2_s"][-1] > 1.1 * before["left.inflow_m2_s"][-1]
    assert one_way["aperture_mm"] == pytest.approx(one_way["aperture_mm"][0], rel=1e-6)


@pytest.mark.fast
def test_a_restart_goes_on_as_if_it_had_not_stopped(femdem, tmp_path):
    block(tmp_path)
    more = STAGE.format("more") + "&boundary group = 'top', stage = 'more', sxx = 5e6, syy = 7e6 /\n"
    more += "&boundary group = 'bottom', stage = 'more', sxx = 5e6, syy = 7e6 /\n"
    start = RUN + ROCK + JOINT + PRESSED + STAGES + TWO_WAY
    start += FILLED.format("left", 3e6) + FILLED.format("right", 0)
    whole, _ = results(femdem, tmp_path, start + more)
    results(femdem, tmp_path, start)
    parts, _ = results(femdem, tmp_path, start + more, "--branch", "results/checkpoint.h5")
    # Pressure and apertures agree to the tolerance of the coupling, and what a restart starts from is that
    assert parts["aperture_mm"] == pytest.approx(whole["aperture_mm"], rel=1e-5)
    assert parts["fluid_pressure"] == pytest.approx(whole["fluid_pressure"], rel=1e-4, abs=1.0, nan_ok=True)


def test_crack_under_pressure(femdem, tmp_path):
    # Half-length a = 0.1 m in a plate of 4 m: w(0) = 4 (1 - nu^2) p a/E, volume pi a w(0)/2
    (tmp_path / "crack.csv").write_text("x1,y1,x2,y2,trace\n-0.1,0,0.1,0,a\n", encoding="utf-8")
    command = [
        TOP / "bin" / "femdem-mesh",
        tmp_path / "crack.csv",
        "--window",
        -2,
        -2,
        2,
        2,
        "--size",
        0.001,
    ]
    command += ["--coarse", 0.1, "--grading", 0.06, "--out", tmp_path / "mesh.msh"]
    subprocess.run([str(word) for word in command], check=True, capture_output=True, timeout=200)
    deck = RUN + ROCK
    deck += "&joint group = 'fractures', law = 'coulomb', friction_angle = 31, normal = 'penalty', a0_mm = 1e-3 /\n"
    deck += "&boundary group = 'corner_sw', vx = 0, vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    deck += "&stage name = 'fill', move_time = 1e-2, equilibrium = 1e-6 /\n" + TWO_WAY
    deck += FILLED.format("fractures", 10e6)
    found, _ = results(femdem, tmp_path, deck)
    ends = found["x"][found["joints"][:, :2]][:, :, 0]
    opening, length = found["opening_mm"], np.abs(ends[:, 1] - ends[:, 0])
    assert opening.max() == pytest.approx(0.123613, rel=1e-2)
    assert 1e-3 * (opening * length).sum() == pytest.approx(1.94171e-5, rel=1e-2)


@pytest.mark.fast
@pytest.mark.parametrize(
    ("deck", "message"),
    [
        ("", "needs a &flow_boundary"),
        (
            FILLED.format("left", 1e6) + "&pore_pressure pressure = 1 /\n",
            "the pressure is found with coupling = 'two-way'",
        ),
        (FILLED.format("left", 1e6).replace("'fill'", "'fil'"), "there is no such stage"),
        (
            (FILLED.format("left", 1e6) + STAGE.format("out")).replace(
                "equilibrium", "remove = 'rock', equilibrium"
            ),
            "does not go with remove of &stage",
        ),
    ],
)
def test_wrong_decks_are_told(femdem, tmp_path, deck, message):
    block(tmp_path)
    done = run(femdem, tmp_path, RUN + ROCK + JOINT + PRESSED + STAGES + TWO_WAY + deck)
    assert done.returncode == 2
    assert message in done.stderr
