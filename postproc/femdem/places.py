"""Where the program is, and where results go, from a checkout of the project or from an installed package."""

import os
import shutil
import sys
from pathlib import Path

PACKAGES = Path(__file__).resolve().parents[1]  # the folder that holds this package
PROGRAM_NAME = "femdem"


def checkout():
    """Top of the project this package lies in; none when it is installed elsewhere."""
    top = PACKAGES.parent
    return top if (top / "CMakeLists.txt").is_file() and (top / "run.sh").is_file() else None


def program():
    """The program: $FEMDEM, that in build/ of the project or of the working directory, or the first in PATH."""
    if os.environ.get("FEMDEM"):
        return Path(os.environ["FEMDEM"])
    built = (checkout() or Path.cwd()) / "build" / PROGRAM_NAME
    if checkout() or built.is_file():
        return built
    return Path(shutil.which(PROGRAM_NAME) or PROGRAM_NAME)


def results():
    """Where results go that are given no other place"""
    return (checkout() or Path.cwd()) / "results"


def module(name, *words):
    """Command that runs a module of this package; it needs environment()"""
    return [sys.executable, "-m", name, *words]


def environment():
    """Environment in which another Python finds this package, installed or not"""
    paths = [str(PACKAGES), *filter(None, [os.environ.get("PYTHONPATH")])]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(paths))
