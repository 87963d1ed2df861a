!> Edges of a triangulation, each once, with the triangles on its two sides.
module edges_m
   implicit none
   private

   public :: build_edges, find_edge

   !> Every edge once, in the order in which the triangles name them. The table is built and searched through lists of
   !> the edges at their lower node, a handful each, so that its cost is linear.
   type, public :: edge_table_t
      !> Nodes of each edge (2, edges), in the direction that has triangle(1) on its left
      integer, allocatable :: node(:, :)
      !> Triangles on its left and on its right, 0 where there is none (2, edges)
      integer, allocatable :: triangle(:, :)
      !> Number of triangles that have it (edges): 1 outer boundary, 2 interior, more is no triangulation
      integer, allocatable :: triangles(:)
      !> Edge from corner k to the next corner of each triangle (3, triangles)
      integer, allocatable :: of_triangle(:, :)
      !> First edge in the list of each lower node (nodes), next edge in the list (edges); 0 ends it
      integer, allocatable, private :: first(:), next(:)
   end type edge_table_t

   !> Corner that follows each corner of a triangle
   integer, parameter, public :: next_corner(3) = [2, 3, 1]

contains

   !> Build the table of edges.
   pure subroutine build_edges(triangle, nodes, edges)
      !> Corners, anticlockwise (3, triangles)
      integer, intent(in) :: triangle(:, :)
      !> Number of nodes
      integer, intent(in) :: nodes
      type(edge_table_t), intent(out) :: edges
      integer, allocatable :: node(:, :), side(:, :), triangles(:), next(:)
      integer :: t, k, a, b, e, n, most

      most = 3*size(triangle, 2)
      allocate (node(2, most), side(2, most), triangles(most), next(most))
      allocate (edges%of_triangle(3, size(triangle, 2)), edges%first(nodes))
      edges%first = 0
      n = 0
      do t = 1, size(triangle, 2)
         do k = 1, 3
            a = triangle(k, t)
            b = triangle(next_corner(k), t)
            e = edges%first(min(a, b))
            do while (e > 0)
               if (max(node(1, e), node(2, e)) == max(a, b)) exit
               e = next(e)
            end do
            if (e == 0) then
               n = n + 1
               e = n
               node(:, e) = [a, b]
               side(:, e) = [t, 0]
               triangles(e) = 1
               next(e) = edges%first(min(a, b))
               edges%first(min(a, b)) = e
            else
               if (triangles(e) == 1) side(2, e) = t
               triangles(e) = triangles(e) + 1
            end if
            edges%of_triangle(k, t) = e
         end do
      end do
      edges%node = node(:, :n)
      edges%triangle = side(:, :n)
      edges%triangles = triangles(:n)
      call move_alloc(next, edges%next)
   end subroutine build_edges

   !> Number of the edge between two nodes (0: there is none).
   pure integer function find_edge(edges, a, b) result(edge)
      type(edge_table_t), intent(in) :: edges
      integer, intent(in) :: a, b

      edge = edges%first(min(a, b))
      do while (edge > 0)
         if (max(edges%node(1, edge), edges%node(2, edge)) == max(a, b)) return
         edge = edges%next(edge)
      end do
   end function find_edge

end module edges_m
