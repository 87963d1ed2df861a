!> What Fortran does not offer for files: replacing one in a single step, and making a directory.
module files_m
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int32_t, c_null_char, c_null_ptr, &
                                                                             c_ptr, c_size_t
   use kinds_m, only: i8
   implicit none
   private

   public :: replace_file, make_directory, file_exists, delete_file, read_text, real_path, relative_path, process_number

   interface
      integer(c_int) function c_getpid() bind(c, name='getpid')
         import :: c_int
      end function c_getpid

      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_int, c_char
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function c_rename

      integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
         import :: c_int, c_int32_t, c_char
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int32_t), value :: mode
      end function c_mkdir

      type(c_ptr) function c_realpath(path, resolved) bind(c, name='realpath')
         import :: c_char, c_ptr
         character(kind=c_char), intent(in) :: path(*)
         type(c_ptr), value :: resolved
      end function c_realpath

      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: text
      end function c_strlen

      subroutine c_free(memory) bind(c, name='free')
         import :: c_ptr
         type(c_ptr), value :: memory
      end subroutine c_free
   end interface

contains

   !> Give a finished file its name, replacing the old file in one step: a reader sees the old one or the new one,
   !> and a kill loses neither.
   subroutine replace_file(from, to, status)
      !> Finished file, and the name it gets (same directory)
      character(len=*), intent(in) :: from, to
      !> 0 on success
      integer, intent(out) :: status

      status = int(c_rename(trim(from)//c_null_char, trim(to)//c_null_char))
   end subroutine replace_file

   !> Number of this process.
   integer function process_number()

      process_number = int(c_getpid())
   end function process_number

   !> Make a directory and those above it. It is no error when it exists already.
   subroutine make_directory(path, status)
      character(len=*), intent(in) :: path
      !> 0 when the directory is there afterwards and files can be made in it
      integer, intent(out) :: status
      !> Read, write and search for the user, read and search for the others (octal 755)
      integer(c_int32_t), parameter :: permissions = 493_c_int32_t
      integer(c_int) :: ignored
      character(len=16) :: number
      integer :: i, unit

      do i = 2, len_trim(path)
         if (path(i:i) /= '/') cycle
         ! An answer other than 0 mostly means 'exists': what counts is whether a file can be made at the end.
         ignored = c_mkdir(path(:i - 1)//c_null_char, permissions)
      end do
      ignored = c_mkdir(trim(path)//c_null_char, permissions)
      ! Another process may be trying the same
      write (number, '(i0)') process_number()
      open (newunit=unit, file=trim(path)//'/.write_test.'//trim(number), action='write', status='replace', iostat=status)
      if (status == 0) close (unit, status='delete', iostat=status)
   end subroutine make_directory

   !> The path of a file or directory from the root, without links and dots; empty when it is not there.
   function real_path(path) result(absolute)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: absolute
      character(kind=c_char), pointer :: letter(:)
      type(c_ptr) :: resolved
      integer :: i

      absolute = ''
      resolved = c_realpath(trim(path)//c_null_char, c_null_ptr)
      if (.not. c_associated(resolved)) return
      call c_f_pointer(resolved, letter, [int(c_strlen(resolved))])
      do i = 1, size(letter)
         absolute = absolute//letter(i)
      end do
      call c_free(resolved)
   end function real_path

   !> The way from a directory to a file, both as real_path gives them.
   pure function relative_path(path, directory) result(way)
      character(len=*), intent(in) :: path, directory
      character(len=:), allocatable :: way
      integer :: i, shared

      ! The path of both up to the last '/' they share
      shared = 0
      do i = 1, min(len(path), len(directory) + 1)
         if (path(i:i) == '/' .and. (i > len(directory))) shared = i
         if (i > len(directory)) exit
         if (path(i:i) /= directory(i:i)) exit
         if (path(i:i) == '/') shared = i
      end do
      way = path(shared + 1:)
      do i = shared + 1, len(directory)
         if (i == shared + 1 .or. directory(i:i) == '/') way = '../'//way
      end do
   end function relative_path

   !> Is there a file of this name?
   logical function file_exists(path)
      character(len=*), intent(in) :: path

      inquire (file=trim(path), exist=file_exists)
   end function file_exists

   !> Delete a file; it is no error when there is none.
   subroutine delete_file(path)
      character(len=*), intent(in) :: path
      integer :: unit, status

      if (.not. file_exists(path)) return
      open (newunit=unit, file=trim(path), status='old', iostat=status)
      if (status == 0) close (unit, status='delete', iostat=status)
   end subroutine delete_file

   !> The whole of a file, byte by byte.
   subroutine read_text(path, text, status, message)
      character(len=*), intent(in) :: path
      !> Content, line ends included; empty when the file cannot be read
      character(len=:), allocatable, intent(out) :: text
      !> 0 on success
      integer, intent(out) :: status
      !> Why it cannot be read, in the words of the system
      character(len=*), intent(out), optional :: message
      character(len=256) :: why
      integer(i8) :: length
      integer :: unit

      text = ''
      why = ''
      open (newunit=unit, file=trim(path), action='read', status='old', access='stream', form='unformatted', &
            iostat=status, iomsg=why)
      if (status == 0) then
         inquire (unit=unit, size=length)
         if (length > 0_i8) then
            deallocate (text)
            allocate (character(len=length) :: text)
            read (unit, iostat=status, iomsg=why) text
            if (status /= 0) text = ''
         end if
         close (unit)
      end if
      if (present(message)) message = why
   end subroutine read_text

end module files_m
