!> Explicit solver: one load increment of a stage after the other, eq 1 stepped in time.
module explicit_m
   use kinds_m, only: wp, i8
   use stopwatch_m, only: begin_step, end_steps, now_doing, work_motion, work_cracks, work_step, work_other
   use constants_m, only: is_set
   use errors_m, only: error_list_t
   use interrupt_m, only: stop_wanted
   use text_m, only: to_text
   use log_m, only: log_t, progress_t
   use mesh_m, only: place_text
   use model_m, only: model_t
   use state_m, only: state_t, kinetic_energy
   use solid_stress_m, only: strain_energy
   use forces_m, only: find_forces, find_energies
   use stable_step_m, only: stable_step
   use corners_m, only: decide_corners, follow_closure
   use joints_m, only: have_stiffened
   use loads_m, only: smooth_ramp
   use bonds_m, only: follow_bonds
   use cracks_m, only: breaks_t, find_breaks, describe_bonds
   use release_m, only: release_factor
   use motion_m, only: pace_t, move_nodes, unbalanced_ratio
   use shares_m, only: speeds_of_shares, book_step
   implicit none
   private

   public :: explicit_cycle, start_account, fraction_done

   !> Steps between two looks at equilibrium and at the clock
   integer, parameter :: steps_between_looks = 100
   !> Unbalanced force ratio below which the rock is calm enough to see which corners hold
   real(wp), parameter :: calm = 0.05_wp
   !> Steps in which corners are pressed back to 1/e: many periods of a node on a corner, so that the rock follows without swinging
   real(wp), parameter :: steps_to_press = 300.0_wp
   !> Kinetic energy that only an unstable motion has [J per m]; its square is still a number
   real(wp), parameter :: absurd_energy = 1.0e100_wp

   !> What a cycle was like, for the log and the history
   type, public :: cycle_report_t
      !> Steps taken, smallest step [s]
      integer(i8) :: steps = 0_i8
      real(wp) :: smallest_step = huge(1.0_wp)
      !> Unbalanced force ratio at the end
      real(wp) :: unbalanced = 0.0_wp
      !> Did the rest end at the equilibrium asked for? True when none was asked for
      logical :: balanced = .true.
      !> Did a signal end the cycle before its end? What it leaves is then no state to go on from
      logical :: interrupted = .false.
      !> Slip of the joints since the last rest, when none was found after it (joints) [mm]; else not allocated
      real(wp), allocatable :: moved(:)
      !> Root of the largest kinetic energy that loads gave to the rock over the work of the run so far [-]: about how much
      !> further than to rest it swung
      real(wp) :: overshoot = 0.0_wp
      !> What has to change in the model before the cycle can go on: the solver is then called again
      type(breaks_t) :: breaks
      !> Loads then, 0 to 1 over the stage
      real(wp) :: level = 0.0_wp
   end type cycle_report_t

   !> How far a cycle has come, for one that goes on after rock has broken
   type, public :: march_t
      private
      !> A move, or a rest?
      logical :: moving = .true.
      !> Time to cover and covered [s], step [s]
      real(wp) :: duration = 0.0_wp, elapsed = 0.0_wp, dt = 0.0_wp
      !> How far velocities are behind displacements: half a step, but where all is known at one time [s]
      real(wp) :: lag = 0.0_wp
      !> Steps to come, and since the last look at equilibrium and at the clock
      integer(i8) :: steps_left = 0_i8
      integer :: since_look = 0
      !> Was the rock calm at that look, so that corners are pressed back?
      logical :: presses = .false.
   end type march_t

contains

   !> Open the energy account with what the initial velocities bring.
   subroutine start_account(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      state%energy%initial = kinetic_energy(state%mass, state%v) + strain_energy(model%solid, state%u)
   end subroutine start_account

   !> One cycle of a stage: move, then rest. Where rock breaks on the way it returns with what is to change in the model
   !> (report%breaks), and goes on when it is called again. On failure errors says when, where and what.
   subroutine explicit_cycle(model, stage, cycle, log, progress, march, state, report, errors)
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(progress_t), intent(inout) :: progress
      type(march_t), intent(inout) :: march
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      real(wp) :: rest_time, motion
      logical :: searched, goes_on

      associate (settings => model%deck%stage(stage))
         rest_time = settings%rest_time
         if (model%until_balanced(stage)) rest_time = model%longest_rest(stage)
         goes_on = report%breaks%any()
         if (.not. goes_on) march = march_t(duration=settings%move_time)
         do
            call step_on(model, stage, cycle, goes_on, log, progress, march, state, report, errors)
            call end_steps()
            if (report%breaks%any()) return
            if (.not. march%moving .or. rest_time <= 0.0_wp .or. errors%any() .or. report%interrupted) exit
            march = march_t(moving=.false., duration=rest_time, lag=march%lag)
            goes_on = .false.
         end do
         if (abs(state%energy%external) > 0.0_wp) report%overshoot = sqrt(report%overshoot/abs(state%energy%external))
         report%unbalanced = unbalanced_ratio(model%loads, state)
         if (model%until_balanced(stage)) report%balanced = report%unbalanced <= settings%equilibrium
         if (errors%any() .or. report%interrupted) return
         ! Stresses and joints as they are now: those of the last step were found before it moved the nodes
         call find_forces(model, real(cycle, wp)/real(settings%cycles, wp), state, searched)
         if (model%can_break) call follow_bonds(model%bonds, model%split%x, state%u, state%bonds)
         ! The velocities catch up: all energies are then those of one time
         motion = merge(1.0_wp, 0.0_wp, march%moving .and. settings%profile == 'constant')
         call settle_impacts(model, motion, march, state)
         if (march%lag > 0.0_wp) call move(model, motion, march%lag, 0.0_wp, state)
      end associate
      state%energy%kinetic = kinetic_energy(state%mass, state%v)
      call find_energies(model, state)
      call describe_bonds(model, state)
   end subroutine explicit_cycle

   !> Step through a move or a rest of given duration, or what is left of it; a rest may end sooner, at equilibrium.
   subroutine step_on(model, stage, cycle, goes_on, log, progress, march, state, report, errors)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      !> Has rock broken in the last step, and the model changed?
      logical, intent(in) :: goes_on
      type(log_t), intent(in) :: log
      type(progress_t), intent(inout) :: progress
      type(march_t), intent(inout) :: march
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      real(wp) :: fraction, level, motion, part
      logical :: searched, broken, changed, let_go, calm_now, by_loads

      if (march%duration <= 0.0_wp) return
      ! What is driven at a given speed has that much kinetic energy, however slowly it goes
      by_loads = .not. march%moving .or. .not. any(abs(model%loads%velocity) > 0.0_wp)
      broken = goes_on
      report%breaks = breaks_t()
      if (.not. goes_on) call fit_step()
      do while (march%steps_left > 0_i8 .or. broken)
         if (.not. broken) then
            call begin_step(state%step)
            fraction = march%elapsed/march%duration
            call profile(model, stage, march%moving, fraction, 0.5_wp*march%dt/march%duration, part, motion)
            level = (real(cycle - 1, wp) + part)/real(model%deck%stage(stage)%cycles, wp)
            call find_forces(model, level, state, searched)
            if (searched) then
               ! The step must suit the new pairs before they touch
               call fit_step()
               call profile(model, stage, march%moving, fraction, 0.5_wp*march%dt/march%duration, part, motion)
            end if
            call now_doing(work_motion)
            call settle_impacts(model, motion, march, state)
            call move(model, motion, march%lag + 0.5_wp*march%dt, march%dt, state)
            call now_doing(work_other)
            ! What damping has taken from the motion may go into the corners
            call follow_closure(model%corners, state%u, merge(1.0_wp - 1.0_wp/steps_to_press, 1.0_wp, march%presses), &
                                state%energy%corners + state%energy%damping, state%corners)
            march%lag = 0.5_wp*march%dt
            march%elapsed = march%elapsed + march%dt
            state%time = state%time + march%dt
            state%step = state%step + 1_i8
            report%steps = report%steps + 1_i8
            march%steps_left = march%steps_left - 1_i8
            if (by_loads) report%overshoot = max(report%overshoot, state%energy%kinetic)
            if (march%steps_left > 0_i8) report%interrupted = stop_wanted()
            if (report%interrupted) return
            ! Every step, since an unstable motion can grow a hundredfold in each. A comparison with NaN is false.
            if (.not. state%energy%kinetic < absurd_energy) then
               call report_failure(model, stage, cycle, state, march%dt, errors)
               return
            end if
            if (model%can_break) then
               if (mod(state%step, int(model%check_every, i8)) == 0_i8) then
                  call now_doing(work_cracks)
                  call find_breaks(model, state, report%breaks)
                  call now_doing(work_other)
               end if
               report%level = level
               if (report%breaks%any()) return
            end if
         end if
         ! After the last step there is nothing left to divide
         if (march%steps_left > 0_i8 .and. &
             (broken .or. state%walls%moved_on .or. have_stiffened(model%joints, state%tractions) .or. &
              .not. model%deck%plan%skip_step)) call fit_step()
         broken = .false.
         march%since_look = march%since_look + 1
         if (march%since_look < steps_between_looks .and. march%steps_left > 0_i8) cycle
         march%since_look = 0
         call progress%tick(log, fraction_done(model, stage, cycle, march%moving, march%elapsed/march%duration))
         if (size(model%corners%stiffness) > 0) then
            changed = .false.
            calm_now = unbalanced_ratio(model%loads, state) <= calm
            if (march%steps_left == 0_i8 .or. calm_now) then
               call decide_corners(model%corners, state%u, state%corners, changed, let_go)
            end if
            march%presses = calm_now
            if (changed .and. march%steps_left > 0_i8) call fit_step()
         end if
         if (.not. march%moving .and. model%until_balanced(stage)) then
            if (unbalanced_ratio(model%loads, state) <= model%deck%stage(stage)%equilibrium) return
         end if
      end do

   contains

      !> Divide the rest of the duration into equal steps no longer than the stable one.
      subroutine fit_step()
         real(wp) :: longest

         call now_doing(work_step)
         longest = stable_step(model, state)
         call now_doing(work_other)
         march%steps_left = max(1_i8, ceiling((march%duration - march%elapsed)/longest - 1.0e-9_wp, i8))
         march%dt = (march%duration - march%elapsed)/real(march%steps_left, wp)
         report%smallest_step = min(report%smallest_step, march%dt)
      end subroutine fit_step

   end subroutine step_on

   !> Let the velocities catch up with the displacements where contact gave to the motion what it did not have (or did not give
   !> what it had), and mend that.
   subroutine settle_impacts(model, motion, march, state)
      type(model_t), intent(in) :: model
      !> Factor of prescribed velocities
      real(wp), intent(in) :: motion
      type(march_t), intent(inout) :: march
      type(state_t), intent(inout) :: state
      real(wp) :: before

      if (.not. model%has_contact .or. march%lag <= 0.0_wp) return
      if (.not. state%contact%impacts%any_wrong()) return
      call move(model, motion, march%lag, 0.0_wp, state)
      before = state%energy%contact
      call state%contact%impacts%settle(state%mass, model%loads%fixed, 2.0_wp*march%lag, state%v, state%energy%contact, &
                                        state%energy%external)
      state%energy%surfaces = state%energy%surfaces + state%energy%contact - before
      march%lag = 0.0_wp
   end subroutine settle_impacts

   !> Move the nodes, with the work of the forces that new cracks let go of.
   subroutine move(model, motion, kick, drift, state)
      type(model_t), intent(in) :: model
      !> As in pace_t
      real(wp), intent(in) :: motion, kick, drift
      type(state_t), intent(inout) :: state
      real(wp), allocatable :: corners(:, :), surfaces(:, :)

      call speeds_of_shares(model, state, corners, surfaces)
      if (model%can_break) call account_release(0.5_wp*kick, state)
      call move_nodes(model%loads, pace_t(motion, model%local_damping, kick, drift), state, model%undisturbed)
      call book_step(model, corners, surfaces, kick, state)
      if (model%can_break) call account_release(0.5_wp*kick, state)
   end subroutine move

   !> Where loads and prescribed motion stand at a fraction of a move: the part of the cycle's load increment that is on
   !> at its end, and the factor of the prescribed velocities over the step. A rest has all of the increment and no motion.
   pure subroutine profile(model, stage, moving, fraction, half_step, part, motion)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      logical, intent(in) :: moving
      !> Fraction of the move that is over at the start of the step, and half a step as a fraction of the move
      real(wp), intent(in) :: fraction, half_step
      real(wp), intent(out) :: part, motion

      part = 1.0_wp
      motion = 0.0_wp
      if (.not. moving) return
      if (model%deck%stage(stage)%profile == 'smooth') then
         part = smooth_ramp(fraction)
         ! The mean rate over the step, so that the move covers its distance exactly
         motion = (smooth_ramp(fraction + 2.0_wp*half_step) - part)/(2.0_wp*half_step)
      else
         part = fraction
         motion = 1.0_wp
      end if
   end subroutine profile

   !> What letting go of the forces of new cracks takes out of the motion counts as damping.
   subroutine account_release(time, state)
      !> Half of the time that they act on the velocities, once before these change and once after [s]
      real(wp), intent(in) :: time
      type(state_t), intent(inout) :: state
      real(wp) :: factor

      factor = release_factor(state)
      if (factor > 0.0_wp) state%energy%damping = state%energy%damping - factor*time*sum(state%release*state%v)
   end subroutine account_release

   !> Say when and where the motion has grown out of all bounds.
   subroutine report_failure(model, stage, cycle, state, dt, errors)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt
      type(error_list_t), intent(inout) :: errors
      integer :: n, worst
      real(wp) :: speed(size(state%mass))

      worst = 0
      do n = 1, size(speed)
         speed(n) = maxval(abs(state%v(:, n)))
         ! Not a number
         if (worst == 0 .and. .not. speed(n) <= huge(1.0_wp)) worst = n
      end do
      if (worst == 0) worst = maxloc(speed, dim=1)
      call errors%add('the velocity has grown to '//to_text(speed(worst))//' m/s at time '//to_text(state%time)//' s (stage '''// &
                      trim(model%deck%stage(stage)%name)//''', cycle '//to_text(cycle)//', step '//to_text(state%step)// &
                      ', dt '//to_text(dt)//' s), most at node '//to_text(worst)//' near '// &
                      place_text(model%split%x(:, worst), model%split%datum)// &
                      '; try a smaller &explicit '//trim(merge('step  ', 'safety', is_set(model%deck%explicit%step)))// &
                      ', or check penalty and boundary conditions there')
   end subroutine report_failure

   !> Part of the whole run that is done, for the progress line: cycles weigh by their duration.
   pure real(wp) function fraction_done(model, stage, cycle, moving, part) result(done)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      logical, intent(in) :: moving
      real(wp), intent(in) :: part
      real(wp) :: total, before, move, rest
      integer :: s

      total = 0.0_wp
      before = 0.0_wp
      do s = 1, size(model%deck%stage)
         move = model%deck%stage(s)%move_time
         rest = max(model%deck%stage(s)%rest_time, 0.0_wp)
         if (model%until_balanced(s)) rest = max(rest, move)
         if (s < stage) before = before + real(model%deck%stage(s)%cycles, wp)*(move + rest)
         if (s == stage) before = before + real(cycle - 1, wp)*(move + rest) + merge(part*move, move + part*rest, moving)
         total = total + real(model%deck%stage(s)%cycles, wp)*(move + rest)
      end do
      done = 0.0_wp
      if (total > 0.0_wp) done = min(1.0_wp, before/total)
   end function fraction_done

end module explicit_m
