"""Every folder of tests/scenes: run the program and compare with closed forms or references."""

import pytest

from scene import complaints_about, find_cases, run_case


def scene_parameters():
    cases = find_cases()
    marks = {"fast": [pytest.mark.fast], "normal": [], "long": [pytest.mark.long]}
    return [pytest.param(case, id=case.name, marks=marks[case.mark]) for case in cases]


@pytest.mark.parametrize("case", scene_parameters())
def test_scene(case, femdem, build_directory):
    results = run_case(case, femdem, build_directory / "scenes")
    complaints = complaints_about(case, results)
    assert not complaints, "\n".join([case.title, *complaints, f"results in {results}"])
