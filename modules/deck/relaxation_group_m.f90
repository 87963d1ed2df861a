!> The group &relaxation: accuracy, steps and increments of the relaxation solver.
module relaxation_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_part, least_tolerance
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_number, a_count, namelist_text, require_clean_read, check_range, check_least
   use deck_write_m, only: begin_group, put, end_group
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
      !> Step over the longest stable one, which sets the fictitious masses
      real(wp) :: safety = 0.9_wp
   end type relaxation_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('tolerance', a_number), &
                                  variable_t('max_steps', a_count), &
                                  variable_t('substeps', a_count), &
                                  variable_t('safety', a_number)]

contains

   !> Read and check the group.
   subroutine read_relaxation(slice, relaxation, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(relaxation_t), intent(out) :: relaxation
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ relaxation

      relaxation%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_range(errors, slice, 'tolerance', relaxation%tolerance, least=least_tolerance, below=1.0_wp)
      call check_least(errors, slice, 'max_steps', relaxation%max_steps, 1)
      call check_least(errors, slice, 'substeps', relaxation%substeps, 1)
      call check_range(errors, slice, 'safety', relaxation%safety, least=least_part, most=1.0_wp)
   end subroutine read_relaxation

   !> Write the effective group, every variable.
   subroutine write_relaxation(relaxation, unit)
      type(relaxation_t), intent(in) :: relaxation
      integer, intent(in) :: unit

      call begin_group(unit, 'relaxation')
      call put(unit, 'tolerance', relaxation%tolerance)
      call put(unit, 'max_steps', relaxation%max_steps)
      call put(unit, 'substeps', relaxation%substeps)
      call put(unit, 'safety', relaxation%safety)
      call end_group(unit)
   end subroutine write_relaxation

end module relaxation_group_m
