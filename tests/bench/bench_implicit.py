#!/usr/bin/env python3
"""Time and error of the implicit solver on the direct shear tests of 6, 12, 18 and 36 cm.

    python3 tests/bench/bench_implicit.py [--size 0.001] [--program build/femdem] [--folder DIR]

Each run is the deck of input/direct_shear, whose solver = 'auto' takes the implicit one: 0 to 5 mm in 500 rows. Printed are
triangles, the user time of the whole program on one thread, and the error against eq 13 in per cent of the peak.
"""

import argparse
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(TOP / "postproc"))

from femdem.jcm import Joint  # noqa: E402
from femdem.results import Results  # noqa: E402

LENGTHS_CM = (6, 12, 18, 36)
NORMAL_STRESS_MPA = 0.0245


def implicit_deck(length_cm, folder):
    """The deck of a length, for the implicit solver."""
    deck = (TOP / "input" / "direct_shear" / f"shear_{length_cm}cm.nml").read_text(encoding="utf-8")
    deck = deck.replace("solver = 'auto'", "solver = 'implicit'")
    path = folder / f"shear_{length_cm}cm.nml"
    path.write_text(deck, encoding="utf-8")
    return path


def run(length_cm, arguments):
    """Mesh, run and measure one length; returns seconds."""
    script = TOP / "input" / "direct_shear" / "make_mesh.py"
    mesh = arguments.folder / f"shear_{length_cm}cm.msh"
    make = [
        sys.executable,
        script,
        "--length",
        f"{length_cm / 100}",
        "--size",
        f"{arguments.size}",
        "--out",
        mesh,
    ]
    made = subprocess.run(make, check=True, capture_output=True, text=True)
    deck = implicit_deck(length_cm, arguments.folder)
    results = arguments.folder / f"results_{length_cm}cm"
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([arguments.program, "--quiet", "--output", results, deck], check=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    history = Results(results).history
    joint = Joint(jrc0=15, jcs0=2, l0=0.06, phi_r=32, length=length_cm / 100)
    law = joint.shear_stress(history["joint.shear_displacement_mm"], NORMAL_STRESS_MPA)
    error = (history["joint.shear_stress_MPa"] - law) / joint.peak_shear_stress(NORMAL_STRESS_MPA)
    triangles = re.search(r"(\d+) triangles", made.stdout)[1]
    seconds = after.ru_utime - before.ru_utime
    print(
        f"{length_cm:3d} cm {triangles:>6} triangles {seconds:6.2f} s   "
        f"error {100 * np.sqrt(np.mean(error**2)):.3f} % rms, {100 * abs(error).max():.2f} % at most; "
        f"unbalanced {history['unbalanced_ratio'].max():.1e}",
        flush=True,
    )
    return seconds


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--size", type=float, default=0.001, help="element size along the joint in m (default 0.001)"
    )
    parser.add_argument("--program", type=Path, default=TOP / "build" / "femdem", help="program to measure")
    parser.add_argument(
        "--folder", type=Path, default=TOP / "results" / "bench_implicit", help="where everything goes"
    )
    arguments = parser.parse_args()
    arguments.program = arguments.program.resolve()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print(f"together {sum(run(length, arguments) for length in LENGTHS_CM):.2f} s")


if __name__ == "__main__":
    main()
