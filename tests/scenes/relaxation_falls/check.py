"""The message names stage and place, which is on the loose block, and says what to do."""

import re
from pathlib import Path


def check(results):
    said = (Path(results).parent / "output.txt").read_text(encoding="utf-8")
    for word in ("does not come to rest", "stage 'fall'", "explicit"):
        assert word in said, f"'{word}' is missing in: {said}"
    y = float(re.search(r"y = (\S+?) ", said).group(1))
    assert y <= 0.1, f"the place, y = {y}, is not on the loose block"
