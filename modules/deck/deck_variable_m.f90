!> What values of variables look like, kind by kind, and the checks of range and choice that all groups share. Every message names
!> file, line, group, variable and the value found.
module deck_variable_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use errors_m, only: error_list_t
   use text_m, only: exact_text, lower, nearest_word, quoted, to_text
   use deck_scan_m, only: group_slice_t
   implicit none
   private

   public :: what_is_wrong, suggestion, check_range, check_size, check_least, check_choice, check_given, check_needed, check_idle

   !> Lengths of an option's text, of a name (stage, physical group), of a path or title
   integer, parameter, public :: option_length = 32, name_length = 64, path_length = 512

   !> Kinds of variable; a_word: text in quotes, or a whole number
   integer, parameter, public :: a_number = 1, a_count = 2, a_switch = 3, an_option = 4, a_name = 5, a_path = 6, a_word = 7

   !> Decimal exponents beyond this are not meant, and would trap or become infinite when read
   integer, parameter :: largest_exponent = 300
   !> More digits than this overflow a default integer
   integer, parameter :: most_digits = 9

contains

   !> A number must lie in a range; a number not given passes, unless it is required.
   subroutine check_range(errors, slice, name, value, above, below, least, most, required)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value
      !> Limits that are themselves outside the range
      real(wp), intent(in), optional :: above, below
      !> Limits that belong to the range
      real(wp), intent(in), optional :: least, most
      !> Must be given
      logical, intent(in), optional :: required
      character(len=:), allocatable :: range
      logical :: valid, needed

      needed = .false.
      if (present(required)) needed = required
      valid = .true.
      range = ''
      if (present(above)) call limit('above', value > above, above)
      if (present(least)) call limit('at least', value >= least, least)
      if (present(below)) call limit('below', value < below, below)
      if (present(most)) call limit('at most', value <= most, most)
      if (.not. is_set(value)) then
         if (needed .and. slice%find(name) == 0) call errors%add(slice%place(name)//' is missing: a number '//range)
      else if (.not. valid) then
         call errors%add(slice%place(name)//': must be '//range)
      end if

   contains

      subroutine limit(words, holds, bound)
         character(len=*), intent(in) :: words
         logical, intent(in) :: holds
         real(wp), intent(in) :: bound

         valid = valid .and. holds
         if (range /= '') range = range//' and '
         range = range//words//' '//exact_text(bound)
      end subroutine limit

   end subroutine check_range

   !> A number of either sign must be 0 or have a size within limits; a number not given passes.
   subroutine check_size(errors, slice, name, value, least, most)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value
      !> Limits of its size
      real(wp), intent(in) :: least, most

      if (.not. is_set(value) .or. abs(value) <= 0.0_wp) return
      if (abs(value) >= least .and. abs(value) <= most) return
      call errors%add(slice%place(name)//': must be at least '//exact_text(-most)//' and at most '//exact_text(most)// &
                      ', and 0 or at least '//exact_text(least)//' in size')
   end subroutine check_size

   !> A count must not be less than a limit.
   subroutine check_least(errors, slice, name, value, least)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      integer, intent(in) :: value, least

      if (value < least) call errors%add(slice%place(name)//': must be a whole number of at least '//to_text(least))
   end subroutine check_least

   !> An option must be one of a list; it is kept in lower case.
   subroutine check_choice(errors, slice, name, value, choices)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      character(len=*), intent(inout) :: value
      !> Valid options, in lower case
      character(len=*), intent(in) :: choices(:)
      character(len=:), allocatable :: nearest, list
      integer :: i

      value = lower(value)
      if (any(choices == value)) return
      list = quoted(choices(1))
      do i = 2, size(choices)
         list = list//', '//quoted(choices(i))
      end do
      nearest = nearest_word(value, choices)
      if (nearest /= '') list = list//'; did you mean '//quoted(nearest)//'?'
      call errors%add(slice%place(name)//': must be one of '//list)
   end subroutine check_choice

   !> A name or path must be given.
   subroutine check_given(errors, slice, name, value, meaning)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: value
      !> What is wanted, for the message
      character(len=*), intent(in) :: meaning

      if (value /= '') return
      if (slice%find(name) == 0) then
         call errors%add(slice%place(name)//' is missing: '//meaning)
      else if (verify(slice%assignment(slice%find(name))%value, '''" ') == 0) then
         call errors%add(slice%place(name)//' is empty: '//meaning)
      end if
   end subroutine check_given

   !> A variable that another one makes necessary must be given.
   subroutine check_needed(errors, slice, name, value, reason)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value
      !> What makes it necessary
      character(len=*), intent(in) :: reason

      ! A value that was given and could not be read has been reported already.
      if (is_set(value) .or. slice%find(name) > 0) return
      call errors%add(slice%place(name)//' is missing: '//reason//' needs it')
   end subroutine check_needed

   !> A variable that has no effect without another one must not be given.
   subroutine check_idle(errors, slice, name, value, condition)
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), intent(in) :: slice
      !> Variable
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value
      !> When it would have an effect
      character(len=*), intent(in) :: condition

      if (.not. is_set(value)) return
      call errors%add(slice%place(name)//': has no effect without '//condition//'; give both or neither')
   end subroutine check_idle

   !> 'did you mean jrc0?', or the whole list when nothing is near.
   pure function suggestion(word, names)
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: suggestion
      integer :: i

      suggestion = nearest_word(word, names)
      if (suggestion /= '') then
         suggestion = 'did you mean '//suggestion//'?'
      else
         suggestion = 'valid: '//trim(names(1))
         do i = 2, size(names)
            suggestion = suggestion//', '//trim(names(i))
         end do
      end if
   end function suggestion

   !> Why a value as written cannot be one of this kind (empty: it can).
   pure function what_is_wrong(value, values, kind) result(wrong)
      !> Value as written, and how many values it holds
      character(len=*), intent(in) :: value
      integer, intent(in) :: values, kind
      character(len=:), allocatable :: wrong

      wrong = ''
      if (values == 0) then
         wrong = 'no value given; must be '//kind_name(kind)
      else if (values > 1) then
         wrong = 'must be one value only: '//kind_name(kind)
      else
         select case (kind)
         case (a_number)
            if (.not. is_number(value)) wrong = 'must be '//kind_name(kind)
         case (a_count)
            if (.not. is_whole_number(value)) wrong = 'must be '//kind_name(kind)
         case (a_switch)
            if (.not. is_switch(value)) wrong = 'must be '//kind_name(kind)
         case (an_option)
            wrong = text_fault(value, option_length, kind)
         case (a_word)
            if (.not. is_whole_number(value)) wrong = text_fault(value, option_length, kind)
         case (a_name)
            wrong = text_fault(value, name_length, kind)
         case default
            wrong = text_fault(value, path_length, kind)
         end select
      end if
   end function what_is_wrong

   !> What a value of this kind looks like.
   pure function kind_name(kind)
      integer, intent(in) :: kind
      character(len=:), allocatable :: kind_name

      select case (kind)
      case (a_number)
         kind_name = 'a number, such as 0.5 or 2e9'
      case (a_count)
         kind_name = 'a whole number'
      case (a_switch)
         kind_name = '.true. or .false.'
      case default
         kind_name = "text in quotes"
      end select
   end function kind_name

   !> Why a value cannot be a text of this kind (empty: it can).
   pure function text_fault(value, length, kind) result(wrong)
      character(len=*), intent(in) :: value
      !> Longest text
      integer, intent(in) :: length, kind
      character(len=:), allocatable :: wrong
      integer, parameter :: quotes = 2

      wrong = ''
      if (scan(value(1:1), '''"') == 0) then
         wrong = 'must be '//kind_name(kind)
      else if (len(value) - quotes > length) then
         wrong = 'the text is too long: at most '//to_text(length)//' characters'
      end if
   end function text_fault

   !> Is this a decimal number such as -1, .5, 2.5e-3 or 1d6, of a size that can be held?
   pure logical function is_number(text)
      character(len=*), intent(in) :: text
      integer :: letter, point
      character(len=:), allocatable :: mantissa, exponent

      letter = scan(text, 'eEdD')
      if (letter == 0) then
         mantissa = without_sign(text)
         exponent = '0'
      else
         mantissa = without_sign(text(:letter - 1))
         exponent = without_sign(text(letter + 1:))
      end if
      point = index(mantissa, '.')
      if (point > 0) mantissa = mantissa(:point - 1)//mantissa(point + 1:)
      is_number = is_digits(mantissa) .and. is_digits(exponent)
      if (is_number) is_number = small_enough(exponent)
   end function is_number

   !> Is this string of digits an exponent that can be held?
   pure logical function small_enough(exponent)
      character(len=*), intent(in) :: exponent
      integer :: value

      small_enough = len(exponent) <= most_digits
      if (.not. small_enough) return
      read (exponent, *) value
      small_enough = value <= largest_exponent
   end function small_enough

   pure logical function is_whole_number(text)
      character(len=*), intent(in) :: text

      is_whole_number = is_digits(without_sign(text)) .and. len(without_sign(text)) <= most_digits
   end function is_whole_number

   pure logical function is_switch(text)
      character(len=*), intent(in) :: text

      select case (lower(text))
      case ('.true.', '.false.', 'true', 'false', '.t.', '.f.', 't', 'f')
         is_switch = .true.
      case default
         is_switch = .false.
      end select
   end function is_switch

   pure logical function is_digits(text)
      character(len=*), intent(in) :: text

      is_digits = len(text) > 0 .and. verify(text, '0123456789') == 0
   end function is_digits

   pure function without_sign(text) result(rest)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: rest

      rest = text
      if (len(text) == 0) return
      if (scan(text(1:1), '+-') == 1) rest = text(2:)
   end function without_sign

end module deck_variable_m
