!> The scene: what a run is made of, built once from deck and mesh. Not all of it stays: stages change the loads, cracks cut the
!> mesh, and walls, corners, bonds, contact springs and joints remember where they are. Motion and the joints' laws are in state_m.
module scene_m
   use kinds_m, only: wp
   use constants_m, only: is_set, unset, radians, megapascal, millimetre, megapascal_per_millimetre
   use errors_m, only: error_list_t
   use text_m, only: to_text, quoted
   use union_find_m, only: each_alone, join, representatives
   use log_m, only: log_t
   use deck_m, only: deck_t
   use joint_group_m, only: joint_t
   use mesh_m, only: mesh_t, split_mesh_t, find_group, surface_first, place_text
   use edges_m, only: edge_table_t
   use split_m, only: cut_t, fracture_cuts, split_edges
   use topology_m, only: topology_t, scan_topology
   use solid_m, only: solid_t, init_solid, set_viscosity, lumped_mass, solid_stiffness_bound, solid_damping_bound
   use joint_law_m, only: guard_t
   use law_list_m, only: scaled_law
   use joints_m, only: joints_t, init_joints
   use bonds_m, only: bonds_t, is_closed
   use wall_contact_m, only: wall_contact_t, init_wall_contact, init_meeting, surfaces_walked, walls_touching, lets_go
   use corners_m, only: corners_t, init_corners, init_choices
   use contact_m, only: contact_t, contact_options_t
   use friction_m, only: friction_slider, friction_velocity
   use pore_pressure_m, only: add_pore_pressure
   use loads_m, only: loads_t, init_loads, start_stage, group_nodes
   use state_m, only: state_t, init_state
   use solver_choice_m, only: choose_solver, solver_name, solver_explicit, solver_relaxation
   implicit none
   private

   type, public :: scene_t
      type(deck_t) :: deck
      !> Solver of this run, and why
      integer :: solver = solver_explicit
      character(len=:), allocatable :: solver_reason
      !> The mesh as read, its edges, and those of them that are cut: fractures first, then cracks as they come
      type(mesh_t) :: whole
      type(edge_table_t) :: edges
      type(cut_t) :: cut
      type(split_mesh_t) :: split
      type(topology_t) :: topology
      type(solid_t) :: solid
      type(joints_t) :: joints
      type(wall_contact_t) :: walls
      type(corners_t) :: corners
      type(bonds_t) :: bonds
      !> The split mesh with those surface edges only that no bond holds, and their numbers in split
      type(split_mesh_t) :: exposed
      integer, allocatable :: exposed_edge(:)
      type(contact_t) :: contact
      !> Nodes that contact can push: all of the triangles with a node on a surface
      integer, allocatable :: touching(:)
      type(loads_t) :: loads
      !> True nodal mass (nodes) [kg per m] and weight (2, nodes) [N per m]
      real(wp), allocatable :: mass(:), weight(:, :)
      !> Row sums of stiffness and damping of the rock (nodes) [N/m, N s/m per m]
      real(wp), allocatable :: rock_stiffness(:), rock_damping(:)
      !> Cundall's local damping (0: none)
      real(wp) :: local_damping = 0.0_wp
      !> What the scene needs
      logical :: has_damping = .false., has_walls = .false., has_contact = .false., has_potential_joints = .false., &
                 can_break = .false.
      !> Index of the deck's &fracture group of each edge of the mesh as read, 0 where it cannot break (edges)
      integer, allocatable :: breakable(:)
      !> Are edges still to be cut where the stress asks for it? Steps between two looks at cracks
      logical :: is_adaptive = .false.
      integer :: check_every = 1
      !> Number of the stage
      integer :: stage = 0
   contains
      procedure :: until_balanced
      procedure :: longest_rest
      procedure :: rest_tolerance
   end type scene_t

   public :: build_scene, begin_stage, build_nodes, build_walls, build_contact, start_contact, first_friction, &
             material_of

contains

   !> Split the mesh, scan the topology and set up rock, joints, walls and the state at rest.
   subroutine build_scene(deck, mesh, log, scene, state, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(log_t), intent(in) :: log
      type(scene_t), intent(out) :: scene
      type(state_t), intent(out) :: state
      type(error_list_t), intent(inout) :: errors
      logical, allocatable :: fracture(:)
      integer :: i

      scene%deck = deck
      allocate (fracture(size(mesh%group)), source=.false.)
      do i = 1, size(deck%joint)
         fracture(find_group(mesh%group, deck%joint(i)%group, 1)) = .true.
      end do
      scene%whole = mesh
      call fracture_cuts(mesh, fracture, scene%edges, scene%cut, errors)
      if (errors%any()) return
      call split_edges(mesh, scene%edges, scene%cut, scene%split)
      call scan_topology(scene%split, scene%topology)
      call choose_solver(deck, scene%split, scene%solver, scene%solver_reason)
      ! The deck written beside the results names it
      scene%deck%run%solver = solver_name(scene%solver)
      call build_rock(scene)
      call build_nodes(scene)
      call build_joints(scene, log)
      call build_contact(scene)
      call init_loads(scene%split, deck%boundary, scene%loads, every_time=.not. deck%plan%skip_loads)
      call init_state(scene%mass, size(scene%split%joint, 2), scene%has_damping, state)
      call start_contact(scene, state)
      call start_moving(scene, state)
   end subroutine build_scene

   !> Triangles.
   subroutine build_rock(scene)
      type(scene_t), intent(inout) :: scene
      real(wp), allocatable :: density(:), young(:), poisson(:)
      integer :: triangles, e, m

      triangles = size(scene%split%triangle, 2)
      allocate (density(triangles), young(triangles), poisson(triangles))
      do e = 1, triangles
         m = material_of(scene, e)
         density(e) = scene%deck%material(m)%density
         young(e) = scene%deck%material(m)%young
         poisson(e) = scene%deck%material(m)%poisson
      end do
      call init_solid(scene%split%x, scene%split%triangle, density, young, poisson, scene%solid)
      associate (settings => scene%deck%explicit)
         ! Damping belongs to motion
         if (scene%solver /= solver_explicit) return
         if (.not. scene%deck%plan%skip_viscosity) call set_viscosity(scene%solid, 0.0_wp)
         if (settings%damping == 'viscous') call set_viscosity(scene%solid, settings%damping_factor)
         if (settings%damping == 'local') scene%local_damping = settings%damping_factor
      end associate
   end subroutine build_rock

   !> What belongs to the nodes of the split mesh: masses, weights, bounds for the stable step.
   subroutine build_nodes(scene)
      type(scene_t), intent(inout) :: scene
      integer :: nodes, gravity_axis

      nodes = size(scene%split%x, 2)
      scene%solid%node = scene%split%triangle
      if (allocated(scene%mass)) deallocate (scene%mass, scene%weight, scene%rock_stiffness, scene%rock_damping)
      allocate (scene%mass(nodes), scene%weight(2, nodes))
      call lumped_mass(scene%solid, scene%mass)
      do gravity_axis = 1, 2
         scene%weight(gravity_axis, :) = scene%mass*merge(scene%deck%gravity%gx, scene%deck%gravity%gy, gravity_axis == 1)
      end do
      allocate (scene%rock_stiffness(nodes), scene%rock_damping(nodes), source=0.0_wp)
      call solid_stiffness_bound(scene%solid, scene%rock_stiffness)
      scene%has_damping = scene%solver == solver_explicit .and. &
                          (scene%deck%explicit%damping == 'viscous' .or. .not. scene%deck%plan%skip_viscosity)
      if (scene%has_damping) call solid_damping_bound(scene%solid, scene%rock_damping)
   end subroutine build_nodes

   !> Index of the deck's material of a triangle.
   pure integer function material_of(scene, e) result(material)
      type(scene_t), intent(in) :: scene
      !> Triangle
      integer, intent(in) :: e
      integer :: m

      material = 0
      do m = 1, size(scene%deck%material)
         if (scene%deck%material(m)%group == scene%split%group(scene%split%triangle_group(e))%name) material = m
      end do
   end function material_of

   !> Laws at the scale of the block edges, coupling options, wall contact.
   subroutine build_joints(scene, log)
      type(scene_t), intent(inout) :: scene
      type(log_t), intent(in) :: log
      real(wp), allocatable :: mean_length(:)
      integer :: j, g

      call init_joints(scene%split, scene%joints)
      allocate (mean_length(size(scene%deck%joint)))
      do g = 1, size(scene%deck%joint)
         mean_length(g) = mean_edge_length(scene, g)
      end do
      do j = 1, size(scene%split%joint, 2)
         g = deck_joint(scene, j)
         scene%joints%group(j) = g
         associate (settings => scene%deck%joint(g), edge => scene%topology%edge_of_joint(j))
            call scaled_law(settings%law, settings%settings, scene%topology%edge_length(edge), mean_length(g), &
                            scene%joints%law(j)%raw)
            scene%joints%coupled(j) = settings%coupling == 'coupled'
            scene%joints%velocity_friction(j) = settings%friction == 'velocity'
            scene%joints%stress_from_walls(j) = settings%normal_stress == 'walls'
            scene%joints%literal_aperture(j) = settings%aperture == 'eq31'
            scene%joints%wall_handled(j) = settings%contact == 'wall'
            if (settings%normal == 'penalty') scene%joints%penalty(j) = penalty_stiffness(scene, settings, j)
         end associate
         call scene%joints%law(j)%raw%lend(scene%joints%penalty(j))
      end do
      call warn_of_guards(scene, log)
      call warn_of_closed(scene, log)
      call build_walls(scene)
   end subroutine build_joints

   !> Contact of all walls that no bond holds, and of the corners between them. Walls of cracks whose law closes may overlap by
   !> all of their closure before contact lets go of them.
   subroutine build_walls(scene)
      type(scene_t), intent(inout) :: scene
      integer :: w

      call init_wall_contact(scene%split, scene%joints%wall_handled, scene%walls, scene%joints%bonded)
      ! Those of fractures: where cracks meet, fragments find each other by the general contact
      call init_corners(scene%split, walls_touching(scene%joints%wall_handled, scene%joints%bonded) .and. &
                        scene%split%joint_group > 0, scene%solid%young, scene%deck%contact%corner_factor, scene%corners)
      do w = 1, size(scene%walls%joint)
         associate (j => scene%walls%joint(w))
            if (scene%split%joint_group(j) > 0 .or. scene%joints%law(j)%raw%own_closure() <= 0.0_wp) cycle
            scene%walls%deepest(w) = scene%walls%deepest(w) + &
                                     scene%joints%law(j)%raw%own_closure()*millimetre/(lets_go*scene%joints%length(j))
         end associate
      end do
   end subroutine build_walls

   !> Contact between surfaces that no wall contact looks after.
   subroutine build_contact(scene)
      type(scene_t), intent(inout) :: scene
      type(contact_options_t) :: options
      real(wp), allocatable :: penalty(:)
      integer, allocatable :: walked(:)
      integer :: e

      call expose(scene)
      call find_touching(scene)
      scene%has_walls = size(scene%walls%joint) > 0
      scene%has_potential_joints = .not. all(scene%joints%wall_handled)
      associate (settings => scene%deck%contact)
         if (.not. settings%active) return
         options%skin_factor = settings%skin_factor
         options%tangential_factor = settings%tangential_factor
         options%everywhere = .not. scene%deck%plan%skip_contact
         options%every_time = .not. scene%deck%plan%skip_search
         options%friction = merge(friction_velocity, friction_slider, settings%friction == 'velocity')
         allocate (penalty(size(scene%split%triangle, 2)))
         do e = 1, size(penalty)
            penalty(e) = scene%deck%material(material_of(scene, e))%penalty_factor*scene%solid%young(e)
         end do
         walked = surfaces_walked(scene%walls, scene%split)
         call scene%contact%init(scene%exposed, penalty, walked(scene%exposed_edge), options, held_together(scene))
         scene%has_contact = scene%contact%possible
      end associate
   end subroutine build_contact

   !> Friction coefficient of the surfaces in the general contact before any motion (surface edges).
   function first_friction(scene) result(friction)
      type(scene_t), intent(in) :: scene
      real(wp), allocatable :: friction(:)
      integer :: e

      allocate (friction(size(scene%exposed_edge)), source=tan(scene%deck%contact%friction_angle*radians))
      do e = 1, size(friction)
         associate (crack => scene%exposed%surface_joint(e) - scene%bonds%fractures)
            if (scene%can_break .and. crack > 0) friction(e) = scene%bonds%law(crack)%residual
         end associate
      end do
   end function first_friction

   !> Walls and surfaces that have not felt anything yet.
   subroutine start_contact(scene, state)
      type(scene_t), intent(in) :: scene
      type(state_t), intent(inout) :: state

      call init_meeting(scene%walls, state%walls)
      call init_choices(scene%corners, state%corners)
      if (scene%has_contact) call scene%contact%start(state%contact)
      state%surface_friction = first_friction(scene)
   end subroutine start_contact

   !> Leave out the surface edges that a bond holds.
   subroutine expose(scene)
      type(scene_t), intent(inout) :: scene
      logical, allocatable :: keep(:)
      integer :: e

      scene%exposed = scene%split
      keep = [(scene%split%surface_joint(e) == 0, e=1, size(scene%split%surface_joint))]
      do e = 1, size(keep)
         if (.not. keep(e)) keep(e) = .not. scene%joints%bonded(scene%split%surface_joint(e))
      end do
      scene%exposed_edge = pack([(e, e=1, size(keep))], keep)
      associate (exposed => scene%exposed, edge => scene%exposed_edge)
         exposed%surface = scene%split%surface(:, edge)
         exposed%surface_triangle = scene%split%surface_triangle(edge)
         exposed%surface_joint = scene%split%surface_joint(edge)
         exposed%surface_side = scene%split%surface_side(edge)
         exposed%surface_group = scene%split%surface_group(edge)
      end associate
   end subroutine expose

   !> A number that is the same for nodes which bonds hold together or once held together: triangles that share one never
   !> meet in the general contact (nodes).
   function held_together(scene) result(same)
      type(scene_t), intent(in) :: scene
      integer, allocatable :: same(:)
      integer :: b, k

      allocate (same(size(scene%split%x, 2)))
      same = each_alone(size(same))
      if (.not. scene%can_break) return
      do b = 1, size(scene%bonds%node, 2)
         do k = 1, 2
            call join(same, scene%bonds%node(k, b), scene%bonds%node(k + 2, b))
         end do
      end do
      same = representatives(same)
   end function held_together

   !> Nodes of the triangles with a node on a surface.
   subroutine find_touching(scene)
      type(scene_t), intent(inout) :: scene
      logical, allocatable :: on_surface(:), touches(:)
      integer :: e, n

      allocate (on_surface(size(scene%split%x, 2)), source=.false.)
      do e = 1, size(scene%exposed%surface, 2)
         on_surface(scene%exposed%surface(:, e)) = .true.
      end do
      touches = on_surface .or. .not. scene%deck%plan%skip_nodes
      do e = 1, size(scene%split%triangle, 2)
         if (any(on_surface(scene%split%triangle(:, e)))) touches(scene%split%triangle(:, e)) = .true.
      end do
      scene%touching = pack([(n, n=1, size(touches))], touches)
   end subroutine find_touching

   !> Index of the deck's &joint group of a joint element.
   pure integer function deck_joint(scene, j) result(group)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: j
      integer :: g

      group = 0
      do g = 1, size(scene%deck%joint)
         if (scene%deck%joint(g)%group == scene%split%group(scene%split%joint_group(j))%name) group = g
      end do
   end function deck_joint

   !> Mean length of the block edges of a &joint group [m].
   pure real(wp) function mean_edge_length(scene, g) result(mean)
      type(scene_t), intent(in) :: scene
      !> Index of the deck's &joint group
      integer, intent(in) :: g
      integer :: e, edges

      mean = 0.0_wp
      edges = 0
      do e = 1, size(scene%topology%edge_group)
         if (scene%split%group(scene%topology%edge_group(e))%name /= scene%deck%joint(g)%group) cycle
         mean = mean + scene%topology%edge_length(e)
         edges = edges + 1
      end do
      if (edges > 0) mean = mean/real(edges, wp)
   end function mean_edge_length

   !> Penalty stiffness of a joint's walls, p over the size of the triangles behind them [MPa/mm].
   pure real(wp) function penalty_stiffness(scene, settings, j) result(stiffness)
      type(scene_t), intent(in) :: scene
      type(joint_t), intent(in) :: settings
      integer, intent(in) :: j
      real(wp) :: penalty, height

      associate (triangle => scene%split%joint_triangle(:, j))
         penalty = settings%penalty
         if (.not. is_set(penalty)) penalty = &
            maxval(scene%deck%material([material_of(scene, triangle(1)), material_of(scene, triangle(2))])%penalty_factor* &
                   scene%solid%young(triangle))
         height = minval(scene%solid%height(triangle))
      end associate
      stiffness = penalty/height/megapascal_per_millimetre
   end function penalty_stiffness

   !> Say once, group by group, where a law had to be kept within its bounds.
   subroutine warn_of_guards(scene, log)
      type(scene_t), intent(in) :: scene
      type(log_t), intent(in) :: log
      type(guard_t), allocatable :: guards(:)
      integer, allocatable :: acted(:)
      integer :: g, j, members

      do g = 1, size(scene%deck%joint)
         members = 0
         do j = 1, size(scene%joints%group)
            if (scene%joints%group(j) /= g) cycle
            guards = scene%joints%law(j)%raw%guards()
            if (members == 0) acted = 0*[(j, j=1, size(guards))]
            members = members + 1
            acted = acted + merge(1, 0, guards%acted)
         end do
         if (members == 0) cycle
         do j = 1, size(guards)
            if (acted(j) > 0) call log%warn(to_text(acted(j))//' of '//to_text(members)//' joint elements of '// &
                                            quoted(scene%deck%joint(g)%group)//' '//trim(guards(j)%text))
         end do
      end do
   end subroutine warn_of_guards

   !> A joint element both of whose ends are tips has no node of its own: it can neither open nor slide.
   subroutine warn_of_closed(scene, log)
      type(scene_t), intent(in) :: scene
      type(log_t), intent(in) :: log
      logical :: closed(size(scene%joints%group))
      integer :: g, j

      closed = [(is_closed(scene%split%joint(:, j)), j=1, size(closed))]
      do g = 1, size(scene%deck%joint)
         if (count(closed .and. scene%joints%group == g) == 0) cycle
         j = findloc(closed .and. scene%joints%group == g, .true., dim=1)
         call log%warn(to_text(count(closed .and. scene%joints%group == g))//' joint elements of '// &
                       quoted(scene%deck%joint(g)%group)//' are fractures of one element with both tips in the rock, as at '// &
                       place_text(scene%split%x(:, scene%split%joint(1, j)), scene%split%datum)//': they cannot open '// &
                       'or slide; a finer mesh can')
      end do
   end subroutine warn_of_closed

   !> Initial velocities.
   subroutine start_moving(scene, state)
      type(scene_t), intent(in) :: scene
      type(state_t), intent(inout) :: state
      logical, allocatable :: member(:)
      integer :: i

      do i = 1, size(scene%deck%initial)
         member = group_nodes(scene%split, scene%deck%initial(i)%group, surface_first)
         associate (initial => scene%deck%initial(i))
            if (is_set(initial%vx)) where (member) state%v(1, :) = initial%vx
            if (is_set(initial%vy)) where (member) state%v(2, :) = initial%vy
         end associate
      end do
   end subroutine start_moving

   !> Compile the boundary conditions of a stage.
   subroutine begin_stage(scene, stage, state)
      type(scene_t), intent(inout) :: scene
      !> Number of the stage
      integer, intent(in) :: stage
      type(state_t), intent(inout) :: state

      scene%stage = stage
      call start_stage(scene%split, scene%deck%boundary, scene%deck%stage%name, stage, scene%weight, scene%loads)
      call add_pore_pressure(scene%split, scene%deck%pore_pressure, scene%deck%stage%name, stage, filled(scene, state), scene%loads)
      ! Weight that is not ramped is there from the very start
      if (stage == 1 .and. .not. scene%deck%gravity%ramped) scene%loads%dead_start = scene%weight
      state%load_level = unset
   end subroutine begin_stage

   !> Can fluid be between the walls of a joint element? On fractures, and in cracks that have broken (joints).
   pure function filled(scene, state)
      type(scene_t), intent(in) :: scene
      type(state_t), intent(in) :: state
      logical :: filled(size(scene%split%joint, 2))

      filled = .true.
      if (scene%can_break) filled(scene%bonds%fractures + 1:) = state%bonds%broken
   end function filled

   !> Does the rest of a stage end at equilibrium rather than at a given time?
   pure logical function until_balanced(self, stage)
      class(scene_t), intent(in) :: self
      integer, intent(in) :: stage

      until_balanced = is_set(self%deck%stage(stage)%equilibrium)
   end function until_balanced

   !> Longest rest of a stage that ends at equilibrium [s].
   pure real(wp) function longest_rest(self, stage)
      class(scene_t), intent(in) :: self
      integer, intent(in) :: stage

      longest_rest = self%deck%stage(stage)%max_rest_time
   end function longest_rest

   !> Unbalanced force ratio at which solvers that know rest alone call it rest: their own tolerance, or what the stage asks for
   !> if that is less.
   pure real(wp) function rest_tolerance(self) result(tolerance)
      class(scene_t), intent(in) :: self

      tolerance = self%deck%implicit%tolerance
      if (self%solver == solver_relaxation) tolerance = self%deck%relaxation%tolerance
      if (self%stage == 0) return
      if (self%until_balanced(self%stage)) tolerance = min(tolerance, self%deck%stage(self%stage)%equilibrium)
   end function rest_tolerance

end module scene_m
