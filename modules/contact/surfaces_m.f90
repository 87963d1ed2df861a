!> What the surfaces of a split mesh can do: whether any two of them can meet, and which marked fracture groups a
!> triangle touches.
module surfaces_m
   use kinds_m, only: wp
   use rows_m, only: fill_rows
   use mesh_m, only: split_mesh_t
   use union_find_m, only: each_alone, join
   implicit none
   private

   public :: surfaces_can_meet, groups_at_triangles

   !> Outline corners that turn back by less than this (sine of the angle) count as straight
   real(wp), parameter :: straight = 1.0e-6_wp

   !> Lists of group numbers, one a triangle
   type, public :: groups_t
      private
      !> Where each triangle's list begins (triangles + 1), and the lists
      integer, allocatable :: first(:), group(:)
   contains
      procedure :: share
   end type groups_t

contains

   !> Can two surfaces meet that this contact is responsible for? Not in one body without a free fracture wall whose
   !> outline is convex: it would have to be folded first.
   function surfaces_can_meet(split, handled, same) result(possible)
      type(split_mesh_t), intent(in) :: split
      !> Group of each surface edge that another law handles, 0 for the others (surface edges)
      integer, intent(in) :: handled(:)
      !> Number that is the same for nodes held together (nodes)
      integer, intent(in) :: same(:)
      logical :: possible

      possible = any(split%surface_joint > 0 .and. handled == 0)
      if (.not. possible) possible = bodies(split, same) > 1
      if (.not. possible) possible = .not. convex_outline(split)
   end function surfaces_can_meet

   !> Number of bodies: sets of triangles joined by common nodes or nodes held together.
   integer function bodies(split, same)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: same(:)
      integer, allocatable :: parent(:)
      logical, allocatable :: in_a_body(:)
      integer :: i, k

      allocate (parent(size(split%x, 2)), in_a_body(size(split%x, 2)))
      parent = each_alone(size(parent))
      in_a_body = .false.
      do i = 1, size(split%triangle, 2)
         in_a_body(same(split%triangle(:, i))) = .true.
         do k = 2, 3
            call join(parent, same(split%triangle(1, i)), same(split%triangle(k, i)))
         end do
      end do
      bodies = 0
      do i = 1, size(parent)
         if (in_a_body(i) .and. parent(i) == i) bodies = bodies + 1
      end do

   end function bodies

   !> Does the outer boundary turn left, or go straight on, at every node? A hole runs clockwise and turns right. Where
   !> a fracture reaches the boundary the outline goes on at the node's copy.
   logical function convex_outline(split) result(convex)
      type(split_mesh_t), intent(in) :: split
      integer, allocatable :: leaving(:)
      real(wp) :: here(2), ahead(2)
      integer :: i, next

      allocate (leaving(maxval(split%origin)))
      leaving = 0
      convex = .false.
      do i = 1, size(split%surface, 2)
         if (split%surface_joint(i) > 0) cycle
         associate (corner => split%origin(split%surface(1, i)))
            ! Two outlines through one point
            if (leaving(corner) /= 0) return
            leaving(corner) = i
         end associate
      end do
      do i = 1, size(split%surface, 2)
         if (split%surface_joint(i) > 0) cycle
         next = leaving(split%origin(split%surface(2, i)))
         if (next == 0) return
         here = split%x(:, split%surface(2, i)) - split%x(:, split%surface(1, i))
         ahead = split%x(:, split%surface(2, next)) - split%x(:, split%surface(1, next))
         if (here(1)*ahead(2) - here(2)*ahead(1) < -straight*norm2(here)*norm2(ahead)) return
      end do
      convex = .true.
   end function convex_outline

   !> Groups of the marked surface edges that each of some triangles touches, with an edge or only with a corner, its own
   !> or one that is held together with it.
   function groups_at_triangles(split, handled, same, triangle) result(groups)
      type(split_mesh_t), intent(in) :: split
      !> Group of each surface edge that another law handles, 0 for the others (surface edges)
      integer, intent(in) :: handled(:)
      !> Number that is the same for nodes held together (nodes)
      integer, intent(in) :: same(:)
      !> Triangles asked for
      integer, intent(in) :: triangle(:)
      type(groups_t) :: groups
      integer, allocatable :: first(:), edge(:), found(:), longer(:)
      integer :: i, k, j, n, number

      call marked_edges_at(split, handled, same, first, edge)
      allocate (groups%first(size(triangle) + 1), found(16))
      n = 0
      do i = 1, size(triangle)
         groups%first(i) = n + 1
         do k = 1, 3
            associate (place => same(split%triangle(k, triangle(i))))
               do j = first(place), first(place + 1) - 1
                  number = handled(edge(j))
                  if (any(found(groups%first(i):n) == number)) cycle
                  if (n == size(found)) then
                     allocate (longer(2*n))
                     longer(:n) = found
                     call move_alloc(longer, found)
                  end if
                  n = n + 1
                  found(n) = number
               end do
            end associate
         end do
      end do
      groups%first(size(triangle) + 1) = n + 1
      groups%group = found(:n)
   end function groups_at_triangles

   !> Marked surface edges that start or end at each place (compressed rows).
   pure subroutine marked_edges_at(split, handled, same, first, edge)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: handled(:), same(:)
      !> Edges at place i: edge(first(i):first(i + 1) - 1)
      integer, allocatable, intent(out) :: first(:), edge(:)
      integer :: place(2, size(handled)), i

      place = 0
      do i = 1, size(handled)
         if (handled(i) /= 0) place(:, i) = same(split%surface(:, i))
      end do
      call fill_rows(reshape(place, [size(place)]), size(same), first, edge)
      ! Two ends an edge
      edge = (edge + 1)/2
   end subroutine marked_edges_at

   !> Do two triangles touch the same group?
   pure logical function share(self, a, b)
      class(groups_t), intent(in) :: self
      !> Places of the triangles in the list asked for
      integer, intent(in) :: a, b
      integer :: i

      share = .false.
      do i = self%first(a), self%first(a + 1) - 1
         share = share .or. any(self%group(self%first(b):self%first(b + 1) - 1) == self%group(i))
      end do
   end function share

end module surfaces_m
