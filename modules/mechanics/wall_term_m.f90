!> Walls of joints that face each other: where they meet (wall_contact_m) and what the law of the joint lets pass
!> (joint_border_m).
module wall_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_laws, work_walls
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use field_list_m, only: field_list_t, on_joints
   use wall_layout_m, only: wall_contact_t
   use model_m, only: model_t, term_t, increment_t
   use state_m, only: state_t
   use joint_point_m, only: joint_point_t, joint_values, joint_from_values, joint_value_count
   use wall_contact_m, only: wall_meeting_t, meet_walls, add_wall_forces, wall_stiffness_bound, point_stiffness_bound, &
                             points_of_joints
   use wall_layout_m, only: wall_contact_t
   use wall_point_m, only: add_energy_forces
   use joints_m, only: joints_t
   use joint_border_m, only: couple_walls, joint_stiffness, stiffness_at_points
   use wall_tangent_m, only: wall_element_t, joint_wall_tangent
   use sparse_system_m, only: sparse_system_t, node_groups_t, add_block
   implicit none
   private

   type, extends(term_t), public :: wall_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_tangent
      procedure, nopass :: join_nodes
      procedure, nopass :: add_stiffness_bound
      procedure, nopass :: results
      procedure, nopass :: keep
   end type wall_term_t

   !> Edges a wall may slide past in either direction before the pattern of the matrix is built again
   integer, parameter :: reach = 1

contains

   !> Where joints are in wall contact.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = model%has_walls
   end function is_there

   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      call now_doing(work_walls)
      call meet_walls(model%walls, model%split%x, state%u, state%walls)
      call now_doing(work_laws)
      call couple_walls(model%joints, model%walls, state%walls, model%solid, model%split%x, state%u, state%v, &
                        state%tractions, state%joint, state%opening, state%aperture)
      call now_doing(work_walls)
      call add_wall_forces(state%walls, state%tractions%pressure, state%tractions%shear, state%normal, state%friction)
      if (model%can_break) call add_energy_forces(state%walls, of_cracks(model%joints, model%walls, state%walls), &
                                                  state%tractions%pressure, model%split%x, state%u, state%normal)
   end subroutine add_forces

   !> Points between walls of cracks that press on each other like a spring, those of bonds that have parted (points). Fractures
   !> and cracks with a closure of their own are left: what closes them is not all given back.
   pure function of_cracks(joints, walls, met) result(elastic)
      type(joints_t), intent(in) :: joints
      type(wall_contact_t), intent(in) :: walls
      type(wall_meeting_t), intent(in) :: met
      logical :: elastic(met%points)
      integer :: k

      do k = 1, met%points
         elastic(k) = is_spring(walls%joint(met%wall(k)))
         if (met%faced_joint(k) > 0) elastic(k) = elastic(k) .and. is_spring(met%faced_joint(k))
      end do

   contains

      pure logical function is_spring(j)
         integer, intent(in) :: j

         is_spring = joints%group(j) == 0 .and. joints%penalty(j) > 0.0_wp
      end function is_spring

   end function of_cracks

   subroutine add_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside
      !> Elements that are found before any is added
      integer, parameter :: batch = 64
      type(wall_element_t) :: element(batch)
      integer :: first(size(model%walls%joint)/2 + 1), i, begin, last

      associate (unused => increment)
      end associate
      call points_of_joints(state%walls, first)
      do begin = 1, size(first) - 1, batch
         last = min(begin + batch, size(first)) - 1
         !$omp parallel do schedule(static) default(none) shared(model, state, element, first, begin, last)
         do i = begin, last
            associate (j => model%walls%joint(2*i))
               call joint_wall_tangent(model%joints, state%walls, state%tractions, j, first(i), first(i + 1) - 1, model%split%x, &
                                       state%u, state%joint(j), element(i - begin + 1))
            end associate
         end do
         !$omp end parallel do
         ! In their order, whoever found them
         do i = 1, last - begin + 1
            call add_block(system, element(i)%node(:element(i)%nodes), element(i)%stiffness, outside)
         end do
      end do
   end subroutine add_tangent

   !> The nodes of each joint with those its walls face and their neighbours, so that a wall can slide some way.
   subroutine join_nodes(model, state, groups)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(node_groups_t), intent(inout) :: groups
      integer :: first(size(model%walls%joint)/2 + 1), i, k

      call points_of_joints(state%walls, first)
      do i = 1, size(first) - 1
         call groups%join(model%joints%node(:, model%walls%joint(2*i)))
         call add_faced(model%walls, state%walls%facing(2*i - 1), groups)
         call add_faced(model%walls, state%walls%facing(2*i), groups)
         do k = first(i), first(i + 1) - 1
            call groups%add(state%walls%point_node(:, k))
            call groups%add(pack(state%walls%beside(:, k), state%walls%beside(:, k) > 0))
         end do
      end do
   end subroutine join_nodes

   !> Nodes of the surface edge that a wall faces and of those within reach; also those of other blocks that end there and
   !> may come to share what these cover.
   subroutine add_faced(walls, facing, groups)
      type(wall_contact_t), intent(in) :: walls
      !> Surface edge, 0: none
      integer, intent(in) :: facing
      type(node_groups_t), intent(inout) :: groups
      integer :: edge, next, passed

      edge = facing
      if (edge == 0) return
      ! Back to the first edge within reach, then forward over all of them
      do passed = 1, reach
         if (walls%before(edge) == 0) exit
         edge = walls%before(edge)
      end do
      next = walls%before(edge)
      if (next > 0) call groups%add(walls%surface(2:2, next))
      do passed = 1, 2*reach + 1
         call groups%add(walls%surface(:, edge))
         next = walls%after(edge)
         if (next == 0) exit
         edge = next
      end do
      if (next > 0) call groups%add(walls%surface(1:1, next))
   end subroutine add_faced

   subroutine add_stiffness_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(inout) :: bound(:)
      real(wp) :: of_edges(size(bound)), of_points(size(bound))

      state%tractions%stiffness_then = joint_stiffness(model%joints%law, model%joints%penalty, &
                                                       state%tractions%contact_stiffness, state%joint)
      call meet_walls(model%walls, model%split%x, state%u, state%walls)
      state%walls%moved_on = .false.
      of_edges = 0.0_wp
      call wall_stiffness_bound(model%walls, state%walls, model%split%x, &
                                state%tractions%stiffness_then(model%walls%joint), of_edges)
      of_points = 0.0_wp
      call point_stiffness_bound(state%walls, stiffness_at_points(model%joints, model%walls, state%walls, state%tractions, &
                                                                  state%joint), of_points)
      bound = bound + max(of_edges, of_points)
   end subroutine add_stiffness_bound

   !> Of all joints, those in potential contact too.
   subroutine results(model, state, list)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(field_list_t), intent(inout) :: list

      associate (joint => state%joint)
         call list%add('shear_displacement_mm', 'mm', 'shear displacement u (eq 30)', on_joints, joint%u)
         call list%add('opening_mm', 'mm', 'opening w, negative when the walls overlap (eq 30)', on_joints, state%opening)
         call list%add('aperture_mm', 'mm', 'aperture (eq 31)', on_joints, state%aperture)
         call list%add('closure_mm', 'mm', 'closure by normal stress (eq 5b)', on_joints, joint%vn)
         call list%add('dilation_mm', 'mm', 'dilation by shear (eq 18)', on_joints, joint%dilation)
         call list%add('normal_stress_MPa', 'MPa', 'normal stress, compression positive', on_joints, joint%sn)
         call list%add('shear_stress_MPa', 'MPa', 'shear stress, with the sign of the slip', on_joints, joint%tau)
         call list%add('mobilised_friction', '-', 'mobilised friction coefficient (eq 33)', on_joints, joint%mu_mob)
      end associate
      if (any(model%deck%stage%remove /= '')) &
         call list%add('joint_removed', '-', '1 where the rock on a side was taken out, else 0', on_joints, &
                       merge(1.0_wp, 0.0_wp, model%joints%gone))
   end subroutine results

   subroutine keep(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: table(:, :)

      associate (unused => model)
      end associate
      allocate (table, source=joint_table(state%joint))
      call file%keep('joints', table, errors)
      if (errors%any()) return
      if (.not. file%writing) call joints_from_table(table, state%joint)
      call file%keep('opening', state%opening, errors)
      call file%keep('aperture', state%aperture, errors)
      call file%keep('contact_stiffness', state%tractions%contact_stiffness, errors)
      call file%keep('normal_force', state%normal, errors)
      call file%keep('friction_force', state%friction, errors)
      call file%keep('facing', state%walls%facing, errors)
      call file%keep('reached', state%walls%reached, errors)
   end subroutine keep

   !> Joint elements as a table (values, joints).
   pure function joint_table(joint) result(table)
      type(joint_point_t), intent(in) :: joint(:)
      real(wp), allocatable :: table(:, :)
      integer :: j

      allocate (table(joint_value_count, size(joint)))
      do j = 1, size(joint)
         table(:, j) = joint_values(joint(j))
      end do
   end function joint_table

   pure subroutine joints_from_table(table, joint)
      real(wp), intent(in) :: table(:, :)
      type(joint_point_t), intent(out) :: joint(:)
      integer :: j

      do j = 1, size(joint)
         joint(j) = joint_from_values(table(:, j))
      end do
   end subroutine joints_from_table

end module wall_term_m
