#!/usr/bin/env python3
"""Error of the slip of a closed inclined crack: element size, and where the error comes from.

    python3 tests/bench/inclined_crack.py [--sizes 0.016 0.008 0.0056 0.004 0.0028] [--results results/bench/inclined_crack]

Runs the decks of tests/scenes/inclined_crack (friction alone) and inclined_crack_springs (springs alone; springs that slide)
with elements of several sizes. Then, with friction alone, elements of one size along the crack in place of graded ones, a
smaller plate, less load, and stiffer walls. Writes inclined_crack.csv: error at the centre and largest one on the inner
90 %, in per cent of the slip at the centre.
"""

import argparse
import csv
import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
SCENES = TOP / "tests" / "scenes"
sys.path[:0] = [str(TOP / "postproc"), str(TOP / "tests")]
import numpy as np  # noqa: E402

from femdem.kept import make  # noqa: E402
from femdem.results import Results  # noqa: E402
from scene_crack import (  # noqa: E402
    ANGLE,
    HALF_LENGTH,
    MODULUS,
    STRESS,
    reference_slip,
    resolved,
    slip_error,
)

PROGRAM = TOP / "build" / "femdem"
FRICTION_DECK = SCENES / "inclined_crack" / "crack.nml"
SPRINGS_DECK = SCENES / "inclined_crack_springs" / "springs.nml"
# Name, deck, changes of it, shear stiffness [Pa/m], friction angle [degrees]
VARIANTS = (
    ("friction", FRICTION_DECK, (), np.inf, 15.0),
    ("springs", SPRINGS_DECK, (), 60e9, None),
    (
        "springs and friction",
        SPRINGS_DECK,
        (("friction_angle = 80", "friction_angle = 30"), ("ks_mpa_mm = 60", "ks_mpa_mm = 150")),
        150e9,
        30.0,
    ),
)
# With friction alone: what, arguments of the mesher, changes of the deck, size [m]
PLATES = (
    ("one size along the crack", ["--uniform"], (), 0.008),
    ("one size along the crack", ["--uniform"], (), 0.004),
    ("one size along the crack", ["--uniform"], (), 0.002),
    ("plate of 8 m", ["--side", "8"], (), 0.004),
    ("plate of 4 m", ["--side", "4"], (), 0.004),
    ("plate of 32 m", ["--side", "32"], (), 0.004),
    ("a hundredth of the load", [], (("syy = 10e6", "syy = 1e5"),), 0.004),
    (
        "walls ten times as stiff",
        [],
        (("kn_mpa_mm = 1e5, ks_mpa_mm = 1e4", "kn_mpa_mm = 1e6, ks_mpa_mm = 1e5"),),
        0.004,
    ),
)


def run(folder, name, size, deck, changes=(), mesher=()):
    """Mesh and run; the results directory."""
    mesh = folder / f"{'_'.join(mesher).replace('-', '') or 'graded'}_{size:g}.msh"
    command = [
        sys.executable,
        SCENES / "inclined_crack" / "make_mesh.py",
        "--size",
        size,
        *mesher,
        "--out",
        mesh,
    ]
    if make(mesh, command) != 0:
        sys.exit(f"error: {mesh} was not made")
    text = deck.read_text(encoding="utf-8")
    for old, new in (("crack.msh", mesh.name), *changes):
        assert old in text, f"{deck}: '{old}' is not there"
        text = text.replace(old, new)
    path = folder / f"{name.replace(' ', '_')}_{size:g}.nml"
    path.write_text(text, encoding="utf-8")
    results = path.with_suffix("")
    subprocess.run([PROGRAM, "--quiet", "--output", results, path], check=True)
    return results


def exact(ks, friction, stress=STRESS):
    normal, shear = resolved(stress, ANGLE)
    strength = np.inf if friction is None else normal * np.tan(np.radians(friction))
    return lambda x: reference_slip(x, HALF_LENGTH, MODULUS, shear, ks, strength)


def row(what, size, results, reference):
    """A row of the table, printed too."""
    centre, worst = slip_error(results, reference)
    triangles = len(Results(results).fields.mesh().triangles)
    found = [what, f"{100 * size / HALF_LENGTH:g}", triangles, f"{100 * centre:.3f}", f"{100 * worst:.3f}"]
    print(
        f"{what}, h/b = {found[1]} %, {triangles} triangles: centre {found[3]} %, worst {found[4]} %",
        flush=True,
    )
    return found


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=float, nargs="+", default=[0.016, 0.008, 0.0056, 0.004, 0.0028])
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench" / "inclined_crack")
    arguments = parser.parse_args()
    folder = arguments.results.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, deck, changes, ks, friction in VARIANTS:
        for size in arguments.sizes:
            rows.append(row(name, size, run(folder, name, size, deck, changes), exact(ks, friction)))
    for name, mesher, changes, size in PLATES:
        stress = STRESS / 100 if "load" in name else STRESS
        results = run(folder, name, size, FRICTION_DECK, changes, mesher)
        rows.append(row(name, size, results, exact(np.inf, 15.0, stress)))
    with open(folder / "inclined_crack.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["what", "h_over_b_%", "triangles", "centre_%", "worst_%"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
