"""The account is warned of when it is off by a twentieth, and the run fails when that becomes half: at once where it stays so."""

from pathlib import Path

from femdem.results import Results
from scene_motion import changed_deck, output_says, run_deck


def check(results):
    output_says(
        results,
        "warning: the energy account is off by ",
        "error: the energy account was off by ",
        " of the work put in at time ",
        "stage 'load', cycle ",
        "lost while kinetic_J changed most",
    )
    assert Results(results).history["cycle"][-1] == 60

    # A third is missing: a warning when it happens, and one at the end
    folder = Path(results).parent
    short = changed_deck(folder, "impact.nml", "short.nml", ("cycles = 60", "cycles = 17"))
    run_deck(folder, short, "short")
    said = (folder / "short" / "run.log").read_text(encoding="utf-8")
    assert said.count("warning: the energy account was off by ") == 1

    # Stiffer: what is missing grows and grows, and ends the run
    body = "group = '{}', density = 2700, young = 1e8, poisson = 0.25, penalty_factor = {}"
    stiffer = [(body.format(name, 100), body.format(name, 300)) for name in ("left", "right")]
    stiff = changed_deck(folder, "impact.nml", "stiff.nml", ("step = 1e-5", "step = 1.5e-5"), *stiffer)
    stiff_results = run_deck(folder, stiff, "stiff", status=1)
    said = (stiff_results / "run.log").read_text(encoding="utf-8")
    assert "error: the energy account is off by " in said
    assert Results(stiff_results).history["cycle"][-1] < 60, "the run went on"
