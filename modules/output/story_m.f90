!> What the log tells of a run: its start, the end of each stage, its end.
module story_m
   use kinds_m, only: wp, i8
   use stopwatch_m, only: time_lines
   use constants_m, only: is_set
   use units_m, only: millimetre
   use files_m, only: file_exists
   use interrupt_m, only: signal_name
   use text_m, only: to_text, quoted
   use log_m, only: log_t, progress_t
   use version_m, only: program_version, program_commit
   use deck_m, only: deck_t
   use mesh_m, only: place_text
   use corners_m, only: corner_overlap
   use model_m, only: model_t
   use solver_choice_m, only: solver_explicit, solver_implicit
   use state_m, only: state_t
   use explicit_m, only: cycle_report_t
   use forces_m, only: find_forces, net_force
   use solid_stress_m, only: in_situ_scale, turned_over
   implicit none
   private

   !> Corners that overlap by more than this part of the largest slip are warned of
   real(wp), parameter :: corner_share = 1.0e-2_wp

   public :: say_start, say_in_situ, say_stage, say_end, say_stopped, command_text

contains

   subroutine say_start(deck, log)
      type(deck_t), intent(in) :: deck
      type(log_t), intent(in) :: log

      call log%say('femdem '//program_version//' ('//program_commit//')')
      call log%say('deck      '//deck%path//': '//trim(deck%run%title))
   end subroutine say_start

   !> The end of a stage: time, steps, step, balance of forces and energy.
   subroutine say_stage(model, stage, state, report, log)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(state_t), intent(in) :: state
      !> Report of the stage's last cycle
      type(cycle_report_t), intent(in) :: report
      type(log_t), intent(in) :: log
      real(wp) :: added, total

      call log%say('stage     '//quoted(model%deck%stage(stage)%name)//' done at '//to_text(state%time)//' s, step '// &
                   to_text(state%step)//' (last dt '//to_text(report%smallest_step)//' s); unbalanced force ratio '// &
                   to_text(report%unbalanced))
      added = sum(state%mass) - sum(model%nodes%mass)
      total = sum(model%nodes%mass)
      if (added > 0.0_wp) call log%say('          mass scaling has added '//to_text(added)//' kg/m, '// &
                                       to_text(100.0_wp*added/total)//' % of the mass')
      call say_overshoot(model, stage, state, report, log)
      if (is_set(model%deck%stage(stage)%equilibrium) .and. .not. report%balanced) &
         call log%warn('stage '//quoted(model%deck%stage(stage)%name)//' ended before equilibrium: unbalanced force ratio '// &
                       to_text(report%unbalanced)//' after the longest rest allowed; asked for was '// &
                       to_text(model%deck%stage(stage)%equilibrium)//' (max_rest_time, damping)')
      call warn_of_corners(model, state, log)
      call warn_of_turned_rock(model, state, log)
   end subroutine say_stage

   !> Say where triangles are turned inside out: forces are in balance there too, but they are not those of any rock.
   subroutine warn_of_turned_rock(model, state, log)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(log_t), intent(in) :: log
      logical :: turned(size(model%solid%area))
      integer :: first

      turned = turned_over(model%solid, state%u)
      first = findloc(turned, .true., dim=1)
      if (first == 0) return
      call log%warn(to_text(count(turned))//' of '//to_text(size(turned))//' triangles are turned inside out, the first near '// &
                    place_text(sum(model%split%x(:, model%split%triangle(:, first)), dim=2)/3.0_wp, model%split%datum)// &
                    ': loads or prescribed motion are beyond all that elastic rock bears, and the result means nothing there')
   end subroutine warn_of_turned_rock

   !> Say where corners of blocks have passed into each other by more than closure and elasticity let them.
   subroutine warn_of_corners(model, state, log)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(log_t), intent(in) :: log
      character(len=:), allocatable :: place
      real(wp) :: deepest
      integer :: pair

      call corner_overlap(model%corners, state%u, deepest, pair)
      if (pair == 0) return
      if (deepest <= corner_share*maxval(abs(state%joint%u))*millimetre) return
      place = place_text(model%split%x(:, model%corners%node(1, pair)), model%split%datum)
      call log%warn('corners of blocks overlap by '//to_text(deepest/millimetre)//' mm beyond the closure of their joints '// &
                    'near '//place//': no rest was found with them held, or corner_factor is small; more cycles may hold them')
   end subroutine warn_of_corners

   !> Joints and cracks that slide too far while the rock swings stay there: rest alone does not tell. The kinetic energy does.
   subroutine say_overshoot(model, stage, state, report, log)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(state_t), intent(in) :: state
      !> Report of the stage's last cycle
      type(cycle_report_t), intent(in) :: report
      type(log_t), intent(in) :: log
      !> Overshoot that is worth a word: slip was too large by a third of it up to all of it where that was measured
      real(wp), parameter :: noticeable = 0.01_wp

      if (model%solver /= solver_explicit .or. .not. model%until_balanced(stage) .or. size(state%joint) == 0) return
      call log%say('          the rock swung about '//to_text(100.0_wp*report%overshoot)// &
                   ' % further than to rest in the last cycle (root of its kinetic energy over the work)')
      if (report%overshoot > noticeable) &
         call log%warn('stage '//quoted(model%deck%stage(stage)%name)//': loads grew so fast that the rock swung about '// &
                       to_text(100.0_wp*report%overshoot)//' % further than to rest; joints that slid with it stay there. '// &
                       'For less: more cycles, a longer move_time, or solver = ''implicit''')
   end subroutine say_overshoot

   !> Is the in-situ stress in balance with the boundary, the weight and the joints? Before anything has moved.
   subroutine say_in_situ(model, state, log)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(log_t), intent(in) :: log
      !> Unbalanced force over the forces of the stress in all corners of triangles that is worth a word: joints in a stress
      !> that grows with depth leave less
      real(wp), parameter :: noticeable = 1.0e-3_wp
      type(state_t) :: trial
      real(wp) :: share
      logical :: searched

      trial = state
      call find_forces(model, 0.0_wp, trial, searched)
      share = norm2(pack(net_force(trial),.not. model%loads%fixed))/in_situ_scale(model%solid)
      call log%say('in situ   unbalanced force '//to_text(share)//' of the forces of the stress')
      if (share > noticeable) &
         call log%warn('the in-situ stress is not in balance with the boundary, the weight and the joints: '// &
                       to_text(100.0_wp*share)//' % of its forces. On sides that nothing holds &boundary sxx, syy, sxy of the '// &
                       'first stage is to be the same, and syy_gradient is density times gravity; what is left moves the rock '// &
                       'in the first stage')
   end subroutine say_in_situ

   subroutine say_end(directory, model, state, progress, first_step, log)
      character(len=*), intent(in) :: directory
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(progress_t), intent(in) :: progress
      !> Steps before this run, for one that goes on from a checkpoint
      integer(i8), intent(in) :: first_step
      type(log_t), intent(in) :: log

      call log%say('energy    external '//to_text(state%energy%external)//' J/m, residual '// &
                   to_text(state%energy%residual())//' J/m')
      ! Coupled joints lift the walls as they dilate: what they give out so, shearing has put in
      if (model%solver == solver_explicit .and. energy_from_contact(state) &
          .and. .not. any(model%deck%joint%coupling == 'coupled')) &
         call log%warn('the contact has given out '//to_text(-state%energy%contact)//' J/m more than it took up: bodies '// &
                       'collide too fast for this step; try a smaller &explicit safety or &material penalty_factor')
      if (model%has_contact) call log%say('contact   '//to_text(state%contact%searches)//' searches in '// &
                                          to_text(state%step)//' steps')
      call say_time(model, state%step - first_step, log)
      call log%say('done      '//to_text(state%step)//' steps in '//to_text(progress%elapsed())//' s; results in '//directory)
   end subroutine say_end

   !> Where the time went, and how fast the run was.
   subroutine say_time(model, steps, log)
      type(model_t), intent(in) :: model
      !> Steps or iterations of this run
      integer(i8), intent(in) :: steps
      type(log_t), intent(in) :: log
      character(len=:), allocatable :: what
      real(wp) :: size_of_step
      integer :: i

      size_of_step = real(size(model%split%triangle, 2), wp)
      what = 'triangle-steps'
      if (model%solver == solver_implicit) then
         size_of_step = real(2*size(model%split%x, 2), wp)
         what = 'unknowns times iterations'
      end if
      associate (line => time_lines(size_of_step*real(steps, wp), what))
         do i = 1, size(line)
            call log%say(trim(line(i)))
         end do
      end associate
   end subroutine say_time

   !> A signal has ended the run: what is kept, and how to go on.
   subroutine say_stopped(checkpoint, model, stage, cycle, log)
      !> Path of the checkpoint
      character(len=*), intent(in) :: checkpoint
      type(model_t), intent(in) :: model
      !> Last stage and cycle completed (0: none)
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      logical :: kept

      ! An old checkpoint may be there, and none where a restarted run writes to another directory
      kept = file_exists(checkpoint)
      if (stage == 0) kept = .false.
      if (.not. kept) then
         call log%warn('stopped by '//signal_name()//' before the first cycle was completed: there is nothing to go on from')
      else
         call log%warn('stopped by '//signal_name()//'; kept is all up to cycle '//to_text(cycle)//' of stage '// &
                       quoted(model%deck%stage(stage)%name)//'. To go on: femdem --restart '//checkpoint//' '// &
                       model%deck%path)
      end if
   end subroutine say_stopped

   !> Has the contact given out more energy than it took up? A node that meets a wall and leaves it within a step or two
   !> gains or loses energy of the order of (omega dt)^2/4 of its own.
   pure logical function energy_from_contact(state)
      type(state_t), intent(in) :: state
      !> Share of the energy brought in that is worth a word
      real(wp), parameter :: noticeable = 0.01_wp

      associate (energy => state%energy)
         energy_from_contact = energy%contact < -noticeable*(abs(energy%initial) + abs(energy%external))
      end associate
   end function energy_from_contact

   !> The command line as typed.
   function command_text() result(text)
      character(len=:), allocatable :: text
      integer :: length

      call get_command(length=length)
      allocate (character(len=length) :: text)
      if (length > 0) call get_command(command=text)
   end function command_text

end module story_m
