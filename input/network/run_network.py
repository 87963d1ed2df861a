#!/usr/bin/env python3
"""A fracture network under in-situ stresses, from traces to figures.

    python3 run_network.py two_sets.csv
    python3 run_network.py traces.csv --size 0.02 --models jcm --results DIR

Makes the mesh, runs phase I for every joint model and branches the later phases from its checkpoint, then draws maps of
shear displacement and aperture, the joint models side by side, histograms of the block edges, stress and displacement.

    phases   1: --stress (5, 5 MPa); 2a: sxx = 10 MPa; 2b: sxx = 15 MPa; other stresses: --phase NAME=SXX,SYY (MPa)
    models   jcm (each block edge has its own length), jcm_mean (Model-I), coulomb (Model-II)

Decks are phase_1.nml of this folder with values changed; mesh, decks, results and figures go to the results directory.
Runs that are there already are kept (--again repeats them). Prints the time of each run.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
TOP = HERE.parent.parent
PROGRAM = TOP / "build" / "femdem"
POSTPROC = TOP / "postproc"
MODELS = ("jcm", "jcm_mean", "coulomb")
PHASES = {"phase_2a": (10.0, 5.0), "phase_2b": (15.0, 5.0)}
SIDES = ("left", "right", "bottom", "top")
MESH_NAME = "mesh.msh"  # one name for all decks: checkpoints remember it
BOX = "&boundary group = '{side}', stage = '{stage}', sxx = {sxx:g}, syy = {syy:g} /\n"
STAGE = "&stage name = '{name}', cycles = {cycles}, move_time = 1e-2, equilibrium = 1e-4 /\n"
EXPLICIT_STAGE = "&stage name = '{name}', move_time = 3e-2, equilibrium = 1e-4, max_rest_time = 4e-2 /\n"
CRACKS = """&fracture group = 'rock', tensile_strength = 7e6, cohesion = 15e6, friction_angle = 26.6, g_i = 100, g_ii = 500 /
"""
MPA = 1e6


def parse_phase(text):
    """A --phase: NAME=SXX,SYY"""
    name, _, stresses = text.partition("=")
    try:
        sxx, syy = (float(word) for word in stresses.split(","))
    except ValueError:
        sys.exit(f"error: --phase {text}: it must be NAME=SXX,SYY with stresses in MPa")
    return name, (sxx, syy)


def stage(name, stresses, arguments):
    """Boundaries and stage of one phase"""
    sxx, syy = (MPA * stress for stress in stresses)
    box = "".join(BOX.format(side=side, stage=name, sxx=sxx, syy=syy) for side in SIDES)
    form = EXPLICIT_STAGE if arguments.solver == "explicit" else STAGE
    return box + form.format(name=name, cycles=arguments.cycles)


def deck(template, arguments, model, phase, stresses):
    """Text of the deck of a model and a phase: phase I, then the phase asked for."""
    kept = [
        line
        for line in template.splitlines(keepends=True)
        if not line.startswith(("!", "&stage", "&output")) and "stage = 'phase_1'" not in line
    ]
    text = "".join(kept)
    sxx, syy = stresses
    for old, new in (
        ("law = 'jcm'", f"law = '{model}'"),
        ("mesh = 'two_sets.msh'", f"mesh = '{MESH_NAME}'"),
        ("solver = 'implicit'", f"solver = '{arguments.solver}'"),
    ):
        if text.count(old) != 1:
            sys.exit(f"error: {arguments.deck}: {old} is there {text.count(old)} times, it must be once")
        text = text.replace(old, new)
    text = text.replace(
        text[text.index("title = '") : text.index("', mesh")],
        f"title = '{model}, {phase}: {sxx:g}, {syy:g} MPa",
    )
    text += stage("phase_1", arguments.stress, arguments)
    if phase != "phase_1":
        text += stage(phase, stresses, arguments)
    if arguments.solver == "explicit":
        text += "&explicit damping = 'local' /\n"
    if arguments.cracks:
        text += CRACKS
    return text


def run(arguments, model, phase, stresses, template):
    """Run one phase of one model, branched from phase I; the results directory."""
    folder = arguments.results
    results = folder / model / phase
    log = results / "run.log"
    if not arguments.again and log.exists() and "\ndone " in log.read_text():
        return results
    path = folder / f"{model}_{phase}.nml"
    path.write_text(deck(template, arguments, model, phase, stresses), encoding="utf-8")
    command = [arguments.femdem, "--quiet", "--output", results, path]
    if phase != "phase_1":
        command[1:1] = ["--restart", folder / model / "phase_1" / "checkpoint.h5"]
    start = time.monotonic()
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit(f"error: the run of {path} failed; what it says stands above and in {log}")
    print(f"{model} {phase}: {time.monotonic() - start:.1f} s", flush=True)
    return results


def draw(script, runs, out, *options):
    """Draw one figure."""
    command = [sys.executable, POSTPROC / script, *runs, "--out", out, *options]
    subprocess.run([str(word) for word in command], check=True)


def draw_all(results, models, phases, figures):
    """The figures of the paper, and stress and displacement of the last phase of the first model."""
    draw("plot_network.py", [results[models[0], phase] for phase in phases], figures / "network")
    last = phases[-1]
    if len(models) > 1:
        draw("plot_models.py", [results[model, last] for model in models], figures / "models")
    runs = [results[model, last] for model in models]
    draw(
        "plot_edge_histograms.py", runs, figures / "edge_histograms", "--csv", figures / "edge_statistics.csv"
    )
    draw("plot_stress.py", [results[models[0], last]], figures / "stress")
    draw(
        "plot_map.py",
        [results[models[0], last]],
        figures / "displacement",
        "--rock",
        "displacement",
        "--cracks",
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("traces", help="CSV file of traces: x1,y1,x2,y2,trace (m)")
    parser.add_argument(
        "--size", type=float, default=0.015, help="element size at fractures (m; default 0.015)"
    )
    parser.add_argument(
        "--mesh",
        action="append",
        default=[],
        metavar="OPTION",
        help="option of make_mesh.py (--mesh=--feature=0.01; repeat)",
    )
    parser.add_argument(
        "--models", nargs="+", choices=MODELS, default=list(MODELS), help="joint models (default: all)"
    )
    parser.add_argument(
        "--stress",
        nargs=2,
        type=float,
        default=[5.0, 5.0],
        metavar=("SXX", "SYY"),
        help="phase I (MPa; default 5 5)",
    )
    parser.add_argument(
        "--phase",
        action="append",
        default=[],
        metavar="NAME=SXX,SYY",
        help="later phases (MPa; default phase_2a=10,5 and phase_2b=15,5; repeat)",
    )
    parser.add_argument("--cycles", type=int, default=10, help="load increments of a phase (default 10)")
    parser.add_argument(
        "--solver", choices=("implicit", "explicit"), default="implicit", help="solver (default implicit)"
    )
    parser.add_argument("--cracks", action="store_true", help="let the rock break (some minutes at 15 mm)")
    parser.add_argument(
        "--deck", type=Path, default=HERE / "phase_1.nml", help="deck that rock and joints are taken from"
    )
    parser.add_argument(
        "--results", type=Path, help="results directory (default: results/network/NAME OF THE TRACES)"
    )
    parser.add_argument("--femdem", type=Path, default=PROGRAM, help="program (default: build/femdem)")
    parser.add_argument("--again", action="store_true", help="repeat runs that are there already")
    parser.add_argument("--no-figures", action="store_true", help="draw nothing")
    arguments = parser.parse_args()
    arguments.results = arguments.results or TOP / "results" / "network" / Path(arguments.traces).stem
    arguments.results.mkdir(parents=True, exist_ok=True)
    mesh = arguments.results / MESH_NAME
    if arguments.again or not mesh.exists():
        make = [
            sys.executable,
            HERE / "make_mesh.py",
            arguments.traces,
            "--size",
            arguments.size,
            "--out",
            mesh,
        ]
        make += ["--report", arguments.results / "mesh.txt", *arguments.mesh]
        if subprocess.run([str(word) for word in make], check=False).returncode != 0:
            sys.exit(1)
    template = arguments.deck.read_text(encoding="utf-8")
    phases = {"phase_1": tuple(arguments.stress), **(dict(map(parse_phase, arguments.phase)) or PHASES)}
    results = {
        (model, phase): run(arguments, model, phase, stresses, template)
        for model in arguments.models
        for phase, stresses in phases.items()
    }
    if not arguments.no_figures:
        draw_all(results, arguments.models, list(phases), arguments.results / "figures")


if __name__ == "__main__":
    main()
