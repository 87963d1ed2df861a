!> Small text helpers: numbers to text, letter case, nearest spelling.
module text_m
   use kinds_m, only: wp, i8
   implicit none
   private

   public :: ten_digits, to_text, exact_text, lower, nearest_word, quoted, csv_text

   !> Number to trimmed text
   interface to_text
      module procedure integer_to_text, long_to_text, real_to_text
   end interface to_text

contains

   pure function integer_to_text(value) result(text)
      integer, intent(in) :: value
      character(len=:), allocatable :: text
      character(len=12) :: buffer

      write (buffer, '(i0)') value
      text = trim(buffer)
   end function integer_to_text

   pure function long_to_text(value) result(text)
      integer(i8), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=24) :: buffer

      write (buffer, '(i0)') value
      text = trim(buffer)
   end function long_to_text

   !> Real to text with six significant digits, in the plainest form that holds them.
   pure function real_to_text(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=24) :: buffer

      write (buffer, '(g0.6)') value
      text = trim(adjustl(buffer))
   end function real_to_text

   !> Real to the shortest text that reads back as the same number: 0.5, 15, 3e10, 1.25e-5.
   pure function exact_text(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      !> Digits that always hold a double; exponents written in full rather than with an e
      integer, parameter :: most_digits = 17, plain_from = -4, plain_to = 6
      character(len=48) :: buffer
      character(len=16) :: form
      real(wp) :: read_back
      integer :: digits, exponent

      if (.not. abs(value) <= huge(value)) then
         text = to_text(value)
         return
      end if
      do digits = 1, most_digits
         write (form, '(a,i0,a)') '(es32.', digits - 1, 'e4)'
         write (buffer, form) value
         read (buffer, *) read_back
         if (abs(read_back - value) <= 0.0_wp) exit
      end do
      buffer = adjustl(buffer)
      read (buffer(index(buffer, 'E') + 1:), *) exponent
      if (exponent >= plain_from .and. exponent <= plain_to) then
         write (form, '(a,i0,a)') '(f40.', max(digits - 1 - exponent, 0), ')'
         write (buffer, form) value
         text = without_point(trim(adjustl(buffer)))
      else
         text = without_point(buffer(:index(buffer, 'E') - 1))//'e'//to_text(exponent)
      end if
   end function exact_text

   !> A number's text without a decimal point at its end.
   pure function without_point(text) result(shorter)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: shorter

      shorter = text
      if (index(text, '.') == len(text)) shorter = text(:len(text) - 1)
   end function without_point

   !> A text as one field of a table of comma-separated values (RFC 4180): in quotes, its own doubled, where it has signs that
   !> would end the field; with a semicolon too, which ends it for some spreadsheets.
   pure function csv_text(text) result(field)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: field
      integer :: i

      field = trim(text)
      if (scan(field, ',;"'//achar(10)//achar(13)) == 0 .and. index(field, ' ') /= 1) return
      field = '"'
      do i = 1, len_trim(text)
         field = field//text(i:i)
         if (text(i:i) == '"') field = field//'"'
      end do
      field = field//'"'
   end function csv_text

   !> A number with ten digits, as tables have it.
   pure function ten_digits(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=20) :: buffer

      write (buffer, '(es18.9e3)') value
      text = trim(adjustl(buffer))
   end function ten_digits

   !> Text in lower case (ASCII).
   pure function lower(text)
      character(len=*), intent(in) :: text
      character(len=len(text)) :: lower
      integer :: i, code

      do i = 1, len(text)
         code = iachar(text(i:i))
         if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
         lower(i:i) = achar(code)
      end do
   end function lower

   !> Text in single quotes, trimmed.
   pure function quoted(text)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted

      quoted = "'"//trim(text)//"'"
   end function quoted

   !> The candidate nearest to a misspelt word by edit distance; empty when none is near (distance above half the word).
   pure function nearest_word(word, candidates)
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: candidates(:)
      character(len=:), allocatable :: nearest_word
      integer :: i, distance, best

      nearest_word = ''
      best = max(1, len_trim(word)/2) + 1
      do i = 1, size(candidates)
         distance = edit_distance(lower(trim(word)), lower(trim(candidates(i))))
         if (distance < best) then
            best = distance
            nearest_word = trim(candidates(i))
         end if
      end do
   end function nearest_word

   !> Edits that turn one word into another: a letter more, less or changed, or two neighbours exchanged.
   pure integer function edit_distance(a, b)
      character(len=*), intent(in) :: a, b
      integer :: edits(-1:len(a), -1:len(b)), i, j

      edits = 0
      edits(0:, 0) = [(i, i=0, len(a))]
      edits(0, 0:) = [(j, j=0, len(b))]
      do j = 1, len(b)
         do i = 1, len(a)
            edits(i, j) = min(edits(i - 1, j) + 1, edits(i, j - 1) + 1, &
                              edits(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
            if (i == 1 .or. j == 1) cycle
            if (a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)) then
               edits(i, j) = min(edits(i, j), edits(i - 2, j - 2) + 1)
            end if
         end do
      end do
      edit_distance = edits(len(a), len(b))
   end function edit_distance

end module text_m
