!> The energy account as a watchdog: what it cannot explain tells that a result is not to be trusted, whatever it looks like. (What
!> was put in equals what is stored and what was spent, see state_m.)
module watchdog_m
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
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
   character(len=*), parameter :: term(*) = [character(len=8) :: 'kinetic', 'strain', 'walls', 'corners', 'surfaces', 'damping', &
                                                                                                           'fracture', 'absorbed']

   !> What to do about it
   character(len=*), parameter :: advice = '; do not trust the result before smaller steps (&explicit safety, step) or more '// &
                                  'cycles have given the same'

   !> What can be wrong: energy that is missing or too much, and energy that contact has given out and never took up
   type :: fault_t
      !> Step at which each limit was kept last (limits)
      integer(i8) :: kept_at(size(limit)) = 0_i8
      !> Most of it [J per m of thickness] and where that was; has it been warned of?
      real(wp) :: worst = 0.0_wp
      character(len=:), allocatable :: place
      logical :: warned = .false.
   end type fault_t

   !> What it remembers
   type, public :: watchdog_t
      private
      !> Most work that was ever in the account, and work that is nothing [J per m of thickness]
      real(wp) :: work = 0.0_wp, nothing = 0.0_wp
      !> The account when it was looked at last
      type(energy_t) :: before
      !> How much of the residual came about while each term changed most (terms)
      real(wp) :: lost(size(term)) = 0.0_wp
      !> Steps that a fault must last for
      integer(i8) :: patience = 0_i8
      !> Can contact give out no more than it took up?
      logical :: contact_stores = .false.
      type(fault_t) :: residual, contact
   contains
      procedure :: start
      procedure :: look
      procedure :: say_end
   end type watchdog_t

contains

   !> Start to watch.
   subroutine start(self, energy, stiffness, step, steps, contact_stores)
      class(watchdog_t), intent(inout) :: self
      !> The account now
      type(energy_t), intent(in) :: energy
      !> Young's modulus of the rock times its area [N]
      real(wp), intent(in) :: stiffness
      !> Number of the step now; steps that a residual must last for (0 for the solvers that know rest alone)
      integer(i8), intent(in) :: step, steps
      !> Can contact give out no more than it took up? Not so where shearing lifts it, where it was closed from the start, or where
      !> its work is that of mean forces on the way of a whole increment
      logical, intent(in) :: contact_stores
      !> Strain whose energy is a rounding error
      real(wp), parameter :: no_strain = 1.0e-12_wp

      self%before = energy
      self%nothing = stiffness*no_strain**2
      self%work = abs(energy%initial) + abs(energy%external)
      self%residual = fault_t(kept_at=spread(step, 1, size(limit)), place='')
      self%contact = self%residual
      self%patience = steps
      self%contact_stores = contact_stores
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
      integer :: most

      self%work = max(self%work, abs(energy%initial) + abs(energy%external))
      most = maxloc(abs(term_values(energy) - term_values(self%before)), dim=1)
      self%lost(most) = self%lost(most) + abs(energy%residual() - self%before%residual())
      self%before = energy
      ! Work does not tell of NaN: max() passes it over
      if (self%work <= self%nothing .and. .not. ieee_is_nan(energy%residual())) return
      place = 'at time '//to_text(time)//' s (stage '//quoted(trim(stage))//', cycle '//to_text(cycle)//')'
      call judge(abs(energy%residual()), 'the energy account is off '//account(self, energy%residual(), place), self%residual)
      if (self%contact_stores) &
         call judge(-energy%contact, 'the contact has given out '//gift(self, -energy%contact, place), self%contact)

   contains

      !> Compare a fault with its limits.
      subroutine judge(amount, what, fault)
         !> [J per m of thickness]
         real(wp), intent(in) :: amount
         character(len=*), intent(in) :: what
         type(fault_t), intent(inout) :: fault
         logical :: beyond(size(limit))

         if (.not. amount <= fault%worst) then
            fault%worst = amount
            fault%place = place
         end if
         ! A comparison with NaN is false
         where (amount <= limit*self%work) fault%kept_at = step
         beyond = .not. amount <= limit*self%work .and. step - fault%kept_at >= self%patience
         if (beyond(absurd)) then
            call errors%add(what//advice)
         else if (beyond(noticeable) .and. .not. fault%warned) then
            call log%warn(what)
            fault%warned = .true.
         end if
      end subroutine judge
   end subroutine look

   !> At the end of the run: the largest residual over all work, if it is or was worth a word. The word on contact that gives out
   !> energy is that of story_m.
   subroutine say_end(self, log, errors)
      class(watchdog_t), intent(in) :: self
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors

      if (self%work <= self%nothing) return
      associate (worst => self%residual%worst, place => self%residual%place)
         if (.not. worst <= limit(absurd)*self%work) then
            call errors%add('the energy account was off '//account(self, worst, place)//advice)
         else if (self%residual%warned .or. worst > limit(noticeable)*self%work) then
            call log%warn('the energy account was off '//account(self, worst, place)//advice)
         end if
      end associate
      if (.not. self%contact%worst <= limit(absurd)*self%work) &
         call errors%add('the contact gave out '//gift(self, self%contact%worst, self%contact%place)//advice)
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

   !> '7.5 % of the work put in more than it took up at time ...': part, place, numbers.
   function gift(self, given, place) result(text)
      class(watchdog_t), intent(in) :: self
      !> [J per m of thickness]
      real(wp), intent(in) :: given
      !> When it was
      character(len=*), intent(in) :: place
      character(len=:), allocatable :: text

      text = percent(given/self%work)//' of the work put in more than it took up '//place//', '//to_text(given)//' J/m of '// &
             to_text(self%work)//' J/m'
   end function gift

   !> What is stored and spent, in the order of their names (terms) [J per m of thickness].
   pure function term_values(energy) result(value)
      type(energy_t), intent(in) :: energy
      real(wp) :: value(size(term))

      value = [energy%kinetic, energy%strain, energy%walls(), energy%corners, energy%surfaces, energy%damping, &
               energy%fracture, energy%absorbed]
   end function term_values

   !> '7.5 %'
   pure function percent(part) result(text)
      real(wp), intent(in) :: part
      character(len=:), allocatable :: text

      text = to_text(100.0_wp*part)//' %'
   end function percent

end module watchdog_m
