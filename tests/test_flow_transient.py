"""Flow that changes with time against closed forms: diffusion along a joint, consolidation of rock, filling."""

import math

import numpy as np
import pytest

from flow_grid import Grid, close, run, snapshots, table

VISCOSITY, APERTURE, COMPRESSIBILITY = 1e-3, 1e-4, 4.5e-10
CONDUCTS = APERTURE**3 / (12 * VISCOSITY)
RUN = "&run mesh = 'mesh.msh' /\n&flow permeability = .false. /\n"
PUSHED = 1e6


def pressures(femdem, folder, deck):
    """Run a deck; places of the nodes, times and pressures of the snapshots (times, nodes)."""
    x, times, fields = snapshots(femdem, folder, deck)
    return x, times, np.array([field["fluid_pressure"] for field in fields])


def along_a_joint(femdem, folder, width, length, time, walls=None):
    """Pressure 1 m from the end of a joint that is put under pressure, over that pressure.

    width: of the elements [m]; time: what &transient says of it; walls: their stiffness [Pa/m], rigid for None.
    """
    grid = Grid(length, 2 * width, round(length / width), 2, rock=False)
    grid.fracture("fractures", (0, width), (length, width))
    grid.point("inlet", (0, width))
    grid.write(folder / "mesh.msh")
    stiffness = f", wall_stiffness = {walls:g}" if walls else ""
    deck = RUN + f"&conduit group = 'fractures', aperture_mm = 0.1{stiffness} /\n&transient {time} /\n"
    deck += f"&flow_boundary group = 'inlet', pressure = {PUSHED} /\n"
    x, _, pressure = pressures(femdem, folder, deck)
    place = np.flatnonzero(np.isclose(x[:, 0], 1.0) & np.isclose(x[:, 1], width))
    return pressure[-1][place[0]] / PUSHED


@pytest.mark.fast
@pytest.mark.parametrize(
    ("walls", "time", "width", "length", "steps", "reference"),
    [
        (None, 1e-3, 0.05, 12, 400, 0.603332),
        (None, 1e-2, 0.05, 32, 400, 0.869482),
        (None, 1e-1, 0.1, 96, 400, 0.958559),
        (1e12, 1e-3, 0.02, 3, 800, 0.012280),
        (1e12, 1e-2, 0.05, 8, 400, 0.428458),
        (1e12, 1e-1, 0.05, 22, 400, 0.802278),
    ],
)
def test_pressure_diffuses_along_a_joint(femdem, tmp_path, walls, time, width, length, steps, reference):
    storage = APERTURE * COMPRESSIBILITY + (1 / walls if walls else 0.0)
    exact = math.erfc(1 / (2 * math.sqrt(CONDUCTS / storage * time)))
    assert exact == close(reference, 1e-4)
    settings = f"duration = {time}, step = {time / steps}, steps = 'fixed'"
    assert along_a_joint(femdem, tmp_path, width, length, settings, walls) == close(exact, 1e-2)


@pytest.mark.fast
def test_diffusion_is_of_second_order_in_space_and_first_in_time(femdem, tmp_path):
    def found(width, steps):
        settings = f"duration = 1e-3, step = {1e-3 / steps}, steps = 'fixed'"
        return along_a_joint(femdem, tmp_path, width, 3.0, settings, 1e12)

    # Differences between one element width and the next leave the error of time out, and the other way round
    coarse, middle, fine = (found(width, 100) for width in (0.1, 0.05, 0.025))
    assert (coarse - middle) / (middle - fine) == pytest.approx(4.0, abs=0.2)
    coarse, middle, fine = (found(0.05, steps) for steps in (100, 200, 400))
    assert (coarse - middle) / (middle - fine) == pytest.approx(2.0, abs=0.1)


@pytest.mark.fast
def test_adaptive_steps_reach_the_same_with_fewer(femdem, tmp_path):
    exact = math.erfc(1 / (2 * math.sqrt(CONDUCTS / (APERTURE * COMPRESSIBILITY) * 1e-2)))
    settings = "duration = 1e-2, step = 1e-6, tolerance = 1e-3, output_interval = 5e-3"
    assert along_a_joint(femdem, tmp_path, 0.05, 32, settings) == close(exact, 3e-3)
    steps = table(tmp_path / "results" / "flow.csv")["step"]
    assert len(steps) == 2
    assert 20 < steps[-1] < 300  # 1e4 of the first


@pytest.mark.fast
def test_rock_consolidates_as_terzaghi_says(femdem, tmp_path):
    # A column drained at its top: 1 - mean pressure over the first is the degree of consolidation
    permeability, storage, height = 1e-15, 1e-10, 1.0
    diffusivity = permeability / VISCOSITY / storage
    Grid(0.1, height, 2, 40).write(tmp_path / "mesh.msh")
    deck = RUN + f"&porous group = 'rock', permeability = {permeability}, storage = {storage} /\n"
    deck += "&flow_boundary group = 'top', pressure = 0 /\n"
    end = 0.5 * height**2 / diffusivity
    deck += (
        f"&transient duration = {end}, step = {end / 1000}, steps = 'fixed', output_interval = {end / 10}, "
    )
    deck += "initial_pressure = 1e6 /\n"
    x, times, pressure = pressures(femdem, tmp_path, deck)
    middle = np.isclose(x[:, 0], 0.05)
    order = np.argsort(x[middle, 1])
    mean = np.array([np.trapz(row[middle][order], x[middle, 1][order]) for row in pressure]) / height / 1e6
    degree = dict(zip(np.round(times * diffusivity / height**2, 6), 1 - mean, strict=True))
    for factor, reference in ((0.05, 0.25231), (0.1, 0.35682), (0.2, 0.50409), (0.5, 0.76395)):
        assert degree[factor] == close(reference, 1e-2)


@pytest.mark.fast
def test_what_is_injected_is_there(femdem, tmp_path):
    grid = Grid(2.0, 0.5, 16, 4)
    grid.fracture("fractures", (0, 0.25), (2, 0.25))
    grid.point("well", (0.5, 0.25))
    grid.write(tmp_path / "mesh.msh")
    deck = RUN + "&conduit group = 'fractures', aperture_mm = 0.1, wall_stiffness = 1e12 /\n"
    deck += "&porous group = 'rock', permeability = 1e-14, storage = 1e-11 /\n"
    deck += "&flow_boundary group = 'well', rate = 1e-6 /\n&transient duration = 10, step = 1e-2 /\n"
    x, _, pressure = pressures(femdem, tmp_path, deck)
    assert np.isfinite(pressure[-1]).all()
    # No way out: fluid of 10 s in the storage of joint and rock, at nearly one pressure
    stored = 2.0 * (APERTURE * COMPRESSIBILITY + 1e-12) + 1.0 * 1e-11
    assert pressure[-1].mean() == close(1e-5 / stored, 1e-3)
    row = table(tmp_path / "results" / "flow.csv")
    assert row["well.inflow_m2_s"][-1] == close(1e-6, 1e-12)
    assert abs(row["imbalance"][-1]) < 1e-10
    assert len(x) == pressure.shape[1]


@pytest.mark.fast
def test_it_ends_in_steady_flow(femdem, tmp_path):
    grid = Grid(2.0, 1.0, 16, 8)
    grid.fracture("fractures", (0, 0.5), (1.5, 0.5))
    grid.write(tmp_path / "mesh.msh")
    deck = RUN + "&conduit group = 'fractures', aperture_mm = 0.1 /\n"
    deck += "&porous group = 'rock', permeability = 1e-13, storage = 1e-11 /\n"
    deck += (
        "&flow_boundary group = 'left', pressure = 2e5 /\n&flow_boundary group = 'right', pressure = 1e5 /\n"
    )
    _, _, steady = pressures(femdem, tmp_path, deck)
    _, _, last = pressures(femdem, tmp_path, deck + "&transient duration = 100, step = 1e-3 /\n")
    assert last[-1] == close(steady[-1], 1e-6)


@pytest.mark.fast
@pytest.mark.parametrize(
    ("deck", "message"),
    [
        ("&transient duration = 1 /\n", "step is missing"),
        ("&transient duration = 1, step = -1 /\n", "step = -1: must be above 0"),
        ("&transient duration = 1, step = 0.1 /\n", "there is no &flow_boundary"),
    ],
)
def test_wrong_decks_are_told(femdem, tmp_path, deck, message):
    Grid(1.0, 1.0, 4, 4).write(tmp_path / "mesh.msh")
    done = run(
        femdem,
        tmp_path,
        "&run mesh = 'mesh.msh' /\n&flow /\n&porous group = 'rock', permeability = 1e-15 /\n" + deck,
    )
    assert done.returncode == 2
    assert message in done.stderr
