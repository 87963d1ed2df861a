"""What a scene does not need is skipped: the same answers with every skip off, and from every solver.

Skips that can be turned off by a deck: contact searched only where surfaces can meet and when one has moved half the skin
(&contact search), no cohesive joints where nothing can break (&fracture with strengths that are never reached), the matrix
of the implicit solver kept (&implicit matrix). Solvers: the bar of 1 % in mean shear stress, shear displacement and
aperture is the one asked for; what is found is printed.
"""

import shutil
import sys

import pytest
from scene import TOP, read_history, run_command
from scene_motion import changed_deck, run_deck

RECTANGLES = "tests/scenes/_meshes/rectangles.py"
STRONG = "&fracture group = 'all', tensile_strength = 1e12, cohesion = 1e12, friction_angle = 30, g_i = 1e12, g_ii = 1e12 /\n"
# Sums in another order; nothing else changes
ROUNDING = 1e-9
# The stack rests when the unbalanced force ratio is 1e-9; a search in every step divides the rest into other steps
SETTLED = 1e-7
# Ten times &implicit tolerance
BALANCE = 1e-6
# Asked for between solvers
SOLVERS = 1e-2

STACK = [
    "--joint",
    "block_1,0,0,0.25,0.25,3,3,free",
    "block_2,0,0.25,0.25,0.25,3,3,free",
    "block_3,0,0.5,0.25,0.25,3,3",
    "block_4,0,0.75,0.25,0.25,3,3,free",
]
BLOCK = ["base,-0.1,-0.05,0.4,0.05,16,2", "block,0,1e-6,0.2,0.1,8,4"]
BOX = ["--length", "0.06", "--size", "0.004", "--out"]
# Scene: deck, mesh script and its arguments
SCENES = {
    "stack": ("tests/scenes/joint_stack/stack.nml", RECTANGLES, STACK),
    "block": ("tests/scenes/sliding_block/sliding_block.nml", RECTANGLES, BLOCK),
    "shear": (
        "tests/scenes/relaxation_shear/shear_relaxation.nml",
        "input/direct_shear/make_mesh.py",
        [*BOX, "shear_6cm.msh"],
    ),
    "closure": (
        "input/closure/closure_6cm_implicit.nml",
        "input/direct_shear/make_mesh.py",
        [*BOX, "closure_6cm.msh"],
    ),
    "network": (
        "input/network/phase_2b.nml",
        "input/network/make_mesh.py",
        ["two_sets.csv", "--size", "0.08", "--out", "two_sets.msh"],
    ),
}


def folder_of(name, place):
    """A folder with the deck, as deck.nml, and the mesh of a scene."""
    deck, script, arguments = SCENES[name]
    folder = place / name
    shutil.copytree((TOP / script).parent, folder)
    shutil.copy(TOP / deck, folder / "deck.nml")
    run_command([sys.executable, (TOP / script).name, *arguments], folder, 120, expected_status=0)
    return folder


def with_group(folder, new, group, deck="deck.nml"):
    """Write a copy of a deck with a group added."""
    (folder / new).write_text((folder / deck).read_text(encoding="utf-8") + group, encoding="utf-8")
    return new


def last_rows(results):
    """The last row of the history, without what says how it was found (step, energies, balance)."""
    history = read_history(results / "history.csv")
    return {name: column[-1] for name, column in history.items() if "." in name or name == "strain_J"}


def largest_difference(one, other):
    """Largest difference of two last rows, each over the largest of its unit."""

    def size(name):
        unit = name.rsplit("_", 1)[1]
        return max(abs(one[key]) for key in one if key.endswith("_" + unit))

    off = {name: abs(one[name] - other[name]) / size(name) for name in one}
    worst = max(off, key=off.get)
    return off[worst], worst


SKIPS = [
    ("stack", "search", ("&stage", "&contact search = 'always' /\n&stage"), SETTLED),
    ("block", "search", ("&contact friction_angle", "&contact search = 'always', friction_angle"), ROUNDING),
    ("stack", "cohesive joints", ("&stage", STRONG + "&stage"), ROUNDING),
    ("closure", "cohesive joints", ("&stage", STRONG + "&stage"), ROUNDING),
    ("network", "cohesive joints", ("&run title", STRONG + "&run title"), ROUNDING),
    ("closure", "matrix", ("&stage", "&implicit matrix = 'new' /\n&stage"), BALANCE),
    ("network", "matrix", ("&run title", "&implicit matrix = 'new' /\n&run title"), BALANCE),
]


@pytest.mark.parametrize(("name", "skip", "change", "tolerance"), SKIPS)
@pytest.mark.usefixtures("femdem")
def test_same_answer_without_the_skip(name, skip, change, tolerance, tmp_path):
    folder = folder_of(name, tmp_path)
    if name == "block":  # the first two stages and some sliding are enough
        changed_deck(
            folder, "deck.nml", "deck.nml", ("'slide', move_time = 0.12", "'slide', move_time = 0.02")
        )
    with_skip = last_rows(run_deck(folder, "deck.nml", "skipped", "--quiet"))
    changed_deck(folder, "deck.nml", "whole.nml", change)
    without = last_rows(run_deck(folder, "whole.nml", "whole", "--quiet"))
    difference, worst = largest_difference(with_skip, without)
    print(f"{name}, {skip}: at most {difference:.1e}, {worst}")
    assert difference <= tolerance, f"{name}, {skip}: {worst} differs by {difference:.1e}"


def solver_decks(name, folder):
    """Decks of a scene for the explicit, relaxation and implicit solver."""
    rest = "equilibrium = 1e-6, max_rest_time = 0.2"
    damping = "&explicit damping = 'local', damping_factor = 0.8 /\n"
    if name == "stack":
        quiet = ("&explicit damping = 'local', damping_factor = 0.8 /", "")
        return {
            "explicit": "deck.nml",
            "relaxation": changed_deck(folder, "deck.nml", "r.nml", ("'explicit'", "'relaxation'"), quiet),
            "implicit": changed_deck(folder, "deck.nml", "i.nml", ("'explicit'", "'implicit'"), quiet),
        }
    shorter = ("cycles = 20, move_time = 3e-3", "cycles = 4, move_time = 3e-3")
    changed_deck(folder, "deck.nml", "i.nml", shorter)
    changed_deck(
        folder,
        "i.nml",
        "e0.nml",
        ("'implicit'", "'explicit'"),
        ("move_time = 3e-3", f"move_time = 3e-3, {rest}"),
    )
    return {
        "explicit": with_group(folder, "e.nml", damping, "e0.nml"),
        "relaxation": changed_deck(folder, "i.nml", "r.nml", ("'implicit'", "'relaxation'")),
        "implicit": "i.nml",
    }


@pytest.mark.parametrize("name", ["stack", "closure"])
@pytest.mark.usefixtures("femdem")
def test_every_solver_finds_the_same(name, tmp_path):
    folder = folder_of(name, tmp_path)
    found = {
        solver: last_rows(run_deck(folder, deck, solver, "--quiet"))
        for solver, deck in solver_decks(name, folder).items()
    }
    # What is zero but for rounding and settling says nothing
    small = {key: 1e-3 if "MPa" in key else 1e-4 for key in found["implicit"]}
    for solver, row in found.items():
        off = {
            key: abs(row[key] - value) / abs(value)
            for key, value in found["implicit"].items()
            if abs(value) > small[key]
        }
        worst = max(off, key=off.get)
        print(f"{name}, {solver} against implicit: at most {off[worst]:.1e}, {worst}")
        assert off[worst] <= SOLVERS, f"{name}, {solver}: {worst} differs by {off[worst]:.1e}"


@pytest.mark.usefixtures("femdem")
def test_auto_takes_what_the_scene_needs(tmp_path):
    chosen = {}
    for name, named in (("stack", "'explicit'"), ("block", "'explicit'"), ("network", "'implicit'")):
        folder = folder_of(name, tmp_path)
        changed_deck(folder, "deck.nml", "auto.nml", (named, "'auto'"))
        run_deck(folder, "auto.nml", "auto", "--check")
        said = (folder / "auto.txt").read_text(encoding="utf-8")
        chosen[name] = next(line for line in said.splitlines() if line.startswith("solver"))
    print(*chosen.values(), sep="\n")
    assert "explicit: the deck has settings" in chosen["stack"]
    assert "explicit: bodies have initial velocities" in chosen["block"]
    assert "implicit: nothing in the deck is dynamic" in chosen["network"]
    # Without its &explicit the stack is at rest; two bodies without a joint between them need contact
    folder = tmp_path / "stack"
    still = ("&explicit damping = 'local', damping_factor = 0.8 /", "")
    changed_deck(folder, "auto.nml", "still.nml", still)
    run_deck(folder, "still.nml", "still", "--check")
    assert "implicit: nothing" in (folder / "still.txt").read_text(encoding="utf-8")
    folder = tmp_path / "block"
    text = (folder / "deck.nml").read_text(encoding="utf-8").replace("'explicit'", "'auto'")
    kept = [line for line in text.splitlines() if not line.startswith(("&initial", "&explicit"))]
    (folder / "free.nml").write_text("\n".join(kept) + "\n", encoding="utf-8")
    run_deck(folder, "free.nml", "free", "--check")
    assert "explicit: nothing holds the rock" in (folder / "free.txt").read_text(encoding="utf-8")
    held = "&boundary group = 'block', vx = 0, vy = 0 /\n"
    lines = [line for line in kept if "group = 'block', stage" not in line]
    (folder / "held.nml").write_text("\n".join(lines) + "\n" + held, encoding="utf-8")
    run_deck(folder, "held.nml", "held", "--check")
    assert "relaxation: bodies that share no joint" in (folder / "held.txt").read_text(encoding="utf-8")
