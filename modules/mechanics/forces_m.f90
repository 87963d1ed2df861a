!> What every solver asks of all terms (term_t), in one place: forces, stored energies, bounds of the stiffness.
module forces_m
   use kinds_m, only: wp
   use stopwatch_m, only: doing, now_doing, work_rock, work_walls
   use model_m, only: model_t
   use state_m, only: state_t
   implicit none
   private

   public :: find_forces, find_energies, stiffness_bound, net_force, total_force, forces_now

contains

   !> All nodal forces at the current displacement, joints and bonds taken there in one step from what they remember.
   subroutine find_forces(model, level, state, searched)
      type(model_t), intent(in) :: model
      !> Loads: 0 at the start of the stage, 1 at its end
      real(wp), intent(in) :: level
      type(state_t), intent(inout) :: state
      !> Has contact found new pairs, so that the stable step has to be looked at again?
      logical, intent(out) :: searched
      integer :: i, searches, before

      before = doing()
      searches = state%contact%searches
      state%level = level
      call now_doing(work_rock)
      if (size(state%damping, 2) > 0) state%damping = 0.0_wp
      if (model%has_walls .or. model%has_contact) then
         call now_doing(work_walls)
         call clear_at(model%touching, state%normal)
         call clear_at(model%touching, state%friction)
      end if
      do i = 1, size(model%term)
         if (model%term(i)%raw%is_there(model)) call model%term(i)%raw%add_forces(model, state)
      end do
      searched = state%contact%searches /= searches
      call now_doing(before)
   end subroutine find_forces

   !> What is stored in the terms that know it from the state.
   subroutine find_energies(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      integer :: i

      do i = 1, size(model%term)
         if (model%term(i)%raw%is_there(model)) call model%term(i)%raw%find_energy(model, state)
      end do
   end subroutine find_energies

   !> Nodal bounds of the stiffness of all terms at the present state (nodes) [N/m per m of thickness].
   subroutine stiffness_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(out) :: bound(:)
      integer :: i

      bound = 0.0_wp
      do i = 1, size(model%term)
         if (model%term(i)%raw%is_there(model)) call model%term(i)%raw%add_stiffness_bound(model, state, bound)
      end do
      ! Local damping adds its part of the force to it while that acts against the motion
      bound = (1.0_wp + model%local_damping)*bound
   end subroutine stiffness_bound

   !> No force yet at some nodes.
   pure subroutine clear_at(node, force)
      integer, intent(in) :: node(:)
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: i

      do i = 1, size(node)
         force(:, node(i)) = 0.0_wp
      end do
   end subroutine clear_at

   !> Sum of all nodal forces but viscous ones (2, nodes) [N per m of thickness].
   pure function net_force(state) result(force)
      type(state_t), intent(in) :: state
      real(wp) :: force(2, size(state%u, 2))

      force = state%solid + state%normal + state%friction + state%load
   end function net_force

   !> All forces on the nodes but prescribed ones' reactions (2, nodes) [N per m].
   function total_force(state) result(force)
      type(state_t), intent(in) :: state
      real(wp), allocatable :: force(:, :)

      force = net_force(state)
      if (size(state%damping, 2) > 0) force = force + state%damping
   end function total_force

   !> All forces on the nodes, joints taken there from what they remember (2, nodes) [N per m of thickness].
   function forces_now(model, level, state) result(force)
      type(model_t), intent(in) :: model
      !> Loads: 0 at the start of the stage, 1 at its end
      real(wp), intent(in) :: level
      type(state_t), intent(in) :: state
      real(wp) :: force(2, size(state%u, 2))
      type(state_t) :: trial
      logical :: searched

      trial = state
      call find_forces(model, level, trial, searched)
      force = net_force(trial)
   end function forces_now

end module forces_m
