!> checkpoint.h5: everything a run needs to go on, bit for bit. Written beside the old one, sealed with a checksum and renamed when
!> complete, so a kill at any moment leaves one that can be used, and one that is damaged is not. Procedures that differ in the
!> type of their value alone include one text (*.inc).
module checkpoint_m
   use errors_m, only: error_list_t
   use files_m, only: replace_file, file_exists
   use hash_m, only: text_hash, numbers_hash
   use hdf5_m, only: h5_file_t
   use kinds_m, only: wp, i8
   use seal_m, only: seal_file, broken_seal
   use text_m, only: to_text, quoted
   implicit none
   private

   public :: text_hash, numbers_hash

   !> Layout of the file; raise it when what is saved changes meaning
   integer, parameter :: format_version = 10

   !> What a checkpoint must agree with beside the deck (deck_record_m): the same mesh, in size and content
   type, public :: fingerprint_t
      integer :: nodes = 0, triangles = 0, joints = 0
      !> text_hash of what the mesh holds: places of the nodes, corners of triangles and ends of fracture lines, groups
      character(len=16) :: places = '', corners = '', groups = ''
   end type fingerprint_t

   !> A checkpoint being written or read
   type, public :: checkpoint_t
      private
      type(h5_file_t) :: file
      character(len=:), allocatable :: path
      logical, public :: writing = .false.
   contains
      procedure :: create
      procedure :: open => open_checkpoint
      procedure :: close => close_checkpoint
      procedure :: has
      procedure, private :: save_text, save_real, save_integer, save_long, save_real_1, save_real_2, save_integer_1, save_integer_2
      !> save(name, value): a scalar or an array of rank 1 or 2
      generic :: save => save_text, save_real, save_integer, save_long, save_real_1, save_real_2, save_integer_1, save_integer_2
      procedure, private :: load_text, load_real, load_integer, load_long, load_real_1, load_real_2, load_integer_1, load_integer_2
      !> load(name, value): arrays that are allocated must have the shape saved, others get it
      generic :: load => load_text, load_real, load_integer, load_long, load_real_1, load_real_2, load_integer_1, load_integer_2
      procedure, private :: keep_real, keep_integer, keep_long, keep_logical, keep_real_1, keep_real_2, keep_integer_1, &
         keep_integer_2
      !> keep(name, value, errors): save or load, whichever the checkpoint is open for: one list of names serves both
      generic :: keep => keep_real, keep_integer, keep_long, keep_logical, keep_real_1, keep_real_2, keep_integer_1, &
         keep_integer_2
      procedure :: keep_if_any
   end type checkpoint_t

contains

   !> Start a checkpoint; the old one stays until `close`.
   subroutine create(self, path, fingerprint)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      type(fingerprint_t), intent(in) :: fingerprint

      self%path = trim(path)
      self%writing = .true.
      call self%file%create(self%path//'.part')
      call self%file%put('/', 'format', format_version)
      call self%file%put('/', 'nodes', fingerprint%nodes)
      call self%file%put('/', 'triangles', fingerprint%triangles)
      call self%file%put('/', 'joints', fingerprint%joints)
      call self%file%put('/', 'places', fingerprint%places)
      call self%file%put('/', 'corners', fingerprint%corners)
      call self%file%put('/', 'groups', fingerprint%groups)
   end subroutine create

   !> Open a checkpoint and check that it belongs to this mesh. After an error there is nothing to close.
   subroutine open_checkpoint(self, path, fingerprint, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      type(fingerprint_t), intent(in) :: fingerprint
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: wrong
      integer :: version, before

      self%path = trim(path)
      self%writing = .false.
      before = errors%count()
      if (.not. file_exists(path)) then
         call errors%add(self%path//': there is no such checkpoint')
         return
      end if
      wrong = broken_seal(self%path)
      if (wrong /= '') then
         call errors%add(self%path//': the checkpoint '//wrong)
         return
      end if
      call self%file%open(self%path, writable=.false.)
      call self%file%get('/', 'format', version)
      if (.not. self%file%failed() .and. version /= format_version) then
         call errors%add(self%path//': written in checkpoint format '//to_text(version)//', this program reads '// &
                         to_text(format_version))
         call self%file%close(errors)
         return
      end if
      call check_count(self, 'nodes', fingerprint%nodes, errors)
      call check_count(self, 'triangles', fingerprint%triangles, errors)
      call check_count(self, 'joints', fingerprint%joints, errors)
      if (errors%count() == before) then
         call check_hash(self, 'places', fingerprint%places, 'nodes at other places', errors)
         call check_hash(self, 'corners', fingerprint%corners, 'other corners of triangles or ends of fracture lines', errors)
         call check_hash(self, 'groups', fingerprint%groups, 'other groups', errors)
      end if
      if (self%file%failed() .or. errors%count() > before) call self%file%close(errors)
   end subroutine open_checkpoint

   !> One number of the fingerprint.
   subroutine check_count(self, name, expected, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      integer, intent(in) :: expected
      type(error_list_t), intent(inout) :: errors
      integer :: found

      call self%file%get('/', name, found)
      if (self%file%failed()) return
      if (found /= expected) call errors%add(self%path//': its mesh has '//to_text(found)//' '//name// &
                                             ', the mesh of the deck has '//to_text(expected))
   end subroutine check_count

   !> One hash of the fingerprint.
   subroutine check_hash(self, name, expected, what, errors)
      class(checkpoint_t), intent(inout) :: self
      !> Name in the file; what the mesh has when the hash differs
      character(len=*), intent(in) :: name, expected, what
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: found

      call self%file%get('/', name, found)
      if (self%file%failed()) return
      if (found /= expected) call errors%add(self%path//': its mesh has '//what//' than the mesh of the deck')
   end subroutine check_hash

   !> Finish: a checkpoint written without any failure replaces the old one.
   subroutine close_checkpoint(self, errors)
      class(checkpoint_t), intent(inout) :: self
      type(error_list_t), intent(inout) :: errors
      integer :: before, status

      before = errors%count()
      call self%file%close(errors)
      if (.not. self%writing .or. errors%count() > before) return
      call seal_file(self%path//'.part', status)
      if (status /= 0) then
         call errors%add(self%path//'.part: cannot write the checksum of the checkpoint (disk full?)')
         return
      end if
      call replace_file(self%path//'.part', self%path, status)
      if (status /= 0) call errors%add(self%path//': cannot replace the old checkpoint')
   end subroutine close_checkpoint

   !> Was something saved under this name?
   logical function has(self, name)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name

      has = self%file%has('/'//name)
      if (.not. has) has = self%file%has_attribute('/', name)
   end function has

   ! ---- Save --------------------------------------------------------------------------------------------------------

   subroutine save_text(self, name, value)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name, value

      call self%file%put('/', name, value)
   end subroutine save_text

   subroutine save_real(self, name, value)
      real(wp), intent(in) :: value
      include 'save_scalar.inc'
   end subroutine save_real

   subroutine save_integer(self, name, value)
      integer, intent(in) :: value
      include 'save_scalar.inc'
   end subroutine save_integer

   subroutine save_long(self, name, value)
      integer(i8), intent(in) :: value
      include 'save_scalar.inc'
   end subroutine save_long

   subroutine save_real_1(self, name, value)
      real(wp), intent(in) :: value(:)
      include 'save_array.inc'
   end subroutine save_real_1

   subroutine save_real_2(self, name, value)
      real(wp), intent(in) :: value(:, :)
      include 'save_array.inc'
   end subroutine save_real_2

   subroutine save_integer_1(self, name, value)
      integer, intent(in) :: value(:)
      include 'save_array.inc'
   end subroutine save_integer_1

   subroutine save_integer_2(self, name, value)
      integer, intent(in) :: value(:, :)
      include 'save_array.inc'
   end subroutine save_integer_2

   ! ---- Load --------------------------------------------------------------------------------------------------------

   subroutine load_text(self, name, value, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=:), allocatable, intent(out) :: value
      type(error_list_t), intent(inout) :: errors

      value = ''
      if (known(self, name, errors)) call self%file%get('/', name, value)
   end subroutine load_text

   subroutine load_real(self, name, value, errors)
      real(wp), intent(out) :: value
      include 'load_scalar.inc'
   end subroutine load_real

   subroutine load_integer(self, name, value, errors)
      integer, intent(out) :: value
      include 'load_scalar.inc'
   end subroutine load_integer

   subroutine load_long(self, name, value, errors)
      integer(i8), intent(out) :: value
      include 'load_scalar.inc'
   end subroutine load_long

   subroutine load_real_1(self, name, value, errors)
      real(wp), allocatable, intent(inout) :: value(:)
      real(wp), allocatable :: found(:)
      include 'load_array.inc'
   end subroutine load_real_1

   subroutine load_real_2(self, name, value, errors)
      real(wp), allocatable, intent(inout) :: value(:, :)
      real(wp), allocatable :: found(:, :)
      include 'load_array.inc'
   end subroutine load_real_2

   subroutine load_integer_1(self, name, value, errors)
      integer, allocatable, intent(inout) :: value(:)
      integer, allocatable :: found(:)
      include 'load_array.inc'
   end subroutine load_integer_1

   subroutine load_integer_2(self, name, value, errors)
      integer, allocatable, intent(inout) :: value(:, :)
      integer, allocatable :: found(:, :)
      include 'load_array.inc'
   end subroutine load_integer_2

   ! ---- Keep --------------------------------------------------------------------------------------------------------

   subroutine keep_real(self, name, value, errors)
      real(wp), intent(inout) :: value
      include 'keep.inc'
   end subroutine keep_real

   subroutine keep_integer(self, name, value, errors)
      integer, intent(inout) :: value
      include 'keep.inc'
   end subroutine keep_integer

   subroutine keep_long(self, name, value, errors)
      integer(i8), intent(inout) :: value
      include 'keep.inc'
   end subroutine keep_long

   subroutine keep_logical(self, name, value, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      logical, intent(inout) :: value
      type(error_list_t), intent(inout) :: errors
      integer :: number

      number = merge(1, 0, value)
      call self%keep(name, number, errors)
      value = number == 1
   end subroutine keep_logical

   subroutine keep_real_1(self, name, value, errors)
      real(wp), allocatable, intent(inout) :: value(:)
      include 'keep.inc'
   end subroutine keep_real_1

   subroutine keep_real_2(self, name, value, errors)
      real(wp), allocatable, intent(inout) :: value(:, :)
      include 'keep.inc'
   end subroutine keep_real_2

   !> Keep what few scenes have: saved where there is any, and there is none where none was saved.
   subroutine keep_if_any(self, name, value, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      real(wp), allocatable, intent(inout) :: value(:, :)
      type(error_list_t), intent(inout) :: errors

      if (self%writing) then
         if (size(value) > 0) call self%save(name, value)
      else
         deallocate (value)
         if (self%has(name)) then
            call self%keep(name, value, errors)
         else
            allocate (value(2, 0))
         end if
      end if
   end subroutine keep_if_any

   subroutine keep_integer_1(self, name, value, errors)
      integer, allocatable, intent(inout) :: value(:)
      include 'keep.inc'
   end subroutine keep_integer_1

   subroutine keep_integer_2(self, name, value, errors)
      integer, allocatable, intent(inout) :: value(:, :)
      include 'keep.inc'
   end subroutine keep_integer_2

   !> Was it saved? An error otherwise.
   logical function known(self, name, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      type(error_list_t), intent(inout) :: errors

      known = self%has(name)
      if (.not. known) call errors%add(self%path//': the checkpoint has no '//quoted(name))
   end function known

   logical function same_shape(self, name, expected, found, errors)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      integer, intent(in) :: expected(:), found(:)
      type(error_list_t), intent(inout) :: errors
      integer :: i

      same_shape = all(expected == found)
      if (same_shape) return
      do i = 1, size(expected)
         if (expected(i) /= found(i)) call errors%add(self%path//': '//quoted(name)//' has extent '//to_text(found(i))// &
                                                      ' in dimension '//to_text(i)//', expected '//to_text(expected(i)))
      end do
   end function same_shape

end module checkpoint_m
