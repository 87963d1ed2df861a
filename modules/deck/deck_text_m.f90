!> The characters of a deck: is it text at all, and are there any in it that look like others? A no-break blank or a minus sign
!> from a word processor cannot be told from the plain one on the screen, so each is named with its line.
module deck_text_m
   use errors_m, only: error_list_t
   use text_m, only: to_text
   implicit none
   private

   public :: what_file_is, plain_text, is_line_end

   character, parameter :: tab = achar(9), line_feed = achar(10), carriage_return = achar(13), null = achar(0)
   !> Bytes at the start of a file that tell what it is, and how many of them may be odd ones: one in ten
   integer, parameter :: looked_at = 4096
   integer, parameter :: one_in = 10
   !> Distinct messages before the rest is only counted
   integer, parameter :: most_messages = 20

   !> A character, what it is called (with its article), and what it was meant for
   type :: character_t
      integer :: code
      character(len=28) :: name
      character :: meant
   end type character_t

   type(character_t), parameter :: known(*) = [ &
                                   character_t(11, 'a vertical tab', ' '), &
                                   character_t(12, 'a form feed', ' '), &
                                   character_t(26, 'an end-of-file mark of DOS', ' '), &
                                   character_t(133, 'a next line', ' '), &
                                   character_t(160, 'a no-break blank', ' '), &
                                   character_t(173, 'a soft hyphen', ' '), &
                                   character_t(180, 'an acute accent', ''''), &
                                   character_t(8199, 'a figure blank', ' '), &
                                   character_t(8201, 'a thin blank', ' '), &
                                   character_t(8203, 'a zero-width blank', ' '), &
                                   character_t(8204, 'a zero-width non-joiner', ' '), &
                                   character_t(8205, 'a zero-width joiner', ' '), &
                                   character_t(8206, 'a left-to-right mark', ' '), &
                                   character_t(8207, 'a right-to-left mark', ' '), &
                                   character_t(8208, 'a hyphen', '-'), &
                                   character_t(8209, 'a no-break hyphen', '-'), &
                                   character_t(8211, 'an en dash', '-'), &
                                   character_t(8212, 'an em dash', '-'), &
                                   character_t(8216, 'an opening quotation mark', ''''), &
                                   character_t(8217, 'a closing quotation mark', ''''), &
                                   character_t(8220, 'an opening quotation mark', '"'), &
                                   character_t(8221, 'a closing quotation mark', '"'), &
                                   character_t(8232, 'a line separator', ' '), &
                                   character_t(8233, 'a paragraph separator', ' '), &
                                   character_t(8239, 'a narrow no-break blank', ' '), &
                                   character_t(8288, 'a word joiner', ' '), &
                                   character_t(8722, 'a minus sign', '-'), &
                                   character_t(12288, 'an ideographic blank', ' '), &
                                   character_t(65279, 'a byte order mark', ' ')]
   !> They end a line on the screen, but neither a line of the deck nor a comment
   integer, parameter :: false_line_ends(*) = [11, 12, 133, 8232, 8233]

contains

   !> What is wrong with a file as a whole, when it is no text or in another encoding; '' for text.
   pure function what_file_is(text) result(what)
      !> All bytes of the file
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: what
      integer :: i, n, nulls(0:1)

      what = ''
      n = min(len(text), looked_at)
      nulls = 0
      do i = 1, n
         if (text(i:i) == null) nulls(mod(i, 2)) = nulls(mod(i, 2)) + 1
      end do
      if (n >= 2) then
         if (any(text(:2) == [char(255)//char(254), char(254)//char(255)]) .or. &
             (maxval(nulls) > n/4 .and. minval(nulls) <= n/100)) then
            what = 'is written in UTF-16; must be plain text, save it as UTF-8 (or ASCII)'
            return
         end if
      end if
      if (index(text, null) > 0 .or. one_in*odd_bytes(text(:n)) > n .or. one_in*odd_bytes(text) > len(text)) &
         what = 'is no text file; must be a deck, such as those in input/'
   end function what_file_is

   !> Bytes that are seldom in a text: control characters, and what is no UTF-8.
   pure integer function odd_bytes(text) result(odd)
      character(len=*), intent(in) :: text
      integer :: i, code, bytes

      odd = 0
      i = 1
      do while (i <= len(text))
         call decode(text, i, code, bytes)
         if (bytes == 1 .and. code >= 128) odd = odd + 1
         if (code < 32 .and. index(tab//line_feed//carriage_return, text(i:i)) == 0) odd = odd + 1
         i = i + bytes
      end do
   end function odd_bytes

   !> The text with plain characters outside comments and quoted texts, each other one reported and taken for what it was meant
   !> for.
   subroutine plain_text(path, text, plain, errors)
      !> Path of the deck, for the messages; its text
      character(len=*), intent(in) :: path, text
      character(len=:), allocatable, intent(out) :: plain
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: buffer
      character :: quote, meant
      integer :: i, n, line, code, bytes, found
      logical :: comment, curly

      buffer = text
      n = 0
      i = 1
      line = 1
      found = 0
      quote = ' '
      comment = .false.
      curly = .false.
      ! A mark at the very start is how some editors begin UTF-8
      call decode(text, 1, code, bytes)
      if (code == 65279) i = 1 + bytes
      do while (i <= len(text))
         call decode(text, i, code, bytes)
         meant = text(i:i)
         if (code >= 128 .or. code < 32) meant = plain_one(code)
         if (is_line_end(text, i)) line = line + 1
         if (code == 10 .or. code == 13) then
            comment = .false.
            quote = ' '
         else if (comment) then
            if (any(false_line_ends == code)) call complain('in a comment: what follows it is part of the comment')
         else if (quote /= ' ') then
            if (any(false_line_ends == code)) call complain('in a quoted text')
            if (meant == quote .and. (bytes == 1 .or. curly)) then
               quote = ' '
               if (bytes > 1) then
                  n = n + 1
                  buffer(n:n) = meant
                  i = i + bytes
                  cycle
               end if
            end if
         else
            if (code == 33) comment = .true.
            if (meant == '''' .or. meant == '"') then
               quote = meant
               curly = bytes > 1
            end if
            if ((code >= 128 .or. code < 32) .and. code /= 9) then
               call complain('')
               n = n + 1
               buffer(n:n) = meant
               i = i + bytes
               cycle
            end if
         end if
         buffer(n + 1:n + bytes) = text(i:i + bytes - 1)
         n = n + bytes
         i = i + bytes
      end do
      plain = buffer(:n)
      if (found > most_messages) call errors%add(path//': '//to_text(found - most_messages)// &
                                                 ' more characters that are not plain text')

   contains

      subroutine complain(where)
         character(len=*), intent(in) :: where
         character(len=:), allocatable :: message

         found = found + 1
         if (found > most_messages) return
         message = path//':'//to_text(line)//': found '//character_text(code)
         if (where /= '') message = message//' '//where
         if (meant == ' ') message = message//'; must be a plain blank, or nothing'
         if (meant /= ' ') message = message//'; must be the plain '//meant
         call errors%add(message)
      end subroutine complain

   end subroutine plain_text

   !> Does a line end here? Two characters, carriage return and line feed, end it once.
   pure logical function is_line_end(text, i)
      character(len=*), intent(in) :: text
      integer, intent(in) :: i

      is_line_end = text(i:i) == line_feed
      if (text(i:i) /= carriage_return) return
      is_line_end = .true.
      if (i < len(text)) is_line_end = text(i + 1:i + 1) /= line_feed
   end function is_line_end

   !> Code point of the character at a place, and its bytes in UTF-8; a byte that is no UTF-8 is taken as Latin-1.
   pure subroutine decode(text, i, code, bytes)
      character(len=*), intent(in) :: text
      integer, intent(in) :: i
      integer, intent(out) :: code, bytes
      integer :: first, k, next

      code = 0
      bytes = 1
      if (i > len(text)) return
      first = ichar(text(i:i))
      code = first
      if (first >= 240) then
         bytes = 4
         code = first - 240
      else if (first >= 224) then
         bytes = 3
         code = first - 224
      else if (first >= 192) then
         bytes = 2
         code = first - 192
      end if
      do k = 1, bytes - 1
         next = 0
         if (i + k <= len(text)) next = ichar(text(i + k:i + k))
         if (next < 128 .or. next >= 192) then
            code = first
            bytes = 1
            return
         end if
         code = 64*code + next - 128
      end do
   end subroutine decode

   !> What a character was meant for, a blank where that is not known.
   pure character function plain_one(code)
      integer, intent(in) :: code
      integer :: i

      plain_one = ' '
      do i = 1, size(known)
         if (known(i)%code == code) plain_one = known(i)%meant
      end do
   end function plain_one

   !> A character for a message: 'a no-break blank (U+00A0)'.
   pure function character_text(code) result(text)
      integer, intent(in) :: code
      character(len=:), allocatable :: text
      character(len=8) :: digits
      integer :: i

      write (digits, '(z0)') code
      if (code < 4096) write (digits, '(z4.4)') code
      text = 'the character U+'//trim(digits)
      do i = 1, size(known)
         if (known(i)%code == code) text = trim(known(i)%name)//' (U+'//trim(digits)//')'
      end do
   end function character_text

end module deck_text_m
