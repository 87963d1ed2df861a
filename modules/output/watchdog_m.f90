!> The energy account as a watchdog: what it cannot explain tells that a result is not to be trusted, whatever it looks like. (What
!> was put in equals what is stored and what was spent, see state_m.)
module watchdog_m
   use kinds_m, only: wp, i8
   use errors_m, only: error_list_t
   use log_m, only: log_t
   use text_m, only: to_text, quoted
   use state_m, only: energy_t
   implicit none
   private

   !> Parts of the work put in: beyond the first the residual is warned of, beyond the second the run has failed
   integer, parameter :: noticeable = 1, absurd = 2
   real(wp), parameter, public :: limit(*) = [0.05_wp, 0.5_wp]
   !> Explicit steps that it must have been so for: in the first steps of a motion the work is that of a step or two, and as much
   !> may be missing
   integer(i8), parameter, public :: patience = 200_i8
   !> Terms of the account, in the order of term_values
   character(len=*), parameter :: term(*) = [character(len=8) :: 'kinetic', 'strain', 'contact', 'friction', 'damping', &
                                                                                                           'fracture', 'absorbed']

   !> What to do about it
   character(len=*), parameter :: advice = '; do not trust the result before smaller steps (&explicit safety, step) or more '// &
                                  'cycles have given the same'

   !> What it remembers
   type, public :: watchdog_t
      private
      !> Most work that was ever in the account, and work that is nothing [J per m of thickness]
      real(wp) :: work = 0.0_wp, nothing = 0.0_wp
      !> The account when it was looked at last
      type(energy_t) :: before
      !> How much of the residual came about while each term changed most (terms)
      real(wp) :: lost(size(term)) = 0.0_wp
      !> Steps that a residual must last for, and step at which each limit was kept last (limits)
      integer(i8) :: patience = 0_i8, kept_at(size(limit)) = 0_i8
      !> Largest residual [J per m of thickness] and where it was; has it been warned of?
      real(wp) :: worst = 0.0_wp
      character(len=:), allocatable :: place
      logical :: warned = .false.
   contains
      procedure :: start
      procedure :: look
      procedure :: say_end
   end type watchdog_t

contains

   !> Start to watch.
   subroutine start(self, energy, stiffness, step, steps)
      class(watchdog_t), intent(inout) :: self
      !> The account now
      type(energy_t), intent(in) :: energy
      !> Young's modulus of the rock times its area [N]
      real(wp), intent(in) :: stiffness
      !> Number of the step now; steps that a residual must last for (0 for the solvers that know rest alone)
      integer(i8), intent(in) :: step, steps
      !> Strain whose energy is a rounding error
      real(wp), parameter :: no_strain = 1.0e-12_wp

      self%before = energy
      self%nothing = stiffness*no_strain**2
      self%work = abs(energy%initial) + abs(energy%external)
      self%kept_at = step
      self%patience = steps
      self%place = ''
   end subroutine start

   !> Look at the account at the end of a cycle: a word when the residual has become noticeable, an error when it is absurd.
   subroutine look(self, energy, step, time, stage, cycle, log, errors)
      class(watchdog_t), intent(inout) :: self
      type(energy_t), intent(in) :: energy
      !> Number of the step, time [s], name of the stage, cycle in it
      integer(i8), intent(in) :: step
      real(wp), intent(in) :: time
      character(len=*), intent(in) :: stage
      integer, intent(in) :: cycle
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: place
      real(wp) :: part
      integer :: most
      logical :: beyond(size(limit))

      self%work = max(self%work, abs(energy%initial) + abs(energy%external))
      most = maxloc(abs(term_values(energy) - term_values(self%before)), dim=1)
      self%lost(most) = self%lost(most) + abs(energy%residual() - self%before%residual())
      self%before = energy
      if (self%work <= self%nothing) return
      part = abs(energy%residual())/self%work
      place = 'at time '//to_text(time)//' s (stage '//quoted(trim(stage))//', cycle '//to_text(cycle)//')'
      if (.not. abs(energy%residual()) <= self%worst) then
         self%worst = abs(energy%residual())
         self%place = place
      end if
      ! A comparison with NaN is false
      where (part <= limit) self%kept_at = step
      beyond = .not. part <= limit .and. step - self%kept_at >= self%patience
      if (beyond(absurd)) then
         call errors%add('the energy account is off '//account(self, energy%residual(), place)//advice)
      else if (beyond(noticeable) .and. .not. self%warned) then
         call log%warn('the energy account is off '//account(self, energy%residual(), place))
         self%warned = .true.
      end if
   end subroutine look

   !> At the end of the run: the largest residual over all work, if it is or was worth a word.
   subroutine say_end(self, log, errors)
      class(watchdog_t), intent(in) :: self
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      real(wp) :: part

      if (self%work <= self%nothing) return
      part = self%worst/self%work
      if (.not. part <= limit(absurd)) then
         call errors%add('the energy account was off '//account(self, self%worst, self%place)//advice)
      else if (self%warned .or. part > limit(noticeable)) then
         call log%warn('the energy account was off '//account(self, self%worst, self%place)//advice)
      end if
   end subroutine say_end

   !> 'by 7.5 % of the work put in at time ...': part, place, numbers, and the term that lost them.
   function account(self, residual, place) result(text)
      class(watchdog_t), intent(in) :: self
      !> [J per m of thickness]
      real(wp), intent(in) :: residual
      !> When it was
      character(len=*), intent(in) :: place
      character(len=:), allocatable :: text

      text = 'by '//percent(abs(residual)/self%work)//' of the work put in '//place//', residual '//to_text(residual)// &
             ' J/m of '//to_text(self%work)//' J/m, lost while '//trim(term(maxloc(self%lost, dim=1)))//'_J changed most'
   end function account

   !> What is stored and spent, in the order of their names (terms) [J per m of thickness].
   pure function term_values(energy) result(value)
      type(energy_t), intent(in) :: energy
      real(wp) :: value(size(term))

      value = [energy%kinetic, energy%strain, energy%contact, energy%friction, energy%damping, energy%fracture, &
               energy%absorbed]
   end function term_values

   !> '7.5 %'
   pure function percent(part) result(text)
      real(wp), intent(in) :: part
      character(len=:), allocatable :: text

      text = to_text(100.0_wp*part)//' %'
   end function percent

end module watchdog_m
