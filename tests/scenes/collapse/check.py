"""The message tells load level, place and block edge; history, fields and collapse.csv hold the last rest and what moved."""

import csv
import math
import re
from pathlib import Path

from scene_motion import output_says


def check(results):
    said = output_says(
        results, "nothing holds the load", "stage 'push'", "block edges that slip: 1 at", "explicit"
    )
    held = math.tan(math.radians(31))
    level = float(re.search(r"load level (\S+?)\)", said).group(1))
    assert held < level < held + 0.15, f"collapse at load level {level}, friction holds {held:.3f}"
    with (Path(results) / "history.csv").open(newline="", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    stress = float(last["joint.shear_stress_MPa"])
    assert level - 0.15 < stress < held, f"the last rest carries {stress} MPa"
    assert float(last["unbalanced_ratio"]) < 1e-6
    assert abs(float(last["joint.shear_displacement_mm"])) < 1.0, "the last rest is no rest"
    with (Path(results) / "collapse.csv").open(newline="", encoding="utf-8") as file:
        (edge,) = csv.DictReader(file)
    assert float(edge["mean_shear_displacement_mm"]) > 10.0, "the slip of the collapse is missing"
