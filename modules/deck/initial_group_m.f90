!> The group &initial: velocity at the start of a physical group of the mesh.
module initial_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_size, fastest
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, check_given, check_size
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_initial, write_initial

   !> &initial
   type, public :: initial_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical point, curve or surface of the mesh
      character(len=name_length) :: group = ''
      !> Velocity in x [m/s]
      real(wp) :: vx = 0.0_wp
      !> Velocity in y [m/s]
      real(wp) :: vy = 0.0_wp
   end type initial_t

contains

   !> Read and check the group.
   subroutine read_initial(slice, initial, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(initial_t), intent(out) :: initial
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      initial%line = slice%line
      call variables%read(slice)
      call name_variables(variables, initial)
      call variables%end_reading(errors)
      call check_initial(slice, initial, errors)
   end subroutine read_initial

   !> The variables, for reading and writing.
   subroutine name_variables(variables, initial)
      type(group_variables_t), intent(inout) :: variables
      type(initial_t), intent(inout) :: initial

      call variables%keep('group', initial%group)
      call variables%keep('vx', initial%vx)
      call variables%keep('vy', initial%vy)
   end subroutine name_variables

   !> Ranges and choices.
   subroutine check_initial(slice, initial, errors)
      type(group_slice_t), intent(in) :: slice
      type(initial_t), intent(in) :: initial
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', initial%group, 'a physical point, curve or surface of the mesh')
      call check_size(errors, slice, 'vx', initial%vx, least_size, fastest)
      call check_size(errors, slice, 'vy', initial%vy, least_size, fastest)
   end subroutine check_initial

   !> Write the effective group, every variable.
   subroutine write_initial(initial, unit)
      type(initial_t), intent(in) :: initial
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(initial_t) :: effective

      effective = initial
      call variables%write(unit, 'initial')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_initial

end module initial_group_m
