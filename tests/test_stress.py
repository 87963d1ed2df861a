"""The short set of the stress tests (stress/run.py; all of them by hand)."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent / "stress"))
import run as stress

SHORT = [name for name, row in stress.FAMILIES.items() if row[2]]


@pytest.mark.fast
@pytest.mark.parametrize("name", SHORT)
def test_family(name):
    outcome = stress.Outcome(name)
    stress.tell(outcome)
    assert outcome.passed, f"{name}: {outcome.figures} {outcome.error}"


def test_the_network_of_input_can_be_shaken():
    for what, spread in stress.outcrop_jitter(2):
        assert 0.0 < spread < 1e-2, what


@pytest.mark.fast
def test_a_family_that_breaks_its_bar_fails(monkeypatch):
    for bar, known, passed in (
        (1.0, "", True),
        (0.1, "", False),
        (0.1, "so it is", True),
        (1.0, "so it was", False),
    ):
        monkeypatch.setitem(stress.FAMILIES, "x", (lambda: [("a", 0.5)], bar, True, known))
        assert stress.Outcome("x").passed == passed
    monkeypatch.setitem(stress.FAMILIES, "x", (lambda: [("a", float("nan"))], 1.0, True, ""))
    assert not stress.Outcome("x").passed


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["explicit", "implicit", "relaxation"])
def test_rock_that_is_turned_inside_out_is_warned_of(solver):
    time = 1e-3 if solver == "explicit" else 1.0
    for depth, said in ((0.1, False), (1.5, True)):
        run = stress.Run(
            stress.Stack([("rock", 1.0, 1)], columns=1),
            stress.deck(
                stress.rock(),
                stress.HELD,
                stress.load("top", vx=0.0, vy=-depth / 5 / time),
                stress.stage(cycles=5, move=time),
                solver=solver,
            ),
        ).needed()
        assert ("2 of 2 triangles are turned inside out" in run.said) == said
