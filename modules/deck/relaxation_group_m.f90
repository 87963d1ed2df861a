!> The group &relaxation: accuracy, steps and increments of the relaxation solver.
module relaxation_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_part, least_tolerance
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: check_range, check_least
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_relaxation, write_relaxation

   !> &relaxation
   type, public :: relaxation_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Unbalanced force ratio at which an increment is done
      real(wp) :: tolerance = 1.0e-6_wp
      !> Steps after which an increment that has not come to rest is given up
      integer :: max_steps = 100000
      !> Increments that a cycle is divided into
      integer :: substeps = 1
      !> Slip of a joint in an increment over that of its peak strength and what it has slipped, above which the increment is halved
      real(wp) :: largest_slip = 0.5_wp
      !> Step over the longest stable one, which sets the fictitious masses
      real(wp) :: safety = 0.9_wp
   end type relaxation_t

contains

   !> Read and check the group.
   subroutine read_relaxation(slice, relaxation, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(relaxation_t), intent(out) :: relaxation
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      relaxation%line = slice%line
      call variables%read(slice)
      call name_variables(variables, relaxation)
      call variables%end_reading(errors)
      call check_range(errors, slice, 'tolerance', relaxation%tolerance, least=least_tolerance, below=1.0_wp)
      call check_least(errors, slice, 'max_steps', relaxation%max_steps, 1)
      call check_least(errors, slice, 'substeps', relaxation%substeps, 1)
      call check_range(errors, slice, 'largest_slip', relaxation%largest_slip, least=1.0e-3_wp, most=1.0e6_wp)
      call check_range(errors, slice, 'safety', relaxation%safety, least=least_part, most=1.0_wp)
   end subroutine read_relaxation

   !> The variables, for reading and writing.
   subroutine name_variables(variables, relaxation)
      type(group_variables_t), intent(inout) :: variables
      type(relaxation_t), intent(inout) :: relaxation

      call variables%keep('tolerance', relaxation%tolerance)
      call variables%keep('max_steps', relaxation%max_steps)
      call variables%keep('substeps', relaxation%substeps)
      call variables%keep('largest_slip', relaxation%largest_slip)
      call variables%keep('safety', relaxation%safety)
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_relaxation(relaxation, unit)
      type(relaxation_t), intent(in) :: relaxation
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(relaxation_t) :: effective

      effective = relaxation
      call variables%write(unit, 'relaxation')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_relaxation

end module relaxation_group_m
