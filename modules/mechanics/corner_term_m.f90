!> Corners of blocks, point against point (corners_m).
module corner_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_walls
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use model_m, only: model_t, term_t, increment_t
   use solver_choice_m, only: solver_explicit
   use state_m, only: state_t
   use corners_m, only: add_corner_forces, corner_tangent, corner_nodes, corner_stiffness_bound
   use shares_m, only: begin_share, end_share
   use sparse_system_m, only: sparse_system_t, node_groups_t, add_block
   implicit none
   private

   type, extends(term_t), public :: corner_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_tangent
      procedure, nopass :: join_nodes
      procedure, nopass :: add_stiffness_bound
      procedure, nopass :: keep
   end type corner_term_t

contains

   !> Where blocks have corners between walls in contact.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = model%has_walls .and. size(model%corners%stiffness) > 0
   end function is_there

   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      call now_doing(work_walls)
      call begin_share(model%corner_reach, state%normal, state%friction, state%corner_force)
      call add_corner_forces(model%corners, state%corners, state%u, state%normal)
      call end_share(model%corner_reach, state%normal, state%friction, state%corner_force)
   end subroutine add_forces

   subroutine add_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside
      integer :: i

      associate (unused => increment)
      end associate
      do i = 1, size(model%corners%stiffness)
         call add_block(system, corner_nodes(model%corners, i), corner_tangent(model%corners, state%corners, i, state%u), outside)
      end do
   end subroutine add_tangent

   subroutine join_nodes(model, state, groups)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(node_groups_t), intent(inout) :: groups
      integer :: i

      associate (unused => state)
      end associate
      do i = 1, size(model%corners%stiffness)
         call groups%join(corner_nodes(model%corners, i))
      end do
   end subroutine join_nodes

   subroutine add_stiffness_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(inout) :: bound(:)

      call corner_stiffness_bound(model%corners, state%corners, bound)
   end subroutine add_stiffness_bound

   subroutine keep(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: closure(:, :)

      call file%keep('corners', state%corners%held, errors)
      call file%keep('corners_passed', state%corners%passed, errors)
      call file%keep('corners_stage_depth', state%corners%stage_depth, errors)
      call file%keep('corners_turns', state%corners%turns, errors)
      call file%keep_if_any('corner_force', state%corner_force, errors)
      if (model%solver /= solver_explicit) return
      allocate (closure(2, 0))
      if (state%corners%closure_kept) closure = state%corners%closure
      call file%keep_if_any('corners_closure', closure, errors)
      if (file%writing) return
      state%corners%closure_kept = size(closure) > 0
      if (state%corners%closure_kept) state%corners%closure = closure
   end subroutine keep

end module corner_term_m
