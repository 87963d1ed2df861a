!> The group &in_situ: the stress that the rock is under before the first stage.
module in_situ_group_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use bounds_m, only: most_stress, least_size
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: check_range, check_size
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_in_situ, write_in_situ, in_situ_stress

   !> Growth of a stress with depth beyond which a number was mistyped [Pa/m], and place of the reference [m]
   real(wp), parameter :: steepest = 1.0e9_wp, farthest = 1.0e9_wp

   !> &in_situ
   type, public :: in_situ_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Stresses at reference_y, compression positive [Pa]
      real(wp) :: sxx = unset, syy = unset, sxy = 0.0_wp
      !> Their growth with depth below reference_y [Pa/m]
      real(wp) :: sxx_gradient = 0.0_wp, syy_gradient = 0.0_wp, sxy_gradient = 0.0_wp
      !> Where they are sxx, syy, sxy [m]
      real(wp) :: reference_y = 0.0_wp
   end type in_situ_t

contains

   !> Read and check the group.
   subroutine read_in_situ(slice, in_situ, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(in_situ_t), intent(out) :: in_situ
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      in_situ%line = slice%line
      call variables%read(slice)
      call name_variables(variables, in_situ)
      call variables%end_reading(errors)
      call check_in_situ(slice, in_situ, errors)
   end subroutine read_in_situ

   !> The variables, for reading and writing.
   subroutine name_variables(variables, in_situ)
      type(group_variables_t), intent(inout) :: variables
      type(in_situ_t), intent(inout) :: in_situ

      call variables%keep('sxx', in_situ%sxx)
      call variables%keep('syy', in_situ%syy)
      call variables%keep('sxy', in_situ%sxy)
      call variables%keep('sxx_gradient', in_situ%sxx_gradient)
      call variables%keep('syy_gradient', in_situ%syy_gradient)
      call variables%keep('sxy_gradient', in_situ%sxy_gradient)
      call variables%keep('reference_y', in_situ%reference_y)
   end subroutine name_variables

   !> Ranges.
   subroutine check_in_situ(slice, in_situ, errors)
      type(group_slice_t), intent(in) :: slice
      type(in_situ_t), intent(in) :: in_situ
      type(error_list_t), intent(inout) :: errors

      call check_range(errors, slice, 'sxx', in_situ%sxx, least=-most_stress, most=most_stress, required=.true.)
      call check_range(errors, slice, 'syy', in_situ%syy, least=-most_stress, most=most_stress, required=.true.)
      call check_size(errors, slice, 'sxy', in_situ%sxy, least_size, most_stress)
      call check_size(errors, slice, 'sxx_gradient', in_situ%sxx_gradient, least_size, steepest)
      call check_size(errors, slice, 'syy_gradient', in_situ%syy_gradient, least_size, steepest)
      call check_size(errors, slice, 'sxy_gradient', in_situ%sxy_gradient, least_size, steepest)
      call check_size(errors, slice, 'reference_y', in_situ%reference_y, least_size, farthest)
   end subroutine check_in_situ

   !> Write the effective group, every variable; nothing where the deck has none.
   subroutine write_in_situ(in_situ, unit)
      type(in_situ_t), intent(in) :: in_situ
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(in_situ_t) :: effective

      if (in_situ%line == 0) return
      effective = in_situ
      call variables%write(unit, 'in_situ')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_in_situ

   !> Stress sxx, syy, sxy at a height, tension positive [Pa].
   pure function in_situ_stress(in_situ, y) result(stress)
      type(in_situ_t), intent(in) :: in_situ
      !> [m]
      real(wp), intent(in) :: y
      real(wp) :: stress(3), depth

      depth = in_situ%reference_y - y
      stress = -[in_situ%sxx + depth*in_situ%sxx_gradient, in_situ%syy + depth*in_situ%syy_gradient, &
                 in_situ%sxy + depth*in_situ%sxy_gradient]
   end function in_situ_stress

end module in_situ_group_m
