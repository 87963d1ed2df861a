"""With edges along the crack the strength is Hondros': what other meshes add is the angle of their edges."""

import csv
import math
from pathlib import Path

HALF_ARC, STRENGTH = math.radians(15), 7e6
START, END, BEGIN, DURATION = 38e6, 48e6, 0.02, 40e-3


def check(results):
    with open(Path(results) / "cracks.csv", encoding="utf-8") as file:
        cracks = list(csv.DictReader(file))
    first = cracks[0]
    pressure = START + (END - START) * (float(first["time_s"]) - BEGIN) / DURATION
    # Hondros (1959), as in brazilian
    found = 2 * pressure * (math.sin(2 * HALF_ARC) - HALF_ARC) / math.pi
    error = found / STRENGTH - 1
    print(f"tensile strength: expected {STRENGTH / 1e6:.3f}, found {found / 1e6:.3f} MPa ({error:+.2%})")
    # The crack runs on at the load at which it starts: this is the peak
    along = [c for c in cracks if abs(float(c["x_m"])) < 1e-6 and abs(float(c["y_m"])) < 0.6]
    spread = max(float(c["time_s"]) for c in along) - float(first["time_s"])
    rise = (END - START) / DURATION * spread / pressure
    print(
        f"{len(along)} edges on the diameter break within {spread * 1e3:.2f} ms, a rise of the load of {rise:.2%}"
    )
    assert first["mode"] == "I"
    assert abs(float(first["x_m"])) < 1e-6
    assert abs(error) < 0.025, f"tensile strength {found / 1e6:.3f}, expected {STRENGTH / 1e6:.3f} MPa"
    assert len(along) >= 16, "the disc does not split along its diameter"
    assert rise < 0.02, "the disc does not split at once"
