!> Search, through a grid of cells, for nodes of free edges that lie on another free edge or at the place of another
!> node: where parts of a mesh touch without being connected.
module overlap_m
   use kinds_m, only: wp
   implicit none
   private

   public :: find_overlaps

   !> Longest list of places; the rest is only counted
   integer, parameter, public :: most_listed = 20

   !> What was found
   type, public :: overlap_t
      !> Number of pairs of nodes at one place; the first of them
      integer :: pairs = 0, same_place(2, most_listed) = 0
      !> Number of nodes on edges; the first of them, with the ends of the edge
      integer :: cases = 0, on_edge(3, most_listed) = 0
   end type overlap_t

   !> A node nearer to an edge than this part of the edge's length lies on it
   real(wp), parameter :: tolerance = 1.0e-6_wp

   !> Square cells over the mesh; node(first(c):first(c+1)-1) are the nodes in cell c
   type :: grid_t
      real(wp) :: origin(2), cell
      integer :: columns, rows
      integer, allocatable :: first(:), node(:)
   end type grid_t

contains

   !> Find nodes of edges that lie on others. Cells are as large as the mean edge, so that an edge visits about as many
   !> cells as it has mean lengths; the cost is linear in the number of edges.
   subroutine find_overlaps(x, edge, overlap)
      !> Coordinates (2, nodes) [m]
      real(wp), intent(in) :: x(:, :)
      !> Nodes of the free edges (2, edges)
      integer, intent(in) :: edge(:, :)
      type(overlap_t), intent(out) :: overlap
      type(grid_t) :: grid
      integer :: e, column, row, low(2), high(2)
      real(wp) :: reach

      if (size(edge, 2) == 0) return
      call fill_grid(x, edge, grid)
      do e = 1, size(edge, 2)
         associate (a => x(:, edge(1, e)), b => x(:, edge(2, e)))
            reach = 2.0_wp*tolerance*norm2(b - a)
            low(1) = column_of(grid, min(a(1), b(1)) - reach)
            high(1) = column_of(grid, max(a(1), b(1)) + reach)
            do column = low(1), high(1)
               call rows_in_column(grid, a, b, column, reach, low(2), high(2))
               do row = low(2), high(2)
                  call look_into_cell(x, grid, (row - 1)*grid%columns + column, edge(:, e), overlap)
               end do
            end do
         end associate
      end do
   end subroutine find_overlaps

   !> Sort the nodes of the edges into cells.
   subroutine fill_grid(x, edge, grid)
      real(wp), intent(in) :: x(:, :)
      integer, intent(in) :: edge(:, :)
      type(grid_t), intent(out) :: grid
      logical, allocatable :: used(:)
      integer, allocatable :: node(:), cell(:), filled(:)
      real(wp) :: extent(2), length
      integer :: e, i

      allocate (used(size(x, 2)))
      used = .false.
      length = 0.0_wp
      do e = 1, size(edge, 2)
         used(edge(:, e)) = .true.
         length = length + norm2(x(:, edge(2, e)) - x(:, edge(1, e)))
      end do
      node = pack([(i, i=1, size(x, 2))], used)
      grid%origin = minval(x(:, node), dim=2)
      extent = maxval(x(:, node), dim=2) - grid%origin
      ! The mean edge, but not so small that there are many more cells than edges
      grid%cell = max(length/real(size(edge, 2), wp), sqrt(extent(1)*extent(2)/real(4*size(edge, 2), wp)))
      grid%columns = 1 + int(extent(1)/grid%cell)
      grid%rows = 1 + int(extent(2)/grid%cell)

      allocate (cell(size(node)), grid%first(grid%columns*grid%rows + 1), filled(grid%columns*grid%rows))
      allocate (grid%node(size(node)))
      filled = 0
      do i = 1, size(node)
         cell(i) = (row_of(grid, x(2, node(i))) - 1)*grid%columns + column_of(grid, x(1, node(i)))
         filled(cell(i)) = filled(cell(i)) + 1
      end do
      grid%first(1) = 1
      do i = 1, size(filled)
         grid%first(i + 1) = grid%first(i) + filled(i)
      end do
      filled = 0
      do i = 1, size(node)
         grid%node(grid%first(cell(i)) + filled(cell(i))) = node(i)
         filled(cell(i)) = filled(cell(i)) + 1
      end do
   end subroutine fill_grid

   !> Column of cells at x.
   pure integer function column_of(grid, x)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: x

      column_of = min(grid%columns, max(1, 1 + floor((x - grid%origin(1))/grid%cell)))
   end function column_of

   !> Row of cells at y.
   pure integer function row_of(grid, y)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: y

      row_of = min(grid%rows, max(1, 1 + floor((y - grid%origin(2))/grid%cell)))
   end function row_of

   !> Rows that an edge passes in one column.
   pure subroutine rows_in_column(grid, a, b, column, reach, low, high)
      type(grid_t), intent(in) :: grid
      !> Ends of the edge, column
      real(wp), intent(in) :: a(2), b(2)
      integer, intent(in) :: column
      !> How far beside the edge to look [m]
      real(wp), intent(in) :: reach
      integer, intent(out) :: low, high
      real(wp) :: left, right, y(2), part(2)

      y = [a(2), b(2)]
      if (abs(b(1) - a(1)) > reach) then
         left = grid%origin(1) + real(column - 1, wp)*grid%cell - reach
         right = left + grid%cell + 2.0_wp*reach
         part = min(1.0_wp, max(0.0_wp, ([left, right] - a(1))/(b(1) - a(1))))
         y = a(2) + part*(b(2) - a(2))
      end if
      ! An edge nearly upright moves in y by more than reach while it passes reach in x: look one reach further for each
      low = row_of(grid, minval(y) - 2.0_wp*reach)
      high = row_of(grid, maxval(y) + 2.0_wp*reach)
   end subroutine rows_in_column

   !> Compare the nodes of a cell with an edge.
   subroutine look_into_cell(x, grid, cell, edge, overlap)
      real(wp), intent(in) :: x(:, :)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell, edge(2)
      type(overlap_t), intent(inout) :: overlap
      real(wp) :: along(2), beyond(2), length_squared, part, distance
      integer :: i, node

      along = x(:, edge(2)) - x(:, edge(1))
      length_squared = sum(along**2)
      do i = grid%first(cell), grid%first(cell + 1) - 1
         node = grid%node(i)
         if (any(node == edge)) cycle
         beyond = x(:, node) - x(:, edge(1))
         part = sum(beyond*along)/length_squared
         distance = abs(along(1)*beyond(2) - along(2)*beyond(1))/length_squared
         if (distance > tolerance .or. part < -tolerance .or. part > 1.0_wp + tolerance) cycle
         if (part < tolerance) then
            ! Every node begins one free edge and ends another: counted where it begins one, each pair is met twice, and
            ! once with the higher node first
            if (node < edge(1)) cycle
            overlap%pairs = overlap%pairs + 1
            if (overlap%pairs <= most_listed) overlap%same_place(:, overlap%pairs) = [node, edge(1)]
         else if (part <= 1.0_wp - tolerance) then
            overlap%cases = overlap%cases + 1
            if (overlap%cases <= most_listed) overlap%on_edge(:, overlap%cases) = [node, edge]
         end if
      end do
   end subroutine look_into_cell

end module overlap_m
