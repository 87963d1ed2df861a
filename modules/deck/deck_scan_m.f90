!> The deck as text: cuts it into groups `&name variable = value ... /` before anything is read as a namelist.
!>
!> A namelist READ answers a misspelt group, a missing '/' or a wrong type in the last variable with plain end-of-file,
!> so everything that can be wrong with the form of a deck is found and reported here, all of it in one go.
module deck_scan_m
   use deck_text_m, only: what_file_is, plain_text, is_line_end
   use errors_m, only: error_list_t
   use files_m, only: read_text
   use text_m, only: lower, to_text
   implicit none
   private

   public :: scan_deck, read_text_file

   !> `name = value` as written in the deck
   type, public :: assignment_t
      !> Variable in lower case, and its value: words and quoted texts, separated by single blanks
      character(len=:), allocatable :: name, value
      !> Line of the deck
      integer :: line = 0
      !> How many values were given (a good deck: one)
      integer :: values = 0
   end type assignment_t

   !> One group of the deck as written
   type, public :: group_slice_t
      !> Path of the deck as the user gave it; name of the group in lower case, without '&'
      character(len=:), allocatable :: path, name
      !> Line of the deck on which the group starts
      integer :: line = 0
      !> Number of assignments in use, and the assignments in the order of the deck
      integer :: count = 0
      type(assignment_t), allocatable :: assignment(:)
   contains
      procedure :: find
      procedure :: place
   end type group_slice_t

   !> Kinds of token
   integer, parameter :: token_end = 0, token_word = 1, token_string = 2, token_equals = 3, token_comma = 4, &
                         token_slash = 5, token_group = 6, token_open_string = 7

   !> A token and where it stands
   type :: token_t
      integer :: kind = token_end
      character(len=:), allocatable :: text
      integer :: line = 0
   end type token_t

   !> A reader's place in the text
   type :: reader_t
      !> Next character, and its line
      integer :: next = 1, line = 1
   end type reader_t

   character, parameter :: tab = achar(9), line_feed = achar(10), carriage_return = achar(13)
   !> Characters that end a word
   character(len=*), parameter :: word_ends = ' =,/&'//"'!"//'"'//tab//line_feed//carriage_return
   !> What a reader of the message should know
   character(len=*), parameter :: form_of_a_group = &
                                  ' (a group is &name variable = value ... /, its texts in quotes)'
   !> Longest piece of the user's text that a message repeats
   integer, parameter :: excerpt_length = 40

contains

   !> Index of a variable's assignment in the group (0: not given).
   pure integer function find(self, name)
      class(group_slice_t), intent(in) :: self
      !> Variable in lower case
      character(len=*), intent(in) :: name
      integer :: i

      find = 0
      do i = self%count, 1, -1
         if (self%assignment(i)%name == name) find = i
      end do
   end function find

   !> Start of a message: 'input.nml:12: &joint jrc0 = -3', or 'input.nml:10: &joint jrc0' when it is not given.
   pure function place(self, name)
      class(group_slice_t), intent(in) :: self
      !> Variable in lower case
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: place
      integer :: i

      i = self%find(name)
      if (i == 0) then
         place = at_line(self%path, self%line)//'&'//self%name//' '//name
      else
         place = at_line(self%path, self%assignment(i)%line)//'&'//self%name//' '//name//' = '//self%assignment(i)%value
      end if
   end function place

   !> 'input.nml:12: '
   pure function at_line(path, line)
      character(len=*), intent(in) :: path
      integer, intent(in) :: line
      character(len=:), allocatable :: at_line

      at_line = path//':'//to_text(line)//': '
   end function at_line

   !> The whole of a text file.
   subroutine read_text_file(path, text, errors)
      !> Path of the file
      character(len=*), intent(in) :: path
      !> Its content with its line feeds; empty when it can't be read
      character(len=:), allocatable, intent(out) :: text
      type(error_list_t), intent(inout) :: errors
      character(len=256) :: message
      integer :: status

      call read_text(path, text, status, message)
      if (status /= 0) then
         call errors%add(path//': the deck cannot be opened: '//trim(message))
      else if (what_file_is(text) /= '') then
         call errors%add(path//': '//what_file_is(text))
         text = ''
      end if
   end subroutine read_text_file

   !> Cut the text of a deck into its groups. What is wrong is reported and the rest is still cut.
   subroutine scan_deck(path, as_written, slice, errors)
      !> Path of the deck, for the messages
      character(len=*), intent(in) :: path
      !> Text of the deck
      character(len=*), intent(in) :: as_written
      !> Groups in the order of the deck
      type(group_slice_t), allocatable, intent(out) :: slice(:)
      type(error_list_t), intent(inout) :: errors
      type(reader_t) :: reader
      type(token_t) :: token
      character(len=:), allocatable :: text
      logical :: stray_reported

      allocate (slice(0))
      call plain_text(path, as_written, text, errors)
      ! One message for each stretch of stray text: a file that is no deck at all would give thousands.
      stray_reported = .false.
      call next_token(text, reader, token)
      do while (token%kind /= token_end)
         if (token%kind == token_group) then
            call scan_group(path, text, reader, token, slice, errors)
            stray_reported = .false.
         else
            if (.not. stray_reported) then
               call errors%add(at_line(path, token%line)//'text outside a group: '//excerpt(token%text)// &
                               form_of_a_group)
            end if
            stray_reported = .true.
            call next_token(text, reader, token)
         end if
      end do
   end subroutine scan_deck

   !> Scan one group, from its name to its '/'.
   subroutine scan_group(path, text, reader, token, slice, errors)
      character(len=*), intent(in) :: path, text
      type(reader_t), intent(inout) :: reader
      !> In: the token with the group's name; out: the first token after the group
      type(token_t), intent(inout) :: token
      type(group_slice_t), allocatable, intent(inout) :: slice(:)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t) :: group
      type(token_t) :: word

      group%path = path
      group%name = lower(token%text)
      group%line = token%line
      allocate (group%assignment(0))
      if (len(group%name) == 0) call errors%add(at_line(path, group%line)//"'&' without the name of a group")
      do
         call next_token(text, reader, token)
         if (word%kind == token_word .and. token%kind == token_equals) then
            call start_assignment(group, word, errors)
            word%kind = token_end
            cycle
         end if
         call add_value(group, word, errors)
         word%kind = token_end
         select case (token%kind)
         case (token_word, token_string)
            word = token
         case (token_open_string)
            call errors%add(at_line(path, token%line)//'&'//group%name//' '//last_name(group)//': the text '// &
                            excerpt(token%text)//' is not closed by a quote on its line')
            ! Close it, so that this one mistake has this one message.
            word = token
            word%kind = token_string
            word%text = token%text//token%text(1:1)
         case (token_equals)
            call errors%add(at_line(path, token%line)//'&'//group%name//": '=' without the name of a variable")
         case (token_slash)
            call next_token(text, reader, token)
            exit
         case (token_group, token_end)
            call errors%add(at_line(path, group%line)//'&'//group%name// &
                            ": the group is not closed: a '/' is missing before "//what_follows(token))
            if (token%kind == token_group .and. lower(token%text) == 'end') call next_token(text, reader, token)
            exit
         end select
      end do
      call check_duplicates(group, errors)
      call append_slice(slice, group)
   end subroutine scan_group

   !> Variable of the assignment that is being scanned.
   pure function last_name(group)
      type(group_slice_t), intent(in) :: group
      character(len=:), allocatable :: last_name

      last_name = ''
      if (group%count > 0) last_name = group%assignment(group%count)%name
   end function last_name

   !> Where a group without '/' was found to end.
   pure function what_follows(token)
      type(token_t), intent(in) :: token
      character(len=:), allocatable :: what_follows

      what_follows = 'the end of the file'
      if (token%kind == token_group) what_follows = '&'//token%text//' in line '//to_text(token%line)
   end function what_follows

   !> A variable's name and '=' have been read.
   subroutine start_assignment(group, word, errors)
      type(group_slice_t), intent(inout) :: group
      !> Name of the variable
      type(token_t), intent(in) :: word
      type(error_list_t), intent(inout) :: errors
      type(assignment_t) :: assignment
      character(len=:), allocatable :: name
      integer :: bracket

      name = word%text
      bracket = scan(name, '(%')
      assignment%value = ''
      assignment%line = word%line
      if (bracket > 0) then
         call errors%add(at_line(group%path, word%line)//'&'//group%name//' '//excerpt(word%text)// &
                         ': a variable of the deck is a single value; write it without ( or %')
         name = name(:bracket - 1)
      end if
      assignment%name = lower(name)
      call append_assignment(group, assignment)
   end subroutine start_assignment

   !> A word or text that is not a variable's name belongs to the value before it.
   subroutine add_value(group, word, errors)
      type(group_slice_t), intent(inout) :: group
      !> Pending token (kind token_end: none)
      type(token_t), intent(in) :: word
      type(error_list_t), intent(inout) :: errors

      if (word%kind == token_end) return
      if (group%count == 0) then
         call errors%add(at_line(group%path, word%line)//'&'//group%name//': found '//excerpt(word%text)// &
                         ' where variable = value was expected')
         return
      end if
      associate (last => group%assignment(group%count))
         if (last%values > 0) last%value = last%value//' '
         last%value = last%value//word%text
         last%values = last%values + 1
      end associate
   end subroutine add_value

   !> A variable may be given once in a group.
   subroutine check_duplicates(group, errors)
      type(group_slice_t), intent(in) :: group
      type(error_list_t), intent(inout) :: errors
      integer :: i, first

      do i = 2, group%count
         first = group%find(group%assignment(i)%name)
         if (first == i) cycle
         call errors%add(at_line(group%path, group%assignment(i)%line)//'&'//group%name//' '// &
                         group%assignment(i)%name//' = '//group%assignment(i)%value// &
                         ': given twice in this group, first in line '//to_text(group%assignment(first)%line))
      end do
   end subroutine check_duplicates

   !> Read the next token; a comment is skipped.
   subroutine next_token(text, reader, token)
      character(len=*), intent(in) :: text
      type(reader_t), intent(inout) :: reader
      type(token_t), intent(out) :: token
      integer :: first

      call skip_blanks(text, reader)
      token%line = reader%line
      token%text = ''
      if (reader%next > len(text)) return
      first = reader%next
      reader%next = first + 1
      select case (text(first:first))
      case ('=')
         token%kind = token_equals
      case (',')
         token%kind = token_comma
      case ('/')
         token%kind = token_slash
      case ('&')
         token%kind = token_group
         call skip_word(text, reader)
         token%text = text(first + 1:reader%next - 1)
         return
      case ('''', '"')
         call skip_string(text, reader, text(first:first), token%kind)
      case default
         token%kind = token_word
         call skip_word(text, reader)
      end select
      token%text = text(first:reader%next - 1)
   end subroutine next_token

   !> Go to the next character that is neither blank nor in a comment.
   subroutine skip_blanks(text, reader)
      character(len=*), intent(in) :: text
      type(reader_t), intent(inout) :: reader
      logical :: comment

      comment = .false.
      do while (reader%next <= len(text))
         select case (text(reader%next:reader%next))
         case (line_feed, carriage_return)
            ! A carriage return alone ends a line too; before a line feed it is the same end
            comment = .false.
            if (is_line_end(text, reader%next)) reader%line = reader%line + 1
         case ('!')
            comment = .true.
         case (' ', tab)
            continue
         case default
            if (.not. comment) return
         end select
         reader%next = reader%next + 1
      end do
   end subroutine skip_blanks

   !> Go behind the word that has begun.
   subroutine skip_word(text, reader)
      character(len=*), intent(in) :: text
      type(reader_t), intent(inout) :: reader
      integer :: length

      length = scan(text(reader%next:), word_ends) - 1
      if (length < 0) length = len(text) - reader%next + 1
      reader%next = reader%next + length
   end subroutine skip_word

   !> Go behind the closing quote; a doubled quote stands for the quote itself. A text ends on its line.
   subroutine skip_string(text, reader, quote, kind)
      character(len=*), intent(in) :: text
      type(reader_t), intent(inout) :: reader
      character, intent(in) :: quote
      !> token_string, or token_open_string when the line ends first
      integer, intent(out) :: kind

      kind = token_open_string
      do while (reader%next <= len(text))
         if (index(line_feed//carriage_return, text(reader%next:reader%next)) > 0) return
         reader%next = reader%next + 1
         if (text(reader%next - 1:reader%next - 1) /= quote) cycle
         kind = token_string
         if (reader%next > len(text)) return
         if (text(reader%next:reader%next) /= quote) return
         kind = token_open_string
         reader%next = reader%next + 1
      end do
   end subroutine skip_string

   !> The user's own text, shortened and in plain characters, for a message: it may be no text at all.
   pure function excerpt(text)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: excerpt
      integer :: i

      excerpt = text(:min(len(text), excerpt_length))
      do i = 1, len(excerpt)
         if (excerpt(i:i) < ' ' .or. excerpt(i:i) > '~') excerpt(i:i) = '?'
      end do
      if (len(text) > excerpt_length) excerpt = excerpt//'...'
   end function excerpt

   subroutine append_assignment(group, assignment)
      type(group_slice_t), intent(inout) :: group
      type(assignment_t), intent(in) :: assignment
      type(assignment_t), allocatable :: longer(:)

      if (group%count == size(group%assignment)) then
         allocate (longer(2*group%count + 8))
         longer(:group%count) = group%assignment
         call move_alloc(longer, group%assignment)
      end if
      group%count = group%count + 1
      group%assignment(group%count) = assignment
   end subroutine append_assignment

   subroutine append_slice(slice, group)
      type(group_slice_t), allocatable, intent(inout) :: slice(:)
      type(group_slice_t), intent(in) :: group
      type(group_slice_t), allocatable :: longer(:)

      allocate (longer(size(slice) + 1))
      longer(:size(slice)) = slice
      longer(size(longer)) = group
      call move_alloc(longer, slice)
   end subroutine append_slice

end module deck_scan_m
