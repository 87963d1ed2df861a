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
   implicit none
   private

   public :: find_overlaps

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

   !> One level: the boxes that matter on its grid, visitors first
   type :: level_t
      !> Boxes 1..visitors are smaller than the level's, the rest up to n are its own
      integer :: visitors = 0, n = 0
      !> Number of each box in the caller's list (n)
      integer, allocatable :: box(:)
      type(lines_t) :: row, column
   end type level_t

contains

   !> Every pair of boxes that overlap or touch, once each, the smaller number first.
   subroutine find_overlaps(box, pair)
      !> Boxes (4, n): xmin, xmax, ymin, ymax [m]
      real(wp), intent(in) :: box(:, :)
      !> Pairs (2, pairs) of box numbers, first < second; the order of the pairs means nothing
      integer, allocatable, intent(out) :: pair(:, :)
      type(pair_list_t) :: found
      type(level_t) :: grid
      integer, allocatable :: order(:)
      integer :: first(max_levels + 1), level
      real(wp) :: finest

      allocate (found%pair(2, max(16, 4*size(box, 2))))
      if (size(box, 2) > 1) then
         call sort_by_level(box, order, first, finest)
         do level = 1, max_levels
            if (first(level + 1) == first(level)) cycle
            call fill_level(box, order, first(level), first(level + 1) - 1, finest*2.0_wp**(level - 1), grid)
            call sweep_rows(box, grid, found)
         end do
      end if
      allocate (pair(2, found%n))
      pair = found%pair(:, :found%n)
   end subroutine find_overlaps

   !> Order the boxes by level, and say where each level begins.
   pure subroutine sort_by_level(box, order, first, finest)
      real(wp), intent(in) :: box(:, :)
      !> Box numbers, smallest level first (n)
      integer, allocatable, intent(out) :: order(:)
      !> Place in order of each level's first box
      integer, intent(out) :: first(:)
      !> Cell size of level 1 [m]
      real(wp), intent(out) :: finest
      real(wp) :: extent, smallest, largest, length
      integer, allocatable :: level(:)
      integer :: place(max_levels), i

      allocate (level(size(box, 2)), order(size(box, 2)))
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

      first = 0
      do i = 1, size(box, 2)
         level(i) = level_of(cell_slack*box_size(box(:, i))/finest)
         first(level(i) + 1) = first(level(i) + 1) + 1
      end do
      first(1) = 1
      do i = 1, max_levels
         place(i) = first(i)
         first(i + 1) = first(i + 1) + first(i)
      end do
      do i = 1, size(box, 2)
         order(place(level(i))) = i
         place(level(i)) = place(level(i)) + 1
      end do
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
      real(wp), intent(in) :: box(:, :)
      !> Boxes ordered by level; the residents are order(from:to), every smaller box stands before them
      integer, intent(in) :: order(:), from, to
      !> Cell size [m]
      real(wp), intent(in) :: cell
      type(level_t), intent(out) :: grid
      integer(i8), allocatable :: key(:)
      real(wp) :: reach(4)
      integer :: i, n

      reach = box(:, order(from))
      do i = from + 1, to
         reach(1) = min(reach(1), box(1, order(i)))
         reach(2) = max(reach(2), box(2, order(i)))
         reach(3) = min(reach(3), box(3, order(i)))
         reach(4) = max(reach(4), box(4, order(i)))
      end do
      allocate (grid%box(to))
      n = 0
      do i = 1, from - 1
         if (.not. overlap(reach, box(:, order(i)))) cycle
         n = n + 1
         grid%box(n) = order(i)
      end do
      grid%visitors = n
      grid%box(n + 1:n + to - from + 1) = order(from:to)
      grid%n = n + to - from + 1

      allocate (key(grid%n))
      do i = 1, grid%n
         key(i) = cell_number(box(1, grid%box(i)), box(2, grid%box(i)), reach(1), cell)
      end do
      call number_lines(key, grid%column)
      do i = 1, grid%n
         key(i) = cell_number(box(3, grid%box(i)), box(4, grid%box(i)), reach(3), cell)
      end do
      call number_lines(key, grid%row)
   end subroutine fill_level

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
   subroutine sweep_rows(box, grid, found)
      real(wp), intent(in) :: box(:, :)
      type(level_t), intent(in) :: grid
      type(pair_list_t), intent(inout) :: found
      integer, allocatable :: row_resident(:), row_visitor(:), row_next(:), new(:), new_next(:), old(:), old_next(:)
      integer :: row, below, near(3), i, k, column

      allocate (row_resident(grid%row%n), row_visitor(grid%row%n), row_next(grid%n), new_next(grid%n), old_next(grid%n))
      allocate (new(0:grid%column%n), old(0:grid%column%n))
      call list_boxes(grid%row%of_box, 1, grid%visitors, row_visitor, row_next)
      call list_boxes(grid%row%of_box, grid%visitors + 1, grid%n, row_resident, row_next)
      ! Column 0 stands for a neighbour that is not there and stays empty
      new = 0
      old = 0
      do row = 1, grid%row%n
         if (row_resident(row) == 0) cycle
         below = grid%row%below(row)
         call open_row(row_resident(row), new, new_next)
         if (below > 0) call open_row(row_resident(below), old, old_next)

         i = row_resident(row)
         do while (i > 0)
            column = grid%column%of_box(i)
            call meet(i, new_next(i), new_next)
            call meet(i, new(grid%column%below(column)), new_next)
            call meet(i, old(grid%column%below(column)), old_next)
            call meet(i, old(column), old_next)
            call meet(i, old(grid%column%above(column)), old_next)
            i = row_next(i)
         end do

         near = [below, row, grid%row%above(row)]
         do k = 1, size(near)
            if (near(k) == 0) cycle
            i = row_visitor(near(k))
            do while (i > 0)
               column = grid%column%of_box(i)
               call meet(i, new(grid%column%below(column)), new_next)
               call meet(i, new(column), new_next)
               call meet(i, new(grid%column%above(column)), new_next)
               i = row_next(i)
            end do
         end do

         call close_row(row_resident(row), new)
         if (below > 0) call close_row(row_resident(below), old)
      end do

   contains

      !> Sort the boxes of a row by column
      pure subroutine open_row(first_box, head, next)
         integer, intent(in) :: first_box
         integer, intent(inout) :: head(0:), next(:)
         integer :: j

         j = first_box
         do while (j > 0)
            next(j) = head(grid%column%of_box(j))
            head(grid%column%of_box(j)) = j
            j = row_next(j)
         end do
      end subroutine open_row

      !> Empty the columns that a row has used
      pure subroutine close_row(first_box, head)
         integer, intent(in) :: first_box
         integer, intent(inout) :: head(0:)
         integer :: j

         j = first_box
         do while (j > 0)
            head(grid%column%of_box(j)) = 0
            j = row_next(j)
         end do
      end subroutine close_row

      !> Box a against a chain of boxes
      subroutine meet(a, chain, next)
         integer, intent(in) :: a, chain, next(:)
         integer :: j

         j = chain
         do while (j > 0)
            if (overlap(box(:, grid%box(a)), box(:, grid%box(j)))) call found%append(grid%box(a), grid%box(j))
            j = next(j)
         end do
      end subroutine meet
   end subroutine sweep_rows

   !> Linked lists of the boxes from..to by line.
   pure subroutine list_boxes(line, from, to, head, next)
      !> Line of each box (boxes)
      integer, intent(in) :: line(:), from, to
      !> First box of each line, 0 when there is none (lines); box after each box (boxes)
      integer, intent(out) :: head(:)
      integer, intent(inout) :: next(:)
      integer :: i

      head = 0
      do i = to, from, -1
         next(i) = head(line(i))
         head(line(i)) = i
      end do
   end subroutine list_boxes

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
