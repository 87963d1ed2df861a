!> history.csv: one row an output time, every row on the disk as soon as it is written.
module history_m
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use errors_m, only: error_list_t
   use files_m, only: replace_file, file_exists
   use kinds_m, only: wp
   use text_m, only: to_text, csv_text
   implicit none
   private

   public :: history_columns, group_means

   !> Longest name of a column
   integer, parameter, public :: column_length = 128
   !> Columns that every run has. The stage is its number in the deck; the residual is what the energy balance lacks.
   character(len=column_length), parameter, public :: run_column(*) = [character(len=column_length) :: &
                                'time_s', 'step', 'stage', 'cycle', 'kinetic_J', 'strain_J', 'contact_J', 'friction_J', 'walls_J', &
                                                                       'corners_J', 'surfaces_J', 'fracture_J', 'damping_J', &
                                                                       'absorbed_J', 'external_J', 'residual_J', 'unbalanced_ratio']
   !> Columns of each joint group G, written as G.name: means over the group weighted by length
   character(len=column_length), parameter, public :: joint_column(*) = [character(len=column_length) :: &
                       'shear_displacement_mm', 'shear_stress_MPa', 'normal_stress_MPa', 'dilation_mm', 'closure_mm', 'aperture_mm']

   !> The history file
   type, public :: history_t
      private
      !> Unit of the open file, 0 when there is none
      integer :: unit = 0
      integer :: columns = 0
      character(len=:), allocatable :: path
      !> The row of the checkpoint that a restart has dropped; not allocated when there is none, or the run has gone on
      character(len=:), allocatable :: dropped
   contains
      procedure :: init
      procedure :: resume
      procedure :: write_row
      procedure :: put_back
      procedure :: forget_dropped
      procedure :: close => close_history
   end type history_t

contains

   !> Names of all columns: those of the run, then those of each joint group.
   pure function history_columns(joint_group) result(name)
      !> Names of the joint groups
      character(len=*), intent(in) :: joint_group(:)
      character(len=column_length) :: name(size(run_column) + size(joint_column)*size(joint_group))
      integer :: i, j, k

      k = size(run_column)
      name(:k) = run_column
      do i = 1, size(joint_group)
         do j = 1, size(joint_column)
            k = k + 1
            name(k) = trim(joint_group(i))//'.'//joint_column(j)
         end do
      end do
   end function history_columns

   !> Means over each group, weighted by length (0 for an empty group).
   pure function group_means(groups, group, length, value) result(mean)
      !> Number of groups
      integer, intent(in) :: groups
      !> Group of each joint, 1 to groups; others are left out (joints)
      integer, intent(in) :: group(:)
      !> Length of each joint [m] (joints)
      real(wp), intent(in) :: length(:)
      !> Values to average (joints)
      real(wp), intent(in) :: value(:)
      real(wp) :: mean(groups)
      real(wp) :: total(groups)
      integer :: i

      mean = 0.0_wp
      total = 0.0_wp
      do i = 1, size(group)
         if (group(i) < 1 .or. group(i) > groups) cycle
         mean(group(i)) = mean(group(i)) + length(i)*value(i)
         total(group(i)) = total(group(i)) + length(i)
      end do
      where (total > 0.0_wp) mean = mean/total
   end function group_means

   !> Start a new file with its line of names.
   subroutine init(self, path, column, errors)
      class(history_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Names of the columns, each ending in its unit
      character(len=*), intent(in) :: column(:)
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: status

      self%path = trim(path)
      self%columns = size(column)
      open (newunit=self%unit, file=self%path, action='write', status='replace', iostat=status, iomsg=message)
      if (status == 0) write (self%unit, '(a)', iostat=status, iomsg=message) heading(column)
      if (status == 0) flush (self%unit, iostat=status, iomsg=message)
      if (status /= 0) call errors%add(self%path//': cannot write the history: '//trim(message))
   end subroutine init

   !> Go on with the file of an interrupted run. Rows later than the restart time are dropped, and a row cut short.
   subroutine resume(self, path, column, time, errors)
      class(history_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: column(:)
      !> Time of the checkpoint [s]
      real(wp), intent(in) :: time
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: line
      character(len=512) :: message
      real(wp) :: row_time
      integer :: old, new, status
      logical :: complete

      if (.not. file_exists(path)) then
         call self%init(path, column, errors)
         return
      end if
      self%path = trim(path)
      self%columns = size(column)
      open (newunit=old, file=self%path, action='read', status='old', iostat=status, iomsg=message)
      if (status /= 0) then
         call errors%add(self%path//': cannot read the history to go on with: '//trim(message))
         return
      end if
      call read_line(old, line, complete)
      if (line /= heading(column)) then
         call errors%add(self%path//': its columns are not those of this deck; restart with the deck that wrote it,'// &
                         ' or in another results directory')
         close (old)
         return
      end if
      open (newunit=new, file=self%path//'.part', action='write', status='replace', iostat=status, iomsg=message)
      if (status == 0) write (new, '(a)', iostat=status, iomsg=message) line
      do while (status == 0)
         call read_line(old, line, complete)
         if (.not. complete) exit
         ! Commas end a list-directed item, so this reads the first column, the time.
         read (line, *, iostat=status) row_time
         if (status /= 0) then
            status = 0
            exit
         end if
         ! The row of the checkpoint itself stays: its time was written with finitely many digits.
         if (row_time > time*(1.0_wp + 1.0e-10_wp)) then
            if (row_time <= time*(1.0_wp + 4.0e-10_wp)) self%dropped = line
            exit
         end if
         write (new, '(a)', iostat=status, iomsg=message) line
      end do
      close (old)
      if (status == 0) then
         flush (new, iostat=status, iomsg=message)
         if (status == 0) then
            call replace_file(self%path//'.part', self%path, status)
            message = 'cannot replace the old file'
         end if
      end if
      self%unit = new
      if (status /= 0) call errors%add(self%path//': cannot go on with the history: '//trim(message))
   end subroutine resume

   !> Write one row and hand it to the system, so that it can be read at once and outlives a kill.
   subroutine write_row(self, value, errors)
      class(history_t), intent(inout) :: self
      !> One value a column
      real(wp), intent(in) :: value(:)
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: line
      character(len=512) :: message
      integer :: i, status

      if (size(value) /= self%columns) then
         call errors%add(self%path//': a row of '//to_text(size(value))//' values for '//to_text(self%columns)//' columns')
         return
      end if
      line = number(value(1))
      do i = 2, size(value)
         line = line//','//number(value(i))
      end do
      write (self%unit, '(a)', iostat=status, iomsg=message) line
      if (status == 0) flush (self%unit, iostat=status, iomsg=message)
      if (status /= 0) call errors%add(self%path//': cannot write the history: '//trim(message))
   end subroutine write_row

   !> Write the row again that a restart has dropped, when the run has not gone on since: that of the checkpoint, which the deck
   !> does not ask for.
   subroutine put_back(self, errors)
      class(history_t), intent(inout) :: self
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: status

      if (.not. allocated(self%dropped)) return
      write (self%unit, '(a)', iostat=status, iomsg=message) self%dropped
      if (status == 0) flush (self%unit, iostat=status, iomsg=message)
      if (status /= 0) call errors%add(self%path//': cannot write the history: '//trim(message))
      deallocate (self%dropped)
   end subroutine put_back

   !> The run has gone on: the row that a restart has dropped is over.
   pure subroutine forget_dropped(self)
      class(history_t), intent(inout) :: self

      if (allocated(self%dropped)) deallocate (self%dropped)
   end subroutine forget_dropped

   subroutine close_history(self)
      class(history_t), intent(inout) :: self
      integer :: status

      if (self%unit /= 0) close (self%unit, iostat=status)
      self%unit = 0
   end subroutine close_history

   !> The line of names.
   pure function heading(column) result(line)
      character(len=*), intent(in) :: column(:)
      character(len=:), allocatable :: line
      integer :: i

      line = csv_text(column(1))
      do i = 2, size(column)
         line = line//','//csv_text(column(i))
      end do
   end function heading

   !> A number with twelve digits, whole numbers (steps, stages, cycles) without a point.
   function number(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      !> Whole numbers up to here are exact in double precision and short enough to read
      real(wp), parameter :: largest_whole = 1.0e12_wp
      character(len=24) :: buffer

      if (ieee_is_nan(value)) then
         text = 'nan'
         return
      end if
      if (abs(value) < largest_whole) then
         if (.not. abs(value - aint(value)) > 0.0_wp) then
            write (buffer, '(f0.0)') value
            text = trim(adjustl(buffer))
            text = text(:len(text) - 1)
            if (text == '' .or. text == '-' .or. text == '-0') text = '0'
            return
         end if
      end if
      write (buffer, '(es20.11e3)') value
      text = trim(adjustl(buffer))
   end function number

   !> One line of any length.
   subroutine read_line(unit, line, complete)
      integer, intent(in) :: unit
      character(len=:), allocatable, intent(out) :: line
      !> The line was there and ended with a line end
      logical, intent(out) :: complete
      character(len=1024) :: piece
      integer :: status, length

      line = ''
      do
         read (unit, '(a)', advance='no', iostat=status, size=length) piece
         line = line//piece(:length)
         if (status /= 0) exit
      end do
      complete = is_iostat_eor(status)
   end subroutine read_line

end module history_m
