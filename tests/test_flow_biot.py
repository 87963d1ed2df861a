"""Flow in time with stress: undrained rock, consolidation, Mandel's plates, joints that give way, injection."""

import math
from itertools import pairwise

import numpy as np
import pytest

from flow_grid import Grid, close, run, snapshots, table

RUN = "&run mesh = 'mesh.msh', solver = 'implicit' /\n"
YOUNG, POISSON, PERMEABILITY, VISCOSITY = 1e9, 0.2, 1e-15, 1e-3
ROCK = f"&material group = 'rock', density = 2000, young = {YOUNG}, poisson = {POISSON} /\n"
SHEAR = YOUNG / 2 / (1 + POISSON)
LAME = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
# Incompressible fluid and grains: nothing is stored at constant strain
DIFFUSIVITY = PERMEABILITY / VISCOSITY * (LAME + 2 * SHEAR)
SOFT = f"&porous group = 'rock', permeability = {PERMEABILITY}, biot = 1, storage = 0 /\n"
TWO_WAY = "&flow coupling = 'two-way', permeability = .false. /\n"
FIXED = "&transient step = {:g}, steps = 'fixed' /\n"
STAGE = "&stage name = '{}', move_time = {:.17g}, equilibrium = 1e-8 /\n"
LOAD = 1e6


@pytest.mark.fast
@pytest.mark.parametrize(("biot", "storage"), [(1.0, 0.0), (1.0, 5e-10), (0.7, 2e-10)])
def test_undrained_rock_has_the_pressure_of_skempton(femdem, tmp_path, biot, storage):
    # Plane strain, s from all sides: the area shrinks by (s - b p)/(lambda + mu), and b times that is S p
    Grid(0.4, 0.2, 8, 4).write(tmp_path / "mesh.msh")
    deck = RUN + ROCK + TWO_WAY + FIXED.format(1) + STAGE.format("load", 1)
    deck += f"&porous group = 'rock', permeability = {PERMEABILITY}, biot = {biot}, storage = {storage} /\n"
    deck += "&boundary group = 'corner_sw', vx = 0, vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    for side in ("left", "right", "bottom", "top"):
        deck += f"&boundary group = '{side}', sxx = {LOAD}, syy = {LOAD} /\n"
    deck = deck.replace("two-way'", "two-way', tolerance = 1e-9")
    _, _, found = snapshots(femdem, tmp_path, deck)
    exact = biot * LOAD / (storage * (LAME + SHEAR) + biot**2)
    # The same from Skempton's B = b/(b^2 + K/M) and Poisson's ratio undrained
    drained = LAME + 2 * SHEAR / 3
    undrained = drained + (biot**2 / storage if storage else 1e9 * drained)
    skempton = (1 - drained / undrained) / biot
    poisson = (3 * undrained - 2 * SHEAR) / (2 * (3 * undrained + SHEAR))
    assert exact == close(skempton * (1 + poisson) / 3 * 2 * LOAD, 1e-7)
    assert found[-1]["fluid_pressure"] == close(exact, 1e-6)
    assert np.ptp(found[-1]["fluid_pressure"]) < 1e-6 * exact


def mandel(time):
    """Pressure at the centre over that at first, and upright strain over load/shear modulus, nu_u = 1/2; dimensionless time."""
    pressure, strain = 0.0, -(1 - POISSON) / 2
    ratio = (1 - POISSON) / (0.5 - POISSON)
    for root in range(200):
        low, high = root * math.pi + 1e-9, (root + 0.5) * math.pi - 1e-9
        for _ in range(80):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if math.tan(middle) < ratio * middle else (low, middle)
        weight = math.sin(low) / (low - math.sin(low) * math.cos(low)) * math.exp(-(low**2) * time)
        pressure += 2 * weight * (1 - math.cos(low))
        strain += 0.5 * weight * math.cos(low)
    return pressure, strain


MANDEL = {0.01: 1.04376, 0.05: 1.09888, 0.1: 1.09541, 0.5: 0.59279, 1.0: 0.25884}
# Ends of the stages, dimensionless
EARLY = (2e-4, 5e-4, 0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.008, 0.01, 0.015, 0.02, 0.03, 0.04, 0.05)
TIMES = [0.0, *EARLY, 0.06, 0.07, 0.08, 0.09, 0.1, *(round(0.1 + 0.05 * i, 2) for i in range(1, 19))]


def mandel_stages(before):
    """Names and lengths of the stages, the load at once in the first; dimensionless."""
    return [(f"s{n}", late - early) for n, (early, late) in enumerate(pairwise([before, *TIMES]))]


def plates(columns, rows, turned=False):
    """Deck of Mandel's rock between plates: the plates move as they do in the closed form, drained at the ends."""
    height = rows / columns
    left, bottom, top, right = (
        ("bottom", "left", "right", "top") if turned else ("left", "bottom", "top", "right")
    )
    x, y = ("vy", "vx") if turned else ("vx", "vy")
    deck = RUN + ROCK + SOFT + TWO_WAY + FIXED.format(5e-3 / DIFFUSIVITY)
    deck += f"&boundary group = '{left}', {x} = 0 /\n&boundary group = '{bottom}', {y} = 0 /\n"
    deck += f"&flow_boundary group = '{right}', stage = 's1', pressure = 0 /\n"
    strain_before = 0.0
    for time, (name, step) in zip(TIMES, mandel_stages(-1e-6), strict=True):
        # At once the rock keeps its volume: half the load is the fluid's
        strain = (mandel(time)[1] if time > 0 else -0.25) * LOAD / SHEAR
        speed = (strain - strain_before) * height / (step / DIFFUSIVITY)
        deck += STAGE.format(name, step / DIFFUSIVITY)
        deck += f"&boundary group = '{top}', stage = '{name}', {y} = {speed:.17g} /\n"
        strain_before = strain
    return deck


def compare_with_mandel(x, found):
    """Pressure at the centre over half the load against the closed form, 1 %."""
    assert mandel(0.05)[0] == close(MANDEL[0.05], 1e-5)
    centre = np.flatnonzero(np.isclose(x, 0.0).all(axis=1))[0]
    for time, reference in MANDEL.items():
        value = found[TIMES.index(time)]["fluid_pressure"][centre] / (0.5 * LOAD)
        assert value == close(reference, 1e-2), time


@pytest.mark.fast
@pytest.mark.parametrize("turned", [False, True])
def test_mandel(femdem, tmp_path, turned):
    size = (0.1, 1.0, 2, 20) if turned else (1.0, 0.1, 20, 2)
    Grid(*size).write(tmp_path / "mesh.msh")
    x, _, found = snapshots(femdem, tmp_path, plates(20, 2, turned))
    assert found[0]["fluid_pressure"] == close(0.5 * LOAD, 1e-6)
    compare_with_mandel(x, found)
    # Drained at once where the fluid has had no time to come from: one node over and under, by no more than this
    early = found[1]["fluid_pressure"] / (0.5 * LOAD)
    assert early.max() < 1.06
    assert early.min() > -1e-9


@pytest.mark.fast
@pytest.mark.parametrize("loaded", [1.0, 0.5])
def test_mandel_under_a_plate_that_carries_the_force(femdem, tmp_path, loaded):
    # A plate 1e4 times as stiff, free to slide on the rock and held upright; where on it the force stands does not matter
    height, thick, stiffness = 0.1, 1.0, 1e12
    grid = Grid(1.0, height + thick, 20, 7)
    grid.place(grid.columns, [0, height / 2, *(height + thick * np.linspace(0, 1, 6))])
    grid.zone = {"plate": lambda _, y: y > height}
    grid.fracture("gap", (0, height), (1, height))
    grid.part_of_side("end", (1, 0), (1, height))
    grid.part_of_side("loaded", (0, height + thick), (loaded, height + thick))
    grid.write(tmp_path / "mesh.msh")
    deck = RUN + ROCK + SOFT + TWO_WAY + FIXED.format(5e-3 / DIFFUSIVITY)
    deck += f"&material group = 'plate', density = 2000, young = {1e4 * YOUNG}, poisson = 0 /\n"
    # Stiff, closed to the fluid at the first touch, next to nothing in shear
    deck += "&joint group = 'gap', law = 'coulomb', friction_angle = 45, ks_mpa_mm = 1e-6, a0_mm = 1e-4"
    deck += f", kn_mpa_mm = {stiffness / 1e9} /\n"
    deck += "&boundary group = 'left', vx = 0 /\n&boundary group = 'bottom', vy = 0 /\n"
    deck += f"&boundary group = 'loaded', stage = 's0', ty = {-LOAD / loaded} /\n"
    deck += "&flow_boundary group = 'end', stage = 's1', pressure = 0 /\n"
    deck += "".join(STAGE.format(name, step / DIFFUSIVITY) for name, step in mandel_stages(-1e-6))
    x, _, found = snapshots(femdem, tmp_path, deck)
    rock = x[:, 1] < 0.75 * height
    assert found[0]["fluid_pressure"][rock] == close(0.5 * LOAD, 5e-3)
    compare_with_mandel(x, found)
    # The plate stays straight, and sinks as that of the closed form, on a gap that gives way to what the fluid does not carry
    plate = x[:, 1] > height + 0.01 * thick
    gap = np.flatnonzero(np.isclose(x[:, 1], height))
    gap = gap[np.argsort(x[gap, 0])]
    for time in (0.0, 0.05, 0.5):
        fields = found[TIMES.index(time)]
        strain = (mandel(time)[1] if time > 0 else -0.25) * LOAD / SHEAR
        closed = (LOAD - np.trapz(fields["fluid_pressure"][gap], x[gap, 0])) / stiffness
        assert fields["displacement"][plate, 1] == close(strain * height - closed, 5e-3), time


@pytest.mark.fast
def test_terzaghi_in_rock_that_deforms(femdem, tmp_path):
    Grid(0.1, 1.0, 2, 20).write(tmp_path / "mesh.msh")
    factors = {0.05: 0.25231, 0.1: 0.35682, 0.2: 0.50409, 0.5: 0.76395}
    deck = RUN + ROCK + SOFT + TWO_WAY + FIXED.format(1e-3 / DIFFUSIVITY)
    deck += "&boundary group = 'left', vx = 0 /\n&boundary group = 'right', vx = 0 /\n&boundary group = 'bottom', vy = 0 /\n"
    deck += f"&boundary group = 'top', stage = 'load', ty = {-LOAD} /\n" + STAGE.format(
        "load", 1e-6 / DIFFUSIVITY
    )
    deck += "&flow_boundary group = 'top', stage = 't0.05', pressure = 0 /\n"
    before = 0.0
    for factor in factors:
        deck += STAGE.format(f"t{factor:g}", (factor - before) / DIFFUSIVITY)
        before = factor
    x, _, found = snapshots(femdem, tmp_path, deck)
    top = np.flatnonzero(np.isclose(x[:, 1], 1.0) & np.isclose(x[:, 0], 0.05))[0]
    settled = LOAD / (LAME + 2 * SHEAR)
    assert found[0]["fluid_pressure"] == close(LOAD, 1e-5)
    for snapshot, (factor, degree) in zip(found[1:], factors.items(), strict=True):
        assert -snapshot["displacement"][top][1] / settled == close(degree, 1e-2), factor
        column = np.isclose(x[:, 0], 0.05)
        order = np.argsort(x[column, 1])
        mean = np.trapz(snapshot["fluid_pressure"][column][order], x[column, 1][order]) / LOAD
        assert 1 - mean == close(degree, 1e-2), factor


def joint_between_blocks(folder, width, length):
    """A joint along the middle of two stiff blocks, with a point at its end."""
    grid = Grid(length, 2 * width, round(length / width), 2)
    grid.fracture("fractures", (0, width), (length, width))
    grid.point("inlet", (0, width))
    grid.point("outlet", (length, width))
    grid.write(folder / "mesh.msh")
    deck = RUN + "&material group = 'rock', density = 2000, young = 1e11, poisson = 0 /\n" + TWO_WAY
    deck += "&joint group = 'fractures', law = 'coulomb', friction_angle = 30, kn_mpa_mm = 1e3, ks_mpa_mm = 1e3, a0_mm = 0.1 /\n"
    deck += "&boundary group = 'bottom', vx = 0, vy = 0 /\n&boundary group = 'top', vx = 0 /\n"
    return deck


@pytest.mark.fast
def test_pressure_diffuses_along_a_joint_whose_walls_give_way(femdem, tmp_path):
    # The walls are the joint's own stiffness, 1e12 Pa/m: what &conduit wall_stiffness says without mechanics
    width = 0.05
    deck = joint_between_blocks(tmp_path, width, 6.0)
    # Under a load, so that the joint stays closed, and drained at its far end
    deck += FIXED.format(1e3) + "&boundary group = 'top', stage = 'press', ty = -1e5 /\n"
    deck += "&flow_boundary group = 'outlet', stage = 'press', pressure = 0 /\n"
    deck += "&flow_boundary group = 'inlet', stage = 'fill', pressure = 1e4 /\n"
    deck += "&stage name = 'press', cycles = 10, move_time = 100, equilibrium = 1e-8 /\n&output fields_every = 10 /\n"
    deck += (
        STAGE.format("fill", 1e-4)
        + "&stage name = 'hold', cycles = 99, move_time = 1e-4, equilibrium = 1e-8 /\n"
    )
    x, _, found = snapshots(femdem, tmp_path, deck)
    place = np.flatnonzero(np.isclose(x, [1.0, width]).all(axis=1))[0]
    assert abs(found[0]["fluid_pressure"][place]) < 50.0
    # p(1 m)/p0 after 10 ms, erfc(x/(2 sqrt(D t)))
    assert found[-1]["fluid_pressure"][place] / 1e4 == close(0.428458, 1e-2)


@pytest.mark.fast
def test_what_is_injected_opens_joint_and_rock(femdem, tmp_path):
    grid = Grid(0.4, 0.2, 16, 8)
    grid.fracture("fractures", (0.1, 0.1), (0.3, 0.1))
    grid.point("well", (0.2, 0.1))
    grid.write(tmp_path / "mesh.msh")
    deck = (
        RUN
        + ROCK
        + "&joint group = 'fractures', law = 'jcm', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31, a0_mm = 0.194 /\n"
    )
    deck += "&boundary group = 'corner_sw', vx = 0, vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    for side in ("left", "right", "bottom", "top"):
        deck += f"&boundary group = '{side}', stage = 'press', sxx = 5e6, syy = 5e6 /\n"
    deck += "&flow coupling = 'two-way', permeability = .false., tolerance = 1e-8 /\n&transient step = 1, tolerance = 1e-2 /\n"
    deck += "&porous group = 'rock', permeability = 1e-15, biot = 0.8, storage = 5e-10 /\n"
    deck += "&flow_boundary group = 'well', stage = 'fill', rate = 1e-6 /\n"
    deck += (
        STAGE.format("press", 1) + "&stage name = 'fill', cycles = 4, move_time = 5, equilibrium = 1e-9 /\n"
    )
    _, _, found = snapshots(femdem, tmp_path, deck)
    rows = table(tmp_path / "results" / "flow.csv")
    # The rate grows over the stage
    assert rows["well.inflow_m2_s"][1:] == close([2.5e-7, 5e-7, 7.5e-7, 1e-6], 1e-12)
    assert (abs(rows["imbalance"]) < 1e-5).all()
    for before, after in zip(found[1:], found[2:], strict=False):
        assert after["fluid_pressure"].mean() > before["fluid_pressure"].mean()
        assert (after["aperture_mm"] > before["aperture_mm"]).all()


@pytest.mark.fast
@pytest.mark.parametrize(
    ("deck", "message"),
    [
        ("&transient step = 1, duration = 3 /\n" + TWO_WAY, "duration has no effect with stages"),
        (
            "&transient step = 1, output_interval = 3 /\n" + TWO_WAY,
            "output_interval has no effect with stages",
        ),
        ("&transient step = 1 /\n&flow /\n", "needs coupling = 'two-way' of &flow"),
        (
            "&transient step = 1 /\n" + TWO_WAY.replace("'two-way'", "'two-way', tolerance = 2"),
            "tolerance = 2",
        ),
        (
            FIXED.format(1) + TWO_WAY + "&stage name = 'rest', move_time = 1, rest_time = 2 /\n",
            "rest_time must be 0",
        ),
        (
            FIXED.format(1) + TWO_WAY + "&conduit group = 'fractures', wall_stiffness = 1e12 /\n",
            "wall_stiffness has no effect with stages",
        ),
    ],
)
def test_wrong_decks_are_told(femdem, tmp_path, deck, message):
    grid = Grid(1.0, 1.0, 4, 4)
    grid.fracture("fractures", (0, 0.5), (1, 0.5))
    grid.write(tmp_path / "mesh.msh")
    joint = "&joint group = 'fractures', law = 'coulomb', friction_angle = 30, kn_mpa_mm = 1, ks_mpa_mm = 1, a0_mm = 0.1 /\n"
    done = run(femdem, tmp_path, RUN + ROCK + SOFT + joint + STAGE.format("a", 1) + deck)
    assert done.returncode == 2
    assert message in done.stderr
