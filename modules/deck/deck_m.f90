!> The deck: every setting of a run, read once, checked together and never changed afterwards.
module deck_m
   use errors_m, only: error_list_t
   use text_m, only: nearest_word, to_text
   use deck_scan_m, only: group_slice_t, read_text_file, scan_deck
   use run_group_m, only: run_t, read_run, write_run
   use material_group_m, only: material_t, read_material, write_material
   use joint_group_m, only: joint_t, read_joint, write_joint
   use cohesive_group_m, only: cohesive_group_t, read_cohesive, write_cohesive
   use contact_group_m, only: contact_group_t, read_contact, write_contact
   use boundary_group_m, only: boundary_t, read_boundary, write_boundary
   use initial_group_m, only: initial_t, read_initial, write_initial
   use pore_pressure_group_m, only: pore_pressure_t, read_pore_pressure, write_pore_pressure
   use gravity_group_m, only: gravity_t, read_gravity, write_gravity
   use in_situ_group_m, only: in_situ_t, read_in_situ, write_in_situ
   use fluid_group_m, only: fluid_t, read_fluid, write_fluid
   use flow_group_m, only: flow_t, read_flow, write_flow
   use conduit_group_m, only: conduit_t, read_conduit, write_conduit
   use porous_group_m, only: porous_t, read_porous, write_porous
   use flow_boundary_group_m, only: flow_boundary_t, read_flow_boundary, write_flow_boundary
   use transient_group_m, only: transient_t, read_transient, write_transient
   use stage_group_m, only: stage_t, read_stage, write_stage
   use explicit_group_m, only: explicit_t, read_explicit, write_explicit
   use implicit_group_m, only: implicit_t, read_implicit, write_implicit
   use relaxation_group_m, only: relaxation_t, read_relaxation, write_relaxation
   use plan_group_m, only: plan_t, read_plan, write_plan
   use output_group_m, only: output_t, read_output, write_output
   implicit none
   private

   public :: read_deck, parse_deck, write_deck, deck_path

   !> How a deck that the program has written begins
   character(len=*), parameter, public :: written_by_program = '! Effective deck: every variable, given or default.'

   !> All groups of a deck
   type, public :: deck_t
      !> Path as the user gave it; directory part of it with its last '/' (empty: the working directory)
      character(len=:), allocatable :: path, directory
      type(run_t) :: run
      type(material_t), allocatable :: material(:)
      type(joint_t), allocatable :: joint(:)
      type(cohesive_group_t), allocatable :: cohesive(:)
      type(contact_group_t) :: contact
      type(boundary_t), allocatable :: boundary(:)
      type(initial_t), allocatable :: initial(:)
      type(pore_pressure_t), allocatable :: pore_pressure(:)
      type(gravity_t) :: gravity
      type(in_situ_t) :: in_situ
      type(fluid_t) :: fluid
      type(flow_t) :: flow
      type(transient_t) :: transient
      type(conduit_t), allocatable :: conduit(:)
      type(porous_t), allocatable :: porous(:)
      type(flow_boundary_t), allocatable :: flow_boundary(:)
      type(stage_t), allocatable :: stage(:)
      type(explicit_t) :: explicit
      type(implicit_t) :: implicit
      type(relaxation_t) :: relaxation
      type(plan_t) :: plan
      type(output_t) :: output
      !> Lines of &cohesive groups that have their old name, &fracture
      integer, allocatable :: old_name(:)
   end type deck_t

   !> &cohesive was called so: what rock that may break is, not the fractures that are there before
   character(len=*), parameter, public :: old_cohesive = 'fracture'
   !> Names of all groups, and of those that may be given more than once
   character(len=*), parameter :: repeated_names(*) = &
                                  [character(len=13) :: 'material', 'joint', 'cohesive', 'boundary', 'initial', &
                                                         'pore_pressure', 'conduit', 'porous', 'flow_boundary', 'stage']
   character(len=*), parameter :: group_names(*) = &
                                  [character(len=13) :: 'run', repeated_names, &
                                                         'contact', 'gravity', 'in_situ', 'fluid', 'flow', 'transient', &
                                                         'explicit', 'implicit', 'relaxation', &
                                                         'plan', 'output']

contains

   !> Read a deck file. All errors of form, name, kind and range are reported together.
   subroutine read_deck(path, deck, errors)
      character(len=*), intent(in) :: path
      type(deck_t), intent(out) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      integer :: before

      before = errors%count()
      call read_text_file(path, text, errors)
      ! A file that can't be read has one error, not one for every missing group.
      if (errors%count() > before) return
      call parse_deck(path, text, deck, errors)
   end subroutine read_deck

   !> Read a deck from its text.
   subroutine parse_deck(path, text, deck, errors)
      !> Path of the deck, for the messages and for the files it names
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text
      type(deck_t), intent(out) :: deck
      type(error_list_t), intent(inout) :: errors
      type(group_slice_t), allocatable :: slice(:)
      integer :: i

      deck%path = path
      deck%directory = path(:index(path, '/', back=.true.))
      call scan_deck(path, text, slice, errors)
      call take_old_names(slice, deck%old_name)
      call check_group_names(slice, errors)
      call allocate_repeated(slice, deck)
      do i = 1, size(slice)
         call read_group(slice, i, deck, errors)
      end do
   end subroutine parse_deck

   !> Groups by the names they had in the version before, which are still read.
   subroutine take_old_names(slice, old_name)
      type(group_slice_t), intent(inout) :: slice(:)
      !> Lines of groups that have their old name
      integer, allocatable, intent(out) :: old_name(:)
      integer :: i

      old_name = [integer ::]
      do i = 1, size(slice)
         if (slice(i)%name /= old_cohesive) cycle
         slice(i)%name = 'cohesive'
         old_name = [old_name, slice(i)%line]
      end do
   end subroutine take_old_names

   !> A path of the deck, which is relative to the deck's directory, as the program can open it.
   pure function deck_path(deck, path)
      type(deck_t), intent(in) :: deck
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: deck_path

      deck_path = deck%directory//trim(path)
      if (index(path, '/') == 1) deck_path = trim(path)
   end function deck_path

   !> Read one group into its place.
   subroutine read_group(slice, i, deck, errors)
      type(group_slice_t), intent(in) :: slice(:)
      !> Group to read
      integer, intent(in) :: i
      type(deck_t), intent(inout) :: deck
      type(error_list_t), intent(inout) :: errors
      integer :: n

      n = occurrence(slice, i)
      select case (slice(i)%name)
      case ('run')
         call read_run(slice(i), deck%run, errors)
      case ('material')
         call read_material(slice(i), deck%material(n), errors)
      case ('joint')
         call read_joint(slice(i), deck%joint(n), errors)
      case ('cohesive')
         call read_cohesive(slice(i), deck%cohesive(n), errors)
      case ('contact')
         call read_contact(slice(i), deck%contact, errors)
      case ('boundary')
         call read_boundary(slice(i), deck%boundary(n), errors)
      case ('initial')
         call read_initial(slice(i), deck%initial(n), errors)
      case ('pore_pressure')
         call read_pore_pressure(slice(i), deck%pore_pressure(n), errors)
      case ('gravity')
         call read_gravity(slice(i), deck%gravity, errors)
      case ('in_situ')
         call read_in_situ(slice(i), deck%in_situ, errors)
      case ('fluid')
         call read_fluid(slice(i), deck%fluid, errors)
      case ('flow')
         call read_flow(slice(i), deck%flow, errors)
      case ('transient')
         call read_transient(slice(i), deck%transient, errors)
      case ('conduit')
         call read_conduit(slice(i), deck%conduit(n), errors)
      case ('porous')
         call read_porous(slice(i), deck%porous(n), errors)
      case ('flow_boundary')
         call read_flow_boundary(slice(i), deck%flow_boundary(n), errors)
      case ('stage')
         call read_stage(slice(i), deck%stage(n), errors)
      case ('explicit')
         call read_explicit(slice(i), deck%explicit, errors)
      case ('implicit')
         call read_implicit(slice(i), deck%implicit, errors)
      case ('relaxation')
         call read_relaxation(slice(i), deck%relaxation, errors)
      case ('plan')
         call read_plan(slice(i), deck%plan, errors)
      case ('output')
         call read_output(slice(i), deck%output, errors)
      end select
   end subroutine read_group

   !> Every group is a known one, and given once unless it may be repeated.
   subroutine check_group_names(slice, errors)
      type(group_slice_t), intent(in) :: slice(:)
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: place, nearest
      integer :: i, first

      do i = 1, size(slice)
         place = slice(i)%path//':'//to_text(slice(i)%line)//': &'//slice(i)%name
         if (.not. any(group_names == slice(i)%name)) then
            nearest = nearest_word(slice(i)%name, group_names)
            if (nearest /= '') then
               call errors%add(place//': there is no such group; did you mean &'//nearest//'?')
            else
               call errors%add(place//': there is no such group; valid: '//all_groups())
            end if
         else if (occurrence(slice, i) == 2 .and. .not. any(repeated_names == slice(i)%name)) then
            do first = 1, i - 1
               if (slice(first)%name == slice(i)%name) exit
            end do
            call errors%add(place//': this group may be given once only, and was given in line '// &
                            to_text(slice(first)%line))
         end if
      end do
   end subroutine check_group_names

   !> Names of all groups, for a message.
   pure function all_groups()
      character(len=:), allocatable :: all_groups
      integer :: i

      all_groups = '&'//trim(group_names(1))
      do i = 2, size(group_names)
         all_groups = all_groups//', &'//trim(group_names(i))
      end do
   end function all_groups

   !> Make room for the groups that may be repeated.
   subroutine allocate_repeated(slice, deck)
      type(group_slice_t), intent(in) :: slice(:)
      type(deck_t), intent(inout) :: deck

      allocate (deck%material(number_of(slice, 'material')), deck%joint(number_of(slice, 'joint')), &
                deck%cohesive(number_of(slice, 'cohesive')), &
                deck%boundary(number_of(slice, 'boundary')), deck%initial(number_of(slice, 'initial')), &
                deck%pore_pressure(number_of(slice, 'pore_pressure')), &
                deck%conduit(number_of(slice, 'conduit')), deck%porous(number_of(slice, 'porous')), &
                deck%flow_boundary(number_of(slice, 'flow_boundary')), &
                deck%stage(number_of(slice, 'stage')))
   end subroutine allocate_repeated

   !> How many groups of a name there are.
   pure integer function number_of(slice, name)
      type(group_slice_t), intent(in) :: slice(:)
      character(len=*), intent(in) :: name
      integer :: i

      number_of = 0
      do i = 1, size(slice)
         if (slice(i)%name == name) number_of = number_of + 1
      end do
   end function number_of

   !> The i-th group is the how-manieth of its name?
   pure integer function occurrence(slice, i)
      type(group_slice_t), intent(in) :: slice(:)
      integer, intent(in) :: i

      occurrence = number_of(slice(:i), slice(i)%name)
   end function occurrence

   !> Write the effective deck: every variable of every group, defaults too (of flow only where there is
   !> a &flow). It can be read again.
   subroutine write_deck(deck, unit, status)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: unit
      !> 0 when all of it has been written
      integer, intent(out) :: status
      integer :: i

      write (unit, '(a,/)', iostat=status) written_by_program//' Read from '//deck%path
      call write_run(deck%run, unit)
      do i = 1, size(deck%material)
         call write_material(deck%material(i), unit)
      end do
      do i = 1, size(deck%joint)
         call write_joint(deck%joint(i), unit)
      end do
      do i = 1, size(deck%cohesive)
         call write_cohesive(deck%cohesive(i), unit)
      end do
      call write_contact(deck%contact, unit)
      do i = 1, size(deck%boundary)
         call write_boundary(deck%boundary(i), unit)
      end do
      do i = 1, size(deck%initial)
         call write_initial(deck%initial(i), unit)
      end do
      do i = 1, size(deck%pore_pressure)
         call write_pore_pressure(deck%pore_pressure(i), unit)
      end do
      call write_gravity(deck%gravity, unit)
      call write_in_situ(deck%in_situ, unit)
      if (deck%flow%line > 0) then
         call write_fluid(deck%fluid, unit)
         call write_flow(deck%flow, unit)
         if (deck%transient%line > 0) call write_transient(deck%transient, unit)
      end if
      do i = 1, size(deck%conduit)
         call write_conduit(deck%conduit(i), unit)
      end do
      do i = 1, size(deck%porous)
         call write_porous(deck%porous(i), unit)
      end do
      do i = 1, size(deck%flow_boundary)
         call write_flow_boundary(deck%flow_boundary(i), unit)
      end do
      do i = 1, size(deck%stage)
         call write_stage(deck%stage(i), unit)
      end do
      call write_explicit(deck%explicit, unit)
      call write_implicit(deck%implicit, unit)
      call write_relaxation(deck%relaxation, unit)
      call write_plan(deck%plan, unit)
      call write_output(deck%output, unit)
      if (status == 0) flush (unit, iostat=status)
   end subroutine write_deck

end module deck_m
