!> Forces that new cuts would set free at once: held back, and let go of smoothly, so that the acceleration of no node jumps.
module release_m
   use kinds_m, only: wp
   use solid_m, only: solid_t
   use state_m, only: state_t
   implicit none
   private

   public :: hold_back, restart_release, release_factor

   !> New cracks let go of the force that their bonds do not carry over this many times the time a wave takes through an
   !> element
   real(wp), parameter :: release_passages = 10.0_wp

contains

   !> Hold back the forces that new cuts would set free at once, and let go of them over some passages of a wave through
   !> an element: so the acceleration of no node jumps.
   subroutine hold_back(parent, acceleration, force, state)
      !> Node that each node was before the cut (nodes)
      integer, intent(in) :: parent(:)
      !> Acceleration before the cut (2, nodes before) [m/s2], force after it, with what is held back already (2, nodes) [N/m]
      real(wp), intent(in) :: acceleration(:, :), force(:, :)
      type(state_t), intent(inout) :: state
      integer :: copies(size(acceleration, 2)), n

      copies = 0
      do n = 1, size(parent)
         copies(parent(n)) = copies(parent(n)) + 1
      end do
      do n = 1, size(parent)
         if (copies(parent(n)) > 1) state%release(:, n) = state%release(:, n) + state%mass(n)*acceleration(:, parent(n)) &
                                                          - force(:, n)
      end do
   end subroutine hold_back

   !> What is left to let go of at the present time goes to the copies of the nodes as one; the clock starts again.
   subroutine restart_release(solid, parent, state)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: parent(:)
      type(state_t), intent(inout) :: state
      real(wp) :: left(2, size(state%release, 2))
      integer :: copies(size(state%release, 2)), n

      left = state%release*release_factor(state)
      copies = 0
      do n = 1, size(parent)
         copies(parent(n)) = copies(parent(n)) + 1
      end do
      deallocate (state%release)
      allocate (state%release(2, size(parent)), source=0.0_wp)
      do n = 1, size(parent)
         if (copies(parent(n)) == 1) state%release(:, n) = left(:, parent(n))
      end do
      state%release_start = state%time
      state%release_time = release_passages*maxval(solid%height*sqrt(solid%density/solid%young))
   end subroutine restart_release

   !> Part of the forces held back that still acts.
   pure real(wp) function release_factor(state) result(factor)
      type(state_t), intent(in) :: state

      factor = 0.0_wp
      if (state%release_time > 0.0_wp) factor = max(0.0_wp, 1.0_wp - (state%time - state%release_start)/state%release_time)
   end function release_factor

end module release_m
