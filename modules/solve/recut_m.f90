!> Cutting more edges of a scene's mesh while it runs. The mesh is split anew along all cuts, which costs as much as a few
!> steps; what the nodes carried goes with their parents, and joint elements and surface edges keep their numbers.
module recut_m
   use kinds_m, only: wp
   use constants_m, only: megapascal_per_millimetre, radians
   use mesh_m, only: split_mesh_t
   use split_m, only: add_cuts, node_parents, split_edges
   use cohesive_m, only: cohesive_t, cohesive_law
   use bonds_m, only: add_bonds
   use coulomb_law_m, only: coulomb_law_t
   use joint_law_m, only: joint_law_t
   use law_list_m, only: scaled_law
   use joint_point_m, only: joint_point_t
   use joints_m, only: joints_t, init_joints, add_joints
   use wall_contact_m, only: init_meeting
   use corners_m, only: corners_t, corner_choices_t, keep_choices
   use contact_m, only: contact_t, contact_state_t
   use loads_m, only: init_loads
   use model_m, only: model_t, build_nodes, build_walls, build_contact, start_contact, &
                      first_friction, begin_stage
   use state_m, only: state_t
   implicit none
   private

   public :: recut, renew_contact, renew_loads, restore_contact, rock_law

contains

   !> Cut edges of the mesh: each becomes a bond without stress.
   subroutine recut(model, state, edge, parent)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      !> Edges of the mesh as read, interior and not cut yet
      integer, intent(in) :: edge(:)
      !> Node that each node was before (nodes)
      integer, allocatable, intent(out) :: parent(:)
      type(split_mesh_t) :: before
      !> Scaled over true mass (nodes before)
      real(wp) :: added(size(state%mass))

      before = model%split
      call add_cuts(model%edges, edge, model%cut)
      call split_edges(model%whole, model%edges, model%cut, model%split)
      parent = node_parents(before, model%split)
      added = state%mass/max(model%mass, tiny(1.0_wp))
      call build_nodes(model)
      call follow_parents(parent, state)
      ! What mass scaling has added stays, shared out like the rock: no momentum and no kinetic energy comes or goes
      state%mass = added(parent)*model%mass
      call join_joints(model, state)
      call join_bonds(model, edge, state)
      call renew_loads(model, state)
      call renew_contact(model, parent, state)
   end subroutine recut

   !> What the nodes carry goes to all their copies.
   pure subroutine follow_parents(parent, state)
      integer, intent(in) :: parent(:)
      type(state_t), intent(inout) :: state

      state%u = state%u(:, parent)
      state%v = state%v(:, parent)
      state%solid = state%solid(:, parent)
      state%load = state%load(:, parent)
      state%guess%move = state%guess%move(:, parent)
      state%normal = 0.0_wp*state%normal(:, parent)
      state%friction = 0.0_wp*state%friction(:, parent)
      if (size(state%damping, 2) > 0) state%damping = 0.0_wp*state%damping(:, parent)
   end subroutine follow_parents

   !> Joint elements of the new cuts, at rest, and the new nodes of the old ones.
   subroutine join_joints(model, state)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      type(joints_t) :: old
      type(joint_point_t), allocatable :: point(:)
      integer :: n, j

      old = model%joints
      n = size(old%group)
      call init_joints(model%split, model%joints)
      associate (joints => model%joints)
         joints%group(:n) = old%group
         joints%law(:n) = old%law
         joints%penalty(:n) = old%penalty
         joints%coupled(:n) = old%coupled
         joints%velocity_friction(:n) = old%velocity_friction
         joints%stress_from_walls(:n) = old%stress_from_walls
         joints%literal_aperture(:n) = old%literal_aperture
         joints%wall_handled(:n) = old%wall_handled
         joints%bonded(:n) = old%bonded
         joints%bonded(n + 1:) = .true.
         allocate (point(size(joints%group)))
         model%topology%edge_of_joint = [model%topology%edge_of_joint, [(0, j=n + 1, size(joints%group))]]
         state%opening = [state%opening, [(0.0_wp, j=n + 1, size(joints%group))]]
         state%aperture = [state%aperture, [(0.0_wp, j=n + 1, size(joints%group))]]
      end associate
      point(:n) = state%joint
      call move_alloc(point, state%joint)
      call add_joints(size(state%joint), state%tractions)
   end subroutine join_joints

   !> Bonds of the new cuts; the law of each crack for the time when its bond has parted.
   subroutine join_bonds(model, edge, state)
      type(model_t), intent(inout) :: model
      integer, intent(in) :: edge(:)
      type(state_t), intent(inout) :: state
      type(cohesive_t) :: law(size(edge))
      integer :: setting(size(edge)), i, first, j

      first = size(model%split%joint, 2) - size(edge)
      do i = 1, size(edge)
         setting(i) = model%breakable(edge(i))
         law(i) = rock_law(model, first + i, setting(i))
      end do
      call add_bonds(model%bonds, state%bonds, model%joints%length(first + 1:), law, setting)
      model%bonds%node = model%split%joint(:, model%bonds%fractures + 1:)
      do i = 1, size(edge)
         j = first + i
         call crack_law(model, setting(i), law(i), model%joints%law(j)%raw)
         associate (of_crack => model%joints%law(j)%raw)
            ! Laws without a closure of their own press with the stiffness of the bond
            if (of_crack%own_closure() <= 0.0_wp) model%joints%penalty(j) = law(i)%stiffness/megapascal_per_millimetre
            call of_crack%lend(model%joints%penalty(j))
         end associate
      end do
   end subroutine join_bonds

   !> Cohesive law of an edge.
   pure type(cohesive_t) function rock_law(model, joint, setting) result(law)
      type(model_t), intent(in) :: model
      !> Joint element, and index of the deck's &cohesive group
      integer, intent(in) :: joint, setting
      real(wp) :: young, size_of_elements

      associate (settings => model%deck%cohesive(setting), triangle => model%split%joint_triangle(:, joint))
         young = maxval(model%solid%young(triangle))
         ! The side of a square of two triangles
         size_of_elements = sqrt(sum(model%solid%area(triangle)))
         law = cohesive_law(settings%tensile_strength, settings%cohesion, tan(settings%friction_angle*radians), &
                            tan(settings%crack_friction_angle*radians), settings%g_i, settings%g_ii, &
                            settings%penalty_factor*young/size_of_elements, settings%insertion == 'adaptive')
      end associate
   end function rock_law

   !> Law of the contact of a crack: that of a &joint, at the scale of its laboratory sample, or Coulomb friction with the
   !> stiffness of the bond.
   subroutine crack_law(model, setting, bond, law)
      type(model_t), intent(in) :: model
      integer, intent(in) :: setting
      type(cohesive_t), intent(in) :: bond
      class(joint_law_t), allocatable, intent(out) :: law
      real(wp) :: sample
      integer :: g

      associate (settings => model%deck%cohesive(setting))
         do g = 1, size(model%deck%joint)
            if (model%deck%joint(g)%group /= settings%crack_joint) cycle
            sample = model%deck%joint(g)%settings%number('l0')
            call scaled_law(model%deck%joint(g)%law, model%deck%joint(g)%settings, sample, sample, law)
            return
         end do
         law = coulomb_law_t(friction_angle=settings%crack_friction_angle, cohesion=0.0_wp, &
                             kn=bond%stiffness/megapascal_per_millimetre, ks=bond%stiffness/megapascal_per_millimetre, a0=0.0_wp)
      end associate
   end subroutine crack_law

   !> Loads and prescribed motion at the nodes of the new mesh, in the stage that is on; also when fluid gets into cracks.
   subroutine renew_loads(model, state)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      integer :: stage

      stage = model%stage
      call init_loads(model%split, model%deck%boundary, model%loads, every_time=.not. model%deck%plan%skip_loads)
      if (stage > 1) call begin_stage(model, stage - 1, state)
      if (stage > 0) call begin_stage(model, stage, state)
   end subroutine renew_loads

   !> Wall contact and general contact after cuts, or after bonds have parted; they go on as they were.
   subroutine renew_contact(model, parent, state)
      type(model_t), intent(inout) :: model
      integer, intent(in) :: parent(:)
      type(state_t), intent(inout) :: state
      type(corners_t) :: corners
      type(corner_choices_t) :: choices
      type(contact_t) :: contact
      type(contact_state_t) :: touching
      integer, allocatable :: edge(:), facing(:, :)
      real(wp), allocatable :: reached(:, :)
      integer :: w
      logical :: had_contact

      corners = model%corners
      choices = state%corners
      allocate (facing(2, size(model%joints%group)), source=0)
      allocate (reached(2, size(model%joints%group)), source=0.0_wp)
      do w = 1, size(model%walls%joint), 2
         facing(:, model%walls%joint(w)) = state%walls%facing(w:w + 1)
         reached(:, model%walls%joint(w)) = state%walls%reached(w:w + 1)
      end do
      call build_walls(model)
      call init_meeting(model%walls, state%walls)
      call keep_choices(corners, choices, parent, model%corners, state%corners)
      do w = 1, size(model%walls%joint), 2
         ! Surface edges keep their numbers
         associate (j => model%walls%joint(w))
            if (any(facing(:, j) == 0)) cycle
            state%walls%facing(w:w + 1) = facing(:, j)
            state%walls%reached(w:w + 1) = reached(:, j)
         end associate
      end do
      had_contact = model%has_contact
      if (had_contact) contact = model%contact
      if (had_contact) touching = state%contact
      edge = model%exposed_edge
      call build_contact(model)
      state%surface_friction = first_friction(model)
      if (had_contact) then
         call model%contact%carry_on(contact, touching, edge, model%exposed_edge, parent, model%exposed, state%u, state%contact)
      else if (model%has_contact) then
         call model%contact%start(state%contact)
      end if
   end subroutine renew_contact

   !> Walls and general contact of a run that goes on from a checkpoint, once its bonds are known; they remember nothing yet.
   subroutine restore_contact(model, state)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state

      call build_walls(model)
      call build_contact(model)
      call start_contact(model, state)
   end subroutine restore_contact

end module recut_m
