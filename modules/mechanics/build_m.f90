!> Building a model from deck and mesh: rock, joints with their laws, where rock may break, and the state at rest.
module build_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use errors_m, only: error_list_t
   use text_m, only: to_text, quoted
   use log_m, only: log_t
   use deck_m, only: deck_t
   use joint_group_m, only: joint_t
   use cohesive_group_m, only: all_rock
   use edges_m, only: find_edge
   use mesh_m, only: mesh_t, find_group, surface_first, place_text, a_curve
   use split_m, only: fracture_cuts, split_edges
   use topology_m, only: scan_topology
   use solid_m, only: solid_t, init_solid, set_in_situ, set_viscosity
   use in_situ_group_m, only: in_situ_stress
   use joint_point_m, only: joint_point_t
   use joint_law_m, only: guard_t
   use law_list_m, only: scaled_law
   use joints_m, only: joints_t, init_joints
   use joint_border_m, only: set_penalty, settle
   use bonds_m, only: init_bonds, is_closed
   use loads_m, only: init_loads, group_nodes
   use model_m, only: model_t, nodes_of, material_of
   use terms_m, only: all_terms
   use cracks_m, only: breaks_t
   use recut_m, only: recut
   use state_m, only: state_t, init_state
   use solver_choice_m, only: choose_solver, solver_name, solver_explicit
   implicit none
   private

   public :: build_model

contains

   !> Split the mesh, scan the topology and set up rock, joints, walls and the state at rest; cut what is to be cut from the start.
   subroutine build_model(deck, mesh, log, model, state, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(log_t), intent(in) :: log
      type(model_t), intent(out) :: model
      type(state_t), intent(out) :: state
      type(error_list_t), intent(inout) :: errors
      logical, allocatable :: fracture(:)
      integer, allocatable :: breakable(:)
      type(breaks_t) :: breaks
      integer :: i

      model%term = all_terms()
      model%deck = deck
      allocate (fracture(size(mesh%group)), source=.false.)
      do i = 1, size(deck%joint)
         fracture(find_group(mesh%group, deck%joint(i)%group, 1)) = .true.
      end do
      model%whole = mesh
      call fracture_cuts(mesh, fracture, model%edges, model%cut, errors)
      if (errors%any()) return
      call split_edges(mesh, model%edges, model%cut, model%split)
      model%outer_group = model%split%surface_group(:count(model%split%surface_joint == 0))
      call scan_topology(model%split, model%topology)
      call choose_solver(deck, model%split, model%solver, model%solver_reason)
      ! The deck written beside the results names it
      model%deck%run%solver = solver_name(model%solver)
      model%solid = rock_of(model)
      ! Damping belongs to motion
      if (model%solver == solver_explicit) then
         if (deck%explicit%damping == 'local') model%local_damping = deck%explicit%damping_factor
         model%has_damping = deck%explicit%damping == 'viscous' .or. .not. deck%plan%skip_viscosity
      end if
      model%nodes = nodes_of(model)
      model%joints = joints_of(model)
      call warn_of_guards(model, log)
      call warn_of_closed(model, log)
      call init_loads(model%split, deck%boundary, model%loads, every_time=.not. deck%plan%skip_loads)
      call init_state(model%nodes%mass, size(model%split%joint, 2), model%has_damping, state)
      if (deck%in_situ%line > 0) call press_joints(model, log, state)
      call init_bonds(size(model%split%joint, 2), model%bonds, state%bonds)
      call start_moving(model, state)
      call find_breakable(model, breakable, breaks%edge)
      call move_alloc(breakable, model%breakable)
      model%can_break = any(model%breakable > 0)
      if (model%can_break) model%check_every = minval(deck%cohesive%check_every)
      model%is_adaptive = any(model%breakable > 0)
      breaks%at_start = .true.
      call recut(model, breaks, 0.0_wp, state)
      call warn_of_bonds(model, log)
   end subroutine build_model

   !> Triangles.
   function rock_of(model) result(solid)
      type(model_t), intent(in) :: model
      type(solid_t) :: solid
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
      if (allocated(model%whole%patch)) then
         call init_solid(model%split%x, model%split%triangle, density, young, poisson, solid, model%whole%patch)
      else
         call init_solid(model%split%x, model%split%triangle, density, young, poisson, solid)
      end if
      if (model%deck%in_situ%line > 0) call set_in_situ(in_situ_stresses(model), solid)
      if (model%solver /= solver_explicit) return
      associate (settings => model%deck%explicit)
         if (.not. model%deck%plan%skip_viscosity) call set_viscosity(solid, 0.0_wp)
         if (settings%damping == 'viscous') call set_viscosity(solid, settings%damping_factor)
      end associate
   end function rock_of

   !> In-situ stress in the middle of each triangle, tension positive (3, triangles) [Pa].
   function in_situ_stresses(model) result(stress)
      type(model_t), intent(in) :: model
      real(wp) :: stress(3, size(model%split%triangle, 2))
      integer :: e

      do e = 1, size(stress, 2)
         stress(:, e) = in_situ_stress(model%deck%in_situ, &
                                       model%split%datum(2) + sum(model%split%x(2, model%split%triangle(:, e)))/3.0_wp)
      end do
   end function in_situ_stresses

   !> Bring a joint element to the in-situ stress in its middle.
   pure subroutine settle_in_situ(model, joints, j, point, closed, slipped, weak)
      type(model_t), intent(in) :: model
      type(joints_t), intent(in) :: joints
      integer, intent(in) :: j
      type(joint_point_t), intent(out) :: point
      !> Overlap and slip that make the stress [m]; is it too weak for it?
      real(wp), intent(out) :: closed, slipped
      logical, intent(out) :: weak

      associate (a => model%split%x(:, model%split%joint(1, j)), b => model%split%x(:, model%split%joint(2, j)))
         call settle(joints, j, in_situ_stress(model%deck%in_situ, model%split%datum(2) + 0.5_wp*(a(2) + b(2))), b - a, point, &
                     closed, slipped, weak)
      end associate
   end subroutine settle_in_situ

   !> Joints in the state that in-situ stress has brought them to.
   subroutine press_joints(model, log, state)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      type(state_t), intent(inout) :: state
      real(wp) :: closed, slipped
      logical :: weak(size(state%joint))
      integer :: j, g

      do j = 1, size(weak)
         call settle_in_situ(model, model%joints, j, state%joint(j), closed, slipped, weak(j))
      end do
      do g = 1, size(model%deck%joint)
         if (any(weak .and. model%joints%group == g)) &
            call log%warn(to_text(count(weak .and. model%joints%group == g))//' of '//to_text(count(model%joints%group == g))// &
                          ' joint elements of '//quoted(model%deck%joint(g)%group)//' cannot carry their part of the in-situ '// &
                          'stress: they slip or open in the first stage')
      end do
   end subroutine press_joints

   !> Laws at the scale of the block edges, coupling options.
   function joints_of(model) result(joints)
      type(model_t), intent(in) :: model
      type(joints_t) :: joints
      real(wp), allocatable :: mean_length(:)
      type(joint_point_t) :: point
      real(wp) :: penalty
      logical :: weak
      integer :: j, g

      call init_joints(model%split, joints)
      allocate (mean_length(size(model%deck%joint)))
      do g = 1, size(model%deck%joint)
         mean_length(g) = mean_edge_length(model, g)
      end do
      do j = 1, size(model%split%joint, 2)
         g = deck_joint(model, j)
         joints%group(j) = g
         associate (settings => model%deck%joint(g), edge => model%topology%edge_of_joint(j))
            call scaled_law(settings%law, settings%settings, model%topology%edge_length(edge), mean_length(g), joints%law(j)%raw)
            joints%coupled(j) = settings%coupling == 'coupled'
            joints%velocity_friction(j) = settings%friction == 'velocity'
            joints%stress_from_walls(j) = settings%normal_stress == 'walls'
            joints%literal_aperture(j) = settings%aperture == 'eq31'
            joints%wall_handled(j) = settings%contact == 'wall'
            penalty = 0.0_wp
            if (settings%normal == 'penalty') penalty = penalty_stiffness(model, settings, j)
         end associate
         call set_penalty(joints, j, penalty)
         if (model%deck%in_situ%line > 0) &
            call settle_in_situ(model, joints, j, point, joints%closed(j), joints%slipped(j), weak)
      end do
   end function joints_of

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

   !> Penalty stiffness of a joint's walls, p over the size of the triangles behind them [Pa/m].
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
      stiffness = penalty/height
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

   ! ---- Rock that may break ---------------------------------------------------------------------------------------------

   !> Which &cohesive each edge of the mesh follows, and which edges are cut from the start.
   subroutine find_breakable(model, breakable, at_start)
      type(model_t), intent(in) :: model
      !> Index of the &cohesive group (edges); 0: cannot break
      integer, allocatable, intent(out) :: breakable(:)
      integer, allocatable, intent(out) :: at_start(:)
      logical, allocatable :: chosen_at_start(:), on_curve(:, :)
      integer :: e, i, k, of(2), chosen, curve
      character(len=:), allocatable :: insertion

      allocate (breakable(size(model%edges%triangles)), source=0)
      allocate (chosen_at_start(size(breakable)), source=.false.)
      allocate (on_curve(size(breakable), size(model%deck%cohesive)), source=.false.)
      do k = 1, size(model%deck%cohesive)
         curve = find_group(model%whole%group, model%deck%cohesive(k)%curve, a_curve)
         do i = 1, size(model%whole%line_group)
            if (curve == 0 .or. model%whole%line_group(i) /= curve) cycle
            e = find_edge(model%edges, model%whole%line(1, i), model%whole%line(2, i))
            if (e > 0) on_curve(e, k) = .true.
         end do
      end do
      do e = 1, size(breakable)
         if (size(model%deck%cohesive) == 0) exit
         if (model%edges%triangles(e) /= 2) cycle
         do k = 1, 2
            of(k) = cohesive_of(model, model%edges%triangle(k, e))
         end do
         ! Between two kinds of rock the weaker breaks; an edge of a surface to rock that cannot break belongs to
         ! 'everywhere' only
         if (all(of > 0)) then
            chosen = of(1)
            if (model%deck%cohesive(of(2))%tensile_strength < model%deck%cohesive(of(1))%tensile_strength) chosen = of(2)
         else
            chosen = maxval(of)
            if (chosen == 0) cycle
            if (model%deck%cohesive(chosen)%insertion /= 'everywhere') cycle
         end if
         insertion = trim(model%deck%cohesive(chosen)%insertion)
         if (insertion == 'none') cycle
         if (model%deck%cohesive(chosen)%curve /= '') then
            if (.not. on_curve(e, chosen)) cycle
         end if
         breakable(e) = chosen
         chosen_at_start(e) = insertion /= 'adaptive'
      end do
      breakable(model%cut%edge) = 0
      chosen_at_start(model%cut%edge) = .false.
      at_start = pack([(e, e=1, size(breakable))], chosen_at_start)
   end subroutine find_breakable

   !> Index of the &cohesive group of a triangle: that of its surface before that of all rock; 0: none.
   pure integer function cohesive_of(model, triangle) result(fracture)
      type(model_t), intent(in) :: model
      integer, intent(in) :: triangle
      integer :: i

      fracture = 0
      do i = 1, size(model%deck%cohesive)
         if (fracture == 0 .and. model%deck%cohesive(i)%group == all_rock) fracture = i
      end do
      do i = 1, size(model%deck%cohesive)
         if (model%deck%cohesive(i)%group == model%split%group(model%split%triangle_group(triangle))%name) fracture = i
      end do
   end function cohesive_of

   !> Say when the stiffness of the bonds is too low for the fracture energies.
   subroutine warn_of_bonds(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      integer :: soft

      soft = count(.not. model%bonds%law%sound)
      if (soft > 0) call log%warn(to_text(soft)//' of '//to_text(size(model%bonds%law))//' cohesive joints store more energy '// &
                                  'up to their strength than breaking them takes: larger penalty_factor or smaller elements')
   end subroutine warn_of_bonds

end module build_m
