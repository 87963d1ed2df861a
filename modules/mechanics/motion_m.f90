!> Motion of the nodes over one step, and the work done in it.
module motion_m
   use kinds_m, only: wp
   use state_m, only: state_t
   use loads_m, only: loads_t
   use absorbing_m, only: dashpot_force
   implicit none
   private

   public :: move_nodes, undisturbed_blocks, unbalanced_ratio

   !> Nodes handled together
   integer, parameter :: block_size = 128
   !> Numbers of the energy account that a step finds
   integer, parameter :: works = 6

   !> What a step does to every node alike
   type, public :: pace_t
      !> Prescribed velocities act times this: 1 or a smooth profile while the stage moves, 0 while it rests
      real(wp) :: motion = 1.0_wp
      !> Cundall's local damping: this part of the unbalanced force acts against the velocity (0: none)
      real(wp) :: local_damping = 0.0_wp
      !> Time that the forces act on the velocities, and time that the nodes go on with these [s]
      real(wp) :: kick = 0.0_wp, drift = 0.0_wp
   end type pace_t

contains

   !> Advance velocities and displacements by one step of eq 1 (kick then drift) and add the work of the kick to the energy
   !> account; the kinetic energy after it is there at no cost.
   subroutine move_nodes(loads, pace, state, undisturbed)
      type(loads_t), intent(in) :: loads
      type(pace_t), intent(in) :: pace
      type(state_t), intent(inout) :: state
      !> Blocks of nodes that only the rock acts on, see undisturbed_blocks; none unless given
      logical, intent(in), optional :: undisturbed(:)
      logical :: alone((size(state%mass) + block_size - 1)/block_size)
      real(wp) :: work(works, size(alone)), total(works)
      integer :: b, dashpot(size(alone) + 1)

      alone = .false.
      if (present(undisturbed) .and. size(state%damping, 2) == 0) alone = undisturbed
      dashpot = first_dashpots(loads, size(alone))
      !$omp parallel do default(none) schedule(static) private(b) &
      !$omp& shared(loads, pace, state, alone, work, dashpot)
      do b = 1, size(alone)
         call move_block(loads, pace, (b - 1)*block_size + 1, min(b*block_size, size(state%mass)), alone(b), &
                         dashpot(b:b + 1), state, work(:, b))
      end do
      !$omp end parallel do
      total = 0.0_wp
      do b = 1, size(alone)
         total = total + work(:, b)
      end do
      associate (energy => state%energy)
         energy%contact = energy%contact + total(1)
         energy%friction = energy%friction + total(2)
         energy%external = energy%external + total(3)
         energy%damping = energy%damping + total(4)
         energy%absorbed = energy%absorbed + total(5)
         energy%kinetic = total(6)
      end associate
   end subroutine move_nodes

   !> The same for a block of nodes.
   pure subroutine move_block(loads, pace, first, last, alone, dashpot, state, work)
      type(loads_t), intent(in) :: loads
      type(pace_t), intent(in) :: pace
      integer, intent(in) :: first, last
      !> Does the rock alone act on them?
      logical, intent(in) :: alone
      !> Their first node with dashpots, and the first of the next block
      integer, intent(in) :: dashpot(2)
      type(state_t), intent(inout) :: state
      !> Work against contact and friction, of loads and reactions, against damping, of waves that leave; kinetic energy [J per m]
      real(wp), intent(out) :: work(works)
      real(wp), dimension(2, block_size) :: viscous, absorbed, mass, free
      integer :: m, i

      work = 0.0_wp
      m = last - first + 1
      do i = 1, 2
         mass(i, :m) = state%mass(first:last)
      end do
      if (alone) then
         call kick_and_drift_alone(2*m, pace, mass, state%solid(:, first:last), state%v(:, first:last), &
                                   state%u(:, first:last), work)
         return
      end if
      viscous = 0.0_wp
      if (size(state%damping, 2) > 0) viscous(:, :m) = state%damping(:, first:last)
      free(:, :m) = merge(0.0_wp, 1.0_wp, loads%fixed(:, first:last))
      absorbed = 0.0_wp
      do i = dashpot(1), dashpot(2) - 1
         absorbed(:, loads%absorbing%node(i) - first + 1) = absorb(i)
      end do
      call kick_and_drift(2*m, pace, free, loads%velocity(:, first:last), mass, state%solid(:, first:last), &
                          state%normal(:, first:last), state%friction(:, first:last), state%load(:, first:last), &
                          viscous, absorbed, state%v(:, first:last), state%u(:, first:last), work)

   contains

      !> Force of the dashpots of a node.
      pure function absorb(i) result(force)
         !> Its number among those with dashpots
         integer, intent(in) :: i
         real(wp) :: force(2), others(2)
         integer :: k

         associate (n => loads%absorbing%node(i))
            k = n - first + 1
            others = state%solid(:, n) + state%normal(:, n) + state%friction(:, n) + state%load(:, n)
            others = others + viscous(:, k) - free(:, k)*sign(pace%local_damping*abs(others), state%v(:, n))
            force = dashpot_force(loads%absorbing%damping(:, i), state%mass(n), state%v(:, n), free(:, k), &
                                  loads%velocity(:, n)*pace%motion, others, pace%kick)
         end associate
      end function absorb

   end subroutine move_block

   !> The first node with dashpots of each block, and one beyond the last (blocks + 1).
   pure function first_dashpots(loads, blocks) result(first)
      type(loads_t), intent(in) :: loads
      integer, intent(in) :: blocks
      integer :: first(blocks + 1), b, i

      first = 1
      i = 1
      do b = 1, blocks
         first(b) = i
         do while (i <= loads%absorbing%number())
            if (loads%absorbing%node(i) > b*block_size) exit
            i = i + 1
         end do
      end do
      first(blocks + 1) = i
   end function first_dashpots

   !> One step of a block of nodes, without branches. The work of a force over the kick is f.(v_old + v_new)/2 kick, which
   !> changes the kinetic energy exactly; that of a prescribed node's reaction is found the same way.
   pure subroutine kick_and_drift(n, pace, free, velocity, mass, solid, normal, friction, load, viscous, absorbed, v, u, work)
      !> Components: two a node
      integer, intent(in) :: n
      type(pace_t), intent(in) :: pace
      !> 0 where the component is prescribed, else 1; prescribed velocity (n) [m/s]
      real(wp), intent(in) :: free(n), velocity(n)
      !> Nodal mass (n) [kg per m]
      real(wp), intent(in) :: mass(n)
      !> Nodal forces (n) [N per m]
      real(wp), dimension(n), intent(in) :: solid, normal, friction, load, viscous, absorbed
      !> Velocity [m/s] and displacement [m] (n)
      real(wp), intent(inout) :: v(n), u(n)
      !> Work against contact and friction, of loads and reactions, against damping, of waves that leave so far; kinetic energy
      !> [J per m]
      real(wp), intent(inout) :: work(works)
      real(wp) :: new, force, path, damping, contact, rubbing, external, dissipated, gone, twice_kinetic
      integer :: i

      contact = 0.0_wp
      rubbing = 0.0_wp
      external = 0.0_wp
      dissipated = 0.0_wp
      gone = 0.0_wp
      twice_kinetic = 0.0_wp
      !$omp simd private(new, force, path, damping) reduction(+:contact, rubbing, external, dissipated, gone, twice_kinetic)
      do i = 1, n
         force = solid(i) + normal(i) + friction(i) + load(i)
         damping = viscous(i) - free(i)*sign(pace%local_damping*abs(force), v(i))
         new = free(i)*(v(i) + pace%kick*(force + damping + absorbed(i))/mass(i)) + (1.0_wp - free(i))*velocity(i)*pace%motion
         path = 0.5_wp*(v(i) + new)*pace%kick
         contact = contact - normal(i)*path
         rubbing = rubbing - friction(i)*path
         external = external + path*(load(i) + (1.0_wp - free(i))*(mass(i)*(new - v(i))/pace%kick - force - damping - absorbed(i)))
         dissipated = dissipated - damping*path
         gone = gone - absorbed(i)*path
         twice_kinetic = twice_kinetic + mass(i)*new**2
         v(i) = new
         u(i) = u(i) + pace%drift*new
      end do
      work = work + [contact, rubbing, external, dissipated, gone, 0.5_wp*twice_kinetic]
   end subroutine kick_and_drift

   !> The same where nothing but the rock acts: the same numbers from a third of the memory.
   pure subroutine kick_and_drift_alone(n, pace, mass, solid, v, u, work)
      !> As in kick_and_drift
      integer, intent(in) :: n
      type(pace_t), intent(in) :: pace
      real(wp), intent(in) :: mass(n), solid(n)
      real(wp), intent(inout) :: v(n), u(n)
      real(wp), intent(inout) :: work(works)
      real(wp) :: new, damping, dissipated, twice_kinetic
      integer :: i

      dissipated = 0.0_wp
      twice_kinetic = 0.0_wp
      !$omp simd private(new, damping) reduction(+:dissipated, twice_kinetic)
      do i = 1, n
         damping = -sign(pace%local_damping*abs(solid(i)), v(i))
         new = v(i) + pace%kick*(solid(i) + damping)/mass(i)
         dissipated = dissipated - damping*(0.5_wp*(v(i) + new)*pace%kick)
         twice_kinetic = twice_kinetic + mass(i)*new**2
         v(i) = new
         u(i) = u(i) + pace%drift*new
      end do
      work([4, 6]) = work([4, 6]) + [dissipated, 0.5_wp*twice_kinetic]
   end subroutine kick_and_drift_alone

   !> Blocks of nodes without prescribed motion and loads, which no contact can push.
   pure function undisturbed_blocks(loads, touching) result(undisturbed)
      type(loads_t), intent(in) :: loads
      !> Nodes that contact can push
      integer, intent(in) :: touching(:)
      logical, allocatable :: undisturbed(:)
      logical :: alone(size(loads%fixed, 2))
      integer :: b

      alone = .not. any(loads%fixed .or. abs(loads%dead_start) > 0.0_wp .or. abs(loads%dead_end) > 0.0_wp, dim=1)
      alone(touching) = .false.
      if (loads%absorbing%number() > 0) alone(loads%absorbing%node) = .false.
      do b = 1, size(loads%pressure_edge, 2)
         alone(loads%pressure_edge(:, b)) = .false.
      end do
      undisturbed = [(all(alone(b:min(b + block_size - 1, size(alone)))), b=1, size(alone), block_size)]
   end function undisturbed_blocks

   !> Unbalanced force ratio: the norm of the net force on free nodes over the norm of what acts on the bodies (loads,
   !> contact and reactions). Zero at equilibrium; 0 when nothing acts; NaN where a force is none.
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
      ! A comparison with NaN is false
      if (.not. acting <= 0.0_wp) ratio = sqrt(unbalanced/acting)
   end function unbalanced_ratio

end module motion_m
