"""The same run twice gives the same bits, also one that was stopped on its way and gone on with: nothing in a run depends on
threads, clocks or memory that nobody wrote to, and a checkpoint forgets nothing.

A crack whose matrix (25 000 unknowns) was once ordered by a library that draws lots among its threads, so that no two runs
agreed; a coarse network in rock that breaks; a specimen with joints on every edge; direct shear, whose matrix serves for
hundreds of increments.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import junctions
from femdem.places import module
from femdem.results import History
from flow_grid import Grid
from scene import find_cases, run_case

SCENES = Path(__file__).resolve().parent / "scenes"
SPECIMENS, PRESS = SCENES / "_specimens" / "specimens.py", SCENES / "uniaxial_strength" / "compress.nml"
NETWORK = Path(__file__).resolve().parent.parent / "input" / "network"
CRACKS = (
    "&cohesive group = 'all', tensile_strength = 3e6, cohesion = 8e6, friction_angle = 30, crack_friction_angle = 31, "
    "g_i = 50, g_ii = 200 /\n"
)


def assert_same(one, two, tables):
    for table in tables:
        assert (one / table).read_bytes() == (two / table).read_bytes(), table


def stop_and_go_on(femdem, deck, place, rows):
    """Run a deck, stop it when its history has some rows more, and go on from the checkpoint, until it is done; stops."""
    stops, restart = 0, []
    while True:
        command = [str(word) for word in (femdem, "--quiet", "--output", place, *restart, deck)]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            history, before = place / "history.csv", 0
            while process.poll() is None:
                length = history.read_text().count("\n") if history.exists() else 0
                before = before or length
                if length >= before + rows:
                    process.send_signal(signal.SIGTERM)
                    process.wait(timeout=300)
                time.sleep(0.005)
        if process.returncode == 0:
            return stops
        assert process.returncode == 3
        stops, restart = stops + 1, ["--restart", place / "checkpoint.h5"]


@pytest.mark.parametrize(
    ("name", "rows"), [pytest.param("shear_implicit", 60, marks=pytest.mark.fast), ("relaxation_shear", 10)]
)
def test_shear_that_is_stopped(name, rows, femdem, tmp_path):
    case = next(case for case in find_cases() if case.name == name)
    whole = run_case(case, femdem, tmp_path / "whole")
    stopped = whole.parent / "stopped"
    assert stop_and_go_on(femdem, whole.parent / case.deck, stopped, rows) >= 1
    assert_same(whole, stopped, ("history.csv", "edges.csv"))


@pytest.mark.parametrize(
    ("solver", "law", "rows"),
    [
        pytest.param("implicit", "jcm", 2, marks=pytest.mark.fast),
        ("relaxation", "jcm", 1),
        pytest.param("explicit", "coulomb", 2, marks=pytest.mark.fast),
    ],
)
def test_a_crossing_that_is_stopped(solver, law, rows, femdem, tmp_path):
    """Corners know what they have done in the stage, what they hold and what they press with."""
    scene = junctions.large_slip("X", 75, 0.1, 0.5, cycles=6)
    junctions.run(scene, junctions.VARIANTS["drawn"], tmp_path / "whole", solver, law=law)
    whole, stopped = tmp_path / "whole" / "results", tmp_path / "stopped"
    assert abs(History(whole / "history.csv")["corners_J"][-1]) > 1e-3
    assert stop_and_go_on(femdem, tmp_path / "whole" / "deck.nml", stopped, rows) >= 1
    assert_same(whole, stopped, ("history.csv", "edges.csv"))
    # Also what has no part in these numbers may have one in those of a longer run
    with h5py.File(whole / "checkpoint.h5") as one, h5py.File(stopped / "checkpoint.h5") as other:
        assert set(one) == set(other)
        for name in one:
            assert np.array_equal(one[name][()], other[name][()], equal_nan=True), name


def test_bonds_at_rest_that_are_stopped(femdem, tmp_path):
    """Joints on every edge, most of them far below their strength at any time: what stands for them is found anew."""
    mesher = [sys.executable, SPECIMENS, "rectangle", "--size", "0.1", "--out", tmp_path / "scene.msh"]
    subprocess.run(mesher, check=True, capture_output=True, timeout=120)
    text = PRESS.read_text(encoding="utf-8").replace("cycles = 60", "cycles = 30")
    strength = "tensile_strength = 7e6, cohesion = 15e6"
    assert strength in text
    text = text.replace(strength, "tensile_strength = 2e6, cohesion = 5e6, insertion = 'everywhere'")
    deck = tmp_path / "deck.nml"
    deck.write_text(text, encoding="utf-8")
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    subprocess.run([femdem, "--quiet", "--output", whole, deck], check=True, capture_output=True, timeout=300)
    assert len((whole / "cracks.csv").read_text().splitlines()) > 1
    assert stop_and_go_on(femdem, deck, stopped, 4) >= 2
    assert_same(whole, stopped, ("history.csv", "cracks.csv"))


@pytest.mark.parametrize("text", ["", "insertion = 'everywhere', "], ids=["rock", "bonds"])
def test_threads(text, femdem, tmp_path):
    """Twelve patches of triangles on one thread, and on more than there are cores."""
    mesher = [sys.executable, SPECIMENS, "rectangle", "--size", "0.014", "--out", tmp_path / "scene.msh"]
    subprocess.run(mesher, check=True, capture_output=True, timeout=120)
    deck = PRESS.read_text(encoding="utf-8").replace(
        "cycles = 60, move_time = 3e-4", "cycles = 3, move_time = 2e-5"
    )
    if text:
        deck = deck.replace(
            "tensile_strength = 7e6, cohesion = 15e6", text + "tensile_strength = 2e4, cohesion = 5e4"
        )
        deck = deck.replace(
            "friction_angle = 26.6, g_i = 100, g_ii = 500", "friction_angle = 5, g_i = 1e-3, g_ii = 5e-3"
        )
        assert "g_i = 1e-3" in deck
    else:
        deck = "".join(line for line in deck.splitlines(keepends=True) if not line.startswith("&cohesive"))
    runs = {}
    for threads in (1, 2, 3, 8):
        place = tmp_path / f"of_{threads}"
        (tmp_path / "deck.nml").write_text(
            deck.replace("&run", f"&run threads = {threads},"), encoding="utf-8"
        )
        environment = {**os.environ, "OMP_WAIT_POLICY": "passive"}
        command = [femdem, "--quiet", "--output", place, tmp_path / "deck.nml"]
        subprocess.run(command, check=True, capture_output=True, timeout=300, env=environment)
        runs[threads] = (place / "history.csv").read_bytes()
        if text:
            runs[threads] += (place / "cracks.csv").read_bytes()
            assert runs[threads].count(b"\n") > 5, "nothing has broken"
    assert len(set(runs.values())) == 1


def test_a_closed_crack(femdem, tmp_path):
    case = next(case for case in find_cases() if case.name == "inclined_crack")
    one, two = (run_case(case, femdem, tmp_path / name) for name in ("one", "two"))
    assert_same(one, two, ("history.csv", "edges.csv"))


def test_a_network_that_breaks(femdem, tmp_path):
    mesh = tmp_path / "two_sets.msh"
    command = [
        *module("femdem.network.make_mesh"),
        NETWORK / "two_sets.csv",
        "--size",
        "0.08",
        "--out",
        mesh,
    ]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    text = (NETWORK / "phase_2b.nml").read_text(encoding="utf-8").replace("cycles = 10", "cycles = 3")
    deck = tmp_path / "deck.nml"
    deck.write_text(text + CRACKS, encoding="utf-8")
    one, two, stopped = tmp_path / "one", tmp_path / "two", tmp_path / "stopped"
    for place, threads in ((one, "1"), (two, "3")):
        command = [femdem, "--quiet", "--output", place, deck]
        environment = {**os.environ, "OMP_NUM_THREADS": threads, "OMP_WAIT_POLICY": "passive"}
        subprocess.run(command, check=True, capture_output=True, timeout=300, env=environment)
    assert len((one / "cracks.csv").read_text().splitlines()) > 1
    assert_same(one, two, ("history.csv", "edges.csv", "cracks.csv"))
    assert stop_and_go_on(femdem, deck, stopped, 1) >= 2
    assert_same(one, stopped, ("history.csv", "edges.csv", "cracks.csv"))


@pytest.mark.fast
@pytest.mark.parametrize("time", ["", "&transient step = 1, tolerance = 1e-2 /\n"])
def test_two_way_flow_that_is_stopped(femdem, tmp_path, time):
    grid = Grid(0.4, 0.2, 24, 12)
    grid.fracture("fractures", (0, 0.1), (0.4, 0.1))
    grid.write(tmp_path / "mesh.msh")
    deck = "&run mesh = 'mesh.msh', solver = 'implicit' /\n&flow coupling = 'two-way' /\n" + time
    deck += "&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /\n"
    deck += "&joint group = 'fractures', law = 'jcm', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31, a0_mm = 0.194 /\n"
    deck += "&porous group = 'rock', permeability = 1e-16, biot = 0.7, storage = 1e-11 /\n"
    deck += "&boundary group = 'corner_sw', vx = 0, vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    for side in ("left", "right", "bottom", "top"):
        deck += f"&boundary group = '{side}', stage = 'press', sxx = 5e6, syy = 8e6 /\n"
    deck += "&flow_boundary group = 'left', stage = 'fill', pressure = 3e6 /\n"
    deck += "&flow_boundary group = 'right', stage = 'press', pressure = 0 /\n"
    for stage in ("press", "fill"):
        deck += f"&stage name = '{stage}', cycles = 12, move_time = 10, equilibrium = 1e-6 /\n"
    (tmp_path / "deck.nml").write_text(deck, encoding="utf-8")
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    command = [femdem, "--quiet", "--output", whole, tmp_path / "deck.nml"]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    assert stop_and_go_on(femdem, tmp_path / "deck.nml", stopped, 3) >= 2
    assert_same(whole, stopped, ("history.csv", "edges.csv", "flow.csv", "permeability.csv"))
