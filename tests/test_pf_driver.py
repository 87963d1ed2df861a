"""The stand-in for pFUnit must fail where pFUnit would fail: a test that cannot fail proves nothing."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.tools

TESTS = Path(__file__).resolve().parent
DRIVER = TESTS / "pf_driver.py"
FLAGS = [
    "-std=f2008",
    "-Wall",
    "-Wextra",
    "-Wimplicit-interface",
    "-Wimplicit-procedure",
    "-Og",
    "-fcheck=all",
]
FLAGS += ["-ffpe-trap=invalid,zero,overflow", "-finit-real=snan", "-ffpe-summary=none"]

# The module around the tests; below, assertions that must pass and assertions that must fail with a message
SAMPLE = """
module test_sample
   use funit
   use, intrinsic :: iso_fortran_env, only: wp => real64, i8 => int64
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_signaling_nan, ieee_positive_inf
   implicit none
   integer :: set_up_calls = 0, tear_down_calls = 0
   real(wp) :: nan, infinity
contains
   @before
   subroutine set_up()
      set_up_calls = set_up_calls + 1
      nan = ieee_value(nan, ieee_quiet_nan)
      infinity = ieee_value(infinity, ieee_positive_inf)
   end subroutine
   @after
   subroutine tear_down()
      tear_down_calls = tear_down_calls + 1
   end subroutine
{tests}
end module test_sample
"""

PASSING = [
    "@assertEqual(1.0_wp, 1.0_wp)",
    "@assertEqual(1.0_wp, 1.0_wp + 1.0e-9_wp, tolerance=2.0e-9_wp)",
    "@assertEqual(1.0_wp, 1.0_wp + 1.0e-9_wp, 2.0e-9_wp, 'a trailing message, with a comma')",
    "@assertEqual(infinity, infinity)",
    "@assertEqual([1.0_wp, 2.0_wp], [1.0_wp, 2.0_wp])",
    "@assertEqual(reshape([1.0_wp, 2.0_wp], [1, 2]), reshape([1.0_wp, 2.0_wp], [1, 2]), tolerance=0.0_wp)",
    "@assertEqual(2.0_wp, [2.0_wp, 2.0_wp])",
    "@assertEqual(3, 3)",
    "@assertEqual(3, 3_i8)",
    "@assertEqual([1, 2], [1, 2], message='named')",
    "@assertEqual(.true., .true.)",
    "@assertEqual('it''s (a) text', 'it''s (a) text  ')",
    "@ASSERTTRUE(1 < 2)",
    "@asserttrue([.true., .true.])",
    "@assertFalse(1 > 2, 'trailing')",
    "@assertRelativelyEqual(100.0_wp, 100.9_wp, tolerance=0.01_wp)",
    "@assertLessThan(1.0_wp, 2.0_wp)",
    "@assertLessThanOrEqual(2, 2)",
    "@assertGreaterThan(2.0_wp, 1.0_wp, message='named')",
    "@assertGreaterThanOrEqual(2.0_wp, 2.0_wp)",
    "@assertIsNaN(nan)",
    "@assertIsFinite(1.0_wp)",
]

FAILING = {
    "@assertEqual(1.0_wp, 1.0_wp + epsilon(1.0_wp))": "expected 1.0000000000000000, found 1.0000000000000002",
    "@assertEqual(1.0_wp, 1.1_wp, tolerance=0.01_wp)": "tolerance 0.1",
    "@assertEqual(nan, nan)": "expected NaN, found NaN",
    "@assertEqual(nan, 1.0_wp, tolerance=infinity)": "expected NaN, found 1.0",
    "@assertEqual(1.0_wp, nan, tolerance=huge(1.0_wp))": "expected 1.0000000000000000, found NaN",
    "@assertEqual(1.0_wp, ieee_value(1.0_wp, ieee_signaling_nan), tolerance=1.0_wp)": "found NaN",
    "@assertEqual(1.0_wp, infinity, tolerance=1.0_wp)": "found Inf",
    "@assertEqual([1.0_wp, 2.0_wp], [1.0_wp, 3.0_wp])": "at [2]",
    "@assertEqual([1.0_wp], [1.0_wp, 3.0_wp])": "shape: expected [1], found [2]",
    "@assertEqual(reshape([1, 2, 3, 4], [2, 2]), reshape([1, 2, 0, 4], [2, 2]))": "expected 3, found 0, at [1, 2]",
    "@assertEqual(3, 4, 'words of mine')": "words of mine: expected 3, found 4",
    "@assertEqual(.true., .false.)": "1 of 1 not as expected",
    "@assertEqual('abc', 'abd')": 'expected "abc", found "abd"',
    "@assertTrue(1 > 2)": "expected true, found false",
    "@assertFalse(1 < 2, message='named')": "named: expected false, found true",
    "@assertRelativelyEqual(100.0_wp, 102.0_wp, tolerance=0.01_wp)": "relative tolerance",
    "@assertRelativelyEqual(0.0_wp, 0.0_wp, tolerance=0.01_wp)": "expected value is zero",
    "@assertRelativelyEqual(1.0_wp, nan, tolerance=0.01_wp)": "found NaN",
    "@assertLessThan(2.0_wp, 2.0_wp)": "to be less than 2.0",
    "@assertLessThan(nan, 2.0_wp)": "expected NaN to be less than",
    "@assertLessThanOrEqual(3, 2)": "expected 3 to be less than or equal 2",
    "@assertGreaterThan(2.0_wp, 2.0_wp)": "to be greater than",
    "@assertGreaterThanOrEqual(1.0_wp, 2.0_wp)": "to be greater than or equal",
    "@assertIsNaN(1.0_wp)": "expected NaN, found 1.0",
    "@assertIsFinite(nan)": "expected a finite number, found NaN",
    "@assertIsFinite(infinity)": "expected a finite number",
    "@assertExceptionRaised()": "Failed to throw exception.",
    "@assertExceptionRaised('a message')": "Failed to throw exception: <a message>",
}

FIXTURE_TESTS = """
   @test
   subroutine a_thrown_failure_can_be_taken_back()
      call throw('no such material')
      @assertExceptionRaised('no such material')
      call throw('anything')
      @assertExceptionRaised()
   end subroutine
   @Test
   ! a comment between the two lines is no harm
   subroutine a_failed_assertion_ends_its_test() ! nor one behind
      @assertTrue(.false., message='first')
      @assertTrue(.false., message='second')
   end subroutine
   @test
   subroutine fixtures_ran_around_every_test()
      @assertEqual(tear_down_calls + 1, set_up_calls)
      @assertGreaterThan(tear_down_calls, 10)
   end subroutine
"""


@pytest.fixture(scope="module")
def funit(tmp_path_factory):
    """The stand-in module, compiled once."""
    folder = tmp_path_factory.mktemp("funit")
    subprocess.run(["gfortran", *FLAGS, "-Werror", "-c", TESTS / "funit.f90"], cwd=folder, check=True)
    return folder


def translate(folder, text, name="test_sample"):
    source = folder / f"{name}.pf"
    source.write_text(text)
    command = [sys.executable, DRIVER, source, folder / f"{name}.f90"]
    return subprocess.run(command, capture_output=True, text=True)


def run(funit, folder, text):
    """Translate, compile and run a .pf text; the finished program with its output."""
    done = translate(folder, text)
    assert done.returncode == 0, done.stderr
    program = folder / "program"
    command = ["gfortran", *FLAGS, f"-I{funit}", f"-J{folder}", folder / "test_sample.f90", funit / "funit.o"]
    subprocess.run([*command, "-o", program], check=True)
    return subprocess.run([program], capture_output=True, text=True)


def one_test_each(assertions):
    return "\n".join(
        f"   @test\n   subroutine case_{i}()\n      {line}\n   end subroutine"
        for i, line in enumerate(assertions)
    )


def test_right_assertions_pass(funit, tmp_path):
    done = run(funit, tmp_path, SAMPLE.format(tests=one_test_each(PASSING)))
    assert done.stdout.splitlines() == [f"test_sample: {len(PASSING)} passed, 0 failed"]
    assert done.returncode == 0


def test_wrong_assertions_fail(funit, tmp_path):
    text = SAMPLE.format(tests=one_test_each(FAILING))
    done = run(funit, tmp_path, text)
    lines = done.stdout.splitlines()
    assert lines[-1] == f"test_sample: 0 passed, {len(FAILING)} failed"
    assert done.returncode == 1
    source = text.splitlines()
    for i, (assertion, message) in enumerate(FAILING.items()):
        line_number = next(number for number, line in enumerate(source, start=1) if line.strip() == assertion)
        report = next(line for line in lines if f"failure in case_{i}: " in line)
        assert report.startswith(f"test_sample.pf:{line_number}: ")
        assert message in report


def test_fixtures_exceptions_and_early_return(funit, tmp_path):
    done = run(funit, tmp_path, SAMPLE.format(tests=one_test_each(PASSING) + FIXTURE_TESTS))
    assert done.stdout.splitlines()[-1] == f"test_sample: {len(PASSING) + 2} passed, 1 failed"
    assert "first" in done.stdout
    assert "second" not in done.stdout


@pytest.mark.parametrize(
    ("tests", "complaint"),
    [
        ("", "no @test in this file"),
        ("   @test\n   integer function f()", "must be followed by a line with 'subroutine name()'"),
        ("   @test(ifdef=MPI)\n   subroutine a()", "takes no options"),
        ("   @test\n   subroutine a(b)", "must have no arguments"),
        ("   @test\n   subroutine a()\n   @test\n   subroutine A()", "a second test named A"),
        ("   @test\n   subroutine run()", "the name 'run' clashes"),
        ("   @test\n   subroutine " + "a" * 64 + "()", "the name has 64 letters, Fortran allows 63"),
        ("   @assertEqal(1, 1)", "unknown assertion @assertEqal"),
        ("   @assertEqual(1)", "needs at least 2 arguments, found 1"),
        ("   @assertRelativelyEqual(1.0, 1.0)", "needs at least 3 arguments"),
        ("   @assertTrue(f(1)", "brackets or quotes don't match"),
        ("   @assertTrue(.true.) ! comment", "without a comment behind it"),
        ("   @assertEqual(1, &", "must stand on one line"),
        ("   @suite(name='x')", "unknown directive @suite"),
        ("   @before\n   subroutine again()", "a second @before"),
        ("   @assertTrue(" + "a" * 130 + ")", "line too long by"),
    ],
)
def test_what_pfunit_would_not_take_is_an_error(tmp_path, tests, complaint):
    done = translate(tmp_path, SAMPLE.format(tests=tests))
    assert done.returncode == 1
    assert complaint in done.stderr
    assert re.search(r"test_sample\.pf:\d+: error: ", done.stderr)


def test_the_module_is_named_as_the_file(tmp_path):
    done = translate(tmp_path, SAMPLE.format(tests=one_test_each(PASSING)), name="test_other")
    assert "must be named as its file, test_other" in done.stderr
