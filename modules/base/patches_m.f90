!> Patches of elements that threads work on. Patches of one colour share no node, so they are worked on at the same time; colours
!> follow each other. Each node then gets its parts in an order that does not depend on the number of threads: the same sums to
!> the last bit. One thread goes through the patches in the same order.
module patches_m
   use rows_m, only: fill_rows
   implicit none
   private

   public :: colour_patches

   !> Patches in the order in which they have their turn: colour after colour
   type, public :: patches_t
      !> First and last element of the patch of each turn (turns)
      integer, allocatable :: first(:), last(:)
      !> First turn of each colour, and one beyond the last (colours + 1)
      integer, allocatable :: colour(:)
      !> Turn in which each element is worked on (elements)
      integer, allocatable :: turn(:)
   end type patches_t

contains

   !> Colour patches of elements that follow each other.
   pure subroutine colour_patches(node, nodes, first, patches)
      !> Nodes of the elements (any, elements), number of nodes
      integer, intent(in) :: node(:, :), nodes
      !> First element of each patch, in order (patches)
      integer, intent(in) :: first(:)
      type(patches_t), intent(out) :: patches
      integer, allocatable :: start(:), corner(:), patch(:), colour(:), turn_of(:), order(:), members(:)
      logical, allocatable :: taken(:)
      integer :: p, e, i, k, c, colours

      allocate (patch(size(node, 2)), colour(size(first)), members(size(first)), taken(size(first)))
      do p = 1, size(first)
         patch(first(p):last_of(p)) = p
      end do
      call fill_rows(reshape(node, [size(node)]), nodes, start, corner)
      colour = 0
      members = 0
      colours = 0
      do p = 1, size(first)
         taken = .false.
         do e = first(p), last_of(p)
            do i = 1, size(node, 1)
               do k = start(node(i, e)), start(node(i, e) + 1) - 1
                  c = colour(patch((corner(k) - 1)/size(node, 1) + 1))
                  if (c > 0) taken(c) = .true.
               end do
            end do
         end do
         ! The free colour that the fewest patches have
         c = minloc(members(:colours), dim=1, mask=.not. taken(:colours))
         if (c == 0) then
            colours = colours + 1
            c = colours
         end if
         colour(p) = c
         members(c) = members(c) + 1
      end do
      call fill_rows(colour, colours, patches%colour, order)
      allocate (patches%first(size(order)), patches%last(size(order)))
      do i = 1, size(order)
         patches%first(i) = first(order(i))
         patches%last(i) = last_of(order(i))
      end do
      allocate (turn_of(size(first)))
      turn_of(order) = [(i, i=1, size(order))]
      patches%turn = turn_of(patch)

   contains

      !> Last element of a patch.
      pure integer function last_of(p)
         integer, intent(in) :: p

         last_of = size(node, 2)
         if (p < size(first)) last_of = first(p + 1) - 1
      end function last_of

   end subroutine colour_patches

end module patches_m
