"""Sweeps as a user runs them: grids, lists and Latin hypercubes; a kill and what is done after it; runs that fail."""

import contextlib
import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from femdem import ResultsError
from femdem.sweep import table

INPUT = Path(__file__).resolve().parents[2] / "input"
SHEAR, NETWORK = INPUT / "direct_shear", INPUT / "network"
# The program, with a line in a file for each time it is asked to run, and slow enough to be killed
SLOW = """#!/bin/sh
case " $* " in *" --check "*) ;; *) pwd >> "{log}"; sleep {pause} ;; esac
exec "{femdem}" "$@"
"""
PEAK = "peak=history.joint.shear_stress_MPa largest"
PATIENCE = 120  # seconds


@pytest.fixture
def sweep(tmp_path, femdem, commands):
    """Run femdem-sweep on the shear test with 4 mm elements, the program counted"""
    deck = (SHEAR / "shear_6cm.nml").read_text().replace("cycles = 500", "cycles = 20")
    assert "cycles = 20" in deck
    (tmp_path / "deck.nml").write_text(deck.replace("--size 0.001", "--size 0.004"))
    shutil.copy(SHEAR / "make_mesh.py", tmp_path)

    def program(pause=0):
        path = tmp_path / "program"
        path.write_text(SLOW.format(femdem=femdem, log=tmp_path / "ran", pause=pause))
        path.chmod(0o755)
        return path

    def run(text, *options, name="t.csv", status=0, pause=0):
        (tmp_path / name).write_text(text)
        words = (
            name,
            "deck.nml",
            "--out",
            "out",
            "--cores",
            "2",
            "--femdem",
            program(pause),
            "--collect",
            PEAK,
        )
        return commands("sweep", *words, *options, cwd=tmp_path, status=status)

    run.folder, run.program = tmp_path, program
    return run


def rows(sweep):
    """The table of results"""
    with open(sweep.folder / "out" / "table.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def ran(sweep):
    """How often the program ran in each folder"""
    log = sweep.folder / "ran"
    folders = log.read_text().splitlines() if log.exists() else []
    return {folder: folders.count(folder) for folder in folders}


def test_a_list_with_a_run_and_a_mesh_that_fail(sweep):
    said = sweep("joint.jrc0,mesh.size\n8,0.004\n-3,0.004\n15,0.004\n15,-1\n", status=1)
    assert "4 of 4 runs done, 2 of them failed" in said
    found = rows(sweep)
    assert [row["status"] for row in found] == ["done", "failed", "done", "failed"]
    assert "jrc0 = -3: must be at least 0" in found[1]["message"]
    assert found[3]["message"].startswith("no mesh: ")
    assert [row["joint.jrc0"] for row in found] == ["8", "-3", "15", "15"]
    peaks = [float(row["peak"]) for row in found if row["status"] == "done"]
    assert 0.01 < peaks[0] < peaks[1] < 0.05
    # Rows with the same mesh share it
    assert len(list((sweep.folder / "out" / "meshes").iterdir())) == 2
    # Again: nothing is done, failures included, until it is asked for
    before = ran(sweep)
    sweep("joint.jrc0,mesh.size\n8,0.004\n-3,0.004\n15,0.004\n15,-1\n", status=1)
    assert ran(sweep) == before
    sweep("joint.jrc0,mesh.size\n8,0.004\n-3,0.004\n15,0.004\n15,-1\n", "--retry", status=1)
    assert sorted(ran(sweep).values()) == [1, 1, 2]


def test_rows_are_added_and_values_changed(sweep):
    sweep("joint.jrc0\n8\n15\n")
    sweep("joint.jrc0\n5\n8\n15\n")
    assert list(ran(sweep).values()) == [1, 1, 1]
    assert [row["joint.jrc0"] for row in rows(sweep)] == ["5", "8", "15"]
    # Another deck: everything anew
    deck = sweep.folder / "deck.nml"
    deck.write_text(deck.read_text().replace("jcs0_mpa = 2", "jcs0_mpa = 3"))
    first = rows(sweep)[0]["peak"]
    sweep("joint.jrc0\n5\n8\n15\n")
    assert list(ran(sweep).values()) == [2, 2, 2]
    assert rows(sweep)[0]["peak"] != first
    # Another column: the table anew, no run
    sweep("joint.jrc0\n5\n8\n15\n", "--collect", "gap=history.joint.aperture_mm @ load")
    assert list(ran(sweep).values()) == [2, 2, 2]
    assert float(rows(sweep)[0]["gap"]) > 0.0


@pytest.mark.parametrize("how", ["kill", pytest.param("interrupt", marks=pytest.mark.long)])
def test_after_a_kill_nothing_is_done_twice(how, sweep):
    """The whole group of processes is killed in the middle; the same command then does what is missing"""
    text = "joint.jrc0\n" + "".join(f"{n}\n" for n in range(6, 14))
    (sweep.folder / "t.csv").write_text(text)
    command = [
        shutil.which("femdem-sweep"),
        "t.csv",
        "deck.nml",
        "--out",
        "out",
        "--cores",
        "2",
        "--collect",
        PEAK,
    ]
    working = subprocess.Popen(
        [*command, "--femdem", sweep.program(1)],
        cwd=sweep.folder,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        # A shell in the background has its children ignore it
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    status = sweep.folder / "out" / "runs"
    end = time.monotonic() + PATIENCE
    while len(list(status.glob("*/ended.json"))) < 3 and time.monotonic() < end:
        time.sleep(0.1)
    if how == "kill":
        engine = int((sweep.folder / "out" / "running").read_text().split()[2])
        for process in (working.pid, engine):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process, signal.SIGKILL)
    else:
        working.send_signal(signal.SIGINT)
    working.wait(PATIENCE)
    done = {path.parent for path in status.glob("*/ended.json")}
    assert 3 <= len(done) < 8
    at_kill = ran(sweep)
    said = sweep(text, pause=1)
    assert "8 of 8 runs done" in said
    after = ran(sweep)
    assert len(after) == 8
    for folder in done:
        assert after[str(folder)] == at_kill.get(str(folder), 1) == 1
    assert all(row["status"] == "done" for row in rows(sweep))
    assert sum(after.values()) <= 8 + 2


def test_two_at_the_same_time_are_refused(sweep):
    out = sweep.folder / "out"
    out.mkdir()
    import socket

    other = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)", "sweep"])
    (out / "running").write_text(f"{socket.gethostname()} {other.pid}\n")
    assert "works on this sweep" in sweep("joint.jrc0\n8\n", status=2)
    other.kill()
    other.wait()
    assert "1 of 1 runs done" in sweep("joint.jrc0\n8\n")


WRONG = {
    "variable": ("joint.jrco\n8\n", "did you mean jrc0?"),
    "group": ("joints.jrc0\n8\n", "the deck has no &joints; it has: run"),
    "name": ("joint[fault].jrc0\n8\n", "no &joint has fault; there are: joint"),
    "form": ("jrc0\n8\n", "it must be GROUP.VARIABLE"),
    "row": ("joint.jrc0\n8,9\n", "row 1 has 2 values for 1 names"),
    "twice": ("joint.jrc0\n8\n8\n", "row 2 is the same as an earlier one"),
    "empty": ("joint.jrc0\n", "it has no rows"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_tables_are_refused_before_anything_is_run(case, sweep):
    text, said = WRONG[case]
    assert said in sweep(text, status=2)
    assert not ran(sweep)


def test_wrong_columns_are_refused_or_told(sweep):
    assert "TABLE.COLUMN" in sweep("joint.jrc0\n8\n", "--collect", "peak", status=2)
    sweep("joint.jrc0\n8\n", "--collect", "history.nothing")
    assert "no column 'nothing'" in rows(sweep)[0]["message"]
    assert rows(sweep)[0]["status"] == "done"


YAML = """kind: latin
samples: 6
seed: 3
parameters:
  joint.jrc0: {low: 5, high: 17}
  joint.jcs0_mpa: {low: 1, high: 100, scale: log}
  joint.peak: [eq14, eq15]
collect:
  gap: history.joint.aperture_mm
"""


def test_a_latin_hypercube_fills_every_part_of_its_ranges(sweep):
    sweep(YAML, name="t.yaml")
    found = rows(sweep)
    assert [row["status"] for row in found] == ["done"] * 6
    jrc = sorted(int((float(row["joint.jrc0"]) - 5) / 2) for row in found)
    assert jrc == list(range(6))
    assert sorted(row["joint.peak"] for row in found) == ["eq14"] * 3 + ["eq15"] * 3
    assert all(1 < float(row["joint.jcs0_mpa"]) < 100 for row in found)
    # Both what the table and what the command line ask for
    assert all(float(row["gap"]) > 0 and float(row["peak"]) > 0 for row in found)
    decks = [(sweep.folder / "out" / row["results"]).with_name("deck.nml").read_text() for row in found]
    assert all(f"jrc0 = {row['joint.jrc0']}" in text for row, text in zip(found, decks, strict=True))


def test_grids(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text("parameters:\n  a.b: {from: 1, to: 2, step: 0.5}\n  c.d: [x, y]\n  e.f: 3\n")
    found = table.read_table(path).rows
    assert found[:3] == [
        {"a.b": 1, "c.d": "x", "e.f": 3},
        {"a.b": 1, "c.d": "y", "e.f": 3},
        {"a.b": 1.5, "c.d": "x", "e.f": 3},
    ]
    assert len(found) == 6
    path.write_text("parameters:\n  a.b: {low: 1, high: 100, number: 3, scale: log}\n")
    assert [row["a.b"] for row in table.read_table(path).rows] == pytest.approx([1, 10, 100])
    for text, said in (
        ("kind: cube\nparameters: {a.b: 1}\n", "must be one of list, grid, latin"),
        ("params: {a.b: 1}\n", "unknown key 'params'"),
        ("kind: latin\nparameters: {a.b: 1}\n", "samples"),
        ("parameters: {a.b: {from: 2, to: 1}}\n", "has no values"),
        ("a: [1\n", "t.yaml"),
    ):
        path.write_text(text)
        with pytest.raises(ResultsError, match=said):
            table.read_table(path)


def test_a_cluster_gets_the_same_workflow(sweep):
    """What an executor would be given: the plan, without running it"""
    said = sweep("joint.jrc0\n8\n9\n", "--plan", "--jobs", "4", "--", "--default-resources", "runtime=5")
    assert "run" in said
    assert not ran(sweep)
    assert sys.executable  # the jobs are run by this Python


@pytest.mark.long
def test_a_small_part_of_the_shipped_example(tmp_path, commands, femdem):
    """Two of the 200 realisations, coarse: four runs on two meshes, and their figure"""
    example = (NETWORK / "realisations.yaml").read_text()
    assert "to: 200" in example
    small = example.replace("to: 200", "to: 2").replace("parameters:\n", "parameters:\n  mesh.size: 0.1\n")
    (tmp_path / "few.yaml").write_text(small)
    words = ("few.yaml", NETWORK / "realisations.nml", "--cores", "2", "--femdem", femdem)
    said = commands("sweep", *words, cwd=tmp_path)
    assert "4 of 4 runs done" in said
    with open(tmp_path / "few" / "table.csv", newline="", encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    assert [row["message"] for row in found] == [""] * 4
    assert [row["joint.law"] for row in found] == ["jcm", "coulomb"] * 2
    assert len(list((tmp_path / "few" / "meshes").iterdir())) == 2
    for row in found:
        # Phase II-B slips far more than phase I; the networks of two seeds differ
        assert float(row["slip_2b_mm"]) > 5 * float(row["slip_1_mm"]) > 0
        # Apertures of a tenth of a millimetre, one or two a metre: a**3 / 12 a metre is some 1e-13 m2
        assert all(
            1e-15 < float(row[name]) < 1e-11 for name in ("kx_1_m2", "kx_2b_m2", "ky_1_m2", "ky_2b_m2")
        )
    assert found[0]["slip_2b_mm"] != found[2]["slip_2b_mm"]
    said = commands("plot", "sweep", tmp_path / "few" / "table.csv", "--by", "joint.law")
    assert "4 runs, 0 more not done or failed" in said
    assert (tmp_path / "few" / "figures" / "sweep.png").stat().st_size > 10_000
