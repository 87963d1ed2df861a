!> Groups of an HDF5 file that are complete: no kill while the file is changed may lose them.
!>
!> The library adds to a file behind its end, and overwrites the directory at its start when it is closed, in several writes. A
!> kill between two of them leaves a file that cannot be read, though all groups that were complete are in it, where they were.
!> While the file is closed a list therefore stands beside it (its path with '.writing') of these groups and the references by
!> which the library finds them without the directory. A list that is there when a run goes on is that of a file left half-way:
!> its groups are copied to a new file (copy_complete).
module complete_groups_m
   use errors_m, only: error_list_t
   use files_m, only: delete_file, file_exists, read_text, replace_file
   use hdf5_m, only: h5_file_t, h5_name_length
   use kinds_m, only: i8
   use text_m, only: quoted
   implicit none
   private

   public :: was_left, copy_complete, forget_left

   !> Groups of a file
   type, public :: complete_groups_t
      private
      !> Path of each group and the library's reference to it (groups)
      character(len=h5_name_length), allocatable :: name(:)
      integer(i8), allocatable :: reference(:)
   contains
      procedure :: count => count_groups
      procedure :: add
      procedure :: announce
      procedure :: close => close_file
   end type complete_groups_t

   character(len=*), parameter :: suffix = '.writing'
   !> Line of the list: reference, path of the group
   character(len=*), parameter :: line_format = '(i20, 1x, a)'

contains

   !> How many there are.
   pure integer function count_groups(self) result(number)
      class(complete_groups_t), intent(in) :: self

      number = 0
      if (allocated(self%name)) number = size(self%name)
   end function count_groups

   !> One more group of an open file, complete when that has been closed.
   subroutine add(self, file, name)
      class(complete_groups_t), intent(inout) :: self
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name
      character(len=h5_name_length) :: new
      integer(i8) :: reference

      call file%refer(name, reference)
      if (file%failed()) return
      if (.not. allocated(self%name)) allocate (self%name(0), self%reference(0))
      new = name
      self%name = [self%name, new]
      self%reference = [self%reference, reference]
   end subroutine add

   !> Close a file that has been changed. A kill while the library does so loses none of these groups.
   subroutine close_file(self, file, path, errors)
      class(complete_groups_t), intent(in) :: self
      type(h5_file_t), intent(inout) :: file
      !> Of the file
      character(len=*), intent(in) :: path
      type(error_list_t), intent(inout) :: errors
      integer :: before
      logical :: begun

      before = errors%count()
      call file%reserve_room()
      call self%announce(file, path)
      ! What could not be made room for is not begun
      begun = .not. file%failed()
      call file%close(errors)
      if (.not. begun .or. errors%count() == before) call forget_left(path)
   end subroutine close_file

   !> Write the list that tells of a file which is being closed; it has its name when it is complete.
   subroutine announce(self, file, path)
      class(complete_groups_t), intent(in) :: self
      !> Notes what goes wrong, and then is not changed
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      integer :: unit, i, status

      if (file%failed()) return
      open (newunit=unit, file=path//suffix//'.part', action='write', status='replace', iostat=status)
      if (status == 0) then
         do i = 1, self%count()
            write (unit, line_format, iostat=status) self%reference(i), trim(self%name(i))
            if (status /= 0) exit
         end do
         if (status == 0) flush (unit, iostat=status)
         if (status == 0) then
            close (unit, iostat=status)
         else
            close (unit, status='delete')
         end if
      end if
      if (status == 0) call replace_file(path//suffix//'.part', path//suffix, status)
      if (status /= 0) call file%note(-1, 'the list of what is complete in it cannot be written (disk full?)')
   end subroutine announce

   !> Has a kill left a file while it was closed?
   logical function was_left(path)
      character(len=*), intent(in) :: path

      was_left = file_exists(path//suffix)
      if (was_left) was_left = file_exists(path)
   end function was_left

   !> Copy the groups that were complete in a file when it was left to a new one, which notes what goes wrong.
   subroutine copy_complete(path, new)
      !> Of the file that was left
      character(len=*), intent(in) :: path
      !> Open for writing
      type(h5_file_t), intent(inout) :: new
      type(h5_file_t) :: left
      type(error_list_t) :: damage
      character(len=:), allocatable :: list
      character(len=h5_name_length) :: name
      integer(i8) :: reference
      integer :: at, length, status

      call read_text(path//suffix, list, status)
      if (status /= 0) call new%note(-1, 'the list '//quoted(path//suffix)//' cannot be read')
      call left%open(path, writable=.false.)
      at = 1
      do while (at <= len(list) .and. .not. left%failed())
         length = index(list(at:), new_line('a'))
         if (length == 0) length = len(list) - at + 2
         read (list(at:at + length - 2), line_format, iostat=status) reference, name
         if (status /= 0) call new%note(-1, 'the list '//quoted(path//suffix)//' is damaged')
         if (new%failed()) exit
         call new%copy(left, reference, trim(name))
         at = at + length
      end do
      call left%close(damage)
      if (damage%any()) call new%note(-1, damage%text(1))
   end subroutine copy_complete

   !> The file has been seen to: it is no longer one that was left.
   subroutine forget_left(path)
      character(len=*), intent(in) :: path

      call delete_file(path//suffix)
   end subroutine forget_left

end module complete_groups_m
