!> Softening of bonds in the matrix of Newton's method: when may it be there?
!>
!> The matrix leaves it out, so that iterations move away from an equilibrium that is not stable. Where a crack grows it is too
!> stiff by that: each iteration leaves the same share of the force, a half to three quarters. What a step leaves of the work
!> along it tells: less than all, and the rock along the step is stable; much, and it is softer than the matrix says. Near such a
!> rest the whole tangent finds it in a few iterations.
module softening_m
   use kinds_m, only: wp
   implicit none
   private

   type, public :: softening_t
      private
      !> May it be switched?
      logical :: may = .false.
      !> Has the last step left a steady share?
      logical :: steady = .false.
   contains
      procedure :: judge
      procedure :: give_up
   end type softening_t

   interface softening_t
      module procedure :: new_softening
   end interface softening_t

   !> Shares of the work along a step: more than the first is much, more than the second nearly all
   real(wp), parameter :: much = 0.3_wp, nearly_all = 0.9_wp
   !> With softening a step must reduce the unbalanced force to this share
   real(wp), parameter :: good = 0.6_wp

contains

   pure type(softening_t) function new_softening(may) result(softening)
      logical, intent(in) :: may

      softening%may = may
   end function new_softening

   !> After a step: goes the next matrix with softening?
   pure subroutine judge(self, left, reduction, near, softens)
      class(softening_t), intent(inout) :: self
      !> Work along the step, force times step, at its end over that at its start; 0 where that tells nothing: older matrix, step
      !> cut short, no work at its start
      real(wp), intent(in) :: left
      !> Unbalanced force after the step over that before it
      real(wp), intent(in) :: reduction
      !> Is rest near, so that one such step is enough? Otherwise two
      logical, intent(in) :: near
      logical, intent(inout) :: softens
      logical :: steady

      if (.not. self%may) return
      steady = left > much .and. left < nearly_all
      if (softens) then
         softens = reduction <= good
      else
         softens = steady .and. (near .or. self%steady)
      end if
      self%steady = steady
   end subroutine judge

   !> No step with this matrix reduces the force: is it the softening that is in the way? Then it goes, and does not come back.
   pure subroutine give_up(self, softens, again)
      class(softening_t), intent(inout) :: self
      logical, intent(inout) :: softens
      !> Is another step worth a try?
      logical, intent(out) :: again

      again = self%may .and. softens
      if (.not. again) return
      softens = .false.
      self%may = .false.
   end subroutine give_up

end module softening_m
