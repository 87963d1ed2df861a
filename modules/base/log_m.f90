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
   subroutine open_log(self, path, go_on, status)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Add to what an earlier run has said, in place of starting anew?
      logical, intent(in) :: go_on
      integer, intent(out) :: status
      integer :: unit

      if (go_on) then
         open (newunit=unit, file=path, action='write', position='append', iostat=status)
      else
         open (newunit=unit, file=path, action='write', status='replace', iostat=status)
      end if
      if (status == 0) self%file = unit
   end subroutine open_log

   !> One line of the run's story.
   subroutine say(self, text)
      class(log_t), intent(in) :: self
      character(len=*), intent(in) :: text
      integer :: status

      if (.not. self%quiet) then
         ! A story that cannot be told (disk full, reader gone) is no reason to end the run
         write (output_unit, '(a)', iostat=status) text
         flush (output_unit, iostat=status)
      end if
      call to_file(self, text)
   end subroutine say

   !> A warning: on the error unit even when the run is quiet.
   subroutine warn(self, text)
      class(log_t), intent(in) :: self
      character(len=*), intent(in) :: text
      integer :: status

      write (error_unit, '(a)', iostat=status) 'warning: '//text
      call to_file(self, 'warning: '//text)
   end subroutine warn

   subroutine close_log(self)
      class(log_t), intent(inout) :: self
      integer :: status

      if (self%file /= 0) close (self%file, iostat=status)
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
      integer :: status

      if (self%file == 0) return
      write (self%file, '(a)', iostat=status) text
      flush (self%file, iostat=status)
   end subroutine to_file

end module log_m
