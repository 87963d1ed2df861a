!> One cycle of a run with its solver. Solvers take the model as it is; where rock breaks they return, the model is brought up to
!> that (recut_m), and they go on.
module cycle_m
   use errors_m, only: error_list_t
   use log_m, only: log_t, progress_t
   use model_m, only: model_t
   use state_m, only: state_t
   use recut_m, only: recut
   use solver_choice_m, only: solver_explicit, solver_implicit, solver_relaxation
   use explicit_m, only: explicit_cycle, cycle_report_t, march_t
   use implicit_m, only: implicit_cycle, implicit_solver_t
   use relaxation_m, only: relaxation_cycle, relaxation_place_t
   use fluid_coupling_m, only: fluid_coupling_t, is_two_way, start_passes, end_pass
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

   !> One cycle of a stage; with fluid that pushes back, done again until pressure and apertures agree. On failure errors says
   !> when, where and what.
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
      logical :: two_way, agreed

      two_way = is_two_way(model%deck)
      if (two_way) call start_passes(solvers%fluid, model, stage, cycle, state, errors)
      do while (.not. errors%any())
         if (two_way) then
            model%loads = solvers%fluid%loads
            report = cycle_report_t()
         end if
         select case (model%solver)
         case (solver_explicit)
            call explicit_cycle(model, stage, cycle, log, progress, solvers%march, state, report, errors)
         case (solver_implicit)
            call implicit_cycle(solvers%implicit, model, stage, cycle, log, progress, state, report, errors)
         case (solver_relaxation)
            call relaxation_cycle(model, stage, cycle, log, progress, solvers%place, state, report, errors)
         end select
         if (errors%any() .or. report%interrupted) return
         if (report%breaks%any()) then
            call recut(model, report%breaks, report%level, state)
            cycle
         end if
         if (.not. two_way) return
         call end_pass(solvers%fluid, model, stage, cycle, state, agreed, errors)
         if (agreed) return
      end do
   end subroutine run_cycle

end module cycle_m
