!> The variables of a group, named once: one list of names reads them from the deck and writes them to the effective deck. A group
!> goes through its list with `keep`, as a checkpoint does.
module group_variables_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: a_number, a_count, a_switch, an_option, a_name, a_path, a_word, option_length, name_length, &
                              what_is_wrong, suggestion
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   !> A message on a value
   type :: complaint_t
      character(len=:), allocatable :: text
   end type complaint_t

   !> The variables of a group on their way
   type, public :: group_variables_t
      private
      logical, public :: writing = .false.
      !> Unit that is written to
      integer :: unit = 0
      !> Group as written by the user; what is wrong with each assignment, not allocated: no variable has asked for it yet
      type(group_slice_t) :: slice
      type(complaint_t), allocatable :: complaint(:)
      !> Names so far
      character(len=option_length), allocatable :: name(:)
   contains
      procedure :: read => start_reading
      procedure :: write => start_writing
      procedure :: end_reading
      procedure :: end_writing
      procedure, private :: keep_real, keep_integer, keep_logical, keep_text
      !> keep(name, value): read or write a number, count, switch or text; the name of a component of the group's type
      generic :: keep => keep_real, keep_integer, keep_logical, keep_text
      procedure :: keep_word
   end type group_variables_t

contains

   !> Start reading: what is given takes the place of the values there.
   subroutine start_reading(self, slice)
      class(group_variables_t), intent(out) :: self
      !> The group as written
      type(group_slice_t), intent(in) :: slice

      self%slice = slice
      allocate (self%complaint(slice%count), self%name(0))
   end subroutine start_reading

   !> Start writing: every variable.
   subroutine start_writing(self, unit, group)
      class(group_variables_t), intent(out) :: self
      integer, intent(in) :: unit
      !> Its name, without '&'
      character(len=*), intent(in) :: group

      self%writing = .true.
      self%unit = unit
      call begin_group(unit, group)
   end subroutine start_writing

   !> All variables have been named. What is no variable, or has not one value of its kind, is reported in the order of the deck.
   subroutine end_reading(self, errors)
      class(group_variables_t), intent(in) :: self
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, self%slice%count
         associate (name => self%slice%assignment(i)%name)
            if (.not. allocated(self%complaint(i)%text)) then
               call errors%add(self%slice%place(name)//': there is no such variable; '//suggestion(name, self%name))
            else if (self%complaint(i)%text /= '') then
               call errors%add(self%slice%place(name)//': '//self%complaint(i)%text)
            end if
         end associate
      end do
   end subroutine end_reading

   !> All variables have been written.
   subroutine end_writing(self)
      class(group_variables_t), intent(in) :: self

      call end_group(self%unit)
   end subroutine end_writing

   !> A number; what is used when it is not given.
   subroutine keep_real(self, name, value, instead)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(inout) :: value
      character(len=*), intent(in), optional :: instead
      integer :: i, status

      if (self%writing) then
         call put(self%unit, name, value, instead)
         return
      end if
      call look_up(self, name, a_number, i)
      if (i > 0) read (self%slice%assignment(i)%value, *, iostat=status) value
   end subroutine keep_real

   subroutine keep_integer(self, name, value)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      integer, intent(inout) :: value
      integer :: i, status

      if (self%writing) then
         call put(self%unit, name, value)
         return
      end if
      call look_up(self, name, a_count, i)
      if (i > 0) read (self%slice%assignment(i)%value, *, iostat=status) value
   end subroutine keep_integer

   subroutine keep_logical(self, name, value)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      logical, intent(inout) :: value
      integer :: i, status

      if (self%writing) then
         call put(self%unit, name, value)
         return
      end if
      call look_up(self, name, a_switch, i)
      if (i > 0) read (self%slice%assignment(i)%value, *, iostat=status) value
   end subroutine keep_logical

   !> Text in quotes: an option, name or path by its length.
   subroutine keep_text(self, name, value)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(inout) :: value

      select case (len(value))
      case (option_length)
         call keep_text_of(self, name, an_option, value)
      case (name_length)
         call keep_text_of(self, name, a_name, value)
      case default
         call keep_text_of(self, name, a_path, value)
      end select
   end subroutine keep_text

   !> An option, among which are numbers, that may do without quotes.
   subroutine keep_word(self, name, value)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(inout) :: value

      call keep_text_of(self, name, a_word, value)
   end subroutine keep_word

   subroutine keep_text_of(self, name, kind, value)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      integer, intent(in) :: kind
      character(len=*), intent(inout) :: value
      integer :: i, status

      if (self%writing) then
         call put(self%unit, name, value)
         return
      end if
      call look_up(self, name, kind, i)
      if (i > 0) read (self%slice%assignment(i)%value, *, iostat=status) value
   end subroutine keep_text_of

   !> Place of a variable's value among the assignments; 0: not given, or not one value of its kind. Only what reads cleanly gets
   !> through: gfortran alone would take .tomato. for true.
   subroutine look_up(self, name, kind, i)
      class(group_variables_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      integer, intent(in) :: kind
      integer, intent(out) :: i

      self%name = [character(len=option_length) :: self%name, name]
      i = self%slice%find(name)
      if (i == 0) return
      associate (assignment => self%slice%assignment(i))
         self%complaint(i)%text = what_is_wrong(assignment%value, assignment%values, kind)
         if (self%complaint(i)%text /= '') i = 0
      end associate
   end subroutine look_up

end module group_variables_m
