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
   use mesh_m, only: place_text
   use model_m, only: model_t
   use state_m, only: state_t
   use motion_m, only: unbalanced_ratio
   use support_m, only: find_loose
   use contact_m, only: contact_energy_t
   use cracks_m, only: breaks_t, find_breaks, describe_bonds
   use explicit_m, only: cycle_report_t, fraction_done
   use increment_m, only: account_increment, has_left, slip_over_peak
   use corners_m, only: decide_corners, press_further, press_back, any_passed, free_choices, any_chosen, most_pressed
   use sparse_system_m, only: kept_matrix_t, matrix_of
   use newton_m, only: newton_t, newton_increment_t, start_increment_at, lay_out, lay_out_as_kept, equilibrate, evaluate, free_norm
   implicit none
   private

   public :: implicit_cycle, enter_stage, settle

   !> How far a cycle has come, for one that goes on after rock has broken
   type :: way_t
      !> Part of the cycle that is done, part of it that the increment adds, and where it is to end
      real(wp) :: done = 0.0_wp, part = 0.0_wp, until = 1.0_wp
      !> Loads at the increment's end, 0 to 1 over the stage, and the time it takes [s]
      real(wp) :: level = 0.0_wp, duration = 0.0_wp
      !> Slip of the longer increment that joints slipped too far in (see slip_over_peak), over what is allowed
      real(wp) :: slip = huge(1.0_wp)
      !> Starts at the last rest
      type(newton_increment_t) :: increment
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
      procedure :: close => close_solver
   end type implicit_solver_t

   !> What is left of a cycle is nothing below this part of it: rounding
   real(wp), parameter :: least_part = 1.0e-9_wp
   !> No increment is halved below this part of a cycle because joints slip far, nor where half of it has slipped nearly as far
   real(wp), parameter :: shortest = 1.0_wp/64.0_wp, shorter_slip = 0.75_wp
   !> Increments no longer than this part of a cycle that find no rest are tried with corners free
   real(wp), parameter :: choose_anew = 0.25_wp
   !> Unbalanced force ratio while corners are pressed back, all but the last time
   real(wp), parameter :: while_pressed = 1.0e-4_wp
   !> An increment that took no more iterations than this is followed by a longer one
   integer, parameter :: easy = 12
   !> A first guess with a greater unbalanced force ratio than this is compared with standing still
   real(wp), parameter :: near = 0.1_wp
   !> Contact of other surfaces may carry this share of all forces before the answer is refused
   real(wp), parameter :: negligible = 1.0e-2_wp
   !> Rock that cannot break has collapsed when it has moved by this part of the scene in pseudo-time
   real(wp), parameter :: collapsed = 0.1_wp
   !> Block edges named in the message of a collapse
   integer, parameter :: most_named = 3
   !> Ends of a search for rest: found, moved too far, too heavy a drag, too many steps, no factors of the matrix, rock breaks,
   !> to be tried again otherwise
   integer, parameter :: end_rest = 0, end_far = 1, end_stuck = 2, end_long = 3, end_linear = 4, end_broken = 5, end_again = 6
   !> Pseudo-time: drag of the first step, factors by which it falls after an easy step and grows after one without
   !> equilibrium, drag that lets nothing move any more, and drag so light that equilibrium without it is worth a try
   real(wp), parameter :: first_drag = 1.0_wp, lighter = 0.25_wp, heavier = 4.0_wp, heaviest = 1.0e6_wp, light = 1.0e-9_wp
   !> Unbalanced force ratio at which a step of pseudo-time is done, also as a share of what it starts from
   real(wp), parameter :: pseudo_tolerance = 1.0e-5_wp, pseudo_share = 1.0e-2_wp
   !> A step that took no more iterations than this is followed by one with less drag
   integer, parameter :: easy_pseudo = 22
   !> Steps found in a row after one that was not, before the drag falls again
   integer, parameter :: in_a_row = 2
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
      integer :: ending
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
            call follow(self, model, state, report%breaks, ending)
         else if (broken) then
            call rest_again(self, model, state, ending)
         else
            call find_rest(self, model, stage, cycle, state, ending)
         end if
         broken = .false.
         if (ending == end_again) cycle
         if (ending == end_rest .and. model%can_break .and. .not. self%cracks_wait) then
            call find_breaks(model, state, report%breaks)
            if (report%breaks%any()) ending = end_broken
         end if
         select case (ending)
         case (end_rest)
         case (end_broken)
            report%level = self%way%level
            return
         case (end_linear)
            call report_linear_failure(self, model, stage, cycle, state, report, errors)
            return
         case default
            call report_failure(self, model, stage, cycle, ending, state, report, errors)
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
      if (model%has_contact) call check_other_contact(self, model, stage, log, state, errors)
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
      real(wp) :: slip, shortest_cut
      integer :: iterations
      logical :: found

      associate (way => self%way)
         way%part = min(state%guess%part, way%until - way%done)
         way%duration = way%part*model%deck%stage(stage)%move_time
         way%level = (real(cycle - 1, wp) + min(way%until, way%done + way%part))/real(model%deck%stage(stage)%cycles, wp)
         call start_increment_at(model, way%level, way%duration, state, way%increment)
         call first_guess(model, way%part, way%duration, way%increment, state)
      end associate
      call equilibrate(self, model, self%way%increment, model%rest_tolerance(), state, iterations, found)
      ending = end_rest
      slip = 0.0_wp
      if (found) slip = slip_over_peak(model, self%way%increment%start, state)/model%deck%implicit%largest_slip
      if (slip > 1.0_wp .and. self%way%part > shortest .and. slip < shorter_slip*self%way%slip) then
         ! The laws are followed along their curves; but what snaps slips as far in a shorter increment
         call give_up_increment(self, self%way%increment, state)
         ending = end_again
         self%way%slip = slip
         state%guess%part = 0.5_wp*self%way%part
         state%guess%slip_part = state%guess%part
         return
      end if
      self%way%slip = huge(1.0_wp)
      if (found) then
         call hold_corners(self, model, self%way%increment, state, iterations)
         call account_increment(model, self%way%increment%start, state)
         state%guess%move = state%u - self%way%increment%start%u
         state%guess%move_part = self%way%part
         if (iterations <= easy .and. slip <= 0.5_wp) state%guess%part = min(1.0_wp, 2.0_wp*state%guess%part)
         state%guess%slip_part = max(state%guess%slip_part, state%guess%part)
         return
      end if
      call give_up_increment(self, self%way%increment, state)
      ending = end_again
      ! Points that were chosen to hold each other may stand in the way: they choose anew at the rest without them
      if (self%way%part <= choose_anew .and. any_chosen(model%corners, state%corners) .and. .not. allocated(self%failure)) then
         call free_choices(model%corners, state%corners)
         return
      end if
      state%guess%part = 0.5_wp*state%guess%part
      if (allocated(self%failure)) ending = end_linear
      shortest_cut = 0.5_wp**model%deck%implicit%largest_cut*state%guess%slip_part
      if (allocated(self%failure) .or. state%guess%part >= shortest_cut) return
      call start_following(self%way, self%way%duration, state)
      state%guess%move_part = 0.0_wp
      state%guess%part = shortest_cut
   end subroutine find_rest

   !> At rest: hold the corners that have come into each other, and press them back bit by bit in the same increment, as far as
   !> there is rest.
   subroutine hold_corners(self, model, increment, state, iterations)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      !> Those of the increment, to which this adds
      integer, intent(inout) :: iterations
      type(state_t) :: rest
      real(wp) :: pressed(2, size(state%u, 2)), tolerance
      integer :: round, more
      logical :: changed, found

      call decide_corners(model%corners, state%u, state%corners, changed)
      do round = 1, most_pressed
         if (.not. any_passed(model%corners, state%corners, state%u)) return
         rest = state
         call press_further(state%corners)
         if (round == 1) self%outdated = .true.
         ! What is pressed further moves on as it has begun to
         if (round > 1) state%u = state%u + press_back*(state%u - pressed)
         pressed = rest%u
         tolerance = model%rest_tolerance()
         if (round < most_pressed .and. any_passed(model%corners, state%corners, state%u)) tolerance = max(tolerance, while_pressed)
         call evaluate(model, increment, state)
         call equilibrate(self, model, increment, tolerance, state, more, found)
         iterations = iterations + more
         if (found) cycle
         state = rest
         self%outdated = .true.
         call equilibrate(self, model, increment, model%rest_tolerance(), state, more, found)
         iterations = iterations + more
         return
      end do
   end subroutine hold_corners

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
      if (ending == end_again) call follow(self, model, state, report%breaks, ending)
      if (ending == end_linear) call report_linear_failure(self, model, stage, cycle, state, report, errors)
      if (ending /= end_linear .and. ending /= end_rest) &
         call report_failure(self, model, stage, cycle, ending, state, report, errors)
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
   subroutine follow(self, model, state, breaks, ending)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
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
      do while (self%way%step < model%deck%implicit%max_pseudo_steps)
         self%way%step = self%way%step + 1
         call start_increment_at(model, self%way%level, self%way%to_come, state, increment)
         where (model%loads%fixed) state%u = state%u + self%way%to_come*model%loads%velocity
         call evaluate(model, increment, state)
         unbalanced = unbalanced_ratio(model%loads, state)
         tolerance = max(model%rest_tolerance(), min(pseudo_tolerance, pseudo_share*unbalanced))
         free = self%way%drag <= light .or. self%way%calming
         self%way%calming = .false.
         increment%softens = .true.
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
      call check_support(self, model, stage, log, errors)
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

   !> Find what nothing holds: refuse it, or hold it by weak springs in the matrix alone, which carry no force.
   subroutine check_support(self, model, stage, log, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: loose(:), rock(:), joint(:)
      character(len=:), allocatable :: what
      integer :: i

      ! Bodies lean on each other at walls, and bonds hold them. What was taken out holds nothing
      rock = pack([(i, i=1, size(model%split%present))], model%split%present)
      joint = pack([(i, i=1, size(model%joints%gone))],.not. model%joints%gone)
      call find_loose(model%split%x, model%split%triangle(:, rock), model%split%joint(:, joint), model%loads%fixed, loose)
      self%weak_springs = size(loose) > 0
      do i = 1, size(loose)
         what = 'stage '''//trim(model%deck%stage(stage)%name)//''': nothing holds the rock around '// &
                place_text(model%split%x(:, loose(i)), model%split%datum)
         if (model%deck%implicit%loose_bodies == 'hold') then
            call log%warn(what//'; its loads must be in balance')
         else
            call errors%add(what//' against sliding or turning as a whole, and an implicit solver finds no equilibrium '// &
                            'there; prescribe displacements (&boundary vx, vy = 0), set &implicit loose_bodies = ''hold'' '// &
                            'if its loads are in balance, or use solver = ''explicit''')
         end if
      end do
   end subroutine check_support

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

   !> Do surfaces that are no fracture walls press on each other? That contact is not in the equations.
   subroutine check_other_contact(self, model, stage, log, state, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(log_t), intent(in) :: log
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp) :: push(2, size(state%u, 2)), rub(2, size(state%u, 2)), share
      type(contact_energy_t) :: energy
      character(len=:), allocatable :: what
      integer :: node

      if (model%contact%needs_search(state%contact, state%u)) call model%contact%search(model%exposed, state%u, state%contact)
      push = 0.0_wp
      rub = 0.0_wp
      call model%contact%forces(model%exposed, state%u, state%v, state%surface_friction, state%contact, push, rub, energy)
      share = norm2(push)
      if (share <= 0.0_wp) return
      share = share/norm2([norm2(state%normal), norm2(state%friction), norm2(state%load), share])
      node = maxloc(push(1, :)**2 + push(2, :)**2, dim=1)
      what = 'surfaces that are not the two walls of a fracture overlap in stage '''// &
             trim(model%deck%stage(stage)%name)//''', most near '// &
             place_text(model%split%x(:, node), model%split%datum)//': their contact would be '// &
             to_text(100.0_wp*share)//' % of all forces'
      if (share > negligible) then
         call errors%add(what//', which the implicit solver leaves out; use solver = ''relaxation'' or ''explicit'', or '// &
                         '&contact active = .false. if this does not matter')
      else if (.not. self%warned) then
         call log%warn(what//'; it is left out')
         self%warned = .true.
      end if
   end subroutine check_other_contact

   !> Back to the start of the increment.
   subroutine give_up_increment(self, increment, state)
      type(implicit_solver_t), intent(inout) :: self
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state

      state = increment%start
      self%outdated = .true.
   end subroutine give_up_increment

   !> No rest: say when, where and what moves. Rock that cannot break goes back to where it rested last, which the caller writes.
   subroutine report_failure(self, model, stage, cycle, ending, state, report, errors)
      type(implicit_solver_t), intent(in) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      !> How the way in pseudo-time ended
      integer, intent(in) :: ending
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: why, advice
      integer :: joints, most

      joints = size(self%way%increment%start%joint)
      report%moved = state%joint%u
      report%moved(:joints) = state%joint(:joints)%u - self%way%increment%start%joint%u
      why = ' in '//to_text(model%deck%implicit%max_pseudo_steps)//' steps of pseudo-time'
      advice = 'a larger &implicit max_pseudo_steps follows it further'
      select case (ending)
      case (end_far)
         why = ': nothing holds the load'
         advice = 'less load or other supports hold it; solver = ''explicit'' follows the motion'
      case (end_stuck)
         why = ', and steps of pseudo-time find no way on'
         advice = 'more cycles or solver = ''relaxation'' may find it'
      end select
      if (self%weak_springs) then
         advice = 'springs without force alone hold rock here (&implicit loose_bodies), and its loads are not in balance'
         if (size(model%loads%pressure_surface) > 0) &
            advice = advice//': &boundary pressure turns with the surface, and a body that turns in it may have no equilibrium'
         advice = advice//'; prescribe displacements that hold it, or give tractions (tx, ty), which do not turn'
      end if
      why = 'no rest at time '//to_text(state%time)//' s (stage '//quoted(model%deck%stage(stage)%name)//', cycle '// &
            to_text(cycle)//', load level '//to_text(self%way%level)//')'//why
      most = maxloc(sum((state%u - self%way%began)**2, dim=1, mask=.not. model%loads%fixed), dim=1)
      why = why//'; most moves the rock near '//place_text(model%split%x(:, most), model%split%datum)//', by '// &
            to_text(norm2(state%u(:, most) - self%way%began(:, most)))//' m'
      if (.not. model%can_break) then
         state = self%way%increment%start
      else
         ! Its loads are those of the increment's end
         state%time = state%time + self%way%duration
      end if
      report%unbalanced = unbalanced_ratio(model%loads, state)
      call errors%add(why//moving_edges(model, report%moved)//'; '//advice//'. The state written last is '// &
                      trim(merge('that of the last step ', 'the last one at rest  ', model%can_break)))
   end subroutine report_failure

   !> The linear solver cannot go on: say why. The state is that of the last rest.
   subroutine report_linear_failure(self, model, stage, cycle, state, report, errors)
      type(implicit_solver_t), intent(in) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(in) :: state
      type(cycle_report_t), intent(inout) :: report
      type(error_list_t), intent(inout) :: errors

      report%unbalanced = unbalanced_ratio(model%loads, state)
      call errors%add(self%failure//' at time '//to_text(state%time)//' s (stage '//quoted(model%deck%stage(stage)%name)// &
                      ', cycle '//to_text(cycle)//', load level '//to_text(self%way%level)//'); a coarser mesh, a larger '// &
                      '&implicit max_memory, a machine with more memory or solver = ''relaxation'', which needs no matrix, '// &
                      'may help. What is written ends with the last cycle completed')
   end subroutine report_linear_failure

   !> The block edges that have slipped most.
   function moving_edges(model, moved) result(text)
      type(model_t), intent(in) :: model
      !> Slip since the last rest (joints) [mm]
      real(wp), intent(in) :: moved(:)
      character(len=:), allocatable :: text
      real(wp), allocatable :: slip(:)
      integer :: i, edge, joint

      text = ''
      if (size(model%topology%edge_length) == 0) return
      slip = [(mean_slip(i), i=1, size(model%topology%edge_length))]
      do i = 1, min(most_named, size(slip))
         edge = maxloc(slip, dim=1)
         if (slip(edge) <= 0.0_wp) exit
         joint = findloc(model%topology%edge_of_joint, edge, dim=1)
         if (i == 1) text = '; block edges that slip:'
         if (i > 1) text = text//','
         text = text//' '//to_text(edge)//' at '//place_text(model%split%x(:, model%split%joint(1, joint)), model%split%datum)// &
                ' ('//to_text(slip(edge))//' mm)'
         slip(edge) = 0.0_wp
      end do

   contains

      !> Mean slip of a block edge [mm].
      pure real(wp) function mean_slip(edge)
         integer, intent(in) :: edge
         logical :: member(size(moved))

         member = model%topology%edge_of_joint == edge
         mean_slip = 0.0_wp
         if (any(member)) mean_slip = sum(model%joints%length*abs(moved), mask=member)/sum(model%joints%length, mask=member)
      end function mean_slip

   end function moving_edges

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
                                       trim(merge('METIS (nested dissection)', 'AMF (minimum degree)     ', self%dissected)))
      if (self%stage > 0) call log%say('implicit  '//to_text(self%lagged)//' iterations with older factors, '// &
                                       to_text(self%lagged_steps)//' steps; factors take '//to_text(self%lu%memory())//' MB')
      if (self%pseudo_steps > 0_i8) call log%say('implicit  '//to_text(self%pseudo_steps)//' steps of pseudo-time, where '// &
                                                 'slip or cracks ran on by themselves')
      call self%lu%free()
   end subroutine close_solver

end module implicit_m
