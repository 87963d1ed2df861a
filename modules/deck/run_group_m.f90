!> The group &run: what is run, on which mesh, by which solver.
module run_group_m
   use kinds_m, only: wp
   use bounds_m, only: most_threads
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: option_length, path_length, check_choice, check_given, check_range
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_run, write_run

   !> &run
   type, public :: run_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> One line about the run, repeated in the results
      character(len=path_length) :: title = ''
      !> Mesh file, relative to the deck
      character(len=path_length) :: mesh = ''
      !> How the scene is solved
      character(len=option_length) :: solver = 'auto'
      !> Is a run meant that takes very long?
      logical :: long = .false.
      !> Threads of the kernels; 0: what OMP_NUM_THREADS says, or one
      integer :: threads = 0
   end type run_t

   character(len=*), parameter :: solvers(*) = ['auto      ', 'explicit  ', 'implicit  ', 'relaxation']

contains

   !> Read and check the group.
   subroutine read_run(slice, run, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(run_t), intent(out) :: run
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      run%line = slice%line
      call variables%read(slice)
      call name_variables(variables, run)
      call variables%end_reading(errors)
      call check_run(slice, run, errors)
   end subroutine read_run

   !> The variables, for reading and writing.
   subroutine name_variables(variables, run)
      type(group_variables_t), intent(inout) :: variables
      type(run_t), intent(inout) :: run

      call variables%keep('title', run%title)
      call variables%keep('mesh', run%mesh)
      call variables%keep('solver', run%solver)
      call variables%keep('long', run%long)
      call variables%keep('threads', run%threads)
   end subroutine name_variables

   !> Ranges and choices.
   subroutine check_run(slice, run, errors)
      type(group_slice_t), intent(in) :: slice
      type(run_t), intent(inout) :: run
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'mesh', run%mesh, 'the mesh file, relative to the deck')
      call check_choice(errors, slice, 'solver', run%solver, solvers)
      call check_range(errors, slice, 'threads', real(run%threads, wp), least=0.0_wp, most=most_threads)
   end subroutine check_run

   !> Write the effective group, every variable.
   subroutine write_run(run, unit)
      type(run_t), intent(in) :: run
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(run_t) :: effective

      effective = run
      call variables%write(unit, 'run')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_run

end module run_group_m
