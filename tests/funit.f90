!> Stand-in for pFUnit's module `funit`, used on machines without pFUnit.
!>
!> It knows the part of pFUnit 4 that the unit tests use: the assertions below, their argument order and their default
!> tolerance (exact). A failed assertion is kept in a list; the test that failed it returns. As in pFUnit the list is
!> module state: an assertion has no other place to leave its failure.
!> tests/pf_driver.py writes the programs that call run_test and finish_tests.
module funit
   use, intrinsic :: iso_fortran_env, only: real64, int32, int64, output_unit
   implicit none
   private

   public :: SourceLocation, throw, anyExceptions, run_test, finish_tests
   public :: assertEqual, assertTrue, assertFalse, assertRelativelyEqual
   public :: assertExceptionRaised, assertIsNaN, assertIsFinite
   public :: assertLessThan, assertLessThanOrEqual, assertGreaterThan, assertGreaterThanOrEqual

   !> Where an assertion stands
   type :: SourceLocation
      character(len=128) :: file = '<unknown>'
      integer :: line = 0
   end type SourceLocation

   !> A failed assertion waiting to be reported
   type :: failure_t
      character(len=:), allocatable :: message
      type(SourceLocation) :: location
   end type failure_t

   !> Comparisons
   integer, parameter :: less = 1, less_or_equal = 2, greater = 3, greater_or_equal = 4
   character(len=21), parameter :: relation_name(4) = ['less than            ', 'less than or equal   ', &
                                                       'greater than         ', 'greater than or equal']
   !> Failures a single test can hold before further ones are dropped
   integer, parameter :: most_failures = 32

   type(failure_t) :: failures(most_failures)
   integer :: failure_count = 0, passed_count = 0, failed_count = 0

   abstract interface
      subroutine test_procedure()
      end subroutine test_procedure
   end interface

   interface assertTrue
      module procedure true_0, true_1
   end interface assertTrue

   interface assertFalse
      module procedure false_0, false_1
   end interface assertFalse

   interface assertEqual
      module procedure equal_real_00, equal_real_01, equal_real_02, equal_real_11, equal_real_22
      module procedure near_real_00, near_real_01, near_real_02, near_real_11, near_real_22
      module procedure equal_integer_00, equal_integer_11, equal_integer_22
      module procedure equal_long_00, equal_long_11, equal_long_22, equal_mixed_00
      module procedure equal_logical_00, equal_logical_11, equal_text_00
   end interface assertEqual

   interface assertRelativelyEqual
      module procedure relative_00, relative_01, relative_11, relative_22
   end interface assertRelativelyEqual

   interface assertLessThan
      module procedure less_real_00, less_real_11, less_integer_00, less_long_00
   end interface assertLessThan

   interface assertLessThanOrEqual
      module procedure less_or_equal_real_00, less_or_equal_real_11, less_or_equal_integer_00, less_or_equal_long_00
   end interface assertLessThanOrEqual

   interface assertGreaterThan
      module procedure greater_real_00, greater_real_11, greater_integer_00, greater_long_00
   end interface assertGreaterThan

   interface assertGreaterThanOrEqual
      module procedure greater_or_equal_real_00, greater_or_equal_real_11, greater_or_equal_integer_00, &
         greater_or_equal_long_00
   end interface assertGreaterThanOrEqual

   interface assertExceptionRaised
      module procedure raised_any, raised_message
   end interface assertExceptionRaised

contains

   ! ---------------------------------------------------------------------------------------------- running tests

   !> Run one test between its fixture's set-up and tear-down, and print its failures.
   subroutine run_test(name, method, before, after)
      character(len=*), intent(in) :: name
      procedure(test_procedure) :: method
      procedure(test_procedure), optional :: before, after

      failure_count = 0
      if (present(before)) call before()
      if (failure_count == 0) call method()
      if (present(after)) call after()
      if (failure_count == 0) then
         passed_count = passed_count + 1
      else
         failed_count = failed_count + 1
         call write_failures(name)
      end if
   end subroutine run_test

   !> Print the count; tells whether all is well.
   logical function finish_tests(name) result(all_passed)
      character(len=*), intent(in) :: name

      write (output_unit, '(2a,i0,a,i0,a)') name, ': ', passed_count, ' passed, ', failed_count, ' failed'
      flush (output_unit)
      all_passed = failed_count == 0 .and. passed_count > 0
   end function finish_tests

   subroutine write_failures(name)
      character(len=*), intent(in) :: name
      integer :: i

      do i = 1, failure_count
         write (output_unit, '(2a,i0,4a)') trim(failures(i)%location%file), ':', failures(i)%location%line, &
            ': failure in ', name, ': ', failures(i)%message
      end do
      flush (output_unit)
   end subroutine write_failures

   ! -------------------------------------------------------------------------------------------------- exceptions

   !> Note a failure. A test may call it too, and take it back with assertExceptionRaised.
   subroutine throw(message, location)
      character(len=*), intent(in) :: message
      type(SourceLocation), intent(in), optional :: location

      if (failure_count == most_failures) return
      failure_count = failure_count + 1
      failures(failure_count)%message = message
      failures(failure_count)%location = SourceLocation()
      if (present(location)) failures(failure_count)%location = location
   end subroutine throw

   !> Has anything failed in this test?
   logical function anyExceptions()
      anyExceptions = failure_count > 0
   end function anyExceptions

   subroutine raised_any(location)
      type(SourceLocation), intent(in), optional :: location

      if (failure_count > 0) then
         failure_count = failure_count - 1
      else
         call throw('Failed to throw exception.', location)
      end if
   end subroutine raised_any

   subroutine raised_message(message, location)
      character(len=*), intent(in) :: message
      type(SourceLocation), intent(in), optional :: location
      integer :: i

      do i = 1, failure_count
         if (failures(i)%message == message) then
            failures(i:failure_count - 1) = failures(i + 1:failure_count)
            failure_count = failure_count - 1
            return
         end if
      end do
      call throw('Failed to throw exception: <'//message//'>', location)
   end subroutine raised_message

   !> A failure with the test's own words in front.
   subroutine fail(text, message, location)
      character(len=*), intent(in) :: text
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (present(message)) then
         call throw(message//': '//text, location)
      else
         call throw(text, location)
      end if
   end subroutine fail

   ! -------------------------------------------------------------------------------------------------- conditions

   subroutine true_0(condition, message, location)
      logical, intent(in) :: condition
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. condition) call fail('expected true, found false', message, location)
   end subroutine true_0

   subroutine true_1(condition, message, location)
      logical, intent(in) :: condition(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (all(condition)) return
      call fail('expected all true, found '//count_text(.not. condition)//' false', message, location)
   end subroutine true_1

   subroutine false_0(condition, message, location)
      logical, intent(in) :: condition
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (condition) call fail('expected false, found true', message, location)
   end subroutine false_0

   subroutine false_1(condition, message, location)
      logical, intent(in) :: condition(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. any(condition)) return
      call fail('expected all false, found '//count_text(condition)//' true', message, location)
   end subroutine false_1

   subroutine assertIsNaN(x, message, location)
      real(real64), intent(in) :: x
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. is_nan(x)) call fail('expected NaN, found '//real_text(x), message, location)
   end subroutine assertIsNaN

   subroutine assertIsFinite(x, message, location)
      real(real64), intent(in) :: x
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. is_finite(x)) call fail('expected a finite number, found '//real_text(x), message, location)
   end subroutine assertIsFinite

   ! ----------------------------------------------------------------------------------------------- equal: numbers

   subroutine equal_real_00(expected, found, message, location)
      real(real64), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call assertEqual(expected, found, 0.0_real64, message, location)
   end subroutine equal_real_00

   subroutine equal_real_01(expected, found, message, location)
      real(real64), intent(in) :: expected, found(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call assertEqual(expected, found, 0.0_real64, message, location)
   end subroutine equal_real_01

   subroutine equal_real_02(expected, found, message, location)
      real(real64), intent(in) :: expected, found(:, :)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call assertEqual(expected, found, 0.0_real64, message, location)
   end subroutine equal_real_02

   subroutine equal_real_11(expected, found, message, location)
      real(real64), intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call assertEqual(expected, found, 0.0_real64, message, location)
   end subroutine equal_real_11

   subroutine equal_real_22(expected, found, message, location)
      real(real64), intent(in) :: expected(:, :), found(:, :)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call assertEqual(expected, found, 0.0_real64, message, location)
   end subroutine equal_real_22

   subroutine near_real_00(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected, found
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_near([expected], [found], tolerance, shape(found), message, location)
   end subroutine near_real_00

   subroutine near_real_01(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected, found(:)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_near(spread(expected, 1, size(found)), found, tolerance, shape(found), message, location)
   end subroutine near_real_01

   subroutine near_real_02(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected, found(:, :)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_near(spread(expected, 1, size(found)), reshape(found, [size(found)]), &
                      tolerance, shape(found), message, location)
   end subroutine near_real_02

   subroutine near_real_11(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected(:), found(:)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_near(expected, found, tolerance, shape(found), message, location)
   end subroutine near_real_11

   subroutine near_real_22(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected(:, :), found(:, :)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_near(reshape(expected, [size(expected)]), reshape(found, [size(found)]), &
                      tolerance, shape(found), message, location)
   end subroutine near_real_22

   !> The comparison behind assertEqual for reals, on flattened arrays.
   subroutine check_near(expected, found, tolerance, shapes, message, location)
      real(real64), intent(in) :: expected(:), found(:), tolerance
      !> Shape of the found array (empty for a scalar)
      integer, intent(in) :: shapes(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location
      integer :: i

      do i = 1, size(found)
         if (is_near(expected(i), found(i), tolerance)) cycle
         call fail('expected '//real_text(expected(i))//', found '//real_text(found(i))// &
                   difference_text(expected(i), found(i))//', tolerance '//real_text(tolerance)// &
                   index_text(i, shapes), message, location)
         return
      end do
   end subroutine check_near

   !> Within the tolerance; equal infinities are, a NaN never is.
   logical function is_near(expected, found, tolerance)
      real(real64), intent(in) :: expected, found, tolerance

      is_near = .false.
      if (is_nan(expected) .or. is_nan(found) .or. is_nan(tolerance)) return
      if (expected <= found .and. found <= expected) then
         is_near = .true.
      else if (is_finite(expected) .and. is_finite(found)) then
         is_near = abs(found - expected) <= tolerance
      end if
   end function is_near

   !> Do the shapes agree? Notes a failure when they don't.
   logical function same_shape(expected, found, message, location)
      integer, intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      same_shape = all(expected == found)
      if (.not. same_shape) call fail('arrays differ in shape: expected '//list_text(expected)//', found '// &
                                      list_text(found), message, location)
   end function same_shape

   subroutine equal_integer_00(expected, found, message, location)
      integer(int32), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integers(int([expected], int64), int([found], int64), shape(found), message, location)
   end subroutine equal_integer_00

   subroutine equal_integer_11(expected, found, message, location)
      integer(int32), intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_integers(int(expected, int64), int(found, int64), shape(found), message, location)
   end subroutine equal_integer_11

   subroutine equal_integer_22(expected, found, message, location)
      integer(int32), intent(in) :: expected(:, :), found(:, :)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_integers(int(reshape(expected, [size(expected)]), int64), &
                          int(reshape(found, [size(found)]), int64), shape(found), message, location)
   end subroutine equal_integer_22

   subroutine equal_long_00(expected, found, message, location)
      integer(int64), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integers([expected], [found], shape(found), message, location)
   end subroutine equal_long_00

   subroutine equal_long_11(expected, found, message, location)
      integer(int64), intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_integers(expected, found, shape(found), message, location)
   end subroutine equal_long_11

   subroutine equal_long_22(expected, found, message, location)
      integer(int64), intent(in) :: expected(:, :), found(:, :)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_integers(reshape(expected, [size(expected)]), &
                          reshape(found, [size(found)]), shape(found), message, location)
   end subroutine equal_long_22

   subroutine equal_mixed_00(expected, found, message, location)
      integer(int32), intent(in) :: expected
      integer(int64), intent(in) :: found
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call equal_long_00(int(expected, int64), found, message, location)
   end subroutine equal_mixed_00

   subroutine check_integers(expected, found, shapes, message, location)
      integer(int64), intent(in) :: expected(:), found(:)
      integer, intent(in) :: shapes(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location
      integer :: i

      do i = 1, size(found)
         if (expected(i) == found(i)) cycle
         call fail('expected '//long_text(expected(i))//', found '//long_text(found(i))//index_text(i, shapes), &
                   message, location)
         return
      end do
   end subroutine check_integers

   ! ----------------------------------------------------------------------------------------- equal: logicals, text

   subroutine equal_logical_00(expected, found, message, location)
      logical, intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call equal_logical_11([expected], [found], message, location)
   end subroutine equal_logical_00

   subroutine equal_logical_11(expected, found, message, location)
      logical, intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      if (all(expected .eqv. found)) return
      call fail('logical values: '//count_text(expected .neqv. found)//' not as expected', message, location)
   end subroutine equal_logical_11

   !> Leading and trailing blanks don't count (pFUnit's default).
   subroutine equal_text_00(expected, found, message, location)
      character(len=*), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (trim(adjustl(expected)) /= trim(adjustl(found))) &
         call fail('expected "'//trim(expected)//'", found "'//trim(found)//'"', message, location)
   end subroutine equal_text_00

   ! ---------------------------------------------------------------------------------------------- relatively equal

   subroutine relative_00(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected, found
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_relative([expected], [found], tolerance, shape(found), message, location)
   end subroutine relative_00

   subroutine relative_01(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected, found(:)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_relative(spread(expected, 1, size(found)), found, tolerance, shape(found), message, location)
   end subroutine relative_01

   subroutine relative_11(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected(:), found(:)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_relative(expected, found, tolerance, shape(found), message, location)
   end subroutine relative_11

   subroutine relative_22(expected, found, tolerance, message, location)
      real(real64), intent(in) :: expected(:, :), found(:, :)
      real(real64), intent(in) :: tolerance
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(expected), shape(found), message, location)) return
      call check_relative(reshape(expected, [size(expected)]), reshape(found, [size(found)]), &
                          tolerance, shape(found), message, location)
   end subroutine relative_22

   subroutine check_relative(expected, found, tolerance, shapes, message, location)
      real(real64), intent(in) :: expected(:), found(:), tolerance
      integer, intent(in) :: shapes(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location
      integer :: i

      do i = 1, size(found)
         if (is_near(expected(i), 0.0_real64, 0.0_real64)) then
            call fail('expected value is zero: no relative difference'//index_text(i, shapes), message, location)
            return
         end if
         if (is_nan(expected(i))) then
            call fail('expected value is NaN'//index_text(i, shapes), message, location)
            return
         end if
         if (is_near(expected(i), found(i), tolerance*abs(expected(i)))) cycle
         call fail('expected '//real_text(expected(i))//', found '//real_text(found(i))// &
                   difference_text(expected(i), found(i))//', relative tolerance '//real_text(tolerance)// &
                   index_text(i, shapes), message, location)
         return
      end do
   end subroutine check_relative

   ! ---------------------------------------------------------------------------------------------------- inequalities

   subroutine less_real_00(left, right, message, location)
      real(real64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_order(less, [left], [right], shape(right), message, location)
   end subroutine less_real_00

   subroutine less_real_11(left, right, message, location)
      real(real64), intent(in) :: left(:), right(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(left), shape(right), message, location)) return
      call check_order(less, left, right, shape(right), message, location)
   end subroutine less_real_11

   subroutine less_integer_00(left, right, message, location)
      integer(int32), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(less, int(left, int64), int(right, int64), message, location)
   end subroutine less_integer_00

   subroutine less_long_00(left, right, message, location)
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(less, left, right, message, location)
   end subroutine less_long_00

   subroutine less_or_equal_real_00(left, right, message, location)
      real(real64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_order(less_or_equal, [left], [right], shape(right), message, location)
   end subroutine less_or_equal_real_00

   subroutine less_or_equal_real_11(left, right, message, location)
      real(real64), intent(in) :: left(:), right(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(left), shape(right), message, location)) return
      call check_order(less_or_equal, left, right, shape(right), message, location)
   end subroutine less_or_equal_real_11

   subroutine less_or_equal_integer_00(left, right, message, location)
      integer(int32), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(less_or_equal, int(left, int64), int(right, int64), message, location)
   end subroutine less_or_equal_integer_00

   subroutine less_or_equal_long_00(left, right, message, location)
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(less_or_equal, left, right, message, location)
   end subroutine less_or_equal_long_00

   subroutine greater_real_00(left, right, message, location)
      real(real64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_order(greater, [left], [right], shape(right), message, location)
   end subroutine greater_real_00

   subroutine greater_real_11(left, right, message, location)
      real(real64), intent(in) :: left(:), right(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(left), shape(right), message, location)) return
      call check_order(greater, left, right, shape(right), message, location)
   end subroutine greater_real_11

   subroutine greater_integer_00(left, right, message, location)
      integer(int32), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(greater, int(left, int64), int(right, int64), message, location)
   end subroutine greater_integer_00

   subroutine greater_long_00(left, right, message, location)
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(greater, left, right, message, location)
   end subroutine greater_long_00

   subroutine greater_or_equal_real_00(left, right, message, location)
      real(real64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_order(greater_or_equal, [left], [right], shape(right), message, location)
   end subroutine greater_or_equal_real_00

   subroutine greater_or_equal_real_11(left, right, message, location)
      real(real64), intent(in) :: left(:), right(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      if (.not. same_shape(shape(left), shape(right), message, location)) return
      call check_order(greater_or_equal, left, right, shape(right), message, location)
   end subroutine greater_or_equal_real_11

   subroutine greater_or_equal_integer_00(left, right, message, location)
      integer(int32), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(greater_or_equal, int(left, int64), int(right, int64), message, location)
   end subroutine greater_or_equal_integer_00

   subroutine greater_or_equal_long_00(left, right, message, location)
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location

      call check_integer_order(greater_or_equal, left, right, message, location)
   end subroutine greater_or_equal_long_00

   subroutine check_order(relation, left, right, shapes, message, location)
      integer, intent(in) :: relation
      real(real64), intent(in) :: left(:), right(:)
      integer, intent(in) :: shapes(:)
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location
      logical :: holds
      integer :: i

      do i = 1, size(right)
         holds = .false.
         if (.not. (is_nan(left(i)) .or. is_nan(right(i)))) then
            select case (relation)
            case (less)
               holds = left(i) < right(i)
            case (less_or_equal)
               holds = left(i) <= right(i)
            case (greater)
               holds = left(i) > right(i)
            case (greater_or_equal)
               holds = left(i) >= right(i)
            end select
         end if
         if (holds) cycle
         call fail(order_text(relation, real_text(left(i)), real_text(right(i)))//index_text(i, shapes), &
                   message, location)
         return
      end do
   end subroutine check_order

   subroutine check_integer_order(relation, left, right, message, location)
      integer, intent(in) :: relation
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(SourceLocation), intent(in), optional :: location
      logical :: holds

      select case (relation)
      case (less)
         holds = left < right
      case (less_or_equal)
         holds = left <= right
      case (greater)
         holds = left > right
      case default
         holds = left >= right
      end select
      if (.not. holds) call fail(order_text(relation, long_text(left), long_text(right)), message, location)
   end subroutine check_integer_order

   ! ---------------------------------------------------------------------------------------------------------- helpers

   !> Read from the bits, since comparing a signalling NaN would trap in the debug build.
   pure logical function is_nan(x)
      real(real64), intent(in) :: x
      integer(int64), parameter :: exponent_bits = int(z'7FF0000000000000', int64)

      is_nan = iand(transfer(x, 0_int64), huge(0_int64)) > exponent_bits
   end function is_nan

   pure logical function is_finite(x)
      real(real64), intent(in) :: x
      integer(int64), parameter :: exponent_bits = int(z'7FF0000000000000', int64)

      is_finite = iand(transfer(x, 0_int64), exponent_bits) /= exponent_bits
   end function is_finite

   function real_text(x) result(text)
      real(real64), intent(in) :: x
      character(len=:), allocatable :: text
      character(len=32) :: buffer

      if (is_nan(x)) then
         text = 'NaN'
      else
         write (buffer, '(g0)') x
         text = trim(buffer)
      end if
   end function real_text

   function difference_text(expected, found) result(text)
      real(real64), intent(in) :: expected, found
      character(len=:), allocatable :: text
      character(len=32) :: buffer

      text = ''
      if (.not. (is_finite(expected) .and. is_finite(found))) return
      write (buffer, '(es12.4)') found - expected
      text = ', difference '//trim(adjustl(buffer))
   end function difference_text

   function long_text(i) result(text)
      integer(int64), intent(in) :: i
      character(len=:), allocatable :: text
      character(len=24) :: buffer

      write (buffer, '(i0)') i
      text = trim(buffer)
   end function long_text

   function list_text(list) result(text)
      integer, intent(in) :: list(:)
      character(len=:), allocatable :: text
      integer :: i

      text = '['
      do i = 1, size(list)
         if (i > 1) text = text//', '
         text = text//long_text(int(list(i), int64))
      end do
      text = text//']'
   end function list_text

   function count_text(condition) result(text)
      logical, intent(in) :: condition(:)
      character(len=:), allocatable :: text

      text = long_text(count(condition, kind=int64))//' of '//long_text(size(condition, kind=int64))
   end function count_text

   function order_text(relation, left, right) result(text)
      integer, intent(in) :: relation
      character(len=*), intent(in) :: left, right
      character(len=:), allocatable :: text

      text = 'expected '//left//' to be '//trim(relation_name(relation))//' '//right
   end function order_text

   !> Where in an array of the given shape the i-th element stands; nothing for a scalar.
   function index_text(i, shapes) result(text)
      integer, intent(in) :: i, shapes(:)
      character(len=:), allocatable :: text

      select case (size(shapes))
      case (0)
         text = ''
      case (1)
         text = ', at '//list_text([i])
      case default
         text = ', at '//list_text([1 + mod(i - 1, shapes(1)), 1 + (i - 1)/shapes(1)])
      end select
   end function index_text

end module funit
