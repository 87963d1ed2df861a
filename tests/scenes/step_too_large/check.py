"""The message names time, place, quantity and what to try."""

from pathlib import Path


def check(results):
    said = (Path(results).parent / "output.txt").read_text(encoding="utf-8")
    for word in ("no longer finite", "time ", "stage 'load'", "cycle 1", "node ", "x = ", "y = ", "try "):
        assert word in said, f"'{word}' is missing in: {said}"
    log = (Path(results) / "run.log").read_text(encoding="utf-8")
    assert "no longer finite" in log, "run.log does not say why the run failed"
