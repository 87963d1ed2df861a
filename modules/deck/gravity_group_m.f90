!> The group &gravity.
module gravity_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_size
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_number, a_switch, namelist_text, require_clean_read, check_size
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   public :: read_gravity, write_gravity

   !> Acceleration [m/s2] beyond which a number was mistyped (a centrifuge reaches a few hundred g)
   real(wp), parameter :: strongest = 1.0e4_wp

   !> &gravity
   type, public :: gravity_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Acceleration in x [m/s2]
      real(wp) :: gx = 0.0_wp
      !> Acceleration in y [m/s2]
      real(wp) :: gy = 0.0_wp
      !> Does the weight grow over the first stage, or act in full from the start?
      logical :: ramped = .true.
   end type gravity_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('gx', a_number), &
                                  variable_t('gy', a_number), &
                                  variable_t('ramped', a_switch)]

contains

   !> Read and check the group.
   subroutine read_gravity(slice, gravity, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(gravity_t), intent(out) :: gravity
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ gravity

      gravity%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_gravity(slice, gravity, errors)
   end subroutine read_gravity

   !> Ranges and choices.
   subroutine check_gravity(slice, gravity, errors)
      type(group_slice_t), intent(in) :: slice
      type(gravity_t), intent(in) :: gravity
      type(error_list_t), intent(inout) :: errors

      call check_size(errors, slice, 'gx', gravity%gx, least_size, strongest)
      call check_size(errors, slice, 'gy', gravity%gy, least_size, strongest)
   end subroutine check_gravity

   !> Write the effective group, every variable.
   subroutine write_gravity(gravity, unit)
      type(gravity_t), intent(in) :: gravity
      integer, intent(in) :: unit

      call begin_group(unit, 'gravity')
      call put(unit, 'gx', gravity%gx)
      call put(unit, 'gy', gravity%gy)
      call put(unit, 'ramped', gravity%ramped)
      call end_group(unit)
   end subroutine write_gravity

end module gravity_group_m
