!> The order in which the unknowns of a large system are eliminated: nested dissection of the graph of its nodes by METIS.
!>
!> Both components of a node go together, so the graph is a quarter of the matrix. METIS starts from a seed of its own: the same
!> matrix gets the same order, in every run. Below some hundred thousand unknowns the minimum fill of MUMPS is as good and
!> found sooner.
module elimination_m
   use, intrinsic :: iso_c_binding, only: c_int32_t, c_null_ptr, c_ptr
   use sparse_system_m, only: sparse_system_t
   implicit none
   private

   public :: dissection

   !> Unknowns from which on nested dissection pays
   integer, parameter, public :: large = 100000

   integer(c_int32_t), parameter :: metis_ok = 1_c_int32_t

   interface
      !> Fill-reducing order of a graph (METIS 5, 32-bit indices from 0): of the vertex at each place, and place of each vertex
      function metis_node_nd(vertices, first, neighbour, weights, options, vertex_at, place) &
         bind(c, name='METIS_NodeND') result(status)
         import :: c_int32_t, c_ptr
         implicit none
         integer(c_int32_t), intent(in) :: vertices, first(*), neighbour(*)
         type(c_ptr), value :: weights, options
         integer(c_int32_t), intent(out) :: vertex_at(*), place(*)
         integer(c_int32_t) :: status
      end function metis_node_nd
   end interface

contains

   !> Place of every unknown in the order of elimination (unknowns); of size zero when METIS fails.
   function dissection(system) result(place)
      !> Its pattern is the same across the diagonal
      type(sparse_system_t), intent(in) :: system
      integer, allocatable :: place(:)
      integer(c_int32_t), allocatable :: first(:), neighbour(:), vertex_at(:), place_of(:)
      integer, allocatable :: leader(:), last(:), vertex(:)
      integer :: vertices, v, i
      integer(c_int32_t) :: status

      call list_vertices(system, leader, last, vertex)
      vertices = size(leader)
      call list_neighbours(system, leader, vertex, first, neighbour)
      allocate (vertex_at(vertices), place_of(vertices))
      status = metis_node_nd(int(vertices, c_int32_t), first, neighbour, c_null_ptr, c_null_ptr, vertex_at, place_of)
      if (status /= metis_ok) then
         allocate (place(0))
         return
      end if
      allocate (place(system%unknowns))
      i = 0
      do v = 1, vertices
         associate (at => vertex_at(v) + 1)
            place(leader(at)) = i + 1
            place(last(at)) = i + 1 + last(at) - leader(at)
            i = i + 1 + last(at) - leader(at)
         end associate
      end do
   end function dissection

   !> Nodes that move: their first and last unknown (vertices), and the vertex of each unknown.
   pure subroutine list_vertices(system, leader, last, vertex)
      type(sparse_system_t), intent(in) :: system
      integer, allocatable, intent(out) :: leader(:), last(:), vertex(:)
      integer :: n, v

      allocate (leader(count(any(system%number > 0, dim=1))), vertex(system%unknowns))
      allocate (last(size(leader)))
      v = 0
      do n = 1, size(system%number, 2)
         associate (unknown => system%number(:, n))
            if (all(unknown == 0)) cycle
            v = v + 1
            leader(v) = minval(unknown, mask=unknown > 0)
            last(v) = maxval(unknown)
            vertex(leader(v)) = v
            vertex(last(v)) = v
         end associate
      end do
   end subroutine list_vertices

   !> Neighbours of every vertex (compressed rows, from 0).
   pure subroutine list_neighbours(system, leader, vertex, first, neighbour)
      type(sparse_system_t), intent(in) :: system
      integer, intent(in) :: leader(:), vertex(:)
      integer(c_int32_t), allocatable, intent(out) :: first(:), neighbour(:)
      integer :: v, k, entries, before

      allocate (first(size(leader) + 1), neighbour(size(system%column)))
      entries = 0
      do v = 1, size(leader)
         first(v) = int(entries, c_int32_t)
         before = v
         ! Columns are sorted, and those of a node follow each other
         do k = system%first(leader(v)), system%first(leader(v) + 1) - 1
            associate (other => vertex(system%column(k)))
               if (other == v .or. other == before) cycle
               entries = entries + 1
               neighbour(entries) = int(other - 1, c_int32_t)
               before = other
            end associate
         end do
      end do
      first(size(leader) + 1) = int(entries, c_int32_t)
   end subroutine list_neighbours

end module elimination_m
