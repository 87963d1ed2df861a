!> Pairs of triangles that can touch before the next search, and when that is due.
module near_pairs_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use nbs_m, only: find_box_pairs
   use potential_m, only: pair_penalty
   use contact_layer_m, only: contact_layer_t, box_around
   implicit none
   private

   public :: no_pairs, have_moved, find_pairs

   type, public :: near_pairs_t
      !> Displacement of the layer's nodes at the last search (2, layer nodes) [m]
      real(wp), allocatable :: searched(:, :)
      !> Objects near each other (2, pairs), their penalty [Pa] (pairs), and the objects that occur in a pair
      integer, allocatable :: pair(:, :), object(:)
      real(wp), allocatable :: penalty(:)
   end type near_pairs_t

contains

   !> Nothing is searched yet.
   pure subroutine no_pairs(layer, near)
      type(contact_layer_t), intent(in) :: layer
      type(near_pairs_t), intent(out) :: near

      allocate (near%searched(2, size(layer%nodes)), source=0.0_wp)
      allocate (near%pair(2, 0), near%object(0), near%penalty(0))
   end subroutine no_pairs

   !> Has any node of an object moved further than half the skin since the last search?
   pure logical function have_moved(layer, near, displacement)
      type(contact_layer_t), intent(in) :: layer
      type(near_pairs_t), intent(in) :: near
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      integer :: i

      have_moved = .false.
      do i = 1, size(layer%nodes)
         associate (node => layer%nodes(i))
            have_moved = (displacement(1, node) - near%searched(1, i))**2 &
                         + (displacement(2, node) - near%searched(2, i))**2 > layer%reach(i)**2
         end associate
         if (have_moved) return
      end do
   end function have_moved

   !> Find the pairs of objects that can touch before the next search.
   subroutine find_pairs(layer, split, displacement, near)
      type(contact_layer_t), intent(in) :: layer
      type(split_mesh_t), intent(in) :: split
      !> Displacement of every node (2, nodes) [m]
      real(wp), intent(in) :: displacement(:, :)
      type(near_pairs_t), intent(inout) :: near
      real(wp), allocatable :: box(:, :)
      integer, allocatable :: candidate(:, :)
      logical, allocatable :: keep(:), is_near(:)
      real(wp) :: a(2, 3), b(2, 3)
      integer :: i

      near%searched = displacement(:, layer%nodes)
      allocate (box(4, size(layer%node, 2)))
      do i = 1, size(box, 2)
         a = split%x(:, layer%node(:, i)) + displacement(:, layer%node(:, i))
         box(:, i) = box_around(a) + layer%half_skin(i)*[-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
      end do
      call find_box_pairs(box, candidate)

      allocate (keep(size(candidate, 2)), is_near(size(box, 2)))
      is_near = .false.
      do i = 1, size(candidate, 2)
         associate (first => candidate(1, i), second => candidate(2, i))
            keep(i) = .false.
            if (share_node(layer%same(:, first), layer%same(:, second))) cycle
            if (layer%handled%share(first, second)) cycle
            a = split%x(:, layer%node(:, first)) + displacement(:, layer%node(:, first))
            b = split%x(:, layer%node(:, second)) + displacement(:, layer%node(:, second))
            keep(i) = .not. apart(a, b, layer%half_skin(first) + layer%half_skin(second))
            if (keep(i)) is_near(candidate(:, i)) = .true.
         end associate
      end do
      near%object = pack([(i, i=1, size(is_near))], is_near)
      call keep_pairs(layer, candidate, keep, near)
   end subroutine find_pairs

   !> Store the pairs that passed, with their penalties.
   subroutine keep_pairs(layer, candidate, keep, near)
      type(contact_layer_t), intent(in) :: layer
      !> Pairs of objects (2, candidates) and whether they are kept (candidates)
      integer, intent(in) :: candidate(:, :)
      logical, intent(in) :: keep(:)
      type(near_pairs_t), intent(inout) :: near
      integer :: i, n

      deallocate (near%pair, near%penalty)
      allocate (near%pair(2, count(keep)), near%penalty(count(keep)))
      n = 0
      do i = 1, size(keep)
         if (.not. keep(i)) cycle
         n = n + 1
         near%pair(:, n) = candidate(:, i)
         near%penalty(n) = pair_penalty(layer%penalty(candidate(1, i)), layer%penalty(candidate(2, i)))
      end do
   end subroutine keep_pairs

   pure logical function share_node(a, b)
      integer, intent(in) :: a(3), b(3)
      integer :: i

      share_node = .false.
      do i = 1, 3
         share_node = share_node .or. any(a == b(i))
      end do
   end function share_node

   !> Does an edge of either triangle have the other one beyond it by more than a gap?
   pure logical function apart(a, b, gap)
      !> Corners, anticlockwise (2, 3) [m]
      real(wp), intent(in) :: a(2, 3), b(2, 3)
      !> Gap [m]
      real(wp), intent(in) :: gap

      apart = beyond(a, b, gap)
      if (.not. apart) apart = beyond(b, a, gap)
   end function apart

   !> Is the second triangle beyond an edge of the first by more than a gap?
   pure logical function beyond(a, b, gap)
      real(wp), intent(in) :: a(2, 3), b(2, 3), gap
      real(wp) :: along(2)
      integer :: k

      beyond = .false.
      do k = 1, 3
         along = a(:, mod(k, 3) + 1) - a(:, k)
         along = along/norm2(along)
         beyond = beyond .or. minval(along(2)*(b(1, :) - a(1, k)) - along(1)*(b(2, :) - a(2, k))) > gap
      end do
   end function beyond

end module near_pairs_m
