!> What breaking rock changes in the model, in one place: edges of the mesh are cut, walls of bonds that have parted become a
!> matter of contact, fluid gets into cracks, rock is taken out. The mesh is split anew along all cuts, which costs as much as a few
!> steps; what the nodes carried goes with their parents. Triangles and joint elements keep their numbers, surface edges too where
!> no rock is taken out.
module recut_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use mesh_m, only: split_mesh_t
   use edges_m, only: edge_table_t
   use split_m, only: add_cuts, node_parents, split_edges
   use cohesive_m, only: cohesive_t, cohesive_law
   use bond_m, only: followed
   use bonds_m, only: add_bonds, place_bonds, start_bond, restore_bonds, is_closed, release_stored
   use coulomb_law_m, only: coulomb_walls
   use joint_law_m, only: joint_law_t
   use law_list_m, only: scaled_law
   use joint_point_m, only: joint_point_t
   use joints_m, only: joints_t, init_joints, add_joints
   use joint_border_m, only: set_penalty, largest_closure
   use wall_layout_m, only: wall_contact_t
   use wall_contact_m, only: wall_meeting_t, init_meeting
   use crossings_m, only: corners_t
   use corners_m, only: corner_choices_t, keep_choices
   use contact_m, only: contact_t, contact_state_t
   use solid_m, only: renumber, take_out
   use solid_stress_m, only: solid_stress, strain_energy
   use forces_m, only: find_forces, forces_now, total_force
   use motion_m, only: undisturbed_blocks
   use release_m, only: hold_back, restart_release
   use cracks_m, only: breaks_t, describe_bond, stress_across
   use model_m, only: model_t, nodes_of, walls_of, corners_of, contact_of, exposed_edges, exposed_mesh, touching_nodes, &
                      corner_reach_of, surface_reach_of, &
                      start_contact, first_friction, begin_stage
   use solver_choice_m, only: solver_explicit
   use state_m, only: state_t, kinetic_energy
   use shares_m, only: no_share
   implicit none
   private

   public :: recut

contains

   !> Bring the model up to what has broken, and the state onto it. Where rock breaks in motion the cut changes no acceleration:
   !> what the new bonds do not carry is held back and let go of smoothly. At rest equilibrium is to be found anew.
   subroutine recut(model, breaks, level, state)
      type(model_t), intent(inout) :: model
      type(breaks_t), intent(in) :: breaks
      !> Loads: 0 at the start of the stage, 1 at its end
      real(wp), intent(in) :: level
      type(state_t), intent(inout) :: state
      integer, allocatable :: parent(:)
      real(wp), allocatable :: acceleration(:, :)
      logical :: moving, searched
      integer :: n

      model%recuts = model%recuts + 1
      if (breaks%at_start) then
         if (size(breaks%edge) > 0 .or. allocated(breaks%taken)) call cut(parent)
         if (size(breaks%edge) > 0 .and. model%deck%in_situ%line > 0) &
            call load_bonds(spread(.true., 1, size(model%bonds%length)), .false.)
         call start_walls()
         return
      end if
      if (allocated(breaks%taken)) then
         call dig()
         return
      end if
      if (size(breaks%parted) > 0) then
         do n = 1, size(breaks%parted)
            call hand_over(model, breaks%parted(n), state)
         end do
         model%joints%bonded(model%bonds%fractures + breaks%parted) = .false.
         call renew_walls([(n, n=1, size(state%mass))], [(n, n=1, size(model%split%surface, 2))])
      end if
      if (breaks%filled) call begin_stage(model, model%stage, state)
      if (size(breaks%edge) == 0) return
      moving = model%solver == solver_explicit
      if (moving) then
         call find_forces(model, level, state, searched)
         acceleration = total_force(state)/spread(state%mass, 1, 2)
      end if
      call cut_under_stress(moving, parent)
      if (.not. moving) return
      call restart_release(model%solid, parent, state)
      call find_forces(model, level, state, searched)
      call hold_back(parent, acceleration, total_force(state), state)

   contains

      !> Cut the edges: new nodes, joint elements and bonds, loads at the new nodes.
      subroutine cut(parent)
         !> Node that each node was before (nodes)
         integer, allocatable, intent(out) :: parent(:)
         type(split_mesh_t) :: before
         !> Scaled over true mass, true mass (nodes before)
         real(wp) :: added(size(state%mass)), mass(size(state%mass))
         logical :: there(size(model%split%present))

         before = model%split
         there = before%present
         if (allocated(breaks%taken)) there = there .and. .not. breaks%taken
         call add_cuts(model%edges, breaks%edge, model%cut)
         call split_edges(model%whole, model%edges, model%cut, model%split, there)
         parent = node_parents(before, model%split)
         mass = model%nodes%mass
         added = state%mass/max(model%nodes%mass, tiny(1.0_wp))
         call renumber(model%split%triangle, size(model%split%x, 2), model%solid)
         call take_out(there, model%solid)
         model%nodes = nodes_of(model)
         call follow_parents(parent, state)
         ! What mass scaling has added stays, shared out like the rock: no momentum and no kinetic energy comes or goes
         state%mass = added(parent)*model%nodes%mass
         if (size(state%relief, 2) > 0) &
            state%relief = state%relief(:, parent)*spread(model%nodes%mass/max(mass(parent), tiny(1.0_wp)), 1, 2)
         if (size(state%held, 2) > 0) &
            state%held = state%held(:, parent)*spread(model%nodes%mass/max(mass(parent), tiny(1.0_wp)), 1, 2)
         model%joints = with_bonds(model%split, model%joints)
         call join_joints(size(breaks%edge), model%topology%edge_of_joint, state)
         if (model%can_break) call join_bonds()
         model%breakable(breaks%edge) = 0
         where (.not. sound_edges(model%edges, there)) model%breakable = 0
         model%is_adaptive = any(model%breakable > 0)
         ! Nodes have other numbers now: which of them contact can push is found with the walls
         model%touching = [integer ::]
         call begin_stage(model, model%stage, state)
      end subroutine cut

      !> Take rock out: what it was part of is free, and what it had exerted on the rest stays as a load that goes to zero over the
      !> stage. It takes its energy along.
      subroutine dig()
         type(split_mesh_t) :: split
         real(wp) :: before(2, size(state%u, 2)), stored
         integer :: i

         before = forces_now(model, level, state)
         stored = kinetic_energy(state%mass, state%v) + strain_energy(model%solid, state%u)
         split = model%split
         call cut(parent)
         if (model%can_break) state%release = state%release(:, parent)
         call let_go_of_joints(model, state)
         call renew_walls(parent, surface_numbers(split, model%split))
         state%relief = before(:, parent) - forces_now(model, level, state)
         do i = 1, 2
            where (model%nodes%gone)
               state%v(i, :) = 0.0_wp
               state%relief(i, :) = 0.0_wp
            end where
         end do
         call begin_stage(model, model%stage, state)
         state%energy%strain = strain_energy(model%solid, state%u)
         state%energy%kinetic = kinetic_energy(state%mass, state%v)
         state%energy%external = state%energy%external + state%energy%strain + state%energy%kinetic - stored
      end subroutine dig

      !> Bonds of the new cuts, without stress; the law of each crack for the time when its bond has parted.
      subroutine join_bonds()
         type(cohesive_t) :: law(size(breaks%edge))
         class(joint_law_t), allocatable :: of_crack
         integer :: setting(size(breaks%edge)), i, first

         first = size(model%split%joint, 2) - size(breaks%edge)
         do i = 1, size(breaks%edge)
            setting(i) = model%breakable(breaks%edge(i))
            law(i) = rock_law(model, first + i, setting(i))
         end do
         call add_bonds(model%bonds, state%bonds, model%joints%length(first + 1:), law, setting)
         associate (beside => model%split%joint_triangle(1, model%bonds%fractures + 1:))
            call place_bonds(model%bonds, model%split%joint(:, model%bonds%fractures + 1:), model%split%x, &
                             model%solid%patches%turn(beside), model%solid%patches%colour)
         end associate
         do i = 1, size(breaks%edge)
            associate (j => first + i)
               call crack_law(model, setting(i), law(i), of_crack)
               call move_alloc(of_crack, model%joints%law(j)%raw)
               ! Laws without a closure of their own press with the stiffness of the bond
               call set_penalty(model%joints, j, merge(0.0_wp, law(i)%stiffness, largest_closure(model%joints%law(j)%raw) > 0.0_wp))
            end associate
         end do
      end subroutine join_bonds

      !> Cut edges and let their bonds start at the stress of the rock. So do bonds that could not open until now: what they
      !> were put in with is no longer true.
      subroutine cut_under_stress(no_jump, parent)
         !> Are bonds made as strong as the stress they start at, so that no force jumps?
         logical, intent(in) :: no_jump
         integer, allocatable, intent(out) :: parent(:)
         logical, allocatable :: fresh(:)
         integer :: b, e, before

         before = size(state%bonds%active)
         allocate (fresh(before + size(breaks%edge)), source=.true.)
         do b = 1, before
            fresh(b) = is_closed(model%bonds%node(:, b))
         end do
         call cut(parent)
         call renew_walls(parent, [(e, e=1, size(model%split%surface, 2))])
         call load_bonds(fresh, no_jump)
      end subroutine cut_under_stress

      !> Let bonds start at the stress of the rock.
      subroutine load_bonds(fresh, no_jump)
         !> Which ones (bonds)
         logical, intent(in) :: fresh(:)
         !> Are bonds made as strong as the stress they start at, so that no force jumps?
         logical, intent(in) :: no_jump
         real(wp) :: normal, shear
         integer :: b, e

         do b = 1, size(fresh)
            if (.not. fresh(b)) cycle
            e = model%cut%edge(model%bonds%fractures + b)
            associate (beside => model%edges%triangle(:, e))
               call stress_across(model, state, e, 0.5_wp*(solid_stress(model%solid, beside(1), state%u) + &
                                                           solid_stress(model%solid, beside(2), state%u)), normal, shear)
            end associate
            call start_bond(model%bonds, state%bonds, b, rock_law(model, model%bonds%fractures + b, model%bonds%setting(b)), &
                            normal, shear, no_jump)
         end do
      end subroutine load_bonds

      !> Walls, corners and general contact of all that no bond holds.
      subroutine find_walls()

         model%walls = walls_of(model)
         model%corners = corners_of(model)
         model%exposed_edge = exposed_edges(model)
         model%exposed = exposed_mesh(model%split, model%exposed_edge)
         model%touching = touching_nodes(model)
         model%undisturbed = undisturbed_blocks(model%loads, model%touching)
         model%contact = contact_of(model)
         model%has_walls = size(model%walls%joint) > 0
         model%has_potential_joints = .not. all(model%joints%wall_handled)
         model%has_contact = model%contact%possible
         model%corner_reach = corner_reach_of(model)
         model%surface_reach = surface_reach_of(model)
      end subroutine find_walls

      !> Walls and surfaces that have not felt anything yet; bonds as a checkpoint has them.
      subroutine start_walls()

         if (model%can_break) state%release = 0.0_wp*state%u
         if (allocated(breaks%bond)) then
            call restore_bonds(breaks%bond, model%bonds, state%bonds)
            model%joints%bonded(model%bonds%fractures + 1:) = state%bonds%active
         end if
         call find_walls()
         call start_contact(model, state)
      end subroutine start_walls

      !> Walls and general contact after cuts, after bonds have parted or rock was taken out; they go on as they were.
      subroutine renew_walls(parent, number)
         !> Node that each node was before (nodes); number that each surface edge has now, 0 for none (surface edges before)
         integer, intent(in) :: parent(:), number(:)
         type(wall_contact_t) :: walls
         type(wall_meeting_t) :: meeting
         type(corners_t) :: corners
         type(corner_choices_t) :: choices
         type(contact_t) :: contact
         type(contact_state_t) :: touching
         integer, allocatable :: edge(:)
         logical :: had_contact

         walls = model%walls
         meeting = state%walls
         corners = model%corners
         choices = state%corners
         had_contact = model%has_contact
         if (had_contact) contact = model%contact
         if (had_contact) touching = state%contact
         edge = number(model%exposed_edge)
         call find_walls()
         call init_meeting(model%walls, state%walls)
         call keep_meeting(walls, meeting, number, model%walls, state%walls)
         call keep_choices(corners, choices, parent, model%corners, state%corners)
         state%surface_friction = first_friction(model)
         if (had_contact) then
            call model%contact%carry_on(contact, touching, edge, model%exposed_edge, parent, model%exposed, state%u, &
                                        state%contact)
         else if (model%has_contact) then
            call model%contact%start(state%contact)
         end if
      end subroutine renew_walls

   end subroutine recut

   !> A bond has parted: its walls go to the contact with the stresses they have, and with what these store.
   subroutine hand_over(model, b, state)
      type(model_t), intent(in) :: model
      integer, intent(in) :: b
      type(state_t), intent(inout) :: state
      real(wp) :: normal, shear

      associate (j => model%bonds%fractures + b)
         call describe_bond(model, state, b)
         state%bonds%active(b) = .false.
         state%tractions%contact_stress(j) = state%joint(j)%sn
         state%joint(j)%u_max = abs(state%joint(j)%u)
      end associate
      call release_stored(model%bonds, b, state%bonds, normal, shear)
      state%energy%contact = state%energy%contact + normal
      state%energy%friction = state%energy%friction + shear
   end subroutine hand_over

   !> Joints and bonds beside rock that was taken out carry nothing any more.
   subroutine let_go_of_joints(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      where (model%joints%gone)
         state%joint%sn = 0.0_wp
         state%joint%tau = 0.0_wp
         state%tractions%contact_stress = 0.0_wp
         state%tractions%covered = 0.0_wp
      end where
      if (.not. model%can_break) return
      where (model%joints%gone(model%bonds%fractures + 1:))
         state%bonds%active = .false.
         state%bonds%watch = followed
      end where
   end subroutine let_go_of_joints

   !> Are the triangles on all sides of an edge there? (edges)
   pure function sound_edges(edges, there) result(sound)
      type(edge_table_t), intent(in) :: edges
      !> (triangles)
      logical, intent(in) :: there(:)
      logical :: sound(size(edges%triangles))
      integer :: e

      sound = [(all(there(edges%triangle(:min(2, edges%triangles(e)), e))), e=1, size(sound))]
   end function sound_edges

   !> Number that each surface edge has after rock was taken out (surface edges before); 0: it is no surface any more. An edge is
   !> known by the triangle that owns it and the corner at its start.
   pure function surface_numbers(before, after) result(number)
      type(split_mesh_t), intent(in) :: before, after
      integer :: number(size(before%surface, 2))
      integer :: known(3, size(after%triangle, 2)), e

      known = 0
      do e = 1, size(after%surface, 2)
         associate (t => after%surface_triangle(e))
            known(findloc(after%triangle(:, t), after%surface(1, e), dim=1), t) = e
         end associate
      end do
      do e = 1, size(number)
         associate (t => before%surface_triangle(e))
            number(e) = known(findloc(before%triangle(:, t), before%surface(1, e), dim=1), t)
         end associate
      end do
   end function surface_numbers

   !> Walls that were in contact before face each other where they did.
   pure subroutine keep_meeting(old_walls, old, number, walls, meeting)
      type(wall_contact_t), intent(in) :: old_walls, walls
      type(wall_meeting_t), intent(in) :: old
      !> Number that each surface edge has now, 0 for none (surface edges before)
      integer, intent(in) :: number(:)
      type(wall_meeting_t), intent(inout) :: meeting
      integer :: was(max(maxval([0, walls%joint]), maxval([0, old_walls%joint]))), w

      was = 0
      do w = 1, size(old_walls%joint), 2
         was(old_walls%joint(w)) = w
      end do
      do w = 1, size(walls%joint), 2
         associate (before => was(walls%joint(w)))
            if (before == 0) cycle
            if (any(old%facing(before:before + 1) == 0)) cycle
            if (any(number(old%facing(before:before + 1)) == 0)) cycle
            meeting%facing(w:w + 1) = number(old%facing(before:before + 1))
            meeting%reached(w:w + 1) = old%reached(before:before + 1)
         end associate
      end do
   end subroutine keep_meeting

   !> Joint elements with bonds in the new cuts at their end, and the new nodes of the old ones.
   function with_bonds(split, old) result(joints)
      type(split_mesh_t), intent(in) :: split
      type(joints_t), intent(in) :: old
      type(joints_t) :: joints
      integer :: n

      n = size(old%group)
      call init_joints(split, joints)
      joints%group(:n) = old%group
      joints%law(:n) = old%law
      joints%penalty(:n) = old%penalty
      joints%coupled(:n) = old%coupled
      joints%velocity_friction(:n) = old%velocity_friction
      joints%stress_from_walls(:n) = old%stress_from_walls
      joints%literal_aperture(:n) = old%literal_aperture
      joints%wall_handled(:n) = old%wall_handled
      joints%closed(:n) = old%closed
      joints%slipped(:n) = old%slipped
      joints%bonded(:n) = old%bonded
      joints%bonded(n + 1:) = .true.
   end function with_bonds

   !> What the joint elements of new cuts remember: rest.
   subroutine join_joints(cuts, edge_of_joint, state)
      integer, intent(in) :: cuts
      !> Block edge of each joint element (joints); 0: of none
      integer, allocatable, intent(inout) :: edge_of_joint(:)
      type(state_t), intent(inout) :: state
      type(joint_point_t), allocatable :: point(:)
      integer :: n, j

      n = size(state%joint)
      allocate (point(n + cuts))
      point(:n) = state%joint
      call move_alloc(point, state%joint)
      edge_of_joint = [edge_of_joint, [(0, j=1, cuts)]]
      state%opening = [state%opening, [(0.0_wp, j=1, cuts)]]
      state%aperture = [state%aperture, [(0.0_wp, j=1, cuts)]]
      call add_joints(size(state%joint), state%tractions)
   end subroutine join_joints

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
      call no_share(state%corner_force)
      call no_share(state%surface_force)
      if (size(state%damping, 2) > 0) state%damping = 0.0_wp*state%damping(:, parent)
   end subroutine follow_parents

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
         law = coulomb_walls(settings%crack_friction_angle, bond%stiffness)
      end associate
   end subroutine crack_law

end module recut_m
