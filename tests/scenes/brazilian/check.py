"""The disc splits when the tension at its centre reaches the tensile strength."""

import csv
import math
from pathlib import Path

HALF_ARC, STRENGTH = math.radians(15), 7e6
START, END, BEGIN, DURATION = 38e6, 54e6, 0.02, 64 * 1e-3


def check(results):
    with open(Path(results) / "cracks.csv", encoding="utf-8") as file:
        first = next(csv.DictReader(file))
    pressure = START + (END - START) * (float(first["time_s"]) - BEGIN) / DURATION
    # Hondros (1959): pressure p on arcs of half-angle a gives the tension 2 p (sin 2a - a)/pi at the centre; for a -> 0
    # and P = p a D this is 2 P/(pi D)
    found = 2 * pressure * (math.sin(2 * HALF_ARC) - HALF_ARC) / math.pi
    error = found / STRENGTH - 1
    print(f"first crack at ({float(first['x_m']):.3f}, {float(first['y_m']):.3f}), mode {first['mode']}")
    print(f"tensile strength: expected {STRENGTH / 1e6:.3f}, found {found / 1e6:.3f} MPa ({error:+.2%})")
    assert math.hypot(float(first["x_m"]), float(first["y_m"])) < 0.6, (
        "the disc does not split from its middle"
    )
    assert abs(error) < 0.1, f"tensile strength {found / 1e6:.3f}, expected {STRENGTH / 1e6:.3f} MPa"
