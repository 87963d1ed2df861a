!> The group &contact: contact between free surfaces, away from the fractures' own walls.
module contact_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_part
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: option_length, check_range, check_choice
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_contact, write_contact

   real(wp), parameter :: right_angle = 90.0_wp

   !> &contact
   type, public :: contact_group_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Do free surfaces touch each other?
      logical :: active = .true.
      !> Friction angle between free surfaces [degrees]
      real(wp) :: friction_angle = 0.0_wp
      !> Spring-slider, or eq 4 with the relative velocity
      character(len=option_length) :: friction = 'slider'
      !> Skin of the contact search over the edge length [-]
      real(wp) :: skin_factor = 0.2_wp
      !> Tangential over normal contact stiffness [-]
      real(wp) :: tangential_factor = 1.0_wp
      !> Stiffness of blocks against each other at the corners of crossings over Young's modulus; 0: corners pass [-]
      real(wp) :: corner_factor = 45.0_wp
   end type contact_group_t

   character(len=*), parameter :: frictions(*) = ['slider  ', 'velocity']

contains

   !> Read and check the group.
   subroutine read_contact(slice, contact, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(contact_group_t), intent(out) :: contact
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      contact%line = slice%line
      call variables%read(slice)
      call name_variables(variables, contact)
      call variables%end_reading(errors)
      call check_contact(slice, contact, errors)
   end subroutine read_contact

   !> The variables, for reading and writing.
   subroutine name_variables(variables, contact)
      type(group_variables_t), intent(inout) :: variables
      type(contact_group_t), intent(inout) :: contact

      call variables%keep('active', contact%active)
      call variables%keep('friction_angle', contact%friction_angle)
      call variables%keep('friction', contact%friction)
      call variables%keep('skin_factor', contact%skin_factor)
      call variables%keep('tangential_factor', contact%tangential_factor)
      call variables%keep('corner_factor', contact%corner_factor)
   end subroutine name_variables

   !> Ranges and choices.
   subroutine check_contact(slice, contact, errors)
      type(group_slice_t), intent(in) :: slice
      type(contact_group_t), intent(inout) :: contact
      type(error_list_t), intent(inout) :: errors

      call check_choice(errors, slice, 'friction', contact%friction, frictions)
      call check_range(errors, slice, 'friction_angle', contact%friction_angle, least=0.0_wp, below=right_angle)
      call check_range(errors, slice, 'skin_factor', contact%skin_factor, least=least_part, most=1.0_wp)
      call check_range(errors, slice, 'tangential_factor', contact%tangential_factor, least=least_part, most=10.0_wp)
      call check_range(errors, slice, 'corner_factor', contact%corner_factor, least=0.0_wp, most=1000.0_wp)
   end subroutine check_contact

   !> Write the effective group, every variable.
   subroutine write_contact(contact, unit)
      type(contact_group_t), intent(in) :: contact
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(contact_group_t) :: effective

      effective = contact
      call variables%write(unit, 'contact')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_contact

end module contact_group_m
