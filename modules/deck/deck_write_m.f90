!> Writing the effective deck: groups and variables in the form that the deck reader reads back exactly. Whether all of it could
!> be written is asked at its end (write_deck).
module deck_write_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use text_m, only: exact_text, to_text
   implicit none
   private

   public :: begin_group, put, end_group

   !> Write one variable of a group
   interface put
      module procedure put_real, put_integer, put_logical, put_text
   end interface put

   character(len=*), parameter :: indent = '   '

contains

   subroutine begin_group(unit, name)
      integer, intent(in) :: unit
      !> Name of the group without '&'
      character(len=*), intent(in) :: name
      integer :: status

      write (unit, '(a)', iostat=status) '&'//name
   end subroutine begin_group

   subroutine end_group(unit)
      integer, intent(in) :: unit
      integer :: status

      write (unit, '(a,/)', iostat=status) '/'
   end subroutine end_group

   !> A number; one that is not given is named in a comment, with what is used instead.
   subroutine put_real(unit, name, value, instead)
      integer, intent(in) :: unit
      !> Variable
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value
      !> What the program uses when the number is not given
      character(len=*), intent(in), optional :: instead
      integer :: status

      if (is_set(value)) then
         call put_line(unit, name, exact_text(value))
      else if (present(instead)) then
         write (unit, '(a)', iostat=status) indent//'! '//name//' is not given: '//instead
      else
         write (unit, '(a)', iostat=status) indent//'! '//name//' is not given'
      end if
   end subroutine put_real

   subroutine put_integer(unit, name, value)
      integer, intent(in) :: unit
      character(len=*), intent(in) :: name
      integer, intent(in) :: value

      call put_line(unit, name, to_text(value))
   end subroutine put_integer

   subroutine put_logical(unit, name, value)
      integer, intent(in) :: unit
      character(len=*), intent(in) :: name
      logical, intent(in) :: value

      call put_line(unit, name, trim(merge('.true. ', '.false.', value)))
   end subroutine put_logical

   subroutine put_text(unit, name, value)
      integer, intent(in) :: unit
      character(len=*), intent(in) :: name, value

      call put_line(unit, name, "'"//doubled_quotes(trim(value))//"'")
   end subroutine put_text

   subroutine put_line(unit, name, value)
      integer, intent(in) :: unit
      character(len=*), intent(in) :: name, value
      integer :: status

      write (unit, '(a)', iostat=status) indent//name//' = '//value
   end subroutine put_line

   !> The text with every single quote doubled, as a quoted text needs it.
   pure function doubled_quotes(text) result(doubled)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: doubled
      integer :: i

      doubled = ''
      do i = 1, len(text)
         doubled = doubled//text(i:i)
         if (text(i:i) == "'") doubled = doubled//"'"
      end do
   end function doubled_quotes

end module deck_write_m
