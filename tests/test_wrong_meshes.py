"""Wrong meshes: every one ends with exit status 2 and messages that name what is wrong and where."""

import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest

SCENE = Path(__file__).resolve().parent / "scenes" / "wrong_meshes"
SPECIFICATION = importlib.util.spec_from_file_location("wrong_meshes", SCENE / "wrong_meshes.py")
wrong_meshes = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(wrong_meshes)


def check(femdem, text, directory):
    """Let the program check a mesh."""
    shutil.copy(SCENE / "deck.nml", directory)
    (directory / "wrong.msh").write_text(text)
    command = [femdem, "--check", "deck.nml"]
    return subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.fast
@pytest.mark.parametrize("name", wrong_meshes.CASES)
def test_wrong_mesh(name, femdem, tmp_path):
    text, expected = wrong_meshes.CASES[name](wrong_meshes.Mesh())
    result = check(femdem, text, tmp_path)
    assert result.returncode == 2, result.stdout + result.stderr
    errors = [line for line in result.stderr.splitlines() if not line.startswith("warning: ")]
    assert all(line.startswith("error: ") for line in errors), result.stderr
    for fragment in expected:
        assert fragment in result.stderr


@pytest.mark.fast
def test_the_mesh_they_come_from_is_good(femdem, tmp_path):
    result = check(femdem, wrong_meshes.Mesh().text(), tmp_path)
    assert result.returncode == 0, result.stderr


@pytest.mark.fast
def test_a_missing_mesh_is_named(femdem, tmp_path):
    shutil.copy(SCENE / "deck.nml", tmp_path)
    command = [femdem, "--check", "deck.nml"]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 2
    assert "wrong.msh" in result.stderr
