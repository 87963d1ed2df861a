"""The explicit solver says how far loads that grow fast make the rock swing, and warns: joints that slid with it stay there."""

import re
import subprocess

import pytest

from test_groups import HELD, JOINT, ROCK, RUN, TOP, with_top, wrong_meshes

STAGE = "&stage name = 'load', cycles = 2, move_time = {}, equilibrium = 1e-3, max_rest_time = 1 /\n"
DAMPED = "&explicit damping = 'local', damping_factor = 0.8 /\n"
SAID = r"the rock swung about ([0-9.E+-]+) % further than to rest"


@pytest.mark.fast
@pytest.mark.parametrize(("move_time", "warned"), [("1e-3", True), ("0.5", False)])
def test_overshoot_is_said_and_warned_of(move_time, warned, femdem, tmp_path):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.add(wrong_meshes.LINE, 2, mesh.at(2, 1), mesh.at(3, 1))
    deck = (
        RUN.replace("implicit", "explicit")
        + ROCK.format("rock")
        + JOINT.format("fracture")
        + HELD.format("bottom")
    )
    (tmp_path / "box.msh").write_text(mesh.text())
    (tmp_path / "deck.nml").write_text(deck + TOP + STAGE.format(move_time) + DAMPED)
    done = subprocess.run(
        [femdem, "deck.nml"], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    swung = float(re.search(SAID, done.stdout).group(1))
    # A column of 3 m swings some 900 times a second through its lowest mode: a move of 1 ms is fast, one of 0.5 s slow
    assert (swung > 3) if warned else (0 < swung < 1)
    assert ("loads grew so fast" in done.stderr) == warned
