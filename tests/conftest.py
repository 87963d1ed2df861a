"""Options and fixtures of the Python tests."""

import os
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parent.parent
POSTPROC = str(TOP / "postproc")
# The Python package is tested as it lies in the project, in this process and in those that tests start. The tests in package/ are
# run by test_package.py with the package installed in an environment that has all its extras.
INSTALLED = os.environ.get("FEMDEM_PACKAGE_TESTS") == "installed"
collect_ignore = [] if INSTALLED else ["package"]
if not INSTALLED:
    sys.path.insert(0, POSTPROC)
    os.environ["PYTHONPATH"] = os.pathsep.join([POSTPROC, *filter(None, [os.environ.get("PYTHONPATH")])])


def pytest_addoption(parser):
    parser.addoption("--build", default="build", help="build directory to test (default: build)")
    parser.addoption("--long", action="store_true", help="also run the tests marked long")


def pytest_configure(config):
    """Tests that run programs themselves find them through the environment."""
    build = (TOP / config.getoption("--build")).resolve()
    os.environ["FEMDEM_BUILD"] = str(build)
    os.environ["FEMDEM"] = str(build / "femdem")


def pytest_collection_modifyitems(config, items):
    """Leave out the long tests unless they are asked for."""
    if config.getoption("--long"):
        return
    long = [item for item in items if item.get_closest_marker("long")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item not in long]


@pytest.fixture(scope="session")
def build_directory(pytestconfig):
    """The build under test."""
    return (TOP / pytestconfig.getoption("--build")).resolve()


@pytest.fixture(scope="session")
def femdem():
    """Path of the program under test."""
    program = Path(os.environ["FEMDEM"])
    assert program.is_file(), f"{program} is not built"
    return program
