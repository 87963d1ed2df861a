!> The group &porous: rock of one physical surface that conducts. Rock without one does not, and has no pressure.
module porous_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, name_length, namelist_text, require_clean_read, check_range, check_given
   use deck_write_m, only: begin_group, put, end_group
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

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('group', a_name), &
                                  variable_t('permeability', a_number), &
                                  variable_t('storage', a_number), &
                                  variable_t('biot', a_number)]

contains

   !> Read and check the group.
   subroutine read_porous(slice, porous, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(porous_t), intent(out) :: porous
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ porous

      porous%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_given(errors, slice, 'group', porous%group, 'a physical surface of the mesh')
      call check_range(errors, slice, 'permeability', porous%permeability, least=0.0_wp, most=most_permeable, required=.true.)
      call check_range(errors, slice, 'storage', porous%storage, least=0.0_wp, most=softest)
      call check_range(errors, slice, 'biot', porous%biot, least=0.0_wp, most=1.0_wp)
   end subroutine read_porous

   !> Write the effective group, every variable.
   subroutine write_porous(porous, unit)
      type(porous_t), intent(in) :: porous
      integer, intent(in) :: unit

      call begin_group(unit, 'porous')
      call put(unit, 'group', porous%group)
      call put(unit, 'permeability', porous%permeability)
      call put(unit, 'storage', porous%storage)
      call put(unit, 'biot', porous%biot)
      call end_group(unit)
   end subroutine write_porous

end module porous_group_m
