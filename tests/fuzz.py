#!/usr/bin/env python3
"""Mutated decks and meshes: whatever they hold, the program ends in order.

    python3 tests/fuzz.py                                      # 200 decks, 100 meshes, the release build
    python3 tests/fuzz.py --decks 20000 --meshes 5000 --seed 7 --program build-debug/femdem
    python3 tests/fuzz.py --seed 7 --only deck:1234 --keep .   # one of them again, its files kept

Each case is made from the seed and its number alone. A run must end with status 0, 1 or 2 (3 when it had to be stopped after
--seconds), with a message where it is not 0, without a signal, a trap or a word of the runtime library, and without a
number in its tables that is none. The exit status is 1 when a case fails.
"""

import argparse
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent

RUNTIME_WORDS = (
    "Fortran runtime error",
    "Backtrace",
    "SIGFPE",
    "SIGSEGV",
    "AddressSanitizer",
    "runtime error:",
    "STOP",
    "HDF5-DIAG",
)
# Seconds for a run to notice that it is to stop; those in a long increment are killed then, and only counted
GRACE = 3.0
# Cases between two words on how far a long campaign is
PROGRESS = 1000

# ---- What is mutated -------------------------------------------------------------------------------------------------

MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
6
1 1 "bottom"
1 2 "fracture"
1 3 "top"
1 4 "side"
2 5 "rock"
2 6 "cap"
$EndPhysicalNames
$Nodes
9
1 0 0 0
2 1 0 0
3 2 0.1 0
4 0 1 0
5 1 1 0
6 2 1.1 0
7 0 2 0
8 1 2 0
9 2 2 0
$EndNodes
$Elements
16
1 1 2 1 1 1 2
2 1 2 1 1 2 3
3 1 2 2 2 4 5
4 1 2 2 2 5 6
5 1 2 3 3 7 8
6 1 2 3 3 8 9
7 1 2 4 4 3 6
8 1 2 4 4 6 9
9 2 2 5 5 1 2 5
10 2 2 5 5 1 5 4
11 2 2 5 5 2 3 6
12 2 2 5 5 2 6 5
13 2 2 6 6 4 5 8
14 2 2 6 6 4 8 7
15 2 2 6 6 5 6 9
16 2 2 6 6 5 9 8
$EndElements
"""

ROCK = """&material
   group = 'rock', density = 2700, young = 30e9, poisson = 0.27
/
&material group = 'cap', density = 2500, young = 20e9, poisson = 0.2, penalty_factor = 10 /
"""
JOINTS = (
    """&joint
   group = 'fracture', law = 'jcm', jrc0 = 9.7, jcs0_mpa = 169, l0 = 0.2, phi_r = 31
/
""",
    "&joint group = 'fracture', law = 'jcm', coupling = 'coupled', jrc0 = 9, jcs0_mpa = 80, l0 = 0.1, phi_r = 28,"
    " a0_mm = 0.2, sigma_c_mpa = 100, max_angle = 60 /\n",
    "&joint group = 'fracture', law = 'coulomb', friction_angle = 30, kn_mpa_mm = 10, ks_mpa_mm = 5 /\n",
    "&joint group = 'fracture', law = 'coulomb', friction_angle = 20, cohesion = 1e5, normal = 'penalty' /\n",
    "&joint group = 'fracture', law = 'dilatant_coulomb', coupling = 'coupled', friction_angle = 30, dilation_angle = 5,"
    " kn_mpa_mm = 10, ks_mpa_mm = 5, a0_mm = 0.1 /\n",
    "&joint group = 'fracture', law = 'jcm', jrc0 = 12, jcs0_mpa = 60, l0 = 0.1, phi_r = 27,"
    " closure_cycle = 'hysteresis', reversal = 'barton' /\n",
)
FRACTURE = (
    "",
    "&cohesive group = 'all', tensile_strength = 2e5, cohesion = 3e5, friction_angle = 30, g_i = 10, g_ii = 30 /\n",
    "&cohesive group = 'rock', insertion = 'everywhere', tensile_strength = 4e6, cohesion = 6e6,"
    " friction_angle = 40, g_i = 20, g_ii = 60, crack_joint = 'fracture' /\n",
)
REST = """&contact friction_angle = 30, skin_factor = 0.2 /
&boundary group = 'bottom', vx = 0, vy = 0 /
&boundary group = 'top', pressure = 5e6 /
&boundary
   group = 'top'
   stage = 'shear'
   tx = 1e6
/
&gravity gy = -9.81 /
&pore_pressure group = 'all', stage = 'shear', pressure = 1e5, biot = 0.8 /
&stage name = 'load', move_time = 2e-3, cycles = 2 /
&stage
   name = 'shear'
   cycles = 2
   move_time = 2e-3
   equilibrium = 1e-3
   max_rest_time = 4e-3
/
"""
SOLVERS = {
    "explicit": "&explicit damping = 'local', safety = 0.8 /\n&initial group = 'cap', vx = 0, vy = -0.1 /\n",
    "implicit": "&implicit tolerance = 1e-7, max_pseudo_steps = 50 /\n",
    "relaxation": "&relaxation tolerance = 1e-6, max_steps = 2000 /\n",
    "auto": "&implicit max_pseudo_steps = 50 /\n",
}
OUTPUT = "&output directory = 'results', fields_every = 1, history_every = 1, checkpoint_minutes = 0 /\n"

NUMBER_TEXT = (
    "0 -1 1 -0.0 1e300 -1e300 1e-300 1e30 1e-30 1e12 1e-12 1e9 1e-9 1e6 1e-6 1e3 1e-3 89.99999 90 0.49999 0.5 -0.99999 "
    "nan inf -inf 1e400 1d0 .5 5. 2147483647 2147483648 999999999 -999999999 1e1e1 0x10 1/2 '' .true. 3 7 12 100 1e4 1e5"
)
WORD_TEXT = (
    "'explicit' 'implicit' 'relaxation' 'auto' 'jcm' 'jcm_mean' 'coulomb' 'paper' 'coupled' 'slider' 'velocity' 'joint' "
    "'dilatant_coulomb' 'barton' 'hysteresis' '1' '3' "
    "'penalty' 'wall' 'potential' 'contact' 'walls' 'continuous' 'eq31' 'eq14' 'eq15' 'eq16' 'table' 'l0' 'extrapolate' "
    "'none' 'regions' 'adaptive' 'everywhere' 'smooth' 'constant' 'viscous' 'local' 'step' 'kept' 'new' 'refuse' 'hold' "
    "'rock' 'cap' 'fracture' 'top' 'bottom' 'side' 'all' 'load' 'shear' '' 'x' .true. .false."
)
MESH_TEXT = (
    "0 1 2 3 4 9 10 -1 1e300 -1e300 1e-300 nan inf 0.5 2147483648 4294967297 99999999999999999999 a "
    '1e-9 1.0000001 1e6 $End "x" 15 2.2 4.1'
)
NUMBERS, WORDS = NUMBER_TEXT.split(), WORD_TEXT.split()
# Variables of each group that the base decks leave at their defaults
EXTRA = {
    "run": "long = .true.",
    "material": "penalty_factor = 1;penalty_factor = 200",
    "joint": "contact = 'potential', normal = 'penalty';normal = 'penalty';normal = 'penalty', penalty = 1e10;"
    "friction = 'velocity';normal_stress = 'walls';aperture = 'eq31';peak = 'eq14';post_peak = 'eq16';"
    "closure_cycle = '1';reversal = 'barton';dilation_angle = 20;"
    "short_edges = 'l0';a0_mm = 0.1;max_angle = 5;cohesion = 1e5;kn_mpa_mm = 1;ks_mpa_mm = 100",
    "cohesive": "insertion_level = 0.1;check_every = 1;penalty_factor = 2;crack_friction_angle = 0;insertion = 'regions'",
    "contact": "friction = 'velocity';corner_factor = 0;tangential_factor = 3;active = .false.;skin_factor = 1",
    "boundary": "vx = 1e-3;vy = -1;vx = 1e3;tx = 1e6;ty = -2e7;ty = 1e9;pressure = 1e8;pressure = -1e6;"
    "sxx = 1e6, syy = 2e6, sxy = 3e5;stage = 'load'",
    "gravity": "gx = 9.81;ramped = .false.",
    "in_situ": "sxx = 1e6;syy = 2e6;sxy = 0;sxx_gradient = 1e4;reference_y = 0",
    "stage": "rest_time = 1e-3;profile = 'constant';equilibrium = 0.5;max_rest_time = 1e-3, equilibrium = 1e-6",
    "explicit": "mass_scaling = 'step', scaled_step = 1e-4;step = 1e-6;damping_factor = 0.1",
    "initial": "vx = 100",
    "implicit": "loose_bodies = 'hold';matrix = 'new';largest_cut = 0;max_iterations = 2;line_search = 0;max_memory = 1",
    "relaxation": "substeps = 3;safety = 0.1",
    "pore_pressure": "biot = 0",
    "output": "history_every = 3;fields_every = 0;checkpoint_minutes = 5",
}

# ---- Mutations -------------------------------------------------------------------------------------------------------


def base_deck(chance):
    solver = chance.choice(list(SOLVERS))
    head = f"! A deck\n&run\n   title = 'Fuzz', mesh = 'box.msh', solver = '{solver}'\n/\n"
    middle = ROCK + chance.choice(JOINTS) + chance.choice(FRACTURE)
    return head + middle + REST + SOLVERS[solver] + OUTPUT


def replace_match(text, pattern, chance, new):
    """Replace one of the matches of a pattern, chosen by chance"""
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    match = chance.choice(found)
    return text[: match.start(1)] + new(match.group(1)) + text[match.end(1) :]


def other_number(text, chance):
    return replace_match(text, r"= *([-+.\deEdD]+)", chance, lambda _: chance.choice(NUMBERS))


def scaled_number(text, chance):
    factor = 10.0 ** (chance.choice((1, 1, 1, 3, 9)) * chance.uniform(-1, 1))

    def scale(old):
        try:
            return repr(float(old.lower().replace("d", "e")) * factor)
        except ValueError:
            return old

    return replace_match(text, r"= *([-+.\deEdD]+)", chance, scale)


def other_word(text, chance):
    return replace_match(text, r"= *('[^'\n]*')", chance, lambda _: chance.choice(WORDS))


def other_name(text, chance):
    names = sorted(set(re.findall(r"(\w+) *=", text)))
    return replace_match(text, r"(\w+) *=", chance, lambda _: chance.choice(names))


def one_more(text, chance):
    """A variable more in a group, or a value in place of the one there"""
    groups = [match for match in re.finditer(r"&(\w+)[^&/]*", text) if match.group(1) in EXTRA]
    if not groups:
        return text
    group = chance.choice(groups)
    new = chance.choice(EXTRA[group.group(1)].split(";"))
    body = group.group(0)
    for name in re.findall(r"(\w+) =", new):
        body = re.sub(rf",?\s*\b{name} *= *[^,/\n]*,?", " ", body)
    place = 1 + len(group.group(1))
    return f"{text[: group.start()]}{body[:place]} {new}, {body[place:]}{text[group.end() :]}"


def lost_line(text, chance):
    lines = text.split("\n")
    del lines[chance.randrange(len(lines))]
    return "\n".join(lines)


def double_line(text, chance):
    lines = text.split("\n")
    lines.insert(chance.randrange(len(lines) + 1), chance.choice(lines))
    return "\n".join(lines)


def swapped_lines(text, chance):
    lines = text.split("\n")
    i, j = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    return "\n".join(lines)


def other_letter(text, chance):
    i = chance.randrange(len(text) + 1)
    new = chance.choice(
        ["", *"&/='\",!() \t\n\r0129.eE-+$%", "\x00", "\x1b", "\x7f", "é", "−", "\u00a0", "\ufeff"]
    )
    return text[:i] + new + text[i + chance.choice((0, 1, 1, 3)) :]


def cut_short(text, chance):
    return text[: chance.randrange(len(text) + 1)]


def other_token(text, chance):
    """A number of a mesh file replaced"""
    new = [*MESH_TEXT.split(), ""]
    return replace_match(text, r"(?<![\w.])(-?[\d.]+)(?![\w.])", chance, lambda _: chance.choice(new))


DECK_MUTATIONS = (
    *[other_number] * 4,
    *[scaled_number] * 16,
    *[other_word] * 3,
    *[one_more] * 12,
    other_name,
    lost_line,
    double_line,
    swapped_lines,
    other_letter,
    cut_short,
)


def moved_node(text, chance):
    """A node somewhere else: slivers, triangles turned over, blocks in one another"""
    size = 10.0 ** chance.uniform(-9, 1)
    lines = text.split("\n")
    nodes = [i for i, line in enumerate(lines) if re.fullmatch(r"\d+ [-\d.e]+ [-\d.e]+ 0", line)]
    if nodes:
        words = lines[chance.choice(nodes)].split()
        i = nodes[0] + int(words[0]) - 1 if nodes[0] + int(words[0]) - 1 < len(lines) else nodes[0]
        words[1], words[2] = (repr(float(word) + size * chance.uniform(-1, 1)) for word in words[1:3])
        lines[i] = " ".join(words)
    return "\n".join(lines)


def scaled_mesh(text, chance):
    """All places by the same factor, and elsewhere"""
    factor, shift = 10.0 ** chance.uniform(-6, 6), chance.choice((0.0, 0.0, 1e3, 1e6, 1e9))

    def scale(match):
        x, y = (repr(float(match.group(i)) * factor + shift) for i in (2, 3))
        return f"{match.group(1)} {x} {y} 0\n"

    return re.sub(r"^(\d+) ([-\d.]+) ([-\d.]+) 0\n", scale, text, flags=re.M)


MESH_MUTATIONS = (
    *[moved_node] * 8,
    *[scaled_mesh] * 3,
    *[other_token] * 5,
    lost_line,
    double_line,
    swapped_lines,
    other_letter,
    cut_short,
)


def mutated(text, mutations, chance):
    for _ in range(chance.choice((1, 1, 1, 2, 2, 3, 5))):
        text = chance.choice(mutations)(text, chance) or "\n"
    return text


def noise(chance):
    """A file that is no text at all: one message"""
    return bytes(chance.randrange(256) for _ in range(chance.randrange(1, 3000)))


def make_case(seed, kind, number, folder):
    """Deck and mesh of a case"""
    chance = random.Random(f"{seed} {kind} {number}")
    deck, mesh = base_deck(chance), MESH
    if kind == "deck":
        deck = mutated(deck, DECK_MUTATIONS, chance)
    else:
        mesh = mutated(mesh, MESH_MUTATIONS, chance)
    deck, mesh = (text.encode("utf-8", "surrogateescape") for text in (deck, mesh))
    if chance.random() < 0.03:
        deck, mesh = (noise(chance), mesh) if kind == "deck" else (deck, noise(chance))
    (folder / "deck.nml").write_bytes(deck)
    (folder / "box.msh").write_bytes(mesh)


# ---- Runs ------------------------------------------------------------------------------------------------------------


def run(program, folder, seconds):
    """Status (None: had to be killed), and what the program said"""
    with (
        (folder / "said.txt").open("wb") as said,
        subprocess.Popen(
            [program, "--quiet", "deck.nml"], cwd=folder, stdout=said, stderr=subprocess.STDOUT
        ) as process,
    ):
        status = None
        for ask, wait in ((None, seconds), (process.terminate, GRACE), (process.kill, None)):
            if ask:
                ask()
            try:
                status = process.wait(timeout=wait)
                break
            except subprocess.TimeoutExpired:
                continue
        # Stopped by this: killed, or told to end before it listens
        if status == -signal.SIGKILL or (ask and status == -signal.SIGTERM):
            status = None
    return status, (folder / "said.txt").read_text(encoding="utf-8", errors="replace")


def what_is_wrong(status, said, folder):
    """Why a case has failed; '' when it has not"""
    if status is not None and status not in (0, 1, 2, 3):
        return f"status {status}"
    for word in RUNTIME_WORDS:
        if word in said:
            return f"the runtime library spoke: {word}"
    if status in (1, 2) and not re.search(r"^error: .", said, re.M):
        return f"status {status} without a message"
    if status == 0 and "error: " in said:
        return "status 0 with an error"
    for path in folder.glob("*/*.csv"):
        table = path.read_text(encoding="utf-8", errors="replace").split("\n", 1)[-1].lower()
        if re.search(r"\bnan\b|inf|\*\*", table):
            return f"{path.name} holds what is no number"
    return ""


def one_case(arguments, kind, number, keep=None):
    """Status, what is wrong and what was said of one case"""
    folder = Path(tempfile.mkdtemp(prefix="fuzz_"))
    try:
        make_case(arguments.seed, kind, number, folder)
        status, said = run(arguments.program, folder, arguments.seconds)
        wrong = what_is_wrong(status, said, folder)
        if wrong or keep:
            target = Path(keep or arguments.failures) / f"{kind}_{arguments.seed}_{number}"
            shutil.copytree(folder, target, dirs_exist_ok=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return f"{kind}:{number}", status, wrong, said


def read_arguments(argv=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--decks", type=int, default=200, help="mutated decks (200)")
    parser.add_argument("--meshes", type=int, default=100, help="mutated meshes (100)")
    parser.add_argument("--seed", type=int, default=1, help="seed of all of them (1)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    parser.add_argument("--only", metavar="KIND:NUMBER", help="one case, 'deck:17' or 'mesh:4'")
    parser.add_argument("--program", type=Path, default=TOP / "build" / "femdem", help="build/femdem")
    parser.add_argument("--processes", type=int, default=2, help="runs at a time (2)")
    parser.add_argument("--seconds", type=float, default=10.0, help="after which a run is stopped (10)")
    parser.add_argument(
        "--failures", type=Path, default=Path("fuzz_failures"), help="folder for cases that fail"
    )
    parser.add_argument("--keep", type=Path, help="folder for all cases")
    arguments = parser.parse_args(argv)
    arguments.program = arguments.program.resolve()
    if not arguments.program.is_file():
        parser.error(f"{arguments.program} is not built")
    return arguments


def main(argv=None):
    arguments = read_arguments(argv)
    if arguments.only:
        kind, number = arguments.only.split(":")
        cases = [(kind, int(number))]
    else:
        numbers = {"deck": arguments.decks, "mesh": arguments.meshes}
        cases = [(kind, arguments.first + i) for kind, count in numbers.items() for i in range(count)]
    endings, failed = Counter(), []
    with ThreadPoolExecutor(arguments.processes) as pool:
        for name, status, wrong, said in pool.map(
            lambda case: one_case(arguments, *case, arguments.keep), cases
        ):
            kind = name.split(":")[0]
            endings[kind, "killed" if status is None else status] += 1
            if endings.total() % PROGRESS == 0:
                print(f"{endings.total()} of {len(cases)}", file=sys.stderr, flush=True)
            if wrong:
                failed.append(name)
                print(f"{name}: {wrong}\n  " + "\n  ".join(said.splitlines()[:12]), flush=True)
    for kind in ("deck", "mesh"):
        ends = ", ".join(f"{end}: {n}" for (k, end), n in sorted(endings.items(), key=str) if k == kind)
        print(f"{kind}: {ends}")
    print(f"{len(cases) - len(failed)} passed, {len(failed)} failed")
    if failed:
        print(f"failed: {' '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
