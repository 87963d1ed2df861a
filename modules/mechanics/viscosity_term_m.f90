!> Resistance to motion: viscous forces of the rock, and the drag of pseudo-time, which newton_m adds to the forces of a trial.
module viscosity_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_rock
   use model_m, only: model_t, term_t, increment_t
   use state_m, only: state_t
   use solid_forces_m, only: viscous_forces
   use sparse_system_m, only: sparse_system_t, gather
   implicit none
   private

   type, extends(term_t), public :: viscosity_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_tangent
   end type viscosity_term_t

contains

   !> Always asked: whether there is drag is a matter of the increment.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = size(model%nodes%mass) > 0
   end function is_there

   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      if (.not. model%has_damping) return
      call now_doing(work_rock)
      call viscous_forces(model%solid, state%u, state%v, state%damping)
   end subroutine add_forces

   !> The drag, on the diagonal.
   subroutine add_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside
      real(wp) :: drag(system%unknowns)

      associate (unused => state, also => outside)
      end associate
      if (increment%drag <= 0.0_wp) return
      call gather(system, increment%drag*spread(model%nodes%rock_stiffness, 1, 2), drag)
      where (system%row == system%column) system%value = system%value + drag(system%row)
   end subroutine add_tangent

end module viscosity_term_m
