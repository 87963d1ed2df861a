"""Fluid that opens a crack along a given line."""

import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

from cohesive_crack import Rock, cohesive_crack
from femdem.places import module
from flow_grid import close, run, snapshots, table
from fluid_crack import (
    LONGEST,
    NOTCH_OPEN,
    POISSON,
    RATE,
    WIDTH,
    YOUNG,
    crack_found,
    half_a_crack,
    injection,
    viscous_injection,
    viscous_mesh,
)
from scene import TOP
from test_repeat import assert_same, stop_and_go_on
from viscous_crack import Case, viscous_crack


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
    # Flow through the finished run takes the same cracks for open, with two of three points broken or all
    steady = "".join(
        line
        for line in injection(times, 4).splitlines(keepends=True)
        if not line.startswith(("&transient", "&flow"))
    )
    steady += "&flow permeability = .false. /\n&flow_boundary group = 'well', pressure = 1e6 /\n"
    done = run(femdem, tmp_path, steady, "--flow", "results")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "results" / "flow" / "fields.h5") as file:
        after = [
            file[step]["hydraulic_aperture_mm"][:] > 0 for step in sorted(file) if step.startswith("step_")
        ]
    during = [fields["hydraulic_aperture_mm"] > 0 for fields in found]
    assert any(((fields["damage"] > 0.72) & (fields["damage"] < 1)).any() for fields in found)
    assert all(map(np.array_equal, after, during))
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


def fluid_in(folder, fields):
    """What the nodes hold, where a run has left it (nodes) [m2], for a snapshot, and what is open at them"""
    with h5py.File(folder / "results" / "fields.h5") as file:
        x, joints = file["mesh/coordinates"][:], file["mesh/joints"][:, :2]
    half = 0.5 * np.linalg.norm(x[joints[:, 1]] - x[joints[:, 0]], axis=1)
    conducts = fields["hydraulic_aperture_mm"] > 0
    places, place = np.unique(np.round(x, 9), axis=0, return_inverse=True)
    capacity = np.zeros(len(places))
    for end in (0, 1):
        np.add.at(capacity, place[joints[conducts, end]], (1e-3 * half * fields["aperture_mm"])[conducts])
    saturation = np.zeros(len(places))
    saturation[place] = np.nan_to_num(fields["fluid_saturation"])
    return saturation * capacity, capacity


@pytest.mark.fast
def test_a_viscous_fluid_opens_a_crack(femdem, tmp_path):
    """KGD, viscosity: the similarity solution, and the same laws without a mesh; no fluid is lost, and none pulls"""
    case, times = Case(), [1.25, 2.5]
    well = viscous_mesh(tmp_path, case, 0.9)
    x, _, found = snapshots(femdem, tmp_path, viscous_injection(case, times))
    before = fluid_in(tmp_path, found[1])[0].sum()
    for time, fields, alone in zip(times, found[2:], viscous_crack(case, times), strict=True):
        errors = np.array(crack_found(case, well, x, fields)) / case.similarity(time) - 1
        # An element more or less
        assert (abs(errors) <= [1.01 * case.size / case.similarity(time)[0], 0.04, 0.06]).all(), errors
        beside = np.array(crack_found(case, well, x, fields)) / alone - 1
        assert (abs(beside) <= [1.01 * case.size / alone[0], 0.03, 0.04]).all(), beside
        held, capacity = fluid_in(tmp_path, fields)
        assert held.sum() - before == close(case.rate / 2 * time, 1e-9)
        pressure = fields["fluid_pressure"][np.isfinite(fields["fluid_pressure"])]
        assert pressure.min() >= 0
        assert (held <= 1.001 * capacity + 1e-3 * case.rate * time).all()


@pytest.mark.fast
def test_the_drawing_does_not_matter_to_a_viscous_fluid(femdem, tmp_path):
    """Turned by a right angle, and in half the longest step"""
    case, answers = Case(confined=10e6), []
    turned = {"vx =": "vy =", "vy =": "vx =", "ty = -": "tx = ", "ty = ": "tx = -", "tx = -": "ty = -"}
    for name, angle, longest in (("drawn", 0.0, 0.08), ("turned", 90.0, 0.08), ("half", 0.0, 0.04)):
        folder = tmp_path / name
        folder.mkdir()
        well = viscous_mesh(folder, case, 0.6, angle=angle)
        lines = viscous_injection(case, [1.0], longest).splitlines(keepends=True)
        if angle:
            for number, line in enumerate(lines):
                for before, after in turned.items():
                    if line.startswith("&boundary") and before in line:
                        lines[number] = line.replace(before, after)
                        break
        x, _, found = snapshots(femdem, folder, "".join(lines))
        answers.append(crack_found(case, well, x, found[-1]))
    assert answers[1] == pytest.approx(answers[0], rel=1e-3)
    assert answers[2][1:] == pytest.approx(answers[0][1:], rel=0.03)
    assert abs(answers[2][0] - answers[0][0]) <= 1.01 * case.size


@pytest.mark.fast
def test_fluid_lags_behind_the_tip_where_little_confines_the_rock(femdem, tmp_path):
    case = Case(confined=2e6)
    viscous_mesh(tmp_path, case, 1.2)
    _, _, found = snapshots(femdem, tmp_path, viscous_injection(case, [1.0]))
    held, capacity = fluid_in(tmp_path, found[-1])
    dry = (capacity > 0) & (held < 0.5 * capacity)
    assert dry.sum() >= 2
    with h5py.File(tmp_path / "results" / "fields.h5") as file:
        x = file["mesh/coordinates"][:]
    tip = np.nanmax(np.where(found[-1]["fluid_saturation"] >= 0, x[:, 0], np.nan))
    front = np.nanmax(np.where(found[-1]["fluid_pressure"] > 0, x[:, 0], np.nan))
    assert front < tip - case.size
    assert np.nanmin(found[-1]["fluid_pressure"]) >= 0
    stopped = tmp_path / "stopped"
    deck = viscous_injection(case, [1.0], parts=6)
    snapshots(femdem, tmp_path, deck)
    assert stop_and_go_on(femdem, tmp_path / "deck.nml", stopped, 2) >= 1
    assert_same(tmp_path / "results", stopped, ("history.csv", "edges.csv", "flow.csv", "cracks.csv"))


@pytest.mark.long
def test_a_crack_that_viscosity_holds_back(femdem, tmp_path):
    """KGD, viscosity (Adachi and Detournay 2002): elements of 25 mm, three times: 5 % of all (tests/bench/kgd_viscosity.py)"""
    case, times = Case(size=0.025), [2.5, 5.0, 10.0]
    well = viscous_mesh(tmp_path, case, 2.0)
    x, _, found = snapshots(femdem, tmp_path, viscous_injection(case, times), timeout=3000)
    for time, fields in zip(times, found[2:], strict=True):
        errors = np.array(crack_found(case, well, x, fields)) / case.similarity(time) - 1
        assert (abs(errors) <= 0.05).all(), errors


@pytest.mark.fast
def test_fluid_lag_needs_time_and_rock_that_is_tight(femdem, tmp_path):
    half_a_crack(tmp_path)
    deck = injection([0.2], 4).replace("max_passes", "fluid_lag = .true., max_passes")
    assert run(femdem, tmp_path, deck, "--check").returncode == 0
    steady = "".join(line for line in deck.splitlines(keepends=True) if not line.startswith("&transient"))
    done = run(femdem, tmp_path, steady, "--check")
    assert done.returncode == 2
    assert "fluid_lag = .true. needs coupling = 'two-way' and &transient" in done.stderr
    done = run(femdem, tmp_path, deck + "&porous group = 'rock', permeability = 1e-18 /\n", "--check")
    assert done.returncode == 2
    assert "permeability must be 0 with fluid_lag of &flow" in done.stderr
    done = run(femdem, tmp_path, deck + "&conduit group = 'notch', aperture_mm = 0.1 /\n", "--check")
    assert done.returncode == 2
    assert "aperture_mm must not be given with fluid_lag of &flow" in done.stderr
    for name, below in (("initial_pressure", "&transient initial_pressure = -1,"), ("pressure", None)):
        wrong = (
            deck.replace("&transient", below)
            if below
            else deck.replace(f"rate = {RATE / 2}", "pressure = -1")
        )
        done = run(femdem, tmp_path, wrong, "--check")
        assert done.returncode == 2
        assert f"{name} must be at least 0 with fluid_lag" in done.stderr


@pytest.mark.fast
@pytest.mark.parametrize("confined", [1e6, 20e6])
def test_a_fracture_that_fluid_just_opens(femdem, tmp_path, confined):
    """Fluid carries all that confines the walls, in rock that does not break: they answer as if they were still closed"""
    case = Case(confined=confined)
    viscous_mesh(tmp_path, case, 0.5, 8.0)
    deck = viscous_injection(case, [0.3])
    deck = "".join(line for line in deck.splitlines(keepends=True) if not line.startswith("&cohesive"))
    answers = []
    for lag in ("true", "false"):
        _, _, found = snapshots(femdem, tmp_path, deck.replace("fluid_lag = .true.", f"fluid_lag = .{lag}."))
        answers.append(found[-1])
        if lag == "true":
            assert fluid_in(tmp_path, found[-1])[0].sum() == close(
                0.1 * case.notch_open + case.rate / 2 * 0.301, 1e-9
            )
    for name in ("fluid_pressure", "aperture_mm"):
        assert answers[0][name] == pytest.approx(answers[1][name], rel=2e-3, nan_ok=True), name


@pytest.mark.fast
def test_a_well_draws_no_more_than_there_is(femdem, tmp_path):
    case = Case()
    viscous_mesh(tmp_path, case, 0.5, 8.0)
    deck = viscous_injection(case, [0.3, 0.6]).replace(f"rate = {case.rate / 2}", f"rate = {-case.rate / 2}")
    _, _, found = snapshots(femdem, tmp_path, deck)
    assert np.nanmin(found[-1]["fluid_saturation"]) == pytest.approx(0, abs=1e-3)
    held = [fluid_in(tmp_path, fields)[0].sum() for fields in found[-2:]]
    drawn = table(tmp_path / "results" / "flow.csv")["well.inflow_m2_s"]
    assert drawn[1] == close(-case.rate / 2, 1e-9)
    assert min(np.nanmin(fields["fluid_pressure"]) for fields in found) >= 0
    # What the walls still press out
    assert drawn[-1] == pytest.approx((held[1] - held[0]) / 0.3, abs=1e-3 * case.rate)


@pytest.mark.fast
def test_the_shipped_injection(femdem, tmp_path):
    """Tutorial 6: mesh, run and figure; the crack is as long as the README says, give or take an element"""
    for name in ("make_mesh.py", "injection.nml"):
        shutil.copy(TOP / "input" / "injection" / name, tmp_path)
    mesh = [sys.executable, "make_mesh.py", "--out", "injection.msh"]
    subprocess.run(mesh, cwd=tmp_path, check=True, capture_output=True, timeout=60)
    run_deck = [femdem, "--quiet", "--output", "results", "injection.nml"]
    subprocess.run(run_deck, cwd=tmp_path, check=True, capture_output=True, timeout=300)
    draw = [*module("femdem"), "plot", "injection", "results", "--confined", "20e6", "--out", "crack"]
    said = subprocess.run(draw, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60).stdout
    length = float(said.partition(" s ")[2].partition(" m long")[0])
    assert length == pytest.approx(0.95, abs=0.051)
    assert (tmp_path / "crack.png").stat().st_size > 10000


@pytest.mark.fast
def test_fluid_may_begin_to_lag_where_a_run_without_has_ended(femdem, tmp_path):
    case = Case()
    viscous_mesh(tmp_path, case, 0.5, 8.0)
    deck = viscous_injection(case, [0.3])
    before = "".join(line for line in deck.splitlines(keepends=True) if "name = 't0'" not in line)
    snapshots(femdem, tmp_path, before.replace("fluid_lag = .true.", "fluid_lag = .false."))
    (tmp_path / "results").rename(tmp_path / "before")
    done = run(femdem, tmp_path, deck, "--branch", "before/checkpoint.h5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "results" / "fields.h5") as file:
        last = file[max(name for name in file if name.startswith("step_"))]
        fields = {name: last[name][:] for name in last}
    held = fluid_in(tmp_path, fields)[0].sum()
    assert held == close(0.1 * case.notch_open + case.rate / 2 * 0.301, 1e-3)
