"""Variables of a deck changed in its text: only they change, and what cannot be meant is named."""

import difflib
from pathlib import Path

import pytest

from femdem.deck_text import change, groups_of, value_of
from femdem.results import ResultsError, parse_deck
from femdem.sweep.plan import mesh_commands, with_argument
from femdem.sweep.table import read_table

TOP = Path(__file__).resolve().parent.parent
DECK = (TOP / "input" / "network" / "phase_2b.nml").read_text()

pytestmark = [pytest.mark.fast, pytest.mark.tools]

CHANGES = {
    "number": ("joint.jrc0", 12.5, [("joint", "jrc0", 12.5)]),
    "text of a number": ("joint.jrc0", "1.25d1", [("joint", "jrc0", 12.5)]),
    "word in quotes": ("joint.law", "coulomb", [("joint", "law", "coulomb")]),
    "title that looks like a number": ("run.title", "7", [("run", "title", "7")]),
    "quote in a text": ("run.title", "it's", [("run", "title", "it's")]),
    "new number": ("joint.friction_angle", 31, [("joint", "friction_angle", 31)]),
    "new word": ("joint.peak", "eq14", [("joint", "peak", "eq14")]),
    "new switch": ("output.all", True, [("output", "all", True)]),
    "one of many": ("boundary[top, phase_2b].syy", 6e6, [("boundary", "syy", 6e6)]),
    "all of a name": ("stage.cycles", 5, [("stage", "cycles", 5)] * 2),
    "those that have it": ("boundary.vx", 1, [("boundary", "vx", 1)]),
}


@pytest.mark.parametrize("case", CHANGES)
def test_only_what_is_named_changes(case):
    path, value, expected = CHANGES[case]
    new = change(DECK, path, value)
    found = []
    for (name, before), (_, after) in zip(parse_deck(DECK), parse_deck(new), strict=True):
        found += [(name, key, after[key]) for key in after if after[key] != before.get(key)]
        assert set(before) <= set(after)
    assert found == expected
    lines = [line for line in difflib.ndiff(DECK.splitlines(), new.splitlines()) if line[0] in "+-"]
    assert len(lines) == 2 * len(expected)


def test_comments_and_quotes_are_no_variables():
    text = "! &joint jrc0 = 1 /\n&joint group = 'a = 1 / &b', ! jrc0 = 2 /\n  jrc0 = 3 ! jrc0 = 4\n/\n"
    assert [group.name for group in groups_of(text)] == ["joint"]
    assert value_of(text, "joint.jrc0") == "3"
    assert value_of(text, "joint[a = 1 / &b].jrc0") == "3"
    assert change(text, "joint.jrc0", 5) == text.replace("jrc0 = 3", "jrc0 = 5")
    assert "  jrc0 = 3, l0 = 1 ! jrc0 = 4\n" in change(text, "joint.l0", 1)
    assert change("&flow /\n", "flow.coupling", "one-way") == "&flow coupling = 'one-way' /\n"


WRONG = {
    "joints.jrc0": "no &joints; it has: run, material",
    "joint[fault].jrc0": "no &joint has fault; there are: fractures",
    "jrc0": "must be GROUP",
}


@pytest.mark.parametrize("path", WRONG)
def test_what_is_not_there_is_named(path):
    with pytest.raises(ResultsError, match=WRONG[path]):
        change(DECK, path, 1)


def test_a_group_that_is_not_closed():
    with pytest.raises(ResultsError, match="&run is not closed"):
        groups_of("&run mesh = 'a'\n")


def test_arguments_of_the_mesh_script():
    deck = TOP / "input" / "network" / "realisations.nml"
    commands = mesh_commands(deck, deck.read_text())
    assert [one["name"] for one in commands] == ["femdem-traces", "femdem-mesh"]
    # In the command that has it; of what has more values all; what none has goes to the last
    words = [one["words"] for one in with_argument(commands, "seed", 7)]
    assert words[0][:2] == ["--seed", "7"]
    assert words[1] == commands[1]["words"]
    words = with_argument(commands, "window", [0, 0, 1, 1])[1]["words"]
    place = words.index("--window")
    assert words[place : place + 6] == ["--window", "0", "0", "1", "1", "--out"]
    assert with_argument(commands, "min_angle", 20)[1]["words"][-2:] == ["--min-angle", "20"]
    # Traces that a command before makes are not taken for a file beside the deck; those that are there are found
    assert commands[1]["words"][0] == "realisation.csv"
    deck = TOP / "input" / "network" / "phase_1.nml"
    assert mesh_commands(deck, deck.read_text())[0]["words"][0] == str(deck.with_name("two_sets.csv"))


def test_tables_in_csv(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("# comment\njoint.jrc0, mesh.size\n8 , 0.1\n9,0.1\n")
    assert read_table(path).rows == [
        {"joint.jrc0": "8", "mesh.size": "0.1"},
        {"joint.jrc0": "9", "mesh.size": "0.1"},
    ]
    path.write_text("joint.jrc0,joint.jrc0\n8,9\n")
    with pytest.raises(ResultsError, match="is there twice"):
        read_table(path)
    with pytest.raises(ResultsError, match="no such file"):
        read_table(tmp_path / "none.csv")
