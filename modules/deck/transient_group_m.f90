!> The group &transient: flow that changes with time, alone or coupled two-way. Without it flow is steady.
module transient_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: option_length, check_range, check_choice
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_transient, write_transient

   !> &transient
   type, public :: transient_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Time that is computed, first step, time between two outputs [s]; one output at the end when that is not given
      real(wp) :: duration = unset, step = unset, output_interval = unset
      !> Steps all of one length, or as the error of each allows
      character(len=option_length) :: steps = 'adaptive'
      !> Error of a step over the largest difference of pressure [-]
      real(wp) :: tolerance = 1.0e-4_wp
      !> Pressure of the fluid before anything flows [Pa]
      real(wp) :: initial_pressure = 0.0_wp
   end type transient_t

   character(len=*), parameter :: choices(*) = ['adaptive', 'fixed   ']

contains

   !> Read and check the group.
   subroutine read_transient(slice, transient, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(transient_t), intent(out) :: transient
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      transient%line = slice%line
      call variables%read(slice)
      call name_variables(variables, transient)
      call variables%end_reading(errors)
      call check_range(errors, slice, 'duration', transient%duration, above=0.0_wp)
      call check_range(errors, slice, 'step', transient%step, above=0.0_wp, required=.true.)
      call check_range(errors, slice, 'output_interval', transient%output_interval, above=0.0_wp)
      call check_choice(errors, slice, 'steps', transient%steps, choices)
      call check_range(errors, slice, 'tolerance', transient%tolerance, above=0.0_wp, below=1.0_wp)
   end subroutine read_transient

   !> The variables, for reading and writing.
   subroutine name_variables(variables, transient)
      type(group_variables_t), intent(inout) :: variables
      type(transient_t), intent(inout) :: transient

      call variables%keep('duration', transient%duration, 'as long as the stages')
      call variables%keep('step', transient%step)
      call variables%keep('output_interval', transient%output_interval, 'one output, at the end')
      call variables%keep('steps', transient%steps)
      call variables%keep('tolerance', transient%tolerance)
      call variables%keep('initial_pressure', transient%initial_pressure)
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_transient(transient, unit)
      type(transient_t), intent(in) :: transient
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(transient_t) :: effective

      effective = transient
      call variables%write(unit, 'transient')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_transient

end module transient_group_m
