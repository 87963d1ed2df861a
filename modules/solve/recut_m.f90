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
   use scene_m, only: scene_t, build_nodes, build_walls, build_contact, start_contact, &
                      first_friction, begin_stage
   use state_m, only: state_t
   implicit none
   private

   public :: recut, renew_contact, renew_loads, restore_contact, rock_law

contains

   !> Cut edges of the mesh: each becomes a bond without stress.
   subroutine recut(scene, state, edge, parent)
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state
      !> Edges of the mesh as read, interior and not cut yet
      integer, intent(in) :: edge(:)
      !> Node that each node was before (nodes)
      integer, allocatable, intent(out) :: parent(:)
      type(split_mesh_t) :: before
      !> Scaled over true mass (nodes before)
      real(wp) :: added(size(state%mass))

      before = scene%split
      call add_cuts(scene%edges, edge, scene%cut)
      call split_edges(scene%whole, scene%edges, scene%cut, scene%split)
      parent = node_parents(before, scene%split)
      added = state%mass/max(scene%mass, tiny(1.0_wp))
      call build_nodes(scene)
      call follow_parents(parent, state)
      ! What mass scaling has added stays, shared out like the rock: no momentum and no kinetic energy comes or goes
      state%mass = added(parent)*scene%mass
      call join_joints(scene, state)
      call join_bonds(scene, edge, state)
      call renew_loads(scene, state)
      call renew_contact(scene, parent, state)
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
   subroutine join_joints(scene, state)
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state
      type(joints_t) :: old
      type(joint_point_t), allocatable :: point(:)
      integer :: n, j

      old = scene%joints
      n = size(old%group)
      call init_joints(scene%split, scene%joints)
      associate (joints => scene%joints)
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
         scene%topology%edge_of_joint = [scene%topology%edge_of_joint, [(0, j=n + 1, size(joints%group))]]
         state%opening = [state%opening, [(0.0_wp, j=n + 1, size(joints%group))]]
         state%aperture = [state%aperture, [(0.0_wp, j=n + 1, size(joints%group))]]
      end associate
      point(:n) = state%joint
      call move_alloc(point, state%joint)
      call add_joints(size(state%joint), state%tractions)
   end subroutine join_joints

   !> Bonds of the new cuts; the law of each crack for the time when its bond has parted.
   subroutine join_bonds(scene, edge, state)
      type(scene_t), intent(inout) :: scene
      integer, intent(in) :: edge(:)
      type(state_t), intent(inout) :: state
      type(cohesive_t) :: law(size(edge))
      integer :: setting(size(edge)), i, first, j

      first = size(scene%split%joint, 2) - size(edge)
      do i = 1, size(edge)
         setting(i) = scene%breakable(edge(i))
         law(i) = rock_law(scene, first + i, setting(i))
      end do
      call add_bonds(scene%bonds, state%bonds, scene%joints%length(first + 1:), law, setting)
      scene%bonds%node = scene%split%joint(:, scene%bonds%fractures + 1:)
      do i = 1, size(edge)
         j = first + i
         call crack_law(scene, setting(i), law(i), scene%joints%law(j)%raw)
         associate (of_crack => scene%joints%law(j)%raw)
            ! Laws without a closure of their own press with the stiffness of the bond
            if (of_crack%own_closure() <= 0.0_wp) scene%joints%penalty(j) = law(i)%stiffness/megapascal_per_millimetre
            call of_crack%lend(scene%joints%penalty(j))
         end associate
      end do
   end subroutine join_bonds

   !> Cohesive law of an edge.
   pure type(cohesive_t) function rock_law(scene, joint, setting) result(law)
      type(scene_t), intent(in) :: scene
      !> Joint element, and index of the deck's &fracture group
      integer, intent(in) :: joint, setting
      real(wp) :: young, size_of_elements

      associate (settings => scene%deck%fracture(setting), triangle => scene%split%joint_triangle(:, joint))
         young = maxval(scene%solid%young(triangle))
         ! The side of a square of two triangles
         size_of_elements = sqrt(sum(scene%solid%area(triangle)))
         law = cohesive_law(settings%tensile_strength, settings%cohesion, tan(settings%friction_angle*radians), &
                            tan(settings%crack_friction_angle*radians), settings%g_i, settings%g_ii, &
                            settings%penalty_factor*young/size_of_elements, settings%insertion == 'adaptive')
      end associate
   end function rock_law

   !> Law of the contact of a crack: that of a &joint, at the scale of its laboratory sample, or Coulomb friction with the
   !> stiffness of the bond.
   subroutine crack_law(scene, setting, bond, law)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: setting
      type(cohesive_t), intent(in) :: bond
      class(joint_law_t), allocatable, intent(out) :: law
      real(wp) :: sample
      integer :: g

      associate (settings => scene%deck%fracture(setting))
         do g = 1, size(scene%deck%joint)
            if (scene%deck%joint(g)%group /= settings%crack_joint) cycle
            sample = scene%deck%joint(g)%settings%number('l0')
            call scaled_law(scene%deck%joint(g)%law, scene%deck%joint(g)%settings, sample, sample, law)
            return
         end do
         law = coulomb_law_t(friction_angle=settings%crack_friction_angle, cohesion=0.0_wp, &
                             kn=bond%stiffness/megapascal_per_millimetre, ks=bond%stiffness/megapascal_per_millimetre, a0=0.0_wp)
      end associate
   end subroutine crack_law

   !> Loads and prescribed motion at the nodes of the new mesh, in the stage that is on; also when fluid gets into cracks.
   subroutine renew_loads(scene, state)
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state
      integer :: stage

      stage = scene%stage
      call init_loads(scene%split, scene%deck%boundary, scene%loads, every_time=.not. scene%deck%plan%skip_loads)
      if (stage > 1) call begin_stage(scene, stage - 1, state)
      if (stage > 0) call begin_stage(scene, stage, state)
   end subroutine renew_loads

   !> Wall contact and general contact after cuts, or after bonds have parted; they go on as they were.
   subroutine renew_contact(scene, parent, state)
      type(scene_t), intent(inout) :: scene
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

      corners = scene%corners
      choices = state%corners
      allocate (facing(2, size(scene%joints%group)), source=0)
      allocate (reached(2, size(scene%joints%group)), source=0.0_wp)
      do w = 1, size(scene%walls%joint), 2
         facing(:, scene%walls%joint(w)) = state%walls%facing(w:w + 1)
         reached(:, scene%walls%joint(w)) = state%walls%reached(w:w + 1)
      end do
      call build_walls(scene)
      call init_meeting(scene%walls, state%walls)
      call keep_choices(corners, choices, parent, scene%corners, state%corners)
      do w = 1, size(scene%walls%joint), 2
         ! Surface edges keep their numbers
         associate (j => scene%walls%joint(w))
            if (any(facing(:, j) == 0)) cycle
            state%walls%facing(w:w + 1) = facing(:, j)
            state%walls%reached(w:w + 1) = reached(:, j)
         end associate
      end do
      had_contact = scene%has_contact
      if (had_contact) contact = scene%contact
      if (had_contact) touching = state%contact
      edge = scene%exposed_edge
      call build_contact(scene)
      state%surface_friction = first_friction(scene)
      if (had_contact) then
         call scene%contact%carry_on(contact, touching, edge, scene%exposed_edge, parent, scene%exposed, state%u, state%contact)
      else if (scene%has_contact) then
         call scene%contact%start(state%contact)
      end if
   end subroutine renew_contact

   !> Walls and general contact of a run that goes on from a checkpoint, once its bonds are known; they remember nothing yet.
   subroutine restore_contact(scene, state)
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state

      call build_walls(scene)
      call build_contact(scene)
      call start_contact(scene, state)
   end subroutine restore_contact

end module recut_m
