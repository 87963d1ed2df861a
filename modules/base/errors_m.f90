!> Errors are values: procedures add messages to a list, and only the program turns a list into an exit status.
module errors_m
   implicit none
   private

   !> Exit status of the program: done, the run failed, the input is wrong, stopped by a signal with all that was done kept
   integer, parameter, public :: status_ok = 0, status_failed = 1, status_bad_input = 2, status_stopped = 3

   type :: message_t
      character(len=:), allocatable :: text
   end type message_t

   !> A growing list of error messages, reported together
   type, public :: error_list_t
      private
      integer :: n = 0
      type(message_t), allocatable :: message(:)
   contains
      procedure :: add
      procedure :: append
      procedure :: count => error_count
      procedure :: any => any_error
      procedure :: text
      procedure :: write => write_errors
   end type error_list_t

contains

   !> Append a message.
   subroutine add(self, text)
      class(error_list_t), intent(inout) :: self
      !> One line without prefix: what, where, the value found, what would be valid
      character(len=*), intent(in) :: text
      type(message_t), allocatable :: longer(:)

      if (.not. allocated(self%message)) allocate (self%message(8))
      if (self%n == size(self%message)) then
         allocate (longer(2*self%n))
         longer(:self%n) = self%message
         call move_alloc(longer, self%message)
      end if
      self%n = self%n + 1
      self%message(self%n)%text = trim(text)
   end subroutine add

   !> Append all messages of another list.
   subroutine append(self, other)
      class(error_list_t), intent(inout) :: self
      class(error_list_t), intent(in) :: other
      integer :: i

      do i = 1, other%n
         call self%add(other%message(i)%text)
      end do
   end subroutine append

   !> Number of messages.
   pure integer function error_count(self)
      class(error_list_t), intent(in) :: self

      error_count = self%n
   end function error_count

   !> Is there a message at all?
   pure logical function any_error(self)
      class(error_list_t), intent(in) :: self

      any_error = self%n > 0
   end function any_error

   !> The i-th message (empty when there is none).
   pure function text(self, i)
      class(error_list_t), intent(in) :: self
      integer, intent(in) :: i
      character(len=:), allocatable :: text

      text = ''
      if (i >= 1 .and. i <= self%n) text = self%message(i)%text
   end function text

   !> Write all messages, one a line, each with the prefix 'error: ' or another one.
   subroutine write_errors(self, unit, prefix)
      class(error_list_t), intent(in) :: self
      integer, intent(in) :: unit
      !> Prefix of each line, 'warning: ' for a list of warnings
      character(len=*), intent(in), optional :: prefix
      character(len=:), allocatable :: start
      integer :: i, status

      start = 'error: '
      if (present(prefix)) start = prefix
      do i = 1, self%n
         ! Where there is no room to say it there is nobody to tell
         write (unit, '(a)', iostat=status) start//self%message(i)%text
      end do
   end subroutine write_errors

end module errors_m
