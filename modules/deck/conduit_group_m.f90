!> The group &conduit: how the fractures of one physical curve conduct.
module conduit_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, an_option, name_length, option_length, namelist_text, &
                              require_clean_read, check_range, check_choice, check_given
   use deck_write_m, only: begin_group, put, end_group
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

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('group', a_name), &
                                  variable_t('aperture_mm', a_number), &
                                  variable_t('hydraulic', an_option), &
                                  variable_t('jrc', a_number), &
                                  variable_t('wall_stiffness', a_number)]
   character(len=*), parameter :: choices(*) = [character(len=len(hydraulic_laws)) :: hydraulic_laws, as_flow]

contains

   !> Read and check the group.
   subroutine read_conduit(slice, conduit, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(conduit_t), intent(out) :: conduit
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ conduit

      conduit%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_given(errors, slice, 'group', conduit%group, 'a physical curve of the mesh')
      call check_range(errors, slice, 'aperture_mm', conduit%aperture_mm, least=0.0_wp, most=widest)
      call check_choice(errors, slice, 'hydraulic', conduit%hydraulic, choices)
      call check_range(errors, slice, 'jrc', conduit%jrc, above=0.0_wp, most=roughest)
      call check_range(errors, slice, 'wall_stiffness', conduit%wall_stiffness, above=0.0_wp)
   end subroutine read_conduit

   !> Write the effective group, every variable.
   subroutine write_conduit(conduit, unit)
      type(conduit_t), intent(in) :: conduit
      integer, intent(in) :: unit

      call begin_group(unit, 'conduit')
      call put(unit, 'group', conduit%group)
      call put(unit, 'aperture_mm', conduit%aperture_mm, 'that of the joints')
      call put(unit, 'hydraulic', conduit%hydraulic)
      call put(unit, 'jrc', conduit%jrc, 'jrc0 of the &joint')
      call put(unit, 'wall_stiffness', conduit%wall_stiffness, 'rigid')
      call end_group(unit)
   end subroutine write_conduit

end module conduit_group_m
