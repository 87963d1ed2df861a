!> How much a run has to do, before it starts: a slip in a number (1e8 cycles, a stiffness with an exponent too many) makes runs
!> that would not end in a lifetime.
module effort_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use log_m, only: log_t
   use text_m, only: to_text
   use model_m, only: model_t, begin_stage
   use solver_choice_m, only: solver_explicit
   use stable_step_m, only: first_step
   use state_m, only: state_t
   implicit none
   private

   !> Steps of explicit solver or relaxation that cost as much as a load increment of the solvers that know rest alone: in networks
   real(wp), parameter :: steps_an_increment = 2000.0_wp
   !> Seconds for a step of a triangle, with its share of joints and contact, on a core of a usual machine
   real(wp), parameter :: seconds_each = 1.0e-7_wp
   !> Runs shorter than this are said to take seconds [s]
   real(wp), parameter :: seconds_alone = 10.0_wp
   !> Triangles times steps beyond which somebody has to say that it is meant: some hours
   real(wp), parameter :: long_run = 1.0e11_wp

   public :: check_effort, estimated_steps

contains

   !> Say what the run has to do; an error when that is very long and the deck does not say that it is meant.
   subroutine check_effort(model, state, log, errors)
      !> As it was built, before the first stage
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: effort
      real(wp) :: steps, work

      steps = estimated_steps(model, state)
      work = steps*real(size(model%split%triangle, 2), wp)
      if (model%solver == solver_explicit) then
         effort = 'about '//count_text(steps)//' steps of '
      else
         effort = count_text(steps/steps_an_increment)//' increments of '
      end if
      effort = effort//to_text(size(model%split%triangle, 2))//' triangles, '
      ! One joint that slips evenly is a thousand times easier than a network
      if (model%solver /= solver_explicit .and. seconds_each*work >= seconds_alone) effort = effort//'up to '
      effort = effort//duration_text(seconds_each*work)
      call log%say('effort    '//effort)
      if (work <= long_run .or. model%deck%run%long) return
      call errors%add(model%deck%path//':'//to_text(model%deck%run%line)//': &run long = .false.: the run would take '//effort// &
                      ' (from cycles, times, stable step and mesh); if that is meant, give long = .true.')
   end subroutine check_effort

   !> Steps of the run, from the step that is stable now; increments of the other solvers count as many. A rest that ends at
   !> equilibrium counts as long as the move before it.
   real(wp) function estimated_steps(model, state) result(steps)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(model_t) :: trial
      type(state_t) :: trial_state
      real(wp) :: step, rest
      integer :: s

      if (model%solver /= solver_explicit) then
         steps = steps_an_increment*sum(real(model%deck%stage%cycles, wp))
         return
      end if
      ! Loads and supports of the first stage, which tell which nodes can move, on copies
      trial = model
      trial_state = state
      call begin_stage(trial, 1, trial_state)
      step = first_step(trial, trial_state)
      steps = 0.0_wp
      associate (stage => model%deck%stage)
         do s = 1, size(stage)
            rest = max(0.0_wp, stage(s)%rest_time)
            if (model%until_balanced(s)) rest = stage(s)%move_time
            steps = steps + real(stage(s)%cycles, wp)*(whole_steps(stage(s)%move_time) + whole_steps(rest))
         end do
      end associate

   contains

      !> Steps that a duration is divided into.
      pure real(wp) function whole_steps(duration)
         real(wp), intent(in) :: duration

         whole_steps = 0.0_wp
         if (duration > 0.0_wp) whole_steps = max(1.0_wp, duration/step)
      end function whole_steps

   end function estimated_steps

   !> A number of steps as a whole number, as long as that can be read.
   pure function count_text(number) result(text)
      real(wp), intent(in) :: number
      character(len=:), allocatable :: text
      real(wp), parameter :: readable = 1.0e9_wp

      if (number < readable) then
         text = to_text(nint(number))
      else
         text = to_text(number)
      end if
   end function count_text

   !> 'seconds', 'some 3 hours', 'some 2000 years'.
   pure function duration_text(seconds) result(text)
      real(wp), intent(in) :: seconds
      character(len=:), allocatable :: text
      !> Seconds in them
      real(wp), parameter :: minute = 60.0_wp, hour = 3600.0_wp, day = 86400.0_wp, year = 3.15e7_wp

      if (seconds < seconds_alone) then
         text = 'seconds'
      else if (seconds < 2.0_wp*hour) then
         text = 'some '//to_text(ceiling(seconds/minute))//' minutes'
      else if (seconds < 2.0_wp*day) then
         text = 'some '//to_text(nint(seconds/hour))//' hours'
      else if (seconds < 2.0_wp*year) then
         text = 'some '//to_text(nint(seconds/day))//' days'
      else
         text = 'some '//to_text(seconds/year)//' years'
      end if
   end function duration_text

end module effort_m
