!> The run's log: every line goes to run.log, and to the screen unless the run is quiet.
module log_m
   use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
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

   subroutine to_file(self, text)
      class(log_t), intent(in) :: self
      character(len=*), intent(in) :: text

      if (self%file == 0) return
      write (self%file, '(a)') text
      flush (self%file)
   end subroutine to_file

end module log_m
