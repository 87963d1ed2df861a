!> One cycle of a run with its solver. Solvers take the model as it is; where rock breaks they return, the model is brought up to
!> that (recut_m), and they go on.
module cycle_m
   use stopwatch_m, only: now_doing, work_cracks, work_other
   use cracks_m, only: breaks_t
   use errors_m, only: error_list_t
   use interrupt_m, only: stop_wanted
   use log_m, only: log_t, progress_t
   use model_m, only: model_t
   use state_m, only: state_t
   use recut_m, only: recut
   use solver_choice_m, only: solver_explicit, solver_implicit, solver_relaxation
   use explicit_m, only: explicit_cycle, cycle_report_t, march_t
   use implicit_m, only: implicit_cycle, enter_stage, settle, implicit_solver_t
   use relaxation_m, only: relaxation_cycle, relaxation_place_t
   use fluid_coupling_m, only: fluid_coupling_t, is_two_way, hold_pressure, start_cycle, end_pass, go_on_broken, halve_step
   implicit none
   private

   public :: run_cycle

   !> What the solvers remember from one cycle to the next
   type, public :: solvers_t
      type(march_t) :: march
      type(relaxation_place_t) :: place
      type(implicit_solver_t) :: implicit
      type(fluid_coupling_t) :: fluid
   end type solvers_t

contains

   !> One cycle of a stage. On failure errors says when, where and what.
   subroutine run_cycle(solvers, model, stage, cycle, log, progress, state, report, errors)
      type(solvers_t), intent(inout) :: solvers
      type(model_t), intent(inout) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(progress_t), intent(inout) :: progress
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(out) :: report
      type(error_list_t), intent(inout) :: errors

      if (is_two_way(model%deck)) then
         call coupled_cycle()
         return
      end if
      do while (.not. errors%any())
         select case (model%solver)
         case (solver_explicit)
            call explicit_cycle(model, stage, cycle, log, progress, solvers%march, state, report, errors)
         case (solver_implicit)
            call implicit_cycle(solvers%implicit, model, stage, cycle, log, progress, state, report, errors)
         case (solver_relaxation)
            call relaxation_cycle(model, stage, cycle, log, progress, solvers%place, state, report, errors)
         end select
         if (errors%any() .or. report%interrupted) return
         if (.not. report%breaks%any()) return
         call now_doing(work_cracks)
         call recut(model, report%breaks, report%level, state)
         call now_doing(work_other)
      end do

   contains

      !> One cycle with fluid that pushes back: each of its steps is done again until pressure and apertures agree. Only then may
      !> rock break, and they have to agree anew.
      subroutine coupled_cycle()
         type(breaks_t) :: breaks
         type(error_list_t) :: failed

         associate (fluid => solvers%fluid, solver => solvers%implicit)
            solver%cracks_wait = .true.
            call hold_pressure(fluid, model, state)
            model%loads%fluid = fluid%push
            call enter_stage(solver, model, stage, cycle, log, state, errors)
            if (.not. errors%any()) call start_cycle(fluid, model, stage, cycle, state, errors)
            do while (.not. (errors%any() .or. fluid%over))
               model%loads%fluid = fluid%push
               if (fluid%settles) then
                  call settle(solver, model, stage, cycle, state, report, errors)
               else
                  call implicit_cycle(solver, model, stage, cycle, log, progress, state, report, failed, fluid%part)
                  if (failed%any() .and. fluid%may_be_halved(model)) then
                     failed = error_list_t()
                     call halve_step(fluid, model, stage, cycle, state, errors)
                     report%interrupted = stop_wanted()
                     if (report%interrupted) return
                     cycle
                  end if
                  call errors%append(failed)
               end if
               if (errors%any() .or. report%interrupted) return
               call end_pass(fluid, solver, model, stage, cycle, state, breaks, errors)
               if (.not. fluid%over) report%interrupted = stop_wanted()
               if (report%interrupted) return
               if (errors%any() .or. .not. breaks%any()) cycle
               call recut(model, breaks, solver%level(), state)
               call go_on_broken(fluid, model, cycle, state)
            end do
         end associate
      end subroutine coupled_cycle

   end subroutine run_cycle

end module cycle_m
