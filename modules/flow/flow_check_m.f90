!> The deck's groups of flow: against each other, and against those of the mesh.
module flow_check_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use deck_m, only: deck_t
   use boundary_group_m, only: every_stage
   use conduit_group_m, only: as_flow
   use edges_m, only: edge_table_t, build_edges, find_edge
   use errors_m, only: error_list_t
   use mesh_m, only: mesh_t, find_group, name_length, a_point, a_curve, a_surface
   use text_m, only: nearest_word, quoted, to_text
   implicit none
   private

   public :: check_flow, check_flow_groups, has_flow, is_flow_alone

   character(len=*), parameter :: kind(0:2) = [character(len=7) :: 'point', 'curve', 'surface']

contains

   !> Does the deck ask for flow?
   pure logical function has_flow(deck)
      type(deck_t), intent(in) :: deck

      has_flow = deck%flow%line > 0
   end function has_flow

   !> Does it ask for nothing else? Then nothing moves: there is no stage.
   pure logical function is_flow_alone(deck)
      type(deck_t), intent(in) :: deck

      is_flow_alone = has_flow(deck) .and. size(deck%stage) == 0
   end function is_flow_alone

   !> Combinations of the deck's groups.
   subroutine check_flow(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      integer :: i

      if (.not. allocated(deck%stage)) return
      if (.not. has_flow(deck)) then
         if (deck%fluid%line > 0) call idle(deck, deck%fluid%line, 'fluid', errors)
         if (deck%transient%line > 0) call idle(deck, deck%transient%line, 'transient', errors)
         do i = 1, size(deck%conduit)
            call idle(deck, deck%conduit(i)%line, 'conduit', errors)
         end do
         do i = 1, size(deck%porous)
            call idle(deck, deck%porous(i)%line, 'porous', errors)
         end do
         do i = 1, size(deck%flow_boundary)
            call idle(deck, deck%flow_boundary(i)%line, 'flow_boundary', errors)
         end do
         return
      end if
      call check_twice(deck, 'conduit', deck%conduit%group, deck%conduit%line, errors)
      call check_twice(deck, 'porous', deck%porous%group, deck%porous%line, errors)
      call check_twice(deck, 'flow_boundary', deck%flow_boundary%group, deck%flow_boundary%line, errors)
      do i = 1, size(deck%flow_boundary)
         associate (boundary => deck%flow_boundary(i))
            if (boundary%stage == every_stage .or. any(deck%stage%name == boundary%stage)) cycle
            call errors%add(at(deck, boundary%line, 'flow_boundary')//'stage = '//quoted(boundary%stage)// &
                            ': there is no such stage; must be the name of one, or ''all''')
         end associate
      end do
      if (deck%transient%line > 0) call check_transient(deck, errors)
      if (deck%flow%coupling == 'two-way') call check_two_way(deck, errors)
      if (deck%flow%fluid_lag) call check_fluid_lag(deck, errors)
      if (size(deck%flow_boundary) > 0 .and. .not. any(is_set(deck%flow_boundary%pressure)) .and. deck%transient%line == 0) &
         call errors%add(at(deck, deck%flow_boundary(1)%line, 'flow_boundary')//'no &flow_boundary gives a pressure: steady '// &
                         'flow needs one at least')
      if (size(deck%flow_boundary) == 0 .and. .not. (deck%flow%permeability .or. deck%transient%line > 0)) &
         call errors%add(at(deck, deck%flow%line, 'flow')//'permeability = .false. and no &flow_boundary: nothing is asked '// &
                         'for; there must be a pressure, or permeability = .true.')
      call check_conduits(deck, errors)
   end subroutine check_flow

   !> A pressure that pushes back is found in cycles that end at rest, of rock that stays whole.
   subroutine check_two_way(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=*), parameter :: two_way = 'coupling = ''two-way'' '

      if (size(deck%stage) == 0) &
         call errors%add(at(deck, deck%flow%line, 'flow')//two_way//'needs stages: without them nothing moves')
      if (size(deck%stage) > 0 .and. deck%run%solver /= 'implicit') &
         call errors%add(at(deck, deck%flow%line, 'flow')//two_way//'needs solver = ''implicit'' of &run')
      if (size(deck%flow_boundary) == 0 .and. deck%transient%line == 0) &
         call errors%add(at(deck, deck%flow%line, 'flow')//two_way//'needs a &flow_boundary that gives the pressure')
      if (any(deck%stage%remove /= '')) &
         call errors%add(at(deck, deck%flow%line, 'flow')//two_way//'does not go with remove of &stage: that is for ''one-way''')
      if (size(deck%pore_pressure) > 0) &
         call errors%add(at(deck, deck%pore_pressure(1)%line, 'pore_pressure')//'the pressure is found with '//two_way// &
                         'of &flow; leave out one of them')
   end subroutine check_two_way

   !> Fluid that fills what opens needs time and walls that move; what rock gives and takes is not known to it.
   subroutine check_fluid_lag(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      integer :: i

      if (deck%flow%coupling /= 'two-way' .or. deck%transient%line == 0) &
         call errors%add(at(deck, deck%flow%line, 'flow')//'fluid_lag = .true. needs coupling = ''two-way'' and &transient: '// &
                         'fluid fills cracks in time')
      i = findloc(deck%porous%permeability > 0.0_wp, .true., dim=1)
      if (i > 0) call errors%add(at(deck, deck%porous(i)%line, 'porous')//'permeability must be 0 with fluid_lag '// &
                                 'of &flow: fluid that may lag behind a tip stays in fractures and cracks')
      if (deck%transient%initial_pressure < 0.0_wp) &
         call errors%add(at(deck, deck%transient%line, 'transient')//'initial_pressure must be at least 0 with fluid_lag of &flow')
      i = findloc(deck%flow_boundary%pressure < 0.0_wp .and. is_set(deck%flow_boundary%pressure), .true., dim=1)
      if (i > 0) call errors%add(at(deck, deck%flow_boundary(i)%line, 'flow_boundary')//'pressure must be at least 0 with '// &
                                 'fluid_lag of &flow: such fluid cannot be pulled')
      i = findloc(is_set(deck%conduit%aperture_mm), .true., dim=1)
      if (i > 0) call errors%add(at(deck, deck%conduit(i)%line, 'conduit')//'aperture_mm must not be given with fluid_lag of '// &
                                 '&flow: walls that do not move have no room for what flows in')
   end subroutine check_fluid_lag

   !> Flow that changes with time is flow alone or two-way coupled, and something drives it.
   subroutine check_transient(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      integer :: i

      if (size(deck%stage) > 0) then
         if (deck%flow%coupling /= 'two-way') &
            call errors%add(at(deck, deck%transient%line, 'transient')//'the deck has stages: flow that changes with time '// &
                            'under load needs coupling = ''two-way'' of &flow')
         if (is_set(deck%transient%duration)) &
            call errors%add(at(deck, deck%transient%line, 'transient')//'duration has no effect with stages: their move_time '// &
                            'and cycles say how long; leave it out')
         if (is_set(deck%transient%output_interval)) &
            call errors%add(at(deck, deck%transient%line, 'transient')//'output_interval has no effect with stages: there is '// &
                            'an output after every cycle; leave it out')
         if (any(deck%stage%rest_time > 0.0_wp)) &
            call errors%add(at(deck, deck%stage(findloc(deck%stage%rest_time > 0.0_wp, .true., dim=1))%line, 'stage')// &
                            'rest_time must be 0 with &transient: cycles end at rest, and the fluid flows during move_time')
         i = findloc(is_set(deck%conduit%wall_stiffness), .true., dim=1)
         if (i > 0) call errors%add(at(deck, deck%conduit(i)%line, 'conduit')//'wall_stiffness has no effect with stages: the '// &
                                    'walls give way as the &joint says; leave it out')
         return
      end if
      if (.not. is_set(deck%transient%duration)) &
         call errors%add(at(deck, deck%transient%line, 'transient')//'duration is missing; must be above 0')
      if (size(deck%flow_boundary) == 0) call errors%add(at(deck, deck%transient%line, 'transient')//'there is no '// &
                                                         '&flow_boundary: nothing would change; there must be one')
   end subroutine check_transient

   !> Conduits have an aperture, and a roughness where their law needs it.
   subroutine check_conduits(deck, errors)
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: law
      real(wp) :: jrc
      integer :: i, joint, conduit

      do i = 1, size(deck%conduit)
         joint = findloc(deck%joint%group == deck%conduit(i)%group, .true., dim=1)
         if (joint > 0 .and. .not. is_flow_alone(deck)) cycle
         if (is_set(deck%conduit(i)%aperture_mm)) cycle
         call errors%add(at(deck, deck%conduit(i)%line, 'conduit')//'aperture_mm is missing: no joint of '// &
                         quoted(deck%conduit(i)%group)//' has been computed')
      end do
      do i = 1, size(deck%joint) + size(deck%conduit)
         law = trim(deck%flow%hydraulic)
         if (i <= size(deck%joint)) then
            joint = i
            conduit = findloc(deck%conduit%group == deck%joint(i)%group, .true., dim=1)
         else
            conduit = i - size(deck%joint)
            joint = findloc(deck%joint%group == deck%conduit(conduit)%group, .true., dim=1)
            if (joint > 0) cycle
         end if
         jrc = 0.0_wp
         if (joint > 0) jrc = deck%joint(joint)%settings%number('jrc0')
         if (conduit > 0) then
            if (deck%conduit(conduit)%hydraulic /= as_flow) law = trim(deck%conduit(conduit)%hydraulic)
            if (is_set(deck%conduit(conduit)%jrc)) jrc = deck%conduit(conduit)%jrc
         end if
         if (law == 'equal' .or. jrc > 0.0_wp) cycle
         if (conduit > 0) then
            call errors%add(at(deck, deck%conduit(conduit)%line, 'conduit')//'jrc is missing: hydraulic = '// &
                            quoted(law)//' needs it')
         else
            call errors%add(at(deck, deck%joint(joint)%line, 'joint')//'jrc0 is missing: hydraulic = '//quoted(law)// &
                            ' needs it, or a &conduit of the group with jrc')
         end if
      end do
   end subroutine check_conduits

   !> A group of flow without &flow.
   subroutine idle(deck, line, name, errors)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: line
      character(len=*), intent(in) :: name
      type(error_list_t), intent(inout) :: errors

      call errors%add(at(deck, line, name)//'has no effect without &flow; give both or neither')
   end subroutine idle

   !> Groups of the mesh are named once.
   subroutine check_twice(deck, what, name, line, errors)
      type(deck_t), intent(in) :: deck
      character(len=*), intent(in) :: what, name(:)
      integer, intent(in) :: line(:)
      type(error_list_t), intent(inout) :: errors
      integer :: i, first

      do i = 2, size(name)
         first = findloc(name(:i - 1) == name(i), .true., dim=1)
         if (first > 0) call errors%add(at(deck, line(i), what)//'group = '//quoted(name(i))//' was given in line '// &
                                        to_text(line(first))//' already; give it once')
      end do
   end subroutine check_twice

   !> Names of groups against the mesh, and conduits against its edges.
   subroutine check_flow_groups(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      integer :: i, before

      if (.not. has_flow(deck)) return
      before = errors%count()
      do i = 1, size(deck%conduit)
         call require(deck, mesh, 'conduit', deck%conduit(i)%line, deck%conduit(i)%group, [a_curve], errors)
      end do
      do i = 1, size(deck%porous)
         call require(deck, mesh, 'porous', deck%porous(i)%line, deck%porous(i)%group, [a_surface], errors)
      end do
      do i = 1, size(deck%flow_boundary)
         call require(deck, mesh, 'flow_boundary', deck%flow_boundary(i)%line, deck%flow_boundary(i)%group, [a_curve, a_point], &
                      errors)
      end do
      if (errors%count() > before) return
      if (is_flow_alone(deck)) then
         if (size(deck%conduit) + size(deck%porous) == 0) &
            call errors%add(deck%path//': nothing conducts; there must be a &conduit or a &porous')
         if (size(mesh%triangle, 2) > 0) call check_edges(deck, mesh, errors)
      else
         do i = 1, size(deck%conduit)
            if (any(deck%joint%group == deck%conduit(i)%group)) cycle
            call errors%add(at(deck, deck%conduit(i)%line, 'conduit')//'group = '//quoted(deck%conduit(i)%group)// &
                            ': this physical curve is no fracture; must be the group of a &joint')
         end do
      end if
   end subroutine check_flow_groups

   !> Conduits in rock are edges of its triangles.
   subroutine check_edges(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      type(edge_table_t) :: edges
      integer :: i, k, group, off

      call build_edges(mesh%triangle, size(mesh%x, 2), edges)
      do i = 1, size(deck%conduit)
         group = find_group(mesh%group, deck%conduit(i)%group, a_curve)
         off = 0
         do k = 1, size(mesh%line, 2)
            if (mesh%line_group(k) /= group) cycle
            if (find_edge(edges, mesh%line(1, k), mesh%line(2, k)) == 0) off = off + 1
         end do
         if (off > 0) call errors%add(at(deck, deck%conduit(i)%line, 'conduit')//'group = '//quoted(deck%conduit(i)%group)//': '// &
                                      to_text(off)//' of its lines are no edges of triangles (embed the fracture in the surface)')
      end do
   end subroutine check_edges

   !> The mesh has a group of that name, of one of the dimensions, with something in it.
   subroutine require(deck, mesh, what, line, name, dimensions, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: line, dimensions(:)
      type(error_list_t), intent(inout) :: errors
      character(len=name_length), allocatable :: candidates(:)
      character(len=:), allocatable :: kinds, similar
      integer :: d, k, group

      kinds = ''
      do d = 1, size(dimensions)
         if (d > 1) kinds = kinds//' or '
         kinds = kinds//trim(kind(dimensions(d)))
         group = find_group(mesh%group, name, dimensions(d))
         if (group == 0) cycle
         if (dimensions(d) == a_surface .and. any(mesh%triangle_group == group)) return
         if (dimensions(d) == a_curve .and. any(mesh%line_group == group)) return
         if (dimensions(d) == a_point .and. any(mesh%point_group == group)) return
      end do
      candidates = pack(mesh%group%name, [(any(dimensions == mesh%group(k)%dimension), k=1, size(mesh%group))])
      similar = nearest_word(name, candidates)
      if (similar /= '') similar = '; did you mean '//quoted(similar)//'?'
      if (any(candidates == name)) similar = ' with anything in it'
      call errors%add(at(deck, line, what)//'group = '//quoted(name)//': the mesh has no physical '//kinds// &
                      ' of that name'//similar)
   end subroutine require

   !> 'deck.nml:12: &flow '
   pure function at(deck, line, name)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: line
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: at

      at = deck%path//':'//to_text(line)//': &'//name//' '
   end function at

end module flow_check_m
