!> Loads: dead loads, weight, fluid in rock and fractures, and pressure that follows its edge (loads_m).
module load_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_loads
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use model_m, only: model_t, term_t, increment_t
   use state_m, only: state_t
   use loads_m, only: nodal_loads, pressure_stiffness
   use sparse_system_m, only: sparse_system_t, add_block
   implicit none
   private

   type, extends(term_t), public :: load_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_tangent
      procedure, nopass :: keep
   end type load_term_t

contains

   !> Also what is zero: a stage may have left loads.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = allocated(model%loads%fixed)
   end function is_there

   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      call now_doing(work_loads)
      call nodal_loads(model%loads, model%split%x, state%u, state%level, state%load_level, state%load)
   end subroutine add_forces

   !> Of the pressure, which turns and lengthens with its edge.
   subroutine add_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside
      integer :: e

      associate (unused => state)
      end associate
      do e = 1, size(model%loads%pressure_surface)
         call add_block(system, model%loads%pressure_edge(:, e), pressure_stiffness(model%loads, e, increment%level), outside)
      end do
   end subroutine add_tangent

   subroutine keep(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors

      associate (unused => model)
      end associate
      call file%keep('load', state%load, errors)
      call file%keep_if_any('relief', state%relief, errors)
      call file%keep_if_any('held', state%held, errors)
   end subroutine keep

end module load_term_m
