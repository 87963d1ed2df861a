!> The group &flow_boundary: pressure or inflow of the fluid at a physical group of the mesh. What has none is closed.
module flow_boundary_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, check_range, check_given, check_idle
   use group_variables_m, only: group_variables_t
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

contains

   !> Read and check the group.
   subroutine read_flow_boundary(slice, flow_boundary, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(flow_boundary_t), intent(out) :: flow_boundary
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      flow_boundary%line = slice%line
      call variables%read(slice)
      call name_variables(variables, flow_boundary)
      call variables%end_reading(errors)
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

   !> The variables, for reading and writing.
   subroutine name_variables(variables, flow_boundary)
      type(group_variables_t), intent(inout) :: variables
      type(flow_boundary_t), intent(inout) :: flow_boundary

      call variables%keep('group', flow_boundary%group)
      call variables%keep('stage', flow_boundary%stage)
      call variables%keep('pressure', flow_boundary%pressure, 'not prescribed')
      call variables%keep('pressure_dx', flow_boundary%pressure_dx)
      call variables%keep('pressure_dy', flow_boundary%pressure_dy)
      call variables%keep('flux', flow_boundary%flux, 'not prescribed')
      call variables%keep('rate', flow_boundary%rate, 'not prescribed')
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_flow_boundary(flow_boundary, unit)
      type(flow_boundary_t), intent(in) :: flow_boundary
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(flow_boundary_t) :: effective

      effective = flow_boundary
      call variables%write(unit, 'flow_boundary')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_flow_boundary

end module flow_boundary_group_m
