!> Relaxation solver: one load increment of a stage after the other, each followed in pseudo-time until it is at rest.
!>
!> The forces are those of the explicit solver. Masses are fictitious, so that a step of 1 is stable everywhere and every node
!> moves as fast as it may; whenever the kinetic energy has passed a peak all motion is stopped (kinetic damping). What is
!> left when nothing moves any more is an equilibrium. A block that nothing holds never stops: that is found and said.
module relaxation_m
   use kinds_m, only: wp, i8
   use errors_m, only: error_list_t
   use interrupt_m, only: stop_wanted
   use text_m, only: to_text
   use log_m, only: log_t, progress_t
   use mesh_m, only: place_text
   use model_m, only: model_t
   use corners_m, only: corner_choices_t, decide_corners, turn_corners, press_further, any_passed, any_held, keep_closure, &
                        most_pressed, most_chosen, while_pressed
   use state_m, only: state_t
   use joints_m, only: have_stiffened
   use loads_m, only: smooth_ramp
   use motion_m, only: unbalanced_ratio
   use forces_m, only: stiffness_bound
   use stable_step_m, only: scaled_mass
   use cracks_m, only: breaks_t, find_breaks, describe_bonds
   use explicit_m, only: cycle_report_t, fraction_done
   use increment_m, only: increment_t, start_increment, forces_from_start, account_increment, has_left, slip_watch_t, shortest
   implicit none
   private

   public :: relaxation_cycle, push_nodes, back_to_peak

   !> How far a cycle has come, for one that goes on after rock has broken
   type, public :: relaxation_place_t
      private
      !> Increments of the cycle that are done, part of the next one that is, and part of it that is tried
      integer :: substep = 0
      real(wp) :: done = 0.0_wp, part = 0.0_wp
      !> Longest part that is tried in this cycle
      real(wp) :: longest = 1.0_wp
      !> Did the last increment find no rest?
      logical :: stuck = .false.
      !> Have corners turned to their other sides in this increment, or just now, and what did they hold before (while rest is
      !> sought so)?
      logical :: turned = .false., turns = .false.
      type(corner_choices_t), allocatable :: before_turn
      type(slip_watch_t) :: watch
   end type relaxation_place_t

   !> How near to rest an increment has come since its corners changed last
   type :: way_t
      !> Unbalanced force ratio when the closure at corners was found last, and the least so far; step of that
      real(wp) :: since_kept = 1.0_wp, least = huge(1.0_wp)
      integer :: least_at = 0
      !> Peaks of the kinetic energy since then
      integer :: peaks = 0
      !> How motion is damped (see losses), and step from which on
      integer :: damping = 1, damped_from = 0
   contains
      procedure :: look
   end type way_t

   !> Steps over which an increment's prescribed displacements and loads come on, at least
   integer, parameter :: ramp_steps = 50
   !> While they come on nothing prescribed moves by more than this part of the smallest triangle's height in a step, in the mean
   real(wp), parameter :: ramp_stride = 0.05_wp
   !> Steps between two looks at the balance of forces, and at the clock and at what has come loose
   integer, parameter :: steps_between_looks = 10, looks_between_ticks = 10
   !> The last increment goes on when this leaves an unbalanced force ratio no greater
   real(wp), parameter :: near = 0.1_wp
   !> The closure at corners is found anew when the unbalanced force ratio has fallen to this part since it was found last
   real(wp), parameter :: refresh = 0.1_wp
   !> When the unbalanced force ratio has not fallen below this part of its least in so many steps, but the kinetic energy has
   !> passed so many peaks, motion is damped otherwise; in so many steps the increment is halved
   real(wp), parameter :: nearer = 0.9_wp
   integer, parameter :: undamped = 1500, swings = 10, patience = 10000
   !> Parts of its velocity that a node loses in a step, each tried after the one before: what swings about its rest wants much,
   !> what creeps there under much little or none
   real(wp), parameter :: losses(3) = [0.0_wp, 0.05_wp, 0.005_wp]
   !> Kinetic energy that only an unstable motion has [J per m]; its square is still a number
   real(wp), parameter :: absurd_energy = 1.0e100_wp

contains

   !> One cycle of a stage, in as many increments as the deck says. Where rock breaks it returns with what is to change in the
   !> model (report%breaks), and goes on when it is called again. On failure errors says when, where and what.
   subroutine relaxation_cycle(model, stage, cycle, log, progress, place, state, report, errors)
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(progress_t), intent(inout) :: progress
      type(relaxation_place_t), intent(inout) :: place
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      type(increment_t) :: increment
      real(wp) :: duration
      integer :: substeps
      logical :: broken, back

      substeps = model%deck%relaxation%substeps
      duration = model%deck%stage(stage)%move_time/real(substeps, wp)
      report%smallest_step = duration
      broken = report%breaks%any()
      report%breaks = breaks_t()
      if (.not. broken) then
         place = relaxation_place_t()
         ! A new stage prescribes another motion
         if (cycle == 1) then
            state%v = 0.0_wp
            state%guess%part = 1.0_wp
         end if
      end if
      do while (broken .or. place%substep < substeps)
         if (broken) then
            ! Rest at the same loads
            call start_increment(model, level_of(place%done), level_of(place%done), state, increment)
            call come_to_rest(model, stage, cycle, increment, increment%level, 0.0_wp, place, state, report, back, errors)
            if (errors%any()) return
         else
            place%part = min(state%guess%part, 1.0_wp - place%done)
            call start_increment(model, level_of(place%done), level_of(place%done + place%part), state, increment)
            call come_to_rest(model, stage, cycle, increment, level_of(place%done), place%part*duration, place, state, report, &
                              back, errors)
            if (errors%any()) return
            if (back) then
               call go_back(increment, place, state)
               cycle
            end if
            place%turned = .false.
            if (allocated(place%before_turn)) deallocate (place%before_turn)
            ! Velocities are means over the increment: so the next one goes on
            state%v = (state%u - increment%start%u)/(place%part*duration)
            state%time = state%time + place%part*duration
            report%smallest_step = min(report%smallest_step, place%part*duration)
            if (place%watch%is_short()) state%guess%part = min(place%longest, 2.0_wp*state%guess%part)
            ! Parts are halves of halves, without rounding
            place%done = place%done + place%part
            if (place%done >= 1.0_wp) then
               place%substep = place%substep + 1
               place%done = 0.0_wp
            end if
         end if
         broken = .false.
         if (model%can_break) then
            call find_breaks(model, state, report%breaks)
            report%level = increment%level
            if (report%breaks%any()) return
         end if
         call progress%tick(log, fraction_done(model, stage, cycle, .true., &
                                               (real(place%substep, wp) + place%done)/real(substeps, wp)))
         if (place%substep < substeps) report%interrupted = stop_wanted()
         if (report%interrupted) return
      end do
      state%time = state%time + max(0.0_wp, model%deck%stage(stage)%rest_time)
      report%unbalanced = unbalanced_ratio(model%loads, state)
      call describe_bonds(model, state)

   contains

      !> Loads in the middle of an increment, 0 to 1 over the stage.
      pure real(wp) function level_of(done) result(level)
         !> Part of the increment
         real(wp), intent(in) :: done

         level = (real(cycle - 1, wp) + (real(place%substep, wp) + done)/real(substeps, wp)) &
                 /real(model%deck%stage(stage)%cycles, wp)
      end function level_of

   end subroutine relaxation_cycle

   !> Back to the start of the increment, for half of it or, where corners have turned, all of it. Where there is no rest with
   !> corners turned they are as they were.
   subroutine go_back(increment, place, state)
      type(increment_t), intent(in) :: increment
      type(relaxation_place_t), intent(inout) :: place
      type(state_t), intent(inout) :: state
      type(corner_choices_t) :: choices

      choices = state%corners
      call go_back_to(increment%start, state)
      if (place%turns) then
         state%corners = choices
      else if (place%stuck .and. allocated(place%before_turn)) then
         state%corners = place%before_turn
         deallocate (place%before_turn)
      else
         ! Half of it starts with corners as they were
         if (allocated(place%before_turn)) then
            state%corners = place%before_turn
            deallocate (place%before_turn)
         end if
         place%turned = .false.
         state%guess%part = 0.5_wp*place%part
         if (place%stuck) place%longest = state%guess%part
      end if
      place%turns = .false.
   end subroutine go_back

   !> Back to an earlier state; steps are counted on.
   subroutine go_back_to(earlier, state)
      type(state_t), intent(in) :: earlier
      type(state_t), intent(inout) :: state
      integer(i8) :: step

      step = state%step
      state = earlier
      state%step = step
   end subroutine go_back_to

   !> Follow an increment until it is at rest, and book its work. One that is to be halved, because joints slip too far or the
   !> forces do not come nearer balance, is not booked.
   subroutine come_to_rest(model, stage, cycle, increment, level, duration, place, state, report, back, errors)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(increment_t), intent(in) :: increment
      !> Loads at its start, 0 to 1 over the stage
      real(wp), intent(in) :: level
      !> Time that prescribed velocities act [s]
      real(wp), intent(in) :: duration
      type(relaxation_place_t), intent(inout) :: place
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      !> Is half of it to be tried, from its start?
      logical, intent(out) :: back
      type(error_list_t), intent(inout) :: errors
      real(wp) :: mass(size(state%mass)), v(2, size(state%mass)), kinetic, before, part, unbalanced, tolerance
      type(way_t) :: way
      ! Before corners were pressed, and before they were pressed the last time
      type(state_t) :: unpressed, rest
      integer :: step, last, ramp, pressed, chosen
      logical :: searched, loose, changed, let_go, far_enough

      back = .false.
      far_enough = .false.
      place%stuck = .false.
      loose = .false.
      pressed = 0
      chosen = 0
      call find_masses(model, .true., state, mass)
      call keep_closure(model%corners, state%u, state%corners)
      call guess(model, increment, duration, state, ramp)
      v = 0.0_wp
      before = 0.0_wp
      last = model%deck%relaxation%max_steps + ramp
      do step = 1, last
         part = 1.0_wp
         if (step < ramp) part = smooth_ramp(real(step, wp)/real(ramp, wp))
         where (model%loads%fixed) state%u = increment%start%u + part*duration*model%loads%velocity
         call forces_from_start(model, increment, level + part*(increment%level - level), state, searched)
         report%steps = report%steps + 1_i8
         state%step = state%step + 1_i8
         if (searched .or. state%walls%moved_on .or. have_stiffened(model%joints, state%tractions) .or. &
             .not. model%deck%plan%skip_step) &
            call find_masses(model, .false., state, mass)
         if (step >= ramp .and. mod(step - ramp, steps_between_looks) == 0) then
            unbalanced = unbalanced_ratio(model%loads, state)
            tolerance = tolerance_of(model, pressed, state)
            if (any_held(state%corners) .and. unbalanced <= max(tolerance, refresh*way%since_kept)) then
               call keep_closure(model%corners, state%u, state%corners)
               call forces_from_start(model, increment, increment%level, state, searched)
               unbalanced = unbalanced_ratio(model%loads, state)
               way%since_kept = unbalanced
            end if
            if (unbalanced <= tolerance) then
               if (pressed == 0 .and. chosen == 0 .and. duration > 0.0_wp) call look_back(model, increment, place, state, back)
               if (back) return
               let_go = .false.
               if (pressed == 0 .and. chosen < most_chosen) then
                  call decide_corners(model%corners, state%u, state%corners, changed, let_go)
               else if (pressed == 0) then
                  call decide_corners(model%corners, state%u, state%corners, changed)
               end if
               if (let_go) then
                  chosen = chosen + 1
                  way = way_t(least_at=step)
                  call find_masses(model, .false., state, mass)
                  cycle
               end if
               if (pressed == most_pressed .or. .not. any_passed(model%corners, state%corners, state%u)) then
                  call account_increment(model, increment%start, state)
                  return
               end if
               ! Corners that have come into each other are pressed back, bit by bit
               rest = state
               if (pressed == 0) unpressed = state
               pressed = pressed + 1
               call press_further(state%corners)
               way = way_t(least_at=step)
               call find_masses(model, .false., state, mass)
               cycle
            else if (far_enough .and. step - way%least_at > patience .or. pressed > 0 .and. step + steps_between_looks > last) then
               call take_corners_back(model, unpressed, state)
               call forces_from_start(model, increment, increment%level, state, searched)
               call account_increment(model, increment%start, state)
               return
            else if (pressed > 0 .and. step - way%least_at > patience) then
               ! Rest with the corners where they were is better than none
               far_enough = .true.
               pressed = most_pressed
               call take_corners_back(model, rest, state)
               v = 0.0_wp
               before = 0.0_wp
               way = way_t(least_at=step)
               call find_masses(model, .false., state, mass)
               cycle
            end if
            loose = mod(step - ramp, steps_between_looks*looks_between_ticks) == 0 .and. has_left(model, increment%start%u, state)
            if (loose) exit
            call way%look(step, unbalanced)
            if (step - way%least_at > patience .and. may_be_halved(way%peaks, pressed, duration, place%part)) exit
         end if
         call push_nodes(model%loads%fixed, mass, before <= 0.0_wp, losses(way%damping), state, v, kinetic)
         ! A comparison with NaN is false
         if (.not. kinetic < absurd_energy) exit
         if (kinetic < before) then
            call back_to_peak(model%loads%fixed, mass, state, v)
            before = 0.0_wp
            way%peaks = way%peaks + 1
         else
            where (.not. model%loads%fixed) state%u = state%u + v
            before = kinetic
         end if
      end do
      back = allocated(place%before_turn) .or. (.not. loose .and. may_be_halved(way%peaks, pressed, duration, place%part))
      if (back) then
         place%stuck = .true.
         place%watch = slip_watch_t()
      else
         call report_failure(model, stage, cycle, increment, step, state, errors)
      end if
   end subroutine come_to_rest

   !> At rest: where joints have slipped too far half of the increment is tried; where it has driven a corner against the side that
   !> holds it, all of it with the other one.
   subroutine look_back(model, increment, place, state, back)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(relaxation_place_t), intent(inout) :: place
      type(state_t), intent(inout) :: state
      !> Is it to be tried again?
      logical, intent(out) :: back
      type(corner_choices_t) :: before

      back = place%watch%too_far(model, model%deck%relaxation%largest_slip, place%part, increment%start, state)
      if (back .or. place%turned) return
      before = state%corners
      call turn_corners(model%corners, increment%start%u, state%u, state%corners, place%turned)
      place%turns = place%turned
      back = place%turned
      if (back) place%before_turn = before
   end subroutine look_back

   !> Unbalanced force ratio at which an increment is at rest, or near enough for corners to be pressed further.
   pure real(wp) function tolerance_of(model, pressed, state) result(tolerance)
      type(model_t), intent(in) :: model
      !> How often they have been
      integer, intent(in) :: pressed
      type(state_t), intent(in) :: state

      tolerance = model%rest_tolerance()
      if (pressed == 0 .or. pressed == most_pressed) return
      if (any_passed(model%corners, state%corners, state%u)) tolerance = max(tolerance, while_pressed)
   end function tolerance_of

   !> Back to an earlier state of the increment, with corners as they were.
   subroutine take_corners_back(model, earlier, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: earlier
      type(state_t), intent(inout) :: state

      call go_back_to(earlier, state)
      call keep_closure(model%corners, state%u, state%corners)
   end subroutine take_corners_back

   !> Has the unbalanced force come nearer to balance? Motion that does not is damped otherwise.
   pure subroutine look(self, step, unbalanced)
      class(way_t), intent(inout) :: self
      integer, intent(in) :: step
      !> Unbalanced force ratio
      real(wp), intent(in) :: unbalanced

      if (unbalanced < nearer*self%least) then
         self%least = unbalanced
         self%least_at = step
         self%peaks = 0
      end if
      if (step - max(self%least_at, self%damped_from) > undamped .and. self%peaks >= swings) then
         self%damping = mod(self%damping, size(losses)) + 1
         self%damped_from = step
      end if
   end subroutine look

   !> May half the increment find rest? Not where a block goes its way without a swing, while corners are pressed back, nor where
   !> rock has broken.
   pure logical function may_be_halved(peaks, pressed, duration, part)
      !> Peaks of the kinetic energy since the forces were nearest to balance; times that corners were pressed back
      integer, intent(in) :: peaks, pressed
      !> Time that prescribed velocities act [s], part that the increment is of what a cycle is divided into
      real(wp), intent(in) :: duration, part

      may_be_halved = peaks >= swings .and. pressed == 0 .and. duration > 0.0_wp .and. part > shortest
   end function may_be_halved

   !> First guess: the free nodes go on as in the last increment, prescribed displacements and loads come on at once. Where
   !> that is far from balance, nodes stand still and the increment comes on over a ramp.
   subroutine guess(model, increment, duration, state, ramp)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      real(wp), intent(in) :: duration
      type(state_t), intent(inout) :: state
      !> Steps over which the increment comes on
      integer, intent(out) :: ramp
      real(wp) :: farthest
      logical :: searched

      ramp = 1
      if (duration <= 0.0_wp) return
      if (any(abs(state%v) > 0.0_wp)) then
         where (model%loads%fixed)
            state%u = increment%start%u + duration*model%loads%velocity
         elsewhere
            state%u = increment%start%u + duration*state%v
         end where
         call forces_from_start(model, increment, increment%level, state, searched)
         if (unbalanced_ratio(model%loads, state) <= near) return
         state%u = increment%start%u
      end if
      farthest = duration*maxval(abs(model%loads%velocity), mask=model%loads%fixed)
      ramp = ramp_steps
      if (any(model%loads%fixed)) ramp = max(ramp, ceiling(farthest/(ramp_stride*minval(model%solid%height))))
   end subroutine guess

   !> Fictitious masses for which a step of 1 is stable at the present stiffness. While an increment lasts they only grow.
   subroutine find_masses(model, anew, state, mass)
      type(model_t), intent(in) :: model
      logical, intent(in) :: anew
      type(state_t), intent(inout) :: state
      !> (nodes) [N/m per m of thickness]
      real(wp), intent(inout) :: mass(:)
      real(wp) :: stiffness(size(mass))

      if (anew) mass = 0.0_wp
      call stiffness_bound(model, state, stiffness)
      mass = scaled_mass(stiffness, 0.0_wp, mass, 1.0_wp/model%deck%relaxation%safety)
   end subroutine find_masses

   !> Velocities half a step on, and their kinetic energy. From rest the first step is half a one.
   pure subroutine push_nodes(fixed, mass, from_rest, loss, state, v, kinetic)
      !> Prescribed components (2, nodes)
      logical, intent(in) :: fixed(:, :)
      !> Fictitious mass (nodes) [N/m per m of thickness]
      real(wp), intent(in) :: mass(:)
      logical, intent(in) :: from_rest
      !> Part of the velocity that damping takes in a step
      real(wp), intent(in) :: loss
      !> Its forces are known
      type(state_t), intent(in) :: state
      !> Fictitious velocity (2, nodes) [m per step]
      real(wp), intent(inout) :: v(:, :)
      !> [J per m of thickness]
      real(wp), intent(out) :: kinetic
      real(wp) :: part, left, force
      integer :: n, i

      part = merge(0.5_wp, 1.0_wp, from_rest)/(1.0_wp + 0.5_wp*loss)
      left = (1.0_wp - 0.5_wp*loss)/(1.0_wp + 0.5_wp*loss)
      kinetic = 0.0_wp
      do n = 1, size(mass)
         do i = 1, 2
            if (fixed(i, n)) cycle
            force = state%solid(i, n) + state%normal(i, n) + state%friction(i, n) + state%load(i, n)
            v(i, n) = left*v(i, n) + part*force/mass(n)
            kinetic = kinetic + 0.5_wp*mass(n)*v(i, n)**2
         end do
      end do
   end subroutine push_nodes

   !> The kinetic energy has fallen in the push just done: go back to where it was largest, half a step before, and stop.
   pure subroutine back_to_peak(fixed, mass, state, v)
      logical, intent(in) :: fixed(:, :)
      real(wp), intent(in) :: mass(:)
      !> Its forces are those of the push
      type(state_t), intent(inout) :: state
      real(wp), intent(inout) :: v(:, :)
      real(wp) :: force
      integer :: n, i

      do n = 1, size(mass)
         do i = 1, 2
            if (fixed(i, n)) cycle
            force = state%solid(i, n) + state%normal(i, n) + state%friction(i, n) + state%load(i, n)
            state%u(i, n) = state%u(i, n) - 0.5_wp*(v(i, n) - force/mass(n))
         end do
      end do
      v = 0.0_wp
   end subroutine back_to_peak

   !> Say when and where the rock does not come to rest.
   subroutine report_failure(model, stage, cycle, increment, steps, state, errors)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(increment_t), intent(in) :: increment
      integer, intent(in) :: steps
      type(state_t), intent(in) :: state
      type(error_list_t), intent(inout) :: errors
      integer :: n, worst
      real(wp) :: path(size(state%mass))

      do n = 1, size(path)
         path(n) = norm2(state%u(:, n) - increment%start%u(:, n))
         ! Not a number
         if (.not. path(n) <= huge(1.0_wp)) path(n) = huge(1.0_wp)
      end do
      worst = maxloc(path, dim=1)
      call errors%add('the rock near '//place_text(model%split%x(:, worst), model%split%datum)// &
                      ' does not come to rest at time '//to_text(state%time)//' s (stage '''// &
                      trim(model%deck%stage(stage)%name)//''', cycle '//to_text(cycle)//', load level '// &
                      to_text(increment%level)//'): it has moved '//to_text(path(worst))//' m in '//to_text(steps)// &
                      ' steps of relaxation, and the unbalanced force ratio is '// &
                      to_text(unbalanced_ratio(model%loads, state))//'; where a block has come loose, follow its motion with '// &
                      'solver = ''explicit''; else try more cycles or a larger &relaxation max_steps or tolerance')
   end subroutine report_failure

end module relaxation_m
