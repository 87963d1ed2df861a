!> The group &pore_pressure: fluid pressure in rock and fractures (Biot-type coupling, section 4.2 of the paper).
module pore_pressure_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, check_given, check_needed, check_range
   use group_variables_m, only: group_variables_t
   use boundary_group_m, only: every_stage
   implicit none
   private

   public :: read_pore_pressure, write_pore_pressure

   !> Group that stands for all rock and all fractures
   character(len=*), parameter, public :: every_place = 'all'
   !> Pressure [Pa] beyond which the unit must be wrong
   real(wp), parameter :: highest = 1.0e10_wp

   !> &pore_pressure
   type, public :: pore_pressure_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical surface (its rock), physical curve (its fractures), or 'all': all rock and all fractures
      character(len=name_length) :: group = every_place
      !> Stage at whose end the pressure is reached, or 'all'
      character(len=name_length) :: stage = every_stage
      !> Pressure of the fluid [Pa]
      real(wp) :: pressure = unset
      !> Biot coefficient: the part of the pressure that acts in the rock [-]
      real(wp) :: biot = 1.0_wp
   end type pore_pressure_t

contains

   !> Read and check the group.
   subroutine read_pore_pressure(slice, pore_pressure, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(pore_pressure_t), intent(out) :: pore_pressure
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      pore_pressure%line = slice%line
      call variables%read(slice)
      call name_variables(variables, pore_pressure)
      call variables%end_reading(errors)
      call check_pore_pressure(slice, pore_pressure, errors)
   end subroutine read_pore_pressure

   !> The variables, for reading and writing.
   subroutine name_variables(variables, pore_pressure)
      type(group_variables_t), intent(inout) :: variables
      type(pore_pressure_t), intent(inout) :: pore_pressure

      call variables%keep('group', pore_pressure%group)
      call variables%keep('stage', pore_pressure%stage)
      call variables%keep('pressure', pore_pressure%pressure)
      call variables%keep('biot', pore_pressure%biot)
   end subroutine name_variables

   !> Ranges; combinations of groups are checked with the whole deck.
   subroutine check_pore_pressure(slice, pore_pressure, errors)
      type(group_slice_t), intent(in) :: slice
      type(pore_pressure_t), intent(in) :: pore_pressure
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', pore_pressure%group, "a physical surface or curve of the mesh, or 'all'")
      call check_given(errors, slice, 'stage', pore_pressure%stage, "the name of a stage, or 'all'")
      call check_needed(errors, slice, 'pressure', pore_pressure%pressure, 'the pressure of the fluid in Pa')
      if (is_set(pore_pressure%pressure)) &
         call check_range(errors, slice, 'pressure', pore_pressure%pressure, least=0.0_wp, most=highest)
      call check_range(errors, slice, 'biot', pore_pressure%biot, least=0.0_wp, most=1.0_wp)
   end subroutine check_pore_pressure

   !> Write the effective group, every variable.
   subroutine write_pore_pressure(pore_pressure, unit)
      type(pore_pressure_t), intent(in) :: pore_pressure
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(pore_pressure_t) :: effective

      effective = pore_pressure
      call variables%write(unit, 'pore_pressure')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_pore_pressure

end module pore_pressure_group_m
