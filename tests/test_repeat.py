"""The same run twice gives the same bits: nothing in a run depends on threads, clocks or memory that nobody wrote to.

A crack whose matrix (25 000 unknowns) was once ordered by a library that draws lots among its threads, so that no two runs
agreed; and a coarse network in rock that breaks.
"""

import subprocess
import sys
from pathlib import Path

from scene import find_cases, run_case

NETWORK = Path(__file__).resolve().parent.parent / "input" / "network"
CRACKS = (
    "&fracture group = 'all', tensile_strength = 3e6, cohesion = 8e6, friction_angle = 30, crack_friction_angle = 31, "
    "g_i = 50, g_ii = 200 /\n"
)


def assert_same(one, two, tables):
    for table in tables:
        assert (one / table).read_bytes() == (two / table).read_bytes(), table


def test_a_closed_crack(femdem, tmp_path):
    case = next(case for case in find_cases() if case.name == "inclined_crack")
    one, two = (run_case(case, femdem, tmp_path / name) for name in ("one", "two"))
    assert_same(one, two, ("history.csv", "edges.csv"))


def test_a_network_that_breaks(femdem, tmp_path):
    mesh = tmp_path / "two_sets.msh"
    command = [
        sys.executable,
        NETWORK / "make_mesh.py",
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
    one, two = tmp_path / "one", tmp_path / "two"
    for place in (one, two):
        command = [femdem, "--quiet", "--output", place, deck]
        subprocess.run(command, check=True, capture_output=True, timeout=300)
    assert len((one / "cracks.csv").read_text().splitlines()) > 1
    assert_same(one, two, ("history.csv", "edges.csv", "cracks.csv"))
