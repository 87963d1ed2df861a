!> Splitting of a mesh along edges: the two sides of each edge get nodes of their own, held together by a four-noded
!> joint element. fracture_cuts says where before the run; split_edges does it for any edges, cracks too, while it goes on.
module split_m
   use chains_m, only: direct_chains, find_neighbours
   use edges_m, only: build_edges, edge_table_t, find_edge, next_corner
   use errors_m, only: error_list_t
   use kinds_m, only: wp
   use mesh_m, only: mesh_t, split_mesh_t
   use text_m, only: quoted, to_text
   use union_find_m, only: each_alone, join, representative
   implicit none
   private

   public :: fracture_cuts, split_edges, add_cuts, node_parents

   !> Edges to split, one joint element each, in this order
   type, public :: cut_t
      !> Number of the edge; its nodes in the direction A->B of the joint element (2, cuts)
      integer, allocatable :: edge(:), node(:, :)
      !> Group of the joint element (0: a crack, of no group)
      integer, allocatable :: group(:)
   end type cut_t

contains

   !> The edges of the mesh and those of them that the fracture groups cut, directed along their chains.
   subroutine fracture_cuts(mesh, fracture_group, edges, cut, errors)
      type(mesh_t), intent(in) :: mesh
      !> Is this group a fracture? (groups)
      logical, intent(in) :: fracture_group(:)
      type(edge_table_t), intent(out) :: edges
      type(cut_t), intent(out) :: cut
      !> Fracture lines that cannot be split are added here
      type(error_list_t), intent(inout) :: errors
      integer :: before

      before = errors%count()
      call build_edges(mesh%triangle, size(mesh%x, 2), edges)
      call find_fractures(mesh, edges, fracture_group, cut, errors)
      if (errors%count() == before) call direct(mesh, edges, cut)
   end subroutine fracture_cuts

   !> Edges of the fracture lines. A line given twice in one group counts once.
   subroutine find_fractures(mesh, edges, fracture_group, cut, errors)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      logical, intent(in) :: fracture_group(:)
      type(cut_t), intent(out) :: cut
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: group_of_edge(:)
      integer :: i, e, n, group

      n = count(fracture_group(mesh%line_group))
      allocate (cut%edge(n), cut%node(2, n), cut%group(n), group_of_edge(size(edges%node, 2)))
      group_of_edge = 0
      n = 0
      do i = 1, size(mesh%line, 2)
         group = mesh%line_group(i)
         if (.not. fracture_group(group)) cycle
         e = find_edge(edges, mesh%line(1, i), mesh%line(2, i))
         if (e == 0) then
            call errors%add(line_text(mesh, i)//' is not an edge of triangles (embed the fracture in the surface)')
         else if (edges%triangles(e) /= 2) then
            call errors%add(line_text(mesh, i)//' has '//to_text(edges%triangles(e))// &
                            ' triangle(s) beside it; a fracture needs rock on both sides')
         else if (group_of_edge(e) == 0) then
            n = n + 1
            cut%edge(n) = e
            cut%node(:, n) = mesh%line(:, i)
            cut%group(n) = group
            group_of_edge(e) = group
         else if (group_of_edge(e) /= group) then
            call errors%add(line_text(mesh, i)//' is in fracture group ' &
                            //quoted(mesh%group(group_of_edge(e))%name)//' too')
         end if
      end do
      cut%edge = cut%edge(:n)
      cut%node = cut%node(:, :n)
      cut%group = cut%group(:n)
   end subroutine find_fractures

   !> A line, for messages.
   pure function line_text(mesh, line) result(text)
      type(mesh_t), intent(in) :: mesh
      integer, intent(in) :: line
      character(len=:), allocatable :: text
      real(wp) :: a(2), b(2)

      a = mesh%x(:, mesh%line(1, line))
      b = mesh%x(:, mesh%line(2, line))
      text = 'line from ('//to_text(a(1))//', '//to_text(a(2))//') to ('//to_text(b(1))//', '//to_text(b(2))// &
             ') of fracture group '//quoted(mesh%group(mesh%line_group(line))%name)
   end function line_text

   !> Direct the cuts along their chains.
   subroutine direct(mesh, edges, cut)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      type(cut_t), intent(inout) :: cut
      logical, allocatable :: on_boundary(:), reversed(:)
      integer, allocatable :: neighbour(:, :)
      integer :: e, i

      allocate (on_boundary(size(mesh%x, 2)), reversed(size(cut%edge)), neighbour(2, size(cut%edge)))
      on_boundary = .false.
      do e = 1, size(edges%node, 2)
         if (edges%triangles(e) == 1) on_boundary(edges%node(:, e)) = .true.
      end do
      call find_neighbours(cut%node, cut%group, on_boundary, neighbour)
      call direct_chains(cut%node, neighbour, mesh%x, reversed)
      do i = 1, size(cut%edge)
         if (reversed(i)) cut%node(:, i) = cut%node([2, 1], i)
      end do
   end subroutine direct

   !> Add cracks to the cuts, of no group, each directed as its first triangle has it.
   pure subroutine add_cuts(edges, chosen, cut)
      type(edge_table_t), intent(in) :: edges
      !> Numbers of the edges
      integer, intent(in) :: chosen(:)
      type(cut_t), intent(inout) :: cut
      integer :: i

      cut%node = reshape([cut%node, edges%node(:, chosen)], [2, size(cut%edge) + size(chosen)])
      cut%edge = [cut%edge, chosen]
      cut%group = [cut%group, [(0, i=1, size(chosen))]]
   end subroutine add_cuts

   !> Which node of a split mesh each node was before more edges were cut (nodes after the cut).
   pure function node_parents(before, after) result(parent)
      !> Triangles before and after (3, triangles)
      type(split_mesh_t), intent(in) :: before, after
      integer, allocatable :: parent(:)
      integer :: n, t, k

      ! Nodes of no triangle are in the mesh file: they keep their number
      parent = [(n, n=1, size(after%x, 2))]
      do t = 1, size(after%triangle, 2)
         do k = 1, 3
            parent(after%triangle(k, t)) = before%triangle(k, t)
         end do
      end do
   end function node_parents

   !> Split the mesh along any set of interior edges.
   !>
   !> The triangles around a node fall into sectors, parted by the cut edges and by the outer boundary; every sector
   !> gets a node of its own. Around a tip there is one sector, so a tip stays closed; two across a fracture; as many
   !> as there are branches where fractures meet. The first sector, in the order of the triangles, keeps the node.
   !>
   !>                  |                        o  o
   !>       -----------X-----------  --->       o  o         four branches, four sectors, three new nodes
   !>                  |
   !>
   !> Rock that is taken out is parted from the rest all around, as if by cuts, without joint elements.
   subroutine split_edges(mesh, edges, cut, split, there)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      !> Interior edges, no edge twice
      type(cut_t), intent(in) :: cut
      type(split_mesh_t), intent(out) :: split
      !> Is the triangle there? All are when not given (triangles)
      logical, intent(in), optional :: there(:)
      logical, allocatable :: is_cut(:)
      integer :: e

      allocate (split%present(size(mesh%triangle, 2)), source=.true.)
      if (present(there)) split%present = there
      allocate (is_cut(size(edges%node, 2)))
      is_cut = .false.
      is_cut(cut%edge) = .true.
      do e = 1, size(is_cut)
         if (triangles_present(edges, split%present, e) == 1) is_cut(e) = .true.
      end do
      split%triangle_group = mesh%triangle_group
      split%group = mesh%group
      split%datum = mesh%datum
      call copy_nodes(mesh, edges, is_cut, split)
      call make_joints(mesh, edges, cut, split)
      call make_surface(mesh, edges, cut, split)
      call copy_points(mesh, split)
   end subroutine split_edges

   !> Give each sector its node. Corners of triangles are joined into sectors across the edges that are not cut, by
   !> union and find; a corner is numbered 3*(triangle-1) + its place in the triangle.
   subroutine copy_nodes(mesh, edges, is_cut, split)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      logical, intent(in) :: is_cut(:)
      type(split_mesh_t), intent(inout) :: split
      integer, allocatable :: parent(:), node_of_sector(:), origin(:)
      logical, allocatable :: taken(:)
      integer :: e, k, t, sector, node, nodes

      nodes = size(mesh%x, 2)
      allocate (parent(3*size(mesh%triangle, 2)))
      parent = each_alone(size(parent))
      do e = 1, size(is_cut)
         if (is_cut(e) .or. edges%triangle(2, e) == 0) cycle
         do k = 1, 2
            node = edges%node(k, e)
            call join(parent, corner_at(mesh%triangle, edges%triangle(1, e), node), &
                      corner_at(mesh%triangle, edges%triangle(2, e), node))
         end do
      end do

      ! At most every corner has a node of its own, besides nodes that no triangle has
      allocate (node_of_sector(size(parent)), taken(nodes), origin(nodes + size(parent)))
      node_of_sector = 0
      taken = .false.
      origin(:nodes) = [(node, node=1, nodes)]
      allocate (split%triangle(3, size(mesh%triangle, 2)))
      do t = 1, size(mesh%triangle, 2)
         do k = 1, 3
            node = mesh%triangle(k, t)
            sector = representative(parent, 3*(t - 1) + k)
            if (node_of_sector(sector) == 0) then
               if (taken(node)) then
                  nodes = nodes + 1
                  origin(nodes) = node
                  node_of_sector(sector) = nodes
               else
                  taken(node) = .true.
                  node_of_sector(sector) = node
               end if
            end if
            split%triangle(k, t) = node_of_sector(sector)
         end do
      end do
      split%origin = origin(:nodes)
      split%x = mesh%x(:, split%origin)
   end subroutine copy_nodes

   !> Corner of a triangle at a node.
   pure integer function corner_at(triangle, t, node)
      integer, intent(in) :: triangle(:, :), t, node

      corner_at = 3*(t - 1) + place_in(triangle(:, t), node)
   end function corner_at

   !> Place of a node in a triangle.
   pure integer function place_in(corner, node)
      integer, intent(in) :: corner(3), node

      place_in = 3
      if (corner(1) == node) place_in = 1
      if (corner(2) == node) place_in = 2
   end function place_in

   !> Joint elements between the two sides of each cut.
   subroutine make_joints(mesh, edges, cut, split)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      type(cut_t), intent(in) :: cut
      type(split_mesh_t), intent(inout) :: split
      integer :: i, k, side, lower, upper

      allocate (split%joint(4, size(cut%edge)), split%joint_triangle(2, size(cut%edge)))
      split%joint_group = cut%group
      do i = 1, size(cut%edge)
         side = merge(1, 2, edges%node(1, cut%edge(i)) == cut%node(1, i))
         upper = edges%triangle(side, cut%edge(i))
         lower = edges%triangle(3 - side, cut%edge(i))
         split%joint_triangle(:, i) = [lower, upper]
         do k = 1, 2
            split%joint(k, i) = split%triangle(place_in(mesh%triangle(:, lower), cut%node(k, i)), lower)
            split%joint(k + 2, i) = split%triangle(place_in(mesh%triangle(:, upper), cut%node(k, i)), upper)
         end do
      end do
   end subroutine make_joints

   !> How many of the triangles beside an edge are there.
   pure integer function triangles_present(edges, there, e)
      type(edge_table_t), intent(in) :: edges
      !> Is the triangle there? (triangles)
      logical, intent(in) :: there(:)
      integer, intent(in) :: e
      integer :: k

      triangles_present = count([(there(edges%triangle(k, e)), k=1, edges%triangles(e))])
   end function triangles_present

   !> Free edges, the rock on their left: first those with rock on one side alone in the order of the edges, then the lower and
   !> the upper wall of each joint element with rock on both sides in turn.
   subroutine make_surface(mesh, edges, cut, split)
      type(mesh_t), intent(in) :: mesh
      type(edge_table_t), intent(in) :: edges
      type(cut_t), intent(in) :: cut
      type(split_mesh_t), intent(inout) :: split
      integer, allocatable :: group_of_edge(:)
      integer :: e, i, k, n, t, beside(size(edges%node, 2))

      beside = [(triangles_present(edges, split%present, e), e=1, size(beside))]
      n = count(beside == 1) + 2*count(beside(cut%edge) == 2)
      allocate (split%surface(2, n), split%surface_triangle(n), split%surface_joint(n), split%surface_side(n))
      allocate (split%surface_group(n), group_of_edge(size(edges%node, 2)))
      split%surface_joint = 0
      split%surface_side = 0
      split%surface_group = 0
      group_of_edge = 0
      do i = 1, size(mesh%line, 2)
         e = find_edge(edges, mesh%line(1, i), mesh%line(2, i))
         if (e > 0) group_of_edge(e) = mesh%line_group(i)
      end do

      n = 0
      do e = 1, size(edges%node, 2)
         if (beside(e) /= 1) cycle
         n = n + 1
         ! The second triangle has the edge the other way round
         k = merge(1, 2, split%present(edges%triangle(1, e)))
         t = edges%triangle(k, e)
         split%surface(:, n) = [split%triangle(place_in(mesh%triangle(:, t), edges%node(k, e)), t), &
                                split%triangle(place_in(mesh%triangle(:, t), edges%node(3 - k, e)), t)]
         split%surface_triangle(n) = t
         split%surface_group(n) = group_of_edge(e)
      end do
      do i = 1, size(cut%edge)
         if (beside(cut%edge(i)) /= 2) cycle
         associate (joint => split%joint(:, i))
            split%surface(:, n + 1:n + 2) = reshape([joint(2), joint(1), joint(3), joint(4)], [2, 2])
         end associate
         split%surface_triangle(n + 1:n + 2) = split%joint_triangle(:, i)
         split%surface_joint(n + 1:n + 2) = i
         split%surface_side(n + 1:n + 2) = [-1, 1]
         n = n + 2
      end do
   end subroutine make_surface

   !> Points of groups: every copy of the node belongs to the group.
   subroutine copy_points(mesh, split)
      type(mesh_t), intent(in) :: mesh
      type(split_mesh_t), intent(inout) :: split
      integer, allocatable :: copies(:), first(:), copy(:)
      integer :: i, n, node, nodes

      ! Lists of the new copies of each node: copy(first(node):first(node+1)-1)
      nodes = size(mesh%x, 2)
      allocate (copies(nodes), first(nodes + 1), copy(size(split%origin) - nodes))
      copies = 0
      do i = nodes + 1, size(split%origin)
         copies(split%origin(i)) = copies(split%origin(i)) + 1
      end do
      first(1) = 1
      do node = 1, nodes
         first(node + 1) = first(node) + copies(node)
      end do
      copies = 0
      do i = nodes + 1, size(split%origin)
         node = split%origin(i)
         copy(first(node) + copies(node)) = i
         copies(node) = copies(node) + 1
      end do

      n = size(mesh%point) + sum(copies(mesh%point))
      allocate (split%point(n), split%point_group(n))
      n = 0
      do i = 1, size(mesh%point)
         node = mesh%point(i)
         split%point(n + 1) = node
         split%point(n + 2:n + 1 + copies(node)) = copy(first(node):first(node + 1) - 1)
         split%point_group(n + 1:n + 1 + copies(node)) = mesh%point_group(i)
         n = n + 1 + copies(node)
      end do
   end subroutine copy_points

end module split_m
