!> JCM-FEMDEM: fractured rock in two dimensions, with its joints as they really behave.
program femdem
   use, intrinsic :: iso_fortran_env, only: error_unit
   use errors_m, only: error_list_t, status_ok, status_failed, status_bad_input, status_stopped
   use exit_m, only: exit_with
   use kinds_m, only: wp, i8
   use files_m, only: make_directory
   use interrupt_m, only: catch_signals, stop_wanted, write_beyond_limits
   use threads_m, only: use_threads
   use stopwatch_m, only: now_doing, work_input, work_output, work_other
   use lock_m, only: lock_t
   use log_m, only: log_t, progress_t
   use version_m, only: program_version, program_commit
   use command_line_m, only: command_t, read_command_line, help_text
   use deck_m, only: deck_t, read_deck, deck_path
   use deck_check_m, only: check_deck, find_warnings
   use mesh_m, only: mesh_t
   use gmsh_m, only: read_gmsh
   use mesh_check_m, only: check_mesh
   use ordering_m, only: order_mesh
   use group_check_m, only: check_groups
   use flow_check_m, only: check_flow, check_flow_groups, is_flow_alone
   use inflow_check_m, only: check_inflows
   use flow_alone_m, only: check_flow_mesh, run_flow_alone
   use flow_after_m, only: check_flow_after, run_flow_after
   use build_m, only: build_model
   use model_m, only: model_t, begin_stage
   use solver_choice_m, only: solver_explicit
   use state_m, only: state_t
   use cracks_m, only: breaks_t
   use recut_m, only: recut
   use excavation_m, only: find_excavation, say_excavation, end_relief
   use held_m, only: hold_absorbing_sides
   use corners_m, only: note_depths
   use plan_m, only: say_plan
   use stable_step_m, only: check_given_step
   use effort_m, only: check_effort
   use explicit_m, only: cycle_report_t, start_account
   use cycle_m, only: run_cycle, solvers_t
   use results_directory_m, only: results_directory, check_directory
   use results_m, only: results_t
   use checkpoint_m, only: checkpoint_t
   use run_checkpoint_m, only: place_t, open_run, load_run
   use watchdog_m, only: watchdog_t, patience
   use story_m, only: say_in_situ, say_start, say_stage, say_end, say_stopped, command_text
   implicit none
   type(command_t) :: command
   type(deck_t) :: deck
   type(mesh_t) :: mesh
   type(model_t) :: model
   type(state_t) :: state
   type(solvers_t) :: solvers
   type(results_t) :: results
   type(place_t) :: place, done
   type(cycle_report_t) :: report
   type(log_t) :: log
   type(progress_t) :: progress
   type(error_list_t) :: errors, deck_warnings, warnings, notes
   type(lock_t) :: lock
   type(watchdog_t) :: watchdog
   character(len=:), allocatable :: directory, taken_over
   integer :: stage, cycle, status
   integer(i8) :: first_step

   call now_doing(work_input)
   call read_command_line(command, errors)
   if (errors%any()) call stop_with(status_bad_input)
   if (command%help .or. command%version) then
      if (command%help) print '(a)', help_text(program_version)
      if (.not. command%help) print '(a)', 'femdem '//program_version//' ('//program_commit//')'
      call exit_with(status_ok)
   end if
   log%quiet = command%quiet
   call write_beyond_limits()

   ! Deck and mesh, checked together before anything else is done
   call read_deck(command%deck, deck, errors)
   call check_deck(deck, errors)
   call check_flow(deck, errors)
   if (errors%any()) call stop_with(status_bad_input)
   call find_warnings(deck, deck_warnings)
   call deck_warnings%write(error_unit, 'warning: ')
   call read_gmsh(deck_path(deck, deck%run%mesh), mesh, errors)
   if (errors%any()) call stop_with(status_bad_input)
   if (command%flow /= '') call check_flow_after(command%flow, deck, errors)
   if (is_flow_alone(deck)) call flow_alone()
   call check_mesh(mesh, errors)
   call check_flow_groups(deck, mesh, errors)
   call check_groups(deck, mesh, errors, warnings)
   if (.not. errors%any()) call check_inflows(deck, mesh, errors)
   call warnings%write(error_unit, 'warning: ')
   if (errors%any()) call stop_with(status_bad_input)

   call use_threads(deck%run%threads)
   call open_directory()
   call say_start(deck, log)
   call order_mesh(mesh)
   call build_model(deck, mesh, log, model, state, errors)
   if (errors%any()) call stop_with(status_bad_input)
   if (command%flow /= '') call flow_after()
   call say_plan(model, mesh, log)
   call check_effort(model, state, log, errors)
   if (errors%any()) call stop_with(status_bad_input)
   if (command%check) then
      call begin_stage(model, 1, state)
      call check_given_step(model, 1, state, errors)
      if (errors%any()) call stop_with(status_bad_input)
      call log%say('the input is good')
      call exit_with(status_ok)
   end if
   if (command%restart /= '') call take_checkpoint()
   if (errors%any()) call stop_with(status_bad_input)
   call catch_signals()
   call results%open(directory, model, state, command_text(), command%restart /= '', done, notes, errors)
   do status = 1, notes%count()
      call log%warn(notes%text(status))
   end do
   if (errors%any()) call stop_with(status_bad_input)

   ! The run: stages, each of equal load increments
   call progress%start()
   call now_doing(work_other)
   first_step = state%step
   if (command%restart == '') call start_account(model, state)
   call watchdog%start(state%energy, sum(model%solid%area*maxval(deck%material%young)), state%step, &
                       merge(patience, 0_i8, model%solver == solver_explicit), &
                       model%solver == solver_explicit .and. .not. any(deck%joint%coupling == 'coupled') &
                       .and. deck%in_situ%line == 0)
   do stage = 1, size(deck%stage)
      call enter_stage()
      if (stage < done%stage .or. (stage == done%stage .and. done%cycle >= deck%stage(stage)%cycles)) cycle
      call check_given_step(model, stage, state, errors)
      ! Before the first step it is the input that is wrong; later the joints have become too stiff for it
      if (errors%any()) call stop_with(merge(status_bad_input, status_failed, state%step == 0))
      do cycle = 1, deck%stage(stage)%cycles
         if (stage == done%stage .and. cycle <= done%cycle) cycle
         call run_cycle(solvers, model, stage, cycle, log, progress, state, report, errors)
         if (.not. (errors%any() .or. report%interrupted)) &
            call watchdog%look(state%energy, state%step, state%time, deck%stage(stage)%name, cycle, log, errors)
         place = place_t(stage, cycle)
         if (errors%any() .or. report%interrupted) call results%record_last_cycle(model, errors)
         if (allocated(report%moved)) call results%record_failure(model, state, place, report%unbalanced, report%moved, errors)
         if (errors%any()) call stop_with(status_failed)
         if (report%interrupted) call stop_on_signal()
         call now_doing(work_output)
         call results%record(model, state, solvers%implicit, place, report%unbalanced, cycle == deck%stage(stage)%cycles, &
                             stage == size(deck%stage) .and. cycle == deck%stage(stage)%cycles, errors)
         if (errors%any()) call stop_with(status_failed)
         call now_doing(work_other)
         done = place
         if (stop_wanted()) then
            call results%record_last_cycle(model, errors)
            if (errors%any()) call stop_with(status_failed)
            call stop_on_signal()
         end if
      end do
      call say_stage(model, stage, state, report, log)
   end do
   call solvers%implicit%close(log)
   call results%close()
   call say_end(directory, model, state, progress, first_step, log)
   call watchdog%say_end(log, errors)
   if (errors%any()) call stop_with(status_failed)
   call log%close()
   call lock%release()

contains

   !> Find the results directory and make it, unless the input is checked only.
   subroutine open_directory()

      directory = results_directory(deck, command%output)
      if (command%flow /= '' .and. command%output == '') directory = command%flow//'/flow'
      call check_directory(directory, errors)
      if (errors%any()) call stop_with(status_bad_input)
      if (command%check) return
      call make_directory(directory, status)
      if (status /= 0) call errors%add('the results directory '//directory//' cannot be made or written to')
      if (status == 0) call lock%take(directory, taken_over, errors)
      if (errors%any()) call stop_with(status_bad_input)
      call log%open(directory//'/run.log', command%restart /= '', status)
      if (taken_over /= '') call log%say(taken_over)
   end subroutine open_directory

   !> Begin a stage with its loads, unless the run goes on from a checkpoint in it or beyond it; take out what it takes out.
   subroutine enter_stage()
      type(breaks_t) :: breaks

      if (stage > done%stage) call end_relief(state)
      if (stage > done%stage) call note_depths(model%corners, state%u, state%corners)
      call begin_stage(model, stage, state)
      if (stage > done%stage .and. any(deck%boundary%absorbing)) then
         call hold_absorbing_sides(model, stage, state)
         call begin_stage(model, stage, state)
      end if
      if (stage == 1 .and. done%stage == 0 .and. deck%in_situ%line > 0) call say_in_situ(model, state, log)
      if (stage > done%stage) call find_excavation(model, stage, breaks)
      if (.not. breaks%any()) return
      call say_excavation(model, stage, breaks, log)
      call recut(model, breaks, 0.0_wp, state)
   end subroutine enter_stage

   !> Go on from a checkpoint: cut what had broken, then take the state.
   subroutine take_checkpoint()
      type(checkpoint_t) :: file
      type(breaks_t) :: breaks

      call open_run(file, command%restart, command%branch, model, breaks, errors)
      if (errors%any()) return
      if (breaks%any() .or. allocated(breaks%bond)) call recut(model, breaks, 0.0_wp, state)
      call load_run(file, model, state, solvers%implicit%kept, done, errors)
   end subroutine take_checkpoint

   !> A deck of flow without stages: nothing moves. Ends the program.
   subroutine flow_alone()

      call check_flow_mesh(deck, mesh, errors)
      if (errors%any()) call stop_with(status_bad_input)
      call open_directory()
      call say_start(deck, log)
      if (command%check) call log%say('the input is good')
      if (command%check) call exit_with(status_ok)
      call run_flow_alone(deck, mesh, directory, log, errors)
      if (errors%any()) call stop_with(status_failed)
      call log%say('done      results in '//directory)
      call log%close()
      call lock%release()
      call exit_with(status_ok)
   end subroutine flow_alone

   !> Flow through the apertures of a finished run. Ends the program.
   subroutine flow_after()

      call run_flow_after(command%flow, model, directory, log, errors)
      if (errors%any()) call stop_with(status_failed)
      call log%say('done      results in '//directory)
      call log%close()
      call lock%release()
      call exit_with(status_ok)
   end subroutine flow_after

   !> Say every error and end with the given status; what has been written stays.
   subroutine stop_with(status)
      integer, intent(in) :: status

      call errors%write(error_unit)
      if (log%file /= 0) call errors%write(log%file)
      call results%close()
      call log%close()
      call lock%release()
      call exit_with(status)
   end subroutine stop_with

   !> A signal has asked the run to stop, and all that was completed is written: say how to go on.
   subroutine stop_on_signal()

      call say_stopped(directory//'/checkpoint.h5', model, done%stage, done%cycle, log)
      call stop_with(status_stopped)
   end subroutine stop_on_signal

end program femdem
