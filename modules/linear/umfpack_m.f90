!> Sparse systems of linear equations by UMFPACK (SuiteSparse 5, 32-bit indices, double precision).
module umfpack_m
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_null_ptr, c_ptr
   use kinds_m, only: wp
   use factors_m, only: factors_t, linear_ok, linear_singular, linear_failed, out_of_memory
   implicit none
   private

   !> Sizes of UMFPACK's lists of settings and of results
   integer, parameter :: settings = 20, results = 90
   !> Places in them, from 1 (umfpack.h counts from 0)
   integer, parameter :: pivot_tolerance = 4, strategy = 6, refinement = 8, ordering_method = 11, &
                         diagonal_tolerance = 16, scaling = 17
   integer, parameter :: size_of_unit = 4, peak_memory = 42, least_pivot = 72
   real(c_double), parameter :: strategy_symmetric = 3, ordering_amd = 1, scaling_none = 0
   !> Outcomes of UMFPACK
   integer(c_int), parameter :: umfpack_ok = 0, warning_singular = 1, error_memory = -1
   !> Solve A x = b
   integer(c_int), parameter :: system_plain = 0
   !> Threshold of partial pivoting, as in mumps_m
   real(c_double), parameter :: least_pivot_ratio = 1.0e-4_c_double
   !> Pivots below this share of the largest entry are nothing but rounding, as for MUMPS
   real(wp), parameter :: null_pivot_share = epsilon(1.0_wp)
   real(wp), parameter :: megabyte = 1.0e6_wp

   !> A matrix factored by UMFPACK
   type, public, extends(factors_t) :: umfpack_factors_t
      private
      integer :: n = 0
      !> Was the order of elimination given?
      logical :: given = .false.
      !> Columns of the matrix, with indices from 0, and the entries of each
      integer(c_int), allocatable :: first(:), row(:)
      real(c_double), allocatable :: entry(:)
      !> Place in entry of each entry of the pattern analysed, from 0 (entries)
      integer(c_int), allocatable :: at(:)
      !> Values as they were given, of size zero before a factorisation (entries)
      real(wp), allocatable :: value(:)
      type(c_ptr) :: plan = c_null_ptr, lu = c_null_ptr
      real(c_double) :: control(settings) = 0.0_c_double, info(results) = 0.0_c_double
      !> Room for a solution (unknowns)
      integer(c_int), allocatable :: room_of_integers(:)
      real(c_double), allocatable :: room(:), right(:)
      !> What UMFPACK said last
      integer(c_int) :: said = umfpack_ok
   contains
      procedure :: analyse
      procedure :: factor
      procedure :: solve
      procedure :: matrix
      procedure :: memory
      procedure :: ordering
      procedure :: message
      procedure :: free => free_factors
   end type umfpack_factors_t

   interface
      !> Settings as they are without being set
      subroutine umfpack_di_defaults(control) bind(c)
         import :: c_double
         implicit none
         real(c_double), intent(out) :: control(*)
      end subroutine umfpack_di_defaults

      !> Columns, sorted, from entries in any order; where each went
      function umfpack_di_triplet_to_col(rows, columns, entries, ti, tj, tx, ap, ai, ax, map) bind(c) result(said)
         import :: c_double, c_int, c_ptr
         implicit none
         integer(c_int), value :: rows, columns, entries
         integer(c_int), intent(in) :: ti(*), tj(*)
         type(c_ptr), value :: tx, ax
         integer(c_int), intent(out) :: ap(*), ai(*), map(*)
         integer(c_int) :: said
      end function umfpack_di_triplet_to_col

      function umfpack_di_symbolic(rows, columns, ap, ai, ax, plan, control, info) bind(c) result(said)
         import :: c_double, c_int, c_ptr
         implicit none
         integer(c_int), value :: rows, columns
         integer(c_int), intent(in) :: ap(*), ai(*)
         type(c_ptr), value :: ax
         type(c_ptr), intent(out) :: plan
         real(c_double), intent(in) :: control(*)
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: said
      end function umfpack_di_symbolic

      !> As umfpack_di_symbolic, with the order of elimination given (unknown at each place)
      function umfpack_di_qsymbolic(rows, columns, ap, ai, ax, unknown_at, plan, control, info) bind(c) result(said)
         import :: c_double, c_int, c_ptr
         implicit none
         integer(c_int), value :: rows, columns
         integer(c_int), intent(in) :: ap(*), ai(*), unknown_at(*)
         type(c_ptr), value :: ax
         type(c_ptr), intent(out) :: plan
         real(c_double), intent(in) :: control(*)
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: said
      end function umfpack_di_qsymbolic

      function umfpack_di_numeric(ap, ai, ax, plan, lu, control, info) bind(c) result(said)
         import :: c_double, c_int, c_ptr
         implicit none
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*), control(*)
         type(c_ptr), value :: plan
         type(c_ptr), intent(out) :: lu
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: said
      end function umfpack_di_numeric

      function umfpack_di_wsolve(system, ap, ai, ax, x, b, lu, control, info, wi, w) bind(c) result(said)
         import :: c_double, c_int, c_ptr
         implicit none
         integer(c_int), value :: system
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*), b(*), control(*)
         real(c_double), intent(out) :: x(*)
         type(c_ptr), value :: lu
         type(c_ptr), value :: info
         integer(c_int), intent(inout) :: wi(*)
         real(c_double), intent(inout) :: w(*)
         integer(c_int) :: said
      end function umfpack_di_wsolve

      subroutine umfpack_di_free_symbolic(plan) bind(c)
         import :: c_ptr
         implicit none
         type(c_ptr), intent(inout) :: plan
      end subroutine umfpack_di_free_symbolic

      subroutine umfpack_di_free_numeric(lu) bind(c)
         import :: c_ptr
         implicit none
         type(c_ptr), intent(inout) :: lu
      end subroutine umfpack_di_free_numeric
   end interface

contains

   !> Order the unknowns of a pattern and plan the factorisation.
   subroutine analyse(self, n, row, column, status, place)
      class(umfpack_factors_t), intent(inout) :: self
      integer, intent(in) :: n, row(:), column(:)
      integer, intent(out) :: status
      !> See factors_t; without it least degree (AMD)
      integer, intent(in), optional :: place(:)
      integer(c_int), allocatable :: unknown_at(:)
      integer(c_int) :: order, i

      call self%free()
      self%n = n
      self%given = present(place)
      order = int(n, c_int)
      allocate (self%first(n + 1), self%row(size(row)), self%at(size(row)))
      allocate (self%value(0), self%room_of_integers(n), self%room(n), self%right(n))
      call umfpack_di_defaults(self%control)
      self%control(strategy) = strategy_symmetric
      self%control(ordering_method) = ordering_amd
      self%control(scaling) = scaling_none
      self%control(refinement) = 0.0_c_double
      self%control([pivot_tolerance, diagonal_tolerance]) = least_pivot_ratio
      self%said = umfpack_di_triplet_to_col(order, order, size(row, kind=c_int), int(row - 1, c_int), &
                                            int(column - 1, c_int), c_null_ptr, self%first, self%row, c_null_ptr, self%at)
      status = linear_failed
      if (self%said /= umfpack_ok) return
      allocate (self%entry(self%first(n + 1)), source=0.0_c_double)
      if (present(place)) then
         allocate (unknown_at(n))
         unknown_at(place) = [(i - 1_c_int, i=1, order)]
         self%said = umfpack_di_qsymbolic(order, order, self%first, self%row, c_null_ptr, unknown_at, self%plan, &
                                          self%control, self%info)
      else
         self%said = umfpack_di_symbolic(order, order, self%first, self%row, c_null_ptr, self%plan, self%control, self%info)
      end if
      if (self%said == umfpack_ok) status = linear_ok
   end subroutine analyse

   !> Factor the matrix of given values.
   subroutine factor(self, value, status)
      class(umfpack_factors_t), intent(inout) :: self
      real(wp), intent(in) :: value(:)
      integer, intent(out) :: status
      integer :: i

      status = linear_failed
      if (.not. c_associated(self%plan)) return
      self%value = value
      self%entry = 0.0_c_double
      do i = 1, size(value)
         self%entry(self%at(i) + 1) = self%entry(self%at(i) + 1) + value(i)
      end do
      if (c_associated(self%lu)) call umfpack_di_free_numeric(self%lu)
      self%said = umfpack_di_numeric(self%first, self%row, self%entry, self%plan, self%lu, self%control, self%info)
      if (self%said == umfpack_ok .and. self%max_memory > 0 .and. self%memory() > self%max_memory) self%said = error_memory
      if (self%said == warning_singular) then
         status = linear_singular
      else if (self%said == umfpack_ok) then
         status = merge(linear_singular, linear_ok, self%info(least_pivot) <= null_pivot_share*maxval(abs(self%entry)))
      end if
   end subroutine factor

   !> Replace a right-hand side by the solution.
   subroutine solve(self, x, status)
      class(umfpack_factors_t), intent(inout) :: self
      real(wp), intent(inout) :: x(:)
      integer, intent(out) :: status

      status = linear_failed
      if (.not. c_associated(self%lu)) return
      self%right = x
      self%said = umfpack_di_wsolve(system_plain, self%first, self%row, self%entry, x, self%right, self%lu, self%control, &
                                    c_null_ptr, self%room_of_integers, self%room)
      if (self%said == umfpack_ok) status = linear_ok
      if (self%said == warning_singular) status = linear_singular
      if (status /= linear_ok) x = self%right
   end subroutine solve

   !> The matrix that was factored last (entries); of size zero when there is none.
   pure function matrix(self)
      class(umfpack_factors_t), intent(in) :: self
      real(wp), allocatable :: matrix(:)

      allocate (matrix(0))
      if (allocated(self%value)) matrix = self%value
   end function matrix

   !> Memory that the last factorisation took at the most [MB].
   pure integer function memory(self)
      class(umfpack_factors_t), intent(in) :: self

      memory = ceiling(self%info(peak_memory)*self%info(size_of_unit)/megabyte)
   end function memory

   !> How the unknowns are ordered, for the log.
   pure function ordering(self) result(name)
      class(umfpack_factors_t), intent(in) :: self
      character(len=:), allocatable :: name

      name = 'AMD (minimum degree)'
      if (self%given) name = 'METIS (nested dissection)'
   end function ordering

   !> Why the last call failed, for messages.
   pure function message(self)
      class(umfpack_factors_t), intent(in) :: self
      character(len=:), allocatable :: message
      character(len=160) :: text

      if (self%said == error_memory) then
         message = out_of_memory(self%n, self%memory())
      else
         write (text, '(a,i0,a,i0,a)') 'the linear solver failed with ', self%n, ' unknowns (UMFPACK, status ', self%said, ')'
         message = trim(text)
      end if
   end function message

   !> Give back all memory.
   subroutine free_factors(self)
      class(umfpack_factors_t), intent(inout) :: self

      if (c_associated(self%lu)) call umfpack_di_free_numeric(self%lu)
      if (c_associated(self%plan)) call umfpack_di_free_symbolic(self%plan)
      self%lu = c_null_ptr
      self%plan = c_null_ptr
      if (allocated(self%first)) deallocate (self%first, self%row, self%at, self%value, self%room_of_integers, self%room, &
                                             self%right)
      if (allocated(self%entry)) deallocate (self%entry)
   end subroutine free_factors

end module umfpack_m
