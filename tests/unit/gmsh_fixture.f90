!> Writer of gmsh files for the unit tests: formats 2.2 and 4.1, text and binary.
module gmsh_fixture
   use kinds_m, only: wp, i4, i8
   use mesh_m, only: mesh_t
   implicit none
   private

   public :: write_gmsh

   !> gmsh's numbers of element types
   integer, parameter :: gmsh_line = 1, gmsh_triangle = 2, gmsh_point = 15
   !> A node that nothing uses
   real(wp), parameter :: unused_node(2) = [7.0_wp, 7.0_wp]

   !> A file being written
   type :: file_t
      integer :: unit = 0
      logical :: binary = .false.
   contains
      procedure :: line
      procedure :: end_line
      procedure :: number
      procedure :: long
      procedure :: coordinate
      procedure :: place
      procedure :: block
      procedure :: element
   end type file_t

contains

   !> Write a mesh as gmsh does. Node numbers leave gaps (node i has number 10 i), and a last node is used by nothing.
   subroutine write_gmsh(mesh, path, version, binary)
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: path
      !> '2.2' or '4.1'
      character(len=*), intent(in) :: version
      logical, intent(in) :: binary
      type(file_t) :: file
      integer :: i

      file%binary = binary
      open (newunit=file%unit, file=path, access='stream', form='unformatted', action='write', status='replace')
      call file%line('$MeshFormat')
      call file%line(version//merge(' 1 8', ' 0 8', binary))
      if (binary) then
         call file%number(1)
         call file%line('')
      end if
      call file%line('$EndMeshFormat')
      call file%line('$Comments')
      call file%line('nothing of use, $Nodes and all')
      call file%line('$EndComments')
      call file%line('$PhysicalNames')
      call file%line(decimal(size(mesh%group)))
      do i = 1, size(mesh%group)
         call file%line(decimal(mesh%group(i)%dimension)//' '//decimal(mesh%group(i)%tag)//' "'// &
                        trim(mesh%group(i)%name)//'"')
      end do
      call file%line('$EndPhysicalNames')
      if (version == '2.2') then
         call write_nodes_2(file, mesh)
         call write_elements_2(file, mesh)
      else
         call write_entities(file, mesh)
         call write_nodes_4(file, mesh)
         call write_elements_4(file, mesh)
      end if
      close (file%unit)
   end subroutine write_gmsh

   !> $Nodes of format 2.2.
   subroutine write_nodes_2(file, mesh)
      type(file_t), intent(in) :: file
      type(mesh_t), intent(in) :: mesh
      integer :: i, nodes

      nodes = size(mesh%x, 2)
      call file%line('$Nodes')
      call file%line(decimal(nodes + 1))
      do i = 1, nodes
         call file%number(10*i)
         call file%place(mesh%x(:, i))
      end do
      call file%number(10*nodes + 5)
      call file%place(unused_node)
      if (file%binary) call file%line('')
      call file%line('$EndNodes')
   end subroutine write_nodes_2

   !> $Elements of format 2.2.
   subroutine write_elements_2(file, mesh)
      type(file_t), intent(in) :: file
      type(mesh_t), intent(in) :: mesh
      integer :: i

      call file%line('$Elements')
      call file%line(decimal(size(mesh%point) + size(mesh%line, 2) + size(mesh%triangle, 2)))
      do i = 1, size(mesh%point)
         call write_element_2(file, mesh, gmsh_point, mesh%point_group(i), [mesh%point(i)])
      end do
      do i = 1, size(mesh%line, 2)
         call write_element_2(file, mesh, gmsh_line, mesh%line_group(i), mesh%line(:, i))
      end do
      do i = 1, size(mesh%triangle, 2)
         call write_element_2(file, mesh, gmsh_triangle, mesh%triangle_group(i), mesh%triangle(:, i))
      end do
      if (file%binary) call file%line('')
      call file%line('$EndElements')
   end subroutine write_elements_2

   !> One element of format 2.2, a block of its own in a binary file.
   subroutine write_element_2(file, mesh, gmsh_type, group, node)
      type(file_t), intent(in) :: file
      type(mesh_t), intent(in) :: mesh
      integer, intent(in) :: gmsh_type, group, node(:)
      integer :: i, tag

      tag = 0
      if (group > 0) tag = mesh%group(group)%tag
      if (.not. file%binary) call file%number(1)
      call file%number(gmsh_type)
      if (file%binary) call file%number(1)
      call file%number(2)
      if (file%binary) call file%number(1)
      call file%number(tag)
      call file%number(group)
      do i = 1, size(node)
         call file%number(10*node(i))
      end do
      call file%end_line()
   end subroutine write_element_2

   !> $Entities of format 4.1: a geometrical entity for each group, numbered as the group is.
   subroutine write_entities(file, mesh)
      type(file_t), intent(in) :: file
      type(mesh_t), intent(in) :: mesh
      integer :: dimension, i, k

      call file%line('$Entities')
      do dimension = 0, 3
         call file%long(count(mesh%group%dimension == dimension))
      end do
      do dimension = 0, 2
         do i = 1, size(mesh%group)
            if (mesh%group(i)%dimension /= dimension) cycle
            call file%number(i)
            do k = 1, merge(3, 6, dimension == 0)
               call file%coordinate(0.0_wp)
            end do
            call file%long(1)
            ! The direction of a curve in its group is the sign of the group's number
            call file%number(merge(-1, 1, dimension == 1)*mesh%group(i)%tag)
            if (dimension > 0) then
               call file%long(2)
               call file%number(1)
               call file%number(-2)
            end if
            call file%end_line()
         end do
      end do
      if (file%binary) call file%line('')
      call file%line('$EndEntities')
   end subroutine write_entities

   !> $Nodes of format 4.1: the unused node on a curve, with its parameter there, then all others.
   subroutine write_nodes_4(file, mesh)
      type(file_t), intent(in) :: file
      type(mesh_t), intent(in) :: mesh
      integer :: i, nodes

      nodes = size(mesh%x, 2)
      call file%line('$Nodes')
      call file%long(2)
      call file%long(nodes + 1)
      call file%long(10)
      call file%long(10*nodes + 5)
      call file%block(1, 1, 1, 1)
      call file%long(10*nodes + 5)
      call file%place(unused_node)
      call file%coordinate(0.25_wp)
      call file%block(2, 1, 0, nodes)
      do i = 1, nodes
         call file%long(10*i)
      end do
      do i = 1, nodes
         call file%place(mesh%x(:, i))
      end do
      if (file%binary) call file%line('')
      call file%line('$EndNodes')
   end subroutine write_nodes_4

   !> $Elements of format 4.1, each in a block of its own.
   subroutine write_elements_4(file, mesh)
      type(file_t), intent(in) :: file
      type(mesh_t), intent(in) :: mesh
      integer :: i, elements

      elements = size(mesh%point) + size(mesh%line, 2) + size(mesh%triangle, 2)
      call file%line('$Elements')
      call file%long(elements)
      call file%long(elements)
      call file%long(1)
      call file%long(elements)
      do i = 1, size(mesh%point)
         call file%block(0, mesh%point_group(i), gmsh_point, 1)
         call file%element([mesh%point(i)])
      end do
      do i = 1, size(mesh%line, 2)
         call file%block(1, mesh%line_group(i), gmsh_line, 1)
         call file%element(mesh%line(:, i))
      end do
      do i = 1, size(mesh%triangle, 2)
         call file%block(2, mesh%triangle_group(i), gmsh_triangle, 1)
         call file%element(mesh%triangle(:, i))
      end do
      if (file%binary) call file%line('')
      call file%line('$EndElements')
   end subroutine write_elements_4

   !> Head of a block of format 4.1.
   subroutine block(self, dimension, entity, kind_of_block, members)
      class(file_t), intent(in) :: self
      integer, intent(in) :: dimension, entity, kind_of_block, members

      call self%number(dimension)
      call self%number(entity)
      call self%number(kind_of_block)
      call self%long(members)
   end subroutine block

   !> One element of format 4.1.
   subroutine element(self, node)
      class(file_t), intent(in) :: self
      integer, intent(in) :: node(:)
      integer :: i

      call self%long(1)
      do i = 1, size(node)
         call self%long(10*node(i))
      end do
      call self%end_line()
   end subroutine element

   subroutine place(self, x)
      class(file_t), intent(in) :: self
      real(wp), intent(in) :: x(2)

      call self%coordinate(x(1))
      call self%coordinate(x(2))
      call self%coordinate(0.0_wp)
      call self%end_line()
   end subroutine place

   subroutine coordinate(self, value)
      class(file_t), intent(in) :: self
      real(wp), intent(in) :: value
      character(len=32) :: text

      if (self%binary) then
         write (self%unit) value
      else
         write (text, '(es24.16e3)') value
         write (self%unit) trim(adjustl(text))//' '
      end if
   end subroutine coordinate

   subroutine number(self, value)
      class(file_t), intent(in) :: self
      integer, intent(in) :: value

      if (self%binary) then
         write (self%unit) int(value, i4)
      else
         write (self%unit) decimal(value)//' '
      end if
   end subroutine number

   subroutine long(self, value)
      class(file_t), intent(in) :: self
      integer, intent(in) :: value

      if (self%binary) then
         write (self%unit) int(value, i8)
      else
         write (self%unit) decimal(value)//' '
      end if
   end subroutine long

   !> A line of text, in a binary file too.
   subroutine line(self, text)
      class(file_t), intent(in) :: self
      character(len=*), intent(in) :: text

      write (self%unit) text//new_line('a')
   end subroutine line

   !> End of a line of numbers; a binary file has none.
   subroutine end_line(self)
      class(file_t), intent(in) :: self

      if (.not. self%binary) call self%line('')
   end subroutine end_line

   !> Integer to text.
   pure function decimal(value)
      integer, intent(in) :: value
      character(len=:), allocatable :: decimal
      character(len=12) :: buffer

      write (buffer, '(i0)') value
      decimal = trim(buffer)
   end function decimal

end module gmsh_fixture
