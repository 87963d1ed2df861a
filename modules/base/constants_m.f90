!> Mathematical constants, and the value of what has not been given.
module constants_m
   use kinds_m, only: wp
   implicit none
   private

   public :: is_set

   real(wp), parameter, public :: pi = acos(-1.0_wp)
   !> Radians in a degree
   real(wp), parameter, public :: radians = pi/180.0_wp
   !> Value of a deck variable the user has not given (a number no deck means)
   real(wp), parameter, public :: unset = -huge(1.0_wp)
   !> Less than any length [m]: what has shrunk to a point, as a diverging solver tries, has no direction, but a number for it
   real(wp), parameter, public :: no_length = 1.0e-30_wp

contains

   !> Has the user given this deck variable?
   elemental logical function is_set(value)
      !> Deck variable
      real(wp), intent(in) :: value

      is_set = value > unset
   end function is_set

end module constants_m
