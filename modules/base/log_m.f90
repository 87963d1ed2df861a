!> The run's log: every line goes to run.log, and to the screen unless the run is quiet.
module log_m
   use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
   use kinds_m, only: wp, i8
   use text_m, only: to_text
   implicit none
   private

   !> Where messages go
   type, public :: log_t
      !> Unit of the log file, 0 before it is open
      integer :: file = 0
      !> Nothing but errors on the screen
      logical :: quiet = .false.
   contains
      procedure :: open => open_log
      procedure :: say
      procedure :: warn
      procedure :: close => close_log
   end type log_t

   !> Seconds between two progress lines
   real(wp), parameter :: progress_interval = 10.0_wp

   !> How far a long run has come, said now and then with the time left
   type, public :: progress_t
      private
      !> Clock counts at the start and at the last line
      integer(i8) :: started = 0_i8, told = 0_i8
   contains
      procedure :: start
      procedure :: elapsed
      procedure :: tick
   end type progress_t

contains

   !> Open the log file; on failure the log stays on the screen alone and status is non-zero.
   subroutine open_log(self, path, status)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer, intent(out) :: status
      integer :: unit

      open (newunit=unit, file=path, action='write', status='replace', iostat=status)
      if (status == 0) self%file = unit
   end subroutine open_log

   !> One line of the run's story.
   subroutine say(self, text)
      class(log_t), intent(in) :: self
      character(len=*), intent(in) :: text

      if (.not. self%quiet) then
         write (output_unit, '(a)') text
         flush (output_unit)
      end if
      call to_file(self, text)
   end subroutine say

   !> A warning: on the error unit even when the run is quiet.
   subroutine warn(self, text)
      class(log_t), intent(in) :: self
      character(len=*), intent(in) :: text

      write (error_unit, '(a)') 'warning: '//text
      call to_file(self, 'warning: '//text)
   end subroutine warn

   subroutine close_log(self)
      class(log_t), intent(inout) :: self

      if (self%file /= 0) close (self%file)
      self%file = 0
   end subroutine close_log

   !> Start the clock.
   subroutine start(self)
      class(progress_t), intent(inout) :: self

      call system_clock(self%started)
      self%told = self%started
   end subroutine start

   !> Seconds since the start.
   real(wp) function elapsed(self)
      class(progress_t), intent(in) :: self
      integer(i8) :: now, rate

      call system_clock(now, rate)
      elapsed = real(now - self%started, wp)/real(rate, wp)
   end function elapsed

   !> Say how far the run is, unless that was said a moment ago.
   subroutine tick(self, log, done)
      class(progress_t), intent(inout) :: self
      type(log_t), intent(in) :: log
      !> Part of the run that is done, 0 to 1
      real(wp), intent(in) :: done
      integer(i8) :: now, rate
      real(wp) :: spent

      call system_clock(now, rate)
      if (real(now - self%told, wp) < progress_interval*real(rate, wp)) return
      self%told = now
      spent = self%elapsed()
      if (done > 0.0_wp) then
         call log%say('  '//to_text(nint(100.0_wp*done))//' % done after '//to_text(nint(spent))//' s, about '// &
                      to_text(nint(spent*(1.0_wp - done)/done))//' s left')
      end if
   end subroutine tick

   subroutine to_file(self, text)
      class(log_t), intent(in) :: self
      character(len=*), intent(in) :: text

      if (self%file == 0) return
      write (self%file, '(a)') text
      flush (self%file)
   end subroutine to_file

end module log_m
