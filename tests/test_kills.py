"""A few kills at random moments (kills.py; the many are run by hand): the same results as of a run left alone."""

import random

import pytest

import kills


@pytest.mark.parametrize("solver", ["explicit", "relaxation", "implicit"])
@pytest.mark.parametrize("cracks", [False, True], ids=["whole", "cracks"])
def test_killed_runs_end_as_one_left_alone(solver, cracks, femdem):
    killed, differ = kills.series(femdem, solver, cracks, 4, random.Random(5))
    assert killed > 0
    assert not differ
