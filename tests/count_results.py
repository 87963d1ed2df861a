#!/usr/bin/env python3
"""Count the tests of a JUnit report by ctest or pytest and print `N passed, N failed`.

    count_results.py [--show] REPORT

With --show the output of what failed comes first. A unit-test program holds many tests and is one test case to
ctest: its own closing line is what counts.
"""

import re
import sys
import xml.etree.ElementTree as ElementTree

STAND_IN = re.compile(r"(\d+) passed, (\d+) failed")
PFUNIT = re.compile(r"\((\d+) tests?\b")


def count(case):
    """Passed, failed and skipped tests of one test case of the report."""
    output = case.findtext("system-out") or ""
    bad = case.find("failure") is not None or case.find("error") is not None
    if not bad and case.find("skipped") is not None:
        return 0, 0, 1
    line = STAND_IN.search(output) if case.get("status") else None
    if line:
        passed, failed = int(line.group(1)), int(line.group(2))
        # A program that ended badly after an all-clear line has failed all the same.
        return passed, max(failed, int(bad)), 0
    if bad:
        return 0, 1, 0
    several = PFUNIT.search(output) if case.get("status") else None
    return int(several.group(1)) if several else 1, 0, 0


def main():
    cases = list(ElementTree.parse(sys.argv[-1]).getroot().iter("testcase"))
    counts = [count(case) for case in cases]
    if "--show" in sys.argv:
        for case, (_, failed, _) in zip(cases, counts, strict=True):
            if failed:
                print(f"{case.get('name')} failed:\n{(case.findtext('system-out') or '').rstrip()}")
    passed, failed, skipped = (sum(column) for column in zip((0, 0, 0), *counts, strict=True))
    print(f"{passed} passed, {failed} failed" + (f" ({skipped} skipped)" if skipped else ""))


if __name__ == "__main__":
    main()
