!> The group &conduit: how the fractures of one physical curve conduct.
module conduit_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, option_length, check_range, check_choice, check_given
   use group_variables_m, only: group_variables_t
   use flow_group_m, only: hydraulic_laws
   implicit none
   private

   public :: read_conduit, write_conduit

   !> Beyond these the unit must be wrong: aperture [mm], JRC [-] (profiles reach 20)
   real(wp), parameter :: widest = 1.0e4_wp, roughest = 30.0_wp
   !> Law of a conduit that does not choose one
   character(len=*), parameter, public :: as_flow = 'as flow'

   !> &conduit
   type, public :: conduit_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical curve of the mesh
      character(len=name_length) :: group = ''
      !> Mechanical aperture [mm]; that of the joints when not given
      real(wp) :: aperture_mm = unset
      !> Hydraulic from mechanical aperture
      character(len=option_length) :: hydraulic = as_flow
      !> Roughness in it [-]; jrc0 of the &joint when not given
      real(wp) :: jrc = unset
      !> Stiffness of the walls against the fluid [Pa/m]; rigid when not given; it counts in transient flow
      real(wp) :: wall_stiffness = unset
   end type conduit_t

   character(len=*), parameter :: choices(*) = [character(len=len(hydraulic_laws)) :: hydraulic_laws, as_flow]

contains

   !> Read and check the group.
   subroutine read_conduit(slice, conduit, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(conduit_t), intent(out) :: conduit
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      conduit%line = slice%line
      call variables%read(slice)
      call name_variables(variables, conduit)
      call variables%end_reading(errors)
      call check_given(errors, slice, 'group', conduit%group, 'a physical curve of the mesh')
      call check_range(errors, slice, 'aperture_mm', conduit%aperture_mm, least=0.0_wp, most=widest)
      call check_choice(errors, slice, 'hydraulic', conduit%hydraulic, choices)
      call check_range(errors, slice, 'jrc', conduit%jrc, above=0.0_wp, most=roughest)
      call check_range(errors, slice, 'wall_stiffness', conduit%wall_stiffness, above=0.0_wp)
   end subroutine read_conduit

   !> The variables, for reading and writing.
   subroutine name_variables(variables, conduit)
      type(group_variables_t), intent(inout) :: variables
      type(conduit_t), intent(inout) :: conduit

      call variables%keep('group', conduit%group)
      call variables%keep('aperture_mm', conduit%aperture_mm, 'that of the joints')
      call variables%keep('hydraulic', conduit%hydraulic)
      call variables%keep('jrc', conduit%jrc, 'jrc0 of the &joint')
      call variables%keep('wall_stiffness', conduit%wall_stiffness, 'rigid')
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_conduit(conduit, unit)
      type(conduit_t), intent(in) :: conduit
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(conduit_t) :: effective

      effective = conduit
      call variables%write(unit, 'conduit')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_conduit

end module conduit_group_m
