#!/usr/bin/env python3
"""Which setting buys which error for which time: solver x element size x velocity or increment.

    python3 tests/bench/time_against_error.py [--quick] [--scene shear closure crack network] [--results DIR]

Scenes: direct shear of the 6 cm joint to 5 mm, its closure to 1 MPa (decks of input/direct_shear and input/closure); the
inclined crack of tests/scenes/inclined_crack; a network of two sets under 15 and 5 MPa (tests/scenes/network_three_solvers). The
settings are varied by velocity (explicit) or increment (other solvers), and by element size. A solver that the program
does not know is left out.

Errors rms_% and worst_%: difference from eq 13 in per cent of the peak, or from eq 5b in per cent of the closure, at the
rows of the history, as by femdem-plot shear and closure; of the dilation from eq 18 as by femdem-plot dilation. Runs with
large increments have few rows, which may miss the peak; so settings are compared by error_%: the same difference, rms, with
the computed curve read linearly every 0.01 mm; for closure the difference at 1 MPa, where every run has a row.
Inclined crack: slip at the centre against its closed form, and as worst_% that of the profile. Network: means of shear
displacement and aperture, weighted by length, against a run with elements of 20 mm and 80 increments a phase; the larger of
the two differences. The explicit solver is left out of the inclined crack: its plate is so large against the crack that
waves cross it many times before it rests, and friction keeps what they did.

Time: solve time of run.log and user time of the whole program. Before every run the reference run (the shipped implicit
direct shear deck) is timed, and the two are divided: what else the machine does falls out for the most part. Runs shorter
than --long seconds are repeated; medians count.

Writes time_against_error.csv, the same as a table, and the figure. The front is the settings which no other one beats in
both time and error (errors within 2 % are the same). A deck for relaxation is the implicit one with another solver.
"""

import argparse
import csv
import os
import re
import statistics
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
SHEAR, CLOSURE = TOP / "input" / "direct_shear", TOP / "input" / "closure"
NETWORK = TOP / "input" / "network"
CRACK_SCENE, NETWORK_SCENE = (
    TOP / "tests" / "scenes" / name for name in ("inclined_crack", "network_three_solvers")
)
sys.path[:0] = [str(TOP / "postproc"), str(SHEAR), str(TOP / "tests")]
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402
from run_series import PROGRAM, change, shear_deck  # noqa: E402

from femdem.figures import style  # noqa: E402
from femdem.figures.closure import draw_closure  # noqa: E402
from femdem.figures.dilation import draw_dilation  # noqa: E402
from femdem.figures.shear import draw_shear  # noqa: E402
from femdem.kept import Kept, fingerprint, make  # noqa: E402
from femdem.results import Results  # noqa: E402
from scene_crack import ANGLE, HALF_LENGTH, MODULUS, STRESS, reference_slip, resolved, slip_error  # noqa: E402

LENGTH, NORMAL_STRESS_MPA, TRAVEL_MM = 0.06, 0.0245, 5.0
SAME = 1.02  # errors this much apart are the same: a longer run must buy more
READ_EVERY_MM = 0.01  # of the computed curve, for error_%
VELOCITY_MM_S = 20.0  # of the shipped decks; an implicit run only knows the increment
SOLVERS = ("explicit", "relaxation", "implicit")
HEADER = [
    "scene",
    "solver",
    "size_mm",
    "setting",
    "triangles",
    "error_%",
    "rms_%",
    "worst_%",
    "dilation_rms_%",
    "solve_s",
    "user_s",
]
HEADER += ["solve_ratio", "user_ratio", "repeats", "on_front"]
SCENE_NAME = {
    "shear": "Direct shear, 6 cm",
    "closure": "Closure to 1 MPa, 6 cm",
    "crack": "Inclined crack, 0.2 m",
    "network": "Network, phases I and II-B",
}
CRACK_FRICTION = 15.0  # degrees, of the crack's deck
NETWORK_FINEST = (20.0, 80)  # element size [mm] and increments a phase of the network's reference
ERROR_NAME = {
    "shear": "Error of the shear stress [% of the peak, rms]",
    "closure": "Error of the closure at 1 MPa [%]",
    "crack": "Error of the slip at the centre [%]",
    "network": "Error of mean shear displacement, aperture [%]",
}


@dataclass
class Case:
    """One setting of one scene."""

    scene: str
    solver: str
    size_mm: float
    setting: str
    deck: str

    @property
    def name(self):
        return re.sub(r"[^\w.]+", "_", f"{self.scene}_{self.solver}_{self.size_mm:g}mm_{self.setting}")


def explicit_shear(velocity):
    """The shipped explicit deck at another velocity [mm/s]."""
    return shear_deck(6, velocity)


def implicit_shear(increment):
    """The shipped deck, by the implicit solver, with increments [mm]."""
    deck = change((SHEAR / "shear_6cm.nml").read_text(encoding="utf-8"), "run", solver="'implicit'")
    time = increment / VELOCITY_MM_S
    return change(deck, "stage name = 'shear'", cycles=round(TRAVEL_MM / increment), move_time=f"{time:g}")


def closure_deck(name, cycles, **stage):
    deck = (CLOSURE / name).read_text(encoding="utf-8").replace("solver = 'auto'", "solver = 'implicit'")
    return change(deck, "stage name = 'close'", cycles=cycles, **stage)


def with_solver(deck, solver):
    """An implicit deck for another solver; &implicit then has no meaning."""
    if solver == "implicit":
        return deck
    return re.sub(r"(?m)^&implicit.*/\n", "", change(deck, "run", solver=f"'{solver}'"))


def crack_deck(solver):
    """The scene's deck for a solver of states of rest."""
    deck = (CRACK_SCENE / "crack.nml").read_text(encoding="utf-8")
    deck = re.sub(r"(?m)^&implicit.*/\n", "", deck) + "&output directory = 'results' /\n"
    return change(deck, "run", solver=f"'{solver}'")


def network_deck(solver, setting):
    """The scene's deck with increments a phase, or for the explicit solver with the time of its ramps [ms]."""
    deck = (NETWORK_SCENE / "network.nml").read_text(encoding="utf-8") + "&output directory = 'results' /\n"
    if solver == "explicit":
        ramp = f"cycles = 1, move_time = {setting}e-3, equilibrium = 1e-4, max_rest_time = 2e-2"
        deck = deck.replace("cycles = 10, move_time = 1e-2", ramp)
    else:
        deck = deck.replace("cycles = 10", f"cycles = {setting}")
    if solver == "explicit":
        deck += "&explicit damping = 'viscous', damping_factor = 0.2, mass_scaling = 'step', scaled_step = 5e-6 /\n"
    return change(deck, "run", solver=f"'{solver}'")


def rock_cases(scenes, solvers, quick):
    """The settings of the inclined crack and of the network."""
    found = []
    for solver in solvers:
        sizes = [16.0, 8.0] if quick or solver != "implicit" else [16.0, 8.0, 5.6, 4.0]
        if "crack" in scenes and solver != "explicit":
            found += [Case("crack", solver, size, "2 steps", crack_deck(solver)) for size in sizes]
        if "network" not in scenes:
            continue
        sizes = [60.0] if quick or solver != "implicit" else [60.0, 40.0, 30.0]
        steps = (
            [100, 200]
            if solver == "explicit"
            else [5, 10]
            if quick or solver != "implicit"
            else [2, 5, 10, 20, 40]
        )
        unit = "ms" if solver == "explicit" else "steps"
        found += [
            Case("network", solver, size, f"{n} {unit}", network_deck(solver, n))
            for size in sizes
            for n in steps
        ]
    return found


def cases(scenes, solvers, quick):
    """The settings of the study."""
    sizes = [3.0] if quick else [3.0, 1.5, 1.0]
    velocities = [160, 80] if quick else [160, 80, 40, 20]
    increments = [0.1, 0.01] if quick else [0.2, 0.1, 0.05, 0.02, 0.01]
    steps = [5, 20] if quick else [2, 5, 20]
    found = []
    for size in sizes:
        for solver in solvers:
            # Solvers that step take long: the coarsest and the finest size show what size does
            if solver != "implicit" and size not in (sizes[0], sizes[-1]):
                continue
            if "shear" in scenes and solver == "explicit":
                found += [Case("shear", solver, size, f"{v:g} mm/s", explicit_shear(v)) for v in velocities]
            elif "shear" in scenes:
                found += [
                    Case("shear", solver, size, f"{i:g} mm", with_solver(implicit_shear(i), solver))
                    for i in increments
                ]
            if "closure" in scenes and (solver == "implicit" or size == sizes[0]):
                for n in steps:
                    if solver == "explicit":
                        deck = closure_deck("closure_6cm_explicit.nml", n)
                    else:
                        deck = with_solver(closure_deck("closure_6cm.nml", n), solver)
                    found.append(Case("closure", solver, size, f"{n} steps", deck))
    return found + rock_cases(scenes, solvers, quick)


def mesh_command(scene, size_mm, mesh):
    """The command that makes the mesh of a scene."""
    size = ["--size", size_mm / 1000, "--out", mesh]
    if scene in ("shear", "closure"):
        command = [SHEAR / "make_mesh.py", "--length", LENGTH, *size]
    elif scene == "crack":
        command = [CRACK_SCENE / "make_mesh.py", *size]
    else:
        command = ["-m", "femdem.network.make_mesh", NETWORK / "two_sets.csv", "--feature", "0.02", *size]
    return [sys.executable, *command]


def prepare(case, folder):
    """Mesh and deck of a case; returns the deck's path."""
    mesh = folder / f"{'' if case.scene in ('shear', 'closure') else case.scene + '_'}{case.size_mm:g}mm.msh"
    if make(mesh, mesh_command(case.scene, case.size_mm, mesh)) != 0:
        sys.exit(f"error: {mesh} was not made")
    path = folder / f"{case.name}.nml"
    deck = change(case.deck, "run", mesh=f"'{mesh.name}'")
    path.write_text(change(deck, "output", directory=f"'{case.name}'"), encoding="utf-8")
    return path


def known_solvers(folder):
    """Solvers that the program takes."""
    known = []
    for solver in SOLVERS:
        deck = explicit_shear(160) if solver == "explicit" else with_solver(implicit_shear(0.1), solver)
        path = prepare(Case("shear", solver, 3.0, "check", deck), folder)
        done = subprocess.run([PROGRAM, "--check", path], capture_output=True)
        if done.returncode == 0:
            known.append(solver)
        else:
            print(f"solver '{solver}' is left out: the program does not take it")
    return known


def timed(deck):
    """Run a deck: seconds of the solve by the log, user seconds of the program."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen([PROGRAM, "--quiet", deck], env=environment, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        return None
    log = (deck.parent / deck.stem / "run.log").read_text(encoding="utf-8")
    solve = float(re.search(r"(?m)^done\s.* steps in (\S+) s", log)[1])
    return solve, usage.ru_utime


def curve_error(run):
    """Root mean square error of the shear stress along the curve [% of the peak]."""
    history = run.history
    u, tau = (history.joint("joint", name) for name in ("shear_displacement_mm", "shear_stress_MPa"))
    at = np.arange(READ_EVERY_MM, u[-1], READ_EVERY_MM)
    law = run.reference_joint("joint")
    found = np.interp(at, np.append(0, u), np.append(0, tau)) - law.shear_stress(at, NORMAL_STRESS_MPA)
    return 100 * float(np.sqrt(np.mean(found**2)) / law.peak_shear_stress(NORMAL_STRESS_MPA))


def network_means(results):
    """Means of shear displacement and aperture [mm], weighted by length."""
    fields = Results(results).fields
    lines = fields.mesh().joint_lines
    length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    return [
        np.average(np.abs(fields.read(name)), weights=length)
        for name in ("shear_displacement_mm", "aperture_mm")
    ]


def rock_errors(case, results):
    """error_%, rms_%, worst_% of the inclined crack and the network."""
    if case.scene == "crack":
        normal, shear = resolved(STRESS, ANGLE)
        strength = normal * np.tan(np.radians(CRACK_FRICTION))
        centre, worst = slip_error(
            results, lambda x: reference_slip(x, HALF_LENGTH, MODULUS, shear, np.inf, strength)
        )
        return [100 * abs(centre), "", 100 * worst, ""]
    finest = Case(
        "network", "implicit", NETWORK_FINEST[0], "finest", network_deck("implicit", NETWORK_FINEST[1])
    )
    folder = Path(results).parent
    deck = prepare(finest, folder)
    kept = Kept(folder / finest.name, folder / finest.name / "run.log")
    mesh = folder / f"network_{NETWORK_FINEST[0]:g}mm.msh"
    ingredients = {path.suffix: fingerprint(path) for path in (deck, mesh)} | {
        "program": fingerprint(PROGRAM)
    }
    if kept.differs(ingredients):
        kept.forget()
        if timed(deck) is None:
            sys.exit("error: the network's reference run failed")
        kept.remember(ingredients)
    off = [
        100 * abs(a / b - 1)
        for a, b in zip(network_means(results), network_means(folder / finest.name), strict=True)
    ]
    return [max(off), "", "", ""]


def errors(case, results):
    """error_%, rms_%, worst_% and dilation_rms_% of HEADER."""
    if case.scene in ("crack", "network"):
        return rock_errors(case, results)
    run, (figure, axes) = Results(results), plt.subplots()
    if case.scene == "closure":
        rows = [row[-1] for row in draw_closure(axes, [run], [""])[1]]
        found = [abs(rows[-1]), statistics.fmean(e * e for e in rows) ** 0.5, max(map(abs, rows)), ""]
    else:
        header, (row,) = draw_shear(axes, [run], [""], normal_stress=NORMAL_STRESS_MPA)
        found = [curve_error(run), row[header.index("rms_%_of_peak")], abs(row[header.index("worst_%")])]
        header, (row,) = draw_dilation(axes, [run], [""], normal_stress=NORMAL_STRESS_MPA)
        found.append(row[header.index("rms_%_of_largest")])
    plt.close(figure)
    return found


def measure(case, reference, folder, repeat, long):
    """Row of the CSV, without the last column."""
    deck = prepare(case, folder)
    solve, user, solve_ratio, user_ratio = [], [], [], []
    while len(solve) < repeat:
        base, found = timed(reference), timed(deck)
        if found is None or base is None:
            print(f"{case.name}: the run failed", flush=True)
            return None
        solve.append(found[0])
        user.append(found[1])
        solve_ratio.append(found[0] / base[0])
        user_ratio.append(found[1] / base[1])
        if user[0] > long:
            break
    log = (deck.parent / deck.stem / "run.log").read_text(encoding="utf-8")
    triangles = int(re.search(r"(?m)^mesh .* nodes, (\d+) triangles", log)[1])
    medians = [statistics.median(values) for values in (solve, user, solve_ratio, user_ratio)]
    setting = [case.scene, case.solver, case.size_mm, case.setting, triangles]
    row = [*setting, *errors(case, folder / case.name), *medians, len(solve)]
    print(
        f"{case.name}: {row[5]:.4g} %, user time {medians[1]:.2f} s, {medians[3]:.2f} of the reference",
        flush=True,
    )
    return row


def measure_all(arguments, folder):
    """Rows of all cases whose run ended well."""
    repeat = 1 if arguments.quick else arguments.repeat
    solvers = [solver for solver in known_solvers(folder) if solver in arguments.solver]
    reference = prepare(Case("shear", "implicit", 1.0, "reference", implicit_shear(0.01)), folder)
    chosen = cases(arguments.scene, solvers, arguments.quick)
    found = [measure(case, reference, folder, repeat, arguments.long) for case in chosen]
    return [row for row in found if row]


def mark_front(rows):
    """Append 'yes' to the rows of a scene that no other one beats in both user time and error."""
    time, error = HEADER.index("user_ratio"), HEADER.index("error_%")
    for row in rows:
        rivals = [other for other in rows if other[0] == row[0] and other is not row]
        beaten = any(o[time] <= row[time] and o[error] <= SAME * row[error] for o in rivals)
        row.append("" if beaten else "yes")


def draw(rows, out):
    """Error against time, one panel a scene, one marker a solver, one colour an element size."""
    time, error, front = (HEADER.index(name) for name in ("user_ratio", "error_%", "on_front"))
    scenes = [scene for scene in SCENE_NAME if any(row[0] == scene for row in rows)]
    sizes = sorted({row[2] for row in rows}, reverse=True)
    solvers = [solver for solver in SOLVERS if any(row[1] == solver for row in rows)]
    figure, panels = plt.subplots(
        1,
        len(scenes),
        figsize=((100 * len(scenes)) * style.MM, 90 * style.MM),
        layout="constrained",
        squeeze=False,
    )
    for axes, scene in zip(panels[0], scenes, strict=True):
        part = [row for row in rows if row[0] == scene]
        best = sorted((row[time], row[error]) for row in part if row[front])
        axes.plot(*zip(*best, strict=True), "--", color="#999999", zorder=1)
        for row in part:
            axes.plot(
                row[time],
                row[error],
                linestyle="none",
                marker=style.MARKERS[solvers.index(row[1])],
                color=style.PALETTE[sizes.index(row[2])],
                zorder=3,
            )
            if row[2] == sizes[0]:  # the other sizes have the same settings
                above = row[1] != "implicit" or scene == "closure"
                axes.annotate(
                    row[3].removesuffix(" steps"),
                    (row[time], row[error]),
                    xytext=(3, 3) if above else (2, -4),
                    textcoords="offset points",
                    fontsize=6,
                    rotation=45 if above else -45,
                    rotation_mode="anchor",
                    va="bottom" if above else "center",
                )
        axes.set(
            xscale="log",
            yscale="log",
            xlabel="User time over that of the reference run",
            title=SCENE_NAME[scene],
        )
        axes.set_ylabel(ERROR_NAME[scene])
        found = [row[error] for row in part]
        axes.set_ylim(min(found) / 2, max(found) * 2)
        axes.margins(x=0.15)
    marks = [
        plt.Line2D([], [], color="#555555", linestyle="none", marker=style.MARKERS[i], label=solver)
        for i, solver in enumerate(solvers)
    ]
    marks += [Patch(color=style.PALETTE[i], label=f"h = {size:g} mm") for i, size in enumerate(sizes)]
    marks.append(plt.Line2D([], [], color="#999999", linestyle="--", label="front"))
    columns = min(len(marks), 4 * len(scenes))
    figure.legend(handles=marks, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=columns)
    style.save(figure, out, None, None)


def read_rows(path):
    """Rows of an earlier run's CSV, without the last column."""
    with open(path, newline="", encoding="utf-8") as file:
        texts = list(csv.reader(file))[1:]
    return [
        [text if text == "" or i in (0, 1, 3) else float(text) for i, text in enumerate(row[:-1])]
        for row in texts
    ]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="a handful of settings, each once: half a minute"
    )
    parser.add_argument("--scene", nargs="+", choices=list(SCENE_NAME), default=list(SCENE_NAME))
    parser.add_argument("--repeat", type=int, default=3, help="runs of each setting (default 3)")
    parser.add_argument(
        "--long", type=float, default=8.0, help="user seconds beyond which a setting runs once"
    )
    parser.add_argument("--results", type=Path, default=TOP / "results" / "bench" / "time_against_error")
    parser.add_argument("--figure", type=Path, help="figure without suffix (default: in --results)")
    parser.add_argument(
        "--solver", nargs="+", choices=SOLVERS, default=SOLVERS, help="default: all that there are"
    )
    parser.add_argument(
        "--add", action="store_true", help="keep the CSV's rows of settings that are not run now"
    )
    parser.add_argument("--redraw", action="store_true", help="table and figure from the CSV that is there")
    arguments = parser.parse_args()
    if not PROGRAM.exists():
        sys.exit(f"error: {PROGRAM} is missing; build first (./run.sh does)")
    folder = arguments.results.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if arguments.redraw:
        rows = read_rows(folder / "time_against_error.csv")
    else:
        rows = measure_all(arguments, folder)
        if arguments.add:
            new = [tuple(row[:4]) for row in rows]
            rows += [row for row in read_rows(folder / "time_against_error.csv") if tuple(row[:4]) not in new]
    mark_front(rows)
    rows.sort(key=lambda row: (row[0], row[HEADER.index("user_ratio")]))
    style.error_table(HEADER, rows, folder / "time_against_error.csv")
    draw(rows, arguments.figure or folder / "time_against_error")


if __name__ == "__main__":
    main()
