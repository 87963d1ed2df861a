!> A load increment of the solvers that know states of rest alone (implicit, relaxation): what they start from, how the
!> joints go from there to wherever the search for equilibrium tries, and the work of an increment that has found it.
!>
!> The joint law remembers. A search for equilibrium goes through states that are none; had joints, friction springs and
!> bonds followed it, every overshoot would have mobilised them. Each trial therefore starts from their state at the start of
!> the increment, and an increment is one step of every law, however the search went.
module increment_m
   use kinds_m, only: wp
   use model_m, only: model_t, increment_t
   use state_m, only: state_t, laws_go_back
   use forces_m, only: find_forces, find_energies
   use joint_border_m, only: slip_of_step
   use shares_m, only: book_increment
   implicit none
   private

   public :: increment_t, begin_increment, start_increment, forces_from_start, account_increment, has_left, drives_too_far, &
             slip_over_peak, shortest

   !> Watch over the slip of increments that have come to rest
   type, public :: slip_watch_t
      private
      !> Slip over what is allowed (see slip_over_peak) in this increment, and in one twice as long that was given up (if it was)
      real(wp) :: slip = 0.0_wp, twice = huge(1.0_wp)
   contains
      procedure :: too_far => slips_too_far
      procedure :: is_short
   end type slip_watch_t

   !> No increment is halved below this part of a cycle because joints slip far, nor where half of it has slipped nearly as far
   real(wp), parameter :: shortest = 1.0_wp/64.0_wp, shorter_slip = 0.75_wp
   !> An increment in which joints slip by no more than this part of what is allowed may be followed by a longer one
   real(wp), parameter :: short_slip = 0.5_wp

contains

   !> An increment that starts from the present state, whose forces are known.
   pure subroutine begin_increment(level, state, increment)
      !> Loads at its end, 0 to 1 over the stage
      real(wp), intent(in) :: level
      type(state_t), intent(in) :: state
      class(increment_t), intent(inout) :: increment

      increment%start = state
      increment%level = level
   end subroutine begin_increment

   !> The same where the forces are not known yet: they are found there.
   subroutine start_increment(model, from, level, state, increment)
      type(model_t), intent(in) :: model
      !> Loads at its start and its end, 0 to 1 over the stage
      real(wp), intent(in) :: from, level
      type(state_t), intent(inout) :: state
      type(increment_t), intent(out) :: increment
      logical :: searched

      call begin_increment(level, state, increment)
      if (model%has_contact) call model%contact%recall(state%contact, state%u, increment%start%contact%springs)
      call forces_from_start(model, increment, from, state, searched)
      call laws_go_back(increment%start, state)
      increment%start = state
   end subroutine start_increment

   !> The forces of the explicit solver at the displacement state%u; joints, bonds and friction go there in one step from
   !> the start of the increment.
   subroutine forces_from_start(model, increment, level, state, searched)
      type(model_t), intent(in) :: model
      class(increment_t), intent(in) :: increment
      real(wp), intent(in) :: level
      type(state_t), intent(inout) :: state
      !> Has contact found new pairs?
      logical, intent(out) :: searched

      call laws_go_back(increment%start, state)
      call find_forces(model, level, state, searched)
   end subroutine forces_from_start

   !> Has a node moved farther than the scene is large, beyond what is prescribed?
   pure logical function has_left(model, began, state)
      type(model_t), intent(in) :: model
      !> Displacement before (2, nodes) [m]
      real(wp), intent(in) :: began(:, :)
      type(state_t), intent(in) :: state
      real(wp) :: extent(2)

      extent = maxval(model%split%x, dim=2) - minval(model%split%x, dim=2)
      has_left = maxval(abs(state%u - began), mask=.not. model%loads%fixed) > maxval(extent)
   end function has_left

   !> The furthest that a joint under pressure has slipped, over the slip of its peak strength and what it had slipped before;
   !> joints without a peak are at home in a step of any length.
   real(wp) function slip_over_peak(model, start, state) result(furthest)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: start, state
      real(wp) :: peak
      integer :: j

      furthest = 0.0_wp
      do j = 1, size(model%joints%law)
         if (state%joint(j)%sn <= 0.0_wp) cycle
         peak = model%joints%law(j)%raw%slip_of_peak(state%joint(j)%sn)
         if (peak > 0.0_wp) furthest = max(furthest, abs(state%joint(j)%u - start%joint(j)%u)/(peak + abs(start%joint(j)%u)))
      end do
   end function slip_over_peak

   !> Do prescribed displacements alone drive a joint under pressure farther than the laws are followed along their curves? Whether
   !> rest is found so far off is chance.
   pure logical function drives_too_far(model, allowed, duration, part, start) result(too_far)
      type(model_t), intent(in) :: model
      !> The deck's largest_slip
      real(wp), intent(in) :: allowed
      !> Time that prescribed velocities act [s], part of a cycle that the increment is
      real(wp), intent(in) :: duration, part
      !> Rest at its start
      type(state_t), intent(in) :: start
      real(wp) :: drive(2), allowed_slip(size(model%joints%law))
      integer :: i

      too_far = .false.
      if (part <= shortest) return
      do i = 1, 2
         drive(i) = 0.0_wp
         if (.not. any(model%loads%fixed(i, :))) cycle
         drive(i) = maxval(model%loads%velocity(i, :), mask=model%loads%fixed(i, :)) &
                    - minval(model%loads%velocity(i, :), mask=model%loads%fixed(i, :))
      end do
      allowed_slip = allowed*slip_of_step(model%joints%law, start%joint)
      too_far = any(allowed_slip > 0.0_wp .and. allowed_slip < duration*norm2(drive))
   end function drives_too_far

   !> Has a joint slipped farther in an increment than the laws are followed along their curves, and would half of it be nearer to
   !> them? What snaps slips as far in a shorter increment. When true, the caller goes back to its start and tries half of it.
   logical function slips_too_far(self, model, allowed, part, start, state) result(too_far)
      class(slip_watch_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> The deck's largest_slip, and the part of a cycle (or of what a cycle is divided into) that the increment is
      real(wp), intent(in) :: allowed, part
      !> Rest at the increment's start and end
      type(state_t), intent(in) :: start, state

      self%slip = slip_over_peak(model, start, state)/allowed
      too_far = self%slip > 1.0_wp .and. part > shortest .and. self%slip < shorter_slip*self%twice
      self%twice = merge(self%slip, huge(1.0_wp), too_far)
   end function slips_too_far

   !> Has the increment looked at last slipped so little that a longer one may follow?
   pure logical function is_short(self)
      class(slip_watch_t), intent(in) :: self

      is_short = self%slip <= short_slip
   end function is_short

   !> Add the work of an increment to the energy account, forces taken as the mean of start and end.
   subroutine account_increment(model, start, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: start
      type(state_t), intent(inout) :: state
      real(wp) :: net, path, contact, friction, external, damping
      integer :: n, i

      contact = 0.0_wp
      friction = 0.0_wp
      external = 0.0_wp
      damping = 0.0_wp
      do n = 1, size(state%u, 2)
         do i = 1, 2
            path = state%u(i, n) - start%u(i, n)
            contact = contact - 0.5_wp*(start%normal(i, n) + state%normal(i, n))*path
            friction = friction - 0.5_wp*(start%friction(i, n) + state%friction(i, n))*path
            external = external + 0.5_wp*(start%load(i, n) + state%load(i, n))*path
            net = start%solid(i, n) + start%normal(i, n) + start%friction(i, n) + start%load(i, n) &
                  + state%solid(i, n) + state%normal(i, n) + state%friction(i, n) + state%load(i, n)
            ! Reactions where motion is prescribed; elsewhere what would have set the rock in motion
            if (model%loads%fixed(i, n)) then
               external = external - 0.5_wp*net*path
            else
               damping = damping + 0.5_wp*net*path
            end if
         end do
      end do
      associate (energy => state%energy)
         energy%contact = energy%contact + contact
         energy%friction = energy%friction + friction
         energy%external = energy%external + external
         energy%damping = energy%damping + damping
         energy%kinetic = 0.0_wp
      end associate
      call book_increment(model, start, state)
      call find_energies(model, state)
   end subroutine account_increment

end module increment_m
