!> The tables of a gmsh file as they stand there: nodes, elements and named groups by the file's own numbers; and
!> their assembly into a mesh.
module gmsh_table_m
   use errors_m, only: error_list_t
   use geometry_m, only: twice_area
   use kinds_m, only: wp, i8
   use mesh_m, only: group_t, mesh_t
   use text_m, only: to_text
   implicit none
   private

   public :: add_element, add_group, assemble

   !> gmsh's numbers of the element types read here, and of the highest type it knows
   integer, parameter, public :: gmsh_line = 1, gmsh_triangle = 2, gmsh_point = 15, highest_type = 140
   !> Groups of points, lines, surfaces (their dimensions)
   integer, parameter, public :: point_dimension = 0, line_dimension = 1, surface_dimension = 2
   !> A physical group that an element is in, when it is in none
   integer, parameter, public :: no_group = 0

   !> What a file holds, by its own numbers
   type, public :: gmsh_table_t
      !> Number of each node in the file (nodes), its coordinates (3, nodes) [m]
      integer(i8), allocatable :: node_number(:)
      real(wp), allocatable :: x(:, :)
      !> Elements so far; gmsh type and physical group (elements), number in the file (elements), node numbers (3, elements)
      integer :: elements = 0
      integer, allocatable :: element_type(:), element_group(:)
      integer(i8), allocatable :: element_number(:), element_node(:, :)
      !> Elements of other types, by type
      integer :: unsupported(highest_type) = 0
      !> Named physical groups
      type(group_t), allocatable :: group(:)
   end type gmsh_table_t

   !> Room for elements to begin with
   integer, parameter :: least_room = 1024
   !> Numbers of nodes may leave gaps of any length: they are found through a table this many times as long as the nodes, in
   !> which a number's place comes from its product with a large odd number
   integer, parameter :: table_per_node = 2
   integer(i8), parameter :: spread_by = 2654435761_i8
   !> Nodes further than this part of the mesh's size from one plane z = constant are out of plane
   real(wp), parameter :: plane_tolerance = 1.0e-9_wp
   !> A mesh this many times its size away from the origin has a datum taken off its coordinates
   real(wp), parameter :: far_away = 10.0_wp
   !> Larger coordinates are damaged numbers; their squares could overflow [m]
   real(wp), parameter :: largest_coordinate = 1.0e30_wp

contains

   !> Add an element of a physical group to the table, or count it when its type is not one read here.
   subroutine add_element(table, gmsh_type, number, group, node)
      type(gmsh_table_t), intent(inout) :: table
      !> Element type, number in the file, physical group
      integer, intent(in) :: gmsh_type
      integer(i8), intent(in) :: number
      integer, intent(in) :: group
      !> Node numbers in the file
      integer(i8), intent(in) :: node(:)
      integer :: n

      if (nodes_of_read_type(gmsh_type) == 0) then
         if (gmsh_type >= 1 .and. gmsh_type <= highest_type) then
            table%unsupported(gmsh_type) = table%unsupported(gmsh_type) + 1
         end if
         return
      end if
      if (.not. allocated(table%element_type)) call make_room(table, least_room)
      if (table%elements == size(table%element_type)) call make_room(table, 2*table%elements)
      n = table%elements + 1
      table%elements = n
      table%element_type(n) = gmsh_type
      table%element_number(n) = number
      ! gmsh writes a group negative where its geometry runs against the group's direction
      table%element_group(n) = abs(group)
      table%element_node(:, n) = 0_i8
      table%element_node(:size(node), n) = node
   end subroutine add_element

   !> Make room for elements.
   subroutine make_room(table, room)
      type(gmsh_table_t), intent(inout) :: table
      integer, intent(in) :: room
      integer(i8), allocatable :: node(:, :), number(:)

      call lengthen(table%element_type, room)
      call lengthen(table%element_group, room)
      allocate (number(room))
      if (allocated(table%element_number)) number(:table%elements) = table%element_number
      call move_alloc(number, table%element_number)
      allocate (node(3, room))
      if (allocated(table%element_node)) node(:, :table%elements) = table%element_node
      call move_alloc(node, table%element_node)
   end subroutine make_room

   subroutine lengthen(list, room)
      integer, allocatable, intent(inout) :: list(:)
      integer, intent(in) :: room
      integer, allocatable :: longer(:)

      allocate (longer(room))
      if (allocated(list)) longer(:size(list)) = list
      call move_alloc(longer, list)
   end subroutine lengthen

   !> Number of nodes of an element type read here (0: it is not read).
   pure integer function nodes_of_read_type(gmsh_type) result(nodes)
      integer, intent(in) :: gmsh_type

      select case (gmsh_type)
      case (gmsh_line)
         nodes = 2
      case (gmsh_triangle)
         nodes = 3
      case (gmsh_point)
         nodes = 1
      case default
         nodes = 0
      end select
   end function nodes_of_read_type

   !> Add a named physical group.
   subroutine add_group(table, dimension, tag, name)
      type(gmsh_table_t), intent(inout) :: table
      !> 0 points, 1 lines, 2 triangles; number in the file
      integer, intent(in) :: dimension, tag
      character(len=*), intent(in) :: name

      if (.not. allocated(table%group)) allocate (table%group(0))
      table%group = [table%group, group_t(name=name, dimension=dimension, tag=tag)]
   end subroutine add_group

   !> Build the mesh from the file's tables: nodes renumbered without gaps and without those that no element of the mesh
   !> uses, in the file's order; triangles turned anticlockwise; lines and points only where they are in a group.
   subroutine assemble(table, path, format_loses_groups, mesh, errors)
      type(gmsh_table_t), intent(inout) :: table
      !> Mesh file, for messages
      character(len=*), intent(in) :: path
      !> Does the format of the file lose the groups where everything is saved?
      logical, intent(in) :: format_loses_groups
      type(mesh_t), intent(inout) :: mesh
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: mesh_node(:)
      logical, allocatable :: used(:)
      integer :: before

      before = errors%count()
      call check_types(table, path, errors)
      if (errors%count() > before) return
      if (.not. allocated(table%node_number)) call errors%add(path//': there is no $Nodes section')
      if (table%elements == 0) call errors%add(path//': there are no triangles, lines or points')
      if (errors%count() > before) return
      if (.not. allocated(table%group)) allocate (table%group(0))
      call map_nodes(table, path, errors)
      if (errors%count() > before) return
      if (format_loses_groups) call check_groups_lost(table, path, errors)
      if (errors%count() > before) return
      used = used_nodes(table)
      call check_plane(table, path, used, errors)
      if (errors%count() > before) return
      call number_nodes(table, used, mesh_node, mesh)
      call take_off_datum(mesh)
      call sort_out(table, mesh_node, mesh)
      call turn_anticlockwise(mesh)
   end subroutine assemble

   !> Only 3-node triangles, 2-node lines and points are read.
   subroutine check_types(table, path, errors)
      type(gmsh_table_t), intent(in) :: table
      character(len=*), intent(in) :: path
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, highest_type
         if (table%unsupported(i) == 0) cycle
         call errors%add(path//': '//to_text(table%unsupported(i))//' elements of gmsh type '//to_text(i)//' ('// &
                         type_name(i)//'); only 3-node triangles, 2-node lines and points are read')
      end do
   end subroutine check_types

   !> gmsh's element types that a user may meet by mistake.
   pure function type_name(gmsh_type)
      integer, intent(in) :: gmsh_type
      character(len=:), allocatable :: type_name

      select case (gmsh_type)
      case (3, 10, 16)
         type_name = 'quadrangles: do not recombine the mesh'
      case (4, 11)
         type_name = 'tetrahedra: mesh in two dimensions'
      case (5, 12, 17)
         type_name = 'hexahedra: mesh in two dimensions'
      case (6, 13, 18)
         type_name = 'prisms: mesh in two dimensions'
      case (7, 14, 19)
         type_name = 'pyramids: mesh in two dimensions'
      case (8, 9, 20:28)
         type_name = 'second or higher order: set the element order to 1'
      case default
         type_name = 'of another kind'
      end select
   end function type_name

   !> Replace the numbers of nodes in the elements by the places of the nodes in the file.
   subroutine map_nodes(table, path, errors)
      type(gmsh_table_t), intent(inout) :: table
      character(len=*), intent(in) :: path
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: node(:)
      integer :: i, j, at

      if (minval(table%node_number) < 1_i8) then
         call errors%add(path//': node number '//to_text(minval(table%node_number))//'; numbers must be positive')
         return
      end if
      allocate (node(0:table_per_node*size(table%node_number)), source=0)
      do i = 1, size(table%node_number)
         at = place_in(node, table%node_number, table%node_number(i))
         if (node(at) /= 0) then
            call errors%add(path//': node number '//to_text(table%node_number(i))//' is given twice')
            return
         end if
         node(at) = i
      end do
      do i = 1, table%elements
         do j = 1, nodes_of_read_type(table%element_type(i))
            at = place_in(node, table%node_number, table%element_node(j, i))
            if (node(at) == 0) then
               call errors%add(path//': element '//to_text(table%element_number(i))//' has node '// &
                               to_text(table%element_node(j, i))//', which is not in the file')
               return
            end if
            table%element_node(j, i) = int(node(at), i8)
         end do
      end do
   end subroutine map_nodes

   !> Place of a number in the table of nodes, an empty one when it is not there.
   pure integer function place_in(node, number, wanted) result(at)
      !> Table: node or 0 (0:)
      integer, intent(in) :: node(0:)
      !> Number of each node, and the one looked for
      integer(i8), intent(in) :: number(:), wanted

      at = int(modulo(modulo(wanted, 2147483647_i8)*spread_by, size(node, kind=i8)))
      do while (node(at) /= 0)
         if (number(node(at)) == wanted) return
         at = at + 1
         if (at == size(node)) at = 0
      end do
   end function place_in

   !> Which nodes of the file the mesh uses (nodes of the file).
   pure function used_nodes(table) result(used)
      type(gmsh_table_t), intent(in) :: table
      logical :: used(size(table%node_number))
      integer :: i, j

      used = .false.
      do i = 1, table%elements
         if (.not. belongs(table, i)) cycle
         do j = 1, nodes_of_read_type(table%element_type(i))
            used(table%element_node(j, i)) = .true.
         end do
      end do
   end function used_nodes

   !> gmsh drops the groups from a file of format 2.2 when it saves all elements, and keeps their names.
   subroutine check_groups_lost(table, path, errors)
      type(gmsh_table_t), intent(in) :: table
      character(len=*), intent(in) :: path
      type(error_list_t), intent(inout) :: errors

      if (size(table%group) == 0 .or. any(table%element_group(:table%elements) /= no_group)) return
      call errors%add(path//': the file names '//to_text(size(table%group))//' physical groups, and nothing is in them: '// &
                      '''Save all elements'' (Mesh.SaveAll = 1) loses the groups in format 2.2; save without it, '// &
                      'or in format 4.1')
   end subroutine check_groups_lost

   !> The mesh must be of this world and lie in one plane z = constant.
   subroutine check_plane(table, path, used, errors)
      type(gmsh_table_t), intent(in) :: table
      character(len=*), intent(in) :: path
      !> Does the mesh use the node? (nodes of the file)
      logical, intent(in) :: used(:)
      type(error_list_t), intent(inout) :: errors
      real(wp) :: low(3), high(3), largest
      integer :: i

      if (.not. any(used)) return
      do i = 1, 3
         low(i) = minval(table%x(i, :), mask=used)
         high(i) = maxval(table%x(i, :), mask=used)
      end do
      largest = max(maxval(abs(low)), maxval(abs(high)))
      if (largest > largest_coordinate) then
         call errors%add(path//': there is a coordinate of '//to_text(largest)//' m; a number is damaged')
         return
      end if
      if (high(3) - low(3) > plane_tolerance*max(high(1) - low(1), high(2) - low(2))) then
         call errors%add(path//': z of the nodes runs from '//to_text(low(3))//' to '//to_text(high(3))// &
                         '; the mesh must lie in a plane z = constant')
      end if
   end subroutine check_plane

   !> Take a datum off coordinates that are many times the size of the mesh. It is in whole metres, so that nothing is rounded.
   pure subroutine take_off_datum(mesh)
      type(mesh_t), intent(inout) :: mesh
      real(wp) :: low(2), high(2)
      integer :: i

      if (size(mesh%x, 2) == 0) return
      low = minval(mesh%x, dim=2)
      high = maxval(mesh%x, dim=2)
      do i = 1, 2
         if (abs(low(i)) <= far_away*maxval(high - low)) cycle
         mesh%datum(i) = anint(low(i))
         mesh%x(i, :) = mesh%x(i, :) - mesh%datum(i)
      end do
   end subroutine take_off_datum

   !> Number the nodes that the mesh uses, in the file's order.
   subroutine number_nodes(table, used, mesh_node, mesh)
      type(gmsh_table_t), intent(in) :: table
      !> Does the mesh use the node? (nodes of the file)
      logical, intent(in) :: used(:)
      !> Number in the mesh (nodes of the file; 0: none)
      integer, allocatable, intent(out) :: mesh_node(:)
      type(mesh_t), intent(inout) :: mesh
      integer :: i, nodes

      allocate (mesh_node(size(used)), source=0)
      allocate (mesh%x(2, count(used)))
      nodes = 0
      do i = 1, size(mesh_node)
         if (.not. used(i)) cycle
         nodes = nodes + 1
         mesh_node(i) = nodes
         mesh%x(:, nodes) = table%x(1:2, i)
      end do
   end subroutine number_nodes

   !> Does an element belong to the mesh? Triangles do, so that one without a group is found out; a line or a point
   !> outside any group means nothing.
   pure logical function belongs(table, element)
      type(gmsh_table_t), intent(in) :: table
      integer, intent(in) :: element

      belongs = table%element_type(element) == gmsh_triangle .or. table%element_group(element) /= no_group
   end function belongs

   !> Sort the elements into triangles, lines and points, and find their groups.
   subroutine sort_out(table, mesh_node, mesh)
      type(gmsh_table_t), intent(inout) :: table
      !> Number in the mesh (nodes of the file)
      integer, intent(in) :: mesh_node(:)
      type(mesh_t), intent(inout) :: mesh
      integer :: i, triangles, lines, points

      associate (kind => table%element_type(:table%elements), tag => table%element_group(:table%elements))
         triangles = count(kind == gmsh_triangle)
         lines = count(kind == gmsh_line .and. tag /= no_group)
         points = count(kind == gmsh_point .and. tag /= no_group)
      end associate
      allocate (mesh%triangle(3, triangles), mesh%triangle_group(triangles))
      allocate (mesh%line(2, lines), mesh%line_group(lines), mesh%point(points), mesh%point_group(points))
      triangles = 0
      lines = 0
      points = 0
      do i = 1, table%elements
         if (.not. belongs(table, i)) cycle
         associate (node => table%element_node(:, i), tag => table%element_group(i))
            select case (table%element_type(i))
            case (gmsh_triangle)
               triangles = triangles + 1
               mesh%triangle(:, triangles) = mesh_node(node)
               call find_or_add(table, surface_dimension, tag, mesh%triangle_group(triangles))
            case (gmsh_line)
               lines = lines + 1
               mesh%line(:, lines) = mesh_node(node(:2))
               call find_or_add(table, line_dimension, tag, mesh%line_group(lines))
            case (gmsh_point)
               points = points + 1
               mesh%point(points) = mesh_node(node(1))
               call find_or_add(table, point_dimension, tag, mesh%point_group(points))
            end select
         end associate
      end do
      mesh%group = table%group
   end subroutine sort_out

   !> Index of a physical group; one without a name is called by its number.
   subroutine find_or_add(table, dimension, tag, found)
      type(gmsh_table_t), intent(inout) :: table
      integer, intent(in) :: dimension, tag
      integer, intent(out) :: found

      found = 0
      if (tag == no_group) return
      do found = 1, size(table%group)
         if (table%group(found)%tag == tag .and. table%group(found)%dimension == dimension) return
      end do
      call add_group(table, dimension, tag, to_text(tag))
      found = size(table%group)
   end subroutine find_or_add

   !> Turn the triangles of a surface whose normal points downwards.
   subroutine turn_anticlockwise(mesh)
      type(mesh_t), intent(inout) :: mesh
      integer :: i

      do i = 1, size(mesh%triangle, 2)
         associate (node => mesh%triangle(:, i))
            if (twice_area(mesh%x(:, node(1)), mesh%x(:, node(2)), mesh%x(:, node(3))) < 0.0_wp) then
               mesh%triangle(2:3, i) = mesh%triangle([3, 2], i)
            end if
         end associate
      end do
   end subroutine turn_anticlockwise

end module gmsh_table_m
