#!/usr/bin/env python3
"""Put deliberate faults into the code, one at a time, and see whether the fast tests notice. See manual/testing.md.

    mutants.py                       # all of tests/mutants.toml
    mutants.py --only NAME ...       # these (names may hold * and ?)
    mutants.py --list                # what there is; builds nothing

The tree is copied to a folder of its own (--folder keeps it for the next time) and built there once; then each mutant
is one changed line, an incremental build and its tests. The exit status is 1 when a mutant survives without a reason,
or cannot be made.
"""

import argparse
import fnmatch
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent
TABLE = Path(__file__).resolve().with_suffix(".toml")
BUILD = "build-mutants"
# A mutant may run for ever; what takes so long is noticed [s]
UNIT_TIMEOUT, SCENES_TIMEOUT = 120, 900


@dataclass
class Mutant:
    """One deliberate fault, a row of the table."""

    name: str
    file: str
    # Text of one line, there exactly once, and what takes its place
    old: str
    new: str
    # What the fault means
    meaning: str
    # Names of unit tests (regular expression) and of fast pytests (-k expression) that are to notice; one may be left out
    unit: str = ""
    scenes: str = ""
    # Why it may survive; empty: it may not
    may_survive: str = ""

    def unit_tests(self, top=TOP):
        """Unit tests of this mutant"""
        names = sorted(path.stem for path in (top / "tests" / "unit").glob("test_*.pf"))
        return [name for name in names if self.unit and re.fullmatch(self.unit, name)]

    def fault(self, top=TOP):
        """What is wrong with the row; empty when nothing is."""
        path = top / self.file
        if not path.is_file():
            return f"no file {self.file}"
        times = path.read_text(encoding="utf-8").count(self.old)
        if times != 1:
            return "text not found" if times == 0 else f"text is there {times} times"
        if "\n" in self.old + self.new or self.old == self.new:
            return "must change one line"
        if not self.unit and not self.scenes:
            return "no tests"
        if self.unit and not self.unit_tests(top):
            return f"no unit test is called {self.unit}"
        return ""


@dataclass
class Tree:
    """A copy of the tree and its build, in which the mutants are made."""

    top: Path
    jobs: int
    copied: list = field(default_factory=list)

    def update(self):
        """Copy what git knows or would add, where it differs."""
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=TOP,
            capture_output=True,
            check=True,
        )
        for name in filter(None, listed.stdout.decode().split("\0")):
            source, target = TOP / name, self.top / name
            if not source.is_file():
                continue
            content = source.read_bytes()
            if target.is_file() and target.read_bytes() == content:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            target.chmod(source.stat().st_mode)

    def run(self, command, timeout=None):
        """Exit status (-1: timed out) and output."""
        try:
            done = subprocess.run(
                command,
                cwd=self.top,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                timeout=timeout,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return -1, f"no end after {timeout} s"
        return done.returncode, done.stdout.decode(errors="replace")

    def configure(self):
        if (self.top / BUILD / "CMakeCache.txt").is_file():
            return
        # A mutant may leave a variable or a dummy without use: no warning is an error here
        command = [
            "cmake",
            "-S",
            ".",
            "-B",
            BUILD,
            "-G",
            "Ninja",
            "-DCMAKE_BUILD_TYPE=Release",
            "-DFEMDEM_WERROR=OFF",
        ]
        status, output = self.run(command)
        if status != 0:
            raise SystemExit(f"cannot configure:\n{output[-2000:]}")

    def build(self, tests):
        """Status and output of building the program and some unit tests."""
        return self.run(
            ["cmake", "--build", BUILD, "--parallel", str(self.jobs), "--target", "femdem", *sorted(tests)]
        )

    def unit_failure(self, tests):
        """What the unit tests notice; empty when nothing."""
        pattern = "^(" + "|".join(sorted(tests)) + ")$"
        command = [
            "ctest",
            "--test-dir",
            BUILD,
            "-R",
            pattern,
            "--no-tests=error",
            "--timeout",
            str(UNIT_TIMEOUT),
        ]
        _, output = self.run([*command, "--output-on-failure"])
        if "No tests were found" in output:
            raise SystemExit(f"no unit tests {pattern}")
        bad = re.findall(
            r"(test_\w+) \((?:Failed|Timeout|SEGFAULT|SIGTRAP|Subprocess[^)]*|Exception[^)]*|ILLEGAL)\)",
            output,
        )
        if not bad and "100% tests passed" in output:
            return ""
        first = re.search(r"failure in (\w+)", output)
        return (bad[0] if bad else "unit tests") + (f": {first[1]}" if first else "")

    def scene_failure(self, expression):
        """What the fast pytests notice; empty when nothing."""
        command = [
            sys.executable,
            "-m",
            "pytest",
            "tests",
            "-q",
            "-x",
            "-m",
            "fast",
            "--build",
            BUILD,
            "-k",
            expression,
        ]
        status, output = self.run(command, SCENES_TIMEOUT)
        if status == 0:
            return ""
        if status not in (-1, 1):
            raise SystemExit(f"pytest -k '{expression}' ends with status {status}:\n{output[-2000:]}")
        first = re.search(r"^(?:FAILED|ERROR) (?:\S*::)?(.+?)(?: - |$)", output, re.MULTILINE)
        return first[1] if first else output.strip().splitlines()[-1]


def read_table(path=TABLE):
    """All mutants."""
    with open(path, "rb") as file:
        return [Mutant(**row) for row in tomllib.load(file)["mutant"]]


def choose(mutants, patterns):
    """Those whose names match one of the patterns, sorted by file: two in the same file build once less."""
    for pattern in patterns:
        if not any(fnmatch.fnmatchcase(mutant.name, pattern) for mutant in mutants):
            raise SystemExit(f"no mutant is called {pattern}")
    chosen = [
        mutant
        for mutant in mutants
        if not patterns or any(fnmatch.fnmatchcase(mutant.name, pattern) for pattern in patterns)
    ]
    return sorted(chosen, key=lambda mutant: mutant.file)


def check_unchanged(tree, mutants):
    """Without a fault all chosen tests must pass, or they say nothing."""
    tests = {test for mutant in mutants for test in mutant.unit_tests(tree.top)}
    status, output = tree.build(tests)
    if status != 0:
        raise SystemExit(f"the unchanged code does not build:\n{output[-2000:]}")
    noticed = tree.unit_failure(tests) if tests else ""
    expressions = sorted({mutant.scenes for mutant in mutants if mutant.scenes})
    for expression in expressions:
        noticed = noticed or tree.scene_failure(expression)
    if noticed:
        raise SystemExit(f"fails on the unchanged code: {noticed}")


def try_mutant(tree, mutant):
    """Result of one mutant, in words: 'killed by ...', 'survived', 'does not compile', or the fault of its row."""
    if fault := mutant.fault(tree.top):
        return fault
    path = tree.top / mutant.file
    unchanged = path.read_text(encoding="utf-8")
    tests = mutant.unit_tests(tree.top)
    try:
        path.write_text(unchanged.replace(mutant.old, mutant.new), encoding="utf-8")
        status, output = tree.build(tests)
        if status != 0:
            error = re.search(r"^.*Error: .*$", output, re.MULTILINE)
            return "does not compile" + (f": {error[0]}" if error else "")
        noticed = tree.unit_failure(tests) if tests else ""
        if not noticed and mutant.scenes:
            noticed = tree.scene_failure(mutant.scenes)
    finally:
        path.write_text(unchanged, encoding="utf-8")
    return f"killed by {noticed}" if noticed else "survived"


def is_copied(folder):
    """Is a folder a part of the tree that is copied?"""
    if folder != TOP and TOP not in folder.parents:
        return False
    return subprocess.run(["git", "check-ignore", "-q", f"{folder}/"], cwd=TOP, check=False).returncode != 0


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="NAME", help="mutants to try; names may hold * and ?"
    )
    parser.add_argument("--list", action="store_true", help="list the mutants and what is to notice them")
    parser.add_argument(
        "--folder", type=Path, help="folder of the copy, kept for the next time (default: a temporary one)"
    )
    parser.add_argument("--jobs", type=int, default=2, help="compilers at a time (default: 2)")
    arguments = parser.parse_args()

    mutants = choose(read_table(), arguments.only)
    if arguments.list:
        for mutant in mutants:
            print(f"{mutant.name:32} {mutant.file:38} {mutant.unit or '-'}; {mutant.scenes or '-'}")
        return 0

    if arguments.folder and is_copied(arguments.folder.resolve()):
        parser.error(
            f"{arguments.folder} would be copied into itself; take a folder that git ignores, such as build-mutants"
        )
    with tempfile.TemporaryDirectory(prefix="femdem-mutants-") as temporary:
        tree = Tree((arguments.folder or Path(temporary)).resolve(), arguments.jobs)
        start = time.monotonic()
        tree.update()
        tree.configure()
        sound = [mutant for mutant in mutants if not mutant.fault(tree.top)]
        check_unchanged(tree, sound)
        print(f"unchanged: all tests pass ({time.monotonic() - start:.0f} s)", flush=True)
        bad = killed = 0
        for mutant in mutants:
            start = time.monotonic()
            result = try_mutant(tree, mutant)
            if result.startswith("killed"):
                killed += 1
                if mutant.may_survive:
                    result += " (its reason to survive is out of date)"
            elif result == "survived" and mutant.may_survive:
                result += f", as it may: {mutant.may_survive}"
            else:
                bad += 1
                result = result.upper() if result == "survived" else result
            print(f"{mutant.name:32} {result} ({time.monotonic() - start:.0f} s)", flush=True)
    print(
        f"{len(mutants)} mutants, {killed} killed, {len(mutants) - killed - bad} survive for a reason, {bad} not in order"
    )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
