"""A fracture network under in-situ stresses, from traces to figures.

    femdem-network two_sets.csv
    femdem-network traces.csv --size 0.02 --models jcm --window 0 0 1 1 --results DIR

Makes the mesh, runs phase I for every joint model and branches the later phases from its checkpoint, then draws maps of
shear displacement and aperture, the joint models side by side, histograms of the block edges, stress and displacement.

    models   jcm (each block edge has its own length), jcm_mean (Model-I), coulomb (Model-II)
    phases   phase_1: --stress (5, 5 MPa); phase_2a: 10, 5 MPa; phase_2b: 15, 5 MPa. Others by --phase, compression positive:
               NAME=SXX,SYY         stresses in x and y (MPa)
               NAME=SXX,SYY,SXY     with a shear stress (MPa)
               NAME=S1,S3@ANGLE     principal stresses (MPa), S1 at an angle from x, anticlockwise (degrees)
               NAME=UX,UYmm         the right side and the top move inwards by so much during the phase (mm), against
                                    rollers on the left and at the bottom
             phase_1 may be among them; when another is, it stands in place of phase_2a and phase_2b.

With --flow the apertures conduct: the equivalent permeability at every output time is in permeability.csv of each run (deck
group &flow), with the water going from left to right, and there are figures of it. Numbers of the network (P20, P21, nodes,
connections) as read and as cleaned are in network_numbers.csv and in the figure ternary.

Decks are phase_1.nml of input/network with values changed; mesh, decks, results and figures go to the results directory.
A mesh or a run that is there already is used again only when all it was made from is the same: traces, options, deck, mesh,
program (--again repeats all). A run that fails does not end the others; what failed is said at the end, with status 1, and
the last state it has written is drawn (failed_MODEL_PHASE).
"""

import argparse
import math
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from femdem.kept import SUFFIX, Kept, fingerprint, ingredients_of, make, text_fingerprint
from femdem.network.network_numbers import draw_ternary, exact_graph, numbers_of, write_numbers
from femdem.network.regions import add_options
from femdem.network.traces import read_traces
from femdem.places import checkout, environment, module, program, results

# The deck that rock and joints are taken from: that of the project, or its copy in the installed package
DECK = (checkout() / "input" / "network" if checkout() else Path(__file__).resolve().parent) / "phase_1.nml"
MODELS = ("jcm", "jcm_mean", "coulomb")
SOLVERS = ("auto", "implicit", "relaxation", "explicit")
FIRST = "phase_1"  # the phase that the others branch from
SIDES = ("left", "right", "bottom", "top")
ROLLERS = "&boundary group = 'left', vx = 0 /\n&boundary group = 'bottom', vy = 0 /\n"
MESH_NAME = "mesh.msh"  # one name for all decks: checkpoints remember it
MOVE_TIME = {"explicit": 3e-2}  # of a cycle [s]; of the other solvers
MOVE_TIME_AT_REST = 1e-2
STAGE = "&stage name = '{name}', cycles = {cycles}, move_time = {time:g}, equilibrium = 1e-4 /\n"
EXPLICIT_STAGE = "&stage name = '{name}', move_time = {time:g}, equilibrium = 1e-4, max_rest_time = 4e-2 /\n"
CRACKS = """&cohesive group = 'all', tensile_strength = 7e6, cohesion = 15e6, friction_angle = 26.6, g_i = 100, g_ii = 500 /
"""
FLOW = """&flow hydraulic = '{law}' /
&flow_boundary group = 'left', pressure = 1e4 /
&flow_boundary group = 'right', pressure = 0 /
"""
HYDRAULIC = ("equal", "barton", "olsson_barton")
# What a run leaves in its results directory
FILES = (
    "history.csv",
    "permeability.csv",
    "flow.csv",
    "fields.h5",
    "fields.xdmf",
    "edges.csv",
    "cracks.csv",
    "collapse.csv",
    "checkpoint.h5",
    "run.log",
    "deck.nml",
)
FIGURES = (
    "network",
    "models",
    "edge_histograms",
    "stress",
    "displacement",
    "ternary",
    "flow",
    "permeability",
)
FAILED_MAP = "failed_"  # and model and phase
MAP = ("--rock", "displacement", "--cracks")
TABLE = "edge_statistics.csv"
NUMBERS, CLEANED = "network_numbers.csv", "cleaned.csv"
BAD_INPUT, FAILED = 2, 1
MPA, MM = 1e6, 1e-3


class InputError(Exception):
    """Something of the command line or the deck is wrong; the message says what."""


@dataclass
class Stress:
    """Far-field stress of a phase, compression positive [MPa]."""

    sxx: float
    syy: float
    sxy: float = 0.0

    @classmethod
    def principal(cls, s1, s3, angle):
        """From principal stresses; s1 acts at an angle [degrees] from x, anticlockwise."""
        mean, half = (s1 + s3) / 2, (s1 - s3) / 2
        turn = math.radians(2 * angle)
        return cls(mean + half * math.cos(turn), mean - half * math.cos(turn), half * math.sin(turn))

    @property
    def text(self):
        """For titles"""
        return f"{self.sxx:.4g}, {self.syy:.4g} MPa" + (f", shear {self.sxy:.4g} MPa" if self.sxy else "")

    def boundaries(self, phase, rollers, _):
        """Groups of the deck"""
        stress = f"sxx = {MPA * self.sxx:.10g}, syy = {MPA * self.syy:.10g}"
        stress += f", sxy = {MPA * self.sxy:.10g}" if self.sxy else ""
        sides = ("right", "top") if rollers else SIDES
        return "".join(f"&boundary group = '{side}', stage = '{phase}', {stress} /\n" for side in sides)


@dataclass
class Shortening:
    """Displacement of the right side and the top during a phase, inwards [mm]."""

    ux: float
    uy: float

    @property
    def text(self):
        """For titles"""
        return f"{self.ux:.4g}, {self.uy:.4g} mm"

    def boundaries(self, phase, rollers, duration):
        """Groups of the deck: velocities over the duration [s] of the phase's motion"""
        held = "" if rollers else ROLLERS.replace(" /", f", stage = '{phase}' /")
        moved = zip(("right", "top"), ("vx", "vy"), (self.ux, self.uy), strict=True)
        return held + "".join(
            f"&boundary group = '{side}', stage = '{phase}', {variable} = {0.0 - MM * u / duration:.10g} /\n"
            for side, variable, u in moved
        )


PHASES = {"phase_2a": Stress(10.0, 5.0), "phase_2b": Stress(15.0, 5.0)}


def finite(text):
    """A finite number"""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def parse_phase(text):
    """A --phase: name and Stress or Shortening."""
    name, _, what = text.partition("=")
    name, what = name.strip(), what.strip()
    if not re.fullmatch(r"\w+", name) or name == "all":
        raise InputError(f"--phase {text}: '{name}' is no name; letters, digits and _ are, but not 'all'")
    kind = Shortening if what.endswith("mm") else Stress
    pair, turned, angle = what.removesuffix("mm").partition("@")
    try:
        numbers = [finite(word) for word in pair.split(",")]
        if turned and kind is Stress and len(numbers) == 2:
            return name, Stress.principal(*numbers, finite(angle))
        if not turned and len(numbers) in ((2,) if kind is Shortening else (2, 3)):
            return name, kind(*numbers)
    except ValueError:
        pass
    raise InputError(
        f"--phase {text}: it must be NAME=SXX,SYY or NAME=SXX,SYY,SXY or NAME=S1,S3@ANGLE (MPa, degrees), or "
        "NAME=UX,UYmm"
    )


def parse_pore_pressure(text):
    """A --pore-pressure: phase and pressure [MPa]."""
    phase, named, pressure = text.rpartition("=")
    try:
        value = finite(pressure)
        if value >= 0.0:
            return phase.strip() if named else FIRST, value
    except ValueError:
        pass
    raise InputError(f"--pore-pressure {text}: it must be PRESSURE or PHASE=PRESSURE, in MPa, not negative")


def gather(parse, texts, wrong):
    """Parse texts to a dictionary; what is wrong with any is added to a list."""
    found = {}
    for text in texts:
        try:
            name, value = parse(text)
            if name in found:
                raise InputError(f"{text}: '{name}' is given twice")
            found[name] = value
        except InputError as error:
            wrong.append(str(error))
    return found


def settle(arguments):
    """Phases, pore pressures and the deck's text; all that is wrong with the command line is said in one InputError."""
    wrong = []
    given = gather(parse_phase, arguments.phase, wrong)
    later = {name: loads for name, loads in given.items() if name != FIRST}
    phases = {FIRST: given.get(FIRST, Stress(*arguments.stress)), **(later or PHASES)}
    pressures = gather(parse_pore_pressure, arguments.pore_pressure, wrong)
    wrong += [
        f"--pore-pressure: there is no phase '{name}'; there are: {', '.join(phases)}"
        for name in pressures
        if name not in phases
    ]
    for name, loads in phases.items():
        if arguments.rollers and isinstance(loads, Stress) and loads.sxy != 0.0:
            wrong.append(
                f"{name}: a shear stress ({loads.sxy:.4g} MPa) cannot act on rollers; leave out --rollers"
            )
    if not all(map(math.isfinite, arguments.stress)):
        wrong.append("--stress: the stresses must be finite numbers")
    if not arguments.size > 0.0:
        wrong.append(f"--size {arguments.size:g}: it must be positive")
    if arguments.cycles < 1:
        wrong.append(f"--cycles {arguments.cycles}: it must be 1 or more")
    if not 0.0 <= arguments.biot <= 1.0:
        wrong.append(f"--biot {arguments.biot:g}: it must be between 0 and 1")
    for file, what in ((arguments.traces, "traces"), (arguments.deck, "deck"), (arguments.femdem, "program")):
        if not Path(file).is_file():
            wrong.append(f"{file}: there is no such file ({what})" + (
                "; build first (./run.sh does)" if file == program() and checkout() else ""
            ))  # fmt: skip
    template = ""
    try:
        template = template_of(arguments) if arguments.deck.is_file() else ""
    except (InputError, OSError, UnicodeDecodeError) as error:
        wrong.append(str(error))
    try:
        arguments.results.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        wrong.append(f"--results {arguments.results}: {error.strerror}")
    if wrong:
        raise InputError("\n".join(f"error: {text}" for text in wrong))
    return phases, pressures, template


def template_of(arguments):
    """What of the deck stays in all decks; refused when it lacks what is changed in it."""
    kept = [
        line
        for line in arguments.deck.read_text(encoding="utf-8").splitlines(keepends=True)
        if not line.startswith(("!", "&stage", "&output")) and f"stage = '{FIRST}'" not in line
    ]
    text = "".join(kept)
    wrong = [
        f"{arguments.deck}: {old} is there {text.count(old)} times, it must be once"
        for old in ("title = '", "law = 'jcm'", "mesh = 'two_sets.msh'", "solver = 'implicit'")
        if text.count(old) != 1
    ]
    if not wrong and "', mesh" not in text[text.index("title = '") :]:
        wrong.append(f"{arguments.deck}: mesh must follow the title in &run")
    if wrong:
        raise InputError("\nerror: ".join(wrong))
    return text


def phase_text(name, loads, pressures, arguments):
    """Boundaries, pore pressure and stage of one phase"""
    explicit = arguments.solver == "explicit"
    move_time = MOVE_TIME.get(arguments.solver, MOVE_TIME_AT_REST)
    duration = move_time * (1 if explicit else arguments.cycles)
    text = loads.boundaries(name, arguments.rollers, duration)
    if name in pressures:
        pressure = f"pressure = {MPA * pressures[name]:.10g}, biot = {arguments.biot:g}"
        text += f"&pore_pressure group = 'all', stage = '{name}', {pressure} /\n"
    form = EXPLICIT_STAGE if explicit else STAGE
    return text + form.format(name=name, cycles=arguments.cycles, time=move_time)


def deck(template, arguments, model, phase, phases, pressures):
    """Text of the deck of a model and a phase: phase I, then the phase asked for."""
    text = template.replace("law = 'jcm'", f"law = '{model}'")
    text = text.replace("mesh = 'two_sets.msh'", f"mesh = '{MESH_NAME}'")
    text = text.replace("solver = 'implicit'", f"solver = '{arguments.solver}'")
    start = text.index("title = '")
    text = text.replace(
        text[start : text.index("', mesh", start)], f"title = '{model}, {phase}: {phases[phase].text}"
    )
    if arguments.rollers:
        text += ROLLERS
    for name in dict.fromkeys((FIRST, phase)):
        text += phase_text(name, phases[name], pressures, arguments)
    if arguments.solver == "explicit":
        text += "&explicit damping = 'local' /\n"
    if arguments.cracks:
        text += CRACKS
    if arguments.flow:
        text += FLOW.format(law=arguments.flow)
    return text


@dataclass
class Run:
    """One phase of one model."""

    model: str
    phase: str
    results: Path
    why: str = ""  # it failed; empty: it is done

    @property
    def name(self):
        return f"{self.model} {self.phase}"


def run(arguments, model, phase, text):
    """Run one phase of one model, branched from phase I, unless it is there already."""
    folder = arguments.results
    this = Run(model, phase, folder / model / phase)
    path = folder / f"{model}_{phase}.nml"
    start_from = folder / model / FIRST / "checkpoint.h5"
    ingredients = {
        "deck": text_fingerprint(text),
        "mesh": fingerprint(folder / MESH_NAME),
        "program": fingerprint(arguments.femdem),
    }
    if phase != FIRST:
        ingredients["phase I"] = fingerprint(start_from)
    kept = Kept(this.results, this.results / "run.log")
    differs = "asked for" if arguments.again else kept.differs(ingredients)
    if not differs:
        print(f"{this.name}: kept, same deck, mesh and program", flush=True)
        return this
    # What a run that fails early would leave of an older one must not be taken for its own
    kept.forget()
    for name in FILES:
        (this.results / name).unlink(missing_ok=True)
    path.write_text(text, encoding="utf-8")
    command = [arguments.femdem, "--quiet", "--output", this.results, path]
    if phase != FIRST:
        command[1:1] = ["--branch", start_from]
    start = time.monotonic()
    try:
        done = subprocess.run(command, check=False, stderr=subprocess.PIPE, text=True, errors="replace")
        status, said = done.returncode, done.stderr
    except OSError as error:
        status, said = FAILED, f"error: {arguments.femdem}: {error.strerror}\n"
    sys.stderr.write(said)
    sys.stderr.flush()
    if status != 0:
        errors = [line for line in said.splitlines() if line.startswith("error: ")]
        ended = f"ended by signal {-status}" if status < 0 else f"ended with status {status}"
        this.why = errors[0].removeprefix("error: ") if errors else ended
        print(f"{this.name}: FAILED after {time.monotonic() - start:.1f} s", flush=True)
        return this
    kept.remember(ingredients)
    print(f"{this.name}: {time.monotonic() - start:.1f} s ({differs})", flush=True)
    return this


def run_all(arguments, phases, pressures, template):
    """Every phase of every model; where phase I fails, the phases that branch from it are left out."""
    runs = []
    for model in arguments.models:
        first = None
        for phase in phases:
            if first is not None and first.why:
                results = arguments.results / model / phase
                runs.append(Run(model, phase, results, "left out: phase I, which it branches from, failed"))
                continue
            runs.append(
                run(arguments, model, phase, deck(template, arguments, model, phase, phases, pressures))
            )
            first = first or runs[-1]
    return runs


def draw(figure, runs, out, *options):
    """Draw one figure; what went wrong, if anything."""
    command = module("femdem", "plot", figure, *(one.results for one in runs), "--out", out, *options)
    status = subprocess.run([str(word) for word in command], check=False, env=environment()).returncode
    return f"figure {out.name}: femdem-plot {figure} ended with status {status}" if status else ""


def remove_figures(figures):
    """Figures of an earlier run are not shown beside those of this one."""
    for name in FIGURES:
        for suffix in (".png", ".pdf"):
            (figures / f"{name}{suffix}").unlink(missing_ok=True)
    for path in figures.glob(f"{FAILED_MAP}*"):
        path.unlink()
    (figures / TABLE).unlink(missing_ok=True)


def draw_failed(runs, figures):
    """A map of the last state of each run that failed after it had written one; what went wrong."""
    return [
        draw("map", [one], figures / f"{FAILED_MAP}{one.model}_{one.phase}", *MAP)
        for one in runs
        if one.why and (one.results / "fields.h5").is_file()
    ]


def draw_all(runs, phases, figures, flow=False):
    """The figures of the paper, and stress and displacement of the last phase, of what has been run; what went wrong."""
    wrong = draw_failed(runs, figures)
    done = [one for one in runs if not one.why]
    if not done:
        return [text for text in wrong if text] + ["no figure of several runs: none is done"]
    first = [one for one in done if one.model == done[0].model]
    # Models are compared in the last phase that most of them have come through
    number = {phase: sum(one.phase == phase for one in done) for phase in phases}
    last = max(phases, key=lambda phase: (number[phase], list(phases).index(phase)))
    same = [one for one in done if one.phase == last]
    if last != list(phases)[-1]:
        print(f"models, edge_histograms: drawn of {last}, the last phase that most models came through")
    wrong.append(draw("network", first, figures / "network"))
    if len(same) > 1:
        wrong.append(draw("models", same, figures / "models"))
    wrong.append(draw("edge_histograms", same, figures / "edge_histograms", "--csv", figures / TABLE))
    wrong.append(draw("stress", first[-1:], figures / "stress"))
    wrong.append(draw("map", first[-1:], figures / "displacement", *MAP))
    if flow:
        wrong.append(draw("flow", first[-1:], figures / "flow"))
        wrong.append(draw("permeability", same, figures / "permeability"))
    return [text for text in wrong if text]


def others_in(folder, runs):
    """Results in the folder that are not of this mesh, made by earlier commands."""
    mesh, own = fingerprint(folder / MESH_NAME), {one.results for one in runs}
    old = []
    for record in sorted(folder.glob(f"*/*{SUFFIX}")):
        results = record.with_name(record.name.removesuffix(SUFFIX))
        known = Kept(results).known()
        if results not in own and isinstance(known, dict) and known.get("mesh") != mesh:
            old.append(str(results.relative_to(folder)))
    return old


def count_network(arguments):
    """Numbers of the network as read and as cleaned: a table, a figure, a line on the screen."""
    window = arguments.window
    columns = {"as read": numbers_of(*exact_graph(read_traces(arguments.traces), window))}
    window = columns["as read"].window
    cleaned = arguments.results / CLEANED
    if cleaned.is_file():
        columns["cleaned"] = numbers_of(*exact_graph(read_traces(cleaned), window))
    write_numbers(arguments.results / NUMBERS, columns)
    for name, numbers in columns.items():
        rows = numbers.rows()
        print(
            f"network {name}: P20 {numbers.p20:.4g} 1/m2, P21 {numbers.p21:.4g} 1/m, "
            f"I {rows['nodes_I']}, Y {rows['nodes_Y']}, X {rows['nodes_X']}, boundary {rows['nodes_on_boundary']}, "
            f"{rows['branches']} branches, {numbers.connections_per_branch:.3g} connections a branch",
            flush=True,
        )
    return columns


def make_mesh(arguments):
    """Make the mesh, unless it is there; the status."""
    command = module("femdem.network.make_mesh", arguments.traces, "--size", arguments.size)
    command += ["--out", arguments.results / MESH_NAME, "--report", arguments.results / "mesh.txt"]
    command += ["--cleaned", arguments.results / CLEANED]
    if arguments.window:
        command += ["--window", *arguments.window]
    for hole in arguments.hole:
        command += ["--hole", *hole]
    for zone in arguments.zone:
        command += ["--zone", *zone]
    command += arguments.mesh
    mesh, report = arguments.results / MESH_NAME, arguments.results / "mesh.txt"
    if not arguments.again and not Kept(mesh).differs(ingredients_of(command)) and report.is_file():
        # Warnings of a mesh that is kept hold for these runs too
        lines = report.read_text(encoding="utf-8").splitlines()
        sys.stderr.write("".join(f"{line}\n" for line in lines if line.startswith("warning: ")))
    return make(mesh, command, again=arguments.again)


def arguments_of(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="femdem-network", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("traces", help="CSV file of traces: x1,y1,x2,y2,trace (m)")
    parser.add_argument(
        "--size", type=float, default=0.015, help="element size at fractures (m; default 0.015)"
    )
    add_options(parser)
    parser.add_argument(
        "--mesh",
        action="append",
        default=[],
        metavar="OPTION",
        help="option of femdem-mesh (--mesh=--feature=0.01; repeat)",
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
        metavar="NAME=LOADS",
        help="a phase, see above (default phase_2a=10,5 and phase_2b=15,5; repeat)",
    )
    parser.add_argument(
        "--rollers",
        action="store_true",
        help="left and bottom on rollers, stresses on the right and at the top (default: stresses on all sides)",
    )
    parser.add_argument(
        "--pore-pressure",
        action="append",
        default=[],
        metavar="[PHASE=]PRESSURE",
        help="pore pressure in rock and fractures from this phase on (MPa; default phase: phase_1; repeat)",
    )
    parser.add_argument("--biot", type=float, default=1.0, help="Biot coefficient of the rock (default 1)")
    parser.add_argument("--cycles", type=int, default=10, help="load increments of a phase (default 10)")
    parser.add_argument("--solver", choices=SOLVERS, default="implicit", help="solver (default implicit)")
    parser.add_argument(
        "--flow",
        nargs="?",
        const="equal",
        choices=HYDRAULIC,
        help="let the apertures conduct, with this hydraulic aperture (default: the mechanical one)",
    )
    parser.add_argument("--cracks", action="store_true", help="let the rock break (some minutes at 15 mm)")
    parser.add_argument("--deck", type=Path, default=DECK, help="deck that rock and joints are taken from")
    parser.add_argument(
        "--results", type=Path, help="results directory (default: results/network/NAME OF THE TRACES)"
    )
    parser.add_argument("--femdem", type=Path, default=program(), help="program (default: build/femdem)")
    parser.add_argument("--again", action="store_true", help="make mesh and runs anew in any case")
    parser.add_argument("--no-figures", action="store_true", help="draw nothing")
    arguments = parser.parse_args(words)
    arguments.results = arguments.results or results() / "network" / Path(arguments.traces).stem
    arguments.models = list(dict.fromkeys(arguments.models))
    return arguments


def main(words=None):
    arguments = arguments_of(words)
    try:
        phases, pressures, template = settle(arguments)
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(BAD_INPUT)
    figures = arguments.results / "figures"
    status = make_mesh(arguments)
    if status != 0:
        remove_figures(figures)
        print("no mesh, so nothing was run; see the error above", file=sys.stderr)
        sys.exit(status)
    columns = count_network(arguments)
    runs = run_all(arguments, phases, pressures, template)
    remove_figures(figures)
    if not arguments.no_figures:
        figures.mkdir(exist_ok=True)
        draw_ternary(figures / "ternary.png", columns)
    wrong = [] if arguments.no_figures else draw_all(runs, phases, figures, bool(arguments.flow))
    old = others_in(arguments.results, runs)
    if old:
        print(f"of another mesh than this one, from earlier commands: {', '.join(old)}")
    failed = [one for one in runs if one.why]
    if failed or wrong:
        print(f"{len(runs) - len(failed)} of {len(runs)} runs done; failed:", file=sys.stderr)
        for one in failed:
            print(f"  {one.name}: {one.why}", file=sys.stderr)
        for text in wrong:
            print(f"  {text}", file=sys.stderr)
        sys.exit(FAILED)


if __name__ == "__main__":
    main()
