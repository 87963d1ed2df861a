!> The group &fluid: what flows in fractures and rock.
module fluid_group_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: check_range
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_fluid, write_fluid

   !> Beyond these the unit must be wrong: viscosity [Pa s] (bitumen has 1e5), density [kg/m3], compressibility [1/Pa] (gas at 1 Pa)
   real(wp), parameter :: thickest = 1.0e6_wp, heaviest = 25000.0_wp, softest = 1.0_wp

   !> &fluid
   type, public :: fluid_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Dynamic viscosity [Pa s]: water at 20 degrees
      real(wp) :: viscosity = 1.0e-3_wp
      !> Density [kg/m3]; it counts where &gravity acts
      real(wp) :: density = 1000.0_wp
      !> Compressibility [1/Pa]; it counts in transient flow
      real(wp) :: compressibility = 4.5e-10_wp
   end type fluid_t

contains

   !> Read and check the group.
   subroutine read_fluid(slice, fluid, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(fluid_t), intent(out) :: fluid
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      fluid%line = slice%line
      call variables%read(slice)
      call name_variables(variables, fluid)
      call variables%end_reading(errors)
      call check_range(errors, slice, 'viscosity', fluid%viscosity, above=0.0_wp, most=thickest)
      call check_range(errors, slice, 'density', fluid%density, least=0.0_wp, most=heaviest)
      call check_range(errors, slice, 'compressibility', fluid%compressibility, least=0.0_wp, most=softest)
   end subroutine read_fluid

   !> The variables, for reading and writing.
   subroutine name_variables(variables, fluid)
      type(group_variables_t), intent(inout) :: variables
      type(fluid_t), intent(inout) :: fluid

      call variables%keep('viscosity', fluid%viscosity)
      call variables%keep('density', fluid%density)
      call variables%keep('compressibility', fluid%compressibility)
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_fluid(fluid, unit)
      type(fluid_t), intent(in) :: fluid
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(fluid_t) :: effective

      effective = fluid
      call variables%write(unit, 'fluid')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_fluid

end module fluid_group_m
