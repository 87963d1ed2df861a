"""Wrong decks: every one ends with exit status 2 and a message that names what is wrong.

The cases are data: scenes/wrong_decks/cases.json replaces one piece of scenes/wrong_decks/base.nml each.
"""

import json
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "tests" / "scenes" / "wrong_decks"
BASE = (SCENE / "base.nml").read_text()
CASES = json.loads((SCENE / "cases.json").read_text())
# Two square blocks, one on the other, with a fracture between them.
MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
5
1 1 "bottom"
1 2 "fracture"
1 3 "top"
1 4 "side"
2 5 "rock"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 1 0 0
3 0 1 0
4 1 1 0
5 0 2 0
6 1 2 0
$EndNodes
$Elements
8
1 1 2 1 1 1 2
2 1 2 2 2 3 4
3 1 2 3 3 5 6
4 1 2 4 4 4 6
5 2 2 5 5 1 2 4
6 2 2 5 5 1 4 3
7 2 2 5 5 3 4 6
8 2 2 5 5 3 6 5
$EndElements
"""


def run(femdem, arguments, directory):
    return subprocess.run(
        [femdem, *arguments], cwd=directory, capture_output=True, text=True, timeout=60, check=False
    )


def check(femdem, deck, directory):
    """Write a deck (text or bytes) beside its mesh and let the femdem check it."""
    (directory / "box.msh").write_text(MESH)
    (directory / "input.nml").write_bytes(deck if isinstance(deck, bytes) else deck.encode())
    return run(femdem, ["--check", "input.nml"], directory)


def assert_wrong(result, *fragments):
    """Exit status 2, every line an error, every fragment in the messages."""
    assert result.returncode == 2, result.stderr
    assert result.stdout == ""
    assert all(line.startswith("error: ") for line in result.stderr.splitlines()), result.stderr
    for fragment in fragments:
        assert fragment in result.stderr


@pytest.mark.fast
@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
def test_wrong_deck(case, femdem, tmp_path):
    assert BASE.count(case["replace"]) == 1, "the piece to replace must be unique in the base deck"
    result = check(femdem, BASE.replace(case["replace"], case["by"]), tmp_path)
    assert_wrong(result, "input.nml", *case["expect"])


@pytest.mark.fast
def test_base_deck_is_good(femdem, tmp_path):
    result = check(femdem, BASE, tmp_path)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""


@pytest.mark.fast
def test_names_are_unique():
    names = [case["name"] for case in CASES]
    assert len(names) == len(set(names))


@pytest.mark.fast
def test_message_names_the_line(femdem, tmp_path):
    deck = BASE.replace("jrc0 = 9.7", "jrc0 = -3")
    line = deck.splitlines().index("   jrc0 = -3") + 1
    assert_wrong(
        check(femdem, deck, tmp_path),
        f"input.nml:{line}: &joint jrc0 = -3: must be at least 0 and at most 30",
    )


@pytest.mark.fast
def test_one_mistake_one_message(femdem, tmp_path):
    for wrong in ("jrc0 = -3", "jrc0 = 'rough'", "jrc0 = 1 2"):
        result = check(femdem, BASE.replace("jrc0 = 9.7", wrong), tmp_path)
        assert len(result.stderr.splitlines()) == 1, result.stderr


@pytest.mark.fast
def test_tension_is_cut_off_below_the_tip_of_the_cone(femdem, tmp_path):
    text = "&cohesive group = 'rock', tensile_strength = 4e6, cohesion = 6e6, friction_angle = {}, g_i = 20, g_ii = 60 /\n"
    # The last is no slope at all: the tip is beyond all numbers
    for angle in ("56", "0", "1e-300"):
        result = check(femdem, BASE + text.format(angle), tmp_path)
        assert result.returncode == 0, result.stderr
    result = check(femdem, BASE + text.format("57"), tmp_path)
    assert_wrong(
        result,
        "&cohesive tensile_strength = 4e6",
        "at most cohesion/tan(friction_angle) = 389644",
        "tip of the cone",
    )


@pytest.mark.fast
@pytest.mark.parametrize("option", ["--check", "--quiet"])
def test_unstable_step(option, femdem, tmp_path):
    """Known only when the scene has been built: refused before the first step, with both numbers."""
    check(femdem, BASE.replace("damping = 'local'", "damping = 'local'\n   step = 1e-3"), tmp_path)
    result = run(femdem, [option, "input.nml"], tmp_path)
    assert result.returncode == 2
    for fragment in ("&explicit step = ", "longer than the stable step", "stage 'load'"):
        assert fragment in result.stderr


ENDLESS = {
    "cycles": ("cycles = 50", "cycles = 999999999"),
    "time": ("name = 'load'\n   move_time = 0.01", "name = 'load'\n   move_time = 1e8"),
    "stiffness": ("phi_r = 31", "phi_r = 31\n   law = 'coulomb'\n   kn_mpa_mm = 1e9\n   ks_mpa_mm = 1e9"),
    "safety": ("damping = 'local'", "damping = 'local'\n   safety = 1e-4"),
}


@pytest.mark.fast
@pytest.mark.parametrize("what", ENDLESS)
def test_endless_runs_are_announced_before_they_start(what, femdem, tmp_path):
    old, new = ENDLESS[what]
    deck = BASE.replace(old, new).replace(
        "   law = 'jcm'\n", "" if what == "stiffness" else "   law = 'jcm'\n"
    )
    if what in ("stiffness", "safety"):
        deck = deck.replace("cycles = 50", "cycles = 90000")
    result = check(femdem, deck, tmp_path)
    assert result.returncode == 2
    assert "input.nml:2: &run long = .false.: the run would take about" in result.stderr
    assert "steps of 4 triangles, some " in result.stderr
    assert len(result.stderr.splitlines()) == 1
    # It is meant
    result = check(femdem, deck.replace("&run\n", "&run\n   long = .true.\n"), tmp_path)
    assert result.returncode == 0, result.stderr
    assert "effort    about" in result.stdout


@pytest.mark.fast
def test_endless_runs_of_other_solvers_too(femdem, tmp_path):
    deck = BASE.replace("'explicit'", "'implicit'").replace("cycles = 50", "cycles = 100000000")
    result = check(femdem, deck.replace("   damping = 'local'\n", ""), tmp_path)
    assert result.returncode == 2
    assert "the run would take 100000001 increments of 4 triangles, up to some " in result.stderr


@pytest.mark.fast
def test_no_deck_at_all(femdem, tmp_path):
    result = run(femdem, ["--check", "nothing.nml"], tmp_path)
    assert_wrong(result, "nothing.nml", "cannot be opened")
    assert len(result.stderr.splitlines()) == 1
    assert_wrong(run(femdem, ["--check", "."], tmp_path))


@pytest.mark.fast
@pytest.mark.parametrize(
    "content",
    [b"", b"\n\n", b"&", b"&runs", b"'", b"=/&"],
    ids=["empty", "blank lines", "ampersand", "name only", "quote", "signs"],
)
def test_no_deck_inside(content, femdem, tmp_path):
    assert_wrong(check(femdem, content, tmp_path), "&run is missing")


@pytest.mark.fast
@pytest.mark.parametrize(
    ("content", "expect"),
    [
        (b"\x00\x01\xff" * 5000, "is no text file"),
        (b"\x1f\x8b\x08" + bytes(range(256)) * 20, "is no text file"),
        (bytes(range(128, 256)) * 40, "is no text file"),
        (BASE.encode() + bytes(range(1, 256)) * 40, "is no text file"),
        (BASE.encode() * 20 + b"\x00\x01\x02", "is no text file"),
        (BASE.encode("utf-16"), "is written in UTF-16"),
        (BASE.encode("utf-16-le"), "is written in UTF-16"),
        (BASE.encode("utf-16-be"), "is written in UTF-16"),
    ],
    ids=["binary", "packed", "upper half", "at its end", "far behind", "UTF-16", "UTF-16 LE", "UTF-16 BE"],
)
def test_what_is_no_deck_has_one_message(content, expect, femdem, tmp_path):
    result = check(femdem, content, tmp_path)
    assert_wrong(result, expect)
    assert len(result.stderr.splitlines()) == 1, result.stderr


@pytest.mark.fast
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["LF", "CR LF", "CR"])
def test_a_comment_ends_with_its_line_whatever_ends_that(end, femdem, tmp_path):
    deck = "! On top\n" + BASE.replace("   vy = 0\n", "   vy = 0 ! held\n")
    assert check(femdem, deck.replace("\n", end), tmp_path).returncode == 0
    # One alone, in the middle: the group behind it counts
    wrong = BASE.replace("   pressure = 5e6\n", f"   ! five{end}   pressure = -a\n")
    assert_wrong(check(femdem, wrong, tmp_path), "&boundary pressure = -a: must be a number")
    wrong = BASE.replace("jrc0 = 9.7", "jrc0 = -3").replace("\n", end)
    assert_wrong(check(femdem, wrong, tmp_path), "input.nml:16: &joint jrc0 = -3")


@pytest.mark.fast
@pytest.mark.parametrize(
    ("old", "new", "expect"),
    [
        ("gy = -9.81", "gy = \u22129.81", "input.nml:38: found a minus sign (U+2212); must be the plain -"),
        ("gy = -9.81", "gy =\u00a0-9.81", "input.nml:38: found a no-break blank (U+00A0)"),
        ("jrc0 =", "jrc0\u200b =", "input.nml:16: found a zero-width blank (U+200B)"),
        (
            "'top'",
            "\u2018top\u2019",
            "input.nml:29: found an opening quotation mark (U+2018); must be the plain '",
        ),
        (
            "! A good deck.",
            "! A good deck.\u2028&stage",
            "input.nml:1: found a line separator (U+2028) in a comment",
        ),
        ("gy = -9.81", "gy = -9.81\x0c", "input.nml:38: found a form feed (U+000C)"),
        ("gy = -9.81", "gy = 9\u00b2", "input.nml:38: found the character U+00B2"),
    ],
)
def test_characters_that_look_like_others_are_named(old, new, expect, femdem, tmp_path):
    result = check(femdem, BASE.replace(old, new), tmp_path)
    assert_wrong(result, expect)
    assert len(result.stderr.splitlines()) == 1, result.stderr


@pytest.mark.fast
def test_anything_may_stand_in_comments_and_texts(femdem, tmp_path):
    deck = BASE.replace("Two blocks", "Zwei Bl\u00f6cke \u2013 a\u00a0b").replace(
        "! A good", "! Ein \u2212 guter"
    )
    assert check(femdem, "\ufeff" + deck, tmp_path).returncode == 0


@pytest.mark.fast
@pytest.mark.parametrize(
    ("arguments", "expect"),
    [
        (["--chek", "input.nml"], "did you mean --check?"),
        (["--output"], "needs a directory"),
        ([], "no deck given"),
        (["a.nml", "b.nml"], "one deck at a time"),
    ],
)
def test_wrong_command_line(arguments, expect, femdem, tmp_path):
    assert_wrong(run(femdem, arguments, tmp_path), expect)


@pytest.mark.fast
def test_help_and_version(femdem, tmp_path):
    for option, expect in (("--help", "exit status"), ("--version", "femdem 0.")):
        result = run(femdem, [option], tmp_path)
        assert result.returncode == 0
        assert expect in result.stdout
        assert result.stderr == ""
