"""It says that nothing holds the load, and where the rock is that moves by more than the scene is large; cracks are listed."""

import csv
import re
from pathlib import Path

from scene_motion import output_says

HEIGHT = 0.2


def check(results):
    said = output_says(
        results, "nothing holds the load", "load level 0.500000", "explicit", never=["max_pseudo_steps"]
    )
    moved = float(re.search(r"most moves the rock near .*, by (\S+) m;", said).group(1))
    assert HEIGHT < moved < 2 * HEIGHT
    with (Path(results) / "cracks.csv").open(newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 2, "a bar two triangles wide parts at two edges"
