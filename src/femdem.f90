!> JCM-FEMDEM: fractured rock in two dimensions, with its joints as they really behave.
program femdem
   use, intrinsic :: iso_fortran_env, only: error_unit
   use errors_m, only: error_list_t, status_ok, status_bad_input
   use exit_m, only: exit_with
   use command_line_m, only: command_t, read_command_line, help_text
   use deck_m, only: deck_t, read_deck
   use deck_check_m, only: check_deck, find_warnings
   use version_m, only: program_version, program_commit
   implicit none
   type(command_t) :: command
   type(deck_t) :: deck
   type(error_list_t) :: errors, warnings

   call read_command_line(command, errors)
   if (errors%any()) call stop_for_input(errors)
   if (command%help .or. command%version) then
      if (command%help) print '(a)', help_text(program_version)
      if (.not. command%help) print '(a)', 'femdem '//program_version//' ('//program_commit//')'
      call exit_with(status_ok)
   end if

   call read_deck(command%deck, deck, errors)
   call check_deck(deck, errors)
   if (errors%any()) call stop_for_input(errors)
   call find_warnings(deck, warnings)
   call warnings%write(error_unit, 'warning: ')
   if (command%check) then
      if (.not. command%quiet) print '(a)', deck%path//': the input is good'
      call exit_with(status_ok)
   end if

contains

   !> The input is wrong: say everything that is, and end.
   subroutine stop_for_input(errors)
      type(error_list_t), intent(in) :: errors

      call errors%write(error_unit)
      call exit_with(status_bad_input)
   end subroutine stop_for_input

end program femdem
