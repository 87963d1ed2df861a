!> General contact between surfaces: which triangles are near each other, when to look again, and the normal and
!> friction forces between them. Objects are the triangles with a node on a surface: the layer under the walls and the
!> outer boundary, as deep as a sound contact ever reaches.
!>
!> Surface edges that another contact law looks after (the joint's own wall contact) are marked by the caller with the
!> number of their fracture group. Two triangles that both touch walls of the same marked group never meet here:
!> wherever these walls slide to, their contact belongs to the other law.
module contact_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use nbs_m, only: find_box_pairs
   use friction_m, only: slide, velocity_friction, friction_slider, friction_velocity
   use potential_m, only: push_t, push_target, pair_penalty, twice_area
   use impact_m, only: impacts_t
   use surfaces_m, only: surfaces_can_meet, groups_at_triangles, groups_t
   implicit none
   private

   !> Choices of the deck's &contact group
   type, public :: contact_options_t
      !> Skin around each triangle over its mean edge length
      real(wp) :: skin_factor = 0.2_wp
      !> Stiffness of the friction spring over the normal contact stiffness (slider law)
      real(wp) :: tangential_factor = 1.0_wp
      !> friction_slider or friction_velocity of friction_m
      integer :: friction = friction_slider
      !> Look where no two surfaces can meet too, and before anything has moved half the skin (checks: the same forces)
      logical :: everywhere = .false., every_time = .false.
      !> Is contact that begins or ends within a step to be noted (impacts of the state; for the explicit solver)?
      logical :: impacts = .false.
   end type contact_options_t

   !> What one call of forces did to the energies
   type, public :: contact_energy_t
      !> Energy of all overlaps now, energy in all friction springs now [J/m]
      real(wp) :: overlap = 0.0_wp, spring = 0.0_wp
      !> Energy that friction spent in this step [J/m]
      real(wp) :: dissipated = 0.0_wp
   end type contact_energy_t

   !> A surface edge (of the target) pushed by a triangle (the contactor)
   type :: touch_t
      !> Surface edge, its object and the contactor's object
      integer :: edge = 0, target = 0, contactor = 0
      !> Which edge of the target it is (1..3), and nodes at its start and end
      integer :: side = 0, from = 0, to = 0
      !> Normal force [N/m], its place along the edge (0..1) and its area coordinates in the contactor
      real(wp) :: normal = 0.0_wp, place = 0.0_wp, lambda(3) = 0.0_wp
      !> Normal stiffness per length of edge [Pa/m]
      real(wp) :: stiffness = 0.0_wp
      !> Slip of the target against the contactor along the edge since the last step [m]
      real(wp) :: slip = 0.0_wp
   end type touch_t

   !> What friction remembers
   type, public :: contact_springs_t
      private
      !> Friction spring of each surface edge: elongation [m], stiffness [N/m per metre of thickness] (surface edges)
      real(wp), allocatable :: elongation(:), stiffness(:)
      !> Displacement of the objects' nodes at the last call of forces (2, layer nodes) [m]
      real(wp), allocatable :: before(:, :)
      !> Energy in all friction springs [J/m]
      real(wp) :: spring_energy = 0.0_wp
   end type contact_springs_t

   !> What the contact remembers, and what it found last
   type, public :: contact_state_t
      private
      !> Searches so far
      integer, public :: searches = 0
      !> Force on each surface edge over the last step: normal (compression positive) and shear, the tangential force on
      !> the rock that owns the edge along the edge's direction (surface edges) [N/m]
      real(wp), allocatable, public :: normal(:), shear(:)
      type(contact_springs_t), public :: springs
      !> Contact that has begun or ended
      type(impacts_t), public :: impacts
      !> Displacement of the objects' nodes at the last search (2, layer nodes) [m]
      real(wp), allocatable :: searched(:, :)
      !> Objects near each other (2, pairs), their penalty [Pa], and the objects that occur in a pair
      integer, allocatable :: pair(:, :), near(:)
      real(wp), allocatable :: pair_penalty(:)
      !> Did any edge carry a force in the last step?
      logical :: loaded = .false.

      !> Room for the present step: boxes of the near objects (4, objects), directions of their surface edges
      !> (2, surface edges)
      real(wp), allocatable :: box(:, :), along(:, :)
      !> Sums of the touches on each edge: normal force, its products with slip and stiffness (surface edges)
      real(wp), allocatable :: load(:), load_slip(:), load_stiffness(:)
      !> Touches of the present step, and their number
      type(touch_t), allocatable :: touch(:)
      integer :: touches = 0
   contains
      procedure :: pairs
      procedure :: values
   end type contact_state_t

   !> Room for touches at first
   integer, parameter :: first_touches = 16

   !> Contact between the surfaces of a split mesh
   type, public :: contact_t
      private
      type(contact_options_t) :: options
      !> Can any two surfaces meet? Else nothing is ever searched or computed.
      logical, public :: possible = .false.
      !> Nodes of each object (3, objects); surface edge each of its edges is, 0 inside the rock (3, objects)
      integer, allocatable :: node(:, :), edge(:, :)
      !> Number of each node that is the same for nodes held together (3, objects)
      integer, allocatable :: same(:, :)
      !> Height of each object over each of its edges (3, objects) [m], its penalty [Pa] and half its skin [m] (objects)
      real(wp), allocatable :: height(:, :), penalty(:), half_skin(:)
      !> Height that the potential rises over from the surface, the least where there is a choice (objects) [m]
      real(wp), allocatable :: surface_height(:)
      !> Groups handled elsewhere that each object touches
      type(groups_t) :: handled
      !> Length of each surface edge [m]
      real(wp), allocatable :: length(:)
      !> Nodes of the objects; how far each may move before the next search [m]
      integer, allocatable :: layer(:)
      real(wp), allocatable :: reach(:)
      !> Place of each node in layer, 0 for the others (nodes)
      integer, allocatable :: place(:)
   contains
      procedure :: init
      procedure :: start
      procedure :: needs_search
      procedure :: search
      procedure :: forces
      procedure :: carry_on
      procedure :: add_stiffness
      procedure :: joint_tractions
      procedure :: recall
      procedure :: restore_state
   end type contact_t

contains

   !> Collect the objects.
   subroutine init(self, split, penalty, handled, options, same)
      class(contact_t), intent(out) :: self
      type(split_mesh_t), intent(in) :: split
      !> Penalty of each triangle's rock (triangles) [Pa]
      real(wp), intent(in) :: penalty(:)
      !> Fracture group of each surface edge whose contact another law handles, 0 for the others (surface edges)
      integer, intent(in) :: handled(:)
      type(contact_options_t), intent(in) :: options
      !> Number that is the same for nodes held together: triangles that share one never meet (nodes)
      integer, intent(in), optional :: same(:)
      integer, allocatable :: object_of(:), chosen(:), number(:)
      integer :: i, k, edges

      self%options = options
      edges = size(split%surface, 2)
      allocate (self%length(edges))
      number = [(i, i=1, size(split%x, 2))]
      if (present(same)) number = same
      self%possible = options%everywhere
      if (.not. self%possible) self%possible = surfaces_can_meet(split, handled, number)

      call choose_objects(split, chosen, object_of)
      allocate (self%node(3, size(chosen)), self%edge(3, size(chosen)), self%height(3, size(chosen)))
      self%node = split%triangle(:, chosen)
      self%penalty = penalty(chosen)
      self%same = reshape(number(reshape(self%node, [size(self%node)])), shape(self%node))
      self%edge = 0
      do i = 1, edges
         associate (object => object_of(split%surface_triangle(i)))
            do k = 1, 3
               if (self%node(k, object) == split%surface(1, i)) self%edge(k, object) = i
            end do
         end associate
         self%length(i) = norm2(split%x(:, split%surface(2, i)) - split%x(:, split%surface(1, i)))
      end do
      self%handled = groups_at_triangles(split, handled, number, chosen)
      call measure(self, split)
   end subroutine init

   !> Nothing is searched yet, nothing touches.
   subroutine start(self, now)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(out) :: now

      associate (edges => size(self%length), layer => size(self%layer))
         allocate (now%normal(edges), now%shear(edges), now%springs%elongation(edges), now%springs%stiffness(edges), &
                   now%along(2, edges), now%load(edges), now%load_slip(edges), now%load_stiffness(edges), &
                   now%searched(2, layer), now%springs%before(2, layer), now%box(4, size(self%penalty)), source=0.0_wp)
      end associate
      allocate (now%pair(2, 0), now%near(0), now%pair_penalty(0))
      allocate (now%touch(first_touches))
      if (self%options%impacts) call now%impacts%start(size(self%penalty))
   end subroutine start

   !> Triangles with a node on a surface.
   subroutine choose_objects(split, chosen, object_of)
      type(split_mesh_t), intent(in) :: split
      !> Triangle of each object (objects); object of each triangle, 0 for none (triangles)
      integer, allocatable, intent(out) :: chosen(:), object_of(:)
      logical, allocatable :: on_surface(:)
      integer :: i, n

      allocate (on_surface(size(split%x, 2)), object_of(size(split%triangle, 2)))
      on_surface = .false.
      do i = 1, size(split%surface, 2)
         on_surface(split%surface(:, i)) = .true.
      end do
      object_of = 0
      n = 0
      do i = 1, size(split%triangle, 2)
         if (.not. any(on_surface(split%triangle(:, i)))) cycle
         n = n + 1
         object_of(i) = n
      end do
      allocate (chosen(n))
      do i = 1, size(object_of)
         if (object_of(i) > 0) chosen(object_of(i)) = i
      end do
   end subroutine choose_objects

   !> Heights and skins of the objects; their nodes and how far these may move.
   subroutine measure(self, split)
      class(contact_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: split
      real(wp), allocatable :: reach(:)
      real(wp) :: corner(2, 3), side(3)
      integer :: i, k, n

      allocate (reach(size(split%x, 2)), self%half_skin(size(self%node, 2)), &
                self%surface_height(size(self%node, 2)))
      ! Nodes of no object keep this and are told by it
      reach = huge(1.0_wp)
      do i = 1, size(self%node, 2)
         corner = split%x(:, self%node(:, i))
         do k = 1, 3
            side(k) = norm2(corner(:, mod(k, 3) + 1) - corner(:, k))
         end do
         self%height(:, i) = twice_area(corner)/side
         self%surface_height(i) = minval(self%height(:, i), mask=self%edge(:, i) > 0)
         if (all(self%edge(:, i) == 0)) self%surface_height(i) = minval(self%height(:, i))
         self%half_skin(i) = 0.5_wp*self%options%skin_factor*sum(side)/3.0_wp
         reach(self%node(:, i)) = min(reach(self%node(:, i)), self%half_skin(i))
      end do
      n = count(reach < huge(1.0_wp))
      allocate (self%layer(n), self%place(size(reach)))
      self%layer = pack([(i, i=1, size(reach))], reach < huge(1.0_wp))
      self%reach = reach(self%layer)
      self%place = 0
      self%place(self%layer) = [(i, i=1, n)]
   end subroutine measure

   !> Has any node of an object moved further than half the skin since the last search (or was there none yet)?
   pure logical function needs_search(self, now, displacement)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(in) :: now
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      integer :: i

      needs_search = self%possible .and. (now%searches == 0 .or. self%options%every_time)
      if (needs_search .or. .not. self%possible) return
      do i = 1, size(self%layer)
         associate (node => self%layer(i))
            needs_search = (displacement(1, node) - now%searched(1, i))**2 &
                           + (displacement(2, node) - now%searched(2, i))**2 > self%reach(i)**2
         end associate
         if (needs_search) return
      end do
   end function needs_search

   !> Find the pairs of objects that can touch before the next search. Friction springs belong to surface edges, not to
   !> pairs, and live on.
   subroutine search(self, split, displacement, now)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      type(contact_state_t), intent(inout) :: now
      real(wp), allocatable :: box(:, :)
      integer, allocatable :: candidate(:, :)
      logical, allocatable :: keep(:), is_near(:)
      real(wp) :: a(2, 3), b(2, 3)
      integer :: i

      if (.not. self%possible) return
      now%searches = now%searches + 1
      now%searched = displacement(:, self%layer)
      ! While there were no pairs, forces did not follow the motion
      if (size(now%pair, 2) == 0) now%springs%before = now%searched
      allocate (box(4, size(self%node, 2)))
      do i = 1, size(box, 2)
         a = split%x(:, self%node(:, i)) + displacement(:, self%node(:, i))
         box(:, i) = bounds(a) + self%half_skin(i)*[-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
      end do
      call find_box_pairs(box, candidate)

      allocate (keep(size(candidate, 2)), is_near(size(box, 2)))
      is_near = .false.
      do i = 1, size(candidate, 2)
         associate (first => candidate(1, i), second => candidate(2, i))
            keep(i) = .false.
            if (share_node(self%same(:, first), self%same(:, second))) cycle
            if (self%handled%share(first, second)) cycle
            a = split%x(:, self%node(:, first)) + displacement(:, self%node(:, first))
            b = split%x(:, self%node(:, second)) + displacement(:, self%node(:, second))
            keep(i) = .not. apart(a, b, self%half_skin(first) + self%half_skin(second))
            if (keep(i)) is_near(candidate(:, i)) = .true.
         end associate
      end do
      now%near = pack([(i, i=1, size(is_near))], is_near)
      call keep_pairs(self, candidate, keep, now)
   end subroutine search

   !> Store the pairs that passed, with their penalties.
   subroutine keep_pairs(self, candidate, keep, now)
      class(contact_t), intent(in) :: self
      !> Pairs of objects (2, candidates) and whether they are kept (candidates)
      integer, intent(in) :: candidate(:, :)
      logical, intent(in) :: keep(:)
      type(contact_state_t), intent(inout) :: now
      integer :: i, n

      deallocate (now%pair, now%pair_penalty)
      allocate (now%pair(2, count(keep)), now%pair_penalty(count(keep)))
      n = 0
      do i = 1, size(keep)
         if (.not. keep(i)) cycle
         n = n + 1
         now%pair(:, n) = candidate(:, i)
         now%pair_penalty(n) = pair_penalty(self%penalty(candidate(1, i)), self%penalty(candidate(2, i)))
      end do
   end subroutine keep_pairs

   !> Go on as another contact of the same rock did whose mesh had fewer cuts: its springs, energy and last displacements.
   subroutine carry_on(self, old, before_cut, old_edge, edge, parent, split, displacement, now)
      class(contact_t), intent(in) :: self
      class(contact_t), intent(in) :: old
      !> State of the old contact
      type(contact_state_t), intent(in) :: before_cut
      !> Numbers of the surface edges of the old contact and of this one that both meshes understand, 0 for those that are none
      !> any more (surface edges)
      integer, intent(in) :: old_edge(:), edge(:)
      !> Node of the old mesh that each node was (nodes)
      integer, intent(in) :: parent(:)
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      type(contact_state_t), intent(out) :: now
      integer, allocatable :: was(:)
      integer :: i, before

      call self%start(now)
      call self%search(split, displacement, now)
      now%searches = before_cut%searches + 1
      now%springs%spring_energy = before_cut%springs%spring_energy
      now%loaded = before_cut%loaded
      allocate (was(max(maxval(edge), maxval(old_edge))), source=0)
      do i = 1, size(old_edge)
         if (old_edge(i) > 0) was(old_edge(i)) = i
      end do
      do i = 1, size(edge)
         if (was(edge(i)) == 0) cycle
         now%springs%elongation(i) = before_cut%springs%elongation(was(edge(i)))
         now%springs%stiffness(i) = before_cut%springs%stiffness(was(edge(i)))
         now%normal(i) = before_cut%normal(was(edge(i)))
         now%shear(i) = before_cut%shear(was(edge(i)))
      end do
      do i = 1, size(self%layer)
         before = old%place(parent(self%layer(i)))
         now%springs%before(:, i) = displacement(:, self%layer(i))
         if (before > 0) now%springs%before(:, i) = before_cut%springs%before(:, before)
      end do
      if (self%options%impacts) call now%impacts%carry_on(before_cut%impacts, same_objects(self, old, parent), self%node)
   end subroutine carry_on

   !> The object that each object of another contact has become, 0 for none (objects of the other one).
   pure function same_objects(self, old, parent) result(object)
      class(contact_t), intent(in) :: self, old
      !> Node of the old mesh that each node was (nodes)
      integer, intent(in) :: parent(:)
      integer :: object(size(old%node, 2))
      !> First object at each old node, as its first corner, and the next one there (objects)
      integer :: first(size(old%place)), next(size(self%node, 2))
      integer :: i, k

      first = 0
      do i = 1, size(next)
         associate (corner => parent(self%node(1, i)))
            next(i) = first(corner)
            first(corner) = i
         end associate
      end do
      object = 0
      do i = 1, size(object)
         k = first(old%node(1, i))
         do while (k > 0)
            if (all(parent(self%node(:, k)) == old%node(:, i))) object(i) = k
            k = next(k)
         end do
      end do
   end function same_objects

   !> Number of pairs near each other since the last search.
   pure integer function pairs(now)
      class(contact_state_t), intent(in) :: now

      pairs = size(now%pair, 2)
   end function pairs

   !> Add normal and friction forces to the nodal forces. Call search first whenever needs_search says so. The slip of
   !> the slider law is taken from the displacements since the last call: a second call at the same place changes
   !> nothing.
   subroutine forces(self, split, displacement, velocity, friction, now, normal_force, friction_force, energy)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement [m] and velocity [m/s] of every node (2, nodes); velocities matter to the velocity law alone
      real(wp), intent(in), contiguous :: displacement(:, :), velocity(:, :)
      !> Friction coefficient of each surface edge (surface edges): mu of eq 4, mu_mob of eq 33
      real(wp), intent(in) :: friction(:)
      type(contact_state_t), intent(inout) :: now
      !> Normal and tangential contact forces on every node, kept apart for the energy balance (2, nodes) [N/m]
      real(wp), intent(inout), contiguous :: normal_force(:, :), friction_force(:, :)
      type(contact_energy_t), intent(out) :: energy

      if (size(now%pair, 2) == 0 .and. .not. now%loaded) then
         call now%impacts%forget()
         return
      end if
      now%normal = 0.0_wp
      now%shear = 0.0_wp
      call place_objects(self, split, displacement, now)
      if (self%options%impacts) call now%impacts%begin()
      call push_pairs(self, split, displacement, now, normal_force, energy%overlap)
      if (self%options%impacts) call now%impacts%compare(split%x, displacement, now%springs%before, self%place)
      call rub(self, displacement, velocity, friction, now, friction_force, energy%dissipated)
      energy%spring = now%springs%spring_energy
      now%loaded = now%touches > 0
      call remember(self, displacement, now)
   end subroutine forces

   !> Boxes and edge directions of the objects that have a neighbour.
   pure subroutine place_objects(self, split, displacement, now)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in), contiguous :: displacement(:, :)
      type(contact_state_t), intent(inout) :: now
      real(wp) :: corner(2, 3)
      integer :: i, k

      do i = 1, size(now%near)
         associate (object => now%near(i))
            do k = 1, 3
               corner(:, k) = split%x(:, self%node(k, object)) + displacement(:, self%node(k, object))
            end do
            now%box(:, object) = bounds(corner)
            do k = 1, 3
               if (self%edge(k, object) == 0) cycle
               now%along(:, self%edge(k, object)) = direction(corner(:, k), corner(:, mod(k, 3) + 1))
            end do
         end associate
      end do
   end subroutine place_objects

   !> Unit vector from one point to another.
   pure function direction(from, to)
      real(wp), intent(in) :: from(2), to(2)
      real(wp) :: direction(2)

      direction = to - from
      direction = direction/sqrt(direction(1)**2 + direction(2)**2)
   end function direction

   !> Keep the displacements for the slip of the next call.
   pure subroutine remember(self, displacement, now)
      class(contact_t), intent(in) :: self
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in), contiguous :: displacement(:, :)
      type(contact_state_t), intent(inout) :: now
      integer :: i

      do i = 1, size(self%layer)
         now%springs%before(:, i) = displacement(:, self%layer(i))
      end do
   end subroutine remember

   !> Normal forces of all pairs, both roles; and the list of surface edges that are touched.
   subroutine push_pairs(self, split, displacement, now, force, overlap_energy)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in), contiguous :: displacement(:, :)
      type(contact_state_t), intent(inout) :: now
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout), contiguous :: force(:, :)
      !> Energy of all overlaps [J/m]
      real(wp), intent(out) :: overlap_energy
      real(wp) :: corner(2, 3, 2)
      type(push_t) :: push
      integer :: i, k, role, target, contactor

      now%touches = 0
      overlap_energy = 0.0_wp
      do i = 1, size(now%pair, 2)
         associate (a => now%pair(1, i), b => now%pair(2, i))
            if (now%box(1, a) > now%box(2, b) .or. now%box(1, b) > now%box(2, a)) cycle
            if (now%box(3, a) > now%box(4, b) .or. now%box(3, b) > now%box(4, a)) cycle
            call place_corners(split%x, displacement, self%node(:, a), self%node(:, b), corner)
         end associate
         do role = 1, 2
            call push_target(corner(:, :, role), corner(:, :, 3 - role), now%pair_penalty(i), push)
            if (push%energy <= 0.0_wp .and. max(push%normal(1), push%normal(2), push%normal(3)) <= 0.0_wp) cycle
            target = now%pair(role, i)
            contactor = now%pair(3 - role, i)
            overlap_energy = overlap_energy + push%energy
            do k = 1, 3
               associate (own => self%node(k, target), other => self%node(k, contactor))
                  force(:, own) = force(:, own) + push%target_force(:, k)
                  force(:, other) = force(:, other) + push%contactor_force(:, k)
               end associate
            end do
            call list_touches(self, target, contactor, now%pair_penalty(i), push, now)
            if (self%options%impacts) &
               call now%impacts%note(target, contactor, self%node(:, target), self%node(:, contactor), push%target_force, &
                                     push%contactor_force, push%energy)
         end do
      end do
   end subroutine push_pairs

   !> Corners of two triangles measured from the first corner of the first: the differences of original coordinates and
   !> of displacements are taken apart, so that a small penetration keeps its digits far from the origin.
   pure subroutine place_corners(x, displacement, first, second, corner)
      !> Original coordinates and displacement of every node (2, nodes) [m]
      real(wp), intent(in), contiguous :: x(:, :), displacement(:, :)
      !> Nodes of both triangles (3)
      integer, intent(in) :: first(3), second(3)
      !> Corners (2, 3, 2) [m]
      real(wp), intent(out) :: corner(2, 3, 2)
      integer :: k

      do k = 1, 3
         corner(:, k, 1) = (x(:, first(k)) - x(:, first(1))) + (displacement(:, first(k)) - displacement(:, first(1)))
         corner(:, k, 2) = (x(:, second(k)) - x(:, first(1))) + (displacement(:, second(k)) - displacement(:, first(1)))
      end do
   end subroutine place_corners

   !> Append the pushed edges of a target that are surface edges.
   subroutine list_touches(self, target, contactor, penalty, push, now)
      class(contact_t), intent(in) :: self
      !> Objects
      integer, intent(in) :: target, contactor
      !> Penalty of the pair [Pa]
      real(wp), intent(in) :: penalty
      type(push_t), intent(in) :: push
      type(contact_state_t), intent(inout) :: now
      type(touch_t), allocatable :: longer(:)
      integer :: side

      do side = 1, 3
         if (self%edge(side, target) == 0 .or. push%normal(side) <= 0.0_wp) cycle
         if (now%touches == size(now%touch)) then
            allocate (longer(2*now%touches))
            longer(:now%touches) = now%touch
            call move_alloc(longer, now%touch)
         end if
         now%touches = now%touches + 1
         associate (touch => now%touch(now%touches))
            touch%edge = self%edge(side, target)
            touch%target = target
            touch%contactor = contactor
            touch%side = side
            touch%from = self%node(side, target)
            touch%to = self%node(mod(side, 3) + 1, target)
            touch%normal = push%normal(side)
            touch%place = push%place(side)
            touch%lambda = push%lambda(:, side)
            touch%stiffness = 3.0_wp*penalty/self%surface_height(contactor)
         end associate
      end do
   end subroutine list_touches

   !> Friction of all touched edges. The spring belongs to the edge, so that sliding from one contactor to the next
   !> carries its force along; its slip is the mean over the edge's touches weighted with their normal forces.
   subroutine rub(self, displacement, velocity, friction, now, force, dissipated)
      class(contact_t), intent(in) :: self
      !> Displacement [m] and velocity [m/s] of every node (2, nodes)
      real(wp), intent(in), contiguous :: displacement(:, :), velocity(:, :)
      !> Friction coefficient (surface edges)
      real(wp), intent(in) :: friction(:)
      type(contact_state_t), intent(inout) :: now
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout), contiguous :: force(:, :)
      !> Energy spent in this step [J/m]
      real(wp), intent(out) :: dissipated
      real(wp) :: tangential
      integer :: i

      now%load = 0.0_wp
      now%load_slip = 0.0_wp
      now%load_stiffness = 0.0_wp
      do i = 1, now%touches
         associate (touch => now%touch(i))
            touch%slip = dot_product(slip_of(self, displacement, touch) - slip_before(self, now, touch), &
                                     now%along(:, touch%edge))
            now%load(touch%edge) = now%load(touch%edge) + touch%normal
            now%load_slip(touch%edge) = now%load_slip(touch%edge) + touch%normal*touch%slip
            now%load_stiffness(touch%edge) = now%load_stiffness(touch%edge) + touch%normal*touch%stiffness
         end associate
      end do

      dissipated = 0.0_wp
      if (self%options%friction == friction_slider) call work_springs(self, friction, now, dissipated)

      do i = 1, now%touches
         associate (touch => now%touch(i), edge => now%touch(i)%edge)
            if (self%options%friction == friction_velocity) then
               tangential = velocity_friction(friction(edge)*touch%normal, &
                                              dot_product(slip_of(self, velocity, touch), now%along(:, edge)))
               dissipated = dissipated + tangential*touch%slip
            else
               tangential = now%springs%stiffness(edge)*now%springs%elongation(edge)*touch%normal/now%load(edge)
            end if
            call drag(self, touch, -tangential*now%along(:, edge), force)
            call credit(self, touch, -tangential, now)
         end associate
      end do
   end subroutine rub

   !> Stretch the friction springs of all surface edges. An edge that has lost its contact lets go of its spring.
   subroutine work_springs(self, friction, now, dissipated)
      class(contact_t), intent(in) :: self
      !> Friction coefficient (surface edges)
      real(wp), intent(in) :: friction(:)
      type(contact_state_t), intent(inout) :: now
      !> Energy spent [J/m]
      real(wp), intent(inout) :: dissipated
      real(wp) :: stiffness, tangential, stored, spent
      integer :: edge

      do edge = 1, size(now%load)
         if (now%load(edge) > 0.0_wp) then
            ! A contactor of another size comes under the edge: the force goes on, the elongation follows
            stiffness = self%options%tangential_factor*self%length(edge)*now%load_stiffness(edge)/now%load(edge)
            tangential = now%springs%stiffness(edge)*now%springs%elongation(edge)
            now%springs%spring_energy = now%springs%spring_energy - 0.5_wp*tangential*now%springs%elongation(edge)
            now%springs%elongation(edge) = tangential/stiffness
            now%springs%spring_energy = now%springs%spring_energy + 0.5_wp*tangential*now%springs%elongation(edge)
            now%springs%stiffness(edge) = stiffness
            call slide(stiffness, friction(edge)*now%load(edge), now%load_slip(edge)/now%load(edge), &
                       now%springs%elongation(edge), tangential, stored, spent)
         else if (now%springs%stiffness(edge) > 0.0_wp) then
            call slide(now%springs%stiffness(edge), 0.0_wp, 0.0_wp, now%springs%elongation(edge), tangential, stored, spent)
            now%springs%stiffness(edge) = 0.0_wp
         else
            cycle
         end if
         now%springs%spring_energy = now%springs%spring_energy + stored
         dissipated = dissipated + spent
      end do
   end subroutine work_springs

   !> Motion of the target against the contactor at the place of the normal force, from a nodal field.
   pure function slip_of(self, field, touch) result(slip)
      class(contact_t), intent(in) :: self
      !> Displacement [m] or velocity [m/s] of every node (2, nodes)
      real(wp), intent(in), contiguous :: field(:, :)
      type(touch_t), intent(in) :: touch
      real(wp) :: slip(2)
      integer :: k

      slip = (1.0_wp - touch%place)*field(:, touch%from) + touch%place*field(:, touch%to)
      do k = 1, 3
         slip = slip - touch%lambda(k)*field(:, self%node(k, touch%contactor))
      end do
   end function slip_of

   !> The same from the displacements at the last call.
   pure function slip_before(self, now, touch) result(slip)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(in) :: now
      type(touch_t), intent(in) :: touch
      real(wp) :: slip(2)
      integer :: k

      slip = (1.0_wp - touch%place)*now%springs%before(:, self%place(touch%from)) &
             + touch%place*now%springs%before(:, self%place(touch%to))
      do k = 1, 3
         slip = slip - touch%lambda(k)*now%springs%before(:, self%place(self%node(k, touch%contactor)))
      end do
   end function slip_before

   !> A force on the target at a touched place, and its reaction on the contactor, to their nodes: both act at one
   !> point, so that momentum and moment of momentum are kept.
   pure subroutine drag(self, touch, pull, force)
      class(contact_t), intent(in) :: self
      type(touch_t), intent(in) :: touch
      !> Force on the target (2) [N/m]
      real(wp), intent(in) :: pull(2)
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout), contiguous :: force(:, :)
      integer :: k

      force(:, touch%from) = force(:, touch%from) + (1.0_wp - touch%place)*pull
      force(:, touch%to) = force(:, touch%to) + touch%place*pull
      do k = 1, 3
         associate (node => self%node(k, touch%contactor))
            force(:, node) = force(:, node) - touch%lambda(k)*pull
         end associate
      end do
   end subroutine drag

   !> Book a touch on the surface edge of the target, and its reaction on the contactor's surface edge that faces it
   !> best.
   pure subroutine credit(self, touch, shear, now)
      class(contact_t), intent(in) :: self
      type(touch_t), intent(in) :: touch
      !> Tangential force on the target along its edge [N/m]
      real(wp), intent(in) :: shear
      type(contact_state_t), intent(inout) :: now
      real(wp) :: along(2), facing(2), reaction(2), cosine, best
      integer :: k, edge

      now%normal(touch%edge) = now%normal(touch%edge) + touch%normal
      now%shear(touch%edge) = now%shear(touch%edge) + shear
      along = now%along(:, touch%edge)
      best = 0.0_wp
      edge = 0
      do k = 1, 3
         if (self%edge(k, touch%contactor) == 0) cycle
         cosine = -dot_product(now%along(:, self%edge(k, touch%contactor)), along)
         if (cosine <= best) cycle
         best = cosine
         edge = self%edge(k, touch%contactor)
      end do
      if (edge == 0) return
      facing = now%along(:, edge)
      reaction = touch%normal*[along(2), -along(1)] - shear*along
      now%normal(edge) = now%normal(edge) - dot_product(reaction, [facing(2), -facing(1)])
      now%shear(edge) = now%shear(edge) + dot_product(reaction, facing)
   end subroutine credit

   !> Add to each node a bound of the contact stiffness it can feel before the next search, such that the largest
   !> frequency of nodes on contact alone obeys omega**2 <= max(stiffness/mass).
   !>
   !> A length dl of contact is a spring 3 p/H dl between the edge and the contactor, with weights N on the edge's nodes
   !> and lambda on the contactor's, each adding up to 1. The sum of the norms of a node's row of 2 x 2 blocks
   !> (Gershgorin) is 2 (3 p/H) integral of N dl = (3 p/H) L for an edge touched over all its length; the contactor's
   !> nodes get as much from the edges that lie along its own surface edge. Both roles of each surface edge are added,
   !> with the stiffest neighbour found by the search. Normal and friction springs act at right angles: the stiffer
   !> counts. The bound supposes penetrations that are small against the height of the triangles.
   subroutine add_stiffness(self, now, stiffness)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(in) :: now
      !> Stiffness of each node (nodes) [N/m per metre of thickness]
      real(wp), intent(inout) :: stiffness(:)
      real(wp), allocatable :: steepest(:)
      real(wp) :: factor
      integer :: i, k, role

      ! The steepest spring per length that each object meets, as target and as contactor
      allocate (steepest(size(self%node, 2)))
      steepest = 0.0_wp
      do i = 1, size(now%pair, 2)
         do role = 1, 2
            associate (own => now%pair(role, i), other => now%pair(3 - role, i))
               steepest(own) = max(steepest(own), 3.0_wp*now%pair_penalty(i)*(1.0_wp/minval(self%height(:, own)) &
                                                                              + 1.0_wp/minval(self%height(:, other))))
            end associate
         end do
      end do
      factor = 1.0_wp
      if (self%options%friction == friction_slider) factor = max(1.0_wp, self%options%tangential_factor)
      do i = 1, size(self%node, 2)
         do k = 1, 3
            if (self%edge(k, i) == 0) cycle
            associate (ends => self%node([k, mod(k, 3) + 1], i))
               stiffness(ends) = stiffness(ends) + factor*steepest(i)*self%length(self%edge(k, i))
            end associate
         end do
      end do
   end subroutine add_stiffness

   !> Contact tractions of each joint element (eqs 32-33 want them), taken on the upper wall as in wall contact: when the
   !> walls have slid, part of the lower wall is bare and part of the load is on the rock beyond it.
   pure subroutine joint_tractions(self, now, split, normal, shear)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(in) :: now
      type(split_mesh_t), intent(in) :: split
      !> Normal stress, compression positive, and shear stress, positive when it resists the upper wall's motion along
      !> A'->B' (joints) [Pa]
      real(wp), intent(out) :: normal(:), shear(:)
      integer :: edge, joint

      normal = 0.0_wp
      shear = 0.0_wp
      do edge = 1, size(self%length)
         joint = split%surface_joint(edge)
         if (joint == 0 .or. split%surface_side(edge) <= 0) cycle
         normal(joint) = now%normal(edge)/self%length(edge)
         ! The wall is directed with its rock on the left, where the resistance to that motion is negative
         shear(joint) = -now%shear(edge)/self%length(edge)
      end do
   end subroutine joint_tractions

   !> What friction remembers now, for a return to it. Pairs stay those of the last search: they carry no history.
   pure subroutine recall(self, now, displacement, springs)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(in) :: now
      !> Displacement of every node now (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      type(contact_springs_t), intent(out) :: springs

      springs = now%springs
      ! While there were no pairs, forces did not follow the motion
      if (size(now%pair, 2) == 0) springs%before = displacement(:, self%layer)
   end subroutine recall

   !> What a checkpoint needs of the contact: the forces on the edges, springs, last displacements, and where the surfaces
   !> were at the last search, from which the same pairs are found again in the same order.
   pure function values(now) result(list)
      class(contact_state_t), intent(in) :: now
      real(wp), allocatable :: list(:)

      list = [now%springs%spring_energy, real(now%searches, wp), now%normal, now%shear, now%springs%elongation, &
              now%springs%stiffness, reshape(now%springs%before, [size(now%springs%before)]), &
              reshape(now%searched, [size(now%searched)])]
   end function values

   !> Go on from a checkpoint exactly as if there had been none: search the pairs where they were searched last, continue
   !> the springs. False when the values do not fit.
   logical function restore_state(self, split, values, now) result(fits)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> What values gave
      real(wp), intent(in) :: values(:)
      type(contact_state_t), intent(inout) :: now
      integer, parameter :: single_values = 2, edge_arrays = 4, node_arrays = 2
      real(wp) :: displacement(2, size(split%x, 2)), normal_force(2, size(split%x, 2)), energy
      integer :: edges, first, searches

      edges = size(now%springs%elongation)
      fits = size(values) == single_values + edge_arrays*edges + node_arrays*size(now%springs%before)
      if (.not. fits) return
      searches = nint(values(2))
      if (searches > 0) then
         displacement = 0.0_wp
         displacement(:, self%layer) = reshape(values(size(values) - size(now%searched) + 1:), shape(now%searched))
         call self%search(split, displacement, now)
      end if
      now%searches = searches
      now%springs%spring_energy = values(1)
      first = single_values
      now%normal = values(first + 1:first + edges)
      now%shear = values(first + edges + 1:first + 2*edges)
      now%springs%elongation = values(first + 2*edges + 1:first + 3*edges)
      now%springs%stiffness = values(first + 3*edges + 1:first + edge_arrays*edges)
      first = first + edge_arrays*edges
      now%springs%before = reshape(values(first + 1:first + size(now%springs%before)), shape(now%springs%before))
      now%loaded = any(now%normal > 0.0_wp)
      if (.not. self%options%impacts) return
      ! The overlaps of the last step, found again where it left them
      displacement = 0.0_wp
      displacement(:, self%layer) = now%springs%before
      normal_force = 0.0_wp
      call now%impacts%forget()
      call place_objects(self, split, displacement, now)
      call push_pairs(self, split, displacement, now, normal_force, energy)
   end function restore_state

   !> Box around a triangle: xmin, xmax, ymin, ymax.
   pure function bounds(corner) result(box)
      real(wp), intent(in) :: corner(2, 3)
      real(wp) :: box(4)

      box = [min(corner(1, 1), corner(1, 2), corner(1, 3)), max(corner(1, 1), corner(1, 2), corner(1, 3)), &
             min(corner(2, 1), corner(2, 2), corner(2, 3)), max(corner(2, 1), corner(2, 2), corner(2, 3))]
   end function bounds

   pure logical function share_node(a, b)
      integer, intent(in) :: a(3), b(3)
      integer :: i

      share_node = .false.
      do i = 1, 3
         share_node = share_node .or. any(a == b(i))
      end do
   end function share_node

   !> Does an edge of either triangle have the other one beyond it by more than a gap?
   pure logical function apart(a, b, gap)
      !> Corners, anticlockwise (2, 3) [m]
      real(wp), intent(in) :: a(2, 3), b(2, 3)
      !> Gap [m]
      real(wp), intent(in) :: gap

      apart = beyond(a, b, gap)
      if (.not. apart) apart = beyond(b, a, gap)
   end function apart

   !> Is the second triangle beyond an edge of the first by more than a gap?
   pure logical function beyond(a, b, gap)
      real(wp), intent(in) :: a(2, 3), b(2, 3), gap
      real(wp) :: along(2)
      integer :: k

      beyond = .false.
      do k = 1, 3
         along = a(:, mod(k, 3) + 1) - a(:, k)
         along = along/norm2(along)
         beyond = beyond .or. minval(along(2)*(b(1, :) - a(1, k)) - along(1)*(b(2, :) - a(2, k))) > gap
      end do
   end function beyond

end module contact_m
