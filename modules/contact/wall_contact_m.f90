!> Contact of facing fracture walls: where each piece of an upper wall meets the other side now.
!>
!> Both walls of every joint are projected on the surface opposite, starting from the edge they faced last and walking
!> along that surface, so that sliding over any number of elements costs no search. Each overlap of a wall edge with one
!> opposite edge gets two Gauss points; the pressure there is found by the joint's law, and the forces go to the four nodes
!> by their shape functions. Overlaps are exact, so a constant pressure passes between walls whose nodes do not match.
!> The walls continue straight across crossings of fractures and on to the outer boundary.
!>
!> What two walls cover of each other is seen from both, and each has half of it: the contact does not know an upper wall
!> from a lower one. Where a wall faces a surface that is none, the wall has all of it. A wall has its rock on its left:
!> turned by half a turn, a lower wall is an upper wall, and pressure, shear stress and slip keep their signs.
module wall_contact_m
   use constants_m, only: no_length
   use kinds_m, only: wp
   use wall_layout_m, only: wall_contact_t, facing_cosine, deepest
   implicit none
   private

   !> Position of the two Gauss points on [0,1]
   real(wp), parameter :: gauss(2) = [0.5_wp - sqrt(1.0_wp/12.0_wp), 0.5_wp + sqrt(1.0_wp/12.0_wp)]
   !> Up to 45 degrees from opposite they press on each other in full, then less and less
   real(wp), parameter :: full_cosine = sqrt(0.5_wp)
   !> Part that each of two walls has of what they cover of each other
   real(wp), parameter :: half = 0.5_wp
   !> Overlaps shorter than this part of the edge carry nothing worth a division
   real(wp), parameter :: least_overlap = 1.0e-9_wp
   !> Contact lets go from this part of the deepest overlap on, so that no force jumps there
   real(wp), parameter, public :: lets_go = 0.5_wp
   !> Longest walk along the opposite surface in one step (edges)
   integer, parameter :: longest_walk = 64

   !> Where the walls meet: what they remember of it, and the integration points found last
   type, public :: wall_meeting_t
      !> Surface edge that each wall edge faced last (walls)
      integer, allocatable :: facing(:)
      !> Overlap over its length that a wall edge had when it was looked at last (walls)
      real(wp), allocatable :: reached(:)
      !> Has a wall come to face another edge since the stable step was last looked at?
      logical :: moved_on = .false.
      !> Current length of each wall edge (walls) [m]; its tangent, i of an upper wall, -i of a lower one (2, walls)
      real(wp), allocatable :: length(:), tangent(:, :)
      !> Integration points: number, wall edge, joint whose wall it faces (0: none), four nodes (A', B', p, q)
      integer :: points = 0
      integer, allocatable :: wall(:), faced_joint(:), point_node(:, :)
      !> Shape functions at the four nodes (4, points), weight [m], gap along the normal [m], negative when overlapping
      real(wp), allocatable :: shape(:, :), weight(:), gap(:)
      !> Part of the wall edge each point stands for, from and to (2, points); nodes of the blocks beside that share it at
      !> either end (2, points), 0 where none does
      real(wp), allocatable :: part(:, :)
      integer, allocatable :: beside(:, :)
   end type wall_meeting_t

   !> A wall edge where it is now: its number, ends A' and B' [m], tangent and length [m]
   type :: wall_edge_t
      integer :: number = 0
      real(wp) :: a(2) = 0.0_wp, b(2) = 0.0_wp, tangent(2) = 0.0_wp, length = 0.0_wp
   end type wall_edge_t

   !> What a surface edge covers of a wall edge, as fractions of the wall edge from A' to B' (beyond [0,1] outside)
   type :: cover_t
      !> The surface edge; do the two face each other?
      integer :: edge = 0
      logical :: faces = .false.
      !> Where its ends are now (2), its length [m]
      real(wp) :: p(2) = 0.0_wp, q(2) = 0.0_wp, length = 0.0_wp
      real(wp) :: from = 0.0_wp, to = 0.0_wp
      !> The part of it that is its own, from and to; nodes of the other blocks that end there and share it, 0: none
      real(wp) :: part(2) = 0.0_wp
      integer :: beside(2) = 0
   end type cover_t

   public :: init_meeting, meet_walls, add_wall_forces, wall_stiffness_bound, point_stiffness_bound, wall_slip_rate, &
             points_of_joints, facing_part, facing_part_slope

contains

   !> Every wall faces the other wall of its joint.
   subroutine init_meeting(walls, met)
      type(wall_contact_t), intent(in) :: walls
      type(wall_meeting_t), intent(out) :: met

      met%facing = walls%opposite
      allocate (met%length(size(walls%joint)), met%reached(size(walls%joint)), met%tangent(2, size(walls%joint)), source=0.0_wp)
      call grow(met, 4*size(walls%joint) + 8)
   end subroutine init_meeting

   !> Find the integration points of all walls for the current displacement.
   subroutine meet_walls(walls, x, u, met)
      type(wall_contact_t), intent(in) :: walls
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(wall_meeting_t), intent(inout) :: met
      type(wall_edge_t) :: wall
      type(cover_t) :: cover
      integer :: w, e, steps, before

      met%points = 0
      do w = 1, size(walls%joint)
         wall%number = w
         wall%a = x(:, walls%node(1, w)) + u(:, walls%node(1, w))
         wall%b = x(:, walls%node(2, w)) + u(:, walls%node(2, w))
         wall%length = max(sqrt(sum((wall%b - wall%a)**2)), no_length)
         wall%tangent = (wall%b - wall%a)/wall%length
         met%length(w) = wall%length
         met%tangent(:, w) = wall%tangent
         before = met%points
         e = met%facing(w)
         if (e == 0) cycle
         call project(walls, e, x, u, wall, cover)
         ! Walk until the edge faced last overlaps this one again
         do steps = 1, longest_walk
            if (cover%to > 0.0_wp .and. cover%from < 1.0_wp) exit
            if (cover%to <= 0.0_wp) then
               if (walls%before(e) == 0) exit
               e = walls%before(e)
            else
               if (walls%after(e) == 0) exit
               e = walls%after(e)
            end if
            call project(walls, e, x, u, wall, cover)
         end do
         if (met%facing(w) /= e) met%moved_on = .true.
         met%facing(w) = e
         call share_edge(walls, walls%after(e), walls%before(e), x, u, wall, cover)
         if (cover%faces) call add_points(walls, wall, cover, met)
         if (cover%part(1) > 0.0_wp) call walk_on(walls, x, u, wall, .true., met)
         if (cover%part(2) < 1.0_wp) call walk_on(walls, x, u, wall, .false., met)
         met%reached(w) = 0.0_wp
         if (met%points > before) met%reached(w) = max(0.0_wp, -minval(met%gap(before + 1:met%points))/wall%length)
      end do
   end subroutine meet_walls

   !> Add the points of the edges that follow the one faced, in one direction, while they still overlap the wall.
   subroutine walk_on(walls, x, u, wall, ahead, met)
      type(wall_contact_t), intent(in) :: walls
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(wall_edge_t), intent(in) :: wall
      !> Ahead along the surface, towards A' of the wall, or back?
      logical, intent(in) :: ahead
      type(wall_meeting_t), intent(inout) :: met
      type(cover_t) :: cover
      integer :: e, last, steps

      e = met%facing(wall%number)
      do steps = 1, longest_walk
         last = e
         if (ahead) then
            e = walls%after(last)
         else
            e = walls%before(last)
         end if
         if (e == 0) return
         call project(walls, e, x, u, wall, cover)
         if (.not. cover%faces) return
         ! The edge walked from is the neighbour it shares with, also where its own surface goes on elsewhere
         if (ahead) then
            call share_edge(walls, walls%after(e), last, x, u, wall, cover)
         else
            call share_edge(walls, last, walls%before(e), x, u, wall, cover)
         end if
         if (cover%part(2) <= 0.0_wp .or. cover%part(1) >= 1.0_wp) return
         call add_points(walls, wall, cover, met)
      end do
   end subroutine walk_on

   !> Part of the wall edge that a surface edge covers.
   pure subroutine project(walls, e, x, u, wall, cover)
      type(wall_contact_t), intent(in) :: walls
      integer, intent(in) :: e
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(wall_edge_t), intent(in) :: wall
      !> All but its part and what is beside it
      type(cover_t), intent(inout) :: cover

      cover%edge = e
      cover%p = x(:, walls%surface(1, e)) + u(:, walls%surface(1, e))
      cover%q = x(:, walls%surface(2, e)) + u(:, walls%surface(2, e))
      cover%length = sqrt(sum((cover%q - cover%p)**2))
      cover%to = dot_product(cover%p - wall%a, wall%tangent)/wall%length
      cover%from = dot_product(cover%q - wall%a, wall%tangent)/wall%length
      cover%faces = (cover%to - cover%from)*wall%length > facing_cosine*cover%length
   end subroutine project

   !> Part of the wall edge that belongs to a surface edge: what it covers, but where the surface goes on in another block
   !> that covers some of it too, each block has half of that. So no piece of wall is held twice, and what each edge
   !> holds changes without a jump when blocks pass each other at a crossing.
   pure subroutine share_edge(walls, next, previous, x, u, wall, cover)
      type(wall_contact_t), intent(in) :: walls
      !> Neighbours of the surface edge towards A' and B' of the wall (0: none)
      integer, intent(in) :: next, previous
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(wall_edge_t), intent(in) :: wall
      type(cover_t), intent(inout) :: cover
      type(cover_t) :: other

      cover%part = [cover%from, cover%to]
      cover%beside = 0
      if (next > 0) then
         if (walls%surface(1, next) /= walls%surface(2, cover%edge)) then
            call project(walls, next, x, u, wall, other)
            if (other%faces .and. other%to > cover%from) then
               cover%part(1) = 0.5_wp*(cover%from + other%to)
               cover%beside(1) = walls%surface(1, next)
            end if
         end if
      end if
      if (previous > 0) then
         if (walls%surface(2, previous) /= walls%surface(1, cover%edge)) then
            call project(walls, previous, x, u, wall, other)
            if (other%faces .and. other%from < cover%to) then
               cover%part(2) = 0.5_wp*(cover%to + other%from)
               cover%beside(2) = walls%surface(2, previous)
            end if
         end if
      end if
   end subroutine share_edge

   !> Two Gauss points on the overlap of a wall edge with a surface edge.
   subroutine add_points(walls, wall, cover, met)
      type(wall_contact_t), intent(in) :: walls
      type(wall_edge_t), intent(in) :: wall
      type(cover_t), intent(in) :: cover
      type(wall_meeting_t), intent(inout) :: met
      real(wp) :: low, high, xi, eta, gap, share, reached, room, deeper
      integer :: g, k, nodes(4)

      low = max(0.0_wp, cover%part(1))
      high = min(1.0_wp, cover%part(2))
      if (high - low < least_overlap) return
      nodes = [walls%node(:, wall%number), walls%surface(:, cover%edge)]
      share = facing_part((cover%to - cover%from)*wall%length/cover%length)
      if (walls%wall_of(cover%edge) > 0) share = half*share
      if (met%points + 2 > size(met%wall)) call grow(met, 2*size(met%wall))
      reached = met%reached(wall%number)*wall%length
      room = walls%deepest(wall%number)*wall%length
      do g = 1, 2
         xi = low + (high - low)*gauss(g)
         eta = (cover%to - xi)/(cover%to - cover%from)
         ! The outward normal of a wall is its tangent turned clockwise
         gap = dot_product(cover%p + eta*(cover%q - cover%p) - wall%a - xi*(wall%b - wall%a), [wall%tangent(2), -wall%tangent(1)])
         deeper = (-gap - reached)/room
         if (deeper > 1.0_wp) cycle
         k = met%points + 1
         met%points = k
         met%wall(k) = wall%number
         met%faced_joint(k) = walls%wall_of(cover%edge)
         met%point_node(:, k) = nodes
         met%shape(:, k) = [1.0_wp - xi, xi, 1.0_wp - eta, eta]
         met%weight(k) = 0.5_wp*(high - low)*wall%length*share*held_part(deeper)
         met%gap(k) = gap
         met%part(:, k) = cover%part
         met%beside(:, k) = cover%beside
      end do
   end subroutine add_points

   !> Part of the pressure between two surfaces at an angle, from the cosine of the angle that one must be turned by to be
   !> exactly opposite: all up to 45 degrees, then smoothly less, none from 60 degrees on.
   pure real(wp) function facing_part(cosine)
      real(wp), intent(in) :: cosine
      real(wp) :: place

      place = min(1.0_wp, max(0.0_wp, (cosine - facing_cosine)/(full_cosine - facing_cosine)))
      facing_part = place**2*(3.0_wp - 2.0_wp*place)
   end function facing_part

   !> Its derivative by the cosine.
   pure real(wp) function facing_part_slope(cosine) result(slope)
      real(wp), intent(in) :: cosine
      real(wp) :: place

      place = min(1.0_wp, max(0.0_wp, (cosine - facing_cosine)/(full_cosine - facing_cosine)))
      slope = 6.0_wp*place*(1.0_wp - place)/(full_cosine - facing_cosine)
   end function facing_part_slope

   !> Part of an overlap that is in contact, at a depth beyond that before over the deepest: all of it up to lets_go, then
   !> smoothly none.
   pure real(wp) function held_part(depth)
      real(wp), intent(in) :: depth
      real(wp) :: beyond

      beyond = min(1.0_wp, max(0.0_wp, (depth - lets_go)/(1.0_wp - lets_go)))
      held_part = 1.0_wp - beyond**2*(3.0_wp - 2.0_wp*beyond)
   end function held_part

   !> Make room for at least n integration points.
   subroutine grow(met, n)
      type(wall_meeting_t), intent(inout) :: met
      integer, intent(in) :: n
      integer, allocatable :: wall(:), faced_joint(:), point_node(:, :), beside(:, :)
      real(wp), allocatable :: shape(:, :), weight(:), gap(:), part(:, :)

      allocate (wall(n), faced_joint(n), point_node(4, n), shape(4, n), weight(n), gap(n), part(2, n), beside(2, n))
      associate (k => met%points)
         if (k > 0) then
            wall(:k) = met%wall(:k)
            faced_joint(:k) = met%faced_joint(:k)
            point_node(:, :k) = met%point_node(:, :k)
            shape(:, :k) = met%shape(:, :k)
            weight(:k) = met%weight(:k)
            gap(:k) = met%gap(:k)
            part(:, :k) = met%part(:, :k)
            beside(:, :k) = met%beside(:, :k)
         end if
      end associate
      call move_alloc(wall, met%wall)
      call move_alloc(faced_joint, met%faced_joint)
      call move_alloc(point_node, met%point_node)
      call move_alloc(shape, met%shape)
      call move_alloc(weight, met%weight)
      call move_alloc(gap, met%gap)
      call move_alloc(part, met%part)
      call move_alloc(beside, met%beside)
   end subroutine grow

   !> First integration point of the walls of every joint: those of the i-th are first(i) to first(i + 1) - 1 (joints + 1).
   pure subroutine points_of_joints(met, first)
      type(wall_meeting_t), intent(in) :: met
      integer, intent(out) :: first(:)
      integer :: i, k

      k = 1
      do i = 1, size(first) - 1
         first(i) = k
         do while (k <= met%points)
            if (met%wall(k) > 2*i) exit
            k = k + 1
         end do
      end do
      first(size(first)) = k
   end subroutine points_of_joints

   !> Add the forces of given tractions at the integration points to the nodes of both walls (eqs 2, 4 in wall form).
   pure subroutine add_wall_forces(met, pressure, shear, normal_force, friction_force)
      type(wall_meeting_t), intent(in) :: met
      !> Normal stress, compression positive, and shear stress, positive when it resists positive slip (points) [Pa]
      real(wp), intent(in) :: pressure(:), shear(:)
      !> Nodal forces (2, nodes) [N per m of thickness]: normal and tangential part kept apart for the energy balance
      real(wp), contiguous, intent(inout) :: normal_force(:, :), friction_force(:, :)
      real(wp) :: normal(2), tangent(2)
      integer :: k, i
      real(wp), parameter :: side(4) = [1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp]

      do k = 1, met%points
         if (pressure(k) <= 0.0_wp) cycle
         ! The wall is pushed into its rock, which lies on its left
         normal = [-met%tangent(2, met%wall(k)), met%tangent(1, met%wall(k))]*pressure(k)*met%weight(k)
         tangent = -met%tangent(:, met%wall(k))*shear(k)*met%weight(k)
         do i = 1, 4
            associate (node => met%point_node(i, k), n => side(i)*met%shape(i, k))
               normal_force(:, node) = normal_force(:, node) + n*normal
               friction_force(:, node) = friction_force(:, node) + n*tangent
            end associate
         end do
      end do
   end subroutine add_wall_forces

   !> Add the row sums of the walls' stiffness to the nodal bounds (see solid_m). Edges count in full, and the next ones
   !> with them, so that the bound holds until a wall faces another edge. A wall with nothing but walls ahead has half of
   !> its contact; the other half is that of what it faces. So it is where the walls of a joint face each other; where they face
   !> those of others it may be up to two times too low: point_stiffness_bound knows.
   subroutine wall_stiffness_bound(walls, met, x, stiffness, bound)
      type(wall_contact_t), intent(in) :: walls
      type(wall_meeting_t), intent(in) :: met
      !> Reference coordinates (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :)
      !> The larger of normal and shear stiffness (walls) [Pa/m]
      real(wp), intent(in) :: stiffness(:)
      !> Nodal bound (nodes) [N/m per m of thickness]
      real(wp), intent(inout) :: bound(:)
      !> Sum of the absolute shape functions of both walls, times the half of an edge that each of its nodes has
      real(wp), parameter :: share = 2.0_wp*0.5_wp
      real(wp) :: against(size(walls%surface, 2)), own
      integer :: w, e
      integer, allocatable :: faced(:)

      against = 0.0_wp
      do w = 1, size(walls%joint)
         e = met%facing(w)
         if (e == 0) cycle
         faced = [e, within_reach(walls%before), within_reach(walls%after)]
         own = stiffness(w)
         if (all(walls%wall_of(faced) > 0)) own = half*own
         call add_edge(walls%node(:, w), own)
         against(faced) = max(against(faced), own)
      end do
      do e = 1, size(against)
         if (against(e) > 0.0_wp) call add_edge(walls%surface(:, e), against(e))
      end do

   contains

      !> The edges that follow edge e within the length of wall w, and one more.
      function within_reach(neighbour) result(list)
         integer, intent(in) :: neighbour(:)
         integer, allocatable :: list(:)
         integer :: next
         real(wp) :: left

         allocate (list(0))
         next = e
         left = norm2(x(:, walls%node(2, w)) - x(:, walls%node(1, w)))
         do
            next = neighbour(next)
            if (next == 0 .or. next == e) return
            list = [list, next]
            left = left - norm2(x(:, walls%surface(2, next)) - x(:, walls%surface(1, next)))
            if (left < 0.0_wp) return
         end do
      end function within_reach

      !> Add an edge's stiffness to its nodes.
      subroutine add_edge(node, k)
         integer, intent(in) :: node(2)
         real(wp), intent(in) :: k

         bound(node) = bound(node) + share*k*norm2(x(:, node(2)) - x(:, node(1)))
      end subroutine add_edge

   end subroutine wall_stiffness_bound

   !> Row sums of the walls' stiffness where they meet now. Where a wall has come to face others, it may bear on one of its nodes
   !> with a short piece that is much stiffer than the rest: the edges' means do not see that.
   pure subroutine point_stiffness_bound(met, stiffness, bound)
      type(wall_meeting_t), intent(in) :: met
      !> Of the closure (points) [Pa/m]
      real(wp), intent(in) :: stiffness(:)
      !> Nodal bound (nodes) [N/m per m of thickness]
      real(wp), intent(inout) :: bound(:)
      !> Sum of the shape functions of both walls
      real(wp), parameter :: both = 2.0_wp
      integer :: i, k

      do k = 1, met%points
         do i = 1, 4
            associate (node => met%point_node(i, k))
               bound(node) = bound(node) + both*met%shape(i, k)*met%weight(k)*stiffness(k)
            end associate
         end do
      end do
   end subroutine point_stiffness_bound

   !> Velocity of the upper wall relative to the lower one along i at an integration point [m/s]; the same for both sides.
   pure real(wp) function wall_slip_rate(met, k, v) result(rate)
      type(wall_meeting_t), intent(in) :: met
      !> Integration point
      integer, intent(in) :: k
      !> Velocity (2, nodes) [m/s]
      real(wp), contiguous, intent(in) :: v(:, :)
      real(wp) :: relative(2)

      associate (node => met%point_node(:, k), n => met%shape(:, k))
         relative = n(1)*v(:, node(1)) + n(2)*v(:, node(2)) - n(3)*v(:, node(3)) - n(4)*v(:, node(4))
      end associate
      rate = dot_product(relative, met%tangent(:, met%wall(k)))
   end function wall_slip_rate

end module wall_contact_m
