!> The group &output: what is written, where and how often.
module output_group_m
   use kinds_m, only: wp
   use bounds_m, only: most_time
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: path_length, check_range, check_least, check_given
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_output, write_output

   !> &output
   type, public :: output_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Directory of the results, relative to the deck
      character(len=path_length) :: directory = 'results'
      !> Cycles between two outputs of the fields (0: at the end of each stage)
      integer :: fields_every = 0
      !> Cycles between two rows of the history [-]
      integer :: history_every = 1
      !> Wall-clock time after which a cycle ends with a checkpoint (0: every cycle) [minutes]
      real(wp) :: checkpoint_minutes = 10.0_wp
   end type output_t

contains

   !> Read and check the group.
   subroutine read_output(slice, output, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(output_t), intent(out) :: output
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      output%line = slice%line
      call variables%read(slice)
      call name_variables(variables, output)
      call variables%end_reading(errors)
      call check_output(slice, output, errors)
   end subroutine read_output

   !> The variables, for reading and writing.
   subroutine name_variables(variables, output)
      type(group_variables_t), intent(inout) :: variables
      type(output_t), intent(inout) :: output

      call variables%keep('directory', output%directory)
      call variables%keep('fields_every', output%fields_every)
      call variables%keep('history_every', output%history_every)
      call variables%keep('checkpoint_minutes', output%checkpoint_minutes)
   end subroutine name_variables

   !> Ranges and choices.
   subroutine check_output(slice, output, errors)
      type(group_slice_t), intent(in) :: slice
      type(output_t), intent(in) :: output
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'directory', output%directory, 'a directory, relative to the deck')
      call check_least(errors, slice, 'fields_every', output%fields_every, 0)
      call check_least(errors, slice, 'history_every', output%history_every, 1)
      call check_range(errors, slice, 'checkpoint_minutes', output%checkpoint_minutes, least=0.0_wp, most=most_time)
   end subroutine check_output

   !> Write the effective group, every variable.
   subroutine write_output(output, unit)
      type(output_t), intent(in) :: output
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(output_t) :: effective

      effective = output
      call variables%write(unit, 'output')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_output

end module output_group_m
