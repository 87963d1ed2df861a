"""Fluid that opens a crack along a given line."""

import numpy as np
import pytest

from flow_grid import Grid, close, run, snapshots, table
from test_repeat import assert_same, stop_and_go_on

RUN = "&run mesh = 'mesh.msh', solver = 'implicit' /\n"
YOUNG, POISSON = 30e9, 0.25
RATE = 1e-5
WIDTH = 0.04
LONGEST = 15
COHESIVE = (
    "&cohesive group = 'rock', curve = '{}', insertion = {}, tensile_strength = 5e6, cohesion = 20e6,"
    " friction_angle = 30, g_i = 30, g_ii = 300 /\n"
)


def half_a_crack(folder, notch=2, longest=LONGEST, extent=4.0, growth=1.5):
    """Rock on one side of a well, with a notch at it and the line that the crack is to take; place of the well.

    notch, longest: elements of the notch, and of notch and line; beyond them elements grow by a factor up to an extent.
    """
    columns = [WIDTH * i for i in range(longest + 1)]
    rows = [WIDTH * i for i in range(4)]
    for lines in (columns, rows):
        step = WIDTH
        while lines[-1] < extent:
            step *= growth
            lines.append(lines[-1] + step)
    rows = np.array([-y for y in rows[:0:-1]] + rows) + rows[-1]
    middle = rows[len(rows) // 2]
    grid = Grid(1.0, 1.0, len(columns) - 1, len(rows) - 1)
    grid.place(columns, rows)
    grid.fracture("notch", (0, middle), (columns[notch], middle))
    grid.fracture("path", (columns[notch], middle), (columns[longest], middle))
    grid.point("well", (0, middle))
    grid.write(folder / "mesh.msh")
    return np.array([0, middle])


def injection(times, steps, curve="path", insertion="'regions'"):
    """Deck: rock of mode-I toughness sqrt(G E/(1 - nu^2)), fluid without viscosity to speak of, half the rate in half the crack."""
    deck = RUN + f"&material group = 'rock', density = 2500, young = {YOUNG}, poisson = {POISSON} /\n"
    deck += (
        "&joint group = 'notch', law = 'coulomb', friction_angle = 30, normal = 'penalty', a0_mm = 0.01 /\n"
    )
    deck += "&boundary group = 'left', vx = 0 /\n&boundary group = 'corner_sw', vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    deck += COHESIVE.format(curve, insertion) + "&fluid viscosity = 1e-6, compressibility = 0 /\n"
    deck += "&flow coupling = 'two-way', permeability = .false., max_passes = 60 /\n"
    deck += f"&transient step = {times[0] / steps}, steps = 'fixed' /\n&flow_boundary group = 'well', rate = {RATE / 2} /\n"
    before = 0.0
    for number, time in enumerate(times):
        deck += f"&stage name = 't{number}', move_time = {time - before}, equilibrium = 1e-6 /\n"
        before = time
    return deck


def test_fluid_opens_a_crack_and_fills_it(femdem, tmp_path):
    well = half_a_crack(tmp_path)
    times = [0.2, 0.5, 1.0]
    x, found_times, found = snapshots(femdem, tmp_path, injection(times, 4))
    assert found_times == close(times, 1e-9)
    place = np.flatnonzero(np.isclose(x, well).all(axis=1))[0]
    lengths, pressures = [], []
    for time, fields in zip(times, found, strict=True):
        conducts = fields["hydraulic_aperture_mm"] > 0
        # What was injected is in what conducts: all of notch and crack, half of it modelled; it was full of fluid at first
        volume = 1e-3 * WIDTH * fields["aperture_mm"][conducts].sum() - 2 * WIDTH * 1e-5
        assert volume == close(RATE / 2 * time, 2e-3)
        # 5/18 of a bond may be left when it counts as broken
        assert (fields["damage"][conducts] > 0.72).all()
        lengths.append(conducts.sum() * WIDTH)
        pressures.append(fields["fluid_pressure"][place])
        # Without viscosity one pressure pushes all of it
        inside = np.isfinite(fields["fluid_pressure"]) & (fields["fluid_pressure"] > 0)
        assert fields["fluid_pressure"][inside] == close(pressures[-1], 1e-2)
    assert lengths[0] == close(2 * WIDTH, 1e-9)
    assert lengths[-1] >= 3 * WIDTH
    assert (np.diff(lengths) >= 0).all()
    rows = table(tmp_path / "results" / "flow.csv")
    assert (abs(rows["imbalance"]) < 1e-3).all()
    # Cracks keep to the line
    with open(tmp_path / "results" / "cracks.csv", encoding="utf-8") as file:
        assert len(file.readlines()) == 1 + round(lengths[-1] / WIDTH) - 2


@pytest.mark.fast
def test_edges_cut_on_the_way_are_filled_and_a_stop_leaves_no_trace(femdem, tmp_path):
    half_a_crack(tmp_path)
    # Coarse elements feel little of the tip: edges are cut at a third of the strength
    deck = injection([0.2, 0.5, 1.0], 4, insertion="'adaptive', insertion_level = 0.3")
    for time in (0.2, 0.3, 0.5):
        deck = deck.replace(f"move_time = {time}, ", f"move_time = {time / 5:g}, cycles = 5, ")
    _, _, found = snapshots(femdem, tmp_path, deck)
    conducts = found[-1]["hydraulic_aperture_mm"] > 0
    assert conducts.sum() > 2
    volume = 1e-3 * WIDTH * found[-1]["aperture_mm"][conducts].sum() - 2 * WIDTH * 1e-5
    assert volume == close(RATE / 2, 1e-4)
    # Edges beside the line feel a third of the strength too
    assert len(found[-1]["damage"]) <= LONGEST
    assert stop_and_go_on(femdem, tmp_path / "deck.nml", tmp_path / "stopped", 3) >= 2
    assert_same(
        tmp_path / "results", tmp_path / "stopped", ("history.csv", "edges.csv", "flow.csv", "cracks.csv")
    )


@pytest.mark.fast
def test_a_line_for_cracks_is_one_of_the_mesh(femdem, tmp_path):
    half_a_crack(tmp_path)
    done = run(femdem, tmp_path, injection([0.2], 4, curve="patj"), "--check")
    assert done.returncode == 2
    assert "did you mean 'path'?" in done.stderr
