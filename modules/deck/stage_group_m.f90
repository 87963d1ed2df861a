!> The group &stage: some equal load increments, each a time of motion and a time of rest.
module stage_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use bounds_m, only: least_time, most_time, least_tolerance
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, option_length, check_range, check_least, check_choice, check_given, check_idle
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_stage, write_stage

   !> A rest until equilibrium gives up after this many times move_time when max_rest_time is not given
   real(wp), parameter :: patience = 100.0_wp

   !> &stage
   type, public :: stage_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Name, for boundaries and results
      character(len=name_length) :: name = ''
      !> Number of load increments [-]
      integer :: cycles = 1
      !> Duration of the motion of each increment [s]
      real(wp) :: move_time = unset
      !> Duration of the rest after it, when equilibrium is not given [s]
      real(wp) :: rest_time = 0.0_wp
      !> Ratio of unbalanced force that ends the rest [-]
      real(wp) :: equilibrium = unset
      !> Longest rest when equilibrium is given; 100 times move_time when not given [s]
      real(wp) :: max_rest_time = unset
      !> Velocity during the motion: from zero to zero, or constant
      character(len=option_length) :: profile = 'smooth'
      !> Physical surface of the mesh whose rock is taken out; none when empty
      character(len=name_length) :: remove = ''
   end type stage_t

   character(len=*), parameter :: profiles(*) = ['smooth  ', 'constant']

contains

   !> Read and check the group.
   subroutine read_stage(slice, stage, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(stage_t), intent(out) :: stage
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      stage%line = slice%line
      call variables%read(slice)
      call name_variables(variables, stage)
      call variables%end_reading(errors)
      ! A rest until equilibrium must be able to end.
      if (is_set(stage%equilibrium) .and. is_set(stage%move_time) .and. slice%find('max_rest_time') == 0) then
         stage%max_rest_time = patience*stage%move_time
      end if
      call check_stage(slice, stage, errors)
   end subroutine read_stage

   !> The variables, for reading and writing.
   subroutine name_variables(variables, stage)
      type(group_variables_t), intent(inout) :: variables
      type(stage_t), intent(inout) :: stage

      call variables%keep('name', stage%name)
      call variables%keep('cycles', stage%cycles)
      call variables%keep('move_time', stage%move_time)
      call variables%keep('rest_time', stage%rest_time)
      call variables%keep('equilibrium', stage%equilibrium, 'the rest lasts rest_time')
      call variables%keep('max_rest_time', stage%max_rest_time)
      call variables%keep('profile', stage%profile)
      call variables%keep('remove', stage%remove)
   end subroutine name_variables

   !> Ranges and choices.
   subroutine check_stage(slice, stage, errors)
      type(group_slice_t), intent(in) :: slice
      type(stage_t), intent(inout) :: stage
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'name', stage%name, 'a name of your choice')
      call check_least(errors, slice, 'cycles', stage%cycles, 1)
      call check_range(errors, slice, 'move_time', stage%move_time, least=least_time, most=most_time, required=.true.)
      call check_range(errors, slice, 'rest_time', stage%rest_time, least=0.0_wp, most=most_time)
      call check_range(errors, slice, 'equilibrium', stage%equilibrium, least=least_tolerance, below=1.0_wp)
      call check_range(errors, slice, 'max_rest_time', stage%max_rest_time, least=least_time, most=100.0_wp*most_time)
      call check_choice(errors, slice, 'profile', stage%profile, profiles)
      if (.not. is_set(stage%equilibrium)) then
         call check_idle(errors, slice, 'max_rest_time', stage%max_rest_time, 'equilibrium')
      end if
   end subroutine check_stage

   !> Write the effective group, every variable.
   subroutine write_stage(stage, unit)
      type(stage_t), intent(in) :: stage
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(stage_t) :: effective

      effective = stage
      call variables%write(unit, 'stage')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_stage

end module stage_group_m
