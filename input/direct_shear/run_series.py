#!/usr/bin/env python3
"""Run the series of direct shear and closure tests of the paper and redraw its Figs 4a, 4b, 5a, 5b and 6.

    python3 run_series.py velocity size both length closure --results DIR

Each run is a copy of an explicit deck (shear_6cm_explicit.nml, closure_6cm_explicit.nml) with a few values changed; decks,
meshes and results go to DIR, the figures and the table of errors (errors.csv) beside them. A run that is there already is
used again when deck, mesh and program are the same (--again repeats all).

  velocity  Fig 4a: 6 cm, elements of 1 mm, driven at 160, 80, 40, 20 and 10 mm/s (--paper: 5 to 1 mm/s as well)
  size      Fig 4b: 6 cm, elements of 3, 1.5, 1.25 and 1 mm along the joint
  both      velocity and element size halved together: 160 mm/s and 3 mm, 80 and 1.5, 40 and 0.75
  length    Figs 5a and 5b: 6, 12, 18 and 36 cm, elements of 1 mm
  closure   Fig 6: 6 cm, 20 stresses up to 1 MPa
"""

import argparse
import csv
import re
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
TOP = HERE.parent.parent
sys.path.insert(0, str(TOP / "postproc"))
from femdem.kept import Kept, fingerprint, make, text_fingerprint  # noqa: E402
from femdem.places import environment, module  # noqa: E402

PROGRAM = TOP / "build" / "femdem"
NORMAL_STRESS_MPA = "0.0245"
TRAVEL_PER_CYCLE = 1e-5  # metres: 0.01 mm as in the paper
VELOCITIES_MM_S = [160, 80, 40, 20, 10]
PAPER_VELOCITIES_MM_S = [5, 4, 3, 2, 1]
SIZES_MM = [3.0, 1.5, 1.25, 1.0]
HALVED_TOGETHER = [(160, 3.0), (80, 1.5), (40, 0.75)]  # mm/s, mm
LENGTHS_CM = [6, 12, 18, 36]


def change(deck, group, **values):
    """Set variables in every group of the deck's text that matches the regular expression `group`."""
    for name, value in values.items():
        pattern = rf"(?ms)(^&{group}(?!\w)(?:(?!^\s*/|/\s*$).)*?\b{name}\s*=\s*)('[^']*'|[^,\s/]+)"
        deck, changed = re.subn(pattern, lambda match, value=value: match[1] + str(value), deck)
        if not changed:
            sys.exit(f"error: the deck has no &{group} with {name}")
    return deck


def run(deck, mesh_arguments, name, folder, again):
    """Make mesh and deck, run the program, unless it is done already; returns the results directory."""
    results = folder / name
    folder.mkdir(parents=True, exist_ok=True)
    mesh = folder / f"{name}.msh"
    status = make(mesh, [sys.executable, HERE / "make_mesh.py", *mesh_arguments, "--out", mesh], again=again)
    if status != 0:
        sys.exit(status)
    deck = change(change(deck, "run", mesh=f"'{mesh.name}'"), "output", directory=f"'{name}'")
    kept = Kept(results, results / "run.log")
    ingredients = {
        "deck": text_fingerprint(deck),
        "mesh": fingerprint(mesh),
        "program": fingerprint(PROGRAM),
    }
    why = "asked for" if again else kept.differs(ingredients)
    if not why:
        print(f"{name}: kept, same deck, mesh and program", flush=True)
        return results
    kept.forget()
    path = folder / f"{name}.nml"
    path.write_text(deck)
    start = time.monotonic()
    subprocess.run([PROGRAM, "--quiet", path], check=True)
    kept.remember(ingredients)
    print(f"{name}: {time.monotonic() - start:.0f} s ({why})", flush=True)
    return results


def shear_deck(length_cm, velocity_mm_s=20.0):
    """The explicit deck for a joint length and the load that goes with it, driven at a velocity over the same travel a cycle."""
    deck = (HERE / "shear_6cm_explicit.nml").read_text()
    load = re.search(r"\bty *= *([^ ,/]+)", (HERE / f"shear_{length_cm}cm.nml").read_text())[1]
    deck = change(deck, "boundary group = 'top'", ty=load)
    velocity = velocity_mm_s / 1000
    deck = change(deck, r"boundary group = 'upper_box', stage = 'shear'", vx=f"{velocity:g}")
    return change(deck, r"stage name = 'shear'", move_time=f"{TRAVEL_PER_CYCLE / velocity:g}")


def draw(kind, figure, runs, labels, folder, *options):
    """Draw a figure from several runs; returns the rows of its table of errors."""
    table = folder / f"{figure}.csv"
    command = module("femdem", "plot", kind, *runs, "--labels", *labels)
    command += ["--out", folder / figure, "--csv", table, *options]
    subprocess.run(command, check=True, env=environment())
    with open(table, newline="") as file:
        return list(csv.reader(file))


def velocity_series(folder, again, paper):
    """Fig 4a."""
    velocities = VELOCITIES_MM_S + (PAPER_VELOCITIES_MM_S if paper else [])
    runs = [
        run(shear_deck(6, v), ["--length", "0.06", "--size", "0.001"], f"v{v}mm_s", folder, again)
        for v in velocities
    ]
    labels = [f"{v} mm/s" for v in velocities]
    return [draw("shear", "fig4a_velocity", runs, labels, folder, "--normal-stress", NORMAL_STRESS_MPA)]


def size_series(folder, again, _):
    """Fig 4b."""
    runs = [
        run(shear_deck(6), ["--length", "0.06", "--size", f"{h / 1000:g}"], f"h{h:g}mm", folder, again)
        for h in SIZES_MM
    ]
    labels = [f"h = {h:g} mm" for h in SIZES_MM]
    return [draw("shear", "fig4b_size", runs, labels, folder, "--normal-stress", NORMAL_STRESS_MPA)]


def both_series(folder, again, _):
    """Velocity and element size halved together."""
    runs = [
        run(shear_deck(6, v), ["--length", "0.06", "--size", f"{h / 1000:g}"], f"v{v}h{h:g}", folder, again)
        for v, h in HALVED_TOGETHER
    ]
    labels = [f"{v} mm/s, {h:g} mm" for v, h in HALVED_TOGETHER]
    return [draw("shear", "fig4_both", runs, labels, folder, "--normal-stress", NORMAL_STRESS_MPA)]


def length_series(folder, again, _):
    """Figs 5a and 5b."""
    runs = [
        run(shear_deck(n), ["--length", f"{n / 100:g}", "--size", "0.001"], f"length{n}cm", folder, again)
        for n in LENGTHS_CM
    ]
    labels = [f"{n} cm" for n in LENGTHS_CM]
    options = ("--normal-stress", NORMAL_STRESS_MPA)
    return [
        draw("shear", "fig5a_length", runs, labels, folder, *options),
        draw("dilation", "fig5b_length", runs, labels, folder, *options),
    ]


def closure_series(folder, again, _):
    """Fig 6."""
    deck = (HERE.parent / "closure" / "closure_6cm_explicit.nml").read_text()
    results = run(deck, ["--length", "0.06", "--size", "0.001"], "closure6cm", folder, again)
    return [draw("closure", "fig6_closure", [results], ["6 cm"], folder)]


SERIES = {
    "velocity": velocity_series,
    "size": size_series,
    "both": both_series,
    "length": length_series,
    "closure": closure_series,
}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("series", nargs="*", choices=[[], *SERIES], default=list(SERIES), help="default: all")
    parser.add_argument(
        "--results", type=Path, default=TOP / "results" / "series", help="where everything goes"
    )
    parser.add_argument("--paper", action="store_true", help="the paper's velocities too (an hour)")
    parser.add_argument("--again", action="store_true", help="make meshes and runs anew in any case")
    arguments = parser.parse_args()
    if not PROGRAM.exists():
        sys.exit(f"error: {PROGRAM} is missing; build first (./run.sh does)")
    folder = arguments.results.resolve()
    with_errors = []
    for name in arguments.series or SERIES:
        for header, *rows in SERIES[name](folder, arguments.again, arguments.paper):
            with_errors += [["series", *header], *([name, *row] for row in rows)]
    with open(folder / "errors.csv", "w", newline="") as file:
        csv.writer(file).writerows(with_errors)
    print(folder / "errors.csv")


if __name__ == "__main__":
    main()
