"""The deck beside the results, and restarts: from that deck, and refused with every difference that matters named.

Two squares with a joint (test_wrong_decks), pressed in one stage and sheared in a second.
"""

import csv
import re
import shutil
import subprocess

import h5py
import pytest

from femdem.results import Results
from test_wrong_decks import MESH

DECK = """
&run mesh = '../mesh/box.msh', solver = 'implicit' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /
&joint group = 'fracture', law = 'coulomb', friction_angle = 30, kn_mpa_mm = 10, ks_mpa_mm = 5 /
&contact friction_angle = 30 /
&boundary group = 'bottom', vx = 0, vy = 0 /
&boundary group = 'top', pressure = 5e6 /
&stage name = 'load', move_time = 0.01, cycles = 2 /
&output directory = 'out/first' /
"""
SHEAR = "&stage name = 'shear', move_time = 0.01 /\n&boundary group = 'top', stage = 'shear', tx = 1e5 /\n"


@pytest.fixture
def folder(tmp_path):
    for name in ("mesh", "deck"):
        (tmp_path / name).mkdir()
    (tmp_path / "mesh" / "box.msh").write_text(MESH)
    (tmp_path / "deck" / "user.nml").write_text(DECK)
    return tmp_path


def run(femdem, folder, *arguments, status=0):
    command = [femdem, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stderr


@pytest.mark.fast
def test_the_deck_beside_the_results_can_be_checked_run_and_gone_on_from(femdem, folder):
    run(femdem, folder, "deck/user.nml")
    results = folder / "deck" / "out" / "first"
    run(femdem, folder, "--check", results / "deck.nml")
    run(femdem, results, "--check", "deck.nml")
    history = (results / "history.csv").read_text()
    # The whole folder may be moved
    (folder / "elsewhere").mkdir()
    for name in ("mesh", "deck"):
        shutil.move(folder / name, folder / "elsewhere" / name)
    results = folder / "elsewhere" / "deck" / "out" / "first"
    run(femdem, results, "--restart", "checkpoint.h5", "deck.nml")
    assert (results / "history.csv").read_text() == history
    (results / "history.csv").unlink()
    run(femdem, folder, results / "deck.nml")
    assert (results / "history.csv").read_text() == history
    assert (results / "deck.nml").read_text().count("mesh = '../../../mesh/box.msh'") == 1


@pytest.mark.fast
@pytest.mark.parametrize("how", ["--output", "directory"])
def test_a_deck_of_the_user_is_not_replaced(how, femdem, folder):
    deck = folder / "deck" / "deck.nml"
    deck.write_text(DECK.replace("out/first", "." if how == "directory" else "out"))
    before = deck.read_bytes()
    options = ["--output", "."] if how == "--output" else []
    for name in ("deck.nml", "user.nml"):
        (folder / "deck" / "user.nml").write_bytes(before)
        said = run(femdem, folder / "deck", *options, name, status=2)
        assert "deck.nml is no deck that the program has written" in said
    assert deck.read_bytes() == before
    assert sorted(path.name for path in (folder / "deck").iterdir()) == ["deck.nml", "user.nml"]


CHANGES = [
    ("young = 30e9", "young = 20e9", "&material group = 'rock': young was 3e10", "is 2e10"),
    ("ks_mpa_mm = 5", "ks_mpa_mm = 6", "&joint group = 'fracture': ks_mpa_mm was 5", "is 6"),
    ("friction_angle = 30 /", "friction_angle = 20 /", "&contact: friction_angle was 30", "is 20"),
    ("pressure = 5e6", "pressure = 6e6", "&boundary group = 'top', stage = 'all': pressure was", "is 6"),
    ("name = 'load'", "name = 'press'", "&stage 1: name was 'load'", "is 'press'"),
    ("cycles = 2", "cycles = 3", "&stage 1: cycles was 2", "is 3"),
    ("&output", "&gravity gy = -9.81 /\n&output", "&gravity: gy was 0", "is -9.81"),
    ("vx = 0, vy = 0", "vy = 0", "&boundary group = 'bottom', stage = 'all': vx was 0", "is not given"),
    (
        "&output",
        "&boundary group = 'side', vx = 0 /\n&output",
        "was written without &boundary group = 'side'",
        "",
    ),
    ("&boundary group = 'top', pressure = 5e6 /", "", "was written with &boundary group = 'top'", ""),
]


@pytest.mark.fast
@pytest.mark.parametrize(("old", "new", "group", "value"), CHANGES, ids=[change[1] for change in CHANGES])
def test_a_restart_names_what_differs_in_the_deck(old, new, group, value, femdem, folder):
    run(femdem, folder, "deck/user.nml")
    assert DECK.count(old) == 1
    (folder / "deck" / "user.nml").write_text(DECK.replace(old, new) + SHEAR)
    checkpoint = "deck/out/first/checkpoint.h5"
    said = run(femdem, folder, "--branch", checkpoint, "--output", "second", "deck/user.nml", status=2)
    assert group in said
    assert value in said
    assert len(said.splitlines()) == 1, said


@pytest.mark.fast
def test_a_branch_may_add_stages_and_change_how_it_is_solved_and_written(femdem, folder):
    run(femdem, folder, "deck/user.nml")
    deck = DECK.replace("out/first", "out/second") + SHEAR + "&implicit tolerance = 1e-7 /\n"
    (folder / "deck" / "user.nml").write_text(deck)
    run(femdem, folder, "--branch", "deck/out/first/checkpoint.h5", "deck/user.nml")


RESTART_CHANGES = [
    ("'implicit'", "'relaxation'", "&run: solver was 'implicit' when it was written, and is 'relaxation'"),
    ("&output", "&stage name = 'more', move_time = 1 /\n&output", "was written without &stage 2"),
    ("&output", "&implicit tolerance = 1e-8 /\n&output", "&implicit: tolerance was 1e-7 when it was written"),
    ("move_time = 0.01", "move_time = 0.02", "&stage 1: move_time was 0.01"),
]


@pytest.mark.fast
@pytest.mark.parametrize(("old", "new", "expect"), RESTART_CHANGES, ids=[c[1][:20] for c in RESTART_CHANGES])
def test_a_restart_goes_on_with_the_same_run_only(old, new, expect, femdem, folder):
    """Later stages, solver and its settings too; --branch says that they are changed on purpose"""
    run(femdem, folder, "deck/user.nml")
    checkpoint = "deck/out/first/checkpoint.h5"
    (folder / "deck" / "user.nml").write_text(DECK.replace(old, new))
    said = run(femdem, folder, "--restart", checkpoint, "deck/user.nml", status=2)
    assert expect in said
    assert "--branch in its place goes on with other stages" in said
    if "move_time = 0.02" not in new:
        run(femdem, folder, "--branch", checkpoint, "--output", "second", "deck/user.nml")


@pytest.mark.fast
def test_a_restart_may_change_what_is_written_and_where(femdem, folder):
    run(femdem, folder, "deck/user.nml")
    deck = DECK.replace("&run", "&run title = 'again',").replace("out/first' /", "out/2', fields_every = 1 /")
    (folder / "deck" / "user.nml").write_text(deck)
    run(femdem, folder, "--restart", "deck/out/first/checkpoint.h5", "deck/user.nml")


@pytest.mark.fast
@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("4 1 1 0", "4 1.01 1 0", "nodes at other places"),
        ("2 1 2 2 2 3 4\n", "2 1 2 2 2 1 2\n", "has 1 joints"),
        ('1 4 "side"', '1 4 "Side"', "other groups"),
        ("7 2 2 5 5 3 4 6\n8 2 2 5 5 3 6 5\n", "7 2 2 5 5 3 4 5\n8 2 2 5 5 4 6 5\n", "other corners"),
    ],
    ids=["moved", "joint", "group", "diagonal"],
)
def test_a_restart_names_what_differs_in_the_mesh(old, new, what, femdem, folder):
    run(femdem, folder, "deck/user.nml")
    assert MESH.count(old) == 1
    mesh = MESH.replace(old, new)
    if what.startswith("has"):
        # A third square below, so that the fracture can be somewhere else: two lines in place of one
        mesh = MESH.replace("8\n1 1 2 1", "9\n9 1 2 2 2 1 4\n1 1 2 1")
    (folder / "mesh" / "box.msh").write_text(mesh)
    (folder / "deck" / "user.nml").write_text(DECK + SHEAR)
    checkpoint = "deck/out/first/checkpoint.h5"
    said = run(femdem, folder, "--branch", checkpoint, "--output", "second", "deck/user.nml", status=2)
    assert what in said


@pytest.mark.fast
def test_masses_that_were_raised_are_not_forgotten(femdem, folder):
    scaled = "&explicit mass_scaling = 'step', scaled_step = 1e-3 /\n"
    deck = DECK.replace("implicit", "explicit") + scaled
    (folder / "deck" / "user.nml").write_text(deck)
    run(femdem, folder, "deck/user.nml")
    options = ("--branch", "deck/out/first/checkpoint.h5", "--output", "second", "deck/user.nml")
    (folder / "deck" / "user.nml").write_text(deck.replace(scaled, "") + SHEAR)
    said = run(femdem, folder, *options, status=2)
    assert "&explicit: mass_scaling was 'step' when it was written, and is 'none' in this deck" in said
    # A solver without masses may go on
    (folder / "deck" / "user.nml").write_text(DECK + SHEAR)
    run(femdem, folder, *options)


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["implicit", "relaxation"])
def test_a_run_that_fails_leaves_its_last_cycle_everywhere(femdem, folder, solver):
    """A block pushed until nothing holds it: history, fields and checkpoint hold the cycle before."""
    push = "&stage name = 'push', move_time = 0.01, cycles = 5 /\n&boundary group = 'top', stage = 'push', tx = 4e6 /\n"
    sparse = (
        "&output directory = 'out/first', history_every = 10, fields_every = 0, checkpoint_minutes = 100 /\n"
    )
    deck = DECK.replace("'implicit'", f"'{solver}'").replace(
        "&output directory = 'out/first' /\n", push + sparse
    )
    (folder / "deck" / "user.nml").write_text(deck + "&relaxation max_steps = 3000 /\n")
    said = run(femdem, folder, "deck/user.nml", status=1)
    cycle = int(re.search(r"stage 'push', cycle (\d)", said).group(1)) - 1
    assert cycle >= 1
    results = folder / "deck" / "out" / "first"
    end = 0.02 + 0.01 * cycle
    with (results / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert any(row["cycle"] == str(cycle) and float(row["time_s"]) == pytest.approx(end) for row in rows)
    times = Results(results).fields.times
    assert any(time == pytest.approx(end) for time in times), times
    with h5py.File(results / "checkpoint.h5") as file:
        assert file.attrs["time"] == pytest.approx(end)
    # From there it goes the same way again
    slip = Results(results).history["fracture.shear_displacement_mm"]
    again = run(femdem, folder, "--restart", results / "checkpoint.h5", "deck/user.nml", status=1)
    assert f"cycle {cycle + 1}" in again
    assert Results(results).history["fracture.shear_displacement_mm"] == pytest.approx(slip, rel=1e-6)
