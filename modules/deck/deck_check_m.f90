!> Combinations: what no single variable can tell is wrong. Everything is reported in one go, before anything is set up.
module deck_check_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use errors_m, only: error_list_t
   use text_m, only: exact_text, nearest_word, quoted, to_text
   use deck_variable_m, only: name_length
   use boundary_group_m, only: boundary_t, prescribable, prescribed, check_clash, every_stage
   use joint_group_m, only: list_warnings
   use deck_m, only: deck_t, deck_path, old_cohesive
   implicit none
   private

   public :: check_deck, find_warnings

contains

   !> Check the combinations of a deck.
   subroutine check_deck(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      integer :: i

      ! A deck that could not be opened has been reported, and has nothing to check.
      if (.not. allocated(deck%stage)) return
      call check_present(deck, errors)
      call check_mesh_file(deck, errors)
      call check_repeated_names(deck, errors)
      call check_stage_names(deck, errors)
      call check_removals(deck, errors)
      if (deck%in_situ%line > 0) call check_in_situ(deck, errors)
      call check_crack_joints(deck, errors)
      if (deck%run%solver == 'implicit') call check_implicit(deck, errors)
      if (deck%run%solver == 'relaxation') call check_relaxation(deck, errors)
      do i = 1, size(deck%boundary)
         call check_boundary(deck, i, errors)
      end do
      do i = 1, size(deck%pore_pressure)
         call check_pore_pressure(deck, i, errors)
      end do
   end subroutine check_deck

   !> A pore pressure acts in a known stage, and once in each for a group.
   subroutine check_pore_pressure(deck, n, errors)
      type(deck_t), intent(in) :: deck
      !> Pore pressure to check
      integer, intent(in) :: n
      type(error_list_t), intent(inout) :: errors
      integer :: i

      associate (mine => deck%pore_pressure(n))
         call check_stage(deck, 'pore_pressure', mine%line, mine%stage, errors)
         do i = 1, n - 1
            if (deck%pore_pressure(i)%group /= mine%group .or. deck%pore_pressure(i)%stage /= mine%stage) cycle
            call errors%add(at(deck, mine%line, 'pore_pressure')//'pressure: already given in line '// &
                            to_text(deck%pore_pressure(i)%line)//' for the same group and stage; give it once')
         end do
      end associate
   end subroutine check_pore_pressure

   !> What the implicit solver cannot do: anything that needs velocities or the general contact.
   subroutine check_implicit(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=*), parameter :: instead = '; solver = ''implicit'' cannot do that: use '
      integer :: i

      do i = 1, size(deck%joint)
         associate (joint => deck%joint(i))
            if (joint%contact == 'potential') call errors%add(at(deck, joint%line, 'joint')// &
                                                              'contact = ''potential'''//instead//'''wall''')
         end associate
      end do
      call check_at_rest(deck, instead, errors)
   end subroutine check_implicit

   !> What the relaxation solver cannot do: anything that needs velocities.
   subroutine check_relaxation(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=*), parameter :: instead = '; solver = ''relaxation'' cannot do that: use '

      if (deck%contact%friction == 'velocity') call errors%add(at(deck, deck%contact%line, 'contact')// &
                                                               'friction = ''velocity'''//instead//'''slider''')
      call check_at_rest(deck, instead, errors)
   end subroutine check_relaxation

   !> What no solver can do that knows states of rest alone.
   subroutine check_at_rest(deck, instead, errors)
      type(deck_t), intent(in) :: deck
      !> Which solver cannot do it, for the messages
      character(len=*), intent(in) :: instead
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, size(deck%joint)
         associate (joint => deck%joint(i))
            if (joint%friction == 'velocity') call errors%add(at(deck, joint%line, 'joint')// &
                                                              'friction = ''velocity'''//instead//'''slider''')
         end associate
      end do
      do i = 1, size(deck%initial)
         call errors%add(at(deck, deck%initial(i)%line, 'initial')//'initial velocities'//instead//'solver = ''explicit''')
      end do
      do i = 1, size(deck%boundary)
         if (deck%boundary(i)%absorbing) call errors%add(at(deck, deck%boundary(i)%line, 'boundary')//'absorbing'//instead// &
                                                         'solver = ''explicit''')
      end do
   end subroutine check_at_rest

   !> Groups without which there is nothing to run.
   subroutine check_present(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors

      if (deck%run%line == 0) call errors%add(deck%path//': &run is missing: it names the mesh')
      ! Flow alone needs neither rock that deforms nor stages
      if (deck%flow%line > 0 .and. size(deck%stage) == 0) return
      if (size(deck%material) == 0) call errors%add(deck%path//': &material is missing: at least one is needed')
      if (size(deck%stage) == 0) call errors%add(deck%path//': &stage is missing: at least one is needed')
   end subroutine check_present

   !> The mesh file must be there.
   subroutine check_mesh_file(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      logical :: exists

      if (deck%run%mesh == '') return
      inquire (file=deck_path(deck, deck%run%mesh), exist=exists)
      if (.not. exists) then
         call errors%add(at(deck, deck%run%line, 'run')//'mesh = '//quoted(deck%run%mesh)//': there is no file '// &
                         deck_path(deck, deck%run%mesh)//'; must be a mesh file, its path relative to the deck')
      end if
   end subroutine check_mesh_file

   !> Materials, joints and initial velocities have one group of the mesh each; stages differ in name.
   subroutine check_repeated_names(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors

      call check_distinct(deck, 'material', 'group', deck%material%group, deck%material%line, errors)
      call check_distinct(deck, 'joint', 'group', deck%joint%group, deck%joint%line, errors)
      call check_distinct(deck, 'cohesive', 'group', deck%cohesive%group, deck%cohesive%line, errors)
      call check_distinct(deck, 'initial', 'group', deck%initial%group, deck%initial%line, errors)
      call check_distinct(deck, 'stage', 'name', deck%stage%name, deck%stage%line, errors)
   end subroutine check_repeated_names

   !> The law of new cracks is that of a &joint of the deck, or Coulomb friction.
   subroutine check_crack_joints(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: nearest
      integer :: i

      do i = 1, size(deck%cohesive)
         associate (name => deck%cohesive(i)%crack_joint)
            if (name == '' .or. any(deck%joint%group == name)) cycle
            nearest = nearest_word(name, deck%joint%group)
            if (nearest /= '') nearest = '; did you mean '//quoted(nearest)//'?'
            call errors%add(at(deck, deck%cohesive(i)%line, 'cohesive')//'crack_joint = '//quoted(name)// &
                            ': no &joint has this group'//nearest)
         end associate
      end do
   end subroutine check_crack_joints

   !> No two groups of a kind may have the same name.
   subroutine check_distinct(deck, group, variable, name, line, errors)
      type(deck_t), intent(in) :: deck
      !> Group and variable, for the message
      character(len=*), intent(in) :: group, variable
      !> Name given in each group, and line of each group
      character(len=*), intent(in) :: name(:)
      integer, intent(in) :: line(:)
      type(error_list_t), intent(inout) :: errors
      integer :: i, first

      do i = 2, size(name)
         if (name(i) == '') cycle
         do first = 1, i - 1
            if (name(first) == name(i)) exit
         end do
         if (first < i) then
            call errors%add(at(deck, line(i), group)//variable//' = '//quoted(name(i))// &
                            ': already has a &'//group//', in line '//to_text(line(first))//'; give it once')
         end if
      end do
   end subroutine check_distinct

   !> A boundary acts in a known stage, and agrees with the boundaries before it.
   subroutine check_boundary(deck, n, errors)
      type(deck_t), intent(in) :: deck
      !> Boundary to check
      integer, intent(in) :: n
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: place
      integer :: i

      place = at(deck, deck%boundary(n)%line, 'boundary')
      call check_stage(deck, 'boundary', deck%boundary(n)%line, deck%boundary(n)%stage, errors)
      do i = 1, n - 1
         associate (mine => deck%boundary(n), other => deck%boundary(i))
            ! A condition of one stage replaces that of 'all' stages, so only those of the same stage can disagree.
            if (other%group /= mine%group .or. mine%group == '' .or. other%stage /= mine%stage) cycle
            call check_clash(place, prescribed(mine), prescribed(other), &
                             ' (line '//to_text(other%line)//', same group and stage)', errors)
            if (other%stage == mine%stage) &
               call check_repeated(place, prescribed(mine), prescribed(other), other%line, errors)
         end associate
      end do
   end subroutine check_boundary

   !> The stage a group acts in is 'all' or one of the deck's.
   subroutine check_stage(deck, group, line, stage, errors)
      type(deck_t), intent(in) :: deck
      !> Group of the deck, its line, and the stage it names
      character(len=*), intent(in) :: group, stage
      integer, intent(in) :: line
      type(error_list_t), intent(inout) :: errors
      character(len=name_length), allocatable :: names(:)
      character(len=:), allocatable :: nearest

      allocate (names(size(deck%stage) + 1))
      names(1) = every_stage
      names(2:) = deck%stage%name
      if (stage == '' .or. any(names == stage)) return
      nearest = nearest_word(stage, names)
      if (nearest /= '') nearest = '; did you mean '//quoted(nearest)//'?'
      call errors%add(at(deck, line, group)//'stage = '//quoted(stage)// &
                      ': there is no such stage; must be one of '//list(names)//nearest)
   end subroutine check_stage

   !> The same variable may not be prescribed twice.
   subroutine check_repeated(place, mine, others, line, errors)
      !> Start of the message
      character(len=*), intent(in) :: place
      logical, intent(in) :: mine(:), others(:)
      !> Line of the other boundary
      integer, intent(in) :: line
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, size(mine)
         if (mine(i) .and. others(i)) then
            call errors%add(place//trim(prescribable(i))//': already prescribed in line '//to_text(line)// &
                            ' for the same group and stage; give it once')
         end if
      end do
   end subroutine check_repeated

   !> A stage may not have the name that stands for every stage.
   subroutine check_stage_names(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, size(deck%stage)
         if (deck%stage(i)%name /= every_stage) cycle
         call errors%add(at(deck, deck%stage(i)%line, 'stage')//'name = '//quoted(every_stage)// &
                         ': stands for every stage; must be another name')
      end do
   end subroutine check_stage_names

   !> In-situ stress needs joints whose walls press by their closure and hold by slip.
   subroutine check_in_situ(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=*), parameter :: instead = ' cannot start under &in_situ: use '
      integer :: i

      do i = 1, size(deck%joint)
         associate (joint => deck%joint(i))
            if (joint%contact == 'potential') call errors%add(at(deck, joint%line, 'joint')// &
                                                              'contact = ''potential'''//instead//'''wall''')
            if (joint%friction == 'velocity') call errors%add(at(deck, joint%line, 'joint')// &
                                                              'friction = ''velocity'''//instead//'''slider''')
         end associate
      end do
   end subroutine check_in_situ

   !> Rock is taken out once, and not where fluid flows through what is left: the equations of flow do not know of it.
   subroutine check_removals(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: what
      integer :: i, first

      do i = 1, size(deck%stage)
         if (deck%stage(i)%remove == '') cycle
         what = at(deck, deck%stage(i)%line, 'stage')//'remove = '//quoted(deck%stage(i)%remove)
         first = findloc(deck%stage(:i)%remove, deck%stage(i)%remove, dim=1)
         if (first < i) call errors%add(what//': is taken out by the stage in line '//to_text(deck%stage(first)%line)// &
                                        ' already; give it once')
         if (deck%flow%line > 0) call errors%add(what//': &flow does not know of rock that is taken out; leave out one of the two')
      end do
   end subroutine check_removals

   !> What is valid, but seldom meant.
   subroutine find_warnings(deck, warnings)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: warnings
      integer :: i

      do i = 1, size(deck%old_name)
         call warnings%add(deck%path//':'//to_text(deck%old_name(i))//': &'//old_cohesive//' is called &cohesive now; its old '// &
                           'name is read in this version for the last time')
      end do
      do i = 1, size(deck%material)
         call warn_of_material(deck, i, warnings)
      end do
      do i = 1, size(deck%joint)
         call list_warnings(deck%joint(i), at(deck, deck%joint(i)%line, 'joint'), warnings)
      end do
      do i = 1, size(deck%stage)
         associate (stage => deck%stage(i))
            if (is_set(stage%equilibrium) .and. stage%rest_time > 0) then
               call warnings%add(at(deck, stage%line, 'stage')//'rest_time = '//exact_text(stage%rest_time)// &
                                 ': has no effect with equilibrium; the rest ends there, or after max_rest_time')
            end if
         end associate
      end do
   end subroutine find_warnings

   !> Units are the usual slip: g/cm3 for kg/m3, GPa for Pa.
   subroutine warn_of_material(deck, n, warnings)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: n
      type(error_list_t), intent(inout) :: warnings
      !> Lightest rock [kg/m3] and softest rock or soil [Pa] that is not surprising
      real(wp), parameter :: light = 500.0_wp, soft = 1.0e5_wp
      character(len=:), allocatable :: place

      associate (material => deck%material(n))
         place = at(deck, material%line, 'material')
         if (material%density < light) then
            call warnings%add(place//'density = '//exact_text(material%density)//': is it in kg/m3?')
         end if
         if (material%young < soft) call warnings%add(place//'young = '//exact_text(material%young)//': is it in Pa?')
         if (material%poisson < 0) then
            call warnings%add(place//'poisson = '//exact_text(material%poisson)//': is it meant to be negative?')
         end if
      end associate
   end subroutine warn_of_material

   !> 'input.nml:12: &joint '
   pure function at(deck, line, group)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: line
      character(len=*), intent(in) :: group
      character(len=:), allocatable :: at

      at = deck%path//':'//to_text(line)//': &'//group//' '
   end function at

   !> Names in a row.
   pure function list(names)
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: list
      integer :: i

      list = trim(names(1))
      do i = 2, size(names)
         list = list//', '//trim(names(i))
      end do
   end function list

end module deck_check_m
