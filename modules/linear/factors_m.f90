!> What a library that factors sparse matrices does for the program.
!>
!> A matrix is analysed once per pattern, factored whenever its values change, and then solved with as often as needed.
module factors_m
   use kinds_m, only: wp
   implicit none
   private

   public :: out_of_memory

   !> Outcome of a call
   integer, parameter, public :: linear_ok = 0, linear_singular = 1, linear_failed = 2

   !> A factored matrix
   type, abstract, public :: factors_t
      !> Memory that factors may take [MB]; 0: what the machine has
      integer :: max_memory = 0
   contains
      procedure(analyse_i), deferred :: analyse
      procedure(factor_i), deferred :: factor
      procedure(solve_i), deferred :: solve
      procedure(matrix_i), deferred :: matrix
      procedure(memory_i), deferred :: memory
      procedure(text_i), deferred :: ordering
      procedure(text_i), deferred :: message
      procedure(free_i), deferred :: free
   end type factors_t

   abstract interface
      !> Order the unknowns of a pattern and plan the factorisation.
      subroutine analyse_i(self, n, row, column, status, place)
         import :: factors_t
         class(factors_t), intent(inout) :: self
         !> Number of unknowns
         integer, intent(in) :: n
         !> Places of the entries, from 1, in any order; entries at one place add (entries)
         integer, intent(in) :: row(:), column(:)
         !> One of the outcomes
         integer, intent(out) :: status
         !> Place of every unknown in the order of elimination (unknowns); the library's own order when not given
         integer, intent(in), optional :: place(:)
      end subroutine analyse_i

      !> Factor the matrix of given values.
      subroutine factor_i(self, value, status)
         import :: factors_t, wp
         class(factors_t), intent(inout) :: self
         !> Entries in the order of the pattern analysed
         real(wp), intent(in) :: value(:)
         integer, intent(out) :: status
      end subroutine factor_i

      !> Replace a right-hand side by the solution.
      subroutine solve_i(self, x, status)
         import :: factors_t, wp
         class(factors_t), intent(inout) :: self
         !> Right-hand side in, solution out (unknowns)
         real(wp), intent(inout) :: x(:)
         integer, intent(out) :: status
      end subroutine solve_i

      !> The matrix that was factored last (entries); of size zero when there is none.
      pure function matrix_i(self) result(matrix)
         import :: factors_t, wp
         class(factors_t), intent(in) :: self
         real(wp), allocatable :: matrix(:)
      end function matrix_i

      !> Memory that the last factorisation took at the most [MB].
      pure integer function memory_i(self)
         import :: factors_t
         class(factors_t), intent(in) :: self
      end function memory_i

      !> How the unknowns are ordered, for the log; why the last call failed, for messages.
      pure function text_i(self) result(text)
         import :: factors_t
         class(factors_t), intent(in) :: self
         character(len=:), allocatable :: text
      end function text_i

      !> Give back all memory.
      subroutine free_i(self)
         import :: factors_t
         class(factors_t), intent(inout) :: self
      end subroutine free_i
   end interface

contains

   !> What is said where factors take more memory than there is.
   pure function out_of_memory(unknowns, megabytes) result(text)
      integer, intent(in) :: unknowns, megabytes
      character(len=:), allocatable :: text
      character(len=160) :: line

      write (line, '(a,i0,a,i0,a)') 'the linear solver has not enough memory for ', unknowns, ' unknowns, which may take ', &
         megabytes, ' MB'
      text = trim(line)
   end function out_of_memory

end module factors_m
