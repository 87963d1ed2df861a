!> The outline of a model: which nodes are on its boundary, and whether it is a rectangle along the axes, with its sides.
module outline_m
   use kinds_m, only: wp
   implicit none
   private

   public :: find_outline

   !> Sides of a rectangle
   integer, parameter, public :: left_side = 1, right_side = 2, bottom_side = 3, top_side = 4
   !> Nodes are on a side, and an outline is a rectangle, to this part of its size
   real(wp), parameter :: closeness = 1.0e-9_wp

   type, public :: outline_t
      !> Nodes on the boundary: those of the rectangle's sides (holes are not), or of all edges that are outside (nodes)
      logical, allocatable :: boundary(:)
      !> Is it a rectangle? Its sides (nodes, 4); a corner is on two
      logical :: rectangle = .false.
      logical, allocatable :: side(:, :)
      !> Least and largest coordinates [m]; area, with that of holes in a rectangle [m2]
      real(wp) :: low(2) = 0.0_wp, high(2) = 0.0_wp, area = 0.0_wp
   end type outline_t

contains

   !> Find the outline from the edges of the boundary.
   subroutine find_outline(x, edge, rock_area, outline)
      !> Nodes (2, nodes) [m]
      real(wp), intent(in) :: x(:, :)
      !> Edges of the boundary, in any order and direction (2, edges)
      integer, intent(in) :: edge(:, :)
      !> Area of the triangles [m2]
      real(wp), intent(in) :: rock_area
      type(outline_t), intent(out) :: outline
      real(wp) :: width(2), tolerance, along
      integer :: i

      allocate (outline%boundary(size(x, 2)), source=.false.)
      allocate (outline%side(size(x, 2), 4), source=.false.)
      outline%area = rock_area
      if (size(edge, 2) == 0) return
      do i = 1, 2
         outline%low(i) = minval(x(i, [edge(1, :), edge(2, :)]))
         outline%high(i) = maxval(x(i, [edge(1, :), edge(2, :)]))
      end do
      width = outline%high - outline%low
      tolerance = closeness*maxval(width)
      along = 0.0_wp
      do i = 1, size(edge, 2)
         associate (a => edge(1, i), b => edge(2, i))
            outline%boundary([a, b]) = .true.
            call take(left_side, 1, outline%low(1))
            call take(right_side, 1, outline%high(1))
            call take(bottom_side, 2, outline%low(2))
            call take(top_side, 2, outline%high(2))
         end associate
      end do
      outline%rectangle = abs(along - 2.0_wp*sum(width)) <= tolerance*real(size(edge, 2) + 1, wp) .and. minval(width) > tolerance
      if (.not. outline%rectangle) return
      outline%boundary = any(outline%side, dim=2)
      outline%area = product(width)

   contains

      !> Edges along a side make it up.
      subroutine take(side, axis, place)
         integer, intent(in) :: side, axis
         real(wp), intent(in) :: place

         associate (a => edge(1, i), b => edge(2, i))
            if (any(abs(x(axis, [a, b]) - place) > tolerance)) return
            outline%side([a, b], side) = .true.
            along = along + norm2(x(:, b) - x(:, a))
         end associate
      end subroutine take

   end subroutine find_outline

end module outline_m
