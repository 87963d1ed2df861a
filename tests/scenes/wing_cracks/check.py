"""Wing cracks leave the tips of a closed flaw at 70.5 degrees: the mean over both tips of eight meshes."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np

from scene_motion import run_deck
from scene_wings import wing_angles

MESHES = 8
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
