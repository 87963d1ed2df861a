!> Sparse systems of linear equations by MUMPS (the sequential library in double precision).
!>
!> A matrix is analysed once per pattern, factored whenever its values change, and then solved with as often as needed.
!> This file is compiled with relaxed flags: MUMPS brings its own structure, a file to be included.
module mumps_m
   use kinds_m, only: wp
   use factors_m, only: factors_t, linear_ok, linear_singular, linear_failed, out_of_memory
   implicit none
   private

   include 'mpif.h'
   include 'dmumps_struc.h'

   !> A matrix factored by MUMPS
   type, public, extends(factors_t) :: mumps_factors_t
      private
      type(dmumps_struc) :: id
      logical :: started = .false.
   contains
      procedure :: analyse
      procedure :: factor
      procedure :: solve
      procedure :: matrix
      procedure :: memory
      procedure :: ordering => ordering_used
      procedure :: message
      procedure :: free => free_factors
   end type mumps_factors_t

   !> Jobs and control numbers of MUMPS (its user's guide, chapters 5 and 6)
   integer, parameter :: job_start = -1, job_end = -2, job_analyse = 1, job_factor = 2, job_solve = 3
   integer, parameter :: error_stream = 1, warning_stream = 2, global_stream = 3, print_level = 4, permutation = 6, &
                         ordering = 7, scaling = 8, refinement = 10, extra_memory = 14, &
                         memory_limit = 23, null_pivot_detection = 24
   integer, parameter :: ordering_given = 1, ordering_amf = 2, memory_margin_percent = 60
   !> Threshold of partial pivoting: the systems are close to symmetric positive definite ones
   integer, parameter :: pivot_threshold = 1
   real(wp), parameter :: least_pivot_ratio = 1.0e-4_wp
   !> MUMPS' numbers of errors: singular matrix; not enough room for the factors, of which more may be asked for; no memory
   integer, parameter :: error_singular_structure = -6, error_singular = -10, error_room = -9, error_integer_room = -8
   integer, parameter :: errors_memory(*) = [-5, -7, error_integer_room, error_room, -11, -13, -14, -15, -17, -19, -20]
   !> Place of the memory that a factorisation is thought to take, among MUMPS' results
   integer, parameter :: memory_planned = 16
   !> Place of the memory that the last factorisation took at the most [MB], likewise
   integer, parameter :: memory_used = 22
   !> Pivots of the last factorisation that were nothing but rounding, likewise
   integer, parameter :: null_pivots = 28
   integer, parameter :: largest_margin_percent = 1000

   interface
      subroutine dmumps(id)
         import :: dmumps_struc
         type(dmumps_struc) :: id
      end subroutine dmumps
   end interface

contains

   !> Order the unknowns of a pattern and plan the factorisation.
   subroutine analyse(self, n, row, column, status, place)
      class(mumps_factors_t), intent(inout) :: self
      !> Number of unknowns
      integer, intent(in) :: n
      !> Places of the entries, from 1 (entries)
      integer, intent(in) :: row(:), column(:)
      !> One of the outcomes
      integer, intent(out) :: status
      !> Place of every unknown in the order of elimination (unknowns); the least degree goes first when not given
      integer, intent(in), optional :: place(:)

      call self%free()
      self%id%comm = MPI_COMM_WORLD
      self%id%par = 1
      self%id%sym = 0
      self%id%job = job_start
      call dmumps(self%id)
      self%started = .true.
      associate (control => self%id%icntl)
         control([error_stream, warning_stream, global_stream, print_level]) = 0
         control(permutation) = 0
         control(ordering) = ordering_amf
         control(scaling) = 0
         control(refinement) = 0
         control(extra_memory) = memory_margin_percent
         control(null_pivot_detection) = 1
         control(memory_limit) = self%max_memory
      end associate
      self%id%cntl(pivot_threshold) = least_pivot_ratio
      self%id%n = n
      self%id%nnz = size(row, kind=8)
      allocate (self%id%irn(size(row)), self%id%jcn(size(row)), self%id%a(size(row)), self%id%rhs(n))
      if (present(place)) then
         self%id%icntl(ordering) = ordering_given
         allocate (self%id%perm_in(n))
         self%id%perm_in = place
      end if
      self%id%irn = row
      self%id%jcn = column
      self%id%job = job_analyse
      call dmumps(self%id)
      status = outcome(self)
   end subroutine analyse

   !> Factor the matrix of given values.
   subroutine factor(self, value, status)
      class(mumps_factors_t), intent(inout) :: self
      !> Entries in the order of the pattern analysed
      real(wp), intent(in) :: value(:)
      integer, intent(out) :: status

      status = linear_failed
      if (.not. self%started) return
      self%id%a = value
      self%id%job = job_factor
      do
         call dmumps(self%id)
         if (self%id%infog(1) /= error_room .and. self%id%infog(1) /= error_integer_room) exit
         if (self%id%icntl(extra_memory) >= largest_margin_percent) exit
         self%id%icntl(extra_memory) = 2*self%id%icntl(extra_memory)
      end do
      status = outcome(self)
      if (status == linear_ok .and. self%id%infog(null_pivots) > 0) status = linear_singular
   end subroutine factor

   !> Replace a right-hand side by the solution.
   subroutine solve(self, x, status)
      class(mumps_factors_t), intent(inout) :: self
      !> Right-hand side in, solution out (unknowns)
      real(wp), intent(inout) :: x(:)
      integer, intent(out) :: status

      status = linear_failed
      if (.not. self%started) return
      self%id%rhs = x
      self%id%job = job_solve
      call dmumps(self%id)
      status = outcome(self)
      if (status == linear_ok) x = self%id%rhs
   end subroutine solve

   !> The matrix that was factored last (entries); of size zero when there is none.
   pure function matrix(self)
      class(mumps_factors_t), intent(in) :: self
      real(wp), allocatable :: matrix(:)

      allocate (matrix(0))
      if (self%started) matrix = self%id%a
   end function matrix

   !> Memory that the last factorisation took at the most [MB].
   pure integer function memory(self)
      class(mumps_factors_t), intent(in) :: self

      memory = self%id%infog(memory_used)
   end function memory

   !> How the unknowns are ordered, for the log.
   pure function ordering_used(self) result(name)
      class(mumps_factors_t), intent(in) :: self
      character(len=:), allocatable :: name

      name = 'AMF (minimum fill)'
      if (.not. self%started) return
      if (self%id%icntl(ordering) == ordering_given) name = 'METIS (nested dissection)'
   end function ordering_used

   !> Why the last job failed, for messages.
   pure function message(self)
      class(mumps_factors_t), intent(in) :: self
      character(len=:), allocatable :: message
      character(len=160) :: text

      if (any(self%id%infog(1) == errors_memory)) then
         message = out_of_memory(self%id%n, self%id%infog(memory_planned))
      else
         write (text, '(a,i0,a,i0,a,i0,a)') 'the linear solver failed with ', self%id%n, ' unknowns (MUMPS, INFOG(1) = ', &
            self%id%infog(1), ', INFOG(2) = ', self%id%infog(2), ')'
         message = trim(text)
      end if
   end function message

   !> Give back all memory.
   subroutine free_factors(self)
      class(mumps_factors_t), intent(inout) :: self

      if (.not. self%started) return
      deallocate (self%id%irn, self%id%jcn, self%id%a, self%id%rhs)
      if (associated(self%id%perm_in)) deallocate (self%id%perm_in)
      self%id%job = job_end
      call dmumps(self%id)
      self%started = .false.
   end subroutine free_factors

   !> Outcome of the last job.
   pure integer function outcome(self)
      type(mumps_factors_t), intent(in) :: self

      select case (self%id%infog(1))
      case (0:)
         outcome = linear_ok
      case (error_singular, error_singular_structure)
         outcome = linear_singular
      case default
         outcome = linear_failed
      end select
   end function outcome

end module mumps_m
