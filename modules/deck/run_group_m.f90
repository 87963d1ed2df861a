!> The group &run: what is run, on which mesh, by which solver.
module run_group_m
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_path, a_switch, an_option, option_length, path_length, namelist_text, &
                              require_clean_read, check_choice, check_given
   use deck_write_m, only: begin_group, put, end_group
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
   end type run_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('title', a_path), &
                                  variable_t('mesh', a_path), &
                                  variable_t('solver', an_option), &
                                  variable_t('long', a_switch)]
   character(len=*), parameter :: solvers(*) = ['auto      ', 'explicit  ', 'implicit  ', 'relaxation']

contains

   !> Read and check the group.
   subroutine read_run(slice, run, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(run_t), intent(out) :: run
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ run

      run%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_run(slice, run, errors)
   end subroutine read_run

   !> Ranges and choices.
   subroutine check_run(slice, run, errors)
      type(group_slice_t), intent(in) :: slice
      type(run_t), intent(inout) :: run
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'mesh', run%mesh, 'the mesh file, relative to the deck')
      call check_choice(errors, slice, 'solver', run%solver, solvers)
   end subroutine check_run

   !> Write the effective group, every variable.
   subroutine write_run(run, unit)
      type(run_t), intent(in) :: run
      integer, intent(in) :: unit

      call begin_group(unit, 'run')
      call put(unit, 'title', run%title)
      call put(unit, 'mesh', run%mesh)
      call put(unit, 'solver', run%solver)
      call put(unit, 'long', run%long)
      call end_group(unit)
   end subroutine write_run

end module run_group_m
