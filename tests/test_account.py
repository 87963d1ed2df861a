"""The energy account by term: what walls, corners of blocks and other surfaces have of contact and friction."""

import subprocess
import sys

import numpy as np
import pytest

import junctions
from femdem.results import History
from scene import TOP

pytestmark = pytest.mark.fast

# Two blocks with a joint between them, pressed and sheared; beside them a block that falls on another
BLOCKS = ("lower,0,0,0.2,0.1,4,2", "upper,0,0.1,0.2,0.1,4,2")
FALLING = ("floor,1,0,0.2,0.1,4,2", "stone,1.03,0.1001,0.1,0.1,3,3")
DECK = """&run mesh = 'scene.msh', solver = 'explicit' /
&explicit step = 2e-6, damping = 'none' /
&contact friction_angle = 20 /
"""
ROCK = "&material group = '{}', density = 2700, young = 1e9, poisson = 0.2 /\n"
JOINT = "&joint group = 'joint', law = 'coulomb', kn_mpa_mm = 10, ks_mpa_mm = 10, friction_angle = 30, a0_mm = 0.1 /\n"
PRESSED = "&boundary group = 'lower_bottom', vx = 0, vy = 0 /\n&boundary group = 'upper_top', tx = 8e4, ty = -1e5 /\n"
THROWN = (
    "&boundary group = 'floor_bottom', vx = 0, vy = 0 /\n&initial group = 'stone', vx = 0.2, vy = -0.3 /\n"
)
STAGE = "&stage name = 'go', cycles = 5, move_time = 4e-4 /\n"


def parts_agree(history):
    """The three are all of contact and friction."""
    terms = history["walls_J"] + history["corners_J"] + history["surfaces_J"]
    kinds = history["contact_J"] + history["friction_J"]
    assert terms == pytest.approx(kinds, rel=1e-9, abs=1e-11 * np.abs(kinds).max())


def run(femdem, folder, rectangles, deck):
    folder.mkdir()
    make = TOP / "tests" / "scenes" / "_meshes" / "rectangles.py"
    subprocess.run(
        [sys.executable, make, "--out", "scene.msh", "--joint", *rectangles], cwd=folder, check=True
    )
    rock = "".join(ROCK.format(part.split(",")[0]) for part in rectangles)
    (folder / "deck.nml").write_text(DECK + rock + deck + STAGE, encoding="utf-8")
    done = subprocess.run(
        [femdem, "--quiet", "--output", "results", "deck.nml"], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    history = History(folder / "results" / "history.csv")
    parts_agree(history)
    return history


def test_surfaces_beside_walls(femdem, tmp_path):
    """Each has its own work, whatever else is in the scene."""
    alone = run(femdem, tmp_path / "walls", BLOCKS, JOINT + PRESSED)
    stone = run(femdem, tmp_path / "surfaces", FALLING, THROWN)
    both = run(femdem, tmp_path / "both", BLOCKS + FALLING, JOINT + PRESSED + THROWN)
    assert (alone["surfaces_J"] == 0).all()
    assert (stone["walls_J"] == 0).all()
    assert np.abs(stone["surfaces_J"]).max() > 0.01
    assert np.abs(stone["friction_J"]).max() > 0.001
    assert both["walls_J"] == pytest.approx(alone["walls_J"], rel=1e-9, abs=1e-12)
    # Pairs are found in another order, and what sticks and slips moves a little differently
    assert both["surfaces_J"] == pytest.approx(stone["surfaces_J"], rel=1e-4)
    assert (both["corners_J"] == 0).all()


@pytest.mark.parametrize("solver", ["implicit", "relaxation"])
def test_corners_of_a_crossing(solver, femdem, tmp_path):
    """Corners that are pressed together store energy; it is told apart from that of the walls they are ends of."""
    assert femdem.is_file()
    scene = junctions.large_slip("X", 75, 0.1, 0.5, cycles=4)
    junctions.run(scene, junctions.VARIANTS["drawn"], tmp_path, solver, law="coulomb")
    history = History(tmp_path / "results" / "history.csv")
    parts_agree(history)
    assert history["corners_J"][-1] == pytest.approx(1.602, rel=1e-3)
    assert history["surfaces_J"] == pytest.approx(0.0, abs=1e-9)


def test_the_account_of_a_crossing_does_not_know_the_drawing(femdem, tmp_path):
    """The same crossing mirrored, turned and renumbered: what corners store is the same energy."""
    assert femdem.is_file()
    scene = junctions.large_slip("X", 75, 0.1, 0.5, cycles=4)
    of_drawing = {}
    for name in ("drawn", "mirrored", "turned_90", "renumbered"):
        junctions.run(scene, junctions.VARIANTS[name], tmp_path / name, law="coulomb")
        of_drawing[name] = History(tmp_path / name / "results" / "history.csv")
    drawn = of_drawing["drawn"]
    for history in of_drawing.values():
        for term in ("walls_J", "corners_J"):
            assert history[term] == pytest.approx(drawn[term], rel=1e-6, abs=1e-6 * np.abs(drawn[term]).max())
