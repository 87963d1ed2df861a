!> Datasets and attributes of HDF5 files: every dataset has a unit and a description.
module hdf5_m
   use, intrinsic :: iso_c_binding, only: c_char, c_loc, c_null_char, c_ptr, c_f_pointer, c_size_t, c_associated
   use hdf5, only: hid_t, hsize_t, h5pcreate_f, h5pclose_f, h5pset_chunk_f, h5pset_deflate_f, h5pset_shuffle_f, h5screate_f, &
                   h5screate_simple_f, h5sclose_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, h5dcreate_f, &
                   h5dopen_f, h5dwrite_f, h5dread_f, h5dclose_f, h5dget_space_f, h5acreate_by_name_f, h5aopen_by_name_f, &
                   h5awrite_f, h5aread_f, h5aclose_f, h5kind_to_type, H5_INTEGER_KIND, H5S_SCALAR_F, H5P_DATASET_CREATE_F, &
                   H5T_NATIVE_DOUBLE, H5T_NATIVE_INTEGER, H5T_STRING
   use hdf5_file_m, only: h5_open_file_t, h5_name_length
   use kinds_m, only: wp, i8
   use text_m, only: to_text, quoted
   implicit none
   private

   public :: h5_name_length

   !> Arrays with at least this many values are compressed; smaller ones are not worth the bookkeeping
   integer, parameter :: compress_from = 1000
   !> Effort of the compression (1 fast - 9 small): most of the gain comes with the first level
   integer, parameter :: deflate_level = 4

   !> An open HDF5 file with what is in it
   type, extends(h5_open_file_t), public :: h5_file_t
   contains
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
   end type h5_file_t

   interface
      pure integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_size_t, c_ptr
         type(c_ptr), value, intent(in) :: text
      end function c_strlen
   end interface

contains

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

   !> Write a dataset, and say what it holds.
   subroutine write_values(self, path, type, dims, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t), intent(in) :: type
      integer(hsize_t), intent(in) :: dims(:)
      !> Address of the values
      type(c_ptr), intent(in) :: value
      !> Unit ('1' for a pure number) and meaning
      character(len=*), intent(in) :: unit, description
      integer(hid_t) :: dataset
      integer :: status

      if (self%failed()) return
      call start_dataset(self, path, type, dims, dataset)
      if (self%failed()) return
      if (product(dims) > 0) call h5dwrite_f(dataset, type, value, status)
      if (product(dims) > 0) call self%note(status, 'cannot write '//quoted(path)//' (disk full?)')
      call h5dclose_f(dataset, status)
      call self%note(status, 'cannot write '//quoted(path)//' to its end (disk full?)')
      call self%put(path, 'unit', unit)
      call self%put(path, 'description', description)
   end subroutine write_values

   subroutine write_real_1(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      real(wp), contiguous, intent(in), target :: value(:)
      character(len=*), intent(in) :: path, unit, description

      call write_values(self, path, H5T_NATIVE_DOUBLE, shape(value, hsize_t), c_loc(value), unit, description)
   end subroutine write_real_1

   subroutine write_real_2(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      real(wp), contiguous, intent(in), target :: value(:, :)
      character(len=*), intent(in) :: path, unit, description

      call write_values(self, path, H5T_NATIVE_DOUBLE, shape(value, hsize_t), c_loc(value), unit, description)
   end subroutine write_real_2

   subroutine write_integer_1(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      integer, contiguous, intent(in), target :: value(:)
      character(len=*), intent(in) :: path, unit, description

      call write_values(self, path, H5T_NATIVE_INTEGER, shape(value, hsize_t), c_loc(value), unit, description)
   end subroutine write_integer_1

   subroutine write_integer_2(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      integer, contiguous, intent(in), target :: value(:, :)
      character(len=*), intent(in) :: path, unit, description

      call write_values(self, path, H5T_NATIVE_INTEGER, shape(value, hsize_t), c_loc(value), unit, description)
   end subroutine write_integer_2

   !> A list of texts, trimmed.
   subroutine write_text_1(self, path, value, unit, description)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: value(:)
      character(len=*), intent(in) :: unit, description
      character(kind=c_char, len=len(value) + 1), allocatable, target :: buffer(:)
      type(c_ptr), allocatable, target :: address(:)
      integer :: i

      if (self%failed()) return
      allocate (buffer(size(value)), address(size(value)))
      do i = 1, size(value)
         buffer(i) = trim(value(i))//c_null_char
         address(i) = c_loc(buffer(i) (1:1))
      end do
      call write_values(self, path, H5T_STRING, shape(value, hsize_t), c_loc(address), unit, description)
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

   !> Read a dataset that has been found, and close it.
   subroutine read_values(self, path, dataset, type, dims, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer(hid_t), intent(in) :: dataset, type
      integer(hsize_t), intent(in) :: dims(:)
      !> Address to read into
      type(c_ptr), intent(in) :: value
      type(c_ptr) :: to
      integer :: status

      if (self%failed()) return
      to = value
      if (product(dims) > 0) call h5dread_f(dataset, type, to, status)
      if (product(dims) > 0) call self%note(status, 'cannot read '//quoted(path))
      call h5dclose_f(dataset, status)
   end subroutine read_values

   subroutine read_real_1(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Empty on failure
      real(wp), allocatable, intent(out), target :: value(:)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(1)

      call find_dataset(self, path, 1, dataset, dims)
      allocate (value(dims(1)))
      call read_values(self, path, dataset, H5T_NATIVE_DOUBLE, dims, c_loc(value))
   end subroutine read_real_1

   subroutine read_real_2(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Empty on failure
      real(wp), allocatable, intent(out), target :: value(:, :)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(2)

      call find_dataset(self, path, 2, dataset, dims)
      allocate (value(dims(1), dims(2)))
      call read_values(self, path, dataset, H5T_NATIVE_DOUBLE, dims, c_loc(value))
   end subroutine read_real_2

   subroutine read_integer_1(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Empty on failure
      integer, allocatable, intent(out), target :: value(:)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(1)

      call find_dataset(self, path, 1, dataset, dims)
      allocate (value(dims(1)))
      call read_values(self, path, dataset, H5T_NATIVE_INTEGER, dims, c_loc(value))
   end subroutine read_integer_1

   subroutine read_integer_2(self, path, value)
      class(h5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Empty on failure
      integer, allocatable, intent(out), target :: value(:, :)
      integer(hid_t) :: dataset
      integer(hsize_t) :: dims(2)

      call find_dataset(self, path, 2, dataset, dims)
      allocate (value(dims(1), dims(2)))
      call read_values(self, path, dataset, H5T_NATIVE_INTEGER, dims, c_loc(value))
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
