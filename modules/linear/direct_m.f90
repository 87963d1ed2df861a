!> Sparse systems of equations by elimination: by fronts_m, and by MUMPS where a matrix needs pivots that fronts do not have.
module direct_m
   use kinds_m, only: wp, i8
   use fronts_m, only: fronts_t
   use mumps_m, only: sparse_lu_t, linear_ok, linear_singular, linear_failed
   implicit none
   private

   public :: linear_ok, linear_singular, linear_failed

   !> A factored matrix whose pattern is the same across the diagonal
   type, public :: direct_t
      private
      integer :: unknowns = 0
      integer, allocatable :: row(:), column(:)
      !> The matrix that was factored last (entries); of size zero when there is none
      real(wp), allocatable :: value(:)
      type(fronts_t) :: fronts
      type(sparse_lu_t) :: mumps
      !> Has MUMPS planned for this pattern, and did it factor the last matrix? Matrices that it has factored
      logical :: mumps_knows = .false., by_mumps = .false.
      integer(i8), public :: refused = 0_i8
      !> Memory that factors may take [MB]; 0: what the machine has
      integer, public :: max_memory = 0
   contains
      procedure :: analyse
      procedure :: factor
      procedure :: solve
      procedure :: matrix
      procedure :: memory
      procedure :: message
      procedure :: free
   end type direct_t

contains

   !> Plan the factors of a pattern.
   subroutine analyse(self, row, column, vertex, status)
      class(direct_t), intent(inout) :: self
      !> Places of the entries, from 1 (entries)
      integer, intent(in) :: row(:), column(:)
      !> Vertex of each unknown: a node, whose unknowns have the same pattern and are all joined (unknowns)
      integer, intent(in) :: vertex(:)
      !> An outcome of mumps_m
      integer, intent(out) :: status

      call self%free()
      self%unknowns = size(vertex)
      self%row = row
      self%column = column
      allocate (self%value(0))
      status = linear_failed
      if (self%unknowns == 0) return
      call self%fronts%analyse(row, column, vertex)
      if (self%max_memory == 0 .or. self%fronts%memory() <= self%max_memory) status = linear_ok
   end subroutine analyse

   !> Factor the matrix of given values.
   subroutine factor(self, value, status)
      class(direct_t), intent(inout) :: self
      !> Entries in the order of the pattern analysed
      real(wp), intent(in) :: value(:)
      integer, intent(out) :: status

      status = linear_failed
      if (self%unknowns == 0) return
      call self%fronts%factorise(value, status)
      self%by_mumps = status == linear_singular
      if (self%by_mumps) then
         self%refused = self%refused + 1_i8
         self%mumps%max_memory = self%max_memory
         status = linear_ok
         if (.not. self%mumps_knows) call self%mumps%analyse(self%unknowns, self%row, self%column, status)
         self%mumps_knows = status == linear_ok
         if (status == linear_ok) call self%mumps%factor(value, status)
      end if
      if (status == linear_ok) self%value = value
   end subroutine factor

   !> Replace a right-hand side by the solution.
   subroutine solve(self, x, status)
      class(direct_t), intent(inout) :: self
      !> Right-hand side in, solution out (unknowns)
      real(wp), intent(inout) :: x(:)
      integer, intent(out) :: status

      status = linear_failed
      if (self%by_mumps) then
         call self%mumps%solve(x, status)
      else if (self%fronts%factored) then
         call self%fronts%solve(x)
         status = linear_ok
      end if
   end subroutine solve

   !> The matrix that was factored last (entries); of size zero when there is none.
   pure function matrix(self)
      class(direct_t), intent(in) :: self
      real(wp), allocatable :: matrix(:)

      allocate (matrix(0))
      if (allocated(self%value)) matrix = self%value
   end function matrix

   !> Memory that the factors take [MB].
   pure integer function memory(self)
      class(direct_t), intent(in) :: self

      if (self%by_mumps) then
         memory = self%mumps%memory()
      else
         memory = self%fronts%memory()
      end if
   end function memory

   !> Why the last job failed, for messages.
   function message(self)
      class(direct_t), intent(in) :: self
      character(len=:), allocatable :: message
      character(len=160) :: text

      if (self%by_mumps) then
         message = self%mumps%message()
      else
         write (text, '(a,i0,a,i0,a)') 'the linear solver has not enough memory for ', self%unknowns, &
            ' unknowns, which may take ', self%fronts%memory(), ' MB'
         message = trim(text)
      end if
   end function message

   !> Give back all memory.
   subroutine free(self)
      class(direct_t), intent(inout) :: self

      call self%mumps%free()
      self%fronts = fronts_t()
      self%mumps_knows = .false.
      self%by_mumps = .false.
      self%unknowns = 0
      if (allocated(self%row)) deallocate (self%row, self%column, self%value)
   end subroutine free

end module direct_m
