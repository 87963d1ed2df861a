"""Every deck that input/network/paper_choices.py makes is good, and its slip, aperture and creep are those of the results."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

os.environ.setdefault("MPLCONFIGDIR", tempfile.gettempdir())

NETWORK = Path(__file__).resolve().parent.parent / "input" / "network"
sys.path.insert(0, str(NETWORK))

import paper_choices  # noqa: E402 - the folder of the scripts comes first

from femdem.results import Edges, Results  # noqa: E402

COARSE = ("--size", "0.15")  # m: a second to run
# Sums of the block edges in another order than the program's, and its twelve digits
ROUNDING = 1e-9
# What stands for a paper's choice in the effective deck
CHOICES = {"contact": "potential", "normal": "penalty", "normal_stress": "walls", "peak": "eq15"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a coarse mesh of the network"""
    made = tmp_path_factory.mktemp("paper_choices")
    command = [
        *(sys.executable, "-m", "femdem", "mesh"),
        paper_choices.TRACES,
        *COARSE,
        "--out",
        made / "mesh.msh",
    ]
    subprocess.run([str(word) for word in command], check=True, capture_output=True)
    return made


def written(folder, name, model):
    path = folder / f"{name}_{model}.nml"
    path.write_text(paper_choices.deck(paper_choices.CASES[name], model, "mesh.msh"), encoding="utf-8")
    return path


@pytest.mark.fast
@pytest.mark.parametrize("name", paper_choices.CASES)
def test_decks_are_good(name, folder, femdem):
    for model in paper_choices.CASES[name].models:
        deck = written(folder, name, model)
        done = subprocess.run([femdem, "--check", deck], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert "will be ignored" not in done.stdout + done.stderr


@pytest.mark.fast
def test_means_are_those_of_the_results(folder, femdem):
    deck = written(folder, "implicit", "jcm")
    subprocess.run(
        [femdem, "--quiet", "--output", folder / "implicit", deck], check=True, capture_output=True
    )
    found = paper_choices.course(folder / "implicit")
    run = Results(folder / "implicit")
    edges = Edges.read(folder / "implicit" / "edges.csv")
    long = edges.length_m > edges.length_m.mean()
    for values, means in (
        (edges.mean_shear_displacement_mm, found.slip),
        (edges.mean_aperture_mm, found.aperture),
    ):
        assert means[-1, 0] == pytest.approx(values.mean(), rel=ROUNDING)
        assert means[-1, 1] == pytest.approx(values[long].mean(), rel=ROUNDING)
        assert means[-1, 2] == pytest.approx(np.average(values, weights=edges.length_m), rel=ROUNDING)
    assert run.fields.stages[found.loaded] == "phase_2b"
    assert run.fields.stages[found.loaded + 1] == "held"


@pytest.mark.fast
def test_creep_is_the_slope_of_the_last_half():
    held = np.array([-1.0, 0.0, 2.0, 4.0, 6.0, 8.0])
    slip = np.where(held < 4.0, 7.0, 1.0 + 0.02 * held)  # mm; 0.02 mm/ms
    course = paper_choices.Course(held + 10.0, held, slip[:, None], slip[:, None])
    assert paper_choices.creep(course) == pytest.approx(20.0, rel=ROUNDING)  # mm/s
