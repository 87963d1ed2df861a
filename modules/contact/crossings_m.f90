!> Crossings of fractures: which blocks meet at their corners only, in which cone one is in the other, and on which ways round the
!> crossing their slips add up. What such corners do to each other is corners_m, where there is a picture.
module crossings_m
   use kinds_m, only: wp
   use constants_m, only: pi
   use mesh_m, only: split_mesh_t
   implicit none
   private

   public :: init_corners

   !> A corner lets go when it has passed the other one by this part of an element
   real(wp), parameter :: reach_share = 0.5_wp

   !> Pairs of blocks that meet at corners only
   type, public :: corners_t
      !> Nodes of P and Q (2, pairs)
      integer, allocatable :: node(:, :)
      !> Inward normals of the two sides of the cone (2, 2, pairs); is it wider than half a turn?
      real(wp), allocatable :: inward(:, :, :)
      logical, allocatable :: wide(:)
      !> Stiffness [N/m per m of thickness]; distance beyond which the corner lets go [m] (pairs)
      real(wp), allocatable :: stiffness(:), reach(:)
      !> Stiffness over Young's modulus
      real(wp) :: factor = 1.0_wp
      !> Legs of the ways from Q to P: those of pair p are first(p) to first(p + 1) - 1
      integer, allocatable :: first(:)
      !> Nodes of the blocks before and behind the arm that a leg crosses (2, legs); unit vector along the arm, unit vector
      !> across it in the direction of the way (2, legs); 1 over the number of ways (legs)
      integer, allocatable :: across(:, :)
      real(wp), allocatable :: along(:, :), normal(:, :), share(:)
   end type corners_t

   !> A crossing: the blocks around it, anticlockwise, and the arms between them
   type :: crossing_t
      !> Node of each block (blocks); arm k lies between blocks k and k + 1
      integer, allocatable :: node(:)
      !> Does the last arm lead back to the first block?
      logical :: closed = .false.
      !> Directions in which each block begins and ends [rad], Young's modulus [Pa], (blocks)
      real(wp), allocatable :: from(:), to(:), young(:)
      !> Shortest arm [m]
      real(wp) :: shortest = 0.0_wp
   end type crossing_t

contains

   !> Find the pairs of blocks at all crossings.
   subroutine init_corners(split, touching, young, factor, corners)
      type(split_mesh_t), intent(in) :: split
      !> Joints whose walls are in wall contact (joints)
      logical, intent(in) :: touching(:)
      !> Young's modulus (triangles) [Pa]
      real(wp), intent(in) :: young(:)
      !> Stiffness of a corner over Young's modulus of its rock (per m of thickness)
      real(wp), intent(in) :: factor
      type(corners_t), intent(out) :: corners
      !> Surface edge that starts and that ends at each node, 0 where there is none or more than one (nodes)
      integer, allocatable :: out(:), in(:)
      !> Wall edges of each joint: lower, upper (2, joints)
      integer, allocatable :: wall(:, :)
      !> Has the block of a node been seen? (nodes)
      logical, allocatable :: seen(:)
      type(crossing_t) :: crossing
      integer :: node, e

      allocate (corners%node(2, 0), corners%inward(2, 2, 0), corners%wide(0), corners%stiffness(0), corners%reach(0), &
                corners%across(2, 0), corners%along(2, 0), corners%normal(2, 0), corners%share(0))
      corners%first = [1]
      corners%factor = factor
      allocate (wall(2, size(touching)), source=0)
      do e = 1, size(split%surface, 2)
         if (split%surface_joint(e) > 0) wall(merge(2, 1, split%surface_side(e) > 0), split%surface_joint(e)) = e
      end do
      call edges_of_nodes(split, out, in)
      allocate (seen(size(split%x, 2)), source=.false.)
      do node = 1, size(seen)
         if (seen(node) .or. in(node) == 0 .or. out(node) == 0) cycle
         call go_round(split, touching, young, wall, out, in, node, seen, crossing)
         if (crossing%closed) call add_pairs(crossing, factor, corners)
      end do
   end subroutine init_corners

   !> The surface edge that starts at each node and the one that ends there.
   pure subroutine edges_of_nodes(split, out, in)
      type(split_mesh_t), intent(in) :: split
      integer, allocatable, intent(out) :: out(:), in(:)
      integer, allocatable :: starts(:)
      integer :: e

      allocate (out(size(split%x, 2)), in(size(split%x, 2)), starts(size(split%x, 2)), source=0)
      do e = 1, size(split%surface, 2)
         associate (start => split%surface(1, e))
            out(start) = e
            starts(start) = starts(start) + 1
            in(split%surface(2, e)) = e
         end associate
      end do
      ! Two bodies that touch at a node alone
      where (starts > 1)
         out = 0
         in = 0
      end where
   end subroutine edges_of_nodes

   !> Go round a crossing from the block of a node: back as far as there are arms, then forward.
   subroutine go_round(split, touching, young, wall, out, in, start, seen, crossing)
      type(split_mesh_t), intent(in) :: split
      logical, intent(in) :: touching(:)
      real(wp), intent(in) :: young(:)
      integer, intent(in) :: wall(:, :), out(:), in(:), start
      logical, intent(inout) :: seen(:)
      type(crossing_t), intent(out) :: crossing
      integer :: node, next

      node = start
      do
         next = beyond(out(node), 1)
         if (next == 0 .or. next == start) exit
         node = next
      end do
      crossing%closed = next == start
      if (crossing%closed) node = start
      crossing%node = [integer ::]
      crossing%from = [real(wp) ::]
      crossing%to = [real(wp) ::]
      crossing%young = [real(wp) ::]
      crossing%shortest = huge(1.0_wp)
      do
         seen(node) = .true.
         crossing%node = [crossing%node, node]
         crossing%young = [crossing%young, young(split%surface_triangle(out(node)))]
         associate (x => split%x(:, node), ahead => split%x(:, split%surface(2, out(node))), &
                    behind => split%x(:, split%surface(1, in(node))))
            crossing%from = [crossing%from, atan2(ahead(2) - x(2), ahead(1) - x(1))]
            crossing%to = [crossing%to, atan2(behind(2) - x(2), behind(1) - x(1))]
            crossing%shortest = min(crossing%shortest, norm2(ahead - x), norm2(behind - x))
         end associate
         node = beyond(in(node), 2)
         if (node == 0) return
         if (seen(node)) return
      end do

   contains

      !> Node of the block beyond a surface edge that starts (1) or ends (2) at this crossing, 0 where there is none. Walls run
      !> against each other: where one ends the other starts.
      pure integer function beyond(edge, which)
         integer, intent(in) :: edge, which
         integer :: joint

         beyond = 0
         joint = split%surface_joint(edge)
         if (joint == 0) return
         if (.not. touching(joint)) return
         beyond = split%surface(3 - which, wall(merge(1, 2, split%surface_side(edge) > 0), joint))
         if (out(beyond) == 0 .or. in(beyond) == 0) beyond = 0
      end function beyond

   end subroutine go_round

   !> Add the pairs of blocks of a crossing that share no arm.
   subroutine add_pairs(crossing, factor, corners)
      type(crossing_t), intent(in) :: crossing
      real(wp), intent(in) :: factor
      type(corners_t), intent(inout) :: corners
      integer :: blocks, i, k, a, ways
      real(wp) :: young

      blocks = size(crossing%node)
      do i = 1, blocks - 2
         do k = i + 2, blocks
            if (crossing%closed .and. blocks - (k - i) < 2) cycle
            if (max(width(crossing, i), width(crossing, k)) > pi*(1.0_wp + sqrt(epsilon(pi)))) cycle
            ways = merge(2, 1, crossing%closed)
            do a = i, k - 1
               call add_leg(crossing, a, a + 1, 1.0_wp, ways, corners)
            end do
            if (crossing%closed) then
               do a = i + blocks, k + 1, -1
                  call add_leg(crossing, a, a - 1, -1.0_wp, ways, corners)
               end do
            end if
            call add_cone(crossing, i, k, corners)
            young = 2.0_wp*crossing%young(i)*crossing%young(k)/(crossing%young(i) + crossing%young(k))
            corners%node = reshape([corners%node, crossing%node(k), crossing%node(i)], [2, size(corners%node, 2) + 1])
            corners%stiffness = [corners%stiffness, factor*young]
            corners%reach = [corners%reach, reach_share*crossing%shortest]
            corners%first = [corners%first, size(corners%share) + 1]
         end do
      end do
   end subroutine add_pairs

   !> Angle that a block fills [rad].
   pure real(wp) function width(crossing, block)
      type(crossing_t), intent(in) :: crossing
      integer, intent(in) :: block

      width = modulo(crossing%to(block) - crossing%from(block), 2.0_wp*pi)
   end function width

   !> Add the step from one block to the next one.
   subroutine add_leg(crossing, from, to, sense, ways, corners)
      type(crossing_t), intent(in) :: crossing
      !> Blocks; numbers go on round a closed crossing
      integer, intent(in) :: from, to
      !> 1: anticlockwise, -1: clockwise
      real(wp), intent(in) :: sense
      integer, intent(in) :: ways
      type(corners_t), intent(inout) :: corners
      integer :: n, behind, ahead
      real(wp) :: angle

      n = size(crossing%node)
      behind = modulo(from - 1, n) + 1
      ahead = modulo(to - 1, n) + 1
      angle = merge(crossing%to(behind), crossing%from(behind), sense > 0.0_wp)
      corners%across = reshape([corners%across, crossing%node(behind), crossing%node(ahead)], &
                               [2, size(corners%across, 2) + 1])
      corners%along = reshape([corners%along, cos(angle), sin(angle)], [2, size(corners%along, 2) + 1])
      corners%normal = reshape([corners%normal, -sense*sin(angle), sense*cos(angle)], [2, size(corners%normal, 2) + 1])
      corners%share = [corners%share, 1.0_wp/real(ways, wp)]
   end subroutine add_leg

   !> Add the cone of directions in which corner k enters corner i.
   subroutine add_cone(crossing, i, k, corners)
      type(crossing_t), intent(in) :: crossing
      integer, intent(in) :: i, k
      type(corners_t), intent(inout) :: corners
      real(wp) :: middle, half_i, half_k, apart, low, high

      half_i = 0.5_wp*width(crossing, i)
      half_k = 0.5_wp*width(crossing, k)
      middle = crossing%from(i) + half_i
      ! Middle of corner k turned by half a turn, from that of corner i
      apart = modulo(crossing%from(k) + half_k + pi - middle + pi, 2.0_wp*pi) - pi
      low = middle + min(-half_i, apart - half_k)
      high = middle + max(half_i, apart + half_k)
      corners%inward = reshape([corners%inward, -sin(low), cos(low), sin(high), -cos(high)], &
                               [2, 2, size(corners%inward, 3) + 1])
      corners%wide = [corners%wide, high - low > pi]
   end subroutine add_cone

end module crossings_m
