!> Compressed rows: things sorted by the row they belong to, by counting.
module rows_m
   implicit none
   private

   public :: fill_rows

contains

   !> Sort items by their row; those of one row keep their order.
   pure subroutine fill_rows(row, rows, first, item)
      !> Row of each item, 1 to rows; 0: it belongs to none (items)
      integer, intent(in) :: row(:)
      !> Number of rows
      integer, intent(in) :: rows
      !> Items of row i are item(first(i):first(i + 1) - 1) (rows + 1)
      integer, allocatable, intent(out) :: first(:), item(:)
      integer, allocatable :: next(:)
      integer :: i

      allocate (first(rows + 1), source=0)
      do i = 1, size(row)
         if (row(i) > 0) first(row(i) + 1) = first(row(i) + 1) + 1
      end do
      first(1) = 1
      do i = 1, rows
         first(i + 1) = first(i + 1) + first(i)
      end do
      allocate (next, source=first)
      allocate (item(first(rows + 1) - 1))
      do i = 1, size(row)
         if (row(i) == 0) cycle
         item(next(row(i))) = i
         next(row(i)) = next(row(i)) + 1
      end do
   end subroutine fill_rows

end module rows_m
