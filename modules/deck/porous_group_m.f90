!> The group &porous: rock of one physical surface that conducts. Rock without one does not, and has no pressure.
module porous_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, check_range, check_given
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_porous, write_porous

   !> Beyond these the unit must be wrong: permeability [m2] (gravel has 1e-9; a darcy is 1e-12), storage [1/Pa] (clay has 1e-6)
   real(wp), parameter :: most_permeable = 1.0e-3_wp, softest = 1.0_wp

   !> &porous
   type, public :: porous_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical surface of the mesh
      character(len=name_length) :: group = ''
      !> Permeability [m2]; 0: the rock does not conduct
      real(wp) :: permeability = unset
      !> Specific storage: fluid that a cubic metre takes up for each pascal [1/Pa]; it counts in transient flow
      real(wp) :: storage = 0.0_wp
      !> Biot coefficient: the part of the pressure that acts in the rock [-]; it counts in two-way coupling
      real(wp) :: biot = 1.0_wp
   end type porous_t

contains

   !> Read and check the group.
   subroutine read_porous(slice, porous, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(porous_t), intent(out) :: porous
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      porous%line = slice%line
      call variables%read(slice)
      call name_variables(variables, porous)
      call variables%end_reading(errors)
      call check_given(errors, slice, 'group', porous%group, 'a physical surface of the mesh')
      call check_range(errors, slice, 'permeability', porous%permeability, least=0.0_wp, most=most_permeable, required=.true.)
      call check_range(errors, slice, 'storage', porous%storage, least=0.0_wp, most=softest)
      call check_range(errors, slice, 'biot', porous%biot, least=0.0_wp, most=1.0_wp)
   end subroutine read_porous

   !> The variables, for reading and writing.
   subroutine name_variables(variables, porous)
      type(group_variables_t), intent(inout) :: variables
      type(porous_t), intent(inout) :: porous

      call variables%keep('group', porous%group)
      call variables%keep('permeability', porous%permeability)
      call variables%keep('storage', porous%storage)
      call variables%keep('biot', porous%biot)
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_porous(porous, unit)
      type(porous_t), intent(in) :: porous
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(porous_t) :: effective

      effective = porous
      call variables%write(unit, 'porous')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_porous

end module porous_group_m
