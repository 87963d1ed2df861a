"""Wing cracks leave the tips of a closed flaw at 70.5 degrees: the mean over both tips of eight meshes."""

import csv
import math
import subprocess
import sys
from pathlib import Path

import numpy as np

from scene_motion import run_deck

ANGLE, HALF, MESHES = 45.0, 0.25, 8
# A crack is measured over this distance from the tip, well below the flaw's half-length: farther away it bends
REACH = 0.07
MESH = [
    "--width",
    "2",
    "--height",
    "2",
    "--flaw",
    "0.5",
    "--angle",
    "45",
    "--size",
    "0.008",
    "--coarse",
    "0.15",
    "--fine",
    "0.1",
]


def wing_angles(results):
    """Angle of the crack at each tip from the continuation of the flaw [degrees]"""
    along = np.array([math.cos(math.radians(ANGLE)), math.sin(math.radians(ANGLE))])
    across = np.array([-along[1], along[0]])
    with open(Path(results) / "cracks.csv", encoding="utf-8") as file:
        places = np.array([[float(row["x_m"]), float(row["y_m"])] for row in csv.DictReader(file)])
    angles = []
    for side in (1, -1):
        away = (places - side * HALF * along) @ (side * np.array([along, across])).T
        away = away[np.argsort(np.hypot(*away.T))]
        crack = away[np.hypot(*away.T) < REACH]
        assert len(crack) > 3, f"no wing crack at tip {side}"
        axis = np.linalg.svd(crack - crack.mean(axis=0))[2][0]
        axis *= np.sign(axis @ (crack[-1] - crack[0]))
        angles.append(math.degrees(math.atan2(axis[1], axis[0])))
    return angles


def check(results):
    folder = Path(results).parent
    angles = wing_angles(results)
    for seed in range(2, MESHES + 1):
        mesh = [sys.executable, "specimens.py", "flaw", *MESH, "--seed", str(seed)]
        subprocess.run(mesh, cwd=folder, check=True, capture_output=True)
        angles += wing_angles(run_deck(folder, "press.nml", f"results_{seed}", timeout=600))
    # Direction of the largest hoop stress in mode II: cos(theta) = 1/3 (Erdogan and Sih 1963)
    expected = math.degrees(math.acos(1 / 3))
    print("angles:", " ".join(f"{angle:.1f}" for angle in angles))
    print(
        f"mean: expected {expected:.1f}, found {np.mean(angles):.1f}, standard deviation {np.std(angles):.1f}"
    )
    assert abs(np.mean(angles) - expected) < 8, f"mean angle {np.mean(angles):.1f}, expected {expected:.1f}"
