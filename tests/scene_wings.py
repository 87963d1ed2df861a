"""Wing cracks of a closed inclined flaw, that the scenes with one share."""

import csv
import math
from pathlib import Path

import numpy as np

FLAW_ANGLE, FLAW_HALF = 45.0, 0.25
# A crack is measured over this distance from the tip, well below the flaw's half-length: farther away it bends
WING_REACH = 0.07


def wing_angles(results):
    """Angle of the wing crack at each tip from the continuation of the flaw [degrees]"""
    along = np.array([math.cos(math.radians(FLAW_ANGLE)), math.sin(math.radians(FLAW_ANGLE))])
    across = np.array([-along[1], along[0]])
    with open(Path(results) / "cracks.csv", encoding="utf-8") as file:
        places = np.array([[float(row["x_m"]), float(row["y_m"])] for row in csv.DictReader(file)])
    angles = []
    for side in (1, -1):
        away = (places - side * FLAW_HALF * along) @ (side * np.array([along, across])).T
        away = away[np.argsort(np.hypot(*away.T))]
        crack = away[np.hypot(*away.T) < WING_REACH]
        assert len(crack) > 3, f"no wing crack at tip {side}"
        axis = np.linalg.svd(crack - crack.mean(axis=0))[2][0]
        axis *= np.sign(axis @ (crack[-1] - crack[0]))
        angles.append(math.degrees(math.atan2(axis[1], axis[0])))
    return angles
