!> The group &material: the rock of one physical surface of the mesh.
module material_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use bounds_m, only: lightest, heaviest, softest, stiffest, least_factor, most_factor
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, check_range, check_given
   use group_variables_m, only: group_variables_t
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

contains

   !> Read and check the group.
   subroutine read_material(slice, material, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(material_t), intent(out) :: material
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      material%line = slice%line
      call variables%read(slice)
      call name_variables(variables, material)
      call variables%end_reading(errors)
      call check_material(slice, material, errors)
   end subroutine read_material

   !> The variables, for reading and writing.
   subroutine name_variables(variables, material)
      type(group_variables_t), intent(inout) :: variables
      type(material_t), intent(inout) :: material

      call variables%keep('group', material%group)
      call variables%keep('density', material%density)
      call variables%keep('young', material%young)
      call variables%keep('poisson', material%poisson)
      call variables%keep('penalty_factor', material%penalty_factor)
   end subroutine name_variables

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
      type(group_variables_t) :: variables
      type(material_t) :: effective

      effective = material
      call variables%write(unit, 'material')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_material

end module material_group_m
