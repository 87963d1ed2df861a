!> The group &joint: the fractures of one physical curve of the mesh, and the law they follow.
module joint_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use bounds_m, only: least_penalty, most_penalty
   use errors_m, only: error_list_t
   use joint_law_m, only: joint_law_t
   use law_list_m, only: law_names, new_law, all_variables
   use law_variable_m, only: law_variable_t, law_settings_t, complaints_t, defaults, default_word, same_variable
   use text_m, only: exact_text, quoted
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, option_length, check_range, check_choice, check_given, check_idle
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_joint, write_joint, list_warnings

   !> &joint
   type, public :: joint_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical curve of the mesh
      character(len=name_length) :: group = ''
      !> Law of the joint: 'jcm_mean' has one JRC and JCS from the mean block-edge length
      character(len=option_length) :: law = 'jcm'
      !> Closure and dilation update the aperture only, or push the walls
      character(len=option_length) :: coupling = 'paper'
      !> Spring-slider, or eq 4 with the relative velocity
      character(len=option_length) :: friction = 'slider'
      !> Normal stiffness of the contact: the joint's own, or the penalty
      character(len=option_length) :: normal = 'joint'
      !> Force between the walls: wall contact, or Munjiza's potential (eq 3)
      character(len=option_length) :: contact = 'wall'
      !> Penalty [Pa]; penalty_factor times young of the wall rock when not given
      real(wp) :: penalty = unset
      !> Normal stress of the law: from the contact force, or from the walls' elements (eq 32)
      character(len=option_length) :: normal_stress = 'contact'
      !> Aperture of walls that part: with the dilation they keep, or eq 31 to the letter
      character(len=option_length) :: aperture = 'continuous'
      !> Variables of the laws, those that are not given with their defaults
      type(law_settings_t) :: settings
   end type joint_t

   character(len=*), parameter :: couplings(*) = ['paper  ', 'coupled']
   character(len=*), parameter :: frictions(*) = ['slider  ', 'velocity']
   character(len=*), parameter :: normals(*) = ['joint  ', 'penalty']
   character(len=*), parameter :: contacts(*) = ['wall     ', 'potential']
   character(len=*), parameter :: normal_stresses(*) = ['contact', 'walls  ']
   character(len=*), parameter :: apertures(*) = ['continuous', 'eq31      ']

contains

   !> Read and check the group.
   subroutine read_joint(slice, joint, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(joint_t), intent(out) :: joint
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables
      type(law_variable_t), allocatable :: of_laws(:)
      integer :: i

      joint%line = slice%line
      allocate (of_laws, source=all_variables())
      joint%settings = defaults(of_laws)
      call variables%read(slice)
      call name_variables(variables, of_laws, joint)
      call variables%end_reading(errors)
      call check_joint(slice, joint, errors)
      do i = 1, size(of_laws)
         call check_law_variable(slice, of_laws(i), joint%settings, errors)
      end do
      call check_contact(slice, joint, errors)
      call check_law(slice, joint, errors)
   end subroutine read_joint

   !> The variables, for reading and writing: every variable of the laws is read; of those of other laws than that of the joint
   !> the ones that are given are written.
   subroutine name_variables(variables, of_laws, joint)
      type(group_variables_t), intent(inout) :: variables
      type(law_variable_t), intent(in) :: of_laws(:)
      type(joint_t), intent(inout) :: joint
      integer :: i

      call variables%keep('group', joint%group)
      call variables%keep('law', joint%law)
      do i = 1, size(of_laws)
         if (variables%writing) then
            if (.not. (belongs(joint%law, of_laws(i)) .or. is_given(joint%settings, of_laws(i)))) cycle
         end if
         call name_law_variable(variables, of_laws(i), joint%settings)
      end do
      call variables%keep('coupling', joint%coupling)
      call variables%keep('friction', joint%friction)
      call variables%keep('normal', joint%normal)
      call variables%keep('contact', joint%contact)
      call variables%keep('penalty', joint%penalty, 'penalty_factor times young of the wall rock')
      call variables%keep('normal_stress', joint%normal_stress)
      call variables%keep('aperture', joint%aperture)
   end subroutine name_variables

   !> The variable of a law. Choices among which are numbers may do without quotes.
   subroutine name_law_variable(variables, variable, settings)
      type(group_variables_t), intent(inout) :: variables
      type(law_variable_t), intent(in) :: variable
      type(law_settings_t), intent(inout) :: settings
      character(len=option_length) :: word
      real(wp) :: number

      if (variable%choices == '') then
         number = settings%number(variable%name)
         if (variable%instead == '') then
            call variables%keep(trim(variable%name), number)
         else
            call variables%keep(trim(variable%name), number, trim(variable%instead))
         end if
         call settings%set_number(variable%name, number)
      else
         word = settings%word(variable%name)
         if (has_number(words_of(variable%choices))) then
            call variables%keep_word(trim(variable%name), word)
         else
            call variables%keep(trim(variable%name), word)
         end if
         call settings%set_word(variable%name, word)
      end if
   end subroutine name_law_variable

   !> Is a whole number among these words?
   pure logical function has_number(words)
      character(len=*), intent(in) :: words(:)
      integer :: i

      has_number = any([(verify(trim(words(i)), '0123456789') == 0, i=1, size(words))])
   end function has_number

   !> Ranges and choices of what all laws share.
   subroutine check_joint(slice, joint, errors)
      type(group_slice_t), intent(in) :: slice
      type(joint_t), intent(inout) :: joint
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', joint%group, 'a physical curve of the mesh')
      call check_choice(errors, slice, 'law', joint%law, law_names)
      call check_choice(errors, slice, 'coupling', joint%coupling, couplings)
      call check_choice(errors, slice, 'friction', joint%friction, frictions)
      call check_choice(errors, slice, 'normal', joint%normal, normals)
      call check_choice(errors, slice, 'contact', joint%contact, contacts)
      call check_choice(errors, slice, 'normal_stress', joint%normal_stress, normal_stresses)
      call check_choice(errors, slice, 'aperture', joint%aperture, apertures)
      call check_range(errors, slice, 'penalty', joint%penalty, least=least_penalty, most=most_penalty)
   end subroutine check_joint

   !> A law's variable is within its range or among its choices.
   subroutine check_law_variable(slice, variable, settings, errors)
      type(group_slice_t), intent(in) :: slice
      type(law_variable_t), intent(in) :: variable
      type(law_settings_t), intent(inout) :: settings
      type(error_list_t), intent(inout) :: errors
      character(len=option_length) :: word
      !> Limits that do not exist are not allocated, and thereby not present
      real(wp), allocatable :: above, below, least, most

      if (variable%choices /= '') then
         word = settings%word(variable%name)
         call check_choice(errors, slice, trim(variable%name), word, words_of(variable%choices))
         call settings%set_word(variable%name, word)
         return
      end if
      if (is_set(variable%above)) above = variable%above
      if (is_set(variable%below)) below = variable%below
      if (is_set(variable%least)) least = variable%least
      if (is_set(variable%most)) most = variable%most
      call check_range(errors, slice, trim(variable%name), settings%number(variable%name), above, below, least, most)
   end subroutine check_law_variable

   !> The words of a list.
   pure function words_of(list) result(words)
      !> Words between blanks
      character(len=*), intent(in) :: list
      character(len=option_length), allocatable :: words(:)
      character(len=len(list)) :: rest
      integer :: blank

      allocate (words(0))
      rest = list
      do while (rest /= '')
         blank = index(rest, ' ')
         words = [character(len=option_length) :: words, rest(:blank - 1)]
         rest = adjustl(rest(blank:))
      end do
   end function words_of

   !> The contact chosen can give the law its stresses.
   subroutine check_contact(slice, joint, errors)
      type(group_slice_t), intent(in) :: slice
      type(joint_t), intent(in) :: joint
      type(error_list_t), intent(inout) :: errors

      if (joint%coupling == 'coupled' .and. joint%contact == 'potential') then
         call errors%add(slice%place('coupling')//" = 'coupled': dilation does not push the walls of contact = 'potential'; "// &
                         "must be 'paper', or contact = 'wall'")
      end if
      if (joint%normal == 'joint') then
         if (joint%contact == 'potential') then
            call errors%add(slice%place('contact')//": has a penalty only, not the stiffness of normal = 'joint'; "// &
                            "must be 'wall', or go with normal = 'penalty'")
         end if
         call check_idle(errors, slice, 'penalty', joint%penalty, "normal = 'penalty'")
      end if
   end subroutine check_contact

   !> What the law says of its settings; it knows the options that all laws share too.
   subroutine ask_law(joint, complaints)
      type(joint_t), intent(in) :: joint
      type(complaints_t), intent(out) :: complaints
      type(law_settings_t) :: settings
      class(joint_law_t), allocatable :: law

      settings = joint%settings
      call settings%set_word('law', joint%law)
      call settings%set_word('coupling', joint%coupling)
      call settings%set_word('friction', joint%friction)
      call settings%set_word('normal', joint%normal)
      call settings%set_word('contact', joint%contact)
      call new_law(joint%law, law)
      if (allocated(law)) call law%check(settings, complaints)
   end subroutine ask_law

   !> Errors of the law. A value that is missing and was given could not be read, which has been reported.
   subroutine check_law(slice, joint, errors)
      type(group_slice_t), intent(in) :: slice
      type(joint_t), intent(in) :: joint
      type(error_list_t), intent(inout) :: errors
      type(complaints_t) :: complaints
      character(len=:), allocatable :: name
      integer :: i

      call ask_law(joint, complaints)
      do i = 1, complaints%count()
         if (.not. complaints%item(i)%is_error) cycle
         name = trim(complaints%item(i)%name)
         if (complaints%item(i)%is_missing .and. slice%find(name) > 0) cycle
         call errors%add(slice%place(name)//complaints%item(i)%text)
      end do
   end subroutine check_law

   !> Warnings of the law, and variables that are given for others.
   subroutine list_warnings(joint, place, warnings)
      type(joint_t), intent(in) :: joint
      !> Start of the message
      character(len=*), intent(in) :: place
      type(error_list_t), intent(inout) :: warnings
      type(complaints_t) :: complaints
      type(law_variable_t), allocatable :: of_laws(:)
      character(len=:), allocatable :: idle
      integer :: i

      call ask_law(joint, complaints)
      do i = 1, complaints%count()
         associate (complaint => complaints%item(i))
            if (complaint%is_error) cycle
            if (complaint%name == '') then
               call warnings%add(place//complaint%text)
            else
               call warnings%add(place//trim(complaint%name)//' = '//exact_text(joint%settings%number(complaint%name))// &
                                 complaint%text)
            end if
         end associate
      end do
      idle = ''
      allocate (of_laws, source=all_variables())
      do i = 1, size(of_laws)
         if (.not. belongs(joint%law, of_laws(i)) .and. is_given(joint%settings, of_laws(i))) &
            idle = idle//', '//trim(of_laws(i)%name)
      end do
      if (idle /= '') call warnings%add(place//'law = '//quoted(trim(joint%law))//': '//idle(3:)//' have no effect')
   end subroutine list_warnings

   !> Is it a variable of this law?
   logical function belongs(name, variable)
      !> Name of the law
      character(len=*), intent(in) :: name
      type(law_variable_t), intent(in) :: variable
      class(joint_law_t), allocatable :: law

      call new_law(name, law)
      belongs = .false.
      if (allocated(law)) belongs = any(same_variable(law%variables(), variable))
   end function belongs

   !> Has a variable another value than it has by default?
   pure logical function is_given(settings, variable)
      type(law_settings_t), intent(in) :: settings
      type(law_variable_t), intent(in) :: variable

      if (variable%choices == '') then
         is_given = abs(settings%number(variable%name) - variable%default) > 0.0_wp
      else
         is_given = settings%word(variable%name) /= default_word(variable)
      end if
   end function is_given

   !> Write the effective group: what all laws share, every variable of its law, and those of others that are given.
   subroutine write_joint(joint, unit)
      type(joint_t), intent(in) :: joint
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(joint_t) :: effective

      effective = joint
      call variables%write(unit, 'joint')
      call name_variables(variables, all_variables(), effective)
      call variables%end_writing()
   end subroutine write_joint

end module joint_group_m
