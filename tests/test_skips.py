"""What a scene does not need is skipped: the same answers with every skip off, and from every solver.

Each scene is run by every solver that can do it, with all skips on, with each of them turned off alone and with all turned
off: those of &plan, the implicit solver's kept matrix (&implicit matrix), and no cohesive joints where nothing breaks
(&cohesive with strengths that are never reached). Compared are the means over the joints, the rock's strain energy and the
displacement of every node at the end. What is found is printed (pytest -s).

What may differ, and why:
  nothing but rounding    contact looked for where it cannot be, all nodes cleared, viscous forces of no viscosity, loads anew;
                          any of them in the implicit solver, and everything but other masses in the relaxation solver
  other steps             the explicit solver with its step found in every step (a search has the step found too), or with its
                          surfaces numbered anew (&cohesive does that): a run that ends at a given unbalanced force ends in
                          another step, and one that does not has the error of its time stepping
  the balance asked for   the implicit solver with another matrix, the relaxation solver with other masses
"""

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from femdem.results import Results
from scene import TOP, mesh_command, read_history, run_command
from scene_motion import changed_deck, run_deck

pytestmark = pytest.mark.xdist_group("skips")
PLAN = ("contact", "search", "nodes", "viscosity", "step", "loads")
# Without viscosity to find; a single step or no masses to find
NOT_IN = {"explicit": (), "relaxation": ("viscosity",), "implicit": ("nodes", "viscosity", "step")}
STRONG = "&cohesive group = 'all', tensile_strength = 1e12, cohesion = 1e12, friction_angle = 30, g_i = 1e12, g_ii = 1e12 /"
ROUNDING = 1e-9
# Ten times &implicit and &relaxation tolerance
BALANCE = {"implicit": 1e-6, "relaxation": 1e-5}
# Asked for between solvers
SOLVERS = 1e-2

RECTANGLES = "tests/scenes/_meshes/rectangles.py"
BOX = "input/direct_shear/make_mesh.py"
CRACK = "tests/scenes/inclined_crack/make_mesh.py"
SPECIMENS = "tests/scenes/_specimens/specimens.py"
STACK_MESH = [
    "--joint",
    "block_1,0,0,0.25,0.25,3,3,free",
    "block_2,0,0.25,0.25,0.25,3,3,free",
    "block_3,0,0.5,0.25,0.25,3,3",
    "block_4,0,0.75,0.25,0.25,3,3,free",
]
BLOCK_MESH = ["base,-0.1,-0.05,0.4,0.05,16,2", "block,0,1e-6,0.2,0.1,8,4"]
FLAW_MESH = "flaw --width 0.5 --height 1 --flaw 0.2 --angle 45 --size 0.04 --coarse 0.08 --fine 0.1 --seed 1"
LOCAL = "&explicit damping = 'local', damping_factor = 0.8 /\n"
SCALED = "&explicit damping = 'local', mass_scaling = 'step', scaled_step = 7e-7 /\n"
VISCOUS = "&explicit damping = 'viscous', damping_factor = {} /\n"
SHEAR = (
    "&stage name = 'load', move_time = 4e-3{} /\n&stage name = 'shear', cycles = 60, move_time = 5e-4{} /\n"
)
PHASES = "&stage name = 'phase_1', {0} /\n&stage name = 'phase_2b', {0} /\n"
CLOSE = "&stage name = 'close', cycles = 2, move_time = 3e-3{} /\n"
PRESS = "&stage name = 'load', cycles = {}, move_time = {}{} /\n"
SLIDE = "".join(
    f"&stage name = '{name}', move_time = {time}, profile = 'constant' /\n"
    for name, time in (("load", 0.03), ("lead", 0.01), ("slide", 0.02))
)
REST = ", equilibrium = 1e-6, max_rest_time = 0.5"


@dataclass(frozen=True)
class Scene:
    """A deck, the script of its mesh with arguments, and for each solver that can do it stages and solver group."""

    deck: str
    script: str
    arguments: list
    solvers: dict
    other_steps: float  # what may differ when an explicit run takes other steps
    changes: tuple = ()  # of the deck: (old, new)
    leave_out: tuple = ()  # skips that the explicit solver is not run without alone, for the time it takes


SCENES = {
    "stack": Scene(
        "tests/scenes/joint_stack/stack.nml",
        RECTANGLES,
        STACK_MESH,
        dict.fromkeys(
            ("explicit", "relaxation", "implicit"), PRESS.format(1, 0.02, REST.replace("1e-6", "1e-9"))
        ),
        1e-7,  # it rests at a ratio of 1e-9
    ),
    "closure": Scene(
        "input/closure/closure_6cm.nml",
        BOX,
        ["--length", "0.06", "--size", "0.004", "--out", "closure_6cm.msh"],
        {"explicit": CLOSE.format(REST), "relaxation": CLOSE.format(""), "implicit": CLOSE.format("")},
        1e-4,
        leave_out=PLAN,
    ),
    "shear": Scene(
        "tests/scenes/relaxation_shear/shear_relaxation.nml",
        BOX,
        ["--length", "0.06", "--size", "0.003", "--out", "shear_6cm.msh"],
        {
            "explicit": SHEAR.format(REST.replace("1e-6", "1e-3"), ", profile = 'constant'") + SCALED,
            "relaxation": SHEAR.format("", ""),
            "implicit": SHEAR.format("", ""),
        },
        5e-4,  # driven, its masses raised in other steps
        leave_out=PLAN,
    ),
    "crack": Scene(
        "tests/scenes/inclined_crack/crack.nml",
        CRACK,
        ["--side", "1", "--size", "0.02", "--out", "crack.msh"],
        {
            "explicit": PRESS.format(1, 2e-2, REST),
            "relaxation": PRESS.format(2, 1e-2, ""),
            "implicit": PRESS.format(2, 1e-2, ""),
        },
        2e-4,
        (("kn_mpa_mm = 1e5, ks_mpa_mm = 1e4", "kn_mpa_mm = 500, ks_mpa_mm = 500"),),
    ),
    "incline": Scene(
        "tests/scenes/relaxation_incline/slides.nml",
        RECTANGLES,
        BLOCK_MESH,
        {"explicit": PRESS.format(1, 0.1, REST), "relaxation": PRESS.format(1, 0.1, "")},
        1e-3,  # of a micrometre: it falls through its gap, and creeps as it bounces
        (("gx = 6.3057463 , gy = -7.5148960", "gx = 3.3552176, gy = -9.2183846"),),  # 20 degrees
    ),
    "block": Scene(
        "tests/scenes/sliding_block/sliding_block.nml",
        RECTANGLES,
        BLOCK_MESH,
        {"explicit": SLIDE + VISCOUS.format(1)},
        ROUNDING,
    ),
    "network": Scene(
        "input/network/phase_2b.nml",
        "femdem-mesh",
        ["two_sets.csv", "--size", "0.08", "--out", "two_sets.msh"],
        {
            # Which corners hold is seen at calm moments, and these come at other steps; bonds leave no corners
            "explicit": PHASES.format("move_time = 2e-3")
            + VISCOUS.format(0.2)
            + "&contact corner_factor = 0 /\n",
            "implicit": PHASES.format("cycles = 10, move_time = 1e-2"),
        },
        1e-4,
        leave_out=PLAN,
    ),
    # Cracks of a run that takes other steps are other cracks: only skips that change no step
    "breaking": Scene(
        "tests/scenes/restart_cracks/press.nml",
        SPECIMENS,
        FLAW_MESH.split(),
        {
            "explicit": "&stage name = 'press', move_time = 3e-4, cycles = 40, profile = 'constant' /\n"
            + VISCOUS.format(0.3)
        },
        0.0,
        tuple(
            (f"&boundary group = '{side}', stage = 'confine', pressure = 1e6 /\n", "")
            for side in ("left", "right")
        ),
        ("search", "step", "all", "bonds"),
    ),
}


def skips_of(name, solver):
    """Skips to turn off: what the deck is given for it."""
    texts = {skip: f"&plan skip_{skip} = .false. /" for skip in PLAN}
    texts["all"] = "&plan " + ", ".join(f"skip_{skip} = .false." for skip in PLAN) + " /"
    texts["bonds"] = STRONG
    left_out = (*NOT_IN[solver], *(SCENES[name].leave_out if solver == "explicit" else ()))
    chosen = {skip: text for skip, text in texts.items() if skip not in left_out}
    if solver == "implicit":
        chosen["matrix"] = "&implicit matrix = 'new' /"
    return chosen


def tolerance_of(name, solver, skip):
    """See the top of this file."""
    if solver == "explicit" and skip in ("contact", "search", "step", "all", "bonds"):
        return max(SCENES[name].other_steps, ROUNDING)
    if solver == "relaxation" and skip in ("search", "step", "all"):
        return BALANCE[solver]
    return BALANCE[solver] if skip == "matrix" else ROUNDING


def deck_text(name, solver, extra):
    """The deck of a scene for a solver, with groups added."""
    scene = SCENES[name]
    text = (TOP / scene.deck).read_text(encoding="utf-8")
    for old, new in scene.changes:
        assert text.count(old) == 1, f"{scene.deck}: '{old}' is there {text.count(old)} times"
        text = text.replace(old, new)
    text = re.sub(r"(?m)^&(stage|explicit|implicit|relaxation|output)\b.*\n", "", text)
    text, solvers = re.subn(r"solver = '\w+'", f"solver = '{solver}'", text)
    assert solvers == 1, f"{scene.deck} names {solvers} solvers"
    group = scene.solvers[solver]
    if solver == "explicit" and "&explicit" not in group:
        group += LOCAL
    return f"{text}\n{group}{extra}\n"


@dataclass
class Answer:
    """The end of a run."""

    log: str
    means: dict
    displacement: np.ndarray
    searches: int


class Runs:
    """Scenes in folders of their own, each run made once."""

    def __init__(self, place):
        self.place = place
        self.known = {}

    def folder(self, name):
        folder = self.place / name
        if not folder.exists():
            scene = SCENES[name]
            source = TOP / (scene.deck if scene.script.startswith("femdem-") else scene.script)
            shutil.copytree(source.parent, folder)
            mesh = mesh_command([Path(scene.script).name, *scene.arguments])
            run_command(mesh, folder, 120, expected_status=0)
        return folder

    def answer(self, name, solver, skip="none", extra=""):
        if (name, solver, skip) not in self.known:
            folder = self.folder(name)
            run = f"{solver}_{skip}"
            (folder / f"{run}.nml").write_text(deck_text(name, solver, extra), encoding="utf-8")
            results = run_deck(folder, f"{run}.nml", run, "--quiet")
            history = read_history(results / "history.csv")
            means = {key: column[-1] for key, column in history.items() if "." in key or key == "strain_J"}
            log = (results / "run.log").read_text(encoding="utf-8")
            found = re.search(r"(\d+) searches", log)
            self.known[name, solver, skip] = Answer(
                log,
                means,
                Results(results).fields.read("displacement", -1),
                int(found[1]) if found else 0,
            )
        return self.known[name, solver, skip]


@pytest.fixture(scope="module")
def runs(tmp_path_factory, femdem):
    assert femdem.is_file()
    return Runs(tmp_path_factory.mktemp("skips"))


def largest_difference(one, other):
    """Largest difference of two answers: means over the largest of their unit, displacement over the largest."""

    def size(name):
        unit = name.rsplit("_", 1)[1]
        return max(abs(one.means[key]) for key in one.means if key.endswith("_" + unit))

    off = {name: abs(one.means[name] - other.means[name]) / size(name) for name in one.means if size(name)}
    assert one.displacement.shape == other.displacement.shape, "another mesh: other cracks"
    off["displacement"] = np.abs(one.displacement - other.displacement).max() / np.abs(one.displacement).max()
    worst = max(off, key=off.get)
    return off[worst], worst


CASES = [
    (name, solver, skip)
    for name, scene in SCENES.items()
    for solver in scene.solvers
    for skip in skips_of(name, solver)
]


@pytest.mark.parametrize(("name", "solver", "skip"), CASES)
def test_same_answer_without_the_skip(name, solver, skip, runs):
    skipped = runs.answer(name, solver)
    whole = runs.answer(name, solver, skip, skips_of(name, solver)[skip])
    if skip in PLAN:
        assert f"(&plan skip_{skip})" in whole.log
    looks = skip == "all" or (skip == "search" and "never searched" not in skipped.log)
    if looks and solver != "implicit":
        assert whole.searches > 100 * max(1, skipped.searches), "the searches were skipped all the same"
    difference, worst = largest_difference(skipped, whole)
    print(f"{name}, {solver}, {skip}: at most {difference:.1e}, {worst}")
    tolerance = tolerance_of(name, solver, skip)
    assert difference <= tolerance, f"{worst} differs by {difference:.1e}, more than {tolerance:.1e}"


@pytest.mark.parametrize("solver", ["explicit", "relaxation", "implicit"])
def test_contact_is_looked_for_only_where_it_can_be(solver, runs):
    """The plate with a crack inside is convex, and the crack's walls have their own contact."""
    whole = runs.answer("crack", solver, "contact", skips_of("crack", solver)["contact"])
    assert runs.answer("crack", solver).searches == 0
    assert "never searched" in runs.answer("crack", solver).log
    assert whole.searches > 0
    assert "never searched" not in whole.log


@pytest.mark.parametrize("name", ["stack", "closure", "shear", "crack", "incline"])
def test_every_solver_finds_the_same(name, runs):
    """The network has a scene of its own, tests/scenes/network_three_solvers: it takes the explicit solver minutes."""
    *others, last = SCENES[name].solvers
    reference = runs.answer(name, last).means
    # What is zero but for rounding and settling says nothing
    small = {key: 1e-3 if "MPa" in key else 1e-4 for key in reference}
    for solver in others:
        means = runs.answer(name, solver).means
        off = {
            key: abs(means[key] - value) / abs(value)
            for key, value in reference.items()
            if abs(value) > small[key]
        }
        worst = max(off, key=off.get)
        print(f"{name}, {solver} against {last}: at most {off[worst]:.1e}, {worst}")
        assert off[worst] <= SOLVERS, f"{name}, {solver}: {worst} differs by {off[worst]:.1e}"


def test_joints_everywhere_are_a_softer_rock(runs):
    """insertion = 'everywhere' is another model: what it adds in compliance goes with one over the penalty."""
    shared = np.abs(runs.answer("stack", "implicit").displacement).max()
    added = []
    for factor in (100, 1000, 10000):
        group = STRONG.replace(" /", f", insertion = 'everywhere', penalty_factor = {factor} /")
        cut = runs.answer("stack", "implicit", f"penalty_{factor}", group)
        added.append(factor * (np.abs(cut.displacement).max() / shared - 1))
    print("softer by", *(f"{a:.3f}" for a in added), "over the penalty factor")
    assert min(added) > 0
    assert max(added) < 1.02 * min(added)


STILL = ("&explicit damping = 'local', damping_factor = 0.8 /", "")
SIDES = tuple((f"&boundary group = 'block_{i}_left', vx = 0 /\n", "") for i in (1, 2, 3, 4))
NOTHING = "implicit: nothing in the deck is dynamic"
CHOICES = {
    "the stack of joints": ((), "explicit: the deck has settings for it (&explicit)"),
    "at rest": ((STILL,), NOTHING),
    "with settings for relaxation": (
        (STILL, ("&stage", "&relaxation safety = 0.8 /\n&stage")),
        "relaxation: ",
    ),
    "that may break": ((STILL, ("&stage", STRONG + "\n&stage")), NOTHING),
    "moving": (
        (STILL, ("&stage", "&initial group = 'block_4', vy = -1 /\n&stage")),
        "explicit: bodies have initial velocities",
    ),
    "friction of motion": (
        (STILL, ("ks_mpa_mm = 2", "ks_mpa_mm = 2, friction = 'velocity'")),
        "explicit: friction follows",
    ),
    "friction of motion between bodies": (
        (STILL, ("&stage", "&contact friction = 'velocity' /\n&stage")),
        "explicit: friction follows",
    ),
    "potential contact": (
        (STILL, ("ks_mpa_mm = 2", "ks_mpa_mm = 2, contact = 'potential', normal = 'penalty'")),
        "relaxation: joints are in potential contact",
    ),
    "nothing holds": ((STILL, *SIDES), "explicit: nothing holds the rock"),
    "nothing holds, but in balance": (
        (STILL, *SIDES, ("&stage", "&implicit loose_bodies = 'hold' /\n&stage")),
        NOTHING,
    ),
}


@pytest.mark.parametrize("case", CHOICES)
def test_auto_takes_what_the_scene_needs(case, runs):
    changes, expected = CHOICES[case]
    folder = runs.folder("stack")
    (folder / "stack.nml").write_bytes((TOP / SCENES["stack"].deck).read_bytes())
    changed_deck(folder, "stack.nml", "auto.nml", ("'explicit'", "'auto'"), *changes)
    run_deck(folder, "auto.nml", "auto", "--check")
    said = (folder / "auto.txt").read_text(encoding="utf-8")
    line = next(line for line in said.splitlines() if line.startswith("solver"))
    assert line.split(maxsplit=1)[1].startswith(expected), line


def test_auto_sees_bodies_that_can_meet(runs):
    """A block on a base, no joint between them: loose it may move; held it can meet the base."""
    folder = runs.folder("block")
    text = (TOP / SCENES["block"].deck).read_text(encoding="utf-8").replace("'explicit'", "'auto'")
    kept = [line for line in text.splitlines() if not line.startswith(("&initial", "&explicit"))]
    (folder / "free.nml").write_text("\n".join(kept) + "\n", encoding="utf-8")
    run_deck(folder, "free.nml", "free", "--check")
    assert "explicit: nothing holds the rock" in (folder / "free.txt").read_text(encoding="utf-8")
    held = "&boundary group = 'block', vx = 0, vy = 0 /\n"
    lines = [line for line in kept if "group = 'block', stage" not in line]
    (folder / "held.nml").write_text("\n".join(lines) + "\n" + held, encoding="utf-8")
    run_deck(folder, "held.nml", "held", "--check")
    assert "relaxation: bodies that share no joint" in (folder / "held.txt").read_text(encoding="utf-8")


def test_auto_is_the_solver_it_names(runs):
    """The same run as with the solver named, and the deck beside the results names it."""
    named = runs.answer("stack", "implicit")
    folder = runs.folder("stack")
    text = deck_text("stack", "implicit", "").replace("'implicit'", "'auto'")
    (folder / "chosen.nml").write_text(text, encoding="utf-8")
    results = run_deck(folder, "chosen.nml", "chosen", "--quiet")
    assert "solver = 'implicit'" in re.sub(r"\s+", " ", (results / "deck.nml").read_text(encoding="utf-8"))
    assert np.array_equal(Results(results).fields.read("displacement", -1), named.displacement)
