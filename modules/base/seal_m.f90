!> A seal at the end of a file: a checksum of all bytes before it, by which damage is noticed before anything is read. (What a
!> file of HDF5 has behind its end is no concern of that library.)
module seal_m
   use hash_m, only: numbers_hash
   use kinds_m, only: i8
   use text_m, only: to_text
   implicit none
   private

   public :: seal_file, broken_seal

   !> What a seal is: a mark, and 16 digits
   character(len=*), parameter :: mark = new_line('a')//'femdem seal '
   integer, parameter :: digits = 16, seal_length = len(mark) + digits
   !> Bytes of a default integer
   integer, parameter :: bytes_each = 4

contains

   !> Seal a finished file.
   subroutine seal_file(path, status)
      character(len=*), intent(in) :: path
      !> 0 on success
      integer, intent(out) :: status
      character(len=digits) :: sum
      integer(i8) :: length
      integer :: unit, ignored

      inquire (file=path, size=length)
      call sum_of(path, length, sum, status)
      if (status /= 0) return
      open (newunit=unit, file=path, access='stream', form='unformatted', action='readwrite', status='old', iostat=status)
      if (status /= 0) return
      write (unit, pos=length + 1, iostat=status) mark//sum
      if (status == 0) flush (unit, iostat=status)
      close (unit, iostat=ignored)
      if (status == 0) status = ignored
   end subroutine seal_file

   !> What is wrong with the seal of a file; '' when it is whole.
   function broken_seal(path) result(wrong)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: wrong
      character(len=seal_length) :: seal
      character(len=digits) :: sum
      integer(i8) :: length
      integer :: unit, status

      wrong = 'cannot be read'
      inquire (file=path, size=length)
      if (length < seal_length) then
         wrong = 'is cut short: it has '//to_text(max(length, 0_i8))//' bytes'
         return
      end if
      open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
      if (status /= 0) return
      read (unit, pos=length - seal_length + 1, iostat=status) seal
      close (unit)
      if (status /= 0) return
      call sum_of(path, length - seal_length, sum, status)
      if (status /= 0) return
      wrong = ''
      if (index(seal, mark) /= 1) then
         wrong = 'has no checksum at its end: it is cut short, damaged, or no checkpoint of this version'
      else if (seal(len(mark) + 1:) /= sum) then
         wrong = 'is damaged: its checksum is '//seal(len(mark) + 1:)//', its content has '//sum
      end if
   end function broken_seal

   !> Checksum of the first bytes of a file, and of their number.
   subroutine sum_of(path, length, sum, status)
      character(len=*), intent(in) :: path
      integer(i8), intent(in) :: length
      character(len=digits), intent(out) :: sum
      integer, intent(out) :: status
      integer, allocatable :: number(:)
      character(len=bytes_each) :: rest
      integer(i8) :: n
      integer :: unit, left

      sum = ''
      n = length/bytes_each
      left = int(length - n*bytes_each)
      rest = ''
      allocate (number(n + 2))
      open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
      if (status /= 0) return
      read (unit, iostat=status) number(:n)
      if (status == 0 .and. left > 0) read (unit, iostat=status) rest(:left)
      close (unit)
      number(n + 1) = transfer(rest, number(1))
      number(n + 2) = int(mod(length, int(huge(0), i8)))
      if (status == 0) sum = numbers_hash(number)
   end subroutine sum_of

end module seal_m
