"""Some hundred mutated decks and meshes end in order (fuzz.py; the many are run by hand)."""

import argparse
from concurrent.futures import ThreadPoolExecutor

import pytest

import fuzz


@pytest.fixture
def arguments(femdem, tmp_path):
    return argparse.Namespace(seed=3, program=femdem, seconds=2.0, failures=tmp_path / "failures")


@pytest.mark.fast
@pytest.mark.parametrize("kind", ["deck", "mesh"])
def test_mutated_input_ends_in_order(kind, arguments):
    number = {"deck": 80, "mesh": 40}[kind]
    with ThreadPoolExecutor(2) as pool:
        for name, _, wrong, said in pool.map(lambda i: fuzz.one_case(arguments, kind, i), range(number)):
            assert not wrong, f"fuzz.py --seed 3 --only {name}: {wrong}\n{said}"


@pytest.mark.fast
def test_what_the_fuzzer_takes_for_wrong(tmp_path):
    """It would notice"""
    (tmp_path / "results").mkdir()
    table = tmp_path / "results" / "history.csv"
    table.write_text("time_s,x\n0,1.0\n")
    assert fuzz.what_is_wrong(0, "", tmp_path) == ""
    assert fuzz.what_is_wrong(2, "error: a", tmp_path) == ""
    assert fuzz.what_is_wrong(None, "", tmp_path) == ""
    assert fuzz.what_is_wrong(-11, "error: a", tmp_path) == "status -11"
    assert fuzz.what_is_wrong(2, "At line 3 of file\nFortran runtime error: End of file", tmp_path)
    assert fuzz.what_is_wrong(1, "", tmp_path) == "status 1 without a message"
    table.write_text("time_s,x\n0,nan\n")
    assert fuzz.what_is_wrong(0, "", tmp_path)
    table.write_text("time_s,x\n0,Infinity\n")
    assert fuzz.what_is_wrong(0, "", tmp_path)
    # The same case again, whatever was run before it
    for _ in range(2):
        (tmp_path / "case").mkdir(exist_ok=True)
        fuzz.make_case(1, "deck", 7, tmp_path / "case")
        made = (tmp_path / "case" / "deck.nml").read_bytes()
    fuzz.make_case(1, "deck", 8, tmp_path / "case")
    assert made != (tmp_path / "case" / "deck.nml").read_bytes()
