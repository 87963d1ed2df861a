"""The load at which the crack grows gives the fracture toughness sqrt(G_I E/(1 - nu^2))."""

import csv
import math
from pathlib import Path

import numpy as np

from scene import read_history

WIDTH, HALF_CRACK, SPEED = 3.2, 0.4, 0.006
# Joints that break before the crack counts as growing
GROWN = 6
TOUGHNESS = math.sqrt(100 * 30e9 / (1 - 0.27**2))


def check(results):
    history = read_history(results / "history.csv")
    time = np.concatenate([[0.0], history["time_s"]])
    work = np.concatenate([[0.0], history["external_J"]])
    stress = np.diff(work) / (np.diff(time) * SPEED * WIDTH)
    with open(Path(results) / "cracks.csv", encoding="utf-8") as file:
        broken = [float(row["time_s"]) for row in csv.DictReader(file)]
    assert len(broken) >= GROWN, "the crack has not grown"
    # The largest load before the crack has grown by some elements; where the mesh ahead is coarse it may stop again
    stress = stress[: np.searchsorted(history["time_s"], broken[GROWN - 1]) + 1]
    # Feddersen's finite-width correction; the plate is twice as high as wide
    found = stress.max() * math.sqrt(math.pi * HALF_CRACK / math.cos(math.pi * HALF_CRACK / WIDTH))
    error = found / TOUGHNESS - 1
    print(f"toughness: expected {TOUGHNESS / 1e6:.4f}, found {found / 1e6:.4f} MPa m^0.5 ({error:+.2%})")
    assert abs(error) < 0.05, f"toughness {found / 1e6:.4f}, expected {TOUGHNESS / 1e6:.4f} MPa m^0.5"
