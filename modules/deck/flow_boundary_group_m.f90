!> The group &flow_boundary: pressure or inflow of the fluid at a physical group of the mesh. What has none is closed.
module flow_boundary_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, name_length, namelist_text, require_clean_read, &
                              check_range, check_given, check_idle
   use deck_write_m, only: begin_group, put, end_group
   use boundary_group_m, only: every_stage
   implicit none
   private

   public :: read_flow_boundary, write_flow_boundary

   !> Pressure [Pa] beyond which the unit must be wrong
   real(wp), parameter :: highest = 1.0e10_wp

   !> &flow_boundary
   type, public :: flow_boundary_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical curve or point of the mesh
      character(len=name_length) :: group = ''
      !> Stage during which it grows, to stay from then on, or 'all': there in full from the start
      character(len=name_length) :: stage = every_stage
      !> Pressure where x = y = 0 [Pa], and its slopes in x and y [Pa/m]
      real(wp) :: pressure = unset, pressure_dx = 0.0_wp, pressure_dy = 0.0_wp
      !> Inflow through each metre of the curve [m/s]
      real(wp) :: flux = unset
      !> Inflow through the whole group, shared by its conducting nodes [m2/s]
      real(wp) :: rate = unset
   end type flow_boundary_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('group', a_name), &
                                  variable_t('stage', a_name), &
                                  variable_t('pressure', a_number), &
                                  variable_t('pressure_dx', a_number), &
                                  variable_t('pressure_dy', a_number), &
                                  variable_t('flux', a_number), &
                                  variable_t('rate', a_number)]

contains

   !> Read and check the group.
   subroutine read_flow_boundary(slice, flow_boundary, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(flow_boundary_t), intent(out) :: flow_boundary
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ flow_boundary

      flow_boundary%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_given(errors, slice, 'group', flow_boundary%group, 'a physical curve or point of the mesh')
      associate (given => is_set([flow_boundary%pressure, flow_boundary%flux, flow_boundary%rate]))
         if (count(given) /= 1) call errors%add(slice%place('pressure')//': one of pressure, flux and rate must be given '// &
                                                '(a boundary without flow needs no &flow_boundary)')
      end associate
      if (is_set(flow_boundary%pressure)) then
         call check_range(errors, slice, 'pressure', flow_boundary%pressure, least=-highest, most=highest)
      else
         if (abs(flow_boundary%pressure_dx) > 0.0_wp) &
            call check_idle(errors, slice, 'pressure_dx', flow_boundary%pressure_dx, 'pressure')
         if (abs(flow_boundary%pressure_dy) > 0.0_wp) &
            call check_idle(errors, slice, 'pressure_dy', flow_boundary%pressure_dy, 'pressure')
      end if
   end subroutine read_flow_boundary

   !> Write the effective group, every variable.
   subroutine write_flow_boundary(flow_boundary, unit)
      type(flow_boundary_t), intent(in) :: flow_boundary
      integer, intent(in) :: unit

      call begin_group(unit, 'flow_boundary')
      call put(unit, 'group', flow_boundary%group)
      call put(unit, 'stage', flow_boundary%stage)
      call put(unit, 'pressure', flow_boundary%pressure, 'not prescribed')
      call put(unit, 'pressure_dx', flow_boundary%pressure_dx)
      call put(unit, 'pressure_dy', flow_boundary%pressure_dy)
      call put(unit, 'flux', flow_boundary%flux, 'not prescribed')
      call put(unit, 'rate', flow_boundary%rate, 'not prescribed')
      call end_group(unit)
   end subroutine write_flow_boundary

end module flow_boundary_group_m
