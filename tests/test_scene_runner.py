"""The scene runner itself, with a small script in the program's place: a scene must be able to fail."""

import stat

import numpy as np
import pytest

from scene import (
    SCENES,
    SceneError,
    complaints_about,
    evaluate,
    find_cases,
    read_case,
    read_history,
    run_case,
)

pytestmark = pytest.mark.tools

HISTORY = "time_s,step,joint.shear_stress_MPa,joint.normal_stress_MPa\n0.0,0,0.0,1.0\n1.0,10,0.5,1.0\n2.0,20,0.4,1.0\n"
PROGRAM = f"""#!/usr/bin/env python3
import pathlib, sys
deck, results = sys.argv[-1], pathlib.Path(sys.argv[sys.argv.index("--output") + 1])
if not pathlib.Path("mesh.msh").exists() or not pathlib.Path(deck).exists():
    sys.exit(2)
results.mkdir()
(results / "history.csv").write_text({HISTORY!r})
"""
CASE = """
title = "A scene"
mark = "fast"
mesh = "make_mesh.py"
deck = "deck.nml"
"""
CHECK = """[[check]]
quantity = "largest(joint.shear_stress_MPa / joint.normal_stress_MPa)"
reference = REFERENCE
tolerance = 1e-12
why = "the numbers above"
"""


def case_text(reference):
    return CASE + CHECK.replace("REFERENCE", str(reference))


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "program"
    path.write_text(PROGRAM)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def make_scene(tmp_path, text, **files):
    folder = tmp_path / "scenes" / "sample"
    folder.mkdir(parents=True)
    (folder / "case.toml").write_text(text)
    (folder / "deck.nml").write_text("&run /\n")
    (folder / "make_mesh.py").write_text("open('mesh.msh', 'w').close()\n")
    for name, content in files.items():
        (folder / f"{name}.py").write_text(content)
    return find_cases(tmp_path / "scenes")[0]


@pytest.mark.parametrize(("reference", "complaints"), [("0.5", 0), ('"1/2"', 0), ("0.51", 1), ("nan", 1)])
def test_a_quantity_is_compared(tmp_path, program, reference, complaints):
    case = make_scene(tmp_path, case_text(reference))
    results = run_case(case, program, tmp_path / "work")
    assert len(complaints_about(case, results)) == complaints


def test_an_unknown_column_is_a_complaint_that_lists_the_columns(tmp_path, program):
    case = make_scene(tmp_path, case_text(0.5).replace("shear_stress_MPa", "shear_MPa"))
    (complaint,) = complaints_about(case, run_case(case, program, tmp_path / "work"))
    assert "joint.normal_stress_MPa" in complaint


def test_a_failed_run_is_an_error(tmp_path, program):
    case = make_scene(tmp_path, case_text(0.5), make_mesh="")
    with pytest.raises(SceneError, match="status 2, expected 0"):
        run_case(case, program, tmp_path / "work")


def test_an_own_check_can_fail(tmp_path, program):
    own = "def check(results):\n    assert (results / 'edges.csv').exists(), 'no edges.csv'\n"
    case = make_scene(tmp_path, case_text(0.5), check=own)
    assert complaints_about(case, run_case(case, program, tmp_path / "work")) == ["check.py: no edges.csv"]


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("why", "because"), "unknown key 'because'"),
        (("tolerance = 1e-12", ""), "needs tolerance or relative_tolerance"),
        (('mark = "fast"', 'mark = "quick"'), "mark must be one of"),
        (("deck", "dek"), "no 'deck'"),
        ((CHECK.replace("REFERENCE", "0.5"), ""), "nothing is checked"),
    ],
)
def test_a_wrong_case_is_an_error(tmp_path, change, complaint):
    with pytest.raises(SceneError, match=complaint):
        make_scene(tmp_path, case_text(0.5).replace(*change))


def test_expressions_and_functions():
    columns = {
        "t": np.array([0.0, 1.0, 2.0]),
        "a.t": np.array([0.0, 2.0, 1.0]),
        "a.t_2": np.array([5.0, 6.0, 7.0]),
    }
    assert evaluate("last(a.t) + first(a.t_2) - largest(t)", columns) == 4.0
    assert evaluate("where(t, a.t, 1.0)", columns) == 0.5
    assert evaluate("where(t, a.t_2, 6.0)", columns) == 1.0
    assert evaluate("tan(radians(45))", {}) == pytest.approx(1.0)
    with pytest.raises(SceneError, match="never reaches"):
        evaluate("where(t, a.t, 3.0)", columns)
    with pytest.raises(SceneError):
        evaluate("open('x')", columns)


def test_history_comments_are_skipped(tmp_path):
    path = tmp_path / "history.csv"
    path.write_text("# made by a test\n" + HISTORY)
    assert list(read_history(path)["step"]) == [0.0, 10.0, 20.0]


def test_the_template_is_a_valid_case():
    assert read_case(SCENES / "_template" / "case.toml").name == "_template"
