"""The message names time, place, quantity and what to try."""

from pathlib import Path


def check(results):
    said = (Path(results).parent / "output.txt").read_text(encoding="utf-8")
    for word in (
        "the velocity has grown to ",
        "time ",
        "stage 'load'",
        "cycle 1",
        "node ",
        "x = ",
        "y = ",
        "try ",
    ):
        assert word in said, f"'{word}' is missing in: {said}"
    log = (Path(results) / "run.log").read_text(encoding="utf-8")
    assert "the velocity has grown to" in log, "run.log does not say why the run failed"
