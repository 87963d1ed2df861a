!> Sets of numbers that grow together, by union and find: what belongs together by links between two members each.
!>
!> The sets are an array that gives each member another of its set, in the end the lowest, which stands for the set.
module union_find_m
   implicit none
   private

   public :: each_alone, join, representative, representatives

contains

   !> Sets of one member each, 1 to n.
   pure function each_alone(n) result(parent)
      integer, intent(in) :: n
      integer :: parent(n)
      integer :: i

      parent = [(i, i=1, n)]
   end function each_alone

   !> Put the sets of two members together.
   pure subroutine join(parent, a, b)
      integer, intent(inout) :: parent(:)
      integer, intent(in) :: a, b
      integer :: lowest_a, lowest_b

      lowest_a = representative(parent, a)
      lowest_b = representative(parent, b)
      parent(max(lowest_a, lowest_b)) = min(lowest_a, lowest_b)
      call shorten(parent, a)
      call shorten(parent, b)
   end subroutine join

   !> Lead all on the way from a member to its representative there at once: later ways are short.
   pure subroutine shorten(parent, member)
      integer, intent(inout) :: parent(:)
      integer, intent(in) :: member
      integer :: at, next, lowest

      lowest = representative(parent, member)
      at = member
      do while (parent(at) /= lowest)
         next = parent(at)
         parent(at) = lowest
         at = next
      end do
   end subroutine shorten

   !> The lowest member of a member's set.
   pure integer function representative(parent, member)
      integer, intent(in) :: parent(:), member

      representative = member
      do while (parent(representative) /= representative)
         representative = parent(representative)
      end do
   end function representative

   !> The lowest member of the set of each (members).
   pure function representatives(parent) result(lowest)
      integer, intent(in) :: parent(:)
      integer :: lowest(size(parent))
      integer :: i

      ! A parent is never higher than its child
      do i = 1, size(parent)
         lowest(i) = i
         if (parent(i) /= i) lowest(i) = lowest(parent(i))
      end do
   end function representatives

end module union_find_m
