"""Fluid that opens a crack along a given line."""

import numpy as np
import pytest

from cohesive_crack import Rock, cohesive_crack
from flow_grid import close, run, snapshots, table
from fluid_crack import LONGEST, NOTCH_OPEN, POISSON, RATE, WIDTH, YOUNG, half_a_crack, injection
from test_repeat import assert_same, stop_and_go_on


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
        volume = 1e-3 * WIDTH * fields["aperture_mm"][conducts].sum() - 2 * WIDTH * NOTCH_OPEN
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


def test_fluid_in_the_zone_that_softens_drives_a_crack_by_less_pressure(femdem, tmp_path):
    pressures = []
    for enters in (1.0, 0.1):
        folder = tmp_path / str(enters)
        folder.mkdir()
        well = half_a_crack(folder)
        deck = injection([0.5, 1.0], 4).replace("max_passes", f"fluid_enters = {enters}, max_passes")
        # A zone of some three elements
        deck = deck.replace("tensile_strength = 5e6", "tensile_strength = 2e6")
        x, _, found = snapshots(femdem, folder, deck)
        place = np.flatnonzero(np.isclose(x, well).all(axis=1))[0]
        for time, fields in zip((0.5, 1.0), found, strict=True):
            conducts = fields["hydraulic_aperture_mm"] > 0
            if enters < 1.0:
                assert (conducts == (fields["damage"] >= enters)).all()
            volume = 1e-3 * WIDTH * fields["aperture_mm"][conducts].sum() - 2 * WIDTH * NOTCH_OPEN
            assert volume == close(RATE / 2 * time, 2e-3)
        pressures.append(fields["fluid_pressure"][place])
    assert pressures[1] < 0.95 * pressures[0]
    # A stop leaves no trace of what was wet
    deck = deck.replace("move_time = 0.5, ", "move_time = 0.25, cycles = 2, ")
    snapshots(femdem, folder, deck)
    assert stop_and_go_on(femdem, folder / "deck.nml", folder / "stopped", 2) >= 1
    assert_same(
        folder / "results", folder / "stopped", ("history.csv", "edges.csv", "flow.csv", "cracks.csv")
    )


@pytest.mark.fast
def test_the_cohesive_law_alone_goes_over_into_griffith():
    """The reference of the next test: errors fall as the zone over the crack, or as the root of that where the zone is dry"""
    rock, size = Rock(), 0.005
    wet, dry = [], []
    for enters, errors in ((0.1, wet), (0.72, dry)):
        for half_length in (0.2, 0.8):
            opening, pressure, length = cohesive_crack(rock, half_length, size, enters)
            found = np.array([length, opening[0], pressure])
            errors.append(found / rock.griffith(2 * size * opening.sum()) - 1)
    assert wet[0][2] == close(0.037, 0.05)
    assert wet[1] == pytest.approx(0, abs=0.015)
    # The root of four is two
    assert 1.7 < dry[0][2] / dry[1][2] < 2.5 < wet[0][2] / wet[1][2]


@pytest.mark.long
def test_a_crack_that_toughness_holds_back(femdem, tmp_path):
    """KGD, toughness (Detournay 2004): elements of 5 mm, a zone of four of them, a crack of five and of eight zones"""
    rock, size = Rock(YOUNG / (1 - POISSON**2)), 0.005
    times = [(length / rock.griffith(1.0)[0]) ** 1.5 / RATE for length in (0.1, 0.15)]
    well = half_a_crack(tmp_path, size, notch=8, longest=40, extent=2.0, growth=1.3)
    deck = injection(times, 10).replace("max_passes", "fluid_enters = 0.1, max_passes")
    x, _, found = snapshots(femdem, tmp_path, deck, timeout=3000)
    place = np.flatnonzero(np.isclose(x, well).all(axis=1))[0]
    for time, fields, bars in zip(times, found, ((0.051, 0.06, 0.11), (0.034, 0.04, 0.08)), strict=True):
        length = size * (fields["hydraulic_aperture_mm"] > 0).sum()
        opening = 1e-3 * fields["aperture_mm"].max() - NOTCH_OPEN
        pressure = fields["fluid_pressure"][place]
        errors = np.array([length, opening, pressure]) / rock.griffith(RATE * time) - 1
        # An element more or less is 5 and 3 % of the length
        assert (abs(errors) <= bars).all(), errors
        # The same law in rock without a mesh
        assert pressure == close(cohesive_crack(rock, length, size / 2, 0.1)[1], 0.04)


@pytest.mark.fast
@pytest.mark.parametrize("enters", ["0", "1.1", "-0.5"])
def test_fluid_enters_at_a_damage(femdem, tmp_path, enters):
    half_a_crack(tmp_path)
    deck = injection([0.2], 4).replace("max_passes", f"fluid_enters = {enters}, max_passes")
    done = run(femdem, tmp_path, deck, "--check")
    assert done.returncode == 2
    assert f"&flow fluid_enters = {enters}: must be above 0 and at most 1" in done.stderr


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
    volume = 1e-3 * WIDTH * found[-1]["aperture_mm"][conducts].sum() - 2 * WIDTH * NOTCH_OPEN
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
