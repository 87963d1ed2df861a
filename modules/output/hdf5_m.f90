!> A thin layer over the HDF5 library: files in which every dataset has a unit and a description.
!> The first failure is kept in the file, later calls then do nothing, and `close` hands it over: a writer is a plain
!> list of calls with one check at its end.
module hdf5_m
   use, intrinsic :: iso_c_binding, only: c_bool, c_char, c_int, c_int64_t, c_loc, c_null_char, c_ptr, c_f_pointer, &
                                                                             c_size_t, c_associated
   use hdf5, only: hid_t, hsize_t, h5open_f, h5iis_valid_f, h5eset_auto_f, h5fcreate_f, h5fopen_f, h5fclose_f, &
                   h5pcreate_f, h5pclose_f, h5pset_chunk_f, h5pset_deflate_f, h5pset_shuffle_f, h5screate_f, &
                   h5screate_simple_f, h5sclose_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, &
                   h5dcreate_f, h5dopen_f, h5dwrite_f, h5dread_f, h5dclose_f, h5dget_space_f, h5gcreate_f, &
                   h5gclose_f, h5gn_members_f, h5gget_obj_info_idx_f, h5acreate_by_name_f, h5aopen_by_name_f, &
                   h5aexists_by_name_f, h5awrite_f, h5aread_f, h5aclose_f, h5lexists_f, h5ldelete_f, &
                   h5dont_atexit_f, h5fget_filesize_f, &
                   h5kind_to_type, H5_INTEGER_KIND, H5S_SCALAR_F, H5F_ACC_TRUNC_F, H5F_ACC_RDWR_F, &
                   H5F_ACC_RDONLY_F, H5P_FILE_ACCESS_F, H5P_DATASET_CREATE_F, H5T_NATIVE_DOUBLE, &
                   H5T_NATIVE_INTEGER, H5T_STRING
   use errors_m, only: error_list_t
   use kinds_m, only: wp, i8
   use text_m, only: to_text, quoted
   implicit none
   private

   !> Longest name of a dataset or group when members are listed
   integer, parameter, public :: h5_name_length = 128
   !> Arrays with at least this many values are compressed; smaller ones are not worth the bookkeeping
   integer, parameter :: compress_from = 1000
   !> Effort of the compression (1 fast - 9 small): most of the gain comes with the first level
   integer, parameter :: deflate_level = 4

   !> An open HDF5 file
   type, public :: h5_file_t
      private
      integer(hid_t) :: id = -1
      character(len=:), allocatable :: path
      !> First failure; unallocated while all is well
      character(len=:), allocatable :: failure
      !> Open for changes? Its size before them
      logical :: writable = .false.
      integer(hsize_t) :: bytes_before = 0
   contains
      procedure :: create
      procedure :: open => open_file
      procedure :: close => close_file
      procedure :: failed
      procedure :: make_group
      procedure :: remove
      procedure :: has
      procedure :: has_attribute
      procedure :: members
      procedure, private :: write_real_1, write_real_2, write_integer_1, write_integer_2, write_text_1
      !> write(path, value, unit, description): a dataset of rank 1 or 2
      generic :: write => write_real_1, write_real_2, write_integer_1, write_integer_2, write_text_1
      procedure, private :: read_real_1, read_real_2, read_integer_1, read_integer_2
      !> read(path, value): value is allocated to the dataset's shape
      generic :: read => read_real_1, read_real_2, read_integer_1, read_integer_2
      procedure, private :: put_text, put_real, put_integer, put_long
      !> put(path, name, value): an attribute of a dataset or group
      generic :: put => put_text, put_real, put_integer, put_long
      procedure, private :: get_text, get_real, get_integer, get_long
      !> get(path, name, value): read an attribute
      generic :: get => get_text, get_real, get_integer, get_long
      procedure, private :: note
   end type h5_file_t

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

      pure integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_size_t, c_ptr
         type(c_ptr), value, intent(in) :: text
      end function c_strlen
   end interface

contains

   !> Create a file, replacing an old one.
   subroutine create(self, path)
      class(h5_file_t), intent(inout) :: self
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
      class(h5_file_t), intent(inout) :: self
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
      class(h5_file_t), intent(inout) :: self
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
      class(h5_file_t), intent(inout) :: self
      type(error_list_t), intent(inout) :: errors
      integer :: status

      if (self%id >= 0) then
         if (self%writable) call reserve_room(self)
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
      class(h5_file_t), intent(inout) :: self
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
      class(h5_file_t), intent(in) :: self

      failed = allocated(self%failure)
   end function failed

   !> Keep the first failure.
   subroutine note(self, status, what)
      class(h5_file_t), intent(inout) :: self
      !> Answer of an HDF5 call, negative on failure
      integer, intent(in) :: status
      character(len=*), intent(in) :: what

      if (status < 0 .and. .not. allocated(self%failure)) self%failure = self%path//': '//what
   end subroutine note

   subroutine make_group(self, path)
      class(h5_file_t), intent(inout) :: self
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
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer :: status

      if (self%failed()) return
      call h5ldelete_f(self%id, trim(path), status)
      call self%note(status, 'cannot remove '//quoted(path))
   end subroutine remove

   !> Is there a dataset or group of this path? (Those above it must exist.)
   logical function has(self, path)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer :: status

      has = .false.
      if (self%failed()) return
      call h5lexists_f(self%id, trim(path), has, status)
      if (status < 0) has = .false.
   end function has

   logical function has_attribute(self, path, name)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      integer :: status

      has_attribute = .false.
      if (self%failed()) return
      call h5aexists_by_name_f(self%id, trim(path), trim(name), has_attribute, status)
      if (status < 0) has_attribute = .false.
   end function has_attribute

   !> Names of all datasets and groups in a group, in alphabetical order.
   subroutine members(self, path, name)
      class(h5_file_t), intent(inout) :: self
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

   ! ---- Datasets ----------------------------------------------------------------------------------------------------

   !> Create a dataset, compressed when it is large.
   subroutine start_dataset(self, path, type, dims, dataset)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t), intent(in) :: type
      integer(hsize_t), intent(in) :: dims(:)
      integer(hid_t), intent(out) :: dataset
      integer(hid_t) :: space, properties
      integer :: status

      dataset = -1
      call h5screate_simple_f(size(dims), dims, space, status)
      call self%note(status, 'cannot make the shape of '//quoted(path))
      call h5pcreate_f(H5P_DATASET_CREATE_F, properties, status)
      if (product(dims) >= compress_from) then
         call h5pset_chunk_f(properties, size(dims), dims, status)
         call self%note(status, 'cannot set the chunks of '//quoted(path))
         call h5pset_shuffle_f(properties, status)
         call h5pset_deflate_f(properties, deflate_level, status)
         call self%note(status, 'cannot compress '//quoted(path))
      end if
      if (.not. self%failed()) then
         call h5dcreate_f(self%id, trim(path), type, space, dataset, status, dcpl_id=properties)
         call self%note(status, 'cannot create the dataset '//quoted(path))
      end if
      call h5pclose_f(properties, status)
      call h5sclose_f(space, status)
   end subroutine start_dataset

   !> Close a dataset that has been written and say what it holds.
   subroutine finish_dataset(self, path, dataset, written, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t), intent(in) :: dataset
      !> Answer of the write
      integer, intent(in) :: written
      character(len=*), intent(in) :: unit, description
      integer :: status

      call self%note(written, 'cannot write '//quoted(path)//' (disk full?)')
      call h5dclose_f(dataset, status)
      call self%note(status, 'cannot write '//quoted(path)//' to its end (disk full?)')
      call self%put(path, 'unit', unit)
      call self%put(path, 'description', description)
   end subroutine finish_dataset

   subroutine write_real_1(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      real(wp), intent(in) :: value(:)
      !> Unit ('1' for a pure number) and meaning
      character(len=*), intent(in) :: unit, description
      integer(hid_t) :: dataset
      integer :: status

      if (self%failed()) return
      call start_dataset(self, path, H5T_NATIVE_DOUBLE, shape(value, hsize_t), dataset)
      if (self%failed()) return
      call h5dwrite_f(dataset, H5T_NATIVE_DOUBLE, value, shape(value, hsize_t), status)
      call finish_dataset(self, path, dataset, status, unit, description)
   end subroutine write_real_1

   subroutine write_real_2(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      real(wp), intent(in) :: value(:, :)
      character(len=*), intent(in) :: unit, description
      integer(hid_t) :: dataset
      integer :: status

      if (self%failed()) return
      call start_dataset(self, path, H5T_NATIVE_DOUBLE, shape(value, hsize_t), dataset)
      if (self%failed()) return
      call h5dwrite_f(dataset, H5T_NATIVE_DOUBLE, value, shape(value, hsize_t), status)
      call finish_dataset(self, path, dataset, status, unit, description)
   end subroutine write_real_2

   subroutine write_integer_1(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer, intent(in) :: value(:)
      character(len=*), intent(in) :: unit, description
      integer(hid_t) :: dataset
      integer :: status

      if (self%failed()) return
      call start_dataset(self, path, H5T_NATIVE_INTEGER, shape(value, hsize_t), dataset)
      if (self%failed()) return
      call h5dwrite_f(dataset, H5T_NATIVE_INTEGER, value, shape(value, hsize_t), status)
      call finish_dataset(self, path, dataset, status, unit, description)
   end subroutine write_integer_1

   subroutine write_integer_2(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer, intent(in) :: value(:, :)
      character(len=*), intent(in) :: unit, description
      integer(hid_t) :: dataset
      integer :: status

      if (self%failed()) return
      call start_dataset(self, path, H5T_NATIVE_INTEGER, shape(value, hsize_t), dataset)
      if (self%failed()) return
      call h5dwrite_f(dataset, H5T_NATIVE_INTEGER, value, shape(value, hsize_t), status)
      call finish_dataset(self, path, dataset, status, unit, description)
   end subroutine write_integer_2

   !> A list of texts, trimmed.
   subroutine write_text_1(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: value(:)
      character(len=*), intent(in) :: unit, description
      character(kind=c_char, len=len(value) + 1), allocatable, target :: buffer(:)
      type(c_ptr), allocatable, target :: address(:)
      integer(hid_t) :: dataset
      integer :: status, i

      if (self%failed()) return
      allocate (buffer(size(value)), address(size(value)))
      do i = 1, size(value)
         buffer(i) = trim(value(i))//c_null_char
         address(i) = c_loc(buffer(i) (1:1))
      end do
      call start_dataset(self, path, H5T_STRING, shape(value, hsize_t), dataset)
      if (self%failed()) return
      status = 0
      if (size(value) > 0) call h5dwrite_f(dataset, H5T_STRING, c_loc(address), status)
      call finish_dataset(self, path, dataset, status, unit, description)
   end subroutine write_text_1

   !> Open a dataset for reading and check its rank.
   subroutine find_dataset(self, path, rank, dataset, dims)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Rank expected
      integer, intent(in) :: rank
      integer(hid_t), intent(out) :: dataset
      !> Shape (rank); zero on failure
      integer(hsize_t), intent(out) :: dims(:)
      integer(hsize_t) :: largest(size(dims))
      integer(hid_t) :: space
      integer :: status, found

      dims = 0
      dataset = -1
      if (self%failed()) return
      call h5dopen_f(self%id, trim(path), dataset, status)
      call self%note(status, 'there is no dataset '//quoted(path))
      if (self%failed()) return
      call h5dget_space_f(dataset, space, status)
      call h5sget_simple_extent_ndims_f(space, found, status)
      if (found == rank) then
         call h5sget_simple_extent_dims_f(space, dims, largest, status)
      else
         call self%note(-1, quoted(path)//' has rank '//to_text(found)//', expected '//to_text(rank))
         call h5dclose_f(dataset, status)
      end if
      call h5sclose_f(space, status)
   end subroutine find_dataset

   subroutine end_reading(self, path, dataset, was_read)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t), intent(in) :: dataset
      !> Answer of the read
      integer, intent(in) :: was_read
      integer :: status

      call self%note(was_read, 'cannot read '//quoted(path))
      call h5dclose_f(dataset, status)
   end subroutine end_reading

   subroutine read_real_1(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Empty on failure
      real(wp), allocatable, intent(out) :: value(:)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(1)
      integer :: status

      call find_dataset(self, path, 1, dataset, dims)
      allocate (value(dims(1)))
      if (self%failed()) return
      call h5dread_f(dataset, H5T_NATIVE_DOUBLE, value, dims, status)
      call end_reading(self, path, dataset, status)
   end subroutine read_real_1

   subroutine read_real_2(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      real(wp), allocatable, intent(out) :: value(:, :)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(2)
      integer :: status

      call find_dataset(self, path, 2, dataset, dims)
      allocate (value(dims(1), dims(2)))
      if (self%failed()) return
      call h5dread_f(dataset, H5T_NATIVE_DOUBLE, value, dims, status)
      call end_reading(self, path, dataset, status)
   end subroutine read_real_2

   subroutine read_integer_1(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer, allocatable, intent(out) :: value(:)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(1)
      integer :: status

      call find_dataset(self, path, 1, dataset, dims)
      allocate (value(dims(1)))
      if (self%failed()) return
      call h5dread_f(dataset, H5T_NATIVE_INTEGER, value, dims, status)
      call end_reading(self, path, dataset, status)
   end subroutine read_integer_1

   subroutine read_integer_2(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer, allocatable, intent(out) :: value(:, :)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(2)
      integer :: status

      call find_dataset(self, path, 2, dataset, dims)
      allocate (value(dims(1), dims(2)))
      if (self%failed()) return
      call h5dread_f(dataset, H5T_NATIVE_INTEGER, value, dims, status)
      call end_reading(self, path, dataset, status)
   end subroutine read_integer_2

   ! ---- Attributes --------------------------------------------------------------------------------------------------

   !> Write one value as an attribute.
   subroutine put_value(self, path, name, type, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      integer(hid_t), intent(in) :: type
      !> Address of the value
      type(c_ptr), intent(in) :: value
      integer(hid_t) :: space, attribute
      integer :: status, ignored

      if (self%failed()) return
      call h5screate_f(H5S_SCALAR_F, space, status)
      call h5acreate_by_name_f(self%id, trim(path), trim(name), type, space, attribute, status)
      call self%note(status, 'cannot create the attribute '//quoted(name)//' of '//quoted(path))
      if (status >= 0) then
         call h5awrite_f(attribute, type, value, status)
         call self%note(status, 'cannot write the attribute '//quoted(name)//' of '//quoted(path))
         call h5aclose_f(attribute, ignored)
      end if
      call h5sclose_f(space, ignored)
   end subroutine put_value

   subroutine put_text(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name, value
      character(kind=c_char, len=:), allocatable, target :: buffer
      type(c_ptr), target :: address

      buffer = trim(value)//c_null_char
      address = c_loc(buffer)
      call put_value(self, path, name, H5T_STRING, c_loc(address))
   end subroutine put_text

   subroutine put_real(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      real(wp), intent(in) :: value
      real(wp), target :: copy

      copy = value
      call put_value(self, path, name, H5T_NATIVE_DOUBLE, c_loc(copy))
   end subroutine put_real

   subroutine put_integer(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      integer, intent(in) :: value
      integer, target :: copy

      copy = value
      call put_value(self, path, name, H5T_NATIVE_INTEGER, c_loc(copy))
   end subroutine put_integer

   subroutine put_long(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      integer(i8), intent(in) :: value
      integer(i8), target :: copy

      copy = value
      call put_value(self, path, name, h5kind_to_type(i8, H5_INTEGER_KIND), c_loc(copy))
   end subroutine put_long

   !> Read one value from an attribute; the value is left alone on failure.
   subroutine get_value(self, path, name, type, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      integer(hid_t), intent(in) :: type
      !> Address to read into
      type(c_ptr), intent(inout) :: value
      integer(hid_t) :: attribute
      integer :: status, ignored

      if (self%failed()) return
      call h5aopen_by_name_f(self%id, trim(path), trim(name), attribute, status)
      call self%note(status, quoted(path)//' has no attribute '//quoted(name))
      if (status < 0) return
      call h5aread_f(attribute, type, value, status)
      call self%note(status, 'cannot read the attribute '//quoted(name)//' of '//quoted(path))
      call h5aclose_f(attribute, ignored)
   end subroutine get_value

   subroutine get_text(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      !> Empty on failure
      character(len=:), allocatable, intent(out) :: value
      character(kind=c_char), pointer :: letter(:)
      type(c_ptr), target :: address
      type(c_ptr) :: to
      integer :: i

      value = ''
      to = c_loc(address)
      call get_value(self, path, name, H5T_STRING, to)
      if (self%failed()) return
      if (.not. c_associated(address)) return
      call c_f_pointer(address, letter, [int(c_strlen(address))])
      deallocate (value)
      allocate (character(len=size(letter)) :: value)
      do i = 1, size(letter)
         value(i:i) = letter(i)
      end do
   end subroutine get_text

   subroutine get_real(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      !> 0 on failure
      real(wp), intent(out) :: value
      real(wp), target :: copy
      type(c_ptr) :: to

      copy = 0.0_wp
      to = c_loc(copy)
      call get_value(self, path, name, H5T_NATIVE_DOUBLE, to)
      value = copy
   end subroutine get_real

   subroutine get_integer(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      !> 0 on failure
      integer, intent(out) :: value
      integer, target :: copy
      type(c_ptr) :: to

      copy = 0
      to = c_loc(copy)
      call get_value(self, path, name, H5T_NATIVE_INTEGER, to)
      value = copy
   end subroutine get_integer

   subroutine get_long(self, path, name, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path, name
      !> 0 on failure
      integer(i8), intent(out) :: value
      integer(i8), target :: copy
      type(c_ptr) :: to

      copy = 0_i8
      to = c_loc(copy)
      call get_value(self, path, name, h5kind_to_type(i8, H5_INTEGER_KIND), to)
      value = copy
   end subroutine get_long

end module hdf5_m
