!> General contact between surfaces: when to look again which triangles are near each other (near_pairs_m), and the normal
!> (potential_m) and friction (contact_friction_m) forces between them. Objects are the triangles of the layer under the surfaces
!> (contact_layer_m).
!>
!> Surface edges that another contact law looks after (the joint's own wall contact) are marked by the caller with the
!> number of their fracture group. Two triangles that both touch walls of the same marked group never meet here:
!> wherever these walls slide to, their contact belongs to the other law.
module contact_m
   use constants_m, only: no_length
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use friction_m, only: friction_slider
   use potential_m, only: push_t, push_target
   use impact_m, only: impacts_t
   use surfaces_m, only: surfaces_can_meet
   use contact_layer_m, only: contact_layer_t, contact_options_t, init_layer, same_objects, box_around
   use near_pairs_m, only: near_pairs_t, no_pairs, have_moved, find_pairs
   use contact_friction_m, only: touches_t, contact_springs_t, no_touches, loose_springs, list_touches, rub
   implicit none
   private

   !> What one call of forces did to the energies
   type, public :: contact_energy_t
      !> Energy of all overlaps now, energy in all friction springs now [J/m]
      real(wp) :: overlap = 0.0_wp, spring = 0.0_wp
      !> Energy that friction spent in this step [J/m]
      real(wp) :: dissipated = 0.0_wp
   end type contact_energy_t

   !> What the contact remembers, and what it found last
   type, public :: contact_state_t
      !> Searches so far
      integer :: searches = 0
      type(near_pairs_t) :: near
      type(touches_t) :: touches
      type(contact_springs_t) :: springs
      !> Contact that has begun or ended
      type(impacts_t) :: impacts
      !> Did any edge carry a force in the last step?
      logical, private :: loaded = .false.
      !> Boxes of the near objects in the present step (4, objects) [m]
      real(wp), allocatable, private :: box(:, :)
   contains
      procedure :: pairs
      procedure :: values
   end type contact_state_t

   !> Contact between the surfaces of a split mesh
   type, public :: contact_t
      !> Can any two surfaces meet? Else nothing is ever searched or computed.
      logical :: possible = .false.
      type(contact_layer_t) :: layer
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

   !> Can surfaces meet? The layer under them.
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
      integer :: number(size(split%x, 2)), i

      number = [(i, i=1, size(number))]
      if (present(same)) number = same
      self%possible = options%everywhere
      if (.not. self%possible) self%possible = surfaces_can_meet(split, handled, number)
      call init_layer(split, penalty, handled, options, number, self%layer)
   end subroutine init

   !> Nothing is searched yet, nothing touches.
   subroutine start(self, now)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(out) :: now

      call no_pairs(self%layer, now%near)
      call no_touches(self%layer, now%touches)
      call loose_springs(self%layer, now%springs)
      allocate (now%box(4, size(self%layer%penalty)), source=0.0_wp)
      if (self%layer%options%impacts) call now%impacts%start(size(self%layer%penalty))
   end subroutine start

   !> Is a search due?
   pure logical function needs_search(self, now, displacement)
      class(contact_t), intent(in) :: self
      type(contact_state_t), intent(in) :: now
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)

      needs_search = self%possible .and. (now%searches == 0 .or. self%layer%options%every_time)
      if (needs_search .or. .not. self%possible) return
      needs_search = have_moved(self%layer, now%near, displacement)
   end function needs_search

   !> Look which objects are near each other. Friction springs belong to surface edges, not to pairs, and live on.
   subroutine search(self, split, displacement, now)
      class(contact_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      type(contact_state_t), intent(inout) :: now

      if (.not. self%possible) return
      now%searches = now%searches + 1
      ! While there were no pairs, forces did not follow the motion
      if (now%pairs() == 0) now%springs%before = displacement(:, self%layer%nodes)
      call find_pairs(self%layer, split, displacement, now%near)
   end subroutine search

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
         if (edge(i) == 0) cycle
         if (was(edge(i)) == 0) cycle
         now%springs%elongation(i) = before_cut%springs%elongation(was(edge(i)))
         now%springs%stiffness(i) = before_cut%springs%stiffness(was(edge(i)))
         now%touches%normal(i) = before_cut%touches%normal(was(edge(i)))
         now%touches%shear(i) = before_cut%touches%shear(was(edge(i)))
      end do
      do i = 1, size(self%layer%nodes)
         before = old%layer%place(parent(self%layer%nodes(i)))
         now%springs%before(:, i) = displacement(:, self%layer%nodes(i))
         if (before > 0) now%springs%before(:, i) = before_cut%springs%before(:, before)
      end do
      if (self%layer%options%impacts) &
         call now%impacts%carry_on(before_cut%impacts, same_objects(self%layer, old%layer, parent), self%layer%node)
   end subroutine carry_on

   !> Number of pairs near each other since the last search.
   pure integer function pairs(now)
      class(contact_state_t), intent(in) :: now

      pairs = size(now%near%pair, 2)
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

      if (size(now%near%pair, 2) == 0 .and. .not. now%loaded) then
         call now%impacts%forget()
         return
      end if
      now%touches%normal = 0.0_wp
      now%touches%shear = 0.0_wp
      call place_objects(self, split, displacement, now)
      if (self%layer%options%impacts) call now%impacts%begin()
      call push_pairs(self, split, displacement, now, normal_force, energy%overlap)
      if (self%layer%options%impacts) call now%impacts%compare(split%x, displacement, now%springs%before, self%layer%place)
      call rub(self%layer, displacement, velocity, friction, now%touches, now%springs, friction_force, energy%dissipated)
      energy%spring = now%springs%spring_energy
      now%loaded = now%touches%number > 0
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

      do i = 1, size(now%near%object)
         associate (object => now%near%object(i))
            do k = 1, 3
               corner(:, k) = split%x(:, self%layer%node(k, object)) + displacement(:, self%layer%node(k, object))
            end do
            now%box(:, object) = box_around(corner)
            do k = 1, 3
               if (self%layer%edge(k, object) == 0) cycle
               now%touches%along(:, self%layer%edge(k, object)) = direction(corner(:, k), corner(:, mod(k, 3) + 1))
            end do
         end associate
      end do
   end subroutine place_objects

   !> Unit vector from one point to another.
   pure function direction(from, to)
      real(wp), intent(in) :: from(2), to(2)
      real(wp) :: direction(2)

      direction = to - from
      direction = direction/max(sqrt(direction(1)**2 + direction(2)**2), no_length)
   end function direction

   !> Keep the displacements for the slip of the next call.
   pure subroutine remember(self, displacement, now)
      class(contact_t), intent(in) :: self
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in), contiguous :: displacement(:, :)
      type(contact_state_t), intent(inout) :: now
      integer :: i

      do i = 1, size(self%layer%nodes)
         now%springs%before(:, i) = displacement(:, self%layer%nodes(i))
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

      now%touches%number = 0
      overlap_energy = 0.0_wp
      do i = 1, size(now%near%pair, 2)
         associate (a => now%near%pair(1, i), b => now%near%pair(2, i))
            if (now%box(1, a) > now%box(2, b) .or. now%box(1, b) > now%box(2, a)) cycle
            if (now%box(3, a) > now%box(4, b) .or. now%box(3, b) > now%box(4, a)) cycle
            call place_corners(split%x, displacement, self%layer%node(:, a), self%layer%node(:, b), corner)
         end associate
         do role = 1, 2
            call push_target(corner(:, :, role), corner(:, :, 3 - role), now%near%penalty(i), push)
            if (push%energy <= 0.0_wp .and. max(push%normal(1), push%normal(2), push%normal(3)) <= 0.0_wp) cycle
            target = now%near%pair(role, i)
            contactor = now%near%pair(3 - role, i)
            overlap_energy = overlap_energy + push%energy
            do k = 1, 3
               associate (own => self%layer%node(k, target), other => self%layer%node(k, contactor))
                  force(:, own) = force(:, own) + push%target_force(:, k)
                  force(:, other) = force(:, other) + push%contactor_force(:, k)
               end associate
            end do
            call list_touches(self%layer, target, contactor, now%near%penalty(i), push, now%touches)
            if (self%layer%options%impacts) &
               call now%impacts%note(target, contactor, self%layer%node(:, target), self%layer%node(:, contactor), &
                                     push%target_force, push%contactor_force, push%energy)
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
      allocate (steepest(size(self%layer%node, 2)))
      steepest = 0.0_wp
      do i = 1, size(now%near%pair, 2)
         do role = 1, 2
            associate (own => now%near%pair(role, i), other => now%near%pair(3 - role, i))
               steepest(own) = max(steepest(own), 3.0_wp*now%near%penalty(i)*(1.0_wp/minval(self%layer%height(:, own)) &
                                                                              + 1.0_wp/minval(self%layer%height(:, other))))
            end associate
         end do
      end do
      factor = 1.0_wp
      if (self%layer%options%friction == friction_slider) factor = max(1.0_wp, self%layer%options%tangential_factor)
      do i = 1, size(self%layer%node, 2)
         do k = 1, 3
            if (self%layer%edge(k, i) == 0) cycle
            associate (ends => self%layer%node([k, mod(k, 3) + 1], i))
               stiffness(ends) = stiffness(ends) + factor*steepest(i)*self%layer%length(self%layer%edge(k, i))
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
      do edge = 1, size(self%layer%length)
         joint = split%surface_joint(edge)
         if (joint == 0 .or. split%surface_side(edge) <= 0) cycle
         normal(joint) = now%touches%normal(edge)/self%layer%length(edge)
         ! The wall is directed with its rock on the left, where the resistance to that motion is negative
         shear(joint) = -now%touches%shear(edge)/self%layer%length(edge)
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
      if (size(now%near%pair, 2) == 0) springs%before = displacement(:, self%layer%nodes)
   end subroutine recall

   !> What a checkpoint needs of the contact: the forces on the edges, springs, last displacements, and where the surfaces
   !> were at the last search, from which the same pairs are found again in the same order.
   pure function values(now) result(list)
      class(contact_state_t), intent(in) :: now
      real(wp), allocatable :: list(:)

      list = [now%springs%spring_energy, real(now%searches, wp), now%touches%normal, now%touches%shear, now%springs%elongation, &
              now%springs%stiffness, reshape(now%springs%before, [size(now%springs%before)]), &
              reshape(now%near%searched, [size(now%near%searched)])]
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
         displacement(:, self%layer%nodes) = reshape(values(size(values) - size(now%near%searched) + 1:), shape(now%near%searched))
         call self%search(split, displacement, now)
      end if
      now%searches = searches
      now%springs%spring_energy = values(1)
      first = single_values
      now%touches%normal = values(first + 1:first + edges)
      now%touches%shear = values(first + edges + 1:first + 2*edges)
      now%springs%elongation = values(first + 2*edges + 1:first + 3*edges)
      now%springs%stiffness = values(first + 3*edges + 1:first + edge_arrays*edges)
      first = first + edge_arrays*edges
      now%springs%before = reshape(values(first + 1:first + size(now%springs%before)), shape(now%springs%before))
      now%loaded = any(now%touches%normal > 0.0_wp)
      if (.not. self%layer%options%impacts) return
      ! The overlaps of the last step, found again where it left them
      displacement = 0.0_wp
      displacement(:, self%layer%nodes) = now%springs%before
      normal_force = 0.0_wp
      call now%impacts%forget()
      call place_objects(self, split, displacement, now)
      call push_pairs(self, split, displacement, now, normal_force, energy)
   end function restore_state

end module contact_m
