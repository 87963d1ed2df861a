!> What of a deck the state of a run depends on, as lines that can be kept in a checkpoint and compared: rock, joints, contact,
!> gravity, the stages that are over and what was prescribed in them. How a solver works and what is written do not belong to it.
module deck_record_m
   use errors_m, only: error_list_t
   use text_m, only: to_text
   use deck_m, only: deck_t, write_deck
   use deck_variable_m, only: path_length
   use loads_m, only: stage_number
   implicit none
   private

   public :: read_record, compare_records

   !> A value of the deck
   type :: entry_t
      !> Group with what tells it from others of its kind; variable; value as the deck has it
      character(len=2*path_length) :: group = ''
      character(len=64) :: variable = ''
      character(len=path_length) :: value = ''
   end type entry_t

   !> What a state that is in a stage has of a group of the deck
   type :: group_t
      !> The stage that it is, or that it is given for (0: all)
      integer :: stage = 0
      !> Does it count where there are cohesive joints alone?
      logical :: of_cracks = .false.
      !> Its lines; for a stage, those while it is on, those at its end, and those once another is on
      character(len=:), allocatable :: text, text_on, text_ended
   end type group_t

   !> All records of a deck, which are looked up and not made anew at each checkpoint: there can be thousands of stages
   type, public :: deck_record_t
      private
      type(group_t), allocatable :: group(:)
      !> Cycles of each stage
      integer, allocatable :: cycles(:)
      !> The record of all that the results of a run depend on: later stages, solver and settings of solvers too
      character(len=:), allocatable, public :: whole
   contains
      procedure :: at => record_at
   end type deck_record_t

   character(len=*), parameter :: a_stage = '&stage ', explicit_group = 'explicit'
   character, parameter :: line_feed = new_line('a'), mark = achar(9)

contains

   !> The record of the state at a place of the run: one line a value, group, variable and value separated by tabs.
   pure function record_at(self, stage, cycle, cracked) result(text)
      class(deck_record_t), intent(in) :: self
      !> Stage and cycle that are over (0: none yet)
      integer, intent(in) :: stage, cycle
      !> Are there cohesive joints?
      logical, intent(in) :: cracked
      character(len=:), allocatable :: text, buffer
      integer :: g, used

      allocate (character(len=4096) :: buffer)
      used = 0
      do g = 1, size(self%group)
         associate (group => self%group(g))
            if (group%stage > stage .or. (group%of_cracks .and. .not. cracked)) cycle
            if (.not. allocated(group%text_on) .or. group%stage < stage) then
               call append(buffer, used, group%text)
            else if (cycle >= self%cycles(stage)) then
               call append(buffer, used, group%text_ended)
            else
               call append(buffer, used, group%text_on)
            end if
         end associate
      end do
      text = buffer(:used)
   end function record_at

   !> The records of a deck; empty where there is no room for a temporary file.
   function read_record(deck) result(record)
      type(deck_t), intent(in) :: deck
      type(deck_record_t) :: record
      type(entry_t), allocatable :: entry(:)
      character(len=2*path_length) :: line
      character(len=:), allocatable :: name, buffer
      integer :: unit, status, n, is, stages, used, groups

      allocate (character(len=4096) :: buffer)
      used = 0
      groups = 0
      allocate (entry(64), record%group(64))
      record%cycles = deck%stage%cycles
      open (newunit=unit, status='scratch', action='readwrite', iostat=status)
      if (status == 0) call write_deck(deck, unit, status)
      if (status == 0) then
         rewind (unit)
         name = ''
         stages = 0
         n = 0
         do
            read (unit, '(a)', iostat=status) line
            if (status /= 0) exit
            line = adjustl(line)
            if (line(1:1) == '!' .or. line == '') cycle
            if (line(1:1) == '&') then
               name = trim(line(2:))
               n = 0
               if (name == 'stage') stages = stages + 1
            else if (line == '/') then
               if (n == 0) cycle
               call append(buffer, used, whole_group_text(name, entry(:n), stages))
               if (groups == size(record%group)) call make_room(record%group)
               groups = groups + 1
               record%group(groups) = group_of(deck, name, entry(:n), stages)
            else
               is = index(line, ' = ')
               if (is == 0 .or. n == size(entry)) cycle
               n = n + 1
               entry(n)%variable = line(:is - 1)
               entry(n)%value = line(is + 3:)
            end if
         end do
      end if
      close (unit, iostat=status)
      record%group = record%group(:groups)
      record%whole = buffer(:used)
   end function read_record

   !> Twice as many groups.
   pure subroutine make_room(group)
      type(group_t), allocatable, intent(inout) :: group(:)
      type(group_t), allocatable :: longer(:)

      allocate (longer(2*size(group)))
      longer(:size(group)) = group
      call move_alloc(longer, group)
   end subroutine make_room

   !> Add to a text whose room grows as it is needed.
   pure subroutine append(buffer, used, more)
      character(len=:), allocatable, intent(inout) :: buffer
      !> Letters in use
      integer, intent(inout) :: used
      character(len=*), intent(in) :: more
      character(len=:), allocatable :: longer

      if (used + len(more) > len(buffer)) then
         allocate (character(len=2*(used + len(more))) :: longer)
         longer(:used) = buffer(:used)
         call move_alloc(longer, buffer)
      end if
      buffer(used + 1:used + len(more)) = more
      used = used + len(more)
   end subroutine append

   !> Lines of one group, all of it but what says where things are and what is written.
   pure function whole_group_text(name, entry, number) result(text)
      character(len=*), intent(in) :: name
      type(entry_t), intent(in) :: entry(:)
      integer, intent(in) :: number
      character(len=:), allocatable :: text, group
      integer :: i

      text = ''
      group = '&'//name
      select case (name)
      case ('output', 'plan')
         return
      case ('material', 'joint', 'cohesive', 'initial')
         group = group//' group = '//value_of(entry, 'group')
      case ('boundary', 'pore_pressure')
         group = group//' group = '//value_of(entry, 'group')//', stage = '//value_of(entry, 'stage')
      case ('stage')
         group = group//' '//to_text(number)
      end select
      do i = 1, size(entry)
         if (name == 'run' .and. entry(i)%variable /= 'solver') cycle
         text = text//group//mark//trim(entry(i)%variable)//mark//trim(entry(i)%value)//line_feed
      end do
   end function whole_group_text

   !> What a state has of one group; without lines when it does not depend on it.
   function group_of(deck, name, entry, number) result(group)
      type(deck_t), intent(in) :: deck
      !> Group of the deck
      character(len=*), intent(in) :: name
      !> Its values
      type(entry_t), intent(in) :: entry(:)
      !> Number of stages so far
      integer, intent(in) :: number
      type(group_t) :: group
      character(len=:), allocatable :: label, variable, line
      integer :: i

      group%text = ''
      label = '&'//name
      select case (name)
      case ('material', 'joint')
         label = label//' group = '//value_of(entry, 'group')
      case ('cohesive')
         group%of_cracks = .true.
         label = label//' group = '//value_of(entry, 'group')
      case ('boundary', 'pore_pressure')
         group%stage = stage_number(deck%stage%name, unquoted(value_of(entry, 'stage')))
         label = label//' group = '//value_of(entry, 'group')//', stage = '//value_of(entry, 'stage')
      case ('contact', 'gravity', 'in_situ')
      case (explicit_group)
         ! Masses that were raised stay raised
         if (deck%run%solver /= explicit_group) return
      case ('stage')
         group%stage = number
         group%text_on = ''
         group%text_ended = ''
         label = label//' '//to_text(number)
      case default
         return
      end select
      do i = 1, size(entry)
         variable = trim(entry(i)%variable)
         if (name == explicit_group .and. all(variable /= ['mass_scaling', 'scaled_step '])) cycle
         if (name == 'cohesive' .and. any(variable == ['insertion      ', 'insertion_level', 'check_every    '])) cycle
         line = label//mark//variable//mark//trim(entry(i)%value)//line_feed
         if (name == 'stage') then
            ! Loads depend on the number of cycles of the last stage; on the rest only while it is on
            if (all(variable /= ['equilibrium  ', 'max_rest_time'])) group%text_on = group%text_on//line
            if (any(variable == ['name  ', 'remove', 'cycles'])) group%text_ended = group%text_ended//line
            if (all(variable /= ['name  ', 'remove'])) cycle
         end if
         group%text = group%text//line
      end do
   end function group_of

   !> Value of a variable in a group; '' when it has none.
   pure function value_of(entry, variable) result(value)
      type(entry_t), intent(in) :: entry(:)
      character(len=*), intent(in) :: variable
      character(len=:), allocatable :: value
      integer :: i

      value = ''
      do i = 1, size(entry)
         if (entry(i)%variable == variable) value = trim(entry(i)%value)
      end do
   end function value_of

   !> A quoted text without its quotes.
   pure function unquoted(value) result(text)
      character(len=*), intent(in) :: value
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      i = 2
      do while (i < len(value))
         text = text//value(i:i)
         ! Doubled quotes stand for one
         if (value(i:i) == '''') i = i + 1
         i = i + 1
      end do
   end function unquoted

   !> Name every difference between the record of a checkpoint and that of the deck that goes on from it.
   subroutine compare_records(path, before, now, whole, errors)
      !> Path of the checkpoint, for the messages
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: before, now
      !> Are they whole records, in which every difference counts?
      logical, intent(in) :: whole
      type(error_list_t), intent(inout) :: errors
      type(entry_t), allocatable :: old(:), new(:)
      integer :: i, same

      call split_record(before, old)
      call split_record(now, new)
      do i = 1, size(old)
         if (known(old(i), new)) cycle
         if (.not. any(new%group == old(i)%group)) then
            ! Another solver has no use for them
            if (old(i)%group == '&'//explicit_group .and. .not. whole) cycle
            if (first_of_group(old, i)) call errors%add(path//': was written with '//trim(old(i)%group)// &
                                                        ', which this deck does not have')
            cycle
         end if
         same = findloc(new%group == old(i)%group .and. new%variable == old(i)%variable, .true., dim=1)
         if (same == 0) then
            ! What belongs to a stage only while it is on follows from its number of cycles
            if (index(old(i)%group, a_stage) == 1 .and. .not. whole) cycle
            call errors%add(path//': '//trim(old(i)%group)//': '//trim(old(i)%variable)//' was '//trim(old(i)%value)// &
                            ' when it was written, and is not given in this deck')
         else
            call errors%add(path//': '//trim(old(i)%group)//': '//trim(old(i)%variable)//' was '//trim(old(i)%value)// &
                            ' when it was written, and is '//trim(new(same)%value)//' in this deck')
         end if
      end do
      do i = 1, size(new)
         if (known(new(i), old) .or. (index(new(i)%group, a_stage) == 1 .and. .not. whole)) cycle
         if (.not. any(old%group == new(i)%group)) then
            if (new(i)%group == '&'//explicit_group .and. .not. whole) cycle
            if (first_of_group(new, i)) call errors%add(path//': was written without '//trim(new(i)%group)// &
                                                        ', which this deck has')
         else if (.not. any(old%group == new(i)%group .and. old%variable == new(i)%variable)) then
            call errors%add(path//': '//trim(new(i)%group)//': '//trim(new(i)%variable)//' was not given when it was written,'// &
                            ' and is '//trim(new(i)%value)//' in this deck')
         end if
      end do
   end subroutine compare_records

   !> Is the same value in a list?
   pure logical function known(one, list)
      type(entry_t), intent(in) :: one, list(:)

      known = any(list%group == one%group .and. list%variable == one%variable .and. list%value == one%value)
   end function known

   !> Is no entry before this one of its group?
   pure logical function first_of_group(list, i)
      type(entry_t), intent(in) :: list(:)
      integer, intent(in) :: i

      first_of_group = .not. any(list(:i - 1)%group == list(i)%group)
   end function first_of_group

   !> The lines of a record.
   pure subroutine split_record(text, list)
      character(len=*), intent(in) :: text
      type(entry_t), allocatable, intent(out) :: list(:)
      integer :: i, n, start, end, first, last

      n = count([(text(i:i) == line_feed, i=1, len(text))])
      allocate (list(n))
      start = 1
      do i = 1, n
         end = start + index(text(start:), line_feed) - 2
         first = start + index(text(start:end), mark) - 1
         last = start + index(text(start:end), mark, back=.true.) - 1
         list(i)%group = text(start:first - 1)
         list(i)%variable = text(first + 1:last - 1)
         list(i)%value = text(last + 1:end)
         start = end + 2
      end do
   end subroutine split_record

end module deck_record_m
