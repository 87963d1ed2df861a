"""Kill the run while cracks grow and restart it; run the first stage alone and branch the second from it. Both must agree
bit for bit with the run that was left alone."""

from pathlib import Path

import h5py

from scene_motion import changed_deck, run_deck
from scene_restart import go_on, kill_midway, rows, same_fields, same_tables

CRACKS = 40  # of 176
FIELDS = ("displacement", "velocity", "stress_xx", "damage", "shear_displacement_mm", "normal_stress_MPa")


def check(results):
    folder = Path(results).parent
    killed = kill_midway(folder, "press.nml", "cracks.csv", CRACKS)
    with h5py.File(killed / "checkpoint.h5") as left, h5py.File(results / "checkpoint.h5") as end:
        cut, events, holds = len(left["crack_edges"]), len(left["crack_events"]), left["bonds"][:, 0]
        print(
            f"killed with {cut} edges cut, {events} broken, {int((holds == 0).sum())} of them handed to the contact"
        )
        assert 0 < cut < len(end["crack_edges"]), "the kill is not amid the cutting of edges"
        assert 0 < events < len(end["crack_events"]), "the kill is not amid the breaking"
        assert 0 < (holds == 0).sum() < len(holds), "no bond has been handed over yet, or all have"
    go_on(folder, "press.nml", killed)
    same_tables(results, killed, "history.csv", "cracks.csv", "edges.csv")
    same_fields(results, killed, *FIELDS)

    stage = "&stage name = 'confine', move_time = 3e-4, cycles = 20, profile = 'constant' /\n"
    loads = [
        f"&boundary group = '{side}', stage = 'confine', pressure = 1e6 /\n" for side in ("left", "right")
    ]
    alone = changed_deck(folder, "press.nml", "alone.nml", *((text, "") for text in (stage, *loads)))
    first = run_deck(folder, alone, "first")
    branch = run_deck(folder, "press.nml", "branch", "--branch", first / "checkpoint.h5")
    same_tables(results, branch, "cracks.csv", "edges.csv")
    whole, parts = (
        [
            line
            for path in paths
            for line in (path / "history.csv").read_text(encoding="utf-8").splitlines()[1:]
        ]
        for paths in ([results], [first, branch])
    )
    assert whole == parts, "the branch has another history"
    same_fields(results, branch, *FIELDS, every=False)

    # A deck in which nothing breaks cannot go on with these cracks; but from its own checkpoint rock may break
    sound = changed_deck(folder, alone, "sound.nml", ("group = 'all',", "group = 'all', insertion = 'none',"))
    run_deck(folder, sound, "refused", "--branch", first / "checkpoint.h5", status=2)
    assert "cracks in rock that cannot break" in (folder / "refused.txt").read_text(encoding="utf-8")
    unbroken = run_deck(folder, sound, "unbroken")
    short = changed_deck(folder, "press.nml", "short.nml", ("cycles = 20", "cycles = 1"))
    breaks = run_deck(folder, short, "breaks", "--branch", unbroken / "checkpoint.h5")
    assert rows(breaks / "cracks.csv") > 0, "nothing has broken after a stage in which nothing could"
