!> The group &gravity.
module gravity_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_size
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: check_size
   use group_variables_m, only: group_variables_t
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

contains

   !> Read and check the group.
   subroutine read_gravity(slice, gravity, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(gravity_t), intent(out) :: gravity
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      gravity%line = slice%line
      call variables%read(slice)
      call name_variables(variables, gravity)
      call variables%end_reading(errors)
      call check_gravity(slice, gravity, errors)
   end subroutine read_gravity

   !> The variables, for reading and writing.
   subroutine name_variables(variables, gravity)
      type(group_variables_t), intent(inout) :: variables
      type(gravity_t), intent(inout) :: gravity

      call variables%keep('gx', gravity%gx)
      call variables%keep('gy', gravity%gy)
      call variables%keep('ramped', gravity%ramped)
   end subroutine name_variables

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
      type(group_variables_t) :: variables
      type(gravity_t) :: effective

      effective = gravity
      call variables%write(unit, 'gravity')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_gravity

end module gravity_group_m
