!> The energy account as a watchdog: what it cannot explain tells that a result is not to be trusted, whatever it looks like. (What
!> was put in equals what is stored and what was spent, see state_m.)
module watchdog_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use log_m, only: log_t
   use text_m, only: to_text, quoted
   use state_m, only: energy_t
   implicit none
   private

   !> Parts of the work put in: beyond the first the residual is warned of, beyond the second the run has failed
   real(wp), parameter, public :: noticeable = 0.05_wp, absurd = 0.5_wp
   !> Terms of the account, in the order of term_values
   character(len=*), parameter :: term(*) = [character(len=8) :: 'kinetic', 'strain', 'contact', 'friction', 'damping', 'fracture']

   !> What it remembers
   type, public :: watchdog_t
      private
      !> Most work that was ever in the account, and work that is nothing [J per m of thickness]
      real(wp) :: work = 0.0_wp, nothing = 0.0_wp
      !> The account when it was looked at last
      type(energy_t) :: before
      !> How much of the residual came about while each term changed most (terms)
      real(wp) :: lost(size(term)) = 0.0_wp
      !> Largest part of the work that was missing, and where
      real(wp) :: worst = 0.0_wp
      character(len=:), allocatable :: place
   contains
      procedure :: start
      procedure :: look
      procedure :: say_end
   end type watchdog_t

contains

   !> Start to watch.
   subroutine start(self, energy, stiffness)
      class(watchdog_t), intent(inout) :: self
      !> The account now
      type(energy_t), intent(in) :: energy
      !> Young's modulus of the rock times its area [N]
      real(wp), intent(in) :: stiffness
      !> Strain whose energy is a rounding error
      real(wp), parameter :: no_strain = 1.0e-12_wp

      self%before = energy
      self%nothing = stiffness*no_strain**2
      self%work = abs(energy%initial) + abs(energy%external)
   end subroutine start

   !> Look at the account at the end of a cycle: a word when the residual becomes noticeable, an error when it is absurd.
   subroutine look(self, energy, time, stage, cycle, log, errors)
      class(watchdog_t), intent(inout) :: self
      type(energy_t), intent(in) :: energy
      !> Time [s], name of the stage, cycle in it
      real(wp), intent(in) :: time
      character(len=*), intent(in) :: stage
      integer, intent(in) :: cycle
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: place
      real(wp) :: part
      integer :: most

      self%work = max(self%work, abs(energy%initial) + abs(energy%external))
      most = maxloc(abs(term_values(energy) - term_values(self%before)), dim=1)
      self%lost(most) = self%lost(most) + abs(energy%residual() - self%before%residual())
      self%before = energy
      if (self%work <= self%nothing) return
      part = abs(energy%residual())/self%work
      if (part <= self%worst) return
      place = 'at time '//to_text(time)//' s (stage '//quoted(trim(stage))//', cycle '//to_text(cycle)//')'
      ! A comparison with NaN is false
      if (.not. part <= absurd) then
         call errors%add('the energy account is off by '//percent(part)//' of the work put in '//place//', '// &
                         account(self, energy)//'; the result means nothing: try a smaller &explicit safety or step, more '// &
                         'cycles, and look at stiffness and loads there')
      else if (part > noticeable .and. self%worst <= noticeable) then
         call log%warn('the energy account is off by '//percent(part)//' of the work put in '//place//', '//account(self, energy))
      end if
      self%worst = part
      self%place = place
   end subroutine look

   !> At the end of the run: the largest part that was missing, if it is worth a word.
   subroutine say_end(self, log)
      class(watchdog_t), intent(in) :: self
      type(log_t), intent(in) :: log

      if (self%worst <= noticeable) return
      call log%warn('the energy account was off by '//percent(self%worst)//' of the work put in, most of all '//self%place// &
                    '; it was lost while '//trim(term(maxloc(self%lost, dim=1)))//'_J changed most: do not trust the result '// &
                    'before smaller steps (&explicit safety, step) or more cycles have given the same')
   end subroutine say_end

   !> The numbers, and the term that lost them.
   function account(self, energy) result(text)
      class(watchdog_t), intent(in) :: self
      type(energy_t), intent(in) :: energy
      character(len=:), allocatable :: text

      text = 'residual '//to_text(energy%residual())//' J/m of '//to_text(self%work)//' J/m, lost while '// &
             trim(term(maxloc(self%lost, dim=1)))//'_J changed most'
   end function account

   !> What is stored and spent, in the order of their names (terms) [J per m of thickness].
   pure function term_values(energy) result(value)
      type(energy_t), intent(in) :: energy
      real(wp) :: value(size(term))

      value = [energy%kinetic, energy%strain, energy%contact, energy%friction, energy%damping, energy%fracture]
   end function term_values

   !> '7.5 %'
   pure function percent(part) result(text)
      real(wp), intent(in) :: part
      character(len=:), allocatable :: text

      text = to_text(100.0_wp*part)//' %'
   end function percent

end module watchdog_m
