!> The deck's groups against those of the mesh: is every name there, and can what is prescribed act there?
module group_check_m
   use errors_m, only: error_list_t
   use text_m, only: to_text, quoted, nearest_word
   use deck_m, only: deck_t
   use fracture_group_m, only: all_rock
   use boundary_group_m, only: prescribed, prescribable, edge_loads
   use edges_m, only: edge_table_t, build_edges, find_edge
   use mesh_m, only: mesh_t, find_group, name_length
   use pore_pressure_group_m, only: every_place
   implicit none
   private

   public :: check_groups

   integer, parameter :: a_point = 0, a_curve = 1, a_surface = 2
   character(len=*), parameter :: kind(0:2) = [character(len=7) :: 'point', 'curve', 'surface']

contains

   !> Check the deck's groups against those of the mesh.
   subroutine check_groups(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      type(edge_table_t) :: edges
      integer :: i
      logical :: found

      call build_edges(mesh%triangle, size(mesh%x, 2), edges)
      do i = 1, size(deck%material)
         call require(deck, mesh, '&material', deck%material(i)%line, deck%material(i)%group, [a_surface], errors, found)
      end do
      do i = 1, size(deck%joint)
         call require(deck, mesh, '&joint', deck%joint(i)%line, deck%joint(i)%group, [a_curve], errors, found)
      end do
      do i = 1, size(deck%fracture)
         if (deck%fracture(i)%group == all_rock) cycle
         call require(deck, mesh, '&fracture', deck%fracture(i)%line, deck%fracture(i)%group, [a_surface], errors, found)
      end do
      do i = 1, size(deck%boundary)
         associate (boundary => deck%boundary(i))
            call require(deck, mesh, '&boundary', boundary%line, boundary%group, [a_point, a_curve, a_surface], errors, found)
            if (.not. found) cycle
            call check_nodes(deck, mesh, edges, '&boundary', boundary%line, boundary%group, errors, found)
            if (found) call check_loads(deck, mesh, edges, i, errors)
         end associate
      end do
      do i = 1, size(deck%initial)
         associate (initial => deck%initial(i))
            call require(deck, mesh, '&initial', initial%line, initial%group, [a_point, a_curve, a_surface], errors, found)
            if (found) call check_nodes(deck, mesh, edges, '&initial', initial%line, initial%group, errors, found)
         end associate
      end do
      do i = 1, size(deck%pore_pressure)
         associate (pore => deck%pore_pressure(i))
            if (pore%group == every_place) cycle
            call require(deck, mesh, '&pore_pressure', pore%line, pore%group, [a_curve, a_surface], errors, found)
            if (find_group(mesh%group, pore%group, a_curve) == 0 .or. any(deck%joint%group == pore%group)) cycle
            call errors%add(place(deck, '&pore_pressure', pore%line, pore%group)//': this physical curve is no fracture; '// &
                            'must be the group of a &joint, or a physical surface')
         end associate
      end do
      call check_materials(deck, mesh, errors)
   end subroutine check_groups

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

   !> What is prescribed on a group needs nodes: of a surface with triangles, of a curve on the outer boundary, of a point.
   subroutine check_nodes(deck, mesh, edges, what, line, name, errors, found)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: line
      type(error_list_t), intent(inout) :: errors
      logical, intent(out) :: found
      integer :: lines, outer

      call count_lines(mesh, edges, name, lines, outer)
      found = outer > 0 .or. has_member(mesh%triangle_group, a_surface) .or. has_member(mesh%point_group, a_point)
      if (found) return
      if (lines > 0) then
         call errors%add(place(deck, what, line, name)//': this physical curve lies inside the rock; '// &
                         'must be a point, a surface, or a curve on the outer boundary')
      else
         call errors%add(place(deck, what, line, name)//': this group of the mesh is empty')
      end if

   contains

      !> Is anything in the group of that name and dimension?
      pure logical function has_member(group_of, dimension)
         integer, intent(in) :: group_of(:), dimension
         integer :: group

         group = find_group(mesh%group, name, dimension)
         has_member = group > 0 .and. any(group_of == group)
      end function has_member

   end subroutine check_nodes

   !> A load acts on edges of the outer boundary; elsewhere it would silently do nothing.
   subroutine check_loads(deck, mesh, edges, b, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      !> Boundary of the deck
      integer, intent(in) :: b
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: names
      logical :: given(size(prescribable))
      integer :: i, lines, outer

      given = prescribed(deck%boundary(b))
      names = ''
      do i = 1, size(edge_loads)
         if (.not. given(edge_loads(i))) cycle
         if (names /= '') names = names//', '
         names = names//trim(prescribable(edge_loads(i)))
      end do
      if (names == '') return
      call count_lines(mesh, edges, deck%boundary(b)%group, lines, outer)
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

   !> Lines of a physical curve, and how many of them are edges of the outer boundary.
   pure subroutine count_lines(mesh, edges, name, lines, outer)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      character(len=*), intent(in) :: name
      integer, intent(out) :: lines, outer
      integer :: i, e, group

      lines = 0
      outer = 0
      group = find_group(mesh%group, name, a_curve)
      if (group == 0) return
      do i = 1, size(mesh%line, 2)
         if (mesh%line_group(i) /= group) cycle
         lines = lines + 1
         e = find_edge(edges, mesh%line(1, i), mesh%line(2, i))
         if (e == 0) cycle
         if (edges%triangles(e) == 1) outer = outer + 1
      end do
   end subroutine count_lines

   !> 'deck.nml:12: &boundary group = 'top''
   pure function place(deck, what, line, name)
      type(deck_t), intent(in) :: deck
      character(len=*), intent(in) :: what, name
      integer, intent(in) :: line
      character(len=:), allocatable :: place

      place = deck%path//':'//to_text(line)//': '//what//' group = '//quoted(name)
   end function place

end module group_check_m
