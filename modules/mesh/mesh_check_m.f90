!> Does a mesh make sense? Every way in which it does not is said with its place, all in one go.
module mesh_check_m
   use edges_m, only: build_edges, edge_table_t, find_edge, next_corner
   use errors_m, only: error_list_t
   use geometry_m, only: twice_area
   use kinds_m, only: wp
   use mesh_m, only: mesh_t, coordinate_text
   use overlap_m, only: find_overlaps, most_of_a_kind => most_listed, overlap_t
   use text_m, only: quoted, to_text
   implicit none
   private

   public :: check_mesh, most_of_a_kind

   !> A triangle whose area is less than this part of its longest edge squared has none
   real(wp), parameter :: least_area = 1.0e-9_wp
   !> Dimension of surface groups
   integer, parameter :: surface_dimension = 2

contains

   !> Add all that is wrong with a mesh to the errors: at most most_of_a_kind messages of each kind. The checks that
   !> need sound triangles are left out when there are broken ones. Cost: linear in the number of triangles.
   subroutine check_mesh(mesh, errors)
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      type(edge_table_t) :: edges
      integer :: before

      before = errors%count()
      call check_groups(mesh, errors)
      if (size(mesh%triangle, 2) == 0) return
      call check_triangles(mesh, errors)
      call check_repeated(mesh, errors)
      call build_edges(mesh%triangle, size(mesh%x, 2), edges)
      if (errors%count() == before) call check_edges(mesh, edges, errors)
      if (errors%count() == before) call check_overlaps(mesh, edges, errors)
      call check_lines(mesh, edges, errors)
      call check_points(mesh, errors)
   end subroutine check_mesh

   !> Add a message unless there are enough of its kind.
   subroutine add_capped(errors, found, text)
      type(error_list_t), intent(inout) :: errors
      !> How many there are of this kind, this one not yet counted
      integer, intent(inout) :: found
      character(len=*), intent(in) :: text

      found = found + 1
      if (found <= most_of_a_kind) call errors%add(text)
   end subroutine add_capped

   !> Say how many more there are of a kind.
   subroutine add_rest(errors, found, kind_text)
      type(error_list_t), intent(inout) :: errors
      integer, intent(in) :: found
      !> What was found, in the plural
      character(len=*), intent(in) :: kind_text

      if (found > most_of_a_kind) then
         call errors%add('mesh: and '//to_text(found - most_of_a_kind)//' more '//kind_text)
      end if
   end subroutine add_rest

   !> There must be triangles, in named surfaces; no two groups of one dimension may share a name.
   subroutine check_groups(mesh, errors)
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      integer :: i, j, found

      if (size(mesh%triangle, 2) == 0) then
         call errors%add('mesh: there are no triangles; put the surfaces of the rock into a physical group '// &
                         '(gmsh saves only what is in one)')
      end if
      found = 0
      do i = 1, size(mesh%group)
         do j = 1, i - 1
            if (mesh%group(i)%dimension /= mesh%group(j)%dimension .or. mesh%group(i)%name /= mesh%group(j)%name) cycle
            call add_capped(errors, found, 'mesh: physical groups '//to_text(mesh%group(j)%tag)//' and '// &
                            to_text(mesh%group(i)%tag)//' have the same name '//quoted(mesh%group(i)%name))
         end do
      end do
      call add_rest(errors, found, 'groups with a name used before')
   end subroutine check_groups

   !> Every triangle must have an area and be in a physical surface.
   subroutine check_triangles(mesh, errors)
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      real(wp) :: longest_squared
      integer :: i, flat, homeless
      logical :: all_homeless

      flat = 0
      homeless = 0
      ! One fault, not one for each triangle
      all_homeless = size(mesh%triangle_group) > 1 .and. all(mesh%triangle_group == 0)
      if (all_homeless) call errors%add('mesh: none of the '//to_text(size(mesh%triangle_group))//' triangles is in a physical '// &
                                        'surface; put every surface of the rock into a physical group')
      do i = 1, size(mesh%triangle, 2)
         associate (a => mesh%x(:, mesh%triangle(1, i)), b => mesh%x(:, mesh%triangle(2, i)), &
                    c => mesh%x(:, mesh%triangle(3, i)))
            longest_squared = max(sum((b - a)**2), sum((c - b)**2), sum((a - c)**2))
            if (twice_area(a, b, c) <= 2.0_wp*least_area*longest_squared) then
               call add_capped(errors, flat, 'mesh: '//triangle_text(mesh, i)//' has no area')
            end if
         end associate
         if (mesh%triangle_group(i) == 0 .and. .not. all_homeless) then
            call add_capped(errors, homeless, 'mesh: '//triangle_text(mesh, i)//' is not in a physical surface')
         end if
      end do
      call add_rest(errors, flat, 'triangles without area')
      call add_rest(errors, homeless, 'triangles not in a physical surface')
   end subroutine check_triangles

   !> No two triangles may have the same corners. They are listed at their lowest node, a handful each.
   subroutine check_repeated(mesh, errors)
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: first(:), next(:)
      integer :: i, other, low, found

      allocate (first(size(mesh%x, 2)), next(size(mesh%triangle, 2)))
      first = 0
      found = 0
      do i = 1, size(mesh%triangle, 2)
         low = minval(mesh%triangle(:, i))
         other = first(low)
         do while (other > 0)
            if (same_corners(mesh%triangle(:, i), mesh%triangle(:, other))) then
               call add_capped(errors, found, 'mesh: '//triangle_text(mesh, i)//' of group '// &
                               group_text(mesh, mesh%triangle_group(i))//' is there already, as triangle '// &
                               to_text(other)//' of group '//group_text(mesh, mesh%triangle_group(other)))
               exit
            end if
            other = next(other)
         end do
         next(i) = first(low)
         first(low) = i
      end do
      call add_rest(errors, found, 'triangles that are there already')
   end subroutine check_repeated

   !> Do two triangles have the same corners, in whatever order?
   pure logical function same_corners(a, b)
      integer, intent(in) :: a(3), b(3)

      same_corners = minval(a) == minval(b) .and. maxval(a) == maxval(b) .and. sum(a) == sum(b)
   end function same_corners

   !> An edge has one or two triangles, and two lie on different sides of it. Where they lie on one side, one of them
   !> was inverted: the mesh is folded.
   subroutine check_edges(mesh, edges, errors)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      type(error_list_t), intent(inout) :: errors
      integer :: e, crowded, folded

      crowded = 0
      folded = 0
      do e = 1, size(edges%triangles)
         if (edges%triangles(e) > 2) then
            call add_capped(errors, crowded, 'mesh: the '//edge_text(mesh, edges%node(:, e))//' has '// &
                            to_text(edges%triangles(e))//' triangles; two are the most')
         else if (edges%triangles(e) == 2) then
            if (same_direction(mesh%triangle(:, edges%triangle(2, e)), edges%node(:, e))) then
               call add_capped(errors, folded, 'mesh: '//triangle_text(mesh, edges%triangle(1, e))//' and '// &
                               triangle_text(mesh, edges%triangle(2, e))// &
                               ' lie on the same side of their common edge: one is inverted')
            end if
         end if
      end do
      call add_rest(errors, crowded, 'edges with more than two triangles')
      call add_rest(errors, folded, 'inverted triangles')
   end subroutine check_edges

   !> Does a triangle pass an edge in the direction given?
   pure logical function same_direction(corner, edge)
      integer, intent(in) :: corner(3), edge(2)

      same_direction = any(corner == edge(1) .and. corner(next_corner) == edge(2))
   end function same_direction

   !> Nodes at the same place, and nodes on edges that do not have them as an end: parts that touch without being
   !> connected.
   subroutine check_overlaps(mesh, edges, errors)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      type(error_list_t), intent(inout) :: errors
      type(overlap_t) :: overlap
      integer :: i

      call find_overlaps(mesh%x, pack_boundary(edges), overlap)
      do i = 1, min(overlap%pairs, most_of_a_kind)
         call errors%add('mesh: nodes '//to_text(overlap%same_place(1, i))//' and '// &
                         to_text(overlap%same_place(2, i))//' are at the same place '// &
                         at_text(mesh%x(:, overlap%same_place(1, i)), mesh%datum)// &
                         '; merge them (gmsh: fragment the surfaces), or leave a gap between separate bodies')
      end do
      do i = 1, min(overlap%cases, most_of_a_kind)
         call errors%add('mesh: node '//to_text(overlap%on_edge(1, i))//' at '// &
                         at_text(mesh%x(:, overlap%on_edge(1, i)), mesh%datum)//' hangs on the '// &
                         edge_text(mesh, overlap%on_edge(2:3, i))//'; mesh both sides with the same nodes '// &
                         '(gmsh: fragment the surfaces), or leave a gap between separate bodies')
      end do
      call add_rest(errors, overlap%pairs, 'nodes at the place of another')
      call add_rest(errors, overlap%cases, 'hanging nodes')
   end subroutine check_overlaps

   !> Edges of the outer boundary (2, edges).
   pure function pack_boundary(edges) result(boundary)
      type(edge_table_t), intent(in) :: edges
      integer, allocatable :: boundary(:, :)
      integer :: e

      boundary = edges%node(:, pack([(e, e=1, size(edges%triangles))], edges%triangles == 1))
   end function pack_boundary

   !> A line of a group must be an edge of triangles, and of one group only.
   subroutine check_lines(mesh, edges, errors)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: group_of_edge(:)
      integer :: i, e, loose, shared

      allocate (group_of_edge(size(edges%triangles)))
      group_of_edge = 0
      loose = 0
      shared = 0
      do i = 1, size(mesh%line, 2)
         e = find_edge(edges, mesh%line(1, i), mesh%line(2, i))
         if (e == 0) then
            call add_capped(errors, loose, 'mesh: the '//edge_text(mesh, mesh%line(:, i))//' of group '// &
                            group_text(mesh, mesh%line_group(i))//' is not an edge of triangles; embed the line in '// &
                            'its surface (gmsh: fragment or embed)')
         else if (group_of_edge(e) == 0) then
            group_of_edge(e) = mesh%line_group(i)
         else if (group_of_edge(e) /= mesh%line_group(i)) then
            call add_capped(errors, shared, 'mesh: the '//edge_text(mesh, mesh%line(:, i))//' is in group '// &
                            group_text(mesh, group_of_edge(e))//' and in group '// &
                            group_text(mesh, mesh%line_group(i))//'; a line belongs to one group')
         end if
      end do
      call add_rest(errors, loose, 'lines that are not edges of triangles')
      call add_rest(errors, shared, 'lines in two groups')
   end subroutine check_lines

   !> A point of a group must be a corner of triangles.
   subroutine check_points(mesh, errors)
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      logical, allocatable :: has_triangle(:)
      integer :: i, loose

      allocate (has_triangle(size(mesh%x, 2)))
      has_triangle = .false.
      do i = 1, size(mesh%triangle, 2)
         has_triangle(mesh%triangle(:, i)) = .true.
      end do
      loose = 0
      do i = 1, size(mesh%point)
         if (has_triangle(mesh%point(i))) cycle
         call add_capped(errors, loose, 'mesh: the point at '//at_text(mesh%x(:, mesh%point(i)), mesh%datum)//' of group '// &
                         group_text(mesh, mesh%point_group(i))//' is not a corner of triangles; embed it in its '// &
                         'surface')
      end do
      call add_rest(errors, loose, 'points that are not corners of triangles')
   end subroutine check_points

   !> A place, for messages.
   pure function at_text(x, datum) result(text)
      !> Coordinates less the datum, and that [m]
      real(wp), intent(in) :: x(2), datum(2)
      character(len=:), allocatable :: text

      text = '('//coordinate_text(x(1), datum(1))//', '//coordinate_text(x(2), datum(2))//')'
   end function at_text

   !> A triangle, by its place among the triangles of the file and by its centre.
   pure function triangle_text(mesh, i) result(text)
      type(mesh_t), intent(in) :: mesh
      integer, intent(in) :: i
      character(len=:), allocatable :: text

      text = 'triangle '//to_text(i)//' at '//at_text(sum(mesh%x(:, mesh%triangle(:, i)), dim=2)/3.0_wp, mesh%datum)
   end function triangle_text

   !> An edge by its ends.
   pure function edge_text(mesh, node) result(text)
      type(mesh_t), intent(in) :: mesh
      integer, intent(in) :: node(2)
      character(len=:), allocatable :: text

      text = 'edge from '//at_text(mesh%x(:, node(1)), mesh%datum)//' to '//at_text(mesh%x(:, node(2)), mesh%datum)
   end function edge_text

   !> Name of a group in quotes.
   pure function group_text(mesh, group) result(text)
      type(mesh_t), intent(in) :: mesh
      integer, intent(in) :: group
      character(len=:), allocatable :: text

      text = 'none'
      if (group > 0) text = quoted(mesh%group(group)%name)
   end function group_text

end module mesh_check_m
