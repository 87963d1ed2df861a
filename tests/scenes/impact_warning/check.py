"""The run warns that contact has given out energy."""

from pathlib import Path


def check(results):
    said = (Path(results).parent / "output.txt").read_text(encoding="utf-8")
    assert "the contact has given out" in said, f"no warning in: {said}"
