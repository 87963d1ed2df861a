"""The warning comes when the account is off by a twentieth, the failure at half; the last cycle before it is kept."""

from pathlib import Path

from femdem.results import Results
from scene_motion import changed_deck, output_says, run_deck


def check(results):
    output_says(
        results,
        "warning: the energy account is off by ",
        "error: the energy account is off by ",
        " of the work put in at time ",
        "stage 'load', cycle ",
        "lost while kinetic_J changed most",
    )
    history = Results(results).history
    part = abs(history["residual_J"]) / history["kinetic_J"][0]
    assert part[-1] < 0.5, "the failed cycle has been recorded"
    last = int(history["cycle"][-1])
    assert 10 < last < 30

    # One cycle less than the failure: the run ends, with the warning said again at its end
    folder = Path(results).parent
    short = changed_deck(folder, "impact.nml", "short.nml", ("cycles = 60", f"cycles = {last}"))
    run_deck(folder, short, "short")
    said = (folder / "short" / "run.log").read_text(encoding="utf-8")
    assert said.count("warning: the energy account is off by ") == 1
    assert said.count("warning: the energy account was off by ") == 1
