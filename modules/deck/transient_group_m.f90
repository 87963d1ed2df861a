!> The group &transient: flow that changes with time, from an initial pressure on. Without it flow is steady.
module transient_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_number, an_option, option_length, namelist_text, require_clean_read, check_range, &
                              check_choice
   use deck_write_m, only: begin_group, put, end_group
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

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('duration', a_number), &
                                  variable_t('step', a_number), &
                                  variable_t('output_interval', a_number), &
                                  variable_t('steps', an_option), &
                                  variable_t('tolerance', a_number), &
                                  variable_t('initial_pressure', a_number)]
   character(len=*), parameter :: choices(*) = ['adaptive', 'fixed   ']

contains

   !> Read and check the group.
   subroutine read_transient(slice, transient, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(transient_t), intent(out) :: transient
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ transient

      transient%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_range(errors, slice, 'duration', transient%duration, above=0.0_wp, required=.true.)
      call check_range(errors, slice, 'step', transient%step, above=0.0_wp, required=.true.)
      call check_range(errors, slice, 'output_interval', transient%output_interval, above=0.0_wp)
      call check_choice(errors, slice, 'steps', transient%steps, choices)
      call check_range(errors, slice, 'tolerance', transient%tolerance, above=0.0_wp, below=1.0_wp)
   end subroutine read_transient

   !> Write the effective group, every variable.
   subroutine write_transient(transient, unit)
      type(transient_t), intent(in) :: transient
      integer, intent(in) :: unit

      call begin_group(unit, 'transient')
      call put(unit, 'duration', transient%duration)
      call put(unit, 'step', transient%step)
      call put(unit, 'output_interval', transient%output_interval, 'one output, at the end')
      call put(unit, 'steps', transient%steps)
      call put(unit, 'tolerance', transient%tolerance)
      call put(unit, 'initial_pressure', transient%initial_pressure)
      call end_group(unit)
   end subroutine write_transient

end module transient_group_m
