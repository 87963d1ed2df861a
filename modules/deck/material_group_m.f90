!> The group &material: the rock of one physical surface of the mesh.
module material_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use bounds_m, only: lightest, heaviest, softest, stiffest, least_factor, most_factor
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, name_length, namelist_text, require_clean_read, &
                              check_range, check_given
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   public :: read_material, write_material

   !> &material
   type, public :: material_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical surface of the mesh
      character(len=name_length) :: group = ''
      !> Density [kg/m3]
      real(wp) :: density = unset
      !> Young's modulus [Pa]
      real(wp) :: young = unset
      !> Poisson's ratio [-]
      real(wp) :: poisson = unset
      !> Penalty of contact over Young's modulus [-]
      real(wp) :: penalty_factor = 20.0_wp
   end type material_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('group', a_name), &
                                  variable_t('density', a_number), &
                                  variable_t('young', a_number), &
                                  variable_t('poisson', a_number), &
                                  variable_t('penalty_factor', a_number)]

contains

   !> Read and check the group.
   subroutine read_material(slice, material, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(material_t), intent(out) :: material
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ material

      material%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_material(slice, material, errors)
   end subroutine read_material

   !> Ranges and choices.
   subroutine check_material(slice, material, errors)
      type(group_slice_t), intent(in) :: slice
      type(material_t), intent(in) :: material
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', material%group, 'a physical surface of the mesh')
      call check_range(errors, slice, 'density', material%density, least=lightest, most=heaviest, required=.true.)
      call check_range(errors, slice, 'young', material%young, least=softest, most=stiffest, required=.true.)
      call check_range(errors, slice, 'poisson', material%poisson, above=-1.0_wp, below=0.5_wp, required=.true.)
      call check_range(errors, slice, 'penalty_factor', material%penalty_factor, least=least_factor, most=most_factor)
   end subroutine check_material

   !> Write the effective group, every variable.
   subroutine write_material(material, unit)
      type(material_t), intent(in) :: material
      integer, intent(in) :: unit

      call begin_group(unit, 'material')
      call put(unit, 'group', material%group)
      call put(unit, 'density', material%density)
      call put(unit, 'young', material%young)
      call put(unit, 'poisson', material%poisson)
      call put(unit, 'penalty_factor', material%penalty_factor)
      call end_group(unit)
   end subroutine write_material

end module material_group_m
