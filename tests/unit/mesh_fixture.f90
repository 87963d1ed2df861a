!> Small meshes for the unit tests, and a writer of gmsh files.
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
   use kinds_m, only: wp, i4, i8
   use mesh_m, only: find_group, group_t, mesh_t
   implicit none
   private

   public :: crossed_grid, add_path, add_point, node_at, is_fracture, write_gmsh

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

   !> Write a mesh as gmsh does. Node numbers leave gaps (node i has number 10 i), and a last node is used by nothing.
   subroutine write_gmsh(mesh, path, version, binary)
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: path
      !> '2.2' or '4.1'
      character(len=*), intent(in) :: version
      logical, intent(in) :: binary
      integer :: unit, i

      open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace')
      call line('$MeshFormat')
      call line(version//merge(' 1 8', ' 0 8', binary))
      if (binary) then
         write (unit) 1_i4
         call line('')
      end if
      call line('$EndMeshFormat')
      call line('$Comments')
      call line('nothing of use, $Nodes and all')
      call line('$EndComments')
      call line('$PhysicalNames')
      call line(decimal(size(mesh%group)))
      do i = 1, size(mesh%group)
         call line(decimal(mesh%group(i)%dimension)//' '//decimal(mesh%group(i)%tag)//' "'// &
                   trim(mesh%group(i)%name)//'"')
      end do
      call line('$EndPhysicalNames')
      if (version == '2.2') then
         call write_2()
      else
         call write_4()
      end if
      close (unit)

   contains

      !> Sections of format 2.2.
      subroutine write_2()
         integer :: n

         call line('$Nodes')
         call line(decimal(size(mesh%x, 2) + 1))
         do n = 1, size(mesh%x, 2)
            call number(10*n)
            call place(mesh%x(:, n))
         end do
         call number(10*size(mesh%x, 2) + 5)
         call place([7.0_wp, 7.0_wp])
         if (binary) call line('')
         call line('$EndNodes')
         call line('$Elements')
         call line(decimal(size(mesh%point) + size(mesh%line, 2) + size(mesh%triangle, 2)))
         do n = 1, size(mesh%point)
            call element_2(15, mesh%point_group(n), [mesh%point(n)])
         end do
         do n = 1, size(mesh%line, 2)
            call element_2(1, mesh%line_group(n), mesh%line(:, n))
         end do
         do n = 1, size(mesh%triangle, 2)
            call element_2(2, mesh%triangle_group(n), mesh%triangle(:, n))
         end do
         if (binary) call line('')
         call line('$EndElements')
      end subroutine write_2

      !> One element of format 2.2, a block of its own in a binary file.
      subroutine element_2(gmsh_type, group, node)
         integer, intent(in) :: gmsh_type, group, node(:)
         integer :: k, tag

         tag = 0
         if (group > 0) tag = mesh%group(group)%tag
         if (.not. binary) call number(1)
         call number(gmsh_type)
         if (binary) call number(1)
         call number(2)
         if (binary) call number(1)
         call number(tag)
         call number(group)
         do k = 1, size(node)
            call number(10*node(k))
         end do
         if (.not. binary) call line('')
      end subroutine element_2

      !> Sections of format 4.1: a geometrical entity for each group, of the group's index.
      subroutine write_4()
         integer :: n, dimension, k

         call line('$Entities')
         do dimension = 0, 3
            call long(count(mesh%group%dimension == dimension))
         end do
         do dimension = 0, 2
            do n = 1, size(mesh%group)
               if (mesh%group(n)%dimension /= dimension) cycle
               call number(n)
               do k = 1, merge(3, 6, dimension == 0)
                  call coordinate(0.0_wp)
               end do
               call long(1)
               ! The direction of a curve in its group is the sign of the group's number
               call number(merge(-1, 1, dimension == 1)*mesh%group(n)%tag)
               if (dimension > 0) then
                  call long(2)
                  call number(1)
                  call number(-2)
               end if
               if (.not. binary) call line('')
            end do
         end do
         if (binary) call line('')
         call line('$EndEntities')

         call line('$Nodes')
         n = size(mesh%x, 2)
         call long(2)
         call long(n + 1)
         call long(10)
         call long(10*n + 5)
         call block(1, 1, 1, 1)
         call long(10*n + 5)
         call place([7.0_wp, 7.0_wp])
         call coordinate(0.25_wp)
         call block(2, 1, 0, n)
         do k = 1, n
            call long(10*k)
         end do
         do k = 1, n
            call place(mesh%x(:, k))
         end do
         if (binary) call line('')
         call line('$EndNodes')

         call line('$Elements')
         n = size(mesh%point) + size(mesh%line, 2) + size(mesh%triangle, 2)
         call long(n)
         call long(n)
         call long(1)
         call long(n)
         do k = 1, size(mesh%point)
            call block(0, mesh%point_group(k), 15, 1)
            call element_4([mesh%point(k)])
         end do
         do k = 1, size(mesh%line, 2)
            call block(1, mesh%line_group(k), 1, 1)
            call element_4(mesh%line(:, k))
         end do
         do k = 1, size(mesh%triangle, 2)
            call block(2, mesh%triangle_group(k), 2, 1)
            call element_4(mesh%triangle(:, k))
         end do
         if (binary) call line('')
         call line('$EndElements')
      end subroutine write_4

      subroutine block(dimension, entity, kind_of_block, members)
         integer, intent(in) :: dimension, entity, kind_of_block, members

         call number(dimension)
         call number(entity)
         call number(kind_of_block)
         call long(members)
      end subroutine block

      subroutine element_4(node)
         integer, intent(in) :: node(:)
         integer :: k

         call long(1)
         do k = 1, size(node)
            call long(10*node(k))
         end do
         if (.not. binary) call line('')
      end subroutine element_4

      subroutine place(x)
         real(wp), intent(in) :: x(2)

         call coordinate(x(1))
         call coordinate(x(2))
         call coordinate(0.0_wp)
         if (.not. binary) call line('')
      end subroutine place

      subroutine coordinate(value)
         real(wp), intent(in) :: value
         character(len=32) :: text

         if (binary) then
            write (unit) value
         else
            write (text, '(es24.16e3)') value
            write (unit) trim(adjustl(text))//' '
         end if
      end subroutine coordinate

      subroutine number(value)
         integer, intent(in) :: value

         if (binary) then
            write (unit) int(value, i4)
         else
            write (unit) decimal(value)//' '
         end if
      end subroutine number

      subroutine long(value)
         integer, intent(in) :: value

         if (binary) then
            write (unit) int(value, i8)
         else
            write (unit) decimal(value)//' '
         end if
      end subroutine long

      subroutine line(text)
         character(len=*), intent(in) :: text

         write (unit) text//new_line('a')
      end subroutine line

   end subroutine write_gmsh

   !> Integer to text.
   pure function decimal(value)
      integer, intent(in) :: value
      character(len=:), allocatable :: decimal
      character(len=12) :: buffer

      write (buffer, '(i0)') value
      decimal = trim(buffer)
   end function decimal

end module mesh_fixture
