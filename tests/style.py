#!/usr/bin/env python3
"""Check the project's style rules on every file git knows, and print `N passed, N failed` (checks, not files).

    style.py [--tools DIRECTORY]
    style.py --graph                # which layer uses which, as it is drawn in manual/design.md

DIRECTORY holds fprettify and ruff. Without it those checks are skipped, or fail where CI=true.
"""

import argparse
import graphlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent
# The longest line of free-form Fortran 2008
MAX_COLUMNS = 132
MAX_ASSERTION_COLUMNS = 132  # an assertion of a .pf file cannot be continued
MAX_ROUTINE_LINES = 120
MAX_FILE_KIB = 1024
# A layer may use its own modules and those of a lower number.
LAYER_HEIGHT = {
    "base": 0,
    "joint": 1,
    "linear": 1,
    "deck": 1,
    "mesh": 1,
    "topology": 2,
    "solid": 2,
    "contact": 2,
    "loads": 2,
    "flow": 2,
    "store": 1,
    "mechanics": 3,
    "solve": 4,
    "output": 4,
}
# Who may convert between SI units and MPa, mm (units_m), and why
CONVERTS = {
    "modules/mechanics/joint_border_m.f90": "between the rock and the laws of joints",
    "modules/joint": "the laws, for what the deck gives them in SI units",
    "modules/flow/flow_domain_m.f90": "apertures come in mm, from joints and from the deck",
    "modules/flow/hydraulic_aperture_m.f90": "its source has apertures in micrometres",
    "modules/output": "tables and messages, where a name says mm or MPa",
}
# Who may change the model, all else has it intent(in)
CHANGES_MODEL = {
    "begin_stage": "the loads of a stage",
    "recut": "rock that breaks or is taken out",
    "run_cycle": "calls recut when a solver says so",
}
CHANGED_MODEL = re.compile(r"^\s*(?:type|class)\(model_t\)(?!.*intent\(in\)).*\bintent\(", re.IGNORECASE)
TEXT_SUFFIXES = ".f90 .pf .py .sh .cmake .md .toml .txt .json .nml .geo .cff .yml .csv".split()  # noqa: SIM905
CODE_SUFFIXES = [".f90", ".pf", ".py", ".sh"]

MODULE = re.compile(r"^\s*module\s+(\w+)\s*$", re.IGNORECASE | re.MULTILINE)
USE = re.compile(
    r"^[ ]*use(?:[ ]*,[ ]*intrinsic[ ]*::|[ ]*::|[ ])[ ]*(\w+)(.*)$", re.IGNORECASE | re.MULTILINE
)
STOP = re.compile(r"^\s*(?:if\s*\(.*\)\s*)?(error\s+stop|stop)\b", re.IGNORECASE)
ROUTINE = re.compile(r"^\s*(?:(?!end\b)[\w()=, *]+\s)?(subroutine|function)\s+(\w+)", re.IGNORECASE)
ROUTINE_END = re.compile(r"^\s*end\s*(subroutine|function)\b", re.IGNORECASE)
# A factor of a thousand or its powers, beside * or / or by the name of a constant
THOUSAND = r"(?:1(?:\.0*)?[ed][+-]?0?[369]|1(?:\.0*)?[ed][+-]?12|1000\.0*|0\.001)(?:_wp)?\b"
FACTOR = re.compile(rf"[*/]\s*{THOUSAND}|(?<![\w.]){THOUSAND}\s*[*/]", re.IGNORECASE)
NAMED_FACTOR = re.compile(
    rf"parameter\b.*\b(?:mega(?!byte)|milli(?!on)|micro|giga|kilo|mpa|mm_|per_m)\w*\s*=\s*{THOUSAND}",
    re.IGNORECASE,
)
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")


def known_files():
    """Files git tracks or would track, that exist."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=TOP, capture_output=True, text=True, check=True).stdout
    return sorted(TOP / name for name in set(listed.split("\0")) if name and (TOP / name).is_file())


FILES = known_files()


def with_suffix(*suffixes):
    return [path for path in FILES if path.suffix in suffixes]


def is_text(path):
    return path.suffix in TEXT_SUFFIXES or path.name in ("CMakeLists.txt", "run", "LICENSE")


def name_of(path):
    return str(path.relative_to(TOP))


def read(path):
    return path.read_text(encoding="utf-8")


def lines_of(path):
    return list(enumerate(read(path).splitlines(), start=1))


def statement(line):
    """A Fortran line without its comment and without what stands in quotes."""
    return re.sub(r"'[^']*'|\"[^\"]*\"", "''", line).split("!")[0]


def run_tool(command):
    """Output of a tool that complains on its standard output."""
    done = subprocess.run([str(word) for word in command], cwd=TOP, capture_output=True, text=True)
    complaints = done.stdout.splitlines()
    if done.returncode and not complaints:
        complaints = done.stderr.splitlines() or [f"{command[0]} ended with status {done.returncode}"]
    return complaints


# ----------------------------------------------------------------------------------------------- checks with tools


def check_fortran_formatting(tools):
    complaints = run_tool([tools / "fprettify", "-c", ".fprettify.rc", "-d", *with_suffix(".f90", ".pf")])
    if not any(line.startswith("Traceback") for line in complaints):
        return complaints
    # fprettify has died of one file, without saying which
    complaints = []
    for path in with_suffix(".f90", ".pf"):
        found = run_tool([tools / "fprettify", "-c", ".fprettify.rc", "-d", path])
        died = any(line.startswith("Traceback") for line in found)
        complaints += [f"{name_of(path)}: fprettify dies of this file: {found[-1]}"] if died else found
    return complaints


def check_python_lint(tools):
    return run_tool([tools / "ruff", "check", "-q", "--output-format", "concise", *with_suffix(".py")])


def check_python_formatting(tools):
    return run_tool([tools / "ruff", "format", "-q", "--diff", *with_suffix(".py")])


# --------------------------------------------------------------------------------------------- checks without tools


def check_spelling():
    if not shutil.which("codespell"):
        return ["codespell is missing"]
    return run_tool(["codespell", *(path for path in FILES if is_text(path))])


def check_shell_scripts():
    scripts = [p for p in FILES if p.suffix == ".sh" or (p.parent.name == ".ci" and p.name == "run")]
    complaints = []
    for script in scripts:
        done = subprocess.run(["bash", "-n", script], capture_output=True, text=True)
        complaints += done.stderr.splitlines()
    if shutil.which("shellcheck"):
        complaints += run_tool(["shellcheck", "-x", "-f", "gcc", *scripts])
    return complaints


def check_blanks():
    """No tabs, no trailing blanks, one line end at the end of the file."""
    complaints = []
    for path in filter(is_text, FILES):
        for number, line in lines_of(path):
            if "\t" in line:
                complaints.append(f"{name_of(path)}:{number}: tab")
            if line != line.rstrip():
                complaints.append(f"{name_of(path)}:{number}: blanks at the end of the line")
        text = read(path)
        if text and (not text.endswith("\n") or text.endswith("\n\n")):
            complaints.append(f"{name_of(path)}: must end with one line end")
    return complaints


def check_line_length():
    complaints = []
    for path in FILES:
        if path.suffix not in CODE_SUFFIXES:
            continue
        for number, line in lines_of(path):
            limit = MAX_ASSERTION_COLUMNS if line.lstrip().startswith("@") else MAX_COLUMNS
            if len(line) > limit:
                complaints.append(f"{name_of(path)}:{number}: {len(line)} columns, at most {limit}")
    return complaints


def check_modules():
    """One module a file, named as the file, with implicit none and private."""
    complaints = []
    where = {}
    for path in with_suffix(".f90"):
        text = read(path)
        modules = MODULE.findall(text)
        for module in modules:
            if where.setdefault(module.lower(), path) != path:
                complaints.append(
                    f"{name_of(path)}: module {module} is also in {name_of(where[module.lower()])}"
                )
        if "modules" in path.relative_to(TOP).parts and len(modules) != 1:
            complaints.append(f"{name_of(path)}: {len(modules)} modules, must be one")
        for module in modules:
            if module != path.stem:
                complaints.append(f"{name_of(path)}: module {module} must be named as its file")
            for word in ("implicit none", "private"):
                if not re.search(rf"^   {word}\s*$", text, re.MULTILINE):
                    complaints.append(f"{name_of(path)}: no '{word}'")
        if not modules and not re.search(r"^\s*implicit none\s*$", text, re.MULTILINE):
            complaints.append(f"{name_of(path)}: no 'implicit none'")
    return complaints


def check_use_only():
    complaints = []
    for path in with_suffix(".f90", ".pf"):
        for number, line in lines_of(path):
            use = USE.match(line)
            if (
                use
                and use.group(1).lower() != "funit"
                and not re.match(r"\s*,\s*only\s*:", use.group(2), re.I)
            ):
                complaints.append(f"{name_of(path)}:{number}: use {use.group(1)} without only")
    return complaints


def check_units():
    """Units are converted where CONVERTS says, by units_m."""
    complaints = []
    for path, used in uses().items():
        name = name_of(path)
        may = any(name == place or name.startswith(place + "/") for place in CONVERTS)
        if "units_m" in used and not may:
            complaints.append(f"{name}: uses units_m; SI units are converted in {', '.join(CONVERTS)} only")
        if path.stem == "units_m":
            continue
        for number, line in lines_of(path):
            if FACTOR.search(statement(line)) or NAMED_FACTOR.search(statement(line)):
                complaints.append(f"{name}:{number}: a factor between units; take it from units_m")
    return complaints


def check_model_is_constant():
    """The model is intent(in) everywhere but in CHANGES_MODEL; a function that builds a part of it returns that."""
    complaints = []
    for path in with_suffix(".f90"):
        if not name_of(path).startswith("modules/"):
            continue
        routine = ""
        for number, line in lines_of(path):
            bare = statement(line)
            if not ROUTINE_END.match(bare) and (begun := ROUTINE.match(bare)):
                routine = begun.group(2)
            if CHANGED_MODEL.match(bare) and routine not in (*CHANGES_MODEL, "build_model"):
                complaints.append(f"{name_of(path)}:{number}: {routine} changes the model")
    return complaints


def check_stops():
    """Only the programs in src and the benchmarks may stop."""
    complaints = []
    for path in with_suffix(".f90", ".pf"):
        folders = path.relative_to(TOP).parts[:-1]
        if folders[:1] == ("src",) or folders[:2] == ("tests", "bench"):
            continue
        for number, line in lines_of(path):
            if STOP.match(statement(line)):
                complaints.append(f"{name_of(path)}:{number}: {line.strip()}")
    return complaints


def uses():
    """Layer and file of each module of modules/, with the modules it uses."""
    modules = [path for path in with_suffix(".f90") if path.relative_to(TOP).parts[0] == "modules"]
    return {path: {used.lower() for used, _ in USE.findall(read(path))} for path in modules}


def layer_uses():
    """Which layers each layer uses: {layer: {used layer}}."""
    layer_of = {path.stem.lower(): path.parent.name for path in uses()}
    below = {layer: set() for layer in sorted(LAYER_HEIGHT)}
    for path, used in uses().items():
        others = {layer_of[module] for module in used if module in layer_of} - {path.parent.name}
        below.setdefault(path.parent.name, set()).update(others)
    return below


def check_layers():
    """A module uses nothing from a layer above its own."""
    complaints = []
    layer_of = {path.stem.lower(): path.parent.name for path in uses()}
    for path, used_modules in uses().items():
        layer = path.parent.name
        if layer not in LAYER_HEIGHT:
            complaints.append(f"{name_of(path)}: unknown layer {layer}; known: {', '.join(LAYER_HEIGHT)}")
            continue
        for used in sorted(used_modules):
            used_layer = layer_of.get(used, "base")
            if LAYER_HEIGHT.get(used_layer, 0) > LAYER_HEIGHT[layer]:
                complaints.append(f"{name_of(path)}: layer {layer} must not use {used} of layer {used_layer}")
    return complaints


def check_cycles():
    """Layers of one height may use each other one way only: the graph of layers has no cycle."""
    try:
        order_of_layers(layer_uses())
    except graphlib.CycleError as error:
        return ["layers use each other in a circle: " + " -> ".join(reversed(error.args[1]))]
    return []


def order_of_layers(direct):
    """Layers, those that are used before those that use them"""
    return list(graphlib.TopologicalSorter({layer: sorted(direct[layer]) for layer in direct}).static_order())


def graph():
    """The graph of layers in Mermaid's language: an arrow for who uses whom, left out where a longer way says it too."""
    direct, below = layer_uses(), {}
    lines = ["graph BT"]
    for layer in order_of_layers(direct):
        below[layer] = direct[layer].union(*(below[used] for used in direct[layer]))
        nearest = [used for used in direct[layer] if not any(used in below[other] for other in direct[layer])]
        lines += [f"    {layer} --> {used}" for used in sorted(nearest)]
    return "\n".join(lines) + "\n"


def check_graph_in_manual():
    """The picture in manual/design.md is that of the sources."""
    if graph() in read(TOP / "manual" / "design.md"):
        return []
    return [
        "manual/design.md: the graph of layers is not that of the sources; python3 tests/style.py --graph prints it"
    ]


def check_routine_length():
    """Lines of a routine without its internal procedures."""
    complaints = []
    for path in with_suffix(".f90", ".pf"):
        open_routines = []
        for number, line in lines_of(path):
            bare = statement(line)
            if ROUTINE_END.match(bare):
                if open_routines:
                    name, start, inside = open_routines.pop()
                    whole = number - start + 1
                    if open_routines:
                        open_routines[-1][2] += whole
                    length = whole - inside
                    if length > MAX_ROUTINE_LINES:
                        complaints.append(
                            f"{name_of(path)}:{start}: {name} has {length} lines, at most {MAX_ROUTINE_LINES}"
                        )
            elif routine := ROUTINE.match(bare):
                open_routines.append([routine.group(2), number, 0])
    return complaints


def check_procedures_used():
    """Every procedure of the program is used by the program: what only tests need is among the tests."""
    words, defined = {}, {}
    for path in (path for path in FILES if path.suffix in (".f90", ".inc")):
        if path.relative_to(TOP).parts[0] not in ("modules", "src"):
            continue
        inside = []
        # Continued lines are one; what is public or imported is not yet used
        text = re.sub(r"&\s*\n\s*&?", "", "\n".join(map(statement, read(path).splitlines())))
        for line in text.splitlines():
            if ROUTINE_END.match(line):
                inside = inside[:-1]
            elif routine := ROUTINE.match(line):
                inside = [*inside, routine.group(2).lower()]
                defined[inside[-1], path] = len(inside)
            elif not re.match(r"\s*(?:public\b|use\b|private\b)", line):
                for word in set(re.findall(r"\w+", line.lower())) - set(inside):
                    words.setdefault(word, set()).add(path)
    return [f"{name_of(path)}: nothing but tests uses {name}" for name, path in defined if name not in words]


def check_sources_listed():
    """Every module and unit test stands in the CMakeLists.txt beside it, and nothing else does."""
    complaints = []
    for lists in (path for path in FILES if path.name == "CMakeLists.txt"):
        folder, text = lists.parent, read(lists)
        listed = set(re.findall(r"\b(\w+\.f90)\b", re.sub(r"#.*", "", text)))
        tests = re.findall(r"^femdem_unit_test\((\w+)\)", text, re.MULTILINE)
        complaints += [
            f"{name_of(lists)}: {name} is listed twice" for name in set(tests) if tests.count(name) > 1
        ]
        listed |= {f"{name}.pf" for name in tests}
        if folder.parent.name == "modules" or name_of(folder) == "tests/unit":
            present = {
                path.name for path in FILES if path.parent == folder and path.suffix in (".f90", ".pf")
            }
            # name.f90.in becomes name.f90 in the build directory
            made = {path.stem for path in FILES if path.parent == folder and path.suffix == ".in"}
            complaints += [f"{name_of(lists)}: {name} is not listed" for name in sorted(present - listed)]
            complaints += [
                f"{name_of(lists)}: {name} is listed but missing" for name in sorted(listed - present - made)
            ]
    return complaints


def check_links():
    """Relative links of the Markdown pages lead to files."""
    complaints = []
    for path in with_suffix(".md"):
        for target in LINK.findall(read(path)):
            if (
                "://" not in target
                and not target.startswith("mailto:")
                and not (path.parent / target).exists()
            ):
                complaints.append(f"{name_of(path)}: link to {target}, which does not exist")
    return complaints


def check_file_sizes():
    """Results and meshes are made, not kept."""
    sizes = ((path, path.stat().st_size // 1024) for path in FILES)
    return [
        f"{name_of(path)}: {size} KiB, at most {MAX_FILE_KIB}" for path, size in sizes if size > MAX_FILE_KIB
    ]


TOOL_CHECKS = [check_fortran_formatting, check_python_lint, check_python_formatting]
CHECKS = [
    check_spelling,
    check_shell_scripts,
    check_blanks,
    check_line_length,
    check_modules,
    check_use_only,
    check_units,
    check_model_is_constant,
    check_stops,
    check_layers,
    check_cycles,
    check_graph_in_manual,
    check_routine_length,
    check_procedures_used,
    check_sources_listed,
    check_links,
    check_file_sizes,
]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--tools", type=Path, help="directory with fprettify and ruff")
    parser.add_argument("--graph", action="store_true", help="print which layer uses which, and end")
    arguments = parser.parse_args()
    if arguments.graph:
        print(graph(), end="")
        return 0
    tools = arguments.tools
    results = {}
    for check in TOOL_CHECKS:
        if tools:
            results[check] = check(tools.resolve())
        elif os.environ.get("CI") == "true":
            results[check] = ["the tool could not be installed"]
        else:
            print(f"skipped: {title(check)} (the tool could not be installed)")
    for check in CHECKS:
        results[check] = check()
    for check, complaints in results.items():
        if complaints:
            print(f"FAILED: {title(check)}")
            print("\n".join(f"  {line}" for line in complaints))
    failed = sum(bool(complaints) for complaints in results.values())
    print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed else 0


def title(check):
    return check.__name__.removeprefix("check_").replace("_", " ")


if __name__ == "__main__":
    sys.exit(main())
