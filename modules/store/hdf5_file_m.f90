!> A thin layer over the HDF5 library: opening and closing files, and their groups.
!> The first failure is kept in the file, later calls then do nothing, and `close` hands it over: a writer is a plain
!> list of calls with one check at its end.
module hdf5_file_m
   use, intrinsic :: iso_c_binding, only: c_bool, c_int, c_int64_t, c_ptr, c_f_pointer
   use hdf5, only: hid_t, hsize_t, hobj_ref_t_f, h5open_f, h5iis_valid_f, h5eset_auto_f, h5fcreate_f, h5fopen_f, h5fclose_f, &
                   h5pcreate_f, h5pclose_f, h5gcreate_f, h5gclose_f, h5gn_members_f, h5gget_obj_info_idx_f, &
                   h5aexists_by_name_f, h5lexists_f, h5ldelete_f, h5rcreate_f, h5rdereference_f, h5ocopy_f, h5oclose_f, &
                   h5dont_atexit_f, h5fget_filesize_f, H5F_ACC_TRUNC_F, H5F_ACC_RDWR_F, H5F_ACC_RDONLY_F, H5P_FILE_ACCESS_F, &
                   H5T_NATIVE_DOUBLE
   use errors_m, only: error_list_t
   use kinds_m, only: i8
   use text_m, only: quoted
   implicit none
   private

   !> Longest name of a dataset or group when members are listed
   integer, parameter, public :: h5_name_length = 128

   !> An open HDF5 file
   type, public :: h5_open_file_t
      !> Number by which the library knows it (-1: not open)
      integer(hid_t) :: id = -1
      character(len=:), allocatable, private :: path
      !> First failure; unallocated while all is well
      character(len=:), allocatable, private :: failure
      !> Open for changes? Its size before them
      logical, private :: writable = .false.
      integer(hsize_t), private :: bytes_before = 0
   contains
      procedure :: create
      procedure :: open => open_file
      procedure :: reserve_room
      procedure :: close => close_file
      procedure :: failed
      procedure :: note
      procedure :: make_group
      procedure :: remove
      procedure :: has
      procedure :: has_attribute
      procedure :: members
      procedure :: refer
      procedure :: copy
   end type h5_open_file_t

   interface
      !> Not in the Fortran interface of HDF5 1.10
      integer(c_int) function c_set_file_locking(access, use_locks, ignore_when_disabled) bind(c, name='H5Pset_file_locking')
         import :: c_int, c_bool, c_int64_t
         integer(c_int64_t), value :: access
         logical(c_bool), value :: use_locks, ignore_when_disabled
      end function c_set_file_locking

      !> Address of the file descriptor of an open file
      integer(c_int) function c_get_vfd_handle(file, access, handle) bind(c, name='H5Fget_vfd_handle')
         import :: c_int, c_int64_t, c_ptr
         integer(c_int64_t), value :: file, access
         type(c_ptr), intent(out) :: handle
      end function c_get_vfd_handle

      !> Make sure that there is room on the disk for a part of a file
      integer(c_int) function c_posix_fallocate(descriptor, offset, length) bind(c, name='posix_fallocate')
         import :: c_int, c_int64_t
         integer(c_int), value :: descriptor
         integer(c_int64_t), value :: offset, length
      end function c_posix_fallocate
   end interface

contains

   !> Create a file, replacing an old one.
   subroutine create(self, path)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t) :: access
      integer :: status

      call prepare(self, path, access)
      self%writable = .true.
      self%bytes_before = 0
      if (self%failed()) return
      call h5fcreate_f(trim(path), H5F_ACC_TRUNC_F, self%id, status, access_prp=access)
      call self%note(status, 'cannot create the file')
      call h5pclose_f(access, status)
   end subroutine create

   !> Open an existing file.
   subroutine open_file(self, path, writable)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> For changes too, not for reading alone
      logical, intent(in) :: writable
      integer(hid_t) :: access
      integer :: status

      call prepare(self, path, access)
      self%writable = writable
      if (self%failed()) return
      call h5fopen_f(trim(path), merge(H5F_ACC_RDWR_F, H5F_ACC_RDONLY_F, writable), self%id, status, access_prp=access)
      call self%note(status, 'cannot open the file (missing, cut short or not HDF5)')
      call h5pclose_f(access, status)
      if (self%failed()) return
      call h5fget_filesize_f(self%id, self%bytes_before, status)
      call self%note(status, 'cannot find the size of the file')
   end subroutine open_file

   !> Start the library and make the access properties: no locks, so that somebody looking at the results
   !> (ParaView keeps them open) cannot stop the run.
   subroutine prepare(self, path, access)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t), intent(out) :: access
      integer :: status
      logical :: started

      self%path = trim(path)
      if (allocated(self%failure)) deallocate (self%failure)
      ! What could not be written to a full disk must not be tried again at the end of the program: the library would crash. (The
      ! answer is an error when this has been said before.)
      call h5dont_atexit_f(status)
      ! Starting it again would make its types anew and leave the old ones in memory.
      call h5iis_valid_f(H5T_NATIVE_DOUBLE, started, status)
      if (.not. started) call h5open_f(status)
      call self%note(status, 'cannot start the HDF5 library')
      ! Failures are reported by this module, not by the library on the screen.
      call h5eset_auto_f(0, status)
      call h5pcreate_f(H5P_FILE_ACCESS_F, access, status)
      call self%note(status, 'cannot make the access properties')
      status = int(c_set_file_locking(access, .false._c_bool, .true._c_bool))
      call self%note(status, 'cannot turn off file locking')
   end subroutine prepare

   !> Close the file; the first failure since it was opened goes to the list. A file in which something could not be written stays
   !> as it was: the library keeps its directory in memory until the file is closed, and what has been added lies behind its end.
   subroutine close_file(self, errors)
      class(h5_open_file_t), intent(inout) :: self
      type(error_list_t), intent(inout) :: errors
      integer :: status

      if (self%id >= 0) then
         if (self%writable) call self%reserve_room()
         if (.not. (self%writable .and. self%failed())) then
            call h5fclose_f(self%id, status)
            call self%note(status, 'cannot close the file (disk full?)')
         end if
      end if
      self%id = -1
      if (allocated(self%failure)) call errors%add(self%failure)
   end subroutine close_file

   !> Room on the disk for all of the file, so that closing it, which overwrites its directory, cannot fail half-way.
   subroutine reserve_room(self)
      class(h5_open_file_t), intent(inout) :: self
      integer(hsize_t) :: bytes
      integer(c_int), pointer :: descriptor
      type(c_ptr) :: handle
      integer :: status

      if (self%failed()) return
      call h5fget_filesize_f(self%id, bytes, status)
      call self%note(status, 'cannot find the size of the file')
      if (self%failed()) return
      ! Property list 0 is the default one of C
      status = int(c_get_vfd_handle(int(self%id, c_int64_t), 0_c_int64_t, handle))
      call self%note(status, 'cannot find the descriptor of the file')
      if (self%failed()) return
      call c_f_pointer(handle, descriptor)
      bytes = max(1_hsize_t, bytes - self%bytes_before)
      status = int(c_posix_fallocate(descriptor, int(self%bytes_before, c_int64_t), int(bytes, c_int64_t)))
      if (status /= 0) call self%note(-1, 'no room for what is to be written (disk full?)')
   end subroutine reserve_room

   !> Has anything gone wrong since the file was opened?
   pure logical function failed(self)
      class(h5_open_file_t), intent(in) :: self

      failed = allocated(self%failure)
   end function failed

   !> Keep the first failure.
   subroutine note(self, status, what)
      class(h5_open_file_t), intent(inout) :: self
      !> Answer of an HDF5 call, negative on failure
      integer, intent(in) :: status
      character(len=*), intent(in) :: what

      if (status < 0 .and. .not. allocated(self%failure)) self%failure = self%path//': '//what
   end subroutine note

   subroutine make_group(self, path)
      class(h5_open_file_t), intent(inout) :: self
      !> Full path of the group, those above it exist
      character(len=*), intent(in) :: path
      integer(hid_t) :: group
      integer :: status

      if (self%failed()) return
      call h5gcreate_f(self%id, trim(path), group, status)
      call self%note(status, 'cannot make the group '//quoted(path))
      if (status >= 0) call h5gclose_f(group, status)
   end subroutine make_group

   !> Remove a dataset, or a group with all in it.
   subroutine remove(self, path)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer :: status

      if (self%failed()) return
      call h5ldelete_f(self%id, trim(path), status)
      call self%note(status, 'cannot remove '//quoted(path))
   end subroutine remove

   !> Is there a dataset or group of this path? (Those above it must exist.)
   logical function has(self, path)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer :: status

      has = .false.
      if (self%failed()) return
      call h5lexists_f(self%id, trim(path), has, status)
      if (status < 0) has = .false.
   end function has

   logical function has_attribute(self, path, name)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      integer :: status

      has_attribute = .false.
      if (self%failed()) return
      call h5aexists_by_name_f(self%id, trim(path), trim(name), has_attribute, status)
      if (status < 0) has_attribute = .false.
   end function has_attribute

   !> Names of all datasets and groups in a group, in alphabetical order.
   subroutine members(self, path, name)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      character(len=h5_name_length), allocatable, intent(out) :: name(:)
      integer :: n, i, kind, status

      n = 0
      if (.not. self%failed()) then
         call h5gn_members_f(self%id, trim(path), n, status)
         call self%note(status, 'cannot list '//quoted(path))
         if (status < 0) n = 0
      end if
      allocate (name(n))
      do i = 1, n
         call h5gget_obj_info_idx_f(self%id, trim(path), i - 1, name(i), kind, status)
         call self%note(status, 'cannot list '//quoted(path))
      end do
   end subroutine members

   !> The library's reference to a group, by which it is found without the directory of the file as long as it stays.
   subroutine refer(self, path, reference)
      class(h5_open_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(i8), intent(out) :: reference
      type(hobj_ref_t_f) :: object
      integer :: status

      reference = 0_i8
      if (self%failed()) return
      call h5rcreate_f(self%id, trim(path), object, status)
      call self%note(status, 'cannot refer to '//quoted(path))
      if (status >= 0) reference = int(object%ref, i8)
   end subroutine refer

   !> Copy a group of another open file, with all in it, from its reference there.
   subroutine copy(self, from, reference, path)
      class(h5_open_file_t), intent(inout) :: self
      class(h5_open_file_t), intent(in) :: from
      integer(i8), intent(in) :: reference
      !> Full path that it gets; the groups above it exist
      character(len=*), intent(in) :: path
      type(hobj_ref_t_f) :: object
      integer(hid_t) :: group
      integer :: status, closed

      if (self%failed()) return
      object%ref = reference
      call h5rdereference_f(from%id, object, group, status)
      call self%note(status, 'cannot find '//quoted(path)//' in '//from%path)
      if (status < 0) return
      call h5ocopy_f(group, '.', self%id, trim(path), status)
      call self%note(status, 'cannot copy '//quoted(path)//' of '//from%path)
      call h5oclose_f(group, closed)
   end subroutine copy

end module hdf5_file_m
