"""The table of deliberate faults keeps pace with the code: every text is still there once, every folder has a fault."""

import pytest

import mutants

FOLDERS = sorted(path.name for path in (mutants.TOP / "modules").iterdir() if path.is_dir())
TABLE = mutants.read_table()
FEWEST = 40


@pytest.mark.tools
def test_every_mutant_can_still_be_made():
    faults = {mutant.name: mutant.fault() for mutant in TABLE if mutant.fault()}
    assert not faults


@pytest.mark.tools
def test_the_table_covers_all_folders_of_the_code():
    names = [mutant.name for mutant in TABLE]
    assert len(set(names)) == len(names) >= FEWEST
    assert sorted({mutant.file.split("/")[1] for mutant in TABLE}) == FOLDERS


@pytest.mark.tools
def test_rows_that_cannot_be_made_are_told(tmp_path):
    (tmp_path / "a.f90").write_text("x = 1\ny = 2\ny = 2\n", encoding="utf-8")
    (tmp_path / "tests" / "unit").mkdir(parents=True)
    (tmp_path / "tests" / "unit" / "test_one.pf").touch()

    def fault(old, new, file="a.f90", **selection):
        return mutants.Mutant("name", file, old, new, "", **(selection or {"unit": "test_one"})).fault(
            tmp_path
        )

    assert fault("x = 1", "x = 3") == ""
    assert fault("z", "x") == "text not found"
    assert fault("y = 2", "y = 3") == "text is there 2 times"
    assert fault("x = 1", "x = 1") == "must change one line"
    assert fault("x = 1\ny", "x = 3\ny") == "must change one line"
    assert fault("x = 1", "x = 3", file="b.f90") == "no file b.f90"
    assert fault("x = 1", "x = 3", unit="test_on") == "no unit test is called test_on"
    assert fault("x = 1", "x = 3", unit="") == "no tests"


@pytest.mark.tools
def test_choice_by_name():
    assert [mutant.name for mutant in mutants.choose(TABLE, ["friction_eq_33"])] == ["friction_eq_33"]
    chosen = mutants.choose(TABLE, ["external_work_*"])
    assert len(chosen) == 2
    assert mutants.choose(TABLE, []) == sorted(TABLE, key=lambda mutant: mutant.file)
    with pytest.raises(SystemExit, match="no mutant is called nobody"):
        mutants.choose(TABLE, ["nobody"])


@pytest.mark.tools
def test_a_copy_is_not_made_in_what_is_copied(tmp_path):
    assert mutants.is_copied(mutants.TOP)
    assert mutants.is_copied(mutants.TOP / "copy")
    assert not mutants.is_copied(mutants.TOP / "build-mutants")
    assert not mutants.is_copied(tmp_path)
