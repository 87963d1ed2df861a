!> The group &implicit: accuracy, increments and equations of the implicit solver.
module implicit_group_m
   use kinds_m, only: wp
   use bounds_m, only: least_tolerance
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: option_length, check_range, check_least, check_choice
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_implicit, write_implicit

   !> &implicit
   type, public :: implicit_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Unbalanced force ratio at which an increment is done
      real(wp) :: tolerance = 1.0e-7_wp
      !> Iterations after which an increment is halved
      integer :: max_iterations = 30
      !> Halvings of a cycle's increment before the way to rest is followed in pseudo-time
      integer :: largest_cut = 2
      !> Slip of a joint in an increment over that of its peak strength and what it has slipped, above which the increment is halved
      real(wp) :: largest_slip = 0.5_wp
      !> Halvings of an iteration's correction
      integer :: line_search = 8
      !> Matrix: kept while iterations converge with it, or new in every iteration
      character(len=option_length) :: matrix = 'kept'
      !> Steps of pseudo-time in which a crack or slip that runs on by itself must come to rest
      integer :: max_pseudo_steps = 2000
      !> Bodies that nothing holds: refused, or held by weak springs in the matrix alone
      character(len=option_length) :: loose_bodies = 'refuse'
      !> Memory that the factors of the matrix may take [MB]; 0: what the machine has
      integer :: max_memory = 0
   end type implicit_t

   character(len=*), parameter :: matrices(*) = ['kept', 'new ']
   character(len=*), parameter :: treatments(*) = ['refuse', 'hold  ']

contains

   !> Read and check the group.
   subroutine read_implicit(slice, implicit, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(implicit_t), intent(out) :: implicit
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      implicit%line = slice%line
      call variables%read(slice)
      call name_variables(variables, implicit)
      call variables%end_reading(errors)
      call check_range(errors, slice, 'tolerance', implicit%tolerance, least=least_tolerance, below=1.0_wp)
      call check_least(errors, slice, 'max_iterations', implicit%max_iterations, 2)
      call check_least(errors, slice, 'largest_cut', implicit%largest_cut, 0)
      call check_range(errors, slice, 'largest_slip', implicit%largest_slip, least=1.0e-3_wp, most=1.0e6_wp)
      call check_least(errors, slice, 'line_search', implicit%line_search, 0)
      call check_choice(errors, slice, 'matrix', implicit%matrix, matrices)
      call check_least(errors, slice, 'max_pseudo_steps', implicit%max_pseudo_steps, 1)
      call check_choice(errors, slice, 'loose_bodies', implicit%loose_bodies, treatments)
      call check_least(errors, slice, 'max_memory', implicit%max_memory, 0)
   end subroutine read_implicit

   !> The variables, for reading and writing.
   subroutine name_variables(variables, implicit)
      type(group_variables_t), intent(inout) :: variables
      type(implicit_t), intent(inout) :: implicit

      call variables%keep('tolerance', implicit%tolerance)
      call variables%keep('max_iterations', implicit%max_iterations)
      call variables%keep('largest_cut', implicit%largest_cut)
      call variables%keep('largest_slip', implicit%largest_slip)
      call variables%keep('line_search', implicit%line_search)
      call variables%keep('matrix', implicit%matrix)
      call variables%keep('max_pseudo_steps', implicit%max_pseudo_steps)
      call variables%keep('loose_bodies', implicit%loose_bodies)
      call variables%keep('max_memory', implicit%max_memory)
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_implicit(implicit, unit)
      type(implicit_t), intent(in) :: implicit
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(implicit_t) :: effective

      effective = implicit
      call variables%write(unit, 'implicit')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_implicit

end module implicit_group_m
