!> The deck variables of a joint law, as the law itself states them, and the values a deck gives them. A law says what it needs;
!> the deck reads it (joint_group_m) and knows no law.
module law_variable_m
   use kinds_m, only: wp
   use constants_m, only: is_set, unset
   implicit none
   private

   public :: a_real, a_choice, defaults, default_word, same_variable

   !> Lengths of a name or word, of a list of words, of a sentence
   integer, parameter, public :: word_length = 32, sentence_length = 160

   !> A variable of &joint
   type, public :: law_variable_t
      !> Name in the deck, with its unit where that is not SI
      character(len=word_length) :: name = ''
      !> What it may be, words between blanks, the default first; none: it is a number
      character(len=sentence_length) :: choices = ''
      !> Default of a number; limits outside and inside its range; unset where there is none
      real(wp) :: default = unset, above = unset, below = unset, least = unset, most = unset
      !> What the law uses when the number is not given
      character(len=sentence_length) :: instead = ''
   end type law_variable_t

   !> A variable with its value
   type :: setting_t
      character(len=word_length) :: name = '', word = ''
      real(wp) :: number = unset
   end type setting_t

   !> What a deck says to a law: its variables, and the options of &joint that all laws share
   type, public :: law_settings_t
      private
      type(setting_t), allocatable :: item(:)
   contains
      procedure :: number
      procedure :: word
      procedure :: has
      procedure :: set_number
      procedure :: set_word
      procedure, private :: find
   end type law_settings_t

   !> What a law has to say of its settings
   type :: complaint_t
      !> Variable it is about, and the rest of the message
      character(len=word_length) :: name
      character(len=:), allocatable :: text
      !> Is it an error? Else a warning. Is a value missing?
      logical :: is_error, is_missing
   end type complaint_t

   !> All it has to say, in its order
   type, public :: complaints_t
      type(complaint_t), allocatable :: item(:)
   contains
      procedure :: count => count_complaints
      procedure :: error
      procedure :: warning
      procedure :: need
      procedure, private :: add
   end type complaints_t

contains

   !> A number.
   pure type(law_variable_t) function a_real(name, default, above, below, least, most, instead) result(variable)
      character(len=*), intent(in) :: name
      real(wp), intent(in), optional :: default, above, below, least, most
      character(len=*), intent(in), optional :: instead

      variable%name = name
      if (present(default)) variable%default = default
      if (present(above)) variable%above = above
      if (present(below)) variable%below = below
      if (present(least)) variable%least = least
      if (present(most)) variable%most = most
      if (present(instead)) variable%instead = instead
   end function a_real

   !> A word.
   pure type(law_variable_t) function a_choice(name, choices) result(variable)
      !> Name; words between blanks, the default first
      character(len=*), intent(in) :: name, choices

      variable%name = name
      variable%choices = choices
   end function a_choice

   !> Settings of variables that a deck does not give.
   pure function defaults(variables) result(settings)
      type(law_variable_t), intent(in) :: variables(:)
      type(law_settings_t) :: settings
      integer :: i

      do i = 1, size(variables)
         associate (variable => variables(i))
            if (variable%choices == '') then
               call settings%set_number(variable%name, variable%default)
            else
               call settings%set_word(variable%name, default_word(variable))
            end if
         end associate
      end do
   end function defaults

   !> The first of its choices.
   pure function default_word(variable) result(word)
      type(law_variable_t), intent(in) :: variable
      character(len=word_length) :: word
      character(len=sentence_length) :: list
      integer :: blank

      list = variable%choices
      blank = index(list, ' ')
      word = list(:blank - 1)
   end function default_word

   !> Do two laws mean the same variable?
   elemental logical function same_variable(one, other)
      type(law_variable_t), intent(in) :: one, other

      same_variable = one%name == other%name
   end function same_variable

   !> Place of a setting (0: there is none).
   pure integer function find(self, name)
      class(law_settings_t), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: i

      find = 0
      if (.not. allocated(self%item)) return
      do i = 1, size(self%item)
         if (self%item(i)%name == name) find = i
      end do
   end function find

   !> Value of a number, unset when the deck does not give it and it has no default.
   pure real(wp) function number(self, name)
      class(law_settings_t), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: i

      number = unset
      i = self%find(name)
      if (i > 0) number = self%item(i)%number
   end function number

   !> The word chosen, '' when there is no such variable.
   pure function word(self, name)
      class(law_settings_t), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=word_length) :: word
      integer :: i

      word = ''
      i = self%find(name)
      if (i > 0) word = self%item(i)%word
   end function word

   !> Does a number have a value?
   pure logical function has(self, name)
      class(law_settings_t), intent(in) :: self
      character(len=*), intent(in) :: name

      has = is_set(self%number(name))
   end function has

   !> Give a variable its value.
   pure subroutine set_number(self, name, value)
      class(law_settings_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value
      type(setting_t) :: setting

      setting%name = name
      setting%number = value
      call put(self, setting)
   end subroutine set_number

   pure subroutine set_word(self, name, value)
      class(law_settings_t), intent(inout) :: self
      character(len=*), intent(in) :: name, value
      type(setting_t) :: setting

      setting%name = name
      setting%word = value
      call put(self, setting)
   end subroutine set_word

   !> Keep a setting in place of the one of that name, or behind the others.
   pure subroutine put(self, setting)
      class(law_settings_t), intent(inout) :: self
      type(setting_t), intent(in) :: setting
      type(setting_t), allocatable :: longer(:)
      integer :: i, n

      i = self%find(setting%name)
      if (i > 0) then
         self%item(i) = setting
         return
      end if
      n = 0
      if (allocated(self%item)) n = size(self%item)
      allocate (longer(n + 1))
      if (n > 0) longer(:n) = self%item
      longer(n + 1) = setting
      call move_alloc(longer, self%item)
   end subroutine put

   !> How many there are.
   pure integer function count_complaints(self)
      class(complaints_t), intent(in) :: self

      count_complaints = 0
      if (allocated(self%item)) count_complaints = size(self%item)
   end function count_complaints

   !> A wrong value: what must be.
   pure subroutine error(self, name, text)
      class(complaints_t), intent(inout) :: self
      character(len=*), intent(in) :: name, text

      call self%add(name, text, is_error=.true., is_missing=.false.)
   end subroutine error

   !> Something to know of a value.
   pure subroutine warning(self, name, text)
      class(complaints_t), intent(inout) :: self
      character(len=*), intent(in) :: name, text

      call self%add(name, text, is_error=.false., is_missing=.false.)
   end subroutine warning

   !> An error when a number that is needed has no value.
   pure subroutine need(self, settings, name, reason)
      class(complaints_t), intent(inout) :: self
      type(law_settings_t), intent(in) :: settings
      !> Variable, and what makes it necessary
      character(len=*), intent(in) :: name, reason

      if (.not. settings%has(name)) &
         call self%add(name, ' is missing: '//reason//' needs it', is_error=.true., is_missing=.true.)
   end subroutine need

   pure subroutine add(self, name, text, is_error, is_missing)
      class(complaints_t), intent(inout) :: self
      character(len=*), intent(in) :: name, text
      logical, intent(in) :: is_error, is_missing
      type(complaint_t), allocatable :: longer(:)
      integer :: n, i

      n = self%count()
      allocate (longer(n + 1))
      do i = 1, n
         longer(i) = self%item(i)
      end do
      longer(n + 1)%name = name
      longer(n + 1)%text = text
      longer(n + 1)%is_error = is_error
      longer(n + 1)%is_missing = is_missing
      call move_alloc(longer, self%item)
   end subroutine add

end module law_variable_m
