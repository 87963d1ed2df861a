!> Where a run's results go, and the deck that goes with them.
module results_directory_m
   use errors_m, only: error_list_t
   use files_m, only: read_text, file_exists, real_path, relative_path, replace_file
   use deck_m, only: deck_t, write_deck, deck_path, written_by_program
   implicit none
   private

   public :: results_directory, check_directory, effective_deck

contains

   !> Directory of the results: as asked for on the command line, else the deck's, relative to the deck.
   pure function results_directory(deck, asked) result(directory)
      type(deck_t), intent(in) :: deck
      !> From the command line; empty when not given
      character(len=*), intent(in) :: asked
      character(len=:), allocatable :: directory

      if (asked /= '') then
         directory = trim(asked)
      else if (deck%output%directory(1:1) == '/') then
         directory = trim(deck%output%directory)
      else
         directory = deck%directory//trim(deck%output%directory)
      end if
   end function results_directory

   !> The effective deck must not replace a deck that somebody has written.
   subroutine check_directory(directory, errors)
      character(len=*), intent(in) :: directory
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      integer :: status

      if (.not. file_exists(directory//'/deck.nml')) return
      call read_text(directory//'/deck.nml', text, status)
      if (index(text, written_by_program) == 1) return
      call errors%add(directory//'/deck.nml is no deck that the program has written, and the results would replace it; must be '// &
                      'another directory (--output, or directory of &output), or rename that deck')
   end subroutine check_directory

   !> Write the complete deck, defaults and all, and give its text. Its paths are those from where it is, so that it can be run.
   subroutine effective_deck(path, deck, text, errors)
      character(len=*), intent(in) :: path
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable, intent(out) :: text
      type(error_list_t), intent(inout) :: errors
      type(deck_t) :: here
      character(len=:), allocatable :: mesh, directory
      character(len=256) :: message
      integer :: unit, status, closed

      text = ''
      here = deck
      mesh = real_path(deck_path(deck, deck%run%mesh))
      directory = real_path(path(:index(path, '/', back=.true.)))
      if (mesh /= '' .and. directory /= '') here%run%mesh = relative_path(mesh, directory)
      here%output%directory = '.'
      open (newunit=unit, file=path//'.part', action='write', status='replace', iostat=status, iomsg=message)
      if (status /= 0) then
         call errors%add(path//' cannot be written: '//trim(message))
         return
      end if
      call write_deck(here, unit, status)
      close (unit, iostat=closed)
      if (status == 0) status = closed
      if (status == 0) call replace_file(path//'.part', path, status)
      if (status /= 0) call errors%add(path//' cannot be written (disk full?)')
      if (status == 0) call read_text(path, text, status)
   end subroutine effective_deck

end module results_directory_m
