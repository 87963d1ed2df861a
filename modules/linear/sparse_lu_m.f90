!> Sparse systems of linear equations: UMFPACK for small ones, MUMPS for large ones.
!>
!> The time of MUMPS is that of its fronts, of which a small matrix has many with next to nothing in them; UMFPACK solves with a
!> small matrix in a quarter of the time. With a large one both read their factors once, and MUMPS makes them sooner.
module sparse_lu_m
   use kinds_m, only: wp
   use factors_m, only: factors_t, linear_ok, linear_singular, linear_failed
   use mumps_m, only: mumps_factors_t
   use umfpack_m, only: umfpack_factors_t
   implicit none
   private

   public :: linear_ok, linear_singular, linear_failed

   !> Unknowns below which UMFPACK takes less time than MUMPS (manual/theory_implicit.md)
   integer, parameter, public :: small = 8000

   !> A factored matrix: see factors_t
   type, public :: sparse_lu_t
      private
      class(factors_t), allocatable :: factors
      !> Memory that factors may take [MB]; 0: what the machine has
      integer, public :: max_memory = 0
   contains
      procedure :: analyse
      procedure :: factor
      procedure :: solve
      procedure :: matrix
      procedure :: memory
      procedure :: ordering
      procedure :: message
      procedure :: free => free_factors
   end type sparse_lu_t

contains

   !> Order the unknowns of a pattern and plan the factorisation.
   subroutine analyse(self, n, row, column, status, place)
      class(sparse_lu_t), intent(inout) :: self
      integer, intent(in) :: n, row(:), column(:)
      integer, intent(out) :: status
      !> For MUMPS, see factors_t
      integer, intent(in), optional :: place(:)

      call self%free()
      if (n < small) then
         allocate (umfpack_factors_t :: self%factors)
      else
         allocate (mumps_factors_t :: self%factors)
      end if
      self%factors%max_memory = self%max_memory
      ! gfortran describes an argument that is absent before it passes it on, with numbers that are none
      if (present(place)) then
         call self%factors%analyse(n, row, column, status, place)
      else
         call self%factors%analyse(n, row, column, status)
      end if
   end subroutine analyse

   !> Factor the matrix of given values.
   subroutine factor(self, value, status)
      class(sparse_lu_t), intent(inout) :: self
      real(wp), intent(in) :: value(:)
      integer, intent(out) :: status

      status = linear_failed
      if (allocated(self%factors)) call self%factors%factor(value, status)
   end subroutine factor

   !> Replace a right-hand side by the solution.
   subroutine solve(self, x, status)
      class(sparse_lu_t), intent(inout) :: self
      real(wp), intent(inout) :: x(:)
      integer, intent(out) :: status

      status = linear_failed
      if (allocated(self%factors)) call self%factors%solve(x, status)
   end subroutine solve

   !> The matrix that was factored last (entries); of size zero when there is none.
   pure function matrix(self)
      class(sparse_lu_t), intent(in) :: self
      real(wp), allocatable :: matrix(:)

      if (allocated(self%factors)) then
         matrix = self%factors%matrix()
      else
         allocate (matrix(0))
      end if
   end function matrix

   !> Memory that the last factorisation took at the most [MB].
   pure integer function memory(self)
      class(sparse_lu_t), intent(in) :: self

      memory = 0
      if (allocated(self%factors)) memory = self%factors%memory()
   end function memory

   !> How the unknowns are ordered, for the log.
   pure function ordering(self) result(name)
      class(sparse_lu_t), intent(in) :: self
      character(len=:), allocatable :: name

      name = ''
      if (allocated(self%factors)) name = self%factors%ordering()
   end function ordering

   !> Why the last call failed, for messages.
   pure function message(self)
      class(sparse_lu_t), intent(in) :: self
      character(len=:), allocatable :: message

      message = 'the linear solver has no matrix'
      if (allocated(self%factors)) message = self%factors%message()
   end function message

   !> Give back all memory.
   subroutine free_factors(self)
      class(sparse_lu_t), intent(inout) :: self

      if (.not. allocated(self%factors)) return
      call self%factors%free()
      deallocate (self%factors)
   end subroutine free_factors

end module sparse_lu_m
