#!/usr/bin/env python3
"""Turn a unit test in pFUnit 4 syntax (.pf) into a plain Fortran program, for machines without pFUnit.

    pf_driver.py test_xxx.pf test_xxx.f90

The output holds the test's module, its assertions turned into calls of module `funit` (tests/funit.f90), and a main
program that runs every test. Compiler messages and failures name the line of the .pf file. What pFUnit's own
preprocessor would not take, or would silently leave out, is an error here too, so that a file that passes here passes
there. manual/testing.md describes the subset.
"""

import re
import sys
from pathlib import Path

# Assertion -> operands it needs at least
ASSERTIONS = {
    "equal": 2,
    "true": 1,
    "false": 1,
    "lessthan": 2,
    "lessthanorequal": 2,
    "greaterthan": 2,
    "greaterthanorequal": 2,
    "relativelyequal": 3,
    "exceptionraised": 0,
    "isnan": 1,
    "isfinite": 1,
}
MAX_COLUMNS = 132
MAX_NAME = 63
# Names pFUnit's generated suite declares beside everything public in the test module, and names `use funit` brings in:
# a public name of the test module spelt like one of these compiles here but not there.
RESERVED = """
    t suite test testcase testsuite testmethod testresult testrunner exception expectation subject predicate disable
    initialize run generic_run finalize stub get_context throw catch catchnext anyexceptions sourcelocation is every
    all_of any_of equal_to near relatively_near array contains_string
"""

DIRECTIVE = re.compile(r"\s*@(\w+)\s*(.*?)\s*$")
SUBROUTINE = re.compile(r"\s*subroutine\s+(\w+)\s*(\([\w\s,]*\))?\s*(!.*)?$", re.IGNORECASE)
MODULE = re.compile(r"\s*module\s+(\w+)\s*$", re.IGNORECASE)
PROCEDURE = re.compile(
    r"\s*(?:(?:pure|elemental|recursive|impure|logical|integer(?:\([^)]*\))?|real(?:\([^)]*\))?)\s+)*"
    r"(?:subroutine|function)\s+(\w+)",
    re.IGNORECASE,
)


class PfError(Exception):
    """Something in the .pf file that one of the two test drivers would not take."""


class PfFile:
    """One .pf file on its way to a Fortran program."""

    def __init__(self, path):
        self.path = Path(path)
        self.lines = self.path.read_text(encoding="utf-8").splitlines()
        self.module = None
        self.tests = []
        self.before = None
        self.after = None
        self.in_specification = True
        self.errors = []
        self.output = [self.line_marker(1)]

    def line_marker(self, number):
        return f'# {number} "{self.path}"'

    def error(self, number, text):
        self.errors.append(f"{self.path}:{number}: error: {text}")

    def translate(self):
        """Read all lines; the result is in self.output, the complaints in self.errors."""
        wanted = None  # the directive that waits for its subroutine
        for number, line in enumerate(self.lines, start=1):
            directive = DIRECTIVE.match(line)
            if directive:
                wanted = self.take_directive(number, line, directive, wanted)
                continue
            if wanted and line.strip() and not line.lstrip().startswith("!"):
                self.take_subroutine(number, line, wanted)
                wanted = None
            self.note_names(number, line)
            self.output.append(line)
        if wanted:
            self.error(len(self.lines), f"@{wanted} without a subroutine")
        self.check_whole()

    def take_directive(self, number, line, directive, wanted):
        """Handle a line that starts with '@'; returns the directive that now waits for a subroutine."""
        name, rest = directive.group(1), directive.group(2)
        key = name.lower()
        if wanted:
            self.error(number, f"@{wanted} must be followed by its subroutine, found @{name}")
        if key in ("test", "before", "after"):
            if rest:
                self.error(number, f"@{name} takes no options here, found '{rest}'")
            self.output.append("!" + line)
            return key
        if key.startswith("assert"):
            self.take_assertion(number, name, rest)
        else:
            self.error(
                number, f"unknown directive @{name}; known: @test, @before, @after, {known_assertions()}"
            )
            self.output.append("")
        return None

    def take_assertion(self, number, name, rest):
        kind = name[len("assert") :].lower()
        if kind not in ASSERTIONS:
            self.error(number, f"unknown assertion @{name}; known: {known_assertions()}")
        elif not (rest.startswith("(") and rest.endswith(")")):
            self.error(
                number, f"@{name} must stand on one line, arguments in brackets, without a comment behind it"
            )
        else:
            arguments = split_arguments(rest[1:-1])
            if arguments is None:
                self.error(number, f"@{name}: brackets or quotes don't match")
            elif len(arguments) < ASSERTIONS[kind]:
                self.error(
                    number, f"@{name} needs at least {ASSERTIONS[kind]} arguments, found {len(arguments)}"
                )
            else:
                inside = rest[1:-1].strip()
                call = f"  call {name}({inside}{', ' if inside else ''}&"
                if len(call) > MAX_COLUMNS:
                    self.error(
                        number, f"line too long by {len(call) - MAX_COLUMNS} columns once it is a call"
                    )
                self.output += [
                    self.line_marker(number),
                    call,
                    self.line_marker(number),
                    f"    & location=SourceLocation('{self.path.name}', {number}))",
                    self.line_marker(number),
                    "  if (anyExceptions()) return",
                ]
        self.output.append(self.line_marker(number + 1))

    def take_subroutine(self, number, line, wanted):
        match = SUBROUTINE.match(line)
        if not match:
            self.error(number, f"@{wanted} must be followed by a line with 'subroutine name()'")
            return
        name, arguments = match.group(1), (match.group(2) or "()")[1:-1].strip()
        if arguments:
            self.error(number, f"subroutine {name} behind @{wanted} must have no arguments")
        if wanted == "test":
            if len(name) > MAX_NAME:
                self.error(number, f"the name has {len(name)} letters, Fortran allows {MAX_NAME}")
            if name.lower() in (test.lower() for test in self.tests):
                self.error(number, f"a second test named {name}")
            self.tests.append(name)
        elif getattr(self, wanted):
            self.error(number, f"a second @{wanted}")
        else:
            setattr(self, wanted, name)

    def note_names(self, number, line):
        """Find the module's name; complain about names that clash with pFUnit's own."""
        match = MODULE.match(line)
        if match and not self.module:
            self.module = match.group(1)
        if re.match(r"\s*private\s*(!.*)?$", line, re.IGNORECASE):
            self.error(number, "a test module must not be private: its tests would be hidden")
        if re.match(r"\s*contains\s*(!.*)?$", line, re.IGNORECASE):
            self.in_specification = False
        names = []
        procedure = PROCEDURE.match(line)
        if procedure and not line.lstrip().lower().startswith("end"):
            names = [procedure.group(1)]
        used = re.match(r"\s*use\b.*\bonly\s*:(.*)$", line, re.IGNORECASE)
        if used:
            names = re.findall(r"(\w+)\s*(?:=>\s*\w+)?\s*(?:,|&|!|$)", used.group(1))
        if self.in_specification and "::" in line:
            names += re.findall(r"(?:^|,)\s*(\w+)", line.split("!")[0].split("::", 1)[1])
        for name in names:
            if name.lower() in RESERVED.split():
                self.error(number, f"the name '{name}' clashes with one of pFUnit's own")

    def check_whole(self):
        if not self.module:
            self.error(1, "no module (its line must be 'module name' with nothing behind it)")
        elif self.module.lower() != self.path.stem.lower():
            self.error(1, f"module {self.module} must be named as its file, {self.path.stem}")
        if not self.tests:
            self.error(1, "no @test in this file")
        if bool(self.before) != bool(self.after):
            self.error(1, "@before and @after must come together (pFUnit's preprocessor needs both)")

    def program(self):
        """The main program that runs the tests."""
        fixture = f", {self.before}, {self.after}" if self.before else ""
        runs = [f"   call run_test('{name}', &\n                 {name}{fixture})" for name in self.tests]
        return [
            "",
            f"program {self.module}_program",
            "   use funit, only: run_test, finish_tests",
            f"   use {self.module}",
            "   implicit none",
            "",
            *runs,
            f"   if (.not. finish_tests('{self.module}')) stop 1",
            f"end program {self.module}_program",
        ]


def known_assertions():
    return ", ".join("@assert" + kind for kind in ASSERTIONS)


def split_arguments(text):
    """Arguments between top-level commas; None when brackets or quotes don't match."""
    arguments, current, depth, quote = [], "", 0, ""
    for character in text:
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character in "([":
            depth += 1
        elif character in ")]":
            depth -= 1
            if depth < 0:
                return None
        elif character == "," and depth == 0:
            arguments.append(current.strip())
            current = ""
            continue
        current += character
    if depth or quote:
        return None
    if current.strip():
        arguments.append(current.strip())
    return arguments


def main():
    if len(sys.argv) != 3:
        print(__doc__)
        return 2
    test_file = PfFile(sys.argv[1])
    test_file.translate()
    if test_file.errors:
        print("\n".join(test_file.errors), file=sys.stderr)
        return 1
    Path(sys.argv[2]).write_text("\n".join(test_file.output + test_file.program()) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
