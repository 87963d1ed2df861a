"""Results that several of these tests read, made once."""

import shutil
import subprocess
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[2]
SHEAR = TOP / "input" / "direct_shear"
NETWORK = TOP / "input" / "network"


@pytest.fixture(scope="session")
def commands():
    """Run a command of the installed package; all it says"""

    def run(name, *words, status=0, **options):
        program = shutil.which(f"femdem-{name}")
        assert program, f"femdem-{name} is not installed"
        done = subprocess.run(
            [str(word) for word in (program, *words)], capture_output=True, text=True, check=False, **options
        )
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout + done.stderr

    return run


@pytest.fixture(scope="session")
def place(tmp_path_factory):
    """A folder with results as run.sh leaves them"""
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="session")
def shear(place, femdem):
    """Results of the direct shear test, elements of 3 mm"""
    results = place / "results" / "direct_shear" / "shear_6cm"
    results.mkdir(parents=True)
    shutil.copy(SHEAR / "shear_6cm.nml", place)
    script = [shutil.which("python"), SHEAR / "make_mesh.py"]
    subprocess.run(
        [*script, "--length", "0.06", "--size", "0.003", "--out", "shear_6cm.msh"], cwd=place, check=True
    )
    subprocess.run([femdem, "--quiet", "--output", results, "shear_6cm.nml"], cwd=place, check=True)
    return results


@pytest.fixture(scope="session")
def network(place, femdem, commands):
    """Results of phases I and II-B of the network, elements of 80 mm"""
    results = place / "results" / "network" / "phase_2b"
    results.mkdir(parents=True)
    shutil.copy(NETWORK / "phase_2b.nml", place)
    commands("mesh", NETWORK / "two_sets.csv", "--size", "0.08", "--out", "two_sets.msh", cwd=place)
    subprocess.run([femdem, "--quiet", "--output", results, "phase_2b.nml"], cwd=place, check=True)
    return results
