!> The model: what a run is made of, built once from deck and mesh. It changes when a stage begins (begin_stage: its loads), when a
!> crack cuts the mesh (recut_m) and when a bond has parted (its walls become a matter of contact); all that a run remembers is
!> in state_m.
module model_m
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

   type, public :: model_t
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
      !> Index of the deck's &cohesive group of each edge of the mesh as read, 0 where it cannot break (edges)
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
   end type model_t

   public :: build_model, begin_stage, build_nodes, build_walls, build_contact, start_contact, first_friction, &
             material_of

contains

   !> Split the mesh, scan the topology and set up rock, joints, walls and the state at rest.
   subroutine build_model(deck, mesh, log, model, state, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(log_t), intent(in) :: log
      type(model_t), intent(out) :: model
      type(state_t), intent(out) :: state
      type(error_list_t), intent(inout) :: errors
      logical, allocatable :: fracture(:)
      integer :: i

      model%deck = deck
      allocate (fracture(size(mesh%group)), source=.false.)
      do i = 1, size(deck%joint)
         fracture(find_group(mesh%group, deck%joint(i)%group, 1)) = .true.
      end do
      model%whole = mesh
      call fracture_cuts(mesh, fracture, model%edges, model%cut, errors)
      if (errors%any()) return
      call split_edges(mesh, model%edges, model%cut, model%split)
      call scan_topology(model%split, model%topology)
      call choose_solver(deck, model%split, model%solver, model%solver_reason)
      ! The deck written beside the results names it
      model%deck%run%solver = solver_name(model%solver)
      call build_rock(model)
      call build_nodes(model)
      call build_joints(model, log)
      call build_contact(model)
      call init_loads(model%split, deck%boundary, model%loads, every_time=.not. deck%plan%skip_loads)
      call init_state(model%mass, size(model%split%joint, 2), model%has_damping, state)
      call start_contact(model, state)
      call start_moving(model, state)
   end subroutine build_model

   !> Triangles.
   subroutine build_rock(model)
      type(model_t), intent(inout) :: model
      real(wp), allocatable :: density(:), young(:), poisson(:)
      integer :: triangles, e, m

      triangles = size(model%split%triangle, 2)
      allocate (density(triangles), young(triangles), poisson(triangles))
      do e = 1, triangles
         m = material_of(model, e)
         density(e) = model%deck%material(m)%density
         young(e) = model%deck%material(m)%young
         poisson(e) = model%deck%material(m)%poisson
      end do
      call init_solid(model%split%x, model%split%triangle, density, young, poisson, model%solid)
      associate (settings => model%deck%explicit)
         ! Damping belongs to motion
         if (model%solver /= solver_explicit) return
         if (.not. model%deck%plan%skip_viscosity) call set_viscosity(model%solid, 0.0_wp)
         if (settings%damping == 'viscous') call set_viscosity(model%solid, settings%damping_factor)
         if (settings%damping == 'local') model%local_damping = settings%damping_factor
      end associate
   end subroutine build_rock

   !> What belongs to the nodes of the split mesh: masses, weights, bounds for the stable step.
   subroutine build_nodes(model)
      type(model_t), intent(inout) :: model
      integer :: nodes, gravity_axis

      nodes = size(model%split%x, 2)
      model%solid%node = model%split%triangle
      if (allocated(model%mass)) deallocate (model%mass, model%weight, model%rock_stiffness, model%rock_damping)
      allocate (model%mass(nodes), model%weight(2, nodes))
      call lumped_mass(model%solid, model%mass)
      do gravity_axis = 1, 2
         model%weight(gravity_axis, :) = model%mass*merge(model%deck%gravity%gx, model%deck%gravity%gy, gravity_axis == 1)
      end do
      allocate (model%rock_stiffness(nodes), model%rock_damping(nodes), source=0.0_wp)
      call solid_stiffness_bound(model%solid, model%rock_stiffness)
      model%has_damping = model%solver == solver_explicit .and. &
                          (model%deck%explicit%damping == 'viscous' .or. .not. model%deck%plan%skip_viscosity)
      if (model%has_damping) call solid_damping_bound(model%solid, model%rock_damping)
   end subroutine build_nodes

   !> Index of the deck's material of a triangle.
   pure integer function material_of(model, e) result(material)
      type(model_t), intent(in) :: model
      !> Triangle
      integer, intent(in) :: e
      integer :: m

      material = 0
      do m = 1, size(model%deck%material)
         if (model%deck%material(m)%group == model%split%group(model%split%triangle_group(e))%name) material = m
      end do
   end function material_of

   !> Laws at the scale of the block edges, coupling options, wall contact.
   subroutine build_joints(model, log)
      type(model_t), intent(inout) :: model
      type(log_t), intent(in) :: log
      real(wp), allocatable :: mean_length(:)
      integer :: j, g

      call init_joints(model%split, model%joints)
      allocate (mean_length(size(model%deck%joint)))
      do g = 1, size(model%deck%joint)
         mean_length(g) = mean_edge_length(model, g)
      end do
      do j = 1, size(model%split%joint, 2)
         g = deck_joint(model, j)
         model%joints%group(j) = g
         associate (settings => model%deck%joint(g), edge => model%topology%edge_of_joint(j))
            call scaled_law(settings%law, settings%settings, model%topology%edge_length(edge), mean_length(g), &
                            model%joints%law(j)%raw)
            model%joints%coupled(j) = settings%coupling == 'coupled'
            model%joints%velocity_friction(j) = settings%friction == 'velocity'
            model%joints%stress_from_walls(j) = settings%normal_stress == 'walls'
            model%joints%literal_aperture(j) = settings%aperture == 'eq31'
            model%joints%wall_handled(j) = settings%contact == 'wall'
            if (settings%normal == 'penalty') model%joints%penalty(j) = penalty_stiffness(model, settings, j)
         end associate
         call model%joints%law(j)%raw%lend(model%joints%penalty(j))
      end do
      call warn_of_guards(model, log)
      call warn_of_closed(model, log)
      call build_walls(model)
   end subroutine build_joints

   !> Contact of all walls that no bond holds, and of the corners between them. Walls of cracks whose law closes may overlap by
   !> all of their closure before contact lets go of them.
   subroutine build_walls(model)
      type(model_t), intent(inout) :: model
      integer :: w

      call init_wall_contact(model%split, model%joints%wall_handled, model%walls, model%joints%bonded)
      ! Those of fractures: where cracks meet, fragments find each other by the general contact
      call init_corners(model%split, walls_touching(model%joints%wall_handled, model%joints%bonded) .and. &
                        model%split%joint_group > 0, model%solid%young, model%deck%contact%corner_factor, model%corners)
      do w = 1, size(model%walls%joint)
         associate (j => model%walls%joint(w))
            if (model%split%joint_group(j) > 0 .or. model%joints%law(j)%raw%own_closure() <= 0.0_wp) cycle
            model%walls%deepest(w) = model%walls%deepest(w) + &
                                     model%joints%law(j)%raw%own_closure()*millimetre/(lets_go*model%joints%length(j))
         end associate
      end do
   end subroutine build_walls

   !> Contact between surfaces that no wall contact looks after.
   subroutine build_contact(model)
      type(model_t), intent(inout) :: model
      type(contact_options_t) :: options
      real(wp), allocatable :: penalty(:)
      integer, allocatable :: walked(:)
      integer :: e

      call expose(model)
      call find_touching(model)
      model%has_walls = size(model%walls%joint) > 0
      model%has_potential_joints = .not. all(model%joints%wall_handled)
      associate (settings => model%deck%contact)
         if (.not. settings%active) return
         options%skin_factor = settings%skin_factor
         options%tangential_factor = settings%tangential_factor
         options%everywhere = .not. model%deck%plan%skip_contact
         options%every_time = .not. model%deck%plan%skip_search
         options%friction = merge(friction_velocity, friction_slider, settings%friction == 'velocity')
         allocate (penalty(size(model%split%triangle, 2)))
         do e = 1, size(penalty)
            penalty(e) = model%deck%material(material_of(model, e))%penalty_factor*model%solid%young(e)
         end do
         walked = surfaces_walked(model%walls, model%split)
         call model%contact%init(model%exposed, penalty, walked(model%exposed_edge), options, held_together(model))
         model%has_contact = model%contact%possible
      end associate
   end subroutine build_contact

   !> Friction coefficient of the surfaces in the general contact before any motion (surface edges).
   function first_friction(model) result(friction)
      type(model_t), intent(in) :: model
      real(wp), allocatable :: friction(:)
      integer :: e

      allocate (friction(size(model%exposed_edge)), source=tan(model%deck%contact%friction_angle*radians))
      do e = 1, size(friction)
         associate (crack => model%exposed%surface_joint(e) - model%bonds%fractures)
            if (model%can_break .and. crack > 0) friction(e) = model%bonds%law(crack)%residual
         end associate
      end do
   end function first_friction

   !> Walls and surfaces that have not felt anything yet.
   subroutine start_contact(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      call init_meeting(model%walls, state%walls)
      call init_choices(model%corners, state%corners)
      if (model%has_contact) call model%contact%start(state%contact)
      state%surface_friction = first_friction(model)
   end subroutine start_contact

   !> Leave out the surface edges that a bond holds.
   subroutine expose(model)
      type(model_t), intent(inout) :: model
      logical, allocatable :: keep(:)
      integer :: e

      model%exposed = model%split
      keep = [(model%split%surface_joint(e) == 0, e=1, size(model%split%surface_joint))]
      do e = 1, size(keep)
         if (.not. keep(e)) keep(e) = .not. model%joints%bonded(model%split%surface_joint(e))
      end do
      model%exposed_edge = pack([(e, e=1, size(keep))], keep)
      associate (exposed => model%exposed, edge => model%exposed_edge)
         exposed%surface = model%split%surface(:, edge)
         exposed%surface_triangle = model%split%surface_triangle(edge)
         exposed%surface_joint = model%split%surface_joint(edge)
         exposed%surface_side = model%split%surface_side(edge)
         exposed%surface_group = model%split%surface_group(edge)
      end associate
   end subroutine expose

   !> A number that is the same for nodes which bonds hold together or once held together: triangles that share one never
   !> meet in the general contact (nodes).
   function held_together(model) result(same)
      type(model_t), intent(in) :: model
      integer, allocatable :: same(:)
      integer :: b, k

      allocate (same(size(model%split%x, 2)))
      same = each_alone(size(same))
      if (.not. model%can_break) return
      do b = 1, size(model%bonds%node, 2)
         do k = 1, 2
            call join(same, model%bonds%node(k, b), model%bonds%node(k + 2, b))
         end do
      end do
      same = representatives(same)
   end function held_together

   !> Nodes of the triangles with a node on a surface.
   subroutine find_touching(model)
      type(model_t), intent(inout) :: model
      logical, allocatable :: on_surface(:), touches(:)
      integer :: e, n

      allocate (on_surface(size(model%split%x, 2)), source=.false.)
      do e = 1, size(model%exposed%surface, 2)
         on_surface(model%exposed%surface(:, e)) = .true.
      end do
      touches = on_surface .or. .not. model%deck%plan%skip_nodes
      do e = 1, size(model%split%triangle, 2)
         if (any(on_surface(model%split%triangle(:, e)))) touches(model%split%triangle(:, e)) = .true.
      end do
      model%touching = pack([(n, n=1, size(touches))], touches)
   end subroutine find_touching

   !> Index of the deck's &joint group of a joint element.
   pure integer function deck_joint(model, j) result(group)
      type(model_t), intent(in) :: model
      integer, intent(in) :: j
      integer :: g

      group = 0
      do g = 1, size(model%deck%joint)
         if (model%deck%joint(g)%group == model%split%group(model%split%joint_group(j))%name) group = g
      end do
   end function deck_joint

   !> Mean length of the block edges of a &joint group [m].
   pure real(wp) function mean_edge_length(model, g) result(mean)
      type(model_t), intent(in) :: model
      !> Index of the deck's &joint group
      integer, intent(in) :: g
      integer :: e, edges

      mean = 0.0_wp
      edges = 0
      do e = 1, size(model%topology%edge_group)
         if (model%split%group(model%topology%edge_group(e))%name /= model%deck%joint(g)%group) cycle
         mean = mean + model%topology%edge_length(e)
         edges = edges + 1
      end do
      if (edges > 0) mean = mean/real(edges, wp)
   end function mean_edge_length

   !> Penalty stiffness of a joint's walls, p over the size of the triangles behind them [MPa/mm].
   pure real(wp) function penalty_stiffness(model, settings, j) result(stiffness)
      type(model_t), intent(in) :: model
      type(joint_t), intent(in) :: settings
      integer, intent(in) :: j
      real(wp) :: penalty, height

      associate (triangle => model%split%joint_triangle(:, j))
         penalty = settings%penalty
         if (.not. is_set(penalty)) penalty = &
            maxval(model%deck%material([material_of(model, triangle(1)), material_of(model, triangle(2))])%penalty_factor* &
                   model%solid%young(triangle))
         height = minval(model%solid%height(triangle))
      end associate
      stiffness = penalty/height/megapascal_per_millimetre
   end function penalty_stiffness

   !> Say once, group by group, where a law had to be kept within its bounds.
   subroutine warn_of_guards(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      type(guard_t), allocatable :: guards(:)
      integer, allocatable :: acted(:)
      integer :: g, j, members

      do g = 1, size(model%deck%joint)
         members = 0
         do j = 1, size(model%joints%group)
            if (model%joints%group(j) /= g) cycle
            guards = model%joints%law(j)%raw%guards()
            if (members == 0) acted = 0*[(j, j=1, size(guards))]
            members = members + 1
            acted = acted + merge(1, 0, guards%acted)
         end do
         if (members == 0) cycle
         do j = 1, size(guards)
            if (acted(j) > 0) call log%warn(to_text(acted(j))//' of '//to_text(members)//' joint elements of '// &
                                            quoted(model%deck%joint(g)%group)//' '//trim(guards(j)%text))
         end do
      end do
   end subroutine warn_of_guards

   !> A joint element both of whose ends are tips has no node of its own: it can neither open nor slide.
   subroutine warn_of_closed(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      logical :: closed(size(model%joints%group))
      integer :: g, j

      closed = [(is_closed(model%split%joint(:, j)), j=1, size(closed))]
      do g = 1, size(model%deck%joint)
         if (count(closed .and. model%joints%group == g) == 0) cycle
         j = findloc(closed .and. model%joints%group == g, .true., dim=1)
         call log%warn(to_text(count(closed .and. model%joints%group == g))//' joint elements of '// &
                       quoted(model%deck%joint(g)%group)//' are fractures of one element with both tips in the rock, as at '// &
                       place_text(model%split%x(:, model%split%joint(1, j)), model%split%datum)//': they cannot open '// &
                       'or slide; a finer mesh can')
      end do
   end subroutine warn_of_closed

   !> Initial velocities.
   subroutine start_moving(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      logical, allocatable :: member(:)
      integer :: i

      do i = 1, size(model%deck%initial)
         member = group_nodes(model%split, model%deck%initial(i)%group, surface_first)
         associate (initial => model%deck%initial(i))
            if (is_set(initial%vx)) where (member) state%v(1, :) = initial%vx
            if (is_set(initial%vy)) where (member) state%v(2, :) = initial%vy
         end associate
      end do
   end subroutine start_moving

   !> Compile the boundary conditions of a stage.
   subroutine begin_stage(model, stage, state)
      type(model_t), intent(inout) :: model
      !> Number of the stage
      integer, intent(in) :: stage
      type(state_t), intent(inout) :: state

      model%stage = stage
      call start_stage(model%split, model%deck%boundary, model%deck%stage%name, stage, model%weight, model%loads)
      call add_pore_pressure(model%split, model%deck%pore_pressure, model%deck%stage%name, stage, filled(model, state), model%loads)
      ! Weight that is not ramped is there from the very start
      if (stage == 1 .and. .not. model%deck%gravity%ramped) model%loads%dead_start = model%weight
      state%load_level = unset
   end subroutine begin_stage

   !> Can fluid be between the walls of a joint element? On fractures, and in cracks that have broken (joints).
   pure function filled(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      logical :: filled(size(model%split%joint, 2))

      filled = .true.
      if (model%can_break) filled(model%bonds%fractures + 1:) = state%bonds%broken
   end function filled

   !> Does the rest of a stage end at equilibrium rather than at a given time?
   pure logical function until_balanced(self, stage)
      class(model_t), intent(in) :: self
      integer, intent(in) :: stage

      until_balanced = is_set(self%deck%stage(stage)%equilibrium)
   end function until_balanced

   !> Longest rest of a stage that ends at equilibrium [s].
   pure real(wp) function longest_rest(self, stage)
      class(model_t), intent(in) :: self
      integer, intent(in) :: stage

      longest_rest = self%deck%stage(stage)%max_rest_time
   end function longest_rest

   !> Unbalanced force ratio at which solvers that know rest alone call it rest: their own tolerance, or what the stage asks for
   !> if that is less.
   pure real(wp) function rest_tolerance(self) result(tolerance)
      class(model_t), intent(in) :: self

      tolerance = self%deck%implicit%tolerance
      if (self%solver == solver_relaxation) tolerance = self%deck%relaxation%tolerance
      if (self%stage == 0) return
      if (self%until_balanced(self%stage)) tolerance = min(tolerance, self%deck%stage(self%stage)%equilibrium)
   end function rest_tolerance

end module model_m
