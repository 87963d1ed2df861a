!> The deck's groups against those of the mesh: is every name there, and can what is prescribed act there?
module group_check_m
   use errors_m, only: error_list_t
   use text_m, only: to_text, quoted, nearest_word
   use deck_m, only: deck_t
   use cohesive_group_m, only: all_rock
   use boundary_group_m, only: prescribed, prescribable, on_edges, every_stage
   use edges_m, only: edge_table_t, build_edges, find_edge
   use mesh_m, only: mesh_t, find_group, name_length, a_point, a_curve, a_surface, curve_first, surface_first
   use pore_pressure_group_m, only: every_place
   use loads_m, only: stage_number
   implicit none
   private

   public :: check_groups

   character(len=*), parameter :: a_stage = '&stage'
   character(len=*), parameter :: kind(0:2) = [character(len=7) :: 'point', 'curve', 'surface']

contains

   !> Check the deck's groups against those of the mesh.
   subroutine check_groups(deck, mesh, errors, warnings)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      !> What is wrong, and what is valid but seldom meant
      type(error_list_t), intent(inout) :: errors, warnings
      type(edge_table_t) :: edges
      integer, allocatable :: taken(:)
      integer :: i
      logical :: found

      call build_edges(mesh%triangle, size(mesh%x, 2), edges)
      call check_removals(deck, mesh, errors)
      taken = taken_in(deck, mesh)
      do i = 1, size(deck%material)
         call require_elements(deck, mesh, '&material', deck%material(i)%line, deck%material(i)%group, [a_surface], errors)
      end do
      do i = 1, size(deck%joint)
         call require_elements(deck, mesh, '&joint', deck%joint(i)%line, deck%joint(i)%group, [a_curve], errors)
      end do
      do i = 1, size(deck%cohesive)
         if (deck%cohesive(i)%curve /= '') &
            call require_elements(deck, mesh, '&cohesive', deck%cohesive(i)%line, deck%cohesive(i)%curve, [a_curve], errors)
         if (deck%cohesive(i)%group == all_rock) cycle
         call require_elements(deck, mesh, '&cohesive', deck%cohesive(i)%line, deck%cohesive(i)%group, [a_surface], errors)
      end do
      do i = 1, size(deck%boundary)
         associate (boundary => deck%boundary(i))
            call require(deck, mesh, '&boundary', boundary%line, boundary%group, [a_point, a_curve, a_surface], errors, found)
            if (.not. found) cycle
            call warn_of_namesakes(deck, mesh, '&boundary', boundary%line, boundary%group, curve_first, warnings)
            call check_nodes(deck, mesh, edges, taken, boundary%stage, '&boundary', boundary%line, boundary%group, curve_first, &
                             errors, found)
            if (found) call check_loads(deck, mesh, edges, taken, i, errors)
         end associate
      end do
      do i = 1, size(deck%initial)
         associate (initial => deck%initial(i))
            call require(deck, mesh, '&initial', initial%line, initial%group, [a_point, a_curve, a_surface], errors, found)
            if (.not. found) cycle
            call warn_of_namesakes(deck, mesh, '&initial', initial%line, initial%group, surface_first, warnings)
            call check_nodes(deck, mesh, edges, taken, every_stage, '&initial', initial%line, initial%group, surface_first, &
                             errors, found)
         end associate
      end do
      do i = 1, size(deck%pore_pressure)
         associate (pore => deck%pore_pressure(i))
            if (pore%group == every_place) cycle
            call require_elements(deck, mesh, '&pore_pressure', pore%line, pore%group, [a_curve, a_surface], errors)
            if (.not. has_members(mesh, pore%group, a_curve)) cycle
            if (has_members(mesh, pore%group, a_surface)) then
               call errors%add(place(deck, '&pore_pressure', pore%line, pore%group)//': the mesh has a physical curve and a '// &
                               'physical surface of that name; give one of them another name, to say where the fluid is')
               cycle
            end if
            if (any(deck%joint%group == pore%group)) cycle
            call errors%add(place(deck, '&pore_pressure', pore%line, pore%group)//': this physical curve is no fracture; '// &
                            'must be the group of a &joint, or a physical surface')
         end associate
      end do
      call check_materials(deck, mesh, errors)
      call warn_of_inner_curves(deck, mesh, edges, taken, warnings)
   end subroutine check_groups

   !> What stages take out is there, and leaves something.
   subroutine check_removals(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      integer :: s

      do s = 1, size(deck%stage)
         if (deck%stage(s)%remove == '') cycle
         call require_elements(deck, mesh, a_stage, deck%stage(s)%line, deck%stage(s)%remove, [a_surface], errors)
         if (all(taken_in(deck, mesh) <= s)) call errors%add(place(deck, a_stage, deck%stage(s)%line, deck%stage(s)%remove)// &
                                                             ': no rock would be left')
      end do
   end subroutine check_removals

   !> Stage that takes out each triangle; one beyond the last where none does (triangles).
   pure function taken_in(deck, mesh) result(stage)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      integer, allocatable :: stage(:)
      integer :: s

      allocate (stage(size(mesh%triangle_group)), source=size(deck%stage) + 1)
      do s = size(deck%stage), 1, -1
         if (deck%stage(s)%remove == '') cycle
         where (mesh%triangle_group == find_group(mesh%group, deck%stage(s)%remove, a_surface)) stage = s
      end do
   end function taken_in

   !> The mesh must have a group of that name and of one of the dimensions.
   subroutine require(deck, mesh, what, line, name, dimensions, errors, found)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      !> Group of the deck, its line, and the group of the mesh it names
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: line, dimensions(:)
      type(error_list_t), intent(inout) :: errors
      logical, intent(out) :: found
      character(len=:), allocatable :: similar, kinds
      character(len=name_length), allocatable :: candidates(:)
      integer :: d, k

      found = .true.
      do d = 1, size(dimensions)
         if (find_group(mesh%group, name, dimensions(d)) > 0) return
      end do
      found = .false.
      candidates = pack(mesh%group%name, [(any(dimensions == mesh%group(k)%dimension), k=1, size(mesh%group))])
      similar = nearest_word(name, candidates)
      if (similar /= '') similar = '; did you mean '//quoted(similar)//'?'
      kinds = 'point, curve or surface'
      if (size(dimensions) == 1) kinds = trim(kind(dimensions(1)))
      call errors%add(place(deck, what, line, name)//': the mesh has no physical '//kinds//' of that name'//similar)
   end subroutine require

   !> The mesh must have a group of that name and of one of the dimensions, and elements in it.
   subroutine require_elements(deck, mesh, what, line, name, dimensions, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: line, dimensions(:)
      type(error_list_t), intent(inout) :: errors
      integer :: d
      logical :: found

      call require(deck, mesh, what, line, name, dimensions, errors, found)
      if (.not. found) return
      do d = 1, size(dimensions)
         if (has_members(mesh, name, dimensions(d))) return
      end do
      call errors%add(place(deck, what, line, name)//': this group of the mesh is empty')
   end subroutine require_elements

   !> Is anything of the mesh in the group of that name and dimension?
   pure logical function has_members(mesh, name, dimension)
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: name
      integer, intent(in) :: dimension
      integer :: group

      group = find_group(mesh%group, name, dimension)
      has_members = .false.
      if (group == 0) return
      select case (dimension)
      case (a_point)
         has_members = any(mesh%point_group == group)
      case (a_curve)
         has_members = any(mesh%line_group == group)
      case (a_surface)
         has_members = any(mesh%triangle_group == group)
      end select
   end function has_members

   !> Dimension of the group that a name means: the first in the order with anything in it (-1: none has).
   pure integer function dimension_meant(mesh, name, order) result(dimension)
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: name
      integer, intent(in) :: order(:)
      integer :: d

      do d = 1, size(order)
         dimension = order(d)
         if (has_members(mesh, name, dimension)) return
      end do
      dimension = -1
   end function dimension_meant

   !> Say which group is meant when several have the name.
   subroutine warn_of_namesakes(deck, mesh, what, line, name, order, warnings)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: what, name
      !> Which dimension goes before which
      integer, intent(in) :: line, order(:)
      type(error_list_t), intent(inout) :: warnings
      integer :: meant, d

      meant = dimension_meant(mesh, name, order)
      do d = 1, size(order)
         if (order(d) == meant .or. .not. has_members(mesh, name, order(d))) cycle
         call warnings%add(place(deck, what, line, name)//': the mesh has a physical '//trim(kind(meant))//' and a physical '// &
                           trim(kind(order(d)))//' of that name; the '//trim(kind(meant))//' is taken')
      end do
   end subroutine warn_of_namesakes

   !> Lines inside the rock that are no fracture are often meant to be one.
   subroutine warn_of_inner_curves(deck, mesh, edges, taken, warnings)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      !> Stage that takes out each triangle (triangles)
      integer, intent(in) :: taken(:)
      type(error_list_t), intent(inout) :: warnings
      integer :: i, lines, outer

      do i = 1, size(mesh%group)
         if (mesh%group(i)%dimension /= a_curve .or. any(deck%joint%group == mesh%group(i)%name) .or. &
             any(deck%cohesive%curve == mesh%group(i)%name)) cycle
         call count_lines(deck, mesh, edges, taken, every_stage, mesh%group(i)%name, lines, outer)
         if (outer == lines) cycle
         call warnings%add(deck%path//': '//to_text(lines - outer)//' of the '//to_text(lines)//' edges of the physical curve '// &
                           quoted(mesh%group(i)%name)//' lie inside the rock, and no &joint has this group: they are no fracture')
      end do
   end subroutine warn_of_inner_curves

   !> What is prescribed on a group needs nodes: of a surface with triangles, of a curve on the outer boundary, of a point.
   subroutine check_nodes(deck, mesh, edges, taken, stage, what, line, name, order, errors, found)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      !> Stage that takes out each triangle (triangles)
      integer, intent(in) :: taken(:)
      !> Stage in which it acts
      character(len=*), intent(in) :: stage, what, name
      !> Line of the deck; which dimension goes before which
      integer, intent(in) :: line, order(:)
      type(error_list_t), intent(inout) :: errors
      logical, intent(out) :: found
      integer :: meant, lines, outer

      meant = dimension_meant(mesh, name, order)
      call count_lines(deck, mesh, edges, taken, stage, name, lines, outer)
      found = meant == a_point .or. meant == a_surface .or. outer > 0
      if (found) return
      if (lines > 0) then
         call errors%add(place(deck, what, line, name)//': this physical curve lies inside the rock; '// &
                         'must be a point, a surface, or a curve on the outer boundary')
      else
         call errors%add(place(deck, what, line, name)//': this group of the mesh is empty')
      end if
   end subroutine check_nodes

   !> A load acts on edges of the outer boundary; elsewhere it would silently do nothing.
   subroutine check_loads(deck, mesh, edges, taken, b, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      !> Stage that takes out each triangle (triangles)
      integer, intent(in) :: taken(:)
      !> Boundary of the deck
      integer, intent(in) :: b
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: names
      logical :: given(size(prescribable))
      integer :: i, lines, outer

      given = prescribed(deck%boundary(b))
      names = ''
      do i = 1, size(on_edges)
         if (.not. given(on_edges(i))) cycle
         if (names /= '') names = names//', '
         names = names//trim(prescribable(on_edges(i)))
      end do
      if (names == '') return
      call count_lines(deck, mesh, edges, taken, deck%boundary(b)%stage, deck%boundary(b)%group, lines, outer)
      if (outer > 0 .and. outer == lines) return
      names = place(deck, '&boundary', deck%boundary(b)%line, deck%boundary(b)%group)//', '//names
      if (outer > 0) names = names//': '//to_text(lines - outer)//' of the '//to_text(lines)// &
                             ' edges of this physical curve lie inside the rock'
      call errors%add(names//': a load acts on edges; must be a physical curve on the outer boundary')
   end subroutine check_loads

   !> Every surface with triangles needs a material.
   subroutine check_materials(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, size(mesh%group)
         if (mesh%group(i)%dimension /= a_surface) cycle
         if (any(deck%material%group == mesh%group(i)%name) .or. .not. any(mesh%triangle_group == i)) cycle
         call errors%add(deck%path//': no &material has group = '//quoted(mesh%group(i)%name)// &
                         ', a physical surface of the mesh with triangles')
      end do
   end subroutine check_materials

   !> Lines of a physical curve, and how many of them are edges of the outer boundary, or become so when rock is taken out: in the
   !> given stage or later.
   pure subroutine count_lines(deck, mesh, edges, taken, stage, name, lines, outer)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      !> Stage that takes out each triangle (triangles)
      integer, intent(in) :: taken(:)
      character(len=*), intent(in) :: stage, name
      integer, intent(out) :: lines, outer
      integer :: i, e, group, ends, starts, first

      lines = 0
      outer = 0
      group = find_group(mesh%group, name, a_curve)
      if (group == 0) return
      first = max(1, stage_number(deck%stage%name, stage))
      do i = 1, size(mesh%line, 2)
         if (mesh%line_group(i) /= group) cycle
         lines = lines + 1
         e = find_edge(edges, mesh%line(1, i), mesh%line(2, i))
         if (e == 0) cycle
         if (edges%triangles(e) > 2) cycle
         if (edges%triangles(e) == 1) then
            outer = outer + 1
            cycle
         end if
         ! The edge is free from when one side of it is gone until the other is
         ends = taken(edges%triangle(1, e))
         starts = taken(edges%triangle(2, e))
         if (max(first, min(starts, ends)) < min(max(starts, ends), size(deck%stage) + 1)) outer = outer + 1
      end do
   end subroutine count_lines

   !> 'deck.nml:12: &boundary group = 'top''
   pure function place(deck, what, line, name)
      type(deck_t), intent(in) :: deck
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: line
      character(len=:), allocatable :: place

      place = deck%path//':'//to_text(line)//': '//what//trim(merge(' remove', ' group ', what == a_stage))//' = '//quoted(name)
   end function place

end module group_check_m
