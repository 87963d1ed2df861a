#!/usr/bin/env python3
"""Many fracture networks through the whole pipeline: traces, mesh, phases I, II-A and II-B; what does not finish is listed.

    python3 tests/networks.py --seeds 0:20 --out generated.csv
    python3 tests/networks.py --maps ../shared/traces --windows 2 4 10 --out maps.csv
    python3 tests/networks.py --seeds 0:50 --models jcm coulomb --relaxation --timeout 300

Networks are generated (make_network.py) or cut from maps of traces, windows about the middle of each map. Element sizes are
parts of the side (--sizes). Decks are those of femdem-network; phases II start from the checkpoint of phase I.
A row of the CSV is a phase of a model on a mesh:

    mean_stress_error   largest difference of the area-weighted mean of sxx, syy, sxy in the rock from the stress applied, over
                        the least one
    unbalanced_ratio    at the end
    aperture_mm, slip_mm   means over the joints, weighted by length
    cpu_s               of the program
    message             why it failed

With --relaxation every phase that finished is run by the relaxation solver too, with the difference of mean aperture, and the
largest difference of a block edge's mean slip over the largest of the network (`slip_scene`) and over its own (`slip_edge`,
edges that slip a hundredth of the largest at least). With --coupled closure and dilation push the walls.
"""

import argparse
import csv
import resource
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postproc"))
from femdem.network.run_network import DECK as PHASE_1_DECK
from femdem.network.run_network import MESH_NAME, MODELS, PHASES, Stress, deck, template_of
from femdem.network.traces import TraceError, read_traces, write_traces
from femdem.places import environment, module
from femdem.results import Results, ResultsError
from junctions import LEAST, areas, program
from make_network import draw_network, recipe_of

PHASE_1 = ("phase_1", Stress(5.0, 5.0))
COLUMNS = [
    *("network", "side", "size", "model", "phase", "solver", "triangles", "joints", "edges", "finished"),
    *("mean_stress_error", "unbalanced_ratio", "aperture_mm", "slip_mm"),
    *("aperture_off", "slip_scene", "slip_edge", "cpu_s", "message"),
]


@dataclass(frozen=True)
class Task:
    """A network at one element size: everything is run on one mesh, in one process."""

    name: str
    size: float  # of elements at fractures [m]
    side: float  # of the window [m]
    seed: int | None = None  # generated
    p21: float | None = None
    traces: str | None = None  # or cut from a map
    window: tuple | None = None


def generated(seeds, parts, side=None, p21=None):
    """Tasks of generated networks; sizes are parts of the side."""
    for seed in seeds:
        square = recipe_of(seed, side, p21).side
        for part in parts:
            yield Task(f"seed_{seed}", part * square, square, seed=seed, p21=p21)


def mapped(folder, windows, parts):
    """Tasks of windows about the middle of each map; a window that a map does not fill is cut to it."""
    for path in sorted(Path(folder).glob("*.csv")):
        x0, y0, x1, y1 = read_traces(path).extent
        for side in windows:
            # A window of a map of this size is the whole of it
            if min(x1 - x0, y1 - y0) < 0.75 * side:
                continue
            middle = ((x0 + x1) / 2, (y0 + y1) / 2)
            half = [min(side, x1 - x0) / 2, min(side, y1 - y0) / 2]
            window = (middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1])
            for part in parts:
                yield Task(
                    f"{path.stem}_{side:g}m", part * side, side, traces=str(path.resolve()), window=window
                )


def call(command, folder, timeout):
    """Run a program; seconds of its own, and None or why it failed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(
            [str(word) for word in command],
            cwd=folder,
            env=environment(),
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        said = done.stdout + done.stderr
        # The error, without warnings before it
        failed = f"status {done.returncode}: " + " ".join(said[max(0, said.rfind("error:")) :].split()[-60:])
        failed = failed if done.returncode else None
    except subprocess.TimeoutExpired:
        failed = f"not done after {timeout:g} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, failed


def make_mesh(task, folder, timeout):
    """Traces and mesh of a task in a folder; None or why there is none."""
    traces = task.traces
    if task.seed is not None:
        traces = folder / "traces.csv"
        write_traces(traces, draw_network(task.seed, task.side, task.p21)[0])
    command = [
        *module("femdem.network.make_mesh"),
        traces,
        "--size",
        task.size,
        "--out",
        folder / MESH_NAME,
    ]
    # The whole square, also where no trace reaches its sides
    command += ["--window", *(task.window or (0.0, 0.0, task.side, task.side))]
    return call(command, folder, timeout)[1]


def measured(directory, stresses):
    """What a finished run found: a part of its row, and mean slip of the block edges."""
    results = Results(directory)
    fields, history, mesh = results.fields, results.history, results.fields.mesh()
    area = areas(mesh.coordinates, mesh.triangles)
    applied = [1e6 * stress for stress in (*stresses, 0.0)]
    mean = [np.average(fields.read(f"stress_{name}"), weights=area) for name in ("xx", "yy", "xy")]
    length = np.hypot(*np.diff(mesh.joint_lines, axis=1)[:, 0].T)
    slip = np.abs(fields.read("shear_displacement_mm"))
    row = {
        "finished": 1,
        "triangles": len(mesh.triangles),
        "joints": len(mesh.joints),
        "edges": len(results.edges),
        "mean_stress_error": float(np.abs(np.subtract(mean, applied)).max() / min(applied[:2])),
        "unbalanced_ratio": float(history["unbalanced_ratio"][-1]),
        "aperture_mm": float(np.average(fields.read("aperture_mm"), weights=length)),
        "slip_mm": float(np.average(slip, weights=length)),
    }
    return row, results.edges.mean_shear_displacement_mm


def run_task(
    task,
    models=MODELS,
    phases=tuple(PHASES),
    relaxation=False,
    coupled=False,
    timeout=600.0,
    cycles=10,
    folder=None,
):
    """Rows of one mesh, for every model and phase; a phase II whose phase I failed is not run."""
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(folder or temporary)
        place.mkdir(parents=True, exist_ok=True)
        head = {"network": task.name, "side": task.side, "size": task.size, "finished": 0}
        try:
            failed = make_mesh(task, place, timeout)
        except TraceError as error:
            failed = str(error)
        if failed:
            return [{**head, "phase": "mesh", "message": failed}]
        rows, found = [], {}
        template = template_of(SimpleNamespace(deck=PHASE_1_DECK))
        if coupled:
            template = template.replace("law = 'jcm'", "law = 'jcm', coupling = 'coupled'")
        solvers = ("implicit", "relaxation") if relaxation else ("implicit",)
        for model in models:
            for solver in solvers:
                settings = SimpleNamespace(
                    cycles=cycles, solver=solver, cracks=False, rollers=False, biot=1.0, flow=None
                )
                first = place / f"{model}_{solver}_phase_1"
                for phase, loads in (PHASE_1, *((name, PHASES[name]) for name in phases)):
                    row = {**head, "model": model, "phase": phase, "solver": solver}
                    name = f"{model}_{solver}_{phase}"
                    (place / f"{name}.nml").write_text(
                        deck(template, settings, model, phase, dict([PHASE_1, (phase, loads)]), {}),
                        encoding="utf-8",
                    )
                    branch = [] if phase == PHASE_1[0] else ["--branch", first / "checkpoint.h5"]
                    command = [program(), *branch, "--quiet", "--output", place / name, f"{name}.nml"]
                    row["cpu_s"], failed = call(command, place, timeout)
                    row["message"] = failed or ""
                    rows.append(row)
                    if failed and phase == PHASE_1[0]:
                        break
                    if failed:
                        continue
                    try:
                        values, slip = measured(place / name, (loads.sxx, loads.syy))
                    except ResultsError as error:
                        row["message"] = str(error)
                        continue
                    row |= values
                    found[model, phase, solver] = (row["aperture_mm"], slip)
                    other = found.get((model, phase, "implicit"))
                    if solver == "relaxation" and other:
                        row |= compared(found[model, phase, solver], other)
        return rows


def compared(one, other):
    """Differences of mean aperture and of block edges' mean slip."""
    off = np.abs(one[1] - other[1])
    largest = other[1].max()
    felt = other[1] > LEAST * largest
    return {
        "aperture_off": abs(one[0] / other[0] - 1),
        "slip_scene": float(off.max() / largest) if largest else 0.0,
        "slip_edge": float((off[felt] / other[1][felt]).max()) if felt.any() else 0.0,
    }


def run_all(tasks, out, processes=2, **options):
    """Run tasks in a few processes; rows go to the CSV file as they are found."""
    rows = []
    with (
        open(out, "w", newline="", encoding="utf-8") as file,
        ProcessPoolExecutor(max_workers=processes) as pool,
    ):
        writer = csv.DictWriter(file, COLUMNS, restval="")
        writer.writeheader()
        # In the order of the tasks: the same file each time
        for future in [pool.submit(run_task, task, **options) for task in tasks]:
            for row in future.result():
                writer.writerow(row)
                rows.append(row)
                said = row["message"] or f"{row['cpu_s']:.1f} s"
                print(
                    *(row.get(name, "") for name in ("network", "model", "phase", "solver")), said, flush=True
                )
            file.flush()
    return rows


def summary(rows):
    """How many finished, in words."""
    runs = [row for row in rows if row["phase"] != "mesh"]
    lines = [f"{sum(row['finished'] for row in runs)} of {len(runs)} phases finished"]
    meshes = len(rows) - len(runs)
    if meshes:
        lines.append(f"{meshes} meshes were not made")
    done = [row for row in runs if row["finished"]]
    for name in ("mean_stress_error", "unbalanced_ratio", "aperture_off", "slip_scene", "slip_edge"):
        values = [row[name] for row in done if name in row]
        if values:
            lines.append(f"{name}: at most {max(values):.2e}, in the middle {np.median(values):.2e}")
    return "\n".join(lines)


def span(text):
    """Seeds: A:B, B not among them, or a single one"""
    first, _, last = text.partition(":")
    return range(int(first), int(last) if last else int(first) + 1)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--seeds", type=span, help="generated networks, FROM:TO")
    what.add_argument("--maps", help="folder of maps (CSV files of traces)")
    parser.add_argument("--side", type=float, help="of generated networks (m; default: by the seed)")
    parser.add_argument("--p21", type=float, help="of generated networks (1/m; default: by the seed)")
    parser.add_argument("--windows", nargs="+", type=float, default=(2.0, 4.0, 10.0), help="of maps (m)")
    parser.add_argument(
        "--sizes", nargs="+", type=float, default=(0.04, 0.02, 0.01), help="of elements, as parts of the side"
    )
    parser.add_argument("--models", nargs="+", choices=MODELS, default=MODELS)
    parser.add_argument(
        "--phases", nargs="+", choices=list(PHASES), default=list(PHASES), help="after phase I"
    )
    parser.add_argument("--cycles", type=int, default=10, help="load increments of a phase (default 10)")
    parser.add_argument("--relaxation", action="store_true", help="by the relaxation solver too, and compare")
    parser.add_argument("--coupled", action="store_true", help="closure and dilation push the walls")
    parser.add_argument("--timeout", type=float, default=600, help="of a run (s; default 600)")
    parser.add_argument("--processes", type=int, default=2, help="at a time (default 2)")
    parser.add_argument("--out", default="networks.csv", help="CSV file (default networks.csv)")
    arguments = parser.parse_args()
    if arguments.maps:
        tasks = mapped(arguments.maps, arguments.windows, arguments.sizes)
    else:
        tasks = generated(arguments.seeds, arguments.sizes, arguments.side, arguments.p21)
    rows = run_all(
        tasks,
        arguments.out,
        arguments.processes,
        models=arguments.models,
        phases=arguments.phases,
        relaxation=arguments.relaxation,
        coupled=arguments.coupled,
        timeout=arguments.timeout,
        cycles=arguments.cycles,
    )
    print(summary(rows))


if __name__ == "__main__":
    main()
