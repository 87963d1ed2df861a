!> One run at a time in a directory: a file in it names the process that works there. What is left by a process that has gone is
!> recognised, as long as it ran on the same machine. Looking at a lock, taking a stale one away and making another are one step
!> for all that do so: the directory itself is locked for that long, by the system, which lets go of it whatever happens.
module lock_m
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr, c_size_t
   use errors_m, only: error_list_t
   use files_m, only: delete_file, file_exists, process_number
   use text_m, only: to_text
   implicit none
   private

   !> Name of the file
   character(len=*), parameter, public :: lock_name = 'run.lock'
   !> Longest name of a machine, longest line
   integer, parameter :: host_length = 256, line_length = 512
   !> flock: for one alone, waiting for it
   integer(c_int), parameter :: exclusive = 2_c_int
   !> How often the file is tried to be made, when others that are stale have been taken away
   integer, parameter :: most_trials = 3

   !> Who works in a directory
   type :: owner_t
      integer :: process = 0
      character(len=host_length) :: host = ''
      !> Date and time for the reader; when the process was started in units of the machine's clock ('': not known), which tells
      !> it from a later one of the same number
      character(len=32) :: since = '', clock = ''
   end type owner_t

   !> A lock, held or not
   type, public :: lock_t
      private
      character(len=:), allocatable :: path
   contains
      procedure :: take
      procedure :: release
   end type lock_t

   interface
      !> With signal 0: can the process be sent signals?
      integer(c_int) function c_kill(process, signal) bind(c, name='kill')
         import :: c_int
         integer(c_int), value :: process, signal
      end function c_kill

      !> A second name of a file; not 0 when that name is taken
      integer(c_int) function c_link(from, to) bind(c, name='link')
         import :: c_int, c_char
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function c_link

      type(c_ptr) function c_opendir(name) bind(c, name='opendir')
         import :: c_ptr, c_char
         character(kind=c_char), intent(in) :: name(*)
      end function c_opendir

      integer(c_int) function c_dirfd(directory) bind(c, name='dirfd')
         import :: c_int, c_ptr
         type(c_ptr), value :: directory
      end function c_dirfd

      integer(c_int) function c_closedir(directory) bind(c, name='closedir')
         import :: c_int, c_ptr
         type(c_ptr), value :: directory
      end function c_closedir

      !> Lock an open file or directory until it is closed
      integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
         import :: c_int
         integer(c_int), value :: descriptor, operation
      end function c_flock

      integer(c_int) function c_gethostname(name, length) bind(c, name='gethostname')
         import :: c_char, c_int, c_size_t
         character(kind=c_char), intent(out) :: name(*)
         integer(c_size_t), value :: length
      end function c_gethostname
   end interface

contains

   !> Lock a directory for this process. An error when another one works there.
   subroutine take(self, directory, note, errors)
      class(lock_t), intent(inout) :: self
      !> It exists and can be written to
      character(len=*), intent(in) :: directory
      !> What to tell of a lock that was left behind; '' when there was none
      character(len=:), allocatable, intent(out) :: note
      type(error_list_t), intent(inout) :: errors
      type(c_ptr) :: opened
      integer(c_int) :: ignored

      note = ''
      ! Between a look at a stale lock and its end another run could have taken it over. File systems that lock no directory
      ! have that gap of a millisecond
      opened = c_opendir(directory//c_null_char)
      if (c_associated(opened)) ignored = c_flock(c_dirfd(opened), exclusive)
      call take_alone()
      if (c_associated(opened)) ignored = c_closedir(opened)

   contains

      !> The same, while no other process does so.
      subroutine take_alone()
         type(owner_t) :: other
         character(len=:), allocatable :: path
         character(len=256) :: message
         integer :: trial, status
         logical :: made, there, goes_on

         message = ''
         path = directory//'/'//lock_name
         do trial = 1, most_trials
            call make_lock(path, made, status, message)
            if (made) self%path = path
            if (made) return
            there = file_exists(path)
            if (.not. there) exit
            other = owner_of(path)
            goes_on = is_at_work(other)
            if (goes_on) then
               call errors%add(directory//' is in use: '//owner_text(other)//' writes its results there ('//path// &
                               '); must be another directory (--output), or wait until it has ended')
               return
            end if
            if (.not. is_here(other)) exit
            note = 'lock      that of '//owner_text(other)//', which has gone, is taken over'
            call delete_file(path)
         end do
         there = file_exists(path)
         if (.not. there) then
            call errors%add(path//' cannot be made: '//trim(message))
         else if (other%process == 0) then
            call errors%add(path//' does not say whose it is; delete it if no run works in that directory')
         else
            call errors%add(directory//' is in use: '//owner_text(other)//' has locked it ('//path// &
                            '); whether that goes on cannot be seen from here: delete the file if it has ended')
         end if
      end subroutine take_alone

   end subroutine take

   !> Let others work in the directory.
   subroutine release(self)
      class(lock_t), intent(inout) :: self

      if (.not. allocated(self%path)) return
      call delete_file(self%path)
      deallocate (self%path)
   end subroutine release

   !> Make the file, if there is none: it is written under another name and gets its own in one step, which succeeds for one process
   !> only, so that a lock always says whose it is.
   subroutine make_lock(path, made, status, message)
      character(len=*), intent(in) :: path
      logical, intent(out) :: made
      !> 0, or why it could not be written
      integer, intent(out) :: status
      character(len=*), intent(inout) :: message
      type(owner_t) :: owner
      character(len=:), allocatable :: draft
      integer :: unit

      made = .false.
      owner = this_process()
      draft = path//'.'//to_text(owner%process)
      open (newunit=unit, file=draft, action='write', status='replace', iostat=status, iomsg=message)
      if (status /= 0) return
      write (unit, '(a)', iostat=status, iomsg=message) to_text(owner%process), trim(owner%host), trim(owner%since), &
         trim(owner%clock)
      if (status == 0) flush (unit, iostat=status, iomsg=message)
      if (status == 0) made = c_link(draft//c_null_char, path//c_null_char) == 0
      close (unit, status='delete', iostat=status)
   end subroutine make_lock

   !> This process.
   function this_process() result(owner)
      type(owner_t) :: owner
      character(len=:), allocatable :: clock
      integer :: now(8)
      logical :: ended

      owner%process = process_number()
      owner%host = host_name()
      call date_and_time(values=now)
      write (owner%since, '(i4.4,"-",i2.2,"-",i2.2," ",i2.2,":",i2.2,":",i2.2)') now(1:3), now(5:7)
      call ask_system(owner%process, clock, ended)
      owner%clock = clock
   end function this_process

   !> What a lock says; process 0 when it cannot be read.
   function owner_of(path) result(owner)
      character(len=*), intent(in) :: path
      type(owner_t) :: owner
      integer :: unit, status

      open (newunit=unit, file=path, action='read', status='old', iostat=status)
      if (status /= 0) return
      read (unit, *, iostat=status) owner%process
      if (status /= 0) owner%process = 0
      read (unit, '(a)', iostat=status) owner%host
      read (unit, '(a)', iostat=status) owner%since
      read (unit, '(a)', iostat=status) owner%clock
      close (unit, iostat=status)
   end function owner_of

   !> 'process 4711 on host (since 2026-01-31 12:00:00)'
   function owner_text(owner) result(text)
      type(owner_t), intent(in) :: owner
      character(len=:), allocatable :: text

      text = 'process '//to_text(owner%process)//' on '//trim(owner%host)//' (since '//trim(owner%since)//')'
   end function owner_text

   !> Does a process of this machine go on, and is it the one that is meant?
   logical function is_at_work(owner)
      type(owner_t), intent(in) :: owner
      character(len=:), allocatable :: clock
      logical :: ended

      is_at_work = is_here(owner)
      if (.not. is_at_work) return
      call ask_system(owner%process, clock, ended)
      is_at_work = c_kill(int(owner%process, c_int), 0_c_int) == 0
      ! Somebody else's process cannot be sent signals, but is there
      if (clock /= '') is_at_work = .not. ended
      if (clock /= '' .and. owner%clock /= '') is_at_work = is_at_work .and. clock == owner%clock
   end function is_at_work

   !> Was that a process of this machine?
   logical function is_here(owner)
      type(owner_t), intent(in) :: owner
      character(len=:), allocatable :: host

      host = host_name()
      is_here = owner%process > 0 .and. owner%host == host
   end function is_here

   !> What Linux tells of a process.
   subroutine ask_system(process, clock, ended)
      integer, intent(in) :: process
      !> When it was started; '' where that cannot be read
      character(len=:), allocatable, intent(out) :: clock
      !> Has it ended, with nobody yet who took note of it?
      logical, intent(out) :: ended
      !> Of the values behind the name of the program, the one that is the start; the first one is the state
      integer, parameter :: start = 20
      character(len=line_length) :: line
      character(len=32) :: value(start)
      integer :: unit, status

      clock = ''
      ended = .false.
      open (newunit=unit, file='/proc/'//to_text(process)//'/stat', action='read', status='old', iostat=status)
      if (status /= 0) return
      read (unit, '(a)', iostat=status) line
      if (status == 0) read (line(index(line, ')', back=.true.) + 1:), *, iostat=status) value
      if (status == 0) then
         clock = trim(value(start))
         ended = any(value(1) == ['Z', 'X'])
      end if
      close (unit, iostat=status)
   end subroutine ask_system

   !> Name of this machine.
   function host_name() result(name)
      character(len=:), allocatable :: name
      character(kind=c_char) :: letter(host_length)
      integer :: i

      name = ''
      letter = c_null_char
      if (c_gethostname(letter, int(host_length - 1, c_size_t)) /= 0) return
      do i = 1, host_length
         if (letter(i) == c_null_char) exit
         name = name//letter(i)
      end do
   end function host_name

end module lock_m
