!> General contact between surfaces: which triangles are near each other, when to look again, and the normal and
!> friction forces between them. Objects are the triangles with a node on a surface: the layer under the walls and the
!> outer boundary, as deep as a sound contact ever reaches.
!>
!> Surface edges that another contact law looks after (the joint's own wall contact) are marked by the caller with the
!> number of their fracture group. Two triangles that both touch walls of the same marked group never meet here: wherever
!> these walls slide to, their contact belongs to the other law.
module contact_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use nbs_m, only: find_overlaps
   use friction_m, only: slide, velocity_friction, friction_slider, friction_velocity
   use potential_m, only: push_t, push_target, pair_penalty, twice_area
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
      !> Which edge of the target it is (1..3)
      integer :: side = 0
      !> Normal force [N/m], its place along the edge (0..1) and its area coordinates in the contactor
      real(wp) :: normal = 0.0_wp, place = 0.0_wp, lambda(3) = 0.0_wp
      !> Normal stiffness per length of edge [Pa/m]
      real(wp) :: stiffness = 0.0_wp
   end type touch_t

   !> Contact between the surfaces of a split mesh
   type, public :: contact_t
      private
      type(contact_options_t) :: options
      !> Can any two surfaces meet? Else nothing is ever searched or computed.
      logical, public :: possible = .false.
      !> Searches so far
      integer, public :: searches = 0
      !> Force on each surface edge over the last step: normal (compression positive) and shear, the tangential force on
      !> the rock that owns the edge along the edge's direction (surface edges) [N/m]
      real(wp), allocatable, public :: normal(:), shear(:)

      !> Nodes of each object (3, objects); surface edge each of its edges is, 0 inside the rock (3, objects)
      integer, allocatable :: node(:, :), edge(:, :)
      !> Height of each object over each of its edges (3, objects) [m], its penalty [Pa] and half its skin [m] (objects)
      real(wp), allocatable :: height(:, :), penalty(:), half_skin(:)
      !> Groups handled elsewhere that each object touches
      type(groups_t) :: handled
      !> Length of each surface edge [m]
      real(wp), allocatable :: length(:)
      !> Nodes of the objects; how far each may move before the next search [m]; its displacement at the last search and
      !> at the last call of forces (2, layer nodes) [m]
      integer, allocatable :: layer(:)
      real(wp), allocatable :: reach(:), searched(:, :), before(:, :)
      !> Place of each node in layer, 0 for the others (nodes)
      integer, allocatable :: place(:)

      !> Objects near each other (2, pairs), their penalty [Pa], and the objects that occur in a pair
      integer, allocatable :: pair(:, :), near(:)
      real(wp), allocatable :: pair_penalty(:)
      !> Friction spring of each surface edge: elongation [m], stiffness [N/m per metre of thickness] (surface edges)
      real(wp), allocatable :: elongation(:), stiffness(:)
      !> Energy in all friction springs [J/m]
      real(wp) :: spring_energy = 0.0_wp
      !> Did any edge carry a force in the last step?
      logical :: loaded = .false.
   contains
      procedure :: init
      procedure :: needs_search
      procedure :: search
      procedure :: pairs
      procedure :: forces
      procedure :: add_stiffness
      procedure :: joint_tractions
      procedure :: save_state
      procedure :: restore_state
   end type contact_t

contains

   !> Collect the objects and prepare their state; nothing is searched yet.
   subroutine init(self, split, penalty, handled, options)
      class(contact_t), intent(out) :: self
      type(split_mesh_t), intent(in) :: split
      !> Penalty of each triangle's rock (triangles) [Pa]
      real(wp), intent(in) :: penalty(:)
      !> Fracture group of each surface edge whose contact another law handles, 0 for the others (surface edges)
      integer, intent(in) :: handled(:)
      type(contact_options_t), intent(in) :: options
      integer, allocatable :: object_of(:), chosen(:)
      integer :: i, k, edges

      self%options = options
      edges = size(split%surface, 2)
      allocate (self%normal(edges), self%shear(edges), self%length(edges), self%elongation(edges), &
                self%stiffness(edges))
      self%normal = 0.0_wp
      self%shear = 0.0_wp
      self%elongation = 0.0_wp
      self%stiffness = 0.0_wp
      allocate (self%pair(2, 0), self%near(0), self%pair_penalty(0))
      self%possible = surfaces_can_meet(split, handled)

      call choose_objects(split, chosen, object_of)
      allocate (self%node(3, size(chosen)), self%edge(3, size(chosen)), self%height(3, size(chosen)))
      self%node = split%triangle(:, chosen)
      self%penalty = penalty(chosen)
      self%edge = 0
      do i = 1, edges
         associate (object => object_of(split%surface_triangle(i)))
            do k = 1, 3
               if (self%node(k, object) == split%surface(1, i)) self%edge(k, object) = i
            end do
         end associate
         self%length(i) = norm2(split%x(:, split%surface(2, i)) - split%x(:, split%surface(1, i)))
      end do
      self%handled = groups_at_triangles(split, handled, chosen)
      call measure(self, split)
   end subroutine init

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

      allocate (reach(size(split%x, 2)), self%half_skin(size(self%node, 2)))
      ! Nodes of no object keep this and are told by it
      reach = huge(1.0_wp)
      do i = 1, size(self%node, 2)
         corner = split%x(:, self%node(:, i))
         do k = 1, 3
            side(k) = norm2(corner(:, mod(k, 3) + 1) - corner(:, k))
         end do
         self%height(:, i) = twice_area(corner)/side
         self%half_skin(i) = 0.5_wp*self%options%skin_factor*sum(side)/3.0_wp
         reach(self%node(:, i)) = min(reach(self%node(:, i)), self%half_skin(i))
      end do
      n = count(reach < huge(1.0_wp))
      allocate (self%layer(n), self%searched(2, n), self%before(2, n), self%place(size(reach)))
      self%layer = pack([(i, i=1, size(reach))], reach < huge(1.0_wp))
      self%reach = reach(self%layer)
      self%place = 0
      self%place(self%layer) = [(i, i=1, n)]
      self%searched = 0.0_wp
      self%before = 0.0_wp
   end subroutine measure

   !> Has any node of an object moved further than half the skin since the last search (or was there none yet)?
   pure logical function needs_search(self, displacement)
      class(contact_t), intent(in) :: self
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      integer :: i

      needs_search = self%possible .and. self%searches == 0
      if (needs_search .or. .not. self%possible) return
      do i = 1, size(self%layer)
         associate (node => self%layer(i))
            needs_search = (displacement(1, node) - self%searched(1, i))**2 &
                           + (displacement(2, node) - self%searched(2, i))**2 > self%reach(i)**2
         end associate
         if (needs_search) return
      end do
   end function needs_search

   !> Find the pairs of objects that can touch before the next search. Friction springs belong to surface edges, not to
   !> pairs, and live on.
   subroutine search(self, split, displacement)
      class(contact_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      real(wp), allocatable :: box(:, :)
      integer, allocatable :: candidate(:, :)
      logical, allocatable :: keep(:), is_near(:)
      real(wp) :: a(2, 3), b(2, 3)
      integer :: i

      if (.not. self%possible) return
      self%searches = self%searches + 1
      self%searched = displacement(:, self%layer)
      ! While there were no pairs, forces did not follow the motion
      if (size(self%pair, 2) == 0) self%before = self%searched
      allocate (box(4, size(self%node, 2)))
      do i = 1, size(box, 2)
         a = split%x(:, self%node(:, i)) + displacement(:, self%node(:, i))
         box(:, i) = bounds(a) + self%half_skin(i)*[-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
      end do
      call find_overlaps(box, candidate)

      allocate (keep(size(candidate, 2)), is_near(size(box, 2)))
      is_near = .false.
      do i = 1, size(candidate, 2)
         associate (first => candidate(1, i), second => candidate(2, i))
            keep(i) = .false.
            if (share_node(self%node(:, first), self%node(:, second))) cycle
            if (self%handled%share(first, second)) cycle
            a = split%x(:, self%node(:, first)) + displacement(:, self%node(:, first))
            b = split%x(:, self%node(:, second)) + displacement(:, self%node(:, second))
            keep(i) = .not. apart(a, b, self%half_skin(first) + self%half_skin(second))
            if (keep(i)) is_near(candidate(:, i)) = .true.
         end associate
      end do
      self%near = pack([(i, i=1, size(is_near))], is_near)
      call keep_pairs(self, candidate, keep)
   end subroutine search

   !> Store the pairs that passed, with their penalties.
   subroutine keep_pairs(self, candidate, keep)
      class(contact_t), intent(inout) :: self
      !> Pairs of objects (2, candidates) and whether they are kept (candidates)
      integer, intent(in) :: candidate(:, :)
      logical, intent(in) :: keep(:)
      integer :: i, n

      deallocate (self%pair, self%pair_penalty)
      allocate (self%pair(2, count(keep)), self%pair_penalty(count(keep)))
      n = 0
      do i = 1, size(keep)
         if (.not. keep(i)) cycle
         n = n + 1
         self%pair(:, n) = candidate(:, i)
         self%pair_penalty(n) = pair_penalty(self%penalty(candidate(1, i)), self%penalty(candidate(2, i)))
      end do
   end subroutine keep_pairs

   !> Number of pairs near each other since the last search.
   pure integer function pairs(self)
      class(contact_t), intent(in) :: self

      pairs = size(self%pair, 2)
   end function pairs

   !> Add normal and friction forces to the nodal forces. Call search first whenever needs_search says so. The slip of
   !> the slider law is taken from the displacements since the last call: a second call at the same place changes nothing.
   subroutine forces(self, split, displacement, velocity, friction, normal_force, friction_force, energy)
      class(contact_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement [m] and velocity [m/s] of every node (2, nodes); velocities matter to the velocity law alone
      real(wp), intent(in) :: displacement(:, :), velocity(:, :)
      !> Friction coefficient of each surface edge (surface edges): mu of eq 4, mu_mob of eq 33
      real(wp), intent(in) :: friction(:)
      !> Normal and tangential contact forces on every node, kept apart for the energy balance (2, nodes) [N/m]
      real(wp), intent(inout) :: normal_force(:, :), friction_force(:, :)
      type(contact_energy_t), intent(out) :: energy
      type(touch_t), allocatable :: touch(:)
      integer :: touches

      if (size(self%pair, 2) == 0 .and. .not. self%loaded) return
      self%normal = 0.0_wp
      self%shear = 0.0_wp
      call push_pairs(self, split, displacement, normal_force, touch, touches, energy%overlap)
      call rub(self, split, displacement, velocity, friction, touch(:touches), friction_force, energy%dissipated)
      energy%spring = self%spring_energy
      self%loaded = touches > 0
      self%before = displacement(:, self%layer)
   end subroutine forces

   !> Normal forces of all pairs, both roles; and the list of surface edges that are touched.
   subroutine push_pairs(self, split, displacement, force, touch, touches, overlap_energy)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout) :: force(:, :)
      type(touch_t), allocatable, intent(out) :: touch(:)
      integer, intent(out) :: touches
      !> Energy of all overlaps [J/m]
      real(wp), intent(out) :: overlap_energy
      real(wp), allocatable :: box(:, :)
      real(wp) :: corner(2, 3, 2)
      type(push_t) :: push
      integer :: i, role, target, contactor

      allocate (box(4, size(self%node, 2)), touch(16))
      touches = 0
      overlap_energy = 0.0_wp
      do i = 1, size(self%near)
         associate (node => self%node(:, self%near(i)))
            box(:, self%near(i)) = bounds(split%x(:, node) + displacement(:, node))
         end associate
      end do
      do i = 1, size(self%pair, 2)
         associate (a => box(:, self%pair(1, i)), b => box(:, self%pair(2, i)))
            if (a(1) > b(2) .or. b(1) > a(2) .or. a(3) > b(4) .or. b(3) > a(4)) cycle
         end associate
         call place_corners(split, displacement, self%node(:, self%pair(:, i)), corner)
         do role = 1, 2
            target = self%pair(role, i)
            contactor = self%pair(3 - role, i)
            call push_target(corner(:, :, role), corner(:, :, 3 - role), self%pair_penalty(i), push)
            if (push%energy <= 0.0_wp .and. all(push%normal <= 0.0_wp)) cycle
            overlap_energy = overlap_energy + push%energy
            force(:, self%node(:, target)) = force(:, self%node(:, target)) + push%target_force
            force(:, self%node(:, contactor)) = force(:, self%node(:, contactor)) + push%contactor_force
            call list_touches(self, target, contactor, self%pair_penalty(i), push, touch, touches)
         end do
      end do
   end subroutine push_pairs

   !> Corners of two triangles measured from the first corner of the first: the differences of original coordinates and
   !> of displacements are taken apart, so that a small penetration keeps its digits far from the origin.
   pure subroutine place_corners(split, displacement, node, corner)
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      !> Nodes of both triangles (3, 2)
      integer, intent(in) :: node(3, 2)
      !> Corners (2, 3, 2) [m]
      real(wp), intent(out) :: corner(2, 3, 2)
      integer :: i, k

      do i = 1, 2
         do k = 1, 3
            corner(:, k, i) = (split%x(:, node(k, i)) - split%x(:, node(1, 1))) &
                              + (displacement(:, node(k, i)) - displacement(:, node(1, 1)))
         end do
      end do
   end subroutine place_corners

   !> Append the pushed edges of a target that are surface edges.
   subroutine list_touches(self, target, contactor, penalty, push, touch, touches)
      class(contact_t), intent(in) :: self
      !> Objects
      integer, intent(in) :: target, contactor
      !> Penalty of the pair [Pa]
      real(wp), intent(in) :: penalty
      type(push_t), intent(in) :: push
      type(touch_t), allocatable, intent(inout) :: touch(:)
      integer, intent(inout) :: touches
      type(touch_t), allocatable :: longer(:)
      integer :: side

      do side = 1, 3
         if (self%edge(side, target) == 0 .or. push%normal(side) <= 0.0_wp) cycle
         if (touches == size(touch)) then
            allocate (longer(2*touches))
            longer(:touches) = touch
            call move_alloc(longer, touch)
         end if
         touches = touches + 1
         touch(touches) = touch_t(edge=self%edge(side, target), target=target, contactor=contactor, side=side, &
                                  normal=push%normal(side), place=push%place(side), lambda=push%lambda(:, side), &
                                  stiffness=3.0_wp*penalty/surface_height(self, contactor))
      end do
   end subroutine list_touches

   !> Height of an object over its surface edge, the one the potential rises from (the least where there is a choice).
   pure real(wp) function surface_height(self, object)
      class(contact_t), intent(in) :: self
      integer, intent(in) :: object

      surface_height = minval(self%height(:, object), mask=self%edge(:, object) > 0)
      if (all(self%edge(:, object) == 0)) surface_height = minval(self%height(:, object))
   end function surface_height

   !> Friction of all touched edges. The spring belongs to the edge, so that sliding from one contactor to the next
   !> carries its force along; its slip is the mean over the edge's touches weighted with their normal forces.
   subroutine rub(self, split, displacement, velocity, friction, touch, force, dissipated)
      class(contact_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement [m] and velocity [m/s] of every node (2, nodes)
      real(wp), intent(in) :: displacement(:, :), velocity(:, :)
      !> Friction coefficient (surface edges)
      real(wp), intent(in) :: friction(:)
      type(touch_t), intent(in) :: touch(:)
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout) :: force(:, :)
      !> Energy spent in this step [J/m]
      real(wp), intent(out) :: dissipated
      real(wp), allocatable :: load(:), slip(:), share(:)
      real(wp) :: along(2), path(size(touch)), tangential
      integer :: i

      allocate (load(size(self%length)), slip(size(self%length)), share(size(self%length)))
      load = 0.0_wp
      slip = 0.0_wp
      share = 0.0_wp
      do i = 1, size(touch)
         along = edge_direction(split, displacement, touch(i)%edge)
         path(i) = dot_product(slip_of(self, displacement, touch(i)) - slip_before(self, touch(i)), along)
         associate (edge => touch(i)%edge)
            load(edge) = load(edge) + touch(i)%normal
            slip(edge) = slip(edge) + touch(i)%normal*path(i)
            share(edge) = share(edge) + touch(i)%normal*touch(i)%stiffness
         end associate
      end do

      dissipated = 0.0_wp
      if (self%options%friction == friction_slider) call work_springs(self, friction, load, slip, share, dissipated)

      do i = 1, size(touch)
         associate (edge => touch(i)%edge)
            along = edge_direction(split, displacement, edge)
            if (self%options%friction == friction_velocity) then
               tangential = velocity_friction(friction(edge)*touch(i)%normal, &
                                              dot_product(slip_of(self, velocity, touch(i)), along))
               dissipated = dissipated + tangential*path(i)
            else
               tangential = self%stiffness(edge)*self%elongation(edge)*touch(i)%normal/load(edge)
            end if
            call drag(self, touch(i), -tangential*along, force)
            call credit(self, split, displacement, touch(i), along, -tangential)
         end associate
      end do
   end subroutine rub

   !> Stretch the friction springs of all surface edges. An edge that has lost its contact lets go of its spring.
   subroutine work_springs(self, friction, load, slip, share, dissipated)
      class(contact_t), intent(inout) :: self
      !> Friction coefficient, normal force [N/m], its products with slip [N] and with stiffness (surface edges)
      real(wp), intent(in) :: friction(:), load(:), slip(:), share(:)
      !> Energy spent [J/m]
      real(wp), intent(inout) :: dissipated
      real(wp) :: stiffness, tangential, stored, spent
      integer :: edge

      do edge = 1, size(load)
         if (load(edge) > 0.0_wp) then
            ! A contactor of another size comes under the edge: the force goes on, the elongation follows
            stiffness = self%options%tangential_factor*self%length(edge)*share(edge)/load(edge)
            tangential = self%stiffness(edge)*self%elongation(edge)
            self%spring_energy = self%spring_energy - 0.5_wp*tangential*self%elongation(edge)
            self%elongation(edge) = tangential/stiffness
            self%spring_energy = self%spring_energy + 0.5_wp*tangential*self%elongation(edge)
            self%stiffness(edge) = stiffness
            call slide(stiffness, friction(edge)*load(edge), slip(edge)/load(edge), self%elongation(edge), tangential, &
                       stored, spent)
         else if (self%stiffness(edge) > 0.0_wp) then
            call slide(self%stiffness(edge), 0.0_wp, 0.0_wp, self%elongation(edge), tangential, stored, spent)
            self%stiffness(edge) = 0.0_wp
         else
            cycle
         end if
         self%spring_energy = self%spring_energy + stored
         dissipated = dissipated + spent
      end do
   end subroutine work_springs

   !> Motion of the target against the contactor at the place of the normal force, from a nodal field.
   pure function slip_of(self, field, touch) result(slip)
      class(contact_t), intent(in) :: self
      !> Displacement [m] or velocity [m/s] of every node (2, nodes)
      real(wp), intent(in) :: field(:, :)
      type(touch_t), intent(in) :: touch
      real(wp) :: slip(2)
      integer :: k

      associate (from => self%node(touch%side, touch%target), to => self%node(mod(touch%side, 3) + 1, touch%target))
         slip = (1.0_wp - touch%place)*field(:, from) + touch%place*field(:, to)
      end associate
      do k = 1, 3
         slip = slip - touch%lambda(k)*field(:, self%node(k, touch%contactor))
      end do
   end function slip_of

   !> The same from the displacements at the last call.
   pure function slip_before(self, touch) result(slip)
      class(contact_t), intent(in) :: self
      type(touch_t), intent(in) :: touch
      real(wp) :: slip(2)
      integer :: k

      associate (from => self%place(self%node(touch%side, touch%target)), &
                 to => self%place(self%node(mod(touch%side, 3) + 1, touch%target)))
         slip = (1.0_wp - touch%place)*self%before(:, from) + touch%place*self%before(:, to)
      end associate
      do k = 1, 3
         slip = slip - touch%lambda(k)*self%before(:, self%place(self%node(k, touch%contactor)))
      end do
   end function slip_before

   !> A force on the target at a touched place, and its reaction on the contactor, to their nodes: both act at one point,
   !> so that momentum and moment of momentum are kept.
   subroutine drag(self, touch, pull, force)
      class(contact_t), intent(in) :: self
      type(touch_t), intent(in) :: touch
      !> Force on the target (2) [N/m]
      real(wp), intent(in) :: pull(2)
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout) :: force(:, :)
      integer :: k

      associate (from => self%node(touch%side, touch%target), to => self%node(mod(touch%side, 3) + 1, touch%target))
         force(:, from) = force(:, from) + (1.0_wp - touch%place)*pull
         force(:, to) = force(:, to) + touch%place*pull
      end associate
      do k = 1, 3
         associate (node => self%node(k, touch%contactor))
            force(:, node) = force(:, node) - touch%lambda(k)*pull
         end associate
      end do
   end subroutine drag

   !> Book a touch on the surface edge of the target, and its reaction on the contactor's surface edge that faces it best.
   subroutine credit(self, split, displacement, touch, along, shear)
      class(contact_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      type(touch_t), intent(in) :: touch
      !> Direction of the target's edge (2)
      real(wp), intent(in) :: along(2)
      !> Tangential force on the target in this direction [N/m]
      real(wp), intent(in) :: shear
      real(wp) :: reaction(2), other(2), facing(2), cosine, best
      integer :: k, edge

      self%normal(touch%edge) = self%normal(touch%edge) + touch%normal
      self%shear(touch%edge) = self%shear(touch%edge) + shear
      best = 0.0_wp
      edge = 0
      do k = 1, 3
         if (self%edge(k, touch%contactor) == 0) cycle
         other = edge_direction(split, displacement, self%edge(k, touch%contactor))
         cosine = -dot_product(other, along)
         if (cosine <= best) cycle
         best = cosine
         edge = self%edge(k, touch%contactor)
         facing = other
      end do
      if (edge == 0) return
      reaction = touch%normal*[along(2), -along(1)] - shear*along
      self%normal(edge) = self%normal(edge) - dot_product(reaction, [facing(2), -facing(1)])
      self%shear(edge) = self%shear(edge) + dot_product(reaction, facing)
   end subroutine credit

   !> Unit vector along a surface edge, its rock on the left.
   pure function edge_direction(split, displacement, edge) result(along)
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      integer, intent(in) :: edge
      real(wp) :: along(2)

      associate (from => split%surface(1, edge), to => split%surface(2, edge))
         along = (split%x(:, to) - split%x(:, from)) + (displacement(:, to) - displacement(:, from))
      end associate
      along = along/norm2(along)
   end function edge_direction

   !> Add to each node a bound of the contact stiffness it can feel before the next search, such that the largest
   !> frequency of nodes on contact alone obeys omega**2 <= max(stiffness/mass).
   !>
   !> A length dl of contact is a spring 3 p/H dl between the edge and the contactor, with weights N on the edge's nodes and
   !> lambda on the contactor's, each adding up to 1. The sum of the norms of a node's row of 2 x 2 blocks
   !> (Gershgorin) is 2 (3 p/H) integral of N dl = (3 p/H) L for an edge touched over all its length; the contactor's
   !> nodes get as much from the edges that lie along its own surface edge. Both roles of each surface edge are added, with
   !> the stiffest neighbour found by the search. Normal and friction springs act at right angles: the stiffer counts.
   !> The bound supposes penetrations that are small against the height of the triangles.
   subroutine add_stiffness(self, stiffness)
      class(contact_t), intent(in) :: self
      !> Stiffness of each node (nodes) [N/m per metre of thickness]
      real(wp), intent(inout) :: stiffness(:)
      real(wp), allocatable :: steepest(:)
      real(wp) :: factor
      integer :: i, k, role

      ! The steepest spring per length that each object meets, as target and as contactor
      allocate (steepest(size(self%node, 2)))
      steepest = 0.0_wp
      do i = 1, size(self%pair, 2)
         do role = 1, 2
            associate (own => self%pair(role, i), other => self%pair(3 - role, i))
               steepest(own) = max(steepest(own), 3.0_wp*self%pair_penalty(i)*(1.0_wp/minval(self%height(:, own)) &
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

   !> Contact tractions of each joint element, the mean of its two walls (eqs 32-33 want them).
   pure subroutine joint_tractions(self, split, normal, shear)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Normal stress, compression positive, and shear stress, positive when it resists the upper wall's motion along
      !> A'->B' (joints) [Pa]
      real(wp), intent(out) :: normal(:), shear(:)
      integer :: edge, joint

      normal = 0.0_wp
      shear = 0.0_wp
      do edge = 1, size(self%length)
         joint = split%surface_joint(edge)
         if (joint == 0) cycle
         normal(joint) = normal(joint) + 0.5_wp*self%normal(edge)/self%length(edge)
         ! Both walls are directed with their rock on the left, where the resistance to that motion is negative
         shear(joint) = shear(joint) - 0.5_wp*self%shear(edge)/self%length(edge)
      end do
   end subroutine joint_tractions

   !> What a checkpoint needs of the contact: springs and last displacements. The pairs are searched anew.
   pure function save_state(self) result(values)
      class(contact_t), intent(in) :: self
      real(wp), allocatable :: values(:)

      allocate (values(1 + 2*size(self%elongation) + size(self%before)))
      values = [self%spring_energy, self%elongation, self%stiffness, reshape(self%before, [size(self%before)])]
   end function save_state

   !> Go on from a checkpoint: search is due, and forces continues the springs. Returns false when the values do not fit.
   logical function restore_state(self, split, displacement, values) result(fits)
      class(contact_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node at the checkpoint (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      !> What save_state gave
      real(wp), intent(in) :: values(:)
      integer :: edges

      edges = size(self%elongation)
      fits = size(values) == 1 + 2*edges + size(self%before)
      if (.not. fits) return
      call self%search(split, displacement)
      self%spring_energy = values(1)
      self%elongation = values(2:edges + 1)
      self%stiffness = values(edges + 2:2*edges + 1)
      self%before = reshape(values(2*edges + 2:), shape(self%before))
      self%loaded = any(self%stiffness > 0.0_wp)
   end function restore_state

   !> Box around a triangle: xmin, xmax, ymin, ymax.
   pure function bounds(corner) result(box)
      real(wp), intent(in) :: corner(2, 3)
      real(wp) :: box(4)

      box = [minval(corner(1, :)), maxval(corner(1, :)), minval(corner(2, :)), maxval(corner(2, :))]
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
