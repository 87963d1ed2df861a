!> Implicit quasi-static solver: one load increment of a stage after the other, each brought to equilibrium by Newton's
!> method (newton_m).
!>
!> A cycle is a load increment: prescribed velocities times the move time are its prescribed displacements, loads go to
!> their value at the cycle's end. Rock that breaks is cut between increments, and equilibrium found again at the same
!> loads. Where there is none nearby, because a crack or slip runs on by itself, the way to the next is followed in
!> pseudo-time.
module implicit_m
   use kinds_m, only: wp, i8
   use errors_m, only: error_list_t
   use interrupt_m, only: stop_wanted
   use text_m, only: to_text, quoted
   use log_m, only: log_t, progress_t
   use model_m, only: model_t
   use state_m, only: state_t
   use motion_m, only: unbalanced_ratio
   use rest_checks_m, only: check_support, check_other_contact
   use rest_report_m, only: no_rest, no_factors, end_rest, end_far, end_stuck, end_long, end_linear, end_broken, end_again
   use cracks_m, only: breaks_t, find_breaks, describe_bonds
   use explicit_m, only: cycle_report_t, fraction_done
   use increment_m, only: account_increment, has_left, drives_too_far, slip_watch_t
   use corners_m, only: corner_choices_t, decide_corners, press_further, press_back, any_passed, free_choices, any_chosen, &
                        turn_corners, most_pressed, most_chosen, while_pressed
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use pore_pressure_m, only: press_walls
   use stopwatch_m, only: now_doing, work_solves, work_other
   use sparse_lu_m, only: linear_ok
   use sparse_system_m, only: kept_matrix_t, matrix_of, gather, scatter
   use newton_m, only: newton_t, newton_increment_t, start_increment_at, lay_out, lay_out_as_kept, equilibrate, evaluate, &
                       free_norm, renew_matrix, factor_matrix
   implicit none
   private

   public :: implicit_cycle, enter_stage, settle

   !> How far a cycle has come, for one that goes on after rock has broken
   type :: way_t
      !> Part of the cycle that is done, part of it that the increment adds, and where it is to end
      real(wp) :: done = 0.0_wp, part = 0.0_wp, until = 1.0_wp
      !> Loads at the increment's end, 0 to 1 over the stage, and the time it takes [s]
      real(wp) :: level = 0.0_wp, duration = 0.0_wp
      type(slip_watch_t) :: watch
      !> Starts at the last rest
      type(newton_increment_t) :: increment
      !> Have corners turned to their other sides in this increment, and what did they hold before (while rest is sought so)?
      logical :: turned = .false.
      type(corner_choices_t), allocatable :: before_turn
      !> Is rest sought in pseudo-time? Displacement where that began (2, nodes) [m], steps so far
      logical :: in_pseudo_time = .false.
      real(wp), allocatable :: began(:, :)
      integer :: step = 0
      !> Drag of the next step, time that prescribed velocities have yet to act [s]
      real(wp) :: drag = 0.0_wp, to_come = 0.0_wp
      !> Is the next step to be tried without drag? Steps found in a row
      logical :: calming = .false.
      integer :: found_since = 0
   end type way_t

   !> What the solver remembers from one cycle to the next
   type, extends(newton_t), public :: implicit_solver_t
      private
      !> Matrix of the checkpoint that the run goes on from
      type(kept_matrix_t), allocatable, public :: kept
      !> Do cracks wait for another call, which looks after them? (fluid that pushes back)
      logical, public :: cracks_wait = .false.
      !> Stage the system was laid out for (0: none)
      integer :: stage = 0
      !> How many times the model had changed when it was laid out last
      integer :: recuts = 0
      !> Has contact of other surfaces been warned of?
      logical :: warned = .false.
      !> Steps of pseudo-time so far
      integer(i8) :: pseudo_steps = 0_i8
      type(way_t) :: way
   contains
      procedure :: matrix => matrix_in_use
      procedure :: level => load_level
      procedure :: matrix_number
      procedure :: answer_of_walls
      procedure :: close => close_solver
   end type implicit_solver_t

   !> What is left of a cycle is nothing below this part of it: rounding
   real(wp), parameter :: least_part = 1.0e-9_wp
   !> An increment that took no more iterations than this is followed by a longer one
   integer, parameter :: easy = 12
   !> A first guess with a greater unbalanced force ratio than this is compared with standing still
   real(wp), parameter :: near = 0.1_wp
   !> Rock that cannot break has collapsed when it has moved by this part of the scene in pseudo-time
   real(wp), parameter :: collapsed = 0.1_wp
   !> Pseudo-time: drag of the first step, factors by which it falls after an easy step and grows after one without
   !> equilibrium, drag that lets nothing move any more, and drag so light that equilibrium without it is worth a try
   real(wp), parameter :: first_drag = 1.0_wp, lighter = 0.25_wp, heavier = 4.0_wp, heaviest = 1.0e6_wp, light = 1.0e-9_wp
   !> Unbalanced force ratio at which a step of pseudo-time is done, also as a share of what it starts from
   real(wp), parameter :: pseudo_tolerance = 1.0e-4_wp, pseudo_share = 5.0e-2_wp
   !> A step in which a correction has to be halved more often is given up: heavier drag costs less
   integer, parameter :: pseudo_halvings = 2
   !> A step that took no more iterations than this is followed by one with less drag
   integer, parameter :: easy_pseudo = 22
   !> Steps found in a row after one that was not, before the drag falls again
   integer, parameter :: in_a_row = 2
   !> With corners held rest is not sought for more steps where rock cannot break
   integer, parameter :: most_steps_held = 100
   !> Corners are not pressed back to a greater part of their depth than this
   real(wp), parameter :: gentlest = 0.9_wp
   !> A step that leaves less than this part of the unbalanced force ratio is followed by a try without drag
   real(wp), parameter :: calm = 0.5_wp

contains

   !> One cycle of a stage, in as many increments as it needs. Where rock breaks it returns with what is to change in the model
   !> (report%breaks), and goes on when it is called again. On failure errors says when, where and what.
   subroutine implicit_cycle(self, model, stage, cycle, log, progress, state, report, errors, of_cycle)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(progress_t), intent(inout) :: progress
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      !> Start and end as parts of the cycle; all of it when not given
      real(wp), intent(in), optional :: of_cycle(2)
      integer :: ending, most_steps
      logical :: broken

      call enter_stage(self, model, stage, cycle, log, state, errors)
      if (errors%any()) return
      broken = report%breaks%any()
      report%breaks = breaks_t()
      if (broken) then
         call take_new_mesh(self, model, state)
      else
         self%way = way_t()
         if (present(of_cycle)) self%way = way_t(done=of_cycle(1), until=of_cycle(2))
      end if
      do while (self%way%done < self%way%until)
         if (self%way%in_pseudo_time) then
            most_steps = model%deck%implicit%max_pseudo_steps
            if (may_choose_anew(model, state)) most_steps = min(most_steps, most_steps_held)
            call follow(self, model, most_steps, state, report%breaks, ending)
            if (any(ending == [end_far, end_stuck, end_long])) call let_corners_choose_anew(self, model, state, ending)
         else if (broken) then
            call rest_again(self, model, state, ending)
         else
            call find_rest(self, model, stage, cycle, state, ending)
         end if
         broken = .false.
         if (ending == end_again) then
            report%interrupted = stop_wanted()
            if (report%interrupted) return
            cycle
         end if
         if (ending == end_rest .and. model%can_break .and. .not. self%cracks_wait) then
            call find_breaks(model, state, report%breaks)
            if (report%breaks%any()) ending = end_broken
         end if
         select case (ending)
         case (end_rest)
         case (end_broken)
            report%level = self%way%level
            return
         case default
            call give_up_cycle(self, model, stage, cycle, ending, state, report, errors)
            return
         end select
         associate (way => self%way)
            way%done = way%done + way%part
            if (way%until - way%done < least_part*way%until) way%done = way%until
            state%time = state%time + way%duration
            state%step = state%step + 1_i8
            report%steps = report%steps + 1_i8
            report%smallest_step = min(report%smallest_step, way%duration)
            call progress%tick(log, fraction_done(model, stage, cycle, .true., way%done))
            if (way%done < way%until) report%interrupted = stop_wanted()
         end associate
         if (report%interrupted) return
      end do
      if (model%has_contact) call check_other_contact(model, stage, log, self%warned, state, errors)
      if (self%way%until >= 1.0_wp) state%time = state%time + max(0.0_wp, model%deck%stage(stage)%rest_time)
      report%unbalanced = unbalanced_ratio(model%loads, state)
      call describe_bonds(model, state)
   end subroutine implicit_cycle

   !> The next increment of a cycle: to rest, or back to its start and on by another way.
   subroutine find_rest(self, model, stage, cycle, state, ending)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      !> How it ends
      integer, intent(out) :: ending
      real(wp) :: shortest_cut
      integer :: iterations
      logical :: found, too_far

      associate (way => self%way)
         way%part = min(state%guess%part, way%until - way%done)
         way%duration = way%part*model%deck%stage(stage)%move_time
         way%level = (real(cycle - 1, wp) + min(way%until, way%done + way%part))/real(model%deck%stage(stage)%cycles, wp)
         call start_increment_at(model, way%level, way%duration, state, way%increment)
         call first_guess(model, way%part, way%duration, way%increment, state)
      end associate
      call equilibrate(self, model, self%way%increment, model%rest_tolerance(), state, iterations, found)
      ending = end_rest
      if (found) then
         too_far = self%way%watch%too_far(model, model%deck%implicit%largest_slip, self%way%part, self%way%increment%start, state)
      else
         self%way%watch = slip_watch_t()
         too_far = .not. allocated(self%failure) .and. &
                   drives_too_far(model, model%deck%implicit%largest_slip, self%way%duration, self%way%part, &
                                  self%way%increment%start)
      end if
      if (too_far) then
         call give_up_increment(self, self%way%increment, state)
         ending = end_again
         call forget_turn(self%way, state)
         state%guess%part = 0.5_wp*self%way%part
         state%guess%slip_part = state%guess%part
         return
      end if
      if (found .and. .not. self%way%turned) call try_turned(self, model, state, ending)
      if (ending == end_again) return
      if (found) then
         self%way%turned = .false.
         if (allocated(self%way%before_turn)) deallocate (self%way%before_turn)
         call hold_corners(self, model, self%way%increment, state, iterations)
         call account_increment(model, self%way%increment%start, state)
         state%guess%move = state%u - self%way%increment%start%u
         state%guess%move_part = self%way%part
         if (iterations <= easy .and. self%way%watch%is_short()) state%guess%part = min(1.0_wp, 2.0_wp*state%guess%part)
         state%guess%slip_part = max(state%guess%slip_part, state%guess%part)
         return
      end if
      call give_up_increment(self, self%way%increment, state)
      ending = merge(end_linear, end_again, allocated(self%failure))
      if (ending == end_linear) return
      ! No rest with corners turned: then as they were
      if (allocated(self%way%before_turn)) then
         state%corners = self%way%before_turn
         deallocate (self%way%before_turn)
         return
      end if
      shortest_cut = 0.5_wp**model%deck%implicit%largest_cut*state%guess%slip_part
      self%way%turned = .false.
      state%guess%part = 0.5_wp*state%guess%part
      if (state%guess%part >= shortest_cut) return
      call start_following(self%way, self%way%duration, state)
      state%guess%move_part = 0.0_wp
      state%guess%part = shortest_cut
   end subroutine find_rest

   !> Where the increment has driven a corner against the side that holds it, it is tried again from its start with the other one.
   subroutine try_turned(self, model, state, ending)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      !> As it was, or end_again
      integer, intent(inout) :: ending
      type(corner_choices_t) :: choices

      choices = state%corners
      call turn_corners(model%corners, self%way%increment%start%u, state%u, choices, self%way%turned)
      if (.not. self%way%turned) return
      ending = end_again
      self%way%before_turn = state%corners
      call give_up_increment(self, self%way%increment, state)
      state%corners = choices
   end subroutine try_turned

   !> A shorter increment starts with corners as they were before they were turned.
   subroutine forget_turn(way, state)
      type(way_t), intent(inout) :: way
      type(state_t), intent(inout) :: state

      way%turned = .false.
      if (.not. allocated(way%before_turn)) return
      state%corners = way%before_turn
      deallocate (way%before_turn)
   end subroutine forget_turn

   !> At rest: hold the corners that have come into each other, and press them back in the same increment.
   subroutine hold_corners(self, model, increment, state, iterations)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      !> Those of the increment, to which this adds
      integer, intent(inout) :: iterations

      if (size(model%corners%stiffness) == 0) return
      call choose_sides(self, model, increment, state, iterations)
      call press_corners(self, model, increment, state, iterations)
   end subroutine hold_corners

   !> Which sides hold; where one that pressed has let go there is another rest, and what is found there may be another choice.
   subroutine choose_sides(self, model, increment, state, iterations)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      integer, intent(inout) :: iterations
      type(state_t) :: rest
      type(corner_choices_t) :: before
      integer :: round, more
      logical :: changed, let_go, found

      do round = 1, most_chosen
         before = state%corners
         call decide_corners(model%corners, state%u, state%corners, changed, let_go)
         if (.not. let_go) exit
         rest = state
         rest%corners = before
         self%outdated = .true.
         call evaluate(model, increment, state)
         call equilibrate(self, model, increment, model%rest_tolerance(), state, more, found)
         iterations = iterations + more
         if (found .and. round < most_chosen) cycle
         if (.not. found) state = rest
         self%outdated = .true.
         call decide_corners(model%corners, state%u, state%corners, changed)
         exit
      end do
   end subroutine choose_sides

   !> Press corners that were let pass back, to a part of their depth at a time, as far as there is rest. Where none is found the
   !> root of that part is tried, and its square again where one is.
   subroutine press_corners(self, model, increment, state, iterations)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      integer, intent(inout) :: iterations
      ! Before corners were pressed, and before they were pressed the last time
      type(state_t) :: unpressed, rest
      real(wp) :: before(2, size(state%u, 2)), tolerance, part, onward
      integer :: pressed, more
      logical :: found

      if (.not. any_passed(model%corners, state%corners, state%u)) return
      unpressed = state
      part = press_back
      pressed = 0
      ! What is pressed further moves on as it has begun to, over so many times the way it came
      onward = 0.0_wp
      do while (any_passed(model%corners, state%corners, state%u) .and. part < gentlest .and. pressed < most_pressed)
         rest = state
         call press_further(state%corners, part)
         if (pressed == 0) self%outdated = .true.
         if (onward > 0.0_wp) state%u = state%u + (1.0_wp - part)*onward*(state%u - before)
         tolerance = model%rest_tolerance()
         if (pressed + 1 < most_pressed .and. any_passed(model%corners, state%corners, state%u)) &
            tolerance = max(tolerance, while_pressed)
         call evaluate(model, increment, state)
         call equilibrate(self, model, increment, tolerance, state, more, found)
         iterations = iterations + more
         if (found) then
            pressed = pressed + 1
            before = rest%u
            onward = part/(1.0_wp - part)
            part = max(press_back, part**2)
         else
            state = rest
            self%outdated = .true.
            if (allocated(self%failure)) exit
            onward = 0.0_wp
            part = sqrt(part)
         end if
      end do
      ! What has been found last may have been near rest only
      call equilibrate(self, model, increment, model%rest_tolerance(), state, more, found)
      iterations = iterations + more
      if (found) return
      state = unpressed
      self%outdated = .true.
   end subroutine press_corners

   !> Rock has broken: rest at the same loads, of which those that the increment brought on are all there.
   subroutine rest_again(self, model, state, ending)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      !> How it ends
      integer, intent(out) :: ending
      type(newton_increment_t) :: increment
      integer :: iterations
      logical :: found

      call start_increment_at(model, self%way%level, 0.0_wp, state, increment)
      call equilibrate(self, model, increment, model%rest_tolerance(), state, iterations, found)
      if (found) then
         call account_increment(model, increment%start, state)
         ending = end_rest
      else
         call give_up_increment(self, increment, state)
         call start_following(self%way, 0.0_wp, state)
         ending = end_again
      end if
   end subroutine rest_again

   !> Rest once more where the last increment ended: rock has broken, or the fluid pushes otherwise. Cracks wait.
   subroutine settle(self, model, stage, cycle, state, report, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      integer :: ending

      call take_new_mesh(self, model, state)
      self%way%in_pseudo_time = .false.
      call start_increment_at(model, self%way%level, 0.0_wp, state, self%way%increment)
      call rest_again(self, model, state, ending)
      if (ending == end_again) &
         call follow(self, model, model%deck%implicit%max_pseudo_steps, state, report%breaks, ending)
      report%interrupted = ending == end_again
      if (report%interrupted) return
      if (ending /= end_rest) call give_up_cycle(self, model, stage, cycle, ending, state, report, errors)
      report%unbalanced = unbalanced_ratio(model%loads, state)
      call describe_bonds(model, state)
   end subroutine settle

   !> Forces of a model that has changed, or of loads that have, and unknowns where need be.
   subroutine take_new_mesh(self, model, state)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(newton_increment_t) :: increment

      call start_increment_at(model, self%way%level, 0.0_wp, state, increment)
      call evaluate(model, increment, state)
      if (self%recuts /= model%recuts) call lay_out(self, model, state)
      self%recuts = model%recuts
      ! Nodes of a cut come after the others
      if (self%way%in_pseudo_time) &
         self%way%began = reshape([self%way%began, state%u(:, size(self%way%began, 2) + 1:)], shape(state%u))
   end subroutine take_new_mesh

   !> Go on in pseudo-time from the present state.
   subroutine start_following(way, duration, state)
      type(way_t), intent(inout) :: way
      !> Time that prescribed velocities have yet to act [s]
      real(wp), intent(in) :: duration
      type(state_t), intent(in) :: state

      way%in_pseudo_time = .true.
      way%began = state%u
      way%step = 0
      way%drag = first_drag
      way%to_come = duration
      way%calming = .false.
      way%found_since = in_a_row
   end subroutine start_following

   !> Follow the rock in pseudo-time to where it comes to rest: steps of Newton's method in which a drag proportional to the
   !> rock's stiffness resists the motion of each step. What a real crack gives to motion, the drag takes up. It is heavy at
   !> first and becomes lighter as steps are found easily. Rock may break after each step.
   subroutine follow(self, model, most_steps, state, breaks, ending)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> Steps on the way at the most
      integer, intent(in) :: most_steps
      type(state_t), intent(inout) :: state
      !> Rock that breaks on the way
      type(breaks_t), intent(inout) :: breaks
      !> How it ends
      integer, intent(out) :: ending
      type(newton_increment_t) :: increment
      real(wp) :: tolerance, unbalanced
      integer :: iterations
      logical :: stepped, free, found

      ending = end_long
      do while (self%way%step < most_steps)
         if (stop_wanted()) then
            ending = end_again
            return
         end if
         self%way%step = self%way%step + 1
         call start_increment_at(model, self%way%level, self%way%to_come, state, increment)
         where (model%loads%fixed) state%u = state%u + self%way%to_come*model%loads%velocity
         call evaluate(model, increment, state)
         unbalanced = unbalanced_ratio(model%loads, state)
         tolerance = max(model%rest_tolerance(), min(pseudo_tolerance, pseudo_share*unbalanced))
         free = self%way%drag <= light .or. self%way%calming
         self%way%calming = .false.
         increment%softens = .true.
         increment%halvings = pseudo_halvings
         if (free) then
            tolerance = model%rest_tolerance()
         else
            increment%drag = self%way%drag
         end if
         self%outdated = .true.
         call equilibrate(self, model, increment, tolerance, state, iterations, stepped)
         self%pseudo_steps = self%pseudo_steps + 1_i8
         if (.not. stepped) then
            call give_up_increment(self, increment, state)
            if (allocated(self%failure)) ending = end_linear
            if (allocated(self%failure)) return
            if (.not. free .or. self%way%drag <= light) self%way%drag = heavier*self%way%drag
            if (self%way%drag > heaviest) ending = end_stuck
            if (self%way%drag > heaviest) return
            if (.not. free) self%way%found_since = 0
            cycle
         end if
         self%way%to_come = 0.0_wp
         if (has_collapsed(model, self%way%began, state) .or. has_left(model, self%way%began, state)) ending = end_far
         if (ending == end_far) return
         if (increment%drag > 0.0_wp) then
            increment%drag = 0.0_wp
            call evaluate(model, increment, state)
         end if
         found = unbalanced_ratio(model%loads, state) <= model%rest_tolerance()
         call account_increment(model, increment%start, state)
         ! Calmer than before: there may be rest nearby
         self%way%calming = unbalanced_ratio(model%loads, state) < calm*unbalanced
         if (model%can_break .and. .not. self%cracks_wait) call find_breaks(model, state, breaks)
         if (breaks%any()) ending = end_broken
         if (found .and. .not. breaks%any()) ending = end_rest
         self%way%in_pseudo_time = ending /= end_rest
         if (ending == end_rest) return
         self%way%found_since = self%way%found_since + 1
         if (iterations <= easy_pseudo .and. self%way%found_since >= in_a_row) self%way%drag = lighter*self%way%drag
         if (ending == end_broken) return
      end do
   end subroutine follow

   !> No rest by any way: corners that hold may stand in it. Rock that cannot break goes back to its last rest, and on without them;
   !> they choose anew at the next one.
   subroutine let_corners_choose_anew(self, model, state, ending)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      !> As it was, or end_again
      integer, intent(inout) :: ending

      if (.not. may_choose_anew(model, state)) return
      ending = end_again
      call give_up_increment(self, self%way%increment, state)
      call free_choices(model%corners, state%corners)
      self%way%in_pseudo_time = .false.
      state%guess%part = 0.5_wp**model%deck%implicit%largest_cut*state%guess%slip_part
      state%guess%move_part = 0.0_wp
   end subroutine let_corners_choose_anew

   !> Are there corners that may be let go for want of rest? Where rock has broken there is no going back.
   pure logical function may_choose_anew(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state

      may_choose_anew = .not. model%can_break .and. any_chosen(model%corners, state%corners)
   end function may_choose_anew

   !> Has rock that cannot break moved so far on the way to rest that nothing holds it? Fragments may.
   pure logical function has_collapsed(model, began, state)
      type(model_t), intent(in) :: model
      !> Displacement at the start of the way (2, nodes) [m]
      real(wp), intent(in) :: began(:, :)
      type(state_t), intent(in) :: state
      real(wp) :: extent(2)

      has_collapsed = .false.
      if (model%can_break) return
      extent = maxval(model%split%x, dim=2) - minval(model%split%x, dim=2)
      has_collapsed = maxval(abs(state%u - began), mask=.not. model%loads%fixed) > collapsed*maxval(extent)
   end function has_collapsed

   !> A new stage prescribes other displacements: other unknowns, another pattern, nothing to extrapolate from. Nothing is done
   !> in the stage that is on.
   subroutine enter_stage(self, model, stage, cycle, log, state, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      type(newton_increment_t) :: increment

      if (stage == self%stage) return
      call check_support(model, stage, log, self%weak_springs, errors)
      if (errors%any()) return
      self%stage = stage
      ! In the middle of a stage a run goes on from its checkpoint
      if (cycle > 1 .and. state%guess%known .and. allocated(self%kept)) then
         self%recuts = model%recuts
         call lay_out_as_kept(self, model, self%kept)
         deallocate (self%kept)
         return
      end if
      state%guess%known = .true.
      state%guess%part = 1.0_wp
      state%guess%move_part = 0.0_wp
      state%guess%move = 0.0_wp*state%u
      state%v = 0.0_wp
      ! The forces of the start are needed for the energy account
      call start_increment_at(model, real(cycle - 1, wp)/real(model%deck%stage(stage)%cycles, wp), 0.0_wp, state, increment)
      call evaluate(model, increment, state)
      call lay_out(self, model, state)
      self%recuts = model%recuts
   end subroutine enter_stage

   !> First guess of an increment: prescribed displacements in full, the others as in the last increment or, where that
   !> is far off and worse, as they are.
   subroutine first_guess(model, part, duration, increment, state)
      type(model_t), intent(in) :: model
      !> Part of the cycle, and the time that prescribed velocities act [s]
      real(wp), intent(in) :: part, duration
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      real(wp) :: unbalanced

      where (model%loads%fixed) state%u = state%u + duration*model%loads%velocity
      if (state%guess%move_part > 0.0_wp) then
         where (.not. model%loads%fixed) state%u = state%u + part/state%guess%move_part*state%guess%move
      end if
      call evaluate(model, increment, state)
      unbalanced = free_norm(model, state)
      if (state%guess%move_part <= 0.0_wp .or. unbalanced_ratio(model%loads, state) <= near) return
      where (.not. model%loads%fixed) state%u = increment%start%u
      call evaluate(model, increment, state)
      if (free_norm(model, state) <= unbalanced) return
      where (.not. model%loads%fixed) state%u = state%u + part/state%guess%move_part*state%guess%move
      call evaluate(model, increment, state)
   end subroutine first_guess

   !> Back to the start of the increment.
   subroutine give_up_increment(self, increment, state)
      type(implicit_solver_t), intent(inout) :: self
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state

      state = increment%start
      self%outdated = .true.
   end subroutine give_up_increment

   !> No rest, or no factors that would lead to it: say so. Rock that cannot break goes back to where it rested last, which the
   !> caller writes.
   subroutine give_up_cycle(self, model, stage, cycle, ending, state, report, errors)
      type(implicit_solver_t), intent(in) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      !> How the way in pseudo-time ended
      integer, intent(in) :: ending
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      integer :: joints

      report%unbalanced = unbalanced_ratio(model%loads, state)
      if (ending == end_linear) then
         call errors%add(no_factors(self%failure, model, stage, cycle, self%way%level, state))
         return
      end if
      associate (way => self%way)
         joints = size(way%increment%start%joint)
         report%moved = state%joint%u
         report%moved(:joints) = state%joint(:joints)%u - way%increment%start%joint%u
         call errors%add(no_rest(model, stage, cycle, way%level, ending, self%weak_springs, way%began, report%moved, state))
         if (.not. model%can_break) then
            state = way%increment%start
         else
            ! Its loads are those of the increment's end
            state%time = state%time + way%duration
         end if
      end associate
      report%unbalanced = unbalanced_ratio(model%loads, state)
   end subroutine give_up_cycle

   !> How far the walls of joint elements part for a pascal more at single nodes between them, at rest: the tangent's answer.
   subroutine answer_of_walls(self, model, state, node, filled, answer, found)
      class(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> At rest, found by this solver
      type(state_t), intent(inout) :: state
      !> Nodes of the mesh as read
      integer, intent(in) :: node(:)
      !> Is the pressure felt between the walls? (joints)
      logical, intent(in) :: filled(:)
      !> (joints, nodes given) [m/Pa]
      real(wp), allocatable, intent(out) :: answer(:, :)
      !> Has the matrix factors?
      logical, intent(out) :: found
      real(wp) :: in_rock(size(model%split%triangle, 2)), in_crack(size(filled)), force(2, size(state%u, 2)), &
                  motion(2, size(state%u, 2)), step(self%system%unknowns), normal(2, size(filled))
      type(joint_frame_t) :: frame
      integer :: j, k, status
      logical :: outside

      allocate (answer(size(filled), size(node)), source=0.0_wp)
      call renew_matrix(self, model, self%way%increment, state, outside)
      found = .not. (outside .or. allocated(self%failure))
      if (found) call factor_matrix(self)
      found = found .and. self%factored
      if (.not. found) return
      do j = 1, size(filled)
         associate (corner => model%split%joint(:, j))
            frame = joint_kinematics(model%split%x(:, corner), state%u(:, corner))
            normal(:, j) = frame%j
         end associate
      end do
      in_rock = 0.0_wp
      call now_doing(work_solves)
      do k = 1, size(node)
         in_crack = 0.0_wp
         do j = 1, size(filled)
            if (filled(j) .and. any(model%split%origin(model%split%joint(1:2, j)) == node(k))) in_crack(j) = 0.5_wp
         end do
         force = 0.0_wp
         call press_walls(model%split, in_rock, in_crack, filled, force)
         call gather(self%system, force, step)
         call self%lu%solve(step, status)
         found = status == linear_ok
         if (.not. found) exit
         motion = 0.0_wp
         call scatter(self%system, 1.0_wp, step, motion)
         do j = 1, size(filled)
            if (.not. filled(j)) cycle
            associate (corner => model%split%joint(:, j))
               answer(j, k) = 0.5_wp*dot_product(normal(:, j), motion(:, corner(3)) - motion(:, corner(1)) &
                                                 + motion(:, corner(4)) - motion(:, corner(2)))
            end associate
         end do
      end do
      call now_doing(work_other)
   end subroutine answer_of_walls

   !> Loads at the end of the last increment, 0 to 1 over the stage.
   pure real(wp) function load_level(self) result(level)
      class(implicit_solver_t), intent(in) :: self

      level = self%way%level
   end function load_level

   !> What a checkpoint keeps of the matrix; nothing for other solvers.
   pure function matrix_in_use(self) result(matrix)
      class(implicit_solver_t), intent(in) :: self
      type(kept_matrix_t) :: matrix

      if (self%factored) then
         matrix = matrix_of(self%system, self%lu%matrix(), self%outdated)
      else
         matrix = matrix_of(self%system, [real(wp) ::], self%outdated)
      end if
   end function matrix_in_use

   !> Another number for each matrix that the solver has had, and for how it stands.
   pure integer(i8) function matrix_number(self) result(number)
      class(implicit_solver_t), intent(in) :: self

      number = 4_i8*(self%patterns + self%factorisations) + merge(2_i8, 0_i8, self%factored) + merge(1_i8, 0_i8, self%outdated)
   end function matrix_number

   !> Say what it took and give back the memory of the matrix.
   subroutine close_solver(self, log)
      class(implicit_solver_t), intent(inout) :: self
      type(log_t), intent(in) :: log

      if (self%stage > 0) call log%say('implicit  '//to_text(self%system%unknowns)//' unknowns in the last stage; '// &
                                       to_text(self%iterations)//' iterations, '//to_text(self%factorisations)// &
                                       ' factorisations, '//to_text(self%patterns)//' patterns, ordered by '// &
                                       self%lu%ordering())
      if (self%stage > 0) call log%say('implicit  '//to_text(self%lagged)//' iterations with older factors, '// &
                                       to_text(self%lagged_steps)//' steps; factors take '//to_text(self%lu%memory())//' MB')
      if (self%pseudo_steps > 0_i8) call log%say('implicit  '//to_text(self%pseudo_steps)//' steps of pseudo-time, where '// &
                                                 'slip or cracks ran on by themselves')
      call self%lu%free()
   end subroutine close_solver

end module implicit_m
