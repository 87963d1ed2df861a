!> Contact of facing fracture walls: where each piece of an upper wall meets the other side now.
!>
!> One wall edge of every joint is projected on the surface opposite, starting from the edge it faced last and walking
!> along that surface, so that sliding over any number of elements costs no search. Each overlap of a wall edge with one
!> opposite edge gets two Gauss points; the pressure there is found by the joint's law, and the forces go to the four nodes
!> by their shape functions. Overlaps are exact, so a constant pressure passes between walls whose nodes do not match.
!> The walls continue straight across crossings of fractures and on to the outer boundary.
!>
!> Which wall walks is one choice for each chain of joints: the upper wall A'B', or the lower wall BA where the upper wall
!> has more free surface straight ahead than the lower one, so that what slides off its partner is the wall that walks and
!> what is walked on is the longer side. A wall has its rock on its left: turned by half a turn, a lower wall is an upper
!> wall, and pressure, shear stress and slip keep their signs.
module wall_contact_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   implicit none
   private

   !> Position of the two Gauss points on [0,1]
   real(wp), parameter :: gauss(2) = [0.5_wp - sqrt(1.0_wp/12.0_wp), 0.5_wp + sqrt(1.0_wp/12.0_wp)]
   !> Surfaces face each other when their normals are within 60 degrees of opposite; they continue each other within 60
   real(wp), parameter :: facing_cosine = 0.5_wp
   !> Overlaps shorter than this part of the edge carry nothing worth a division
   real(wp), parameter :: least_overlap = 1.0e-9_wp
   !> Walls that have passed through each other by more than this part of an edge are not in contact but lost
   real(wp), parameter :: deepest = 1.0_wp
   !> The same for the walls of new cracks, whose fragments may go anywhere: beyond it they never were in contact here
   real(wp), parameter :: deepest_crack = 1.0e-3_wp
   !> Contact lets go from this part of the deepest overlap on, so that no force jumps there
   real(wp), parameter, public :: lets_go = 0.5_wp
   !> Longest walk along the opposite surface in one step (edges)
   integer, parameter :: longest_walk = 64

   !> The walls that walk, the surface they walk on, and the integration points found last
   type, public :: wall_contact_t
      !> Joint of each wall edge (walls), its nodes A', B' or B, A (2, walls), surface edge faced last (walls)
      integer, allocatable :: joint(:), node(:, :), facing(:)
      !> +1: the upper wall walks, -1: the lower one (walls)
      integer, allocatable :: side(:)
      !> Surface edges (2, edges), rock on their left; the edges that go on straight from their start and end (0: none)
      integer, allocatable :: surface(:, :), before(:), after(:)
      !> Has a wall come to face another edge since the stable step was last looked at?
      logical :: moved_on = .false.
      !> Current length of each wall edge (walls) [m]; its tangent, i of an upper wall, -i of a lower one (2, walls)
      real(wp), allocatable :: length(:), tangent(:, :)
      !> Overlap over its length beyond which a wall edge is not in contact (walls)
      real(wp), allocatable :: deepest(:)
      !> Integration points: number, wall edge, four nodes (A', B', p, q)
      integer :: points = 0
      integer, allocatable :: wall(:), point_node(:, :)
      !> Shape functions at the four nodes (4, points), weight [m], gap along the normal [m], negative when overlapping
      real(wp), allocatable :: shape(:, :), weight(:), gap(:)
      !> Part of the wall edge each point stands for, from and to (2, points); nodes of the blocks beside that share it at
      !> either end (2, points), 0 where none does
      real(wp), allocatable :: part(:, :)
      integer, allocatable :: beside(:, :)
   end type wall_contact_t

   public :: init_wall_contact, keep_facing, find_overlaps, add_wall_forces, wall_stiffness_bound, wall_slip_rate, &
             surfaces_walked

contains

   !> Set up the wall contact of the given joints. Tips with coinciding ends are allowed.
   subroutine init_wall_contact(split, handled, walls, bonded)
      type(split_mesh_t), intent(in) :: split
      !> Joints whose walls are in wall contact (joints)
      logical, intent(in) :: handled(:)
      type(wall_contact_t), intent(out) :: walls
      !> Joints whose walls are still bonded and no surface yet (joints); none when not given
      logical, intent(in), optional :: bonded(:)
      !> Surface edge of the lower and upper wall of each joint (joints)
      integer, allocatable :: edge_of(:, :)
      logical :: whole(size(handled)), touching(size(handled))
      integer :: j, e, n, w

      whole = .false.
      if (present(bonded)) whole = bonded
      touching = handled .and. .not. whole
      n = count(touching)
      walls%joint = pack([(j, j=1, size(handled))], touching)
      walls%deepest = merge(deepest, deepest_crack, split%joint_group(walls%joint) > 0)
      walls%surface = split%surface
      allocate (walls%length(n), walls%tangent(2, n), source=0.0_wp)
      allocate (edge_of(2, size(handled)), source=0)
      do e = 1, size(split%surface, 2)
         if (split%surface_joint(e) == 0) cycle
         edge_of(merge(1, 2, split%surface_side(e) < 0), split%surface_joint(e)) = e
      end do
      call continue_straight(split, whole, walls%before, walls%after)
      call choose_sides(walls, split, touching, edge_of)
      allocate (walls%node(2, n), walls%facing(n))
      do w = 1, n
         associate (edges => edge_of(:, walls%joint(w)))
            walls%node(:, w) = split%surface(:, merge(edges(2), edges(1), walls%side(w) > 0))
            walls%facing(w) = merge(edges(1), edges(2), walls%side(w) > 0)
         end associate
      end do
      call grow(walls, 4*n + 8)
   end subroutine init_wall_contact

   !> Let the wall edge of a joint go on as it did: the same of its two walls walks, from the edge it faced last.
   pure subroutine keep_facing(walls, split, w, facing, side)
      type(wall_contact_t), intent(inout) :: walls
      type(split_mesh_t), intent(in) :: split
      !> Wall edge, surface edge it faced, and side that walks: +1 upper, -1 lower
      integer, intent(in) :: w, facing, side

      walls%facing(w) = facing
      walls%side(w) = side
      walls%node(:, w) = merge(split%joint(3:4, walls%joint(w)), split%joint([2, 1], walls%joint(w)), side > 0)
   end subroutine keep_facing

   !> Choose for each chain of joints which wall walks: the upper one, unless it has the more free surface ahead.
   subroutine choose_sides(walls, split, handled, edge_of)
      type(wall_contact_t), intent(inout) :: walls
      type(split_mesh_t), intent(in) :: split
      !> Joints whose walls are in wall contact (joints)
      logical, intent(in) :: handled(:)
      !> Surface edge of the lower and upper wall of each joint (2, joints)
      integer, intent(in) :: edge_of(:, :)
      !> A joint of the same chain, at last the one that stands for it (joints)
      integer, allocatable :: chain(:)
      !> Length of the free surface ahead of the lower and upper walls of each chain (2, joints) [m]
      real(wp), allocatable :: ahead(:, :)
      integer :: j, k, next, standing

      allocate (chain(size(handled)))
      chain = [(j, j=1, size(handled))]
      do j = 1, size(handled)
         if (.not. handled(j)) cycle
         do k = 1, 2
            next = walls%after(edge_of(k, j))
            if (next == 0) cycle
            next = split%surface_joint(next)
            if (next == 0) cycle
            if (handled(next)) chain(max(root(chain, j), root(chain, next))) = min(root(chain, j), root(chain, next))
         end do
      end do
      allocate (ahead(2, size(handled)), source=0.0_wp)
      do j = 1, size(handled)
         if (.not. handled(j)) cycle
         standing = root(chain, j)
         do k = 1, 2
            ahead(k, standing) = ahead(k, standing) + length_of(split, free_run(walls%before, split, edge_of(k, j))) &
                                 + length_of(split, free_run(walls%after, split, edge_of(k, j)))
         end do
      end do
      allocate (walls%side(size(walls%joint)))
      do k = 1, size(walls%joint)
         standing = root(chain, walls%joint(k))
         ! Equal but for rounding counts as equal
         walls%side(k) = merge(-1, 1, ahead(2, standing) > (1.0_wp + least_overlap)*ahead(1, standing))
      end do
   end subroutine choose_sides

   !> The joint that stands for a chain.
   pure integer function root(chain, j)
      integer, intent(in) :: chain(:), j

      root = j
      do while (chain(root) /= root)
         root = chain(root)
      end do
   end function root

   !> Free surface edges that follow a wall edge in one direction, as long as they run on as the wall does.
   pure function free_run(neighbour, split, e) result(run)
      !> Next edge in the direction of the walk (surface edges)
      integer, intent(in) :: neighbour(:)
      type(split_mesh_t), intent(in) :: split
      !> Wall edge
      integer, intent(in) :: e
      integer, allocatable :: run(:)
      integer :: next

      allocate (run(0))
      next = neighbour(e)
      do while (next > 0)
         if (split%surface_joint(next) > 0) return
         if (dot_product(direction(split, e), direction(split, next)) < facing_cosine) return
         run = [run, next]
         next = neighbour(next)
      end do
   end function free_run

   !> Length of some surface edges before any motion [m].
   pure real(wp) function length_of(split, edges) result(length)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: edges(:)
      integer :: k

      length = 0.0_wp
      do k = 1, size(edges)
         length = length + norm2(split%x(:, split%surface(2, edges(k))) - split%x(:, split%surface(1, edges(k))))
      end do
   end function length_of

   !> For each surface edge find the edges that continue it most nearly straight, across crossings too.
   subroutine continue_straight(split, bonded, before, after)
      type(split_mesh_t), intent(in) :: split
      !> Joints whose walls nothing may walk on (joints)
      logical, intent(in) :: bonded(:)
      !> Edge that ends where this one starts, edge that starts where this one ends (edges); 0: none
      integer, allocatable, intent(out) :: before(:), after(:)
      integer, allocatable :: first(:), starts(:)
      integer :: e, other, k, end_node, n, best
      real(wp) :: cosine, best_cosine
      logical :: best_joined, joined

      n = size(split%surface, 2)
      allocate (before(n), after(n))
      before = 0
      after = 0
      call edges_by_start(split, first, starts)
      do e = 1, n
         if (held(e)) cycle
         end_node = split%origin(split%surface(2, e))
         best = 0
         best_cosine = facing_cosine
         best_joined = .false.
         do k = first(end_node), first(end_node + 1) - 1
            other = starts(k)
            if (held(other)) cycle
            cosine = dot_product(direction(split, e), direction(split, other))
            if (cosine < facing_cosine) cycle
            ! The surface of the same body goes before that of another block
            joined = split%surface(1, other) == split%surface(2, e)
            if (best_joined .and. .not. joined) cycle
            if ((joined .and. .not. best_joined) .or. cosine > best_cosine) then
               best = other
               best_cosine = cosine
               best_joined = joined
            end if
         end do
         after(e) = best
      end do
      do e = 1, n
         if (after(e) > 0) then
            if (before(after(e)) == 0 .or. split%surface(2, e) == split%surface(1, after(e))) before(after(e)) = e
         end if
      end do

   contains

      !> Is it the wall of a bond, on which nothing may walk, neither forwards nor backwards?
      pure logical function held(edge)
         integer, intent(in) :: edge

         held = .false.
         if (split%surface_joint(edge) > 0) held = bonded(split%surface_joint(edge))
      end function held

   end subroutine continue_straight

   !> Surface edges whose contact belongs to the walls: the walls themselves, and the free surface straight ahead of the
   !> side that is walked on. Their fracture group; 0 for all others (surface edges).
   function surfaces_walked(walls, split) result(group)
      type(wall_contact_t), intent(in) :: walls
      type(split_mesh_t), intent(in) :: split
      integer, allocatable :: group(:)
      !> Side of each joint that walks, 0 without wall contact (joints)
      integer, allocatable :: walking(:)
      integer :: e

      allocate (group(size(split%surface, 2)), source=0)
      allocate (walking(size(split%joint, 2)), source=0)
      walking(walls%joint) = walls%side
      do e = 1, size(group)
         if (split%surface_joint(e) == 0) cycle
         if (walking(split%surface_joint(e)) /= 0) group(e) = split%joint_group(split%surface_joint(e))
      end do
      do e = 1, size(group)
         if (split%surface_joint(e) == 0) cycle
         if (walking(split%surface_joint(e)) /= -split%surface_side(e)) cycle
         call mark(free_run(walls%before, split, e))
         call mark(free_run(walls%after, split, e))
      end do

   contains

      !> Give free edges the group of edge e.
      subroutine mark(run)
         integer, intent(in) :: run(:)

         where (group(run) == 0) group(run) = group(e)
      end subroutine mark

   end function surfaces_walked

   !> Surface edges sorted by the original node they start from (compressed rows).
   subroutine edges_by_start(split, first, starts)
      type(split_mesh_t), intent(in) :: split
      !> Edges starting from original node i: starts(first(i):first(i+1)-1)
      integer, allocatable, intent(out) :: first(:), starts(:)
      integer, allocatable :: next(:)
      integer :: e, node

      allocate (first(maxval(split%origin) + 1), starts(size(split%surface, 2)))
      first = 0
      do e = 1, size(split%surface, 2)
         node = split%origin(split%surface(1, e))
         first(node + 1) = first(node + 1) + 1
      end do
      first(1) = 1
      do node = 2, size(first)
         first(node) = first(node) + first(node - 1)
      end do
      next = first
      do e = 1, size(split%surface, 2)
         node = split%origin(split%surface(1, e))
         starts(next(node)) = e
         next(node) = next(node) + 1
      end do
   end subroutine edges_by_start

   !> Unit vector along a surface edge before any motion.
   pure function direction(split, e)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: e
      real(wp) :: direction(2)

      direction = split%x(:, split%surface(2, e)) - split%x(:, split%surface(1, e))
      direction = direction/sqrt(sum(direction**2))
   end function direction

   !> Find the integration points of all walls for the current displacement.
   subroutine find_overlaps(walls, x, u)
      type(wall_contact_t), intent(inout) :: walls
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      integer :: w, e, steps
      real(wp) :: a(2), b(2), t(2), length, from, to, part(2)
      integer :: beside(2)
      logical :: faces

      walls%points = 0
      do w = 1, size(walls%joint)
         a = x(:, walls%node(1, w)) + u(:, walls%node(1, w))
         b = x(:, walls%node(2, w)) + u(:, walls%node(2, w))
         length = sqrt(sum((b - a)**2))
         t = (b - a)/length
         walls%length(w) = length
         walls%tangent(:, w) = t
         e = walls%facing(w)
         if (e == 0) cycle
         call project(walls, e, x, u, a, t, length, from, to, faces)
         ! Walk until the edge faced last overlaps this one again
         do steps = 1, longest_walk
            if (to > 0.0_wp .and. from < 1.0_wp) exit
            if (to <= 0.0_wp) then
               if (walls%before(e) == 0) exit
               e = walls%before(e)
            else
               if (walls%after(e) == 0) exit
               e = walls%after(e)
            end if
            call project(walls, e, x, u, a, t, length, from, to, faces)
         end do
         if (walls%facing(w) /= e) walls%moved_on = .true.
         walls%facing(w) = e
         call share_edge(walls, e, walls%after(e), walls%before(e), x, u, a, t, length, from, to, part, beside)
         if (faces) call add_points(walls, w, e, x, u, a, b, t, length, from, to, part, beside)
         if (part(1) > 0.0_wp) call walk_on(walls, w, x, u, a, b, t, length, .true.)
         if (part(2) < 1.0_wp) call walk_on(walls, w, x, u, a, b, t, length, .false.)
      end do
   end subroutine find_overlaps

   !> Add the points of the edges that follow the one faced, in one direction, while they still overlap the wall.
   subroutine walk_on(walls, w, x, u, a, b, t, length, ahead)
      type(wall_contact_t), intent(inout) :: walls
      integer, intent(in) :: w
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> Ends, tangent and length of the wall edge
      real(wp), intent(in) :: a(2), b(2), t(2), length
      !> Ahead along the surface, towards A' of the wall, or back?
      logical, intent(in) :: ahead
      integer :: e, last, steps, beside(2)
      real(wp) :: from, to, part(2)
      logical :: faces

      e = walls%facing(w)
      do steps = 1, longest_walk
         last = e
         if (ahead) then
            e = walls%after(last)
         else
            e = walls%before(last)
         end if
         if (e == 0) return
         call project(walls, e, x, u, a, t, length, from, to, faces)
         if (.not. faces) return
         ! The edge walked from is the neighbour it shares with, also where its own surface goes on elsewhere
         if (ahead) then
            call share_edge(walls, e, walls%after(e), last, x, u, a, t, length, from, to, part, beside)
         else
            call share_edge(walls, e, last, walls%before(e), x, u, a, t, length, from, to, part, beside)
         end if
         if (part(2) <= 0.0_wp .or. part(1) >= 1.0_wp) return
         call add_points(walls, w, e, x, u, a, b, t, length, from, to, part, beside)
      end do
   end subroutine walk_on

   !> Part of the wall edge that a surface edge covers, as fractions of the wall edge from A' to B' (beyond [0,1] outside).
   pure subroutine project(walls, e, x, u, a, t, length, from, to, faces)
      type(wall_contact_t), intent(in) :: walls
      integer, intent(in) :: e
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      real(wp), intent(in) :: a(2), t(2), length
      real(wp), intent(out) :: from, to
      !> Do the two edges face each other?
      logical, intent(out) :: faces
      real(wp) :: p(2), q(2)

      p = x(:, walls%surface(1, e)) + u(:, walls%surface(1, e))
      q = x(:, walls%surface(2, e)) + u(:, walls%surface(2, e))
      to = dot_product(p - a, t)/length
      from = dot_product(q - a, t)/length
      faces = (to - from)*length > facing_cosine*sqrt(sum((q - p)**2))
   end subroutine project

   !> Part of the wall edge that belongs to a surface edge: what it covers, but where the surface goes on in another block
   !> that covers some of it too, each block has half of that. So no piece of wall is held twice, and what each edge
   !> holds changes without a jump when blocks pass each other at a crossing.
   pure subroutine share_edge(walls, e, next, previous, x, u, a, t, length, from, to, part, beside)
      type(wall_contact_t), intent(in) :: walls
      !> Surface edge, and its neighbours towards A' and B' of the wall (0: none)
      integer, intent(in) :: e, next, previous
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      real(wp), intent(in) :: a(2), t(2), length
      !> What the surface edge covers
      real(wp), intent(in) :: from, to
      !> From and to; nodes of the other blocks that end there, 0: none
      real(wp), intent(out) :: part(2)
      integer, intent(out) :: beside(2)
      real(wp) :: other_from, other_to
      logical :: faces

      part = [from, to]
      beside = 0
      if (next > 0) then
         if (walls%surface(1, next) /= walls%surface(2, e)) then
            call project(walls, next, x, u, a, t, length, other_from, other_to, faces)
            if (faces .and. other_to > from) then
               part(1) = 0.5_wp*(from + other_to)
               beside(1) = walls%surface(1, next)
            end if
         end if
      end if
      if (previous > 0) then
         if (walls%surface(2, previous) /= walls%surface(1, e)) then
            call project(walls, previous, x, u, a, t, length, other_from, other_to, faces)
            if (faces .and. other_from < to) then
               part(2) = 0.5_wp*(to + other_from)
               beside(2) = walls%surface(2, previous)
            end if
         end if
      end if
   end subroutine share_edge

   !> Two Gauss points on the overlap of a wall edge with a surface edge.
   subroutine add_points(walls, w, e, x, u, a, b, t, length, from, to, part, beside)
      type(wall_contact_t), intent(inout) :: walls
      integer, intent(in) :: w, e
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      real(wp), intent(in) :: a(2), b(2), t(2), length, from, to
      !> Part of the wall edge that belongs to the surface edge
      real(wp), intent(in) :: part(2)
      !> Nodes of the blocks beside that share it, 0: none
      integer, intent(in) :: beside(2)
      real(wp) :: p(2), q(2), low, high, xi, eta, gap
      integer :: g, k, nodes(4)

      low = max(0.0_wp, part(1))
      high = min(1.0_wp, part(2))
      if (high - low < least_overlap) return
      nodes = [walls%node(:, w), walls%surface(:, e)]
      p = x(:, nodes(3)) + u(:, nodes(3))
      q = x(:, nodes(4)) + u(:, nodes(4))
      if (walls%points + 2 > size(walls%wall)) call grow(walls, 2*size(walls%wall))
      do g = 1, 2
         xi = low + (high - low)*gauss(g)
         eta = (to - xi)/(to - from)
         ! The outward normal of a wall is its tangent turned clockwise
         gap = dot_product(p + eta*(q - p) - a - xi*(b - a), [t(2), -t(1)])
         if (gap < -walls%deepest(w)*length) cycle
         k = walls%points + 1
         walls%points = k
         walls%wall(k) = w
         walls%point_node(:, k) = nodes
         walls%shape(:, k) = [1.0_wp - xi, xi, 1.0_wp - eta, eta]
         walls%weight(k) = 0.5_wp*(high - low)*length*held_part(-gap/(walls%deepest(w)*length))
         walls%gap(k) = gap
         walls%part(:, k) = part
         walls%beside(:, k) = beside
      end do
   end subroutine add_points

   !> Part of an overlap that is still in contact, at a depth over the deepest: all of it up to lets_go, then smoothly none.
   pure real(wp) function held_part(depth)
      real(wp), intent(in) :: depth
      real(wp) :: beyond

      beyond = min(1.0_wp, max(0.0_wp, (depth - lets_go)/(1.0_wp - lets_go)))
      held_part = 1.0_wp - beyond**2*(3.0_wp - 2.0_wp*beyond)
   end function held_part

   !> Make room for at least n integration points.
   subroutine grow(walls, n)
      type(wall_contact_t), intent(inout) :: walls
      integer, intent(in) :: n
      integer, allocatable :: wall(:), point_node(:, :), beside(:, :)
      real(wp), allocatable :: shape(:, :), weight(:), gap(:), part(:, :)

      allocate (wall(n), point_node(4, n), shape(4, n), weight(n), gap(n), part(2, n), beside(2, n))
      associate (k => walls%points)
         if (k > 0) then
            wall(:k) = walls%wall(:k)
            point_node(:, :k) = walls%point_node(:, :k)
            shape(:, :k) = walls%shape(:, :k)
            weight(:k) = walls%weight(:k)
            gap(:k) = walls%gap(:k)
            part(:, :k) = walls%part(:, :k)
            beside(:, :k) = walls%beside(:, :k)
         end if
      end associate
      call move_alloc(wall, walls%wall)
      call move_alloc(point_node, walls%point_node)
      call move_alloc(shape, walls%shape)
      call move_alloc(weight, walls%weight)
      call move_alloc(gap, walls%gap)
      call move_alloc(part, walls%part)
      call move_alloc(beside, walls%beside)
   end subroutine grow

   !> Add the forces of given tractions at the integration points to the nodes of both walls (eqs 2, 4 in wall form).
   pure subroutine add_wall_forces(walls, pressure, shear, normal_force, friction_force)
      type(wall_contact_t), intent(in) :: walls
      !> Normal stress, compression positive, and shear stress, positive when it resists positive slip (points) [Pa]
      real(wp), intent(in) :: pressure(:), shear(:)
      !> Nodal forces (2, nodes) [N per m of thickness]: normal and tangential part kept apart for the energy balance
      real(wp), contiguous, intent(inout) :: normal_force(:, :), friction_force(:, :)
      real(wp) :: normal(2), tangent(2)
      integer :: k, i
      real(wp), parameter :: side(4) = [1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp]

      do k = 1, walls%points
         if (pressure(k) <= 0.0_wp) cycle
         ! The wall is pushed into its rock, which lies on its left
         normal = [-walls%tangent(2, walls%wall(k)), walls%tangent(1, walls%wall(k))]*pressure(k)*walls%weight(k)
         tangent = -walls%tangent(:, walls%wall(k))*shear(k)*walls%weight(k)
         do i = 1, 4
            associate (node => walls%point_node(i, k), n => side(i)*walls%shape(i, k))
               normal_force(:, node) = normal_force(:, node) + n*normal
               friction_force(:, node) = friction_force(:, node) + n*tangent
            end associate
         end do
      end do
   end subroutine add_wall_forces

   !> Add the row sums of the walls' stiffness to the nodal bounds (see solid_m). Edges count in full, and the next ones
   !> with them, so that the bound holds until a wall faces another edge.
   subroutine wall_stiffness_bound(walls, x, stiffness, bound)
      type(wall_contact_t), intent(inout) :: walls
      !> Reference coordinates (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :)
      !> The larger of normal and shear stiffness (walls) [Pa/m]
      real(wp), intent(in) :: stiffness(:)
      !> Nodal bound (nodes) [N/m per m of thickness]
      real(wp), intent(inout) :: bound(:)
      !> Sum of the absolute shape functions of both walls, times the half of an edge that each of its nodes has
      real(wp), parameter :: share = 2.0_wp*0.5_wp
      real(wp) :: against(size(walls%surface, 2))
      integer :: w, e

      walls%moved_on = .false.
      against = 0.0_wp
      do w = 1, size(walls%joint)
         e = walls%facing(w)
         if (e == 0) cycle
         call add_edge(walls%node(:, w), stiffness(w))
         against(e) = max(against(e), stiffness(w))
         call raise(walls%before)
         call raise(walls%after)
      end do
      do e = 1, size(against)
         if (against(e) > 0.0_wp) call add_edge(walls%surface(:, e), against(e))
      end do

   contains

      !> Raise the stiffness against the edges that follow edge e within the reach of wall w, and one more.
      subroutine raise(neighbour)
         integer, intent(in) :: neighbour(:)
         integer :: next
         real(wp) :: left

         next = e
         left = norm2(x(:, walls%node(2, w)) - x(:, walls%node(1, w)))
         do
            next = neighbour(next)
            if (next == 0) return
            against(next) = max(against(next), stiffness(w))
            left = left - norm2(x(:, walls%surface(2, next)) - x(:, walls%surface(1, next)))
            if (left < 0.0_wp .or. next == e) return
         end do
      end subroutine raise

      !> Add an edge's stiffness to its nodes.
      subroutine add_edge(node, k)
         integer, intent(in) :: node(2)
         real(wp), intent(in) :: k

         bound(node) = bound(node) + share*k*norm2(x(:, node(2)) - x(:, node(1)))
      end subroutine add_edge

   end subroutine wall_stiffness_bound

   !> Velocity of the upper wall relative to the lower one along i at an integration point [m/s]; the same for both sides.
   pure real(wp) function wall_slip_rate(walls, k, v) result(rate)
      type(wall_contact_t), intent(in) :: walls
      !> Integration point
      integer, intent(in) :: k
      !> Velocity (2, nodes) [m/s]
      real(wp), contiguous, intent(in) :: v(:, :)
      real(wp) :: relative(2)

      associate (node => walls%point_node(:, k), n => walls%shape(:, k))
         relative = n(1)*v(:, node(1)) + n(2)*v(:, node(2)) - n(3)*v(:, node(3)) - n(4)*v(:, node(4))
      end associate
      rate = dot_product(relative, walls%tangent(:, walls%wall(k)))
   end function wall_slip_rate

end module wall_contact_m
