!> Chains of segments: which segment follows which, for the direction of joint elements and for block edges.
module chains_m
   use geometry_m, only: twice_area
   use kinds_m, only: wp
   implicit none
   private

   public :: find_neighbours, direct_chains

   !> Neighbour of a segment that has none
   integer, parameter, public :: no_neighbour = -1
   !> A chain whose ends differ less than this in x, relative to their distance, counts as upright
   real(wp), parameter :: upright = 1.0e-6_wp

contains

   !> Neighbours of each segment at its first and second node. Two segments are neighbours when they, and no others,
   !> meet at a node inside the rock and are of one group: bends go on; outer boundaries, tips, intersections,
   !> abutments and changes of group end a chain.
   pure subroutine find_neighbours(segment, group, on_boundary, neighbour)
      !> Nodes of each segment (2, segments), and its group
      integer, intent(in) :: segment(:, :), group(:)
      !> Is the node on the outer boundary? (nodes)
      logical, intent(in) :: on_boundary(:)
      !> Neighbour at each end or no_neighbour (2, segments)
      integer, intent(out) :: neighbour(:, :)
      integer, allocatable :: at_node(:, :), degree(:)
      integer :: s, k, node, other

      allocate (at_node(2, size(on_boundary)), degree(size(on_boundary)))
      degree = 0
      do s = 1, size(segment, 2)
         do k = 1, 2
            node = segment(k, s)
            degree(node) = degree(node) + 1
            if (degree(node) <= 2) at_node(degree(node), node) = s
         end do
      end do
      neighbour = no_neighbour
      do s = 1, size(segment, 2)
         do k = 1, 2
            node = segment(k, s)
            if (degree(node) /= 2 .or. on_boundary(node)) cycle
            other = sum(at_node(:, node)) - s
            if (group(other) == group(s)) neighbour(k, s) = other
         end do
      end do
   end subroutine find_neighbours

   !> Direct all segments of a chain the same way: so that the vector from the chain's beginning to its end points to
   !> +x, or to +y where the chain is upright; a closed chain runs anticlockwise.
   pure subroutine direct_chains(segment, neighbour, x, reversed)
      !> Nodes of each segment (2, segments), neighbours at them (2, segments)
      integer, intent(in) :: segment(:, :), neighbour(:, :)
      !> Coordinates (2, nodes) [m]
      real(wp), intent(in) :: x(:, :)
      !> Must the segment be reversed to run along its chain? (segments)
      logical, intent(out) :: reversed(:)
      logical, allocatable :: visited(:)
      integer, allocatable :: chain(:)
      integer :: s, first, enter, length, beginning, ending
      logical :: turn

      allocate (visited(size(segment, 2)), chain(size(segment, 2)))
      visited = .false.
      do s = 1, size(segment, 2)
         if (visited(s)) cycle
         call find_beginning(segment, neighbour, s, first, enter)
         call follow(segment, neighbour, first, enter, visited, reversed, chain, length)
         beginning = segment(enter, first)
         ending = segment(merge(1, 2, reversed(chain(length))), chain(length))
         if (beginning == ending) then
            turn = twice_enclosed(segment, x, chain(:length), reversed) < 0.0_wp
         else
            turn = points_back(x(:, ending) - x(:, beginning))
         end if
         if (turn) reversed(chain(:length)) = .not. reversed(chain(:length))
      end do
   end subroutine direct_chains

   !> Go back from a segment to the one its chain begins with; a closed chain may begin anywhere.
   pure subroutine find_beginning(segment, neighbour, start, first, enter)
      integer, intent(in) :: segment(:, :), neighbour(:, :), start
      !> First segment, and which of its two nodes the chain begins at
      integer, intent(out) :: first, enter
      integer :: before, node

      first = start
      enter = 1
      do
         before = neighbour(enter, first)
         if (before == no_neighbour .or. before == start) return
         node = segment(enter, first)
         enter = merge(2, 1, segment(1, before) == node)
         first = before
      end do
   end subroutine find_beginning

   !> List the segments of a chain from its beginning on.
   pure subroutine follow(segment, neighbour, first, first_enter, visited, reversed, chain, length)
      integer, intent(in) :: segment(:, :), neighbour(:, :)
      !> First segment, and which of its two nodes the chain begins at
      integer, intent(in) :: first, first_enter
      logical, intent(inout) :: visited(:)
      !> Is the segment passed from its second node to its first?
      logical, intent(inout) :: reversed(:)
      !> Segments in order; the first length entries are set
      integer, intent(inout) :: chain(:)
      integer, intent(out) :: length
      integer :: current, enter, node

      current = first
      enter = first_enter
      length = 0
      do
         visited(current) = .true.
         reversed(current) = enter == 2
         length = length + 1
         chain(length) = current
         node = segment(3 - enter, current)
         current = neighbour(3 - enter, current)
         if (current == no_neighbour) return
         if (visited(current)) return
         enter = merge(1, 2, segment(1, current) == node)
      end do
   end subroutine follow

   !> Twice the area that a closed chain encloses, positive when it runs anticlockwise.
   pure real(wp) function twice_enclosed(segment, x, chain, reversed)
      integer, intent(in) :: segment(:, :), chain(:)
      real(wp), intent(in) :: x(:, :)
      logical, intent(in) :: reversed(:)
      real(wp) :: apex(2), area
      integer :: i

      apex = x(:, segment(1, chain(1)))
      twice_enclosed = 0.0_wp
      do i = 1, size(chain)
         area = twice_area(apex, x(:, segment(1, chain(i))), x(:, segment(2, chain(i))))
         twice_enclosed = twice_enclosed + merge(-area, area, reversed(chain(i)))
      end do
   end function twice_enclosed

   !> Does a vector point to -x, or to -y where it is upright?
   pure logical function points_back(vector)
      real(wp), intent(in) :: vector(2)

      if (abs(vector(1)) > upright*abs(vector(2))) then
         points_back = vector(1) < 0.0_wp
      else
         points_back = vector(2) < 0.0_wp
      end if
   end function points_back

end module chains_m
