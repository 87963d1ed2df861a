"""The account is warned of when it is off by a twentieth, and the run fails when that becomes half: at once where it stays so."""

from pathlib import Path

from femdem.results import Results
from scene_motion import changed_deck, output_says, run_deck


def check(results):
    # What is missing grows and grows, and ends the run
    output_says(
        results,
        "error: the energy account is off by ",
        " of the work put in at time ",
        "stage 'load', cycle ",
        "_J changed most",
    )
    assert Results(results).history["cycle"][-1] < 60, "the run went on"

    # It has not lasted at the end of the run
    folder = Path(results).parent
    short = changed_deck(folder, "impact.nml", "short.nml", ("cycles = 60", "cycles = 16"))
    said = (run_deck(folder, short, "short", status=1) / "run.log").read_text(encoding="utf-8")
    assert "error: the energy account was off by " in said
    assert Results(folder / "short").history["cycle"][-1] == 16

    # A softer contact: the account closes better, but the contact gives out what it never took up, half of the work and more ...
    body = "group = '{}', density = 2700, young = 1e8, poisson = 0.25, penalty_factor = {}"
    softer = [(body.format(name, 500), body.format(name, 100)) for name in ("left", "right")]
    soft = changed_deck(folder, "impact.nml", "soft.nml", ("step = 1.6e-5", "step = 1.3e-5"), *softer)
    said = (run_deck(folder, soft, "soft", status=1) / "run.log").read_text(encoding="utf-8")
    assert "error: the contact has given out " in said
    # ... and with a step less than half as long a part of it: a warning when it happens and one at the end
    soft = changed_deck(folder, "impact.nml", "softer.nml", ("step = 1.6e-5", "step = 0.6e-5"), *softer)
    said = (run_deck(folder, soft, "softer") / "run.log").read_text(encoding="utf-8")
    assert said.count("warning: the contact has given out ") == 2
    assert said.count(" % of the work put in more than it took up at time ") == 1
    assert "the energy account" not in said
