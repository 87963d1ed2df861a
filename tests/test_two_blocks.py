"""The deck and meshes of tutorial 4: the example of the input reference is that deck, and both ways to its mesh are good."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from femdem.results import Results

TOP = Path(__file__).resolve().parent.parent
BLOCKS = TOP / "input" / "two_blocks"

pytestmark = pytest.mark.fast


@pytest.fixture(params=["script", "geo"])
def blocks(request, tmp_path):
    """The deck with a mesh made by the script, or by gmsh from its own language"""
    shutil.copytree(BLOCKS, tmp_path, dirs_exist_ok=True)
    commands = {
        "script": [sys.executable, "make_mesh.py", "--size", "0.01"],
        "geo": ["gmsh", "-2", "-format", "msh41", "two_blocks.geo"],
    }
    subprocess.run(commands[request.param], cwd=tmp_path, check=True, capture_output=True)
    return tmp_path


def test_the_example_of_the_input_reference_is_the_deck():
    manual = (TOP / "manual" / "input.md").read_text(encoding="utf-8")
    example = manual[manual.index("    ! Direct shear of two blocks") :]
    text = "".join(line.removeprefix("    ") for line in example.splitlines(keepends=True))
    assert text == (BLOCKS / "two_blocks.nml").read_text(encoding="utf-8")


def test_two_blocks_are_pressed_and_sheared(blocks, femdem):
    command = [femdem, "--output", "results", "two_blocks.nml"]
    done = subprocess.run(command, cwd=blocks, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stderr
    history = Results(blocks / "results").history
    # 1 MPa on top, and the weight of the upper block: 2700 kg/m3, 0.1 m high
    assert history["fracture.normal_stress_MPa"][-1] == pytest.approx(
        1.0 + 2700 * 9.81 * 0.1 * 1e-6, rel=1e-3
    )
    # The left side moves by 0.5 mm; the joint by less, since the block gives way
    assert 0.45 < history["fracture.shear_displacement_mm"][-1] < 0.5
