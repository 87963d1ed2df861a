!> Plane geometry of points.
module geometry_m
   use kinds_m, only: wp
   implicit none
   private

   public :: twice_area

contains

   !> Twice the signed area of a triangle: positive when its corners run anticlockwise.
   pure real(wp) function twice_area(a, b, c)
      !> Corners [m]
      real(wp), intent(in) :: a(2), b(2), c(2)

      twice_area = (b(1) - a(1))*(c(2) - a(2)) - (c(1) - a(1))*(b(2) - a(2))
   end function twice_area

end module geometry_m
