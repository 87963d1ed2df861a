"""The Python package as a user installs it, with all its extras, in an environment of its own that is made here once.

What is tested in it is in package/. Where the environment cannot be made, because no package can be fetched, this is skipped.
"""

import hashlib
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("package")
TOP = Path(__file__).resolve().parent.parent
PACKAGE = TOP / "postproc"
TESTS = sorted(path.stem for path in (TOP / "tests" / "package").glob("test_*.py"))
BESIDE = ("pytest", "nbclient", "ipykernel")  # what the tests need besides the extras
MINUTES = 60  # seconds
TO_INSTALL = 15 * MINUTES


def pip(python, *words):
    """Run pip of an environment"""
    command = [python, "-m", "pip", "install", "-q", "--retries", "1", "--disable-pip-version-check", *words]
    return subprocess.run(command, cwd=TOP, capture_output=True, text=True, timeout=TO_INSTALL, check=False)


@pytest.fixture(scope="module")
def environment(build_directory):
    """Python of an environment with the package, its extras and pytest; what others need is installed once a list of them"""
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = ",".join(project["optional-dependencies"])
    wanted = hashlib.sha256(
        repr([project["dependencies"], project["optional-dependencies"], BESIDE]).encode()
    ).hexdigest()
    place = build_directory / ".venv-package"
    python, mark = place / "bin" / "python", place / "installed.txt"
    if not mark.is_file() or mark.read_text() != wanted:
        made = subprocess.run(
            [sys.executable, "-m", "venv", "--clear", place], capture_output=True, text=True, check=False
        )
        if made.returncode == 0:
            made = pip(python, f"{PACKAGE}[{extras}]", *BESIDE)
        if made.returncode != 0:
            pytest.skip(f"no environment for the package: {' '.join(made.stderr.split())[-300:]}")
        mark.write_text(wanted)
    done = pip(python, "--no-deps", "--force-reinstall", PACKAGE)
    assert done.returncode == 0, done.stderr
    return python


@pytest.mark.parametrize("name", TESTS)
def test_installed(name, environment, build_directory, tmp_path, pytestconfig):
    variables = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "PYTHON", "VIRTUAL_ENV")
    }
    # Snakemake and matplotlib keep things in the home directory
    variables |= {
        "FEMDEM_PACKAGE_TESTS": "installed",
        "XDG_CACHE_HOME": str(tmp_path),
        "MPLCONFIGDIR": str(tmp_path),
    }
    variables["PATH"] = f"{environment.parent}{os.pathsep}{os.environ['PATH']}"
    command = [environment, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--build", build_directory]
    command += ["--basetemp", tmp_path / "inner", TOP / "tests" / "package" / f"{name}.py"]
    command += ["--long"] if pytestconfig.getoption("--long") else []
    done = subprocess.run(
        [str(word) for word in command], cwd=TOP, env=variables, capture_output=True, text=True, check=False
    )
    print(done.stdout.splitlines()[-1] if done.stdout else "")
    assert done.returncode == 0, done.stdout + done.stderr
