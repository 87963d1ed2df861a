"""run.sh and the commands in bin/ from where a newcomer calls them: another Python first in the path, a build that was moved."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parent.parent
# A Python that has nothing installed
BARE = """#!/bin/sh
exec {python} -S -s "$@"
"""

pytestmark = [pytest.mark.fast, pytest.mark.tools]


@pytest.fixture
def newcomer(tmp_path):
    """Environment of somebody whose first Python has no numpy"""
    bare = tmp_path / "bare" / "python3"
    bare.parent.mkdir()
    bare.write_text(BARE.format(python=sys.executable))
    bare.chmod(0o755)
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHON", "PYTHONPATH")}
    return kept | {"PATH": f"{bare.parent}{os.pathsep}{os.environ['PATH']}"}


def call(command, **options):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)
    return done.returncode, done.stdout + done.stderr


def test_the_commands_find_a_python_that_has_what_they_need(newcomer, tmp_path):
    assert call(["python3", "-c", "import numpy"], env=newcomer)[0] != 0
    assert call([TOP / "bin" / "python3", "-c", "import numpy, femdem"], env=newcomer) == (0, "")
    for path in sorted((TOP / "bin").glob("femdem-*")):
        status, said = call([path, "--help"], env=newcomer, cwd=tmp_path)
        assert status == 0, said
        assert f"usage: {path.name}" in said


def test_every_command_of_the_package_has_its_link():
    import tomllib

    project = tomllib.loads((TOP / "postproc" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    links = {path.name for path in (TOP / "bin").glob("femdem-*")}
    assert links == set(project["scripts"])
    from femdem.__main__ import COMMANDS

    assert project["scripts"] == {f"femdem-{name}": f"{module}:main" for name, module in COMMANDS.items()}


def test_the_names_of_the_version_before_lead_to_the_commands(tmp_path):
    links = [*(TOP / "postproc").glob("plot_*.py"), TOP / "input" / "network" / "run_network.py"]
    assert len(links) > 10
    for path in links:
        # A Python without the libraries, as one that comes first in PATH may be
        status, said = call([sys.executable, "-S", "-E", path, "--help"], cwd=tmp_path)
        assert status == 0, said
        assert f"{path.name} is called bin/femdem-" in said
        assert "usage: femdem-" in said


def setup(folder, *lines):
    """Run lines of shell after tools/setup.sh in a folder"""
    text = "\n".join([f"cd {folder}", "source tools/setup.sh", *lines])
    return call(["bash", "-c", text])


@pytest.fixture
def project(tmp_path):
    """A folder that looks like the project, with a program that is newer than all sources"""
    folder = tmp_path / "project"
    for name in ("cmake", "modules", "src", "build", "tools"):
        (folder / name).mkdir(parents=True)
    shutil.copy(TOP / "tools" / "setup.sh", folder / "tools")
    for name in (
        "CMakeLists.txt",
        "CMakePresets.json",
        "src/femdem.f90",
        "build/CMakeCache.txt",
        "build/femdem",
    ):
        (folder / name).touch()
    (folder / "build" / "femdem").chmod(0o755)
    age(folder / "build" / "femdem", 10)
    return folder


def age(path, seconds):
    """Make a file younger by so many seconds than it is"""
    then = path.stat().st_mtime + seconds
    os.utime(path, (then, then))


def test_a_program_that_is_newer_than_its_sources_is_not_built(project):
    assert setup(project, "built build")[0] == 0
    age(project / "src" / "femdem.f90", 20)
    assert setup(project, "built build")[0] == 1


def test_a_build_that_was_moved_is_named(project):
    (project / "build" / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere/project\n")
    status, said = setup(project, "build_preset release build")
    assert status == 1
    assert "was made for the project in /elsewhere/project" in said
    assert "rm -r build" in said
