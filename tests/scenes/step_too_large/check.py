"""The message names time, place, quantity and what to try."""

from pathlib import Path

from scene_motion import output_says


def check(results):
    words = (
        "the velocity has grown to ",
        "time ",
        "stage 'load'",
        "cycle 1",
        "node ",
        "x = ",
        "y = ",
        "try ",
    )
    output_says(results, *words)
    log = (Path(results) / "run.log").read_text(encoding="utf-8")
    assert "the velocity has grown to" in log, "run.log does not say why the run failed"
