!> Motion of the nodes over one step, and the work done in it.
module motion_m
   use kinds_m, only: wp
   use state_m, only: state_t
   use loads_m, only: loads_t
   implicit none
   private

   public :: move_nodes, unbalanced_ratio

contains

   !> Advance velocities and displacements by one step of eq 1 (semi-implicit Euler, kick then drift) and add the step's
   !> work to the energy account. The work of a force over the kick is f.(v_old + v_new)/2 dt, which changes the kinetic
   !> energy exactly.
   pure subroutine move_nodes(loads, motion, local_damping, dt, damping_force, state)
      type(loads_t), intent(in) :: loads
      !> Prescribed velocities act times this: 1 or a smooth profile while the stage moves, 0 while it rests
      real(wp), intent(in) :: motion
      !> Cundall's local damping: this part of the unbalanced force acts against the velocity (0: none)
      real(wp), intent(in) :: local_damping
      !> Step [s]
      real(wp), intent(in) :: dt
      !> Viscous nodal forces (2, nodes) [N per m]; size zero without viscous damping
      real(wp), contiguous, intent(in) :: damping_force(:, :)
      type(state_t), intent(inout) :: state
      real(wp) :: old, new, force, path, damping, contact, friction, external, dissipated, twice_kinetic
      logical :: viscous
      integer :: n, i

      viscous = size(damping_force, 2) > 0
      contact = 0.0_wp
      friction = 0.0_wp
      external = 0.0_wp
      dissipated = 0.0_wp
      twice_kinetic = 0.0_wp
      do n = 1, size(state%mass)
         do i = 1, 2
            old = state%v(i, n)
            force = state%solid(i, n) + state%normal(i, n) + state%friction(i, n) + state%load(i, n)
            damping = 0.0_wp
            if (viscous) damping = damping_force(i, n)
            if (loads%fixed(i, n)) then
               new = loads%velocity(i, n)*motion
               path = 0.5_wp*(old + new)*dt
               ! Work of the reaction that enforces the motion
               external = external + (state%mass(n)*(new - old)/dt - force - damping)*path
            else
               if (local_damping > 0.0_wp) damping = damping - sign(local_damping*abs(force), old)
               new = old + dt*(force + damping)/state%mass(n)
               path = 0.5_wp*(old + new)*dt
            end if
            contact = contact - state%normal(i, n)*path
            friction = friction - state%friction(i, n)*path
            external = external + state%load(i, n)*path
            dissipated = dissipated - damping*path
            twice_kinetic = twice_kinetic + state%mass(n)*new**2
            state%v(i, n) = new
            state%u(i, n) = state%u(i, n) + dt*new
         end do
      end do
      associate (energy => state%energy)
         energy%kinetic = 0.5_wp*twice_kinetic
         energy%contact = energy%contact + contact
         energy%friction = energy%friction + friction
         energy%external = energy%external + external
         energy%damping = energy%damping + dissipated
      end associate
   end subroutine move_nodes

   !> Unbalanced force ratio: the norm of the net force on free nodes over the norm of what acts on the bodies (loads,
   !> contact and reactions). Zero at equilibrium; 0 when nothing acts.
   pure real(wp) function unbalanced_ratio(loads, state) result(ratio)
      type(loads_t), intent(in) :: loads
      type(state_t), intent(in) :: state
      real(wp) :: net, unbalanced, acting
      integer :: n, i

      unbalanced = 0.0_wp
      acting = 0.0_wp
      do n = 1, size(state%mass)
         do i = 1, 2
            net = state%solid(i, n) + state%normal(i, n) + state%friction(i, n) + state%load(i, n)
            acting = acting + state%normal(i, n)**2 + state%friction(i, n)**2 + state%load(i, n)**2
            if (loads%fixed(i, n)) then
               acting = acting + net**2
            else
               unbalanced = unbalanced + net**2
            end if
         end do
      end do
      ratio = 0.0_wp
      if (acting > 0.0_wp) ratio = sqrt(unbalanced/acting)
   end function unbalanced_ratio

end module motion_m
