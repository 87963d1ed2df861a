"""What is kept is used again only when all it was made from is the same: meshes of scripts, of run.sh, results of series."""

import subprocess
import sys
from pathlib import Path

import pytest

from femdem.kept import Kept, ingredients_of, make, text_fingerprint, with_modules

TOP = Path(__file__).resolve().parent.parent

pytestmark = [pytest.mark.fast, pytest.mark.tools]

# A mesh script: writes its helper's word, its file and its arguments; counts how often it ran
SCRIPT = """import sys
from helper import WORD
with open("runs", "a") as file:
    file.write("x")
with open("out.msh", "w") as file:
    file.write(WORD + open("traces.csv").read() + " ".join(sys.argv))
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    (tmp_path / "helper.py").write_text("import deeper\nWORD = deeper.WORD\n")
    (tmp_path / "deeper.py").write_text("WORD = 'one'\n")
    (tmp_path / "traces.csv").write_text("0,0,1,1")
    return tmp_path


def command(*more):
    return [sys.executable, "script.py", "traces.csv", "--size", "1", *more]


def runs(folder):
    return len((folder / "runs").read_text())


def test_same_ingredients_are_used_again(folder, capsys):
    assert make("out.msh", command(), folder) == 0
    assert "made now (it is not there)" in capsys.readouterr().out
    (folder / "script.py").touch()
    assert make("out.msh", command(), folder) == 0
    assert "out.msh: kept" in capsys.readouterr().out
    assert runs(folder) == 1


CHANGES = {
    "an argument": (None, "the command"),
    "a file of the arguments": ("traces.csv", "traces.csv"),
    "the script": ("script.py", "script.py"),
    "a module of the script": ("helper.py", "helper.py"),
    "a module of a module": ("deeper.py", "deeper.py"),
    "the product": ("out.msh", "what was made"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_whatever_changes_it_is_made_anew(what, folder, capsys):
    assert make("out.msh", command(), folder) == 0
    name, said = CHANGES[what]
    more = ["--coarse", "2"] if name is None else []
    if name is not None:
        path = folder / name
        path.write_text(path.read_text() + "\n")
    capsys.readouterr()
    assert make("out.msh", command(*more), folder) == 0
    assert f"made now ({said} changed)" in capsys.readouterr().out
    assert runs(folder) == 2


def test_a_product_of_a_failed_command_is_not_used(folder, capfd):
    assert make("out.msh", command(), folder) == 0
    (folder / "deeper.py").write_text("WORD = 1\n")
    assert make("out.msh", command(), folder) != 0
    (folder / "deeper.py").write_text("WORD = 'one'\n")
    assert make("out.msh", command(), folder) == 0
    assert "how it was made is not recorded" in capfd.readouterr().out


def test_a_command_that_makes_something_else_is_an_error(folder, capfd):
    assert make("other.msh", command(), folder) == 1
    assert "other.msh is not there" in capfd.readouterr().err


def test_what_was_made_before_there_were_records_is_made_anew(folder):
    (folder / "out.msh").write_text("old")
    assert make("out.msh", command(), folder) == 0
    assert runs(folder) == 1


def test_a_directory_is_known_by_its_proof(tmp_path):
    kept = Kept(tmp_path / "results", tmp_path / "results" / "run.log")
    ingredients = {"deck": text_fingerprint("&run /")}
    assert kept.differs(ingredients) == "it is not there"
    (tmp_path / "results").mkdir()
    kept.proof.write_text("done")
    kept.remember(ingredients)
    assert kept.differs(ingredients) == ""
    assert kept.differs({"deck": text_fingerprint("&stage /")}) == "deck changed"
    kept.proof.write_text("done by another run")
    assert kept.differs(ingredients) == "what was made changed"


def test_modules_of_the_mesh_script_are_found():
    script = TOP / "postproc" / "femdem" / "network" / "make_mesh.py"
    names = {path.name for path in with_modules(script)}
    assert {"make_mesh.py", "cleaning.py", "planar_graph.py", "traces.py", "mesh_quality.py"} <= names
    assert {"two_sets.csv", "traces.py"} <= set(
        ingredients_of(["-m", "femdem.network.make_mesh", "two_sets.csv"], TOP / "input" / "network")
    )


def test_run_sh_asks_what_the_mesh_was_made_from(folder):
    """The line of run.sh that makes the mesh, as it stands there."""
    line = next(text for text in (TOP / "run.sh").read_text().splitlines() if "femdem.kept" in text)
    script = (
        f'folder={folder} here={TOP} product=out.msh PYTHON={sys.executable}\nmesh_command=("$@")\n{line}\n'
    )
    said = [
        subprocess.run(
            ["bash", "-c", script, "bash", "script.py", "traces.csv", *more],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for more in ([], [], ["--size", "2"])
    ]
    assert ["made now" in text for text in said] == [True, False, True]


# Plays the program: writes the log of a run into the directory that the deck names, and counts how often it ran
PLAYED = """#!/bin/sh
for deck; do :; done
cd "$(dirname "$deck")" && mkdir -p closure && echo "done" > closure/run.log && printf x >> runs
"""


def test_a_series_runs_again_what_has_changed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(TOP / "input" / "direct_shear")
    import run_series

    program = tmp_path / "program"
    program.write_text(PLAYED)
    program.chmod(0o755)
    monkeypatch.setattr(run_series, "PROGRAM", program)
    deck = (TOP / "input" / "closure" / "closure_6cm_explicit.nml").read_text()
    folder = tmp_path / "series"
    mesh = ["--length", "0.06", "--size", "0.004"]
    other_load = run_series.change(deck, "material", density="1900")
    number = []
    for changed_deck, changed_mesh, again in (
        (deck, mesh, False),
        (deck, mesh, False),
        (other_load, mesh, False),
        (other_load, [*mesh[:3], "0.003"], False),
        (other_load, [*mesh[:3], "0.003"], True),
    ):
        run_series.run(changed_deck, changed_mesh, "closure", folder, again)
        number.append(runs(folder))
    assert number == [1, 1, 2, 3, 4]
    program.write_text(PLAYED + "# another build\n")
    run_series.run(other_load, [*mesh[:3], "0.003"], "closure", folder, False)
    assert runs(folder) == 5
