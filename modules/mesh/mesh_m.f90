!> The mesh: triangles, boundary lines and fracture lines with their named groups; and the same mesh after splitting,
!> where fractures are facing walls joined by four-noded joint elements.
module mesh_m
   use kinds_m, only: wp
   use text_m, only: to_text
   implicit none
   private

   !> Longest name of a physical group
   integer, parameter, public :: name_length = 64

   !> Dimensions of groups
   integer, parameter, public :: a_point = 0, a_curve = 1, a_surface = 2
   !> Groups of different dimension may share a name. Which is meant: where something is held or loaded the curve, where
   !> bodies move the surface
   integer, parameter, public :: curve_first(3) = [a_curve, a_point, a_surface], surface_first(3) = [a_surface, a_curve, a_point]

   !> A physical group of the mesh file
   type, public :: group_t
      character(len=name_length) :: name = ''
      !> 0 points, 1 lines, 2 triangles
      integer :: dimension = 0
      !> Number of the group in the mesh file
      integer :: tag = 0
   end type group_t

   !> The mesh as read: a conforming triangulation in which fractures are still lines of shared nodes
   type, public :: mesh_t
      !> Coordinates (2, nodes) [m], less the datum
      real(wp), allocatable :: x(:, :)
      !> What was taken off the coordinates of a mesh that lies far from the origin, as maps do: so no digits are lost. It comes
      !> back in all that is written [m]
      real(wp) :: datum(2) = 0.0_wp
      !> Triangles (3, triangles), anticlockwise; lines (2, lines); single nodes of point groups (points)
      integer, allocatable :: triangle(:, :), line(:, :), point(:)
      !> Index into group of each triangle, line, point (0: none)
      integer, allocatable :: triangle_group(:), line_group(:), point_group(:)
      type(group_t), allocatable :: group(:)
      !> First triangle of each patch of neighbours (patches); not allocated in a mesh that has not been ordered
      integer, allocatable :: patch(:)
   end type mesh_t

   !> The mesh the solver works on. Fixed after splitting.
   !>
   !>          A'-------->B'      joint(3:4)  upper wall, its triangle on the left  of A'->B'
   !>    j ^   :          :
   !>      |   A--------->B       joint(1:2)  lower wall, its triangle on the right of A->B
   !>      +--> i
   type, public :: split_mesh_t
      !> Coordinates (2, nodes) [m] before any motion, less the datum; and that (see mesh_t)
      real(wp), allocatable :: x(:, :)
      real(wp) :: datum(2) = 0.0_wp
      !> Node of the mesh file that each node is a copy of (nodes)
      integer, allocatable :: origin(:)
      !> Triangles (3, triangles), anticlockwise, and their group
      integer, allocatable :: triangle(:, :), triangle_group(:)
      !> Is it there? Rock that is taken out stays in the list, on nodes of its own (triangles)
      logical, allocatable :: present(:)
      !> Joint elements on fractures (4, joints): A, B, A', B'; A = A' at a tip
      integer, allocatable :: joint(:, :), joint_group(:)
      !> Triangle on the lower and on the upper wall (2, joints)
      integer, allocatable :: joint_triangle(:, :)
      !> Every free edge: outer boundary and fracture walls (2, surface edges), directed with the rock on its left
      integer, allocatable :: surface(:, :)
      !> Triangle that owns the edge; joint it is a wall of (0: none); +1 upper wall, -1 lower wall, 0 none
      integer, allocatable :: surface_triangle(:), surface_joint(:), surface_side(:)
      !> Group of the outer-boundary edges from the mesh's lines (0: none) (surface edges)
      integer, allocatable :: surface_group(:)
      !> Nodes of point groups, all copies (points)
      integer, allocatable :: point(:), point_group(:)
      type(group_t), allocatable :: group(:)
   end type split_mesh_t

   public :: find_group, place_text, coordinate_text

contains

   !> Index of a named group of the given dimension (0: there is none).
   pure integer function find_group(group, name, dimension) result(found)
      type(group_t), intent(in) :: group(:)
      character(len=*), intent(in) :: name
      integer, intent(in) :: dimension
      integer :: i

      found = 0
      do i = 1, size(group)
         if (group(i)%dimension == dimension .and. group(i)%name == name) found = i
      end do
   end function find_group

   !> A place for messages, as 'x = 1.5, y = 2'.
   pure function place_text(x, datum) result(text)
      !> Coordinates less the datum, and that [m]
      real(wp), intent(in) :: x(2), datum(2)
      character(len=:), allocatable :: text

      text = 'x = '//coordinate_text(x(1), datum(1))//', y = '//coordinate_text(x(2), datum(2))
   end function place_text

   !> A coordinate for messages: as many digits behind the point wherever the mesh lies.
   pure function coordinate_text(x, datum) result(text)
      !> Coordinate less the datum, and that [m]
      real(wp), intent(in) :: x, datum
      character(len=:), allocatable :: text
      character(len=32) :: buffer

      text = to_text(x)
      if (abs(datum) <= 0.0_wp) return
      write (buffer, '(f0.5)') datum + x
      text = trim(buffer)
   end function coordinate_text

end module mesh_m
