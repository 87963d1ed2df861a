!> Contact detection without a binary search (NBS): all pairs of overlapping axis-aligned boxes in a time proportional
!> to their number. Boxes are put into square cells no smaller than the boxes; a box can only meet boxes of its own and
!> the neighbouring cells. Cells are held as linked lists, first by rows, then, for the row at work and the one below
!> it, by columns: the memory follows the number of boxes, not the number of cells.
!>
!> Boxes of very different size are grouped into levels, each with cells twice as large as those of the level below.
!> A level's own boxes (residents) meet each other on its grid, and the smaller boxes (visitors) look the residents up
!> on the same grid. Without levels the cost would grow with the square of largest to smallest size.
!>
!> Reference: A. Munjiza, K.R.F. Andrews (1998), NBS contact detection algorithm for bodies of similar size,
!> Int. J. Numer. Meth. Eng. 43:131-149.
module nbs_m
   use kinds_m, only: wp, i8
   use rows_m, only: fill_rows
   implicit none
   private

   public :: find_box_pairs

   !> Finest and coarsest cell differ at most by this power of two
   integer, parameter :: max_levels = 31
   !> Cells are larger than their boxes by this factor, so that rounding cannot move a neighbour out of reach
   real(wp), parameter :: cell_slack = 1.0_wp + 1.0e-6_wp
   !> Smallest cell relative to the scene's extent: cell numbers keep ten digits below the rounding of a real
   real(wp), parameter :: least_cell = 1.0e-10_wp
   !> Odd 32-bit multiplier that scatters sparse cell numbers over the table (golden ratio)
   integer(i8), parameter :: scatter = 2654435769_i8

   !> Pairs found so far
   type :: pair_list_t
      integer :: n = 0
      integer, allocatable :: pair(:, :)
   contains
      procedure :: append
   end type pair_list_t

   !> Lines of cells (rows or columns) that hold a box, numbered without gaps
   type :: lines_t
      integer :: n = 0
      !> Line each box is in (boxes)
      integer, allocatable :: of_box(:)
      !> Line just below and above a line, 0 when it is empty (lines)
      integer, allocatable :: below(:), above(:)
   end type lines_t

   !> One level: the boxes that matter on its grid, sorted by row so that a row lies together in memory
   type :: level_t
      !> Number of each box in the caller's list, and a copy of its bounds: xmin, xmax, ymin, ymax (boxes)
      integer, allocatable :: box(:)
      real(wp), allocatable :: bounds(:, :)
      type(lines_t) :: row, column
      !> First resident (the level's own boxes) and first visitor (smaller ones) of each row; a row's end at the next
      !> row's beginning (rows + 1)
      integer, allocatable :: resident(:), visitor(:)
   end type level_t

contains

   !> Every pair of boxes that overlap or touch, once each, the smaller number first.
   subroutine find_box_pairs(box, pair)
      !> Boxes (4, n): xmin, xmax, ymin, ymax [m]
      real(wp), intent(in) :: box(:, :)
      !> Pairs (2, pairs) of box numbers, first < second; the order of the pairs means nothing
      integer, allocatable, intent(out) :: pair(:, :)
      type(pair_list_t) :: found
      type(level_t) :: grid
      real(wp), allocatable :: sorted(:, :)
      integer, allocatable :: order(:)
      integer :: first(max_levels + 1), level
      real(wp) :: finest

      allocate (found%pair(2, max(16, 4*size(box, 2))))
      if (size(box, 2) > 1) then
         call sort_by_level(box, sorted, order, first, finest)
         do level = 1, max_levels
            if (first(level + 1) == first(level)) cycle
            call fill_level(sorted, order, first(level), first(level + 1) - 1, finest*2.0_wp**(level - 1), grid)
            call sweep_rows(grid, found)
         end do
      end if
      allocate (pair(2, found%n))
      pair = found%pair(:, :found%n)
   end subroutine find_box_pairs

   !> Sort the boxes by level, and say where each level begins.
   pure subroutine sort_by_level(box, sorted, order, first, finest)
      real(wp), intent(in) :: box(:, :)
      !> Boxes, smallest level first (4, n), and their numbers (n)
      real(wp), allocatable, intent(out) :: sorted(:, :)
      integer, allocatable, intent(out) :: order(:)
      !> Place in order of each level's first box
      integer, intent(out) :: first(:)
      !> Cell size of level 1 [m]
      real(wp), intent(out) :: finest
      real(wp) :: extent, smallest, largest, length
      integer, allocatable :: level(:), first_box(:)
      integer :: i

      allocate (level(size(box, 2)), sorted(4, size(box, 2)))
      extent = max(maxval(box(2, :)) - minval(box(1, :)), maxval(box(4, :)) - minval(box(3, :)))
      smallest = huge(smallest)
      largest = 0.0_wp
      do i = 1, size(box, 2)
         length = box_size(box(:, i))
         smallest = min(smallest, length)
         largest = max(largest, length)
      end do
      finest = cell_slack*max(smallest, largest*2.0_wp**(1 - max_levels), extent*least_cell)
      if (finest <= 0.0_wp) finest = 1.0_wp

      do i = 1, size(box, 2)
         level(i) = level_of(cell_slack*box_size(box(:, i))/finest)
      end do
      call fill_rows(level, max_levels, first_box, order)
      first = first_box
      sorted = box(:, order)
   end subroutine sort_by_level

   !> Longer side of a box.
   pure real(wp) function box_size(box)
      real(wp), intent(in) :: box(4)

      box_size = max(box(2) - box(1), box(4) - box(3))
   end function box_size

   !> Level whose cell 2**(level-1), in units of the finest, is the smallest that is not smaller than the box.
   pure integer function level_of(ratio)
      !> Box size over the finest cell
      real(wp), intent(in) :: ratio

      level_of = 1
      if (ratio <= 1.0_wp) return
      level_of = exponent(ratio) + 1
      if (ratio <= 2.0_wp**(level_of - 2)) level_of = level_of - 1
      level_of = min(level_of, max_levels)
   end function level_of

   !> Put a level's residents, and the smaller boxes that can reach them, on the level's grid.
   pure subroutine fill_level(box, order, from, to, cell, grid)
      !> Boxes ordered by level (4, n)
      real(wp), intent(in) :: box(:, :)
      !> Their numbers in the caller's list (n); the residents are from..to, every smaller box stands before them
      integer, intent(in) :: order(:), from, to
      !> Cell size [m]
      real(wp), intent(in) :: cell
      type(level_t), intent(out) :: grid
      integer(i8), allocatable :: row_key(:), column_key(:)
      integer, allocatable :: chosen(:), place(:)
      real(wp) :: reach(4)
      integer :: i, n, visitors

      reach = box(:, from)
      do i = from + 1, to
         reach(1) = min(reach(1), box(1, i))
         reach(2) = max(reach(2), box(2, i))
         reach(3) = min(reach(3), box(3, i))
         reach(4) = max(reach(4), box(4, i))
      end do
      allocate (chosen(to), row_key(to), column_key(to))
      n = 0
      do i = 1, to
         if (i == from) visitors = n
         if (i < from) then
            if (.not. overlap(reach, box(:, i))) cycle
         end if
         n = n + 1
         chosen(n) = i
         column_key(n) = cell_number(box(1, i), box(2, i), reach(1), cell)
         row_key(n) = cell_number(box(3, i), box(4, i), reach(3), cell)
      end do
      call number_lines(row_key(:n), grid%row)
      call number_lines(column_key(:n), grid%column)

      allocate (place(n), grid%visitor(grid%row%n + 1), grid%resident(grid%row%n + 1))
      call sort_by_line(grid%row%of_box(:visitors), 0, grid%visitor, place(:visitors))
      call sort_by_line(grid%row%of_box(visitors + 1:n), visitors, grid%resident, place(visitors + 1:n))
      allocate (grid%box(n), grid%bounds(4, n))
      do i = 1, n
         grid%box(place(i)) = order(chosen(i))
         grid%bounds(:, place(i)) = box(:, chosen(i))
      end do
      grid%row%of_box(place) = grid%row%of_box
      grid%column%of_box(place) = grid%column%of_box
   end subroutine fill_level

   !> Places that boxes take when they are sorted by line.
   pure subroutine sort_by_line(line, offset, first, place)
      !> Line of each box (boxes)
      integer, intent(in) :: line(:)
      !> Places already taken
      integer, intent(in) :: offset
      !> First place of each line (lines + 1); place of each box (boxes)
      integer, intent(out) :: first(:), place(:)
      integer, allocatable :: first_box(:), box(:)
      integer :: i

      call fill_rows(line, size(first) - 1, first_box, box)
      first = offset + first_box
      do i = 1, size(box)
         place(box(i)) = offset + i
      end do
   end subroutine sort_by_line

   !> Cell that the middle of an interval falls into.
   pure integer(i8) function cell_number(low, high, origin, cell)
      real(wp), intent(in) :: low, high, origin, cell

      cell_number = floor((0.5_wp*(low + high) - origin)/cell, i8)
   end function cell_number

   !> Number the lines of cells that are in use, and find each line's neighbours, with a table of cell numbers.
   pure subroutine number_lines(key, lines)
      !> Cell number of each box along one axis (boxes)
      integer(i8), intent(in) :: key(:)
      type(lines_t), intent(out) :: lines
      integer, allocatable :: table(:)
      integer(i8), allocatable :: line_key(:)
      integer(i8) :: mask
      logical :: sparse
      integer :: i, place

      mask = 1_i8
      do while (mask < 2_i8*size(key, kind=i8))
         mask = 2*mask
      end do
      allocate (table(0:mask - 1), line_key(size(key)), lines%of_box(size(key)))
      table = 0
      mask = mask - 1
      ! Dense cell numbers index the table as they are, side by side in memory
      sparse = maxval(key) - minval(key) > mask
      do i = 1, size(key)
         place = place_of(key(i))
         if (table(place) == 0) then
            lines%n = lines%n + 1
            table(place) = lines%n
            line_key(lines%n) = key(i)
         end if
         lines%of_box(i) = table(place)
      end do
      allocate (lines%below(lines%n), lines%above(lines%n))
      do i = 1, lines%n
         lines%below(i) = table(place_of(line_key(i) - 1))
         lines%above(i) = table(place_of(line_key(i) + 1))
      end do

   contains

      !> Place of a cell number in the table, or the free place where it belongs
      pure integer function place_of(number)
         integer(i8), intent(in) :: number
         integer(i8) :: at

         at = number
         ! Multiply the low word and fold the high half of the product into the low bits
         if (sparse) then
            at = iand(ieor(at, ishft(at, -32)), int(z'FFFFFFFF', i8))
            at = iand(at, int(z'7FFFFFFF', i8))*scatter
            at = ieor(at, ishft(at, -29))
         end if
         at = iand(at, mask)
         do
            place_of = int(at)
            if (table(place_of) == 0) return
            if (line_key(table(place_of)) == number) return
            at = iand(at + 1, mask)
         end do
      end function place_of
   end subroutine number_lines

   !> Walk the rows of a level: a row's residents meet themselves and those of the row below, visitors of the row and of
   !> both its neighbours meet the row's residents.
   subroutine sweep_rows(grid, found)
      type(level_t), intent(in) :: grid
      type(pair_list_t), intent(inout) :: found
      integer, allocatable :: new(:), old(:), next(:)
      integer :: row, near(3), i, k, column

      ! First resident of each column in the row at work and in the row below it. Column 0 stands for a neighbour that
      ! is not there and stays empty.
      allocate (new(0:grid%column%n), old(0:grid%column%n), next(size(grid%box)))
      new = 0
      old = 0
      do row = 1, grid%row%n
         if (grid%resident(row) == grid%resident(row + 1)) cycle
         near = [row, grid%row%below(row), grid%row%above(row)]
         call open_row(row, new)
         do i = grid%resident(row), grid%resident(row + 1) - 1
            column = grid%column%of_box(i)
            call meet(i, next(i))
            call meet(i, new(grid%column%below(column)))
         end do
         do k = 1, size(near)
            if (near(k) == 0) cycle
            do i = grid%visitor(near(k)), grid%visitor(near(k) + 1) - 1
               column = grid%column%of_box(i)
               call meet(i, new(grid%column%below(column)))
               call meet(i, new(column))
               call meet(i, new(grid%column%above(column)))
            end do
         end do
         if (near(2) > 0) then
            call open_row(near(2), old)
            do i = grid%resident(row), grid%resident(row + 1) - 1
               column = grid%column%of_box(i)
               call meet(i, old(grid%column%below(column)))
               call meet(i, old(column))
               call meet(i, old(grid%column%above(column)))
            end do
            call close_row(near(2), old)
         end if
         call close_row(row, new)
      end do

   contains

      !> Sort the residents of a row by column
      subroutine open_row(line, head)
         integer, intent(in) :: line
         integer, intent(inout) :: head(0:)
         integer :: j

         do j = grid%resident(line), grid%resident(line + 1) - 1
            next(j) = head(grid%column%of_box(j))
            head(grid%column%of_box(j)) = j
         end do
      end subroutine open_row

      !> Empty the columns that a row has used
      pure subroutine close_row(line, head)
         integer, intent(in) :: line
         integer, intent(inout) :: head(0:)
         integer :: j

         do j = grid%resident(line), grid%resident(line + 1) - 1
            head(grid%column%of_box(j)) = 0
         end do
      end subroutine close_row

      !> Box a against a chain of boxes
      subroutine meet(a, chain)
         integer, intent(in) :: a, chain
         integer :: j

         j = chain
         do while (j > 0)
            if (overlap(grid%bounds(:, a), grid%bounds(:, j))) call found%append(grid%box(a), grid%box(j))
            j = next(j)
         end do
      end subroutine meet
   end subroutine sweep_rows

   !> Do two boxes share a point?
   pure logical function overlap(a, b)
      real(wp), intent(in) :: a(4), b(4)

      overlap = a(1) <= b(2) .and. b(1) <= a(2) .and. a(3) <= b(4) .and. b(3) <= a(4)
   end function overlap

   !> One more pair; the list doubles when it is full, so that the cost of growing stays linear.
   subroutine append(self, a, b)
      class(pair_list_t), intent(inout) :: self
      integer, intent(in) :: a, b
      integer, allocatable :: longer(:, :)

      if (self%n == size(self%pair, 2)) then
         allocate (longer(2, 2*self%n))
         longer(:, :self%n) = self%pair
         call move_alloc(longer, self%pair)
      end if
      self%n = self%n + 1
      self%pair(:, self%n) = [min(a, b), max(a, b)]
   end subroutine append

end module nbs_m
