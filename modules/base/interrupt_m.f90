!> Signals: those that ask a run to stop are noted, and the run looks at the note where what it has can be kept. A second one ends
!> it at once, as if nothing had been done about signals.
module interrupt_m
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int, c_intptr_t, c_null_funptr, c_associated
   implicit none
   private

   public :: catch_signals, stop_wanted, signal_name, write_beyond_limits

   !> Their numbers, the same on Linux, the BSDs and macOS: the terminal has gone, Ctrl-C, kill and batch systems; a file has
   !> reached the largest size allowed
   integer(c_int), parameter :: hang_up = 1, from_keyboard = 2, terminate = 15, file_too_large = 25
   integer(c_int), parameter :: asks_to_stop(*) = [hang_up, from_keyboard, terminate]
   !> SIG_IGN of C: the address that stands for 'ignored'
   integer(c_intptr_t), parameter :: ignored = 1

   !> The signal that has come (0: none). All that a handler may do is to leave a note, and it has no other place for it
   integer(c_int), volatile, save :: caught = 0

   interface
      function c_signal(number, handler) bind(c, name='signal') result(before)
         import :: c_int, c_funptr
         integer(c_int), value :: number
         type(c_funptr), value :: handler
         type(c_funptr) :: before
      end function c_signal
   end interface

contains

   !> From now on note SIGTERM, SIGINT and SIGHUP. One that the caller has had ignored (nohup does) stays so.
   subroutine catch_signals()
      type(c_funptr) :: before
      integer :: i

      do i = 1, size(asks_to_stop)
         before = c_signal(asks_to_stop(i), c_funloc(note_signal))
         if (c_associated(before, transfer(ignored, c_null_funptr))) before = c_signal(asks_to_stop(i), before)
      end do
   end subroutine catch_signals

   !> Let writing beyond the largest size of a file fail like any other writing, in place of ending the program.
   subroutine write_beyond_limits()
      type(c_funptr) :: before

      before = c_signal(file_too_large, transfer(ignored, c_null_funptr))
   end subroutine write_beyond_limits

   !> The handler: the next signal does what it would have done without it.
   subroutine note_signal(number) bind(c)
      integer(c_int), value :: number
      type(c_funptr) :: before
      integer :: i

      caught = number
      do i = 1, size(asks_to_stop)
         before = c_signal(asks_to_stop(i), c_null_funptr)
      end do
   end subroutine note_signal

   !> Has somebody asked the run to stop?
   logical function stop_wanted()
      stop_wanted = caught /= 0
   end function stop_wanted

   !> Name of the signal that has come; '' when there was none.
   function signal_name() result(name)
      character(len=:), allocatable :: name

      select case (caught)
      case (hang_up)
         name = 'SIGHUP'
      case (from_keyboard)
         name = 'SIGINT'
      case (terminate)
         name = 'SIGTERM'
      case default
         name = ''
      end select
   end function signal_name

end module interrupt_m
