!> Numbering of nodes and triangles for the memory caches, and partition of a mesh, both by METIS.
!>
!> The time of a loop over constant-strain triangles goes into fetching their nodes. It is least when triangles that
!> follow one another share nodes, at every cache size. Nested dissection (METIS_NodeND) is made for little fill in a
!> factorisation: it numbers separators last, far from the nodes beside them. A partition of the dual graph into patches
!> that fit the first cache keeps all but the nodes on a patch's rim there; METIS numbers the patches by bisection,
!> so that neighbouring patches mostly follow one another and larger caches are served too. So triangles are ordered by
!> patch, and nodes by their first triangle.
module ordering_m
   use, intrinsic :: iso_c_binding, only: c_int32_t, c_null_ptr, c_ptr
   use rows_m, only: fill_rows
   use mesh_m, only: mesh_t
   implicit none
   private

   public :: order_mesh, partition_mesh

   !> Triangles in a patch: with half as many nodes of 6 numbers of 8 bytes (place, displacement, force) and
   !> 3 corners of 4 bytes each it takes some 20 kB of the 32 kB of a first-level cache
   integer, parameter :: patch = 512
   !> What METIS returns when all is well, and how many nodes triangles share that are neighbours
   integer(c_int32_t), parameter :: metis_ok = 1_c_int32_t, shared_nodes = 2_c_int32_t

   interface
      !> Partition of the dual graph of a mesh (METIS 5, 32-bit indices)
      function metis_part_mesh_dual(elements, nodes, first, node, weights, sizes, common, parts, part_weights, &
                                    options, cut, element_part, node_part) &
         bind(c, name='METIS_PartMeshDual') result(status)
         import :: c_int32_t, c_ptr
         implicit none
         integer(c_int32_t), intent(in) :: elements, nodes, first(*), node(*), common, parts
         type(c_ptr), value :: weights, sizes, part_weights, options
         integer(c_int32_t), intent(out) :: cut, element_part(*), node_part(*)
         integer(c_int32_t) :: status
      end function metis_part_mesh_dual
   end interface

contains

   !> Renumber the nodes and reorder the triangles and lines of a mesh so that neighbours are near in memory. The order
   !> within a patch is the one found. To be called before splitting.
   subroutine order_mesh(mesh)
      type(mesh_t), intent(inout) :: mesh
      integer, allocatable :: part(:), first(:), order(:), new_node(:)
      integer :: i, k, nodes

      call partition_mesh(mesh%triangle, size(mesh%x, 2), size(mesh%triangle, 2)/patch, part)
      call fill_rows(part, maxval(part), first, order)
      mesh%triangle = mesh%triangle(:, order)
      mesh%triangle_group = mesh%triangle_group(order)
      mesh%patch = pack(first(:size(first) - 1), first(2:) > first(:size(first) - 1))

      allocate (new_node(size(mesh%x, 2)))
      new_node = 0
      nodes = 0
      do i = 1, size(mesh%triangle, 2)
         do k = 1, 3
            call number_next(new_node(mesh%triangle(k, i)), nodes)
         end do
      end do
      do i = 1, size(new_node)
         call number_next(new_node(i), nodes)
      end do

      mesh%x(:, new_node) = mesh%x
      do i = 1, size(mesh%triangle, 2)
         mesh%triangle(:, i) = new_node(mesh%triangle(:, i))
      end do
      do i = 1, size(mesh%line, 2)
         mesh%line(:, i) = new_node(mesh%line(:, i))
      end do
      mesh%point = new_node(mesh%point)
      call fill_rows(minval(mesh%line, dim=1), size(mesh%x, 2), first, order)
      mesh%line = mesh%line(:, order)
      mesh%line_group = mesh%line_group(order)
   end subroutine order_mesh

   !> Give a node the next number unless it has one.
   pure subroutine number_next(number, last)
      integer, intent(inout) :: number, last

      if (number > 0) return
      last = last + 1
      number = last
   end subroutine number_next

   !> Part of each triangle, 1 to parts, such that parts are of equal size and share few edges. One part, or a failure
   !> of METIS, gives all triangles to part 1.
   subroutine partition_mesh(triangle, nodes, parts, part)
      !> Corners (3, triangles), number of nodes, number of parts
      integer, intent(in) :: triangle(:, :), nodes, parts
      !> Part of each triangle (triangles)
      integer, allocatable, intent(out) :: part(:)
      integer(c_int32_t), allocatable :: first(:), node(:), element_part(:), node_part(:)
      integer(c_int32_t) :: cut, status
      integer :: i, triangles

      triangles = size(triangle, 2)
      allocate (part(triangles))
      part = 1
      if (parts < 2) return
      allocate (element_part(triangles), node_part(nodes))
      first = [(3*i, i=0, triangles)]
      node = reshape(triangle - 1, [3*triangles])
      status = metis_part_mesh_dual(triangles, nodes, first, node, c_null_ptr, c_null_ptr, shared_nodes, parts, &
                                    c_null_ptr, c_null_ptr, cut, element_part, node_part)
      if (status == metis_ok) part = element_part + 1
   end subroutine partition_mesh

end module ordering_m
