!> The group &initial: velocity at the start of a physical group of the mesh.
module initial_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_size, fastest
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, name_length, namelist_text, require_clean_read, &
                              check_given, check_size
   use deck_write_m, only: begin_group, put, end_group
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

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('group', a_name), &
                                  variable_t('vx', a_number), &
                                  variable_t('vy', a_number)]

contains

   !> Read and check the group.
   subroutine read_initial(slice, initial, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(initial_t), intent(out) :: initial
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ initial

      initial%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_initial(slice, initial, errors)
   end subroutine read_initial

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

      call begin_group(unit, 'initial')
      call put(unit, 'group', initial%group)
      call put(unit, 'vx', initial%vx)
      call put(unit, 'vy', initial%vy)
      call end_group(unit)
   end subroutine write_initial

end module initial_group_m
