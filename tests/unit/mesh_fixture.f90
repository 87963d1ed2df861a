!> Small meshes for the unit tests.
!>
!> crossed_grid(columns, rows): unit squares with a node at each centre. Lines can follow sides and half diagonals, so
!> that up to eight branches meet at a corner and four at a centre. Corner (x, y) has number y*(columns+1) + x + 1,
!> centres come after the corners.
!>
!>     y
!>     1  4-----5-----6        crossed_grid(2, 1): 8 nodes, 8 triangles
!>        |\   /|\   /|
!>        |  7  |  8  |
!>        |/   \|/   \|
!>     0  1-----2-----3
!>        0     1     2  x
module mesh_fixture
   use kinds_m, only: wp
   use mesh_m, only: find_group, group_t, mesh_t, split_mesh_t
   use errors_m, only: error_list_t
   use edges_m, only: edge_table_t
   use split_m, only: cut_t, fracture_cuts, split_edges
   implicit none
   private

   public :: crossed_grid, add_path, add_point, node_at, is_fracture, split_mesh, interior_edges

contains

   !> Grid of unit squares, each of four triangles of group 'rock'.
   pure function crossed_grid(columns, rows) result(mesh)
      integer, intent(in) :: columns, rows
      type(mesh_t) :: mesh
      integer :: i, j, k, n, t, corner(4), centre

      allocate (mesh%x(2, (columns + 1)*(rows + 1) + columns*rows), mesh%triangle(3, 4*columns*rows))
      allocate (mesh%line(2, 0), mesh%line_group(0), mesh%point(0), mesh%point_group(0))
      allocate (mesh%triangle_group(4*columns*rows))
      mesh%triangle_group = 1
      allocate (mesh%group(1))
      mesh%group(1) = group_t(name='rock', dimension=2, tag=10)
      n = 0
      do j = 0, rows
         do i = 0, columns
            n = n + 1
            mesh%x(:, n) = real([i, j], wp)
         end do
      end do
      centre = n
      t = 0
      do j = 0, rows - 1
         do i = 0, columns - 1
            centre = centre + 1
            mesh%x(:, centre) = real([i, j], wp) + 0.5_wp
            corner(1) = j*(columns + 1) + i + 1
            corner(2) = corner(1) + 1
            corner(3) = corner(2) + columns + 1
            corner(4) = corner(3) - 1
            do k = 1, 4
               t = t + 1
               mesh%triangle(:, t) = [corner(k), corner(mod(k, 4) + 1), centre]
            end do
         end do
      end do
   end function crossed_grid

   !> Number of the first node at a place (0: there is none).
   pure integer function node_at(x, place) result(node)
      real(wp), intent(in) :: x(:, :), place(2)

      do node = 1, size(x, 2)
         if (all(abs(x(:, node) - place) < 1.0e-9_wp)) return
      end do
      node = 0
   end function node_at

   !> Add lines from place to place to a group, which is made when it is not there.
   pure subroutine add_path(mesh, name, x, y)
      type(mesh_t), intent(inout) :: mesh
      !> Name of the group
      character(len=*), intent(in) :: name
      !> Places, all of them nodes
      real(wp), intent(in) :: x(:), y(:)
      integer :: i, group, ends(2)

      group = find_group(mesh%group, name, 1)
      if (group == 0) then
         group = size(mesh%group) + 1
         mesh%group = [mesh%group, group_t(name=name, dimension=1, tag=10 + group)]
      end if
      do i = 1, size(x) - 1
         ends = [node_at(mesh%x, [x(i), y(i)]), node_at(mesh%x, [x(i + 1), y(i + 1)])]
         mesh%line = reshape([mesh%line, ends], [2, size(mesh%line, 2) + 1])
         mesh%line_group = [mesh%line_group, group]
      end do
   end subroutine add_path

   !> Add a point group at a node.
   pure subroutine add_point(mesh, name, place)
      type(mesh_t), intent(inout) :: mesh
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: place(2)

      mesh%group = [mesh%group, group_t(name=name, dimension=0, tag=11 + size(mesh%group))]
      mesh%point = [mesh%point, node_at(mesh%x, place)]
      mesh%point_group = [mesh%point_group, size(mesh%group)]
   end subroutine add_point

   !> Groups whose names begin with 'fracture'.
   pure function is_fracture(mesh)
      type(mesh_t), intent(in) :: mesh
      logical, allocatable :: is_fracture(:)
      integer :: i

      allocate (is_fracture(size(mesh%group)))
      do i = 1, size(mesh%group)
         is_fracture(i) = mesh%group(i)%dimension == 1 .and. index(mesh%group(i)%name, 'fracture') == 1
      end do
   end function is_fracture

   !> Split the mesh along the lines of the fracture groups, one joint element a line, in the order of the lines.
   !> All joint elements of a chain (see chains_m) run A->B the same way, to +x or, where it is upright, to +y.
   subroutine split_mesh(mesh, fracture_group, split, errors)
      type(mesh_t), intent(in) :: mesh
      !> Is this group a fracture? (groups)
      logical, intent(in) :: fracture_group(:)
      !> The mesh with facing walls
      type(split_mesh_t), intent(out) :: split
      !> Fracture lines that cannot be split are added here
      type(error_list_t), intent(inout) :: errors
      type(edge_table_t) :: edges
      type(cut_t) :: cut
      integer :: before

      before = errors%count()
      call fracture_cuts(mesh, fracture_group, edges, cut, errors)
      if (errors%count() == before) call split_edges(mesh, edges, cut, split)
   end subroutine split_mesh

   !> Cut every interior edge, each directed as its first triangle has it: cohesive joint elements everywhere.
   subroutine interior_edges(edges, cut)
      type(edge_table_t), intent(in) :: edges
      type(cut_t), intent(out) :: cut
      integer :: e

      cut%edge = pack([(e, e=1, size(edges%triangles))], edges%triangles == 2)
      cut%node = edges%node(:, cut%edge)
      allocate (cut%group(size(cut%edge)))
      cut%group = 0
   end subroutine interior_edges

end module mesh_fixture
