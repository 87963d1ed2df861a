!> Sparse systems of equations whose pattern is the same across the diagonal: factors and solutions front by front (the multifrontal
!> method of Duff and Reid 1983), on any number of threads with the same bits.
!>
!> A front is a small dense matrix: its pivots, and the later unknowns that they reach (its border). Eliminating the pivots leaves
!> a matrix of the border, which is added to the front of the parent. Branches of the tree of fronts do not know of each other
!> and are eliminated at the same time; each front adds up its children in their order, whoever made them.
!> Pivots are exchanged within a front alone. A matrix that needs more than that is refused (linear_singular), for mumps_m.
module fronts_m
   use kinds_m, only: wp, i8
   use rows_m, only: fill_rows
   use elimination_m, only: elimination_t, plan_elimination
   implicit none
   private

   !> Outcome of a call of this layer
   integer, parameter, public :: linear_ok = 0, linear_singular = 1, linear_failed = 2

   !> What the pivots of a front leave for its parent
   type :: remainder_t
      !> (border, border)
      real(wp), allocatable :: value(:, :)
   end type remainder_t

   !> A factored matrix
   type, public :: fronts_t
      private
      integer :: unknowns = 0
      type(elimination_t) :: plan
      !> Place of each unknown of the border in the front of the parent (as plan%border)
      integer, allocatable :: in_parent(:)
      !> Where solutions find it: its place, or beyond all places what a branch has for the unknowns after it (as plan%border)
      integer, allocatable :: slot(:)
      !> Children of front f: child(child_first(f):child_first(f + 1) - 1)
      integer, allocatable :: child_first(:), child(:)
      !> Entries of the matrix of front f: entry(entry_first(f):entry_first(f + 1) - 1), and where they go in its factors
      integer, allocatable :: entry_first(:), entry(:), goes_to(:)
      !> Branches that are eliminated at the same time: their first and last front, and slots of their borders; fronts after them
      integer, allocatable :: branch_first(:), branch_last(:), branch_slot(:), top(:)
      !> Where the factors of a front begin in factor (fronts + 1). Lower part: pivots and border by pivots, with the upper one of
      !> the pivots; then the rest of the upper part, border by pivots
      integer(i8), allocatable :: begins(:)
      real(wp), allocatable :: factor(:)
      !> Row that each pivot changed places with, within its front (unknowns)
      integer, allocatable :: swapped(:)
      !> Is there a factored matrix?
      logical, public :: factored = .false.
   contains
      procedure :: analyse
      procedure :: factorise
      procedure :: solve
      procedure :: memory
      procedure :: branches
   end type fronts_t

   !> A pivot is at least this share of the largest entry below it: the systems are close to symmetric positive definite ones
   real(wp), parameter :: least_pivot_ratio = 1.0e-4_wp
   !> ... and this share of what it was in the matrix: less is nothing but rounding
   real(wp), parameter :: least_share_left = 1.0e-12_wp
   !> A branch has at most this part of all work, unless that is little [multiplications]
   real(wp), parameter :: largest_branch = 1.0_wp/24.0_wp, little_work = 2.0e6_wp
   !> Pivots eliminated at a time, and columns of a large front that a thread takes at a time
   integer, parameter :: panel = 32, columns_at_once = 96

   interface
      !> C = beta C + alpha op(A) op(B) (BLAS)
      subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: wp
         implicit none
         character, intent(in) :: transa, transb
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(wp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
         real(wp), intent(inout) :: c(ldc, *)
      end subroutine dgemm

      !> B = alpha op(A)^-1 B or alpha B op(A)^-1 for a triangular A (BLAS)
      subroutine dtrsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb)
         import :: wp
         implicit none
         character, intent(in) :: side, uplo, transa, diag
         integer, intent(in) :: m, n, lda, ldb
         real(wp), intent(in) :: alpha, a(lda, *)
         real(wp), intent(inout) :: b(ldb, *)
      end subroutine dtrsm
   end interface

contains

   !> Plan the factors of a pattern.
   subroutine analyse(self, row, column, vertex)
      class(fronts_t), intent(inout) :: self
      !> Places of the entries, from 1 (entries)
      integer, intent(in) :: row(:), column(:)
      !> Vertex of each unknown, see plan_elimination (unknowns)
      integer, intent(in) :: vertex(:)
      integer :: f, c, k, i

      self%factored = .false.
      self%unknowns = size(vertex)
      call plan_elimination(row, column, vertex, self%plan)
      associate (plan => self%plan)
         if (allocated(self%begins)) deallocate (self%begins, self%in_parent, self%factor, self%swapped)
         allocate (self%begins(size(plan%parent) + 1), self%in_parent(size(plan%border)), self%swapped(self%unknowns))
         self%begins(1) = 0_i8
         do f = 1, size(plan%parent)
            self%begins(f + 1) = self%begins(f) + int(pivots_of(plan, f), i8)*int(pivots_of(plan, f) + 2*border_of(plan, f), i8)
         end do
         call fill_rows(plan%parent, size(plan%parent), self%child_first, self%child)
         do c = 1, size(plan%parent)
            f = plan%parent(c)
            if (f == 0) cycle
            ! Both are sorted
            k = plan%border_first(f)
            do i = plan%border_first(c), plan%border_first(c + 1) - 1
               if (plan%border(i) < plan%first(f + 1)) then
                  self%in_parent(i) = plan%border(i) - plan%first(f) + 1
               else
                  do while (plan%border(k) < plan%border(i))
                     k = k + 1
                  end do
                  self%in_parent(i) = pivots_of(plan, f) + k - plan%border_first(f) + 1
               end if
            end do
         end do
      end associate
      call place_entries(self, row, column)
      call find_branches(self)
   end subroutine analyse

   !> Pivots of a front, and unknowns of its border.
   pure integer function pivots_of(plan, f)
      type(elimination_t), intent(in) :: plan
      integer, intent(in) :: f

      pivots_of = plan%first(f + 1) - plan%first(f)
   end function pivots_of

   pure integer function border_of(plan, f)
      type(elimination_t), intent(in) :: plan
      integer, intent(in) :: f

      border_of = plan%border_first(f + 1) - plan%border_first(f)
   end function border_of

   !> Where in the factors of which front each entry of the matrix starts from.
   pure subroutine place_entries(self, row, column)
      type(fronts_t), intent(inout) :: self
      integer, intent(in) :: row(:), column(:)
      integer :: front_at(self%unknowns), seen(self%unknowns), at(self%unknowns), front(size(row)), f, i, j, k, m, p

      associate (plan => self%plan)
         do f = 1, size(plan%parent)
            front_at(plan%first(f):plan%first(f + 1) - 1) = f
         end do
         front = front_at(min(plan%place(row), plan%place(column)))
         call fill_rows(front, size(plan%parent), self%entry_first, self%entry)
         if (allocated(self%goes_to)) deallocate (self%goes_to)
         allocate (self%goes_to(size(row)))
         seen = 0
         do f = 1, size(plan%parent)
            p = pivots_of(plan, f)
            m = p + border_of(plan, f)
            at(plan%first(f):plan%first(f + 1) - 1) = [(i, i=1, p)]
            at(plan%border(plan%border_first(f):plan%border_first(f + 1) - 1)) = [(i, i=p + 1, m)]
            do k = self%entry_first(f), self%entry_first(f + 1) - 1
               i = at(plan%place(row(self%entry(k))))
               j = at(plan%place(column(self%entry(k))))
               if (j <= p) then
                  self%goes_to(k) = (j - 1)*m + i
               else
                  self%goes_to(k) = p*m + (i - 1)*(m - p) + j - p
               end if
            end do
         end do
      end associate
   end subroutine place_entries

   !> Divide the tree into branches, the same ones for any number of threads: from the roots the largest is divided until all are
   !> small.
   subroutine find_branches(self)
      type(fronts_t), intent(inout) :: self
      real(wp), allocatable :: work(:)
      integer, allocatable :: last(:)
      logical, allocatable :: in_branch(:)
      integer :: f, k, i, slots, b
      real(wp) :: most

      associate (plan => self%plan)
         allocate (work(size(plan%parent)), source=0.0_wp)
         allocate (in_branch(size(plan%parent)))
         do f = 1, size(plan%parent)
            work(f) = work(f) + real(pivots_of(plan, f), wp)*real(pivots_of(plan, f) + border_of(plan, f), wp)**2
            if (plan%parent(f) > 0) work(plan%parent(f)) = work(plan%parent(f)) + work(f)
         end do
         most = max(little_work, largest_branch*sum(work, mask=plan%parent == 0))
         ! A branch hangs on what is not small, or on nothing
         in_branch = work <= most
         allocate (last(0))
         do f = 1, size(plan%parent)
            if (.not. in_branch(f)) cycle
            if (plan%parent(f) > 0) then
               if (in_branch(plan%parent(f))) cycle
            end if
            last = [last, f]
         end do
         self%top = pack([(f, f=1, size(plan%parent))],.not. in_branch)
         call move_alloc(last, self%branch_last)
         if (allocated(self%branch_first)) deallocate (self%branch_first, self%branch_slot)
         allocate (self%branch_first(size(self%branch_last)), self%branch_slot(size(self%branch_last) + 1))
         self%slot = plan%border
         slots = self%unknowns
         do b = 1, size(self%branch_last)
            f = self%branch_last(b)
            do while (size(children(self, f)) > 0)
               f = self%child(self%child_first(f))
            end do
            self%branch_first(b) = f
            self%branch_slot(b) = slots
            f = self%branch_last(b)
            associate (outside => plan%border(plan%border_first(f):plan%border_first(f + 1) - 1))
               do i = plan%border_first(self%branch_first(b)), plan%border_first(f + 1) - 1
                  if (plan%border(i) < plan%first(f + 1)) cycle
                  k = find(outside, plan%border(i))
                  self%slot(i) = slots + k
               end do
               slots = slots + size(outside)
            end associate
         end do
         self%branch_slot(size(self%branch_slot)) = slots
      end associate
   end subroutine find_branches

   !> Children of a front.
   pure function children(self, f) result(list)
      type(fronts_t), intent(in) :: self
      integer, intent(in) :: f
      integer, allocatable :: list(:)

      list = self%child(self%child_first(f):self%child_first(f + 1) - 1)
   end function children

   !> Where a number stands in a sorted list that has it.
   pure integer function find(list, number) result(low)
      integer, intent(in) :: list(:), number
      integer :: high, middle

      low = 1
      high = size(list)
      do while (low < high)
         middle = (low + high)/2
         if (list(middle) < number) then
            low = middle + 1
         else
            high = middle
         end if
      end do
   end function find

   !> Factor a matrix of the pattern that was analysed.
   subroutine factorise(self, value, status)
      class(fronts_t), intent(inout) :: self
      !> Entries in the order of the pattern; entries of one place are added
      real(wp), intent(in) :: value(:)
      !> linear_ok, linear_singular where a front has no pivot, linear_failed without memory
      integer, intent(out) :: status
      type(remainder_t) :: remainder(size(self%plan%parent))
      logical :: failed
      integer :: b, f, i, allocation

      self%factored = .false.
      status = linear_failed
      if (.not. allocated(self%factor)) then
         allocate (self%factor(self%begins(size(self%begins))), stat=allocation)
         if (allocation /= 0) return
      end if
      failed = .false.
      !$omp parallel do schedule(dynamic) default(none) shared(self, value, remainder) private(f) reduction(.or.:failed) &
      !$omp if(size(self%branch_last) > 1)
      do b = size(self%branch_last), 1, -1
         do f = self%branch_first(b), self%branch_last(b)
            if (.not. failed) call make_front(self, value, f, .false., remainder, failed)
         end do
      end do
      !$omp end parallel do
      do i = 1, size(self%top)
         if (.not. failed) call make_front(self, value, self%top(i), .true., remainder, failed)
      end do
      self%factored = .not. failed
      status = merge(linear_singular, linear_ok, failed)
   end subroutine factorise

   !> Add up a front and eliminate its pivots.
   subroutine make_front(self, value, f, alone, remainder, failed)
      type(fronts_t), intent(inout) :: self
      real(wp), intent(in) :: value(:)
      integer, intent(in) :: f
      !> Are no other fronts made at the same time?
      logical, intent(in) :: alone
      !> Those of the children are taken, that of the front is left (fronts)
      type(remainder_t), intent(inout) :: remainder(:)
      !> Is there no pivot?
      logical, intent(inout) :: failed
      integer(i8) :: begins, upper, at
      real(wp) :: least(pivots_of(self%plan, f))
      integer :: p, c, k, i
      logical :: regular

      p = pivots_of(self%plan, f)
      c = border_of(self%plan, f)
      begins = self%begins(f)
      upper = begins + int(p, i8)*int(p + c, i8)
      self%factor(begins + 1:self%begins(f + 1)) = 0.0_wp
      do k = self%entry_first(f), self%entry_first(f + 1) - 1
         at = begins + int(self%goes_to(k), i8)
         self%factor(at) = self%factor(at) + value(self%entry(k))
      end do
      do k = 1, p
         at = begins + int(k - 1, i8)*int(p + c, i8) + int(k, i8)
         least(k) = least_share_left*abs(self%factor(at))
      end do
      allocate (remainder(f)%value(c, c))
      remainder(f)%value = 0.0_wp
      do k = self%child_first(f), self%child_first(f + 1) - 1
         i = self%child(k)
         associate (first => self%plan%border_first(i), last => self%plan%border_first(i + 1) - 1)
            call add_child(p, c, self%in_parent(first:last), remainder(i)%value, self%factor(begins + 1:upper), &
                           self%factor(upper + 1:self%begins(f + 1)), remainder(f)%value)
         end associate
         deallocate (remainder(i)%value)
      end do
      call eliminate(p, c, alone, least, self%factor(begins + 1:upper), self%factor(upper + 1:self%begins(f + 1)), &
                     remainder(f)%value, self%swapped(self%plan%first(f):self%plan%first(f + 1) - 1), regular)
      failed = failed .or. .not. regular
   end subroutine make_front

   !> Add what a child leaves to the front of its parent.
   pure subroutine add_child(p, c, place, child, lower, upper, rest)
      !> Pivots and border of the parent; places there, in rising order, of what the child leaves
      integer, intent(in) :: p, c, place(:)
      real(wp), intent(in) :: child(:, :)
      real(wp), intent(inout) :: lower(p + c, p), upper(c, p), rest(c, c)
      integer :: i, j, pivots

      pivots = count(place <= p)
      do j = 1, pivots
         do i = 1, size(place)
            lower(place(i), place(j)) = lower(place(i), place(j)) + child(i, j)
         end do
      end do
      do j = pivots + 1, size(place)
         do i = 1, pivots
            upper(place(j) - p, place(i)) = upper(place(j) - p, place(i)) + child(i, j)
         end do
         do i = pivots + 1, size(place)
            rest(place(i) - p, place(j) - p) = rest(place(i) - p, place(j) - p) + child(i, j)
         end do
      end do
   end subroutine add_child

   !> Eliminate the pivots of a front.
   subroutine eliminate(p, c, alone, least, lower, upper, rest, swapped, regular)
      integer, intent(in) :: p, c
      logical, intent(in) :: alone
      !> Least pivots
      real(wp), intent(in) :: least(p)
      !> Pivots and border by pivots, and the transposed rows of the pivots in the border; the factors on return
      real(wp), intent(inout) :: lower(p + c, p), upper(c, p)
      !> The border; what is left of it on return
      real(wp), intent(inout) :: rest(c, c)
      !> Row that each pivot changed places with
      integer, intent(out) :: swapped(p)
      !> Was there a pivot each time?
      logical, intent(out) :: regular
      real(wp) :: line(p), side(c), largest
      integer :: from, to, k, j, q, m, columns

      m = p + c
      regular = .false.
      do from = 1, p, panel
         to = min(from + panel - 1, p)
         do k = from, to
            largest = maxval(abs(lower(k:m, k)))
            q = k
            if (abs(lower(k, k)) < least_pivot_ratio*largest) q = k - 1 + maxloc(abs(lower(k:p, k)), dim=1)
            ! A comparison with NaN is false
            if (.not. (abs(lower(q, k)) >= least_pivot_ratio*largest .and. abs(lower(q, k)) >= least(k))) return
            swapped(k) = q
            if (q /= k) then
               line = lower(k, :)
               lower(k, :) = lower(q, :)
               lower(q, :) = line
               side = upper(:, k)
               upper(:, k) = upper(:, q)
               upper(:, q) = side
            end if
            lower(k + 1:m, k) = lower(k + 1:m, k)/lower(k, k)
            do j = k + 1, to
               lower(k + 1:m, j) = lower(k + 1:m, j) - lower(k, j)*lower(k + 1:m, k)
            end do
         end do
         if (to == p) exit
         call dtrsm('L', 'L', 'N', 'U', to - from + 1, p - to, 1.0_wp, lower(from, from), m, lower(from, to + 1), m)
         call dgemm('N', 'N', m - to, p - to, to - from + 1, -1.0_wp, lower(to + 1, from), m, lower(from, to + 1), m, 1.0_wp, &
                    lower(to + 1, to + 1), m)
      end do
      regular = .true.
      if (c == 0) return
      call dtrsm('R', 'L', 'T', 'U', c, p, 1.0_wp, lower, m, upper, c)
      ! Columns in groups that are the same for any number of threads
      !$omp parallel do schedule(static) default(none) shared(lower, upper, rest, m, p, c) private(columns) &
      !$omp if(alone .and. c > columns_at_once)
      do j = 1, c, columns_at_once
         columns = min(columns_at_once, c - j + 1)
         call dgemm('N', 'T', c, columns, p, -1.0_wp, lower(p + 1, 1), m, upper(j, 1), c, 1.0_wp, rest(1, j), c)
      end do
      !$omp end parallel do
   end subroutine eliminate

   !> Replace a right-hand side by the solution.
   subroutine solve(self, x)
      class(fronts_t), intent(in) :: self
      !> Right-hand side in, solution out (unknowns)
      real(wp), intent(inout) :: x(:)
      !> In the order of elimination, then what each branch has for the unknowns after it
      real(wp) :: y(self%branch_slot(size(self%branch_slot)))
      integer :: b, f, i

      y(self%plan%place) = x
      y(self%unknowns + 1:) = 0.0_wp
      !$omp parallel do schedule(dynamic) default(none) shared(self, y) private(f) if(size(self%branch_last) > 1)
      do b = size(self%branch_last), 1, -1
         do f = self%branch_first(b), self%branch_last(b)
            call go_up(self, f, y)
         end do
      end do
      !$omp end parallel do
      do b = 1, size(self%branch_last)
         f = self%branch_last(b)
         associate (outside => self%plan%border(self%plan%border_first(f):self%plan%border_first(f + 1) - 1))
            y(outside) = y(outside) + y(self%branch_slot(b) + 1:self%branch_slot(b + 1))
         end associate
      end do
      do i = 1, size(self%top)
         call go_up(self, self%top(i), y)
      end do
      do i = size(self%top), 1, -1
         call come_down(self, self%top(i), y)
      end do
      do b = 1, size(self%branch_last)
         f = self%branch_last(b)
         y(self%branch_slot(b) + 1:self%branch_slot(b + 1)) = &
            y(self%plan%border(self%plan%border_first(f):self%plan%border_first(f + 1) - 1))
      end do
      !$omp parallel do schedule(dynamic) default(none) shared(self, y) private(f) if(size(self%branch_last) > 1)
      do b = size(self%branch_last), 1, -1
         do f = self%branch_last(b), self%branch_first(b), -1
            call come_down(self, f, y)
         end do
      end do
      !$omp end parallel do
      x = y(self%plan%place)
   end subroutine solve

   !> Eliminate the pivots of a front from a right-hand side.
   pure subroutine go_up(self, f, y)
      type(fronts_t), intent(in) :: self
      integer, intent(in) :: f
      real(wp), intent(inout) :: y(:)
      integer :: first

      first = self%plan%first(f)
      associate (p => pivots_of(self%plan, f), c => border_of(self%plan, f))
         call eliminate_from(p, c, self%factor(self%begins(f) + 1:self%begins(f) + int(p, i8)*int(p + c, i8)), &
                             self%swapped(first:first + p - 1), &
                             self%slot(self%plan%border_first(f):self%plan%border_first(f + 1) - 1), first, y)
      end associate
   end subroutine go_up

   pure subroutine eliminate_from(p, c, lower, swapped, slot, first, y)
      integer, intent(in) :: p, c, swapped(p), slot(c), first
      real(wp), intent(in) :: lower(p + c, p)
      real(wp), intent(inout) :: y(:)
      real(wp) :: x(p + c), kept
      integer :: k, i

      x(:p) = y(first:first + p - 1)
      x(p + 1:) = 0.0_wp
      do k = 1, p
         if (swapped(k) == k) cycle
         kept = x(k)
         x(k) = x(swapped(k))
         x(swapped(k)) = kept
      end do
      do k = 1, p
         x(k + 1:) = x(k + 1:) - x(k)*lower(k + 1:, k)
      end do
      y(first:first + p - 1) = x(:p)
      do i = 1, c
         y(slot(i)) = y(slot(i)) + x(p + i)
      end do
   end subroutine eliminate_from

   !> Find the pivots' unknowns of a front from those of its border.
   pure subroutine come_down(self, f, y)
      type(fronts_t), intent(in) :: self
      integer, intent(in) :: f
      real(wp), intent(inout) :: y(:)
      integer(i8) :: begins, upper

      associate (p => pivots_of(self%plan, f), c => border_of(self%plan, f))
         begins = self%begins(f)
         upper = begins + int(p, i8)*int(p + c, i8)
         call find_pivots(p, c, self%factor(begins + 1:upper), self%factor(upper + 1:self%begins(f + 1)), &
                          self%slot(self%plan%border_first(f):self%plan%border_first(f + 1) - 1), self%plan%first(f), y)
      end associate
   end subroutine come_down

   pure subroutine find_pivots(p, c, lower, upper, slot, first, y)
      integer, intent(in) :: p, c, slot(c), first
      real(wp), intent(in) :: lower(p + c, p), upper(c, p)
      real(wp), intent(inout) :: y(:)
      real(wp) :: x(p), known(c), total
      integer :: k, i

      x = y(first:first + p - 1)
      do i = 1, c
         known(i) = y(slot(i))
      end do
      do k = 1, p
         total = 0.0_wp
         !$omp simd reduction(+:total)
         do i = 1, c
            total = total + upper(i, k)*known(i)
         end do
         x(k) = x(k) - total
      end do
      do k = p, 1, -1
         x(k) = x(k)/lower(k, k)
         x(:k - 1) = x(:k - 1) - x(k)*lower(:k - 1, k)
      end do
      y(first:first + p - 1) = x
   end subroutine find_pivots

   !> Number of branches that are eliminated at the same time.
   pure integer function branches(self)
      class(fronts_t), intent(in) :: self

      branches = size(self%branch_last)
   end function branches

   !> Memory that the factors take [MB].
   pure integer function memory(self)
      class(fronts_t), intent(in) :: self
      real(wp), parameter :: megabyte = 2.0_wp**20

      memory = 0
      if (allocated(self%begins)) memory = ceiling(8.0_wp*real(self%begins(size(self%begins)), wp)/megabyte)
   end function memory

end module fronts_m
