!> Between SI units, in which everything is, and the MPa and mm of joint laws, decks and tables. Only the modules that
!> tests/style.py lists use these factors: joint_border_m between rock and joint laws, the laws for what the deck gives them, and
!> those that read or write a number whose name says mm or MPa.
module units_m
   use kinds_m, only: wp
   implicit none
   private

   !> Pascals in a megapascal, metres in a millimetre, Pa/m in a MPa/mm
   real(wp), parameter, public :: megapascal = 1.0e6_wp, millimetre = 1.0e-3_wp, megapascal_per_millimetre = 1.0e9_wp
   !> The inverse of millimetre, which is not exact; metres in a micrometre
   real(wp), parameter, public :: millimetres_per_metre = 1000.0_wp, micrometre = 1.0e-6_wp

end module units_m
