!> The model: what a run is made of, built once from deck and mesh (build_m). It changes when a stage begins (begin_stage: its
!> loads) and when rock breaks (recut_m: the mesh is cut, or the walls of a bond become a matter of contact); all that a run
!> remembers is in state_m.
module model_m
   use kinds_m, only: wp
   use constants_m, only: is_set, unset, radians
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use field_list_m, only: field_list_t
   use sparse_system_m, only: sparse_system_t, node_groups_t
   use union_find_m, only: each_alone, join, representatives
   use deck_m, only: deck_t
   use mesh_m, only: mesh_t, split_mesh_t
   use edges_m, only: edge_table_t
   use split_m, only: cut_t
   use topology_m, only: topology_t
   use solid_m, only: solid_t, lumped_mass, wave_impedance
   use solid_bound_m, only: solid_stiffness_bound, solid_damping_bound
   use joints_m, only: joints_t
   use joint_border_m, only: largest_closure
   use bonds_m, only: bond_damage, bonds_t
   use wall_layout_m, only: wall_contact_t, init_wall_contact, surfaces_walked, walls_touching
   use wall_contact_m, only: init_meeting, lets_go
   use crossings_m, only: corners_t, init_corners
   use corners_m, only: init_choices
   use contact_layer_m, only: contact_options_t, beside_surface
   use contact_m, only: contact_t
   use friction_m, only: friction_slider, friction_velocity
   use pore_pressure_m, only: add_pore_pressure
   use loads_m, only: loads_t, init_loads, start_stage, start_absorbing
   use motion_m, only: undisturbed_blocks
   use state_m, only: state_t
   use solver_choice_m, only: solver_explicit, solver_implicit, solver_relaxation
   implicit none
   private

   !> What belongs to the nodes of the split mesh
   type, public :: nodes_t
      !> True nodal mass (nodes) [kg per m] and weight (2, nodes) [N per m]
      real(wp), allocatable :: mass(:), weight(:, :)
      !> Row sums of stiffness and damping of the rock (nodes) [N/m, N s/m per m]
      real(wp), allocatable :: rock_stiffness(:), rock_damping(:)
      !> Do they belong to rock that was taken out? They stay where they are (nodes)
      logical, allocatable :: gone(:)
   end type nodes_t

   !> Where a search for rest starts and what it goes to
   type, public :: increment_t
      type(state_t) :: start
      !> Loads at its end, 0 to 1 over the stage
      real(wp) :: level = 0.0_wp
      !> Drag on the free nodes over the stiffness of the rock around them: a force against their displacement since the
      !> start of the increment. 0: none; with it an increment is a step of pseudo-time
      real(wp) :: drag = 0.0_wp
   end type increment_t

   !> A term of the equations of motion: rock, loads, walls, ... Its parameters are in the model, built there, its memory is in the
   !> state; what it does with them is in one module NAME_term_m of this shape. A scene that does not need it does not have it.
   type, abstract, public :: term_t
   contains
      !> is_there(model): does the scene need it?
      procedure(term_is_there), nopass, deferred :: is_there
      !> add_forces(model, state): to the nodal forces of the state, at its displacement and level
      procedure(term_add_forces), nopass, deferred :: add_forces
      !> add_tangent(model, increment, state, system, outside): minus the derivative of these forces, for the implicit solver;
      !> outside is set when the pattern of the system is too small
      procedure, nopass :: add_tangent => no_tangent
      !> join_nodes(model, state, groups): groups of nodes whose forces depend on each other's displacements in that derivative,
      !> now or soon, for the pattern of the system
      procedure, nopass :: join_nodes => none_joined
      !> add_stiffness_bound(model, state, bound): such that u.K u <= sum bound_i |u_i|^2, for the stable step (nodes) [N/m per m]
      procedure, nopass :: add_stiffness_bound => no_bound
      !> find_energy(model, state): its part of state%energy, when the state tells it; what other terms do is the work of their
      !> nodal forces on the way (motion_m, increment_m)
      procedure, nopass :: find_energy => no_energy
      !> results(model, state, list): fields of a snapshot, with units and descriptions
      procedure, nopass :: results => no_results
      !> keep(file, model, state, errors): what a checkpoint holds of it, for saving and for loading
      procedure, nopass :: keep => nothing_kept
   end type term_t

   type, public :: term_item_t
      class(term_t), allocatable :: raw
   end type term_item_t

   type, public :: model_t
      !> All terms, in the order in which their forces are added (terms_m)
      type(term_item_t), allocatable :: term(:)
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
      !> Groups of the outer boundary of the mesh as read (edges)
      integer, allocatable :: outer_group(:)
      !> The split mesh with those surface edges only that no bond holds, and their numbers in split
      type(split_mesh_t) :: exposed
      integer, allocatable :: exposed_edge(:)
      type(contact_t) :: contact
      !> Nodes that contact can push: all of the triangles with a node on a surface
      integer, allocatable :: touching(:)
      !> Nodes that corners can push, and that surfaces can where there are walls too, for the energy account (shares_m)
      integer, allocatable :: corner_reach(:), surface_reach(:)
      !> Blocks of nodes that nothing but the rock acts on (motion_m)
      logical, allocatable :: undisturbed(:)
      type(loads_t) :: loads
      type(nodes_t) :: nodes
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
      !> Number of the stage; how many times rock has broken and changed the model
      integer :: stage = 0, recuts = 0
   contains
      procedure :: until_balanced
      procedure :: longest_rest
      procedure :: rest_tolerance
   end type model_t

   public :: begin_stage, nodes_of, walls_of, corners_of, contact_of, exposed_edges, exposed_mesh, touching_nodes, &
             corner_reach_of, surface_reach_of, start_contact, first_friction, material_of, holds_fluid

   abstract interface
      pure logical function term_is_there(model)
         import :: model_t
         type(model_t), intent(in) :: model
      end function term_is_there

      subroutine term_add_forces(model, state)
         import :: model_t, state_t
         type(model_t), intent(in) :: model
         type(state_t), intent(inout) :: state
      end subroutine term_add_forces
   end interface

contains

   ! ---- Terms that lack something -----------------------------------------------------------------------------------------

   subroutine no_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside

      associate (unused => model, also => increment, too => state, as_well => system, no_more => outside)
      end associate
   end subroutine no_tangent

   subroutine none_joined(model, state, groups)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(node_groups_t), intent(inout) :: groups

      associate (unused => model, also => state, too => groups)
      end associate
   end subroutine none_joined

   subroutine no_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(inout) :: bound(:)

      associate (unused => model, also => state, too => bound)
      end associate
   end subroutine no_bound

   subroutine no_energy(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      associate (unused => model, also => state)
      end associate
   end subroutine no_energy

   subroutine no_results(model, state, list)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(field_list_t), intent(inout) :: list

      associate (unused => model, also => state, too => list)
      end associate
   end subroutine no_results

   subroutine nothing_kept(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors

      associate (unused => file, also => model, too => state, as_well => errors)
      end associate
   end subroutine nothing_kept

   ! ---- Parts of a model --------------------------------------------------------------------------------------------------

   !> What belongs to the nodes of the split mesh: masses, weights, bounds for the stable step.
   function nodes_of(model) result(nodes)
      type(model_t), intent(in) :: model
      type(nodes_t) :: nodes
      integer :: n, gravity_axis, e

      n = size(model%split%x, 2)
      allocate (nodes%mass(n), nodes%weight(2, n))
      allocate (nodes%gone(n), source=.false.)
      allocate (nodes%rock_stiffness(n), nodes%rock_damping(n), source=0.0_wp)
      call lumped_mass(model%solid, nodes%mass)
      do gravity_axis = 1, 2
         nodes%weight(gravity_axis, :) = nodes%mass*merge(model%deck%gravity%gx, model%deck%gravity%gy, gravity_axis == 1)
      end do
      do e = 1, size(model%split%triangle, 2)
         if (.not. model%split%present(e)) nodes%gone(model%split%triangle(:, e)) = .true.
      end do
      ! Nothing moves them: any mass will do
      where (nodes%gone) nodes%mass = 1.0_wp
      call solid_stiffness_bound(model%solid, nodes%rock_stiffness)
      if (model%has_damping) call solid_damping_bound(model%solid, nodes%rock_damping)
   end function nodes_of

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

   !> Contact of all walls that no bond holds. Walls of cracks whose law closes may overlap by all of their closure before contact
   !> lets go of them.
   function walls_of(model) result(walls)
      type(model_t), intent(in) :: model
      type(wall_contact_t) :: walls
      integer :: w

      call init_wall_contact(model%split, model%joints%wall_handled, walls, model%joints%bonded .or. model%joints%gone)
      do w = 1, size(walls%joint)
         associate (j => walls%joint(w))
            if (model%split%joint_group(j) == 0) &
               walls%deepest(w) = walls%deepest(w) + largest_closure(model%joints%law(j)%raw)/(lets_go*model%joints%length(j))
         end associate
      end do
   end function walls_of

   !> Corners between the walls of fractures: where cracks meet, fragments find each other by the general contact.
   function corners_of(model) result(corners)
      type(model_t), intent(in) :: model
      type(corners_t) :: corners

      call init_corners(model%split, walls_touching(model%joints%wall_handled, model%joints%bonded .or. model%joints%gone) .and. &
                        model%split%joint_group > 0, model%solid%young, model%deck%contact%corner_factor, corners)
   end function corners_of

   !> Contact between surfaces that no wall contact looks after, from walls and exposed surfaces.
   function contact_of(model) result(contact)
      type(model_t), intent(in) :: model
      type(contact_t) :: contact
      type(contact_options_t) :: options
      real(wp), allocatable :: penalty(:)
      integer, allocatable :: walked(:)
      integer :: e

      associate (settings => model%deck%contact)
         if (.not. settings%active) return
         options%skin_factor = settings%skin_factor
         options%tangential_factor = settings%tangential_factor
         options%everywhere = .not. model%deck%plan%skip_contact
         options%every_time = .not. model%deck%plan%skip_search
         options%impacts = model%solver == solver_explicit
         options%friction = merge(friction_velocity, friction_slider, settings%friction == 'velocity')
         allocate (penalty(size(model%split%triangle, 2)))
         do e = 1, size(penalty)
            penalty(e) = model%deck%material(material_of(model, e))%penalty_factor*model%solid%young(e)
         end do
         walked = surfaces_walked(model%walls, model%split)
         call contact%init(model%exposed, penalty, walked(model%exposed_edge), options, held_together(model))
      end associate
   end function contact_of

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

   !> Surface edges that no bond holds.
   function exposed_edges(model) result(edge)
      type(model_t), intent(in) :: model
      integer, allocatable :: edge(:)
      logical :: keep(size(model%split%surface_joint))
      integer :: e

      keep = model%split%surface_joint == 0
      do e = 1, size(keep)
         if (.not. keep(e)) keep(e) = .not. model%joints%bonded(model%split%surface_joint(e))
      end do
      edge = pack([(e, e=1, size(keep))], keep)
   end function exposed_edges

   !> The mesh with those surface edges only.
   function exposed_mesh(split, edge) result(exposed)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: edge(:)
      type(split_mesh_t) :: exposed

      exposed = split
      exposed%surface = split%surface(:, edge)
      exposed%surface_triangle = split%surface_triangle(edge)
      exposed%surface_joint = split%surface_joint(edge)
      exposed%surface_side = split%surface_side(edge)
      exposed%surface_group = split%surface_group(edge)
   end function exposed_mesh

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

   !> Nodes that contact can push: those of the objects of contact_m.
   function touching_nodes(model) result(touching)
      type(model_t), intent(in) :: model
      integer, allocatable :: touching(:)
      logical, allocatable :: touches(:), beside(:)
      integer :: e, n

      allocate (touches(size(model%split%x, 2)), source=.not. model%deck%plan%skip_nodes)
      beside = beside_surface(model%exposed, held_together(model))
      do e = 1, size(beside)
         if (beside(e)) touches(model%exposed%triangle(:, e)) = .true.
      end do
      touching = pack([(n, n=1, size(touches))], touches)
   end function touching_nodes

   !> Nodes of corners, each once.
   function corner_reach_of(model) result(reach)
      type(model_t), intent(in) :: model
      integer, allocatable :: reach(:)
      logical :: reached(size(model%split%x, 2))
      integer :: n

      reached = .false.
      if (model%has_walls) reached(reshape(model%corners%node, [size(model%corners%node)])) = .true.
      reach = pack([(n, n=1, size(reached))], reached)
   end function corner_reach_of

   !> Nodes that surfaces can push, where others do too.
   function surface_reach_of(model) result(reach)
      type(model_t), intent(in) :: model
      integer, allocatable :: reach(:)

      reach = [integer ::]
      if (model%has_walls .and. model%has_contact .and. model%solver /= solver_implicit) reach = model%touching
   end function surface_reach_of

   !> Loads and prescribed motion of a stage; of the one that is on, anew: at the nodes of another mesh, with other forces of the
   !> state, or when fluid gets into cracks.
   subroutine begin_stage(model, stage, state)
      type(model_t), intent(inout) :: model
      !> Number of the stage (0: none yet)
      integer, intent(in) :: stage
      type(state_t), intent(inout) :: state

      if (stage == model%stage) then
         call init_loads(model%split, model%deck%boundary, model%loads, every_time=.not. model%deck%plan%skip_loads)
         if (stage > 1) call compile(stage - 1)
      end if
      model%stage = stage
      if (stage > 0) call compile(stage)

   contains

      !> What the deck says about a stage, after the stage before it.
      subroutine compile(stage)
         integer, intent(in) :: stage
         integer :: i

         call start_stage(model%split, model%deck%boundary, model%deck%stage%name, stage, model%nodes%weight, model%loads)
         call add_pore_pressure(model%split, model%deck%pore_pressure, model%deck%stage%name, stage, &
                                holds_fluid(model, state), model%loads)
         if (any(model%deck%boundary%absorbing)) &
            call start_absorbing(model%split, model%deck%boundary, model%deck%stage%name, stage, wave_impedance(model%solid), &
                                 model%loads)
         if (size(state%held, 2) > 0) then
            model%loads%dead_end = model%loads%dead_end + state%held
            model%loads%dead_changes = any(abs(model%loads%dead_end - model%loads%dead_start) > 0.0_wp)
         end if
         ! Weight that is not ramped is there from the very start
         if (stage == 1 .and. .not. model%deck%gravity%ramped) model%loads%dead_start = model%nodes%weight
         ! In-situ stress is in balance with all of them
         if (stage == 1 .and. model%deck%in_situ%line > 0) then
            model%loads%dead_start = model%loads%dead_end
            model%loads%dead_changes = .false.
            model%loads%pressure_start = model%loads%pressure_end
         end if
         do i = 1, 2
            where (model%nodes%gone)
               model%loads%fixed(i, :) = .true.
               model%loads%velocity(i, :) = 0.0_wp
            end where
         end do
         if (size(state%relief, 2) > 0) then
            model%loads%dead_start = model%loads%dead_start + state%relief
            model%loads%dead_changes = .true.
         end if
         state%load_level = unset
         model%undisturbed = undisturbed_blocks(model%loads, model%touching)
      end subroutine compile

   end subroutine begin_stage

   !> Can fluid be between the walls of a joint element? On fractures, and in cracks that have broken or, where &flow says so, are
   !> damaged enough (joints).
   pure function holds_fluid(model, state) result(holds)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      logical :: holds(size(model%split%joint, 2))

      holds = .true.
      if (.not. model%can_break) return
      holds(model%bonds%fractures + 1:) = state%bonds%broken
      if (model%deck%flow%fluid_enters < 1.0_wp) &
         holds = holds .or. bond_damage(model%bonds, state%bonds, size(holds)) >= model%deck%flow%fluid_enters
   end function holds_fluid

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
