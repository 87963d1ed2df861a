"""A run that is killed at a write to fields.h5, whichever it is, and goes on: the same results as of a run left alone.

kill_at_write.c, loaded before the C library, counts the writes to the file and kills at one of them. The HDF5 library writes its
directory when it closes the file, with several writes in a row; kills at random moments (kills.py) hardly ever come between.
"""

import os
import subprocess

import pytest

import kills
from scene import TOP

# Of some 300 writes; the long test takes all of them. The first makes the file: there is nothing to keep yet
EVERY = 12


@pytest.fixture(scope="module")
def counter(tmp_path_factory):
    library = tmp_path_factory.mktemp("counter") / "kill_at_write.so"
    source = TOP / "tests" / "kill_at_write.c"
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    return library


def killed_runs(femdem, counter, folder, every):
    """What differs from a run left alone after a kill at every so many writes (list of texts), and how often files were rescued"""
    kills.write(folder, "implicit", True)
    deck = folder / "deck.nml"
    deck.write_text(deck.read_text().replace("fields_every = 50", "fields_every = 10"))
    watch = {
        "LD_PRELOAD": str(counter),
        "KILL_FILE": "fields.h5",
        "KILL_AT": "0",
        "KILL_COUNT": str(folder / "count"),
    }
    subprocess.run(kills.command(femdem, "whole", False), cwd=folder, env={**os.environ, **watch}, check=True)
    differ, rescued = [], 0
    for number in range(2, int((folder / "count").read_text()) + 1, every):
        watch["KILL_AT"] = str(number)
        results = folder / f"killed_{number}"
        done = subprocess.run(
            kills.command(femdem, results.name, False), cwd=folder, env={**os.environ, **watch}, check=False
        )
        assert done.returncode == -9
        kills.finish(femdem, folder, results.name, (results / "checkpoint.h5").exists())
        rescued += "all that was complete in it is kept" in (results / "run.log").read_text()
        what = kills.difference(folder / "whole", results)
        if what:
            differ.append(f"write {number}: {what}")
        assert not (results / "fields.h5.damaged").exists()
        assert not (results / "fields.h5.writing").exists()
    return differ, rescued


@pytest.mark.fast
def test_killed_while_fields_are_written(femdem, counter, tmp_path):
    differ, rescued = killed_runs(femdem, counter, tmp_path, EVERY)
    assert not differ
    assert rescued > 0


@pytest.mark.long
def test_killed_at_every_write_of_fields(femdem, counter, tmp_path):
    differ, rescued = killed_runs(femdem, counter, tmp_path, 1)
    assert not differ
    assert rescued > 0
