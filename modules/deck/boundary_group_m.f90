!> The group &boundary: a velocity, traction, pressure or far-field stress on a physical group of the mesh.
module boundary_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, name_length, namelist_text, require_clean_read, &
                              check_given
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   public :: read_boundary, write_boundary

   !> &boundary
   type, public :: boundary_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical point, curve or surface of the mesh
      character(len=name_length) :: group = ''
      !> Stage in which it acts
      character(len=name_length) :: stage = 'all'
      !> Prescribed velocity in x [m/s]
      real(wp) :: vx = unset
      !> Prescribed velocity in y [m/s]
      real(wp) :: vy = unset
      !> Traction in x [Pa]
      real(wp) :: tx = unset
      !> Traction in y [Pa]
      real(wp) :: ty = unset
      !> Pressure on the edges, compression positive [Pa]
      real(wp) :: pressure = unset
      !> Far-field stress xx, compression positive [Pa]
      real(wp) :: sxx = unset
      !> Far-field stress yy, compression positive [Pa]
      real(wp) :: syy = unset
      !> Far-field stress xy; 0 when only sxx and syy are given [Pa]
      real(wp) :: sxy = unset
   end type boundary_t

   type(variable_t), parameter :: variables(*) = [ &
      variable_t('group', a_name), &
      variable_t('stage', a_name), &
      variable_t('vx', a_number), &
      variable_t('vy', a_number), &
      variable_t('tx', a_number), &
      variable_t('ty', a_number), &
      variable_t('pressure', a_number), &
      variable_t('sxx', a_number), &
      variable_t('syy', a_number), &
      variable_t('sxy', a_number)]

contains

   !> Read and check the group.
   subroutine read_boundary(slice, boundary, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(boundary_t), intent(out) :: boundary
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ boundary

      boundary%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      if (is_set(boundary%sxx) .and. is_set(boundary%syy) .and. .not. is_set(boundary%sxy)) boundary%sxy = 0.0_wp
      call check_boundary(slice, boundary, errors)
   end subroutine read_boundary

   !> Ranges and choices; combinations of variables and of groups are checked with the whole deck.
   subroutine check_boundary(slice, boundary, errors)
      type(group_slice_t), intent(in) :: slice
      type(boundary_t), intent(in) :: boundary
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', boundary%group, 'a physical point, curve or surface of the mesh')
      call check_given(errors, slice, 'stage', boundary%stage, 'the name of a stage, or ''all''')
   end subroutine check_boundary

   !> Write the effective group, every variable.
   subroutine write_boundary(boundary, unit)
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: unit

      call begin_group(unit, 'boundary')
      call put(unit, 'group', boundary%group)
      call put(unit, 'stage', boundary%stage)
      call put(unit, 'vx', boundary%vx, 'free in x')
      call put(unit, 'vy', boundary%vy, 'free in y')
      call put(unit, 'tx', boundary%tx)
      call put(unit, 'ty', boundary%ty)
      call put(unit, 'pressure', boundary%pressure)
      call put(unit, 'sxx', boundary%sxx)
      call put(unit, 'syy', boundary%syy)
      call put(unit, 'sxy', boundary%sxy)
      call end_group(unit)
   end subroutine write_boundary

end module boundary_group_m
