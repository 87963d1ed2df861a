!> Hydraulic aperture of a rough fracture: that of two smooth parallel plates that conduct as much.
!>
!> Sources: Barton, Bandis and Bakhtar 1985 (Int J Rock Mech Min Sci 22:121); Olsson and Barton 2001 (Int J Rock Mech Min Sci
!> 38:317). Both have apertures in micrometres.
module hydraulic_aperture_m
   use kinds_m, only: wp
   use units_m, only: micrometre
   implicit none
   private

   public :: hydraulic_law_named, barton_aperture, sheared_aperture, hydraulic_aperture

   !> The laws
   integer, parameter, public :: hydraulic_unknown = 0, hydraulic_equal = 1, hydraulic_barton = 2, hydraulic_olsson_barton = 3

   !> Exponent of JRC
   real(wp), parameter :: roughness_exponent = 2.5_wp
   !> Slip over peak slip up to which the first formula holds, and from which the second
   real(wp), parameter :: sheared_from = 0.75_wp, sheared_whole = 1.0_wp

contains

   !> The law a deck word names, hydraulic_unknown when it names none.
   pure integer function hydraulic_law_named(word)
      character(len=*), intent(in) :: word

      select case (word)
      case ('equal')
         hydraulic_law_named = hydraulic_equal
      case ('barton')
         hydraulic_law_named = hydraulic_barton
      case ('olsson_barton')
         hydraulic_law_named = hydraulic_olsson_barton
      case default
         hydraulic_law_named = hydraulic_unknown
      end select
   end function hydraulic_law_named

   !> e = E^2/JRC^2.5 in micrometres, never above E [m]. A smooth joint has e = E.
   elemental real(wp) function barton_aperture(mechanical, jrc) result(hydraulic)
      !> Mechanical aperture E [m], JRC of the laboratory sample [-]
      real(wp), intent(in) :: mechanical, jrc

      hydraulic = max(mechanical, 0.0_wp)
      if (jrc > 0.0_wp) hydraulic = min(hydraulic, hydraulic**2/micrometre/jrc**roughness_exponent)
   end function barton_aperture

   !> e = sqrt(E) JRCmob in micrometres, never above E [m]: what the shearing of the peak and beyond leaves.
   elemental real(wp) function sheared_aperture(mechanical, jrc_mobilised) result(hydraulic)
      !> Mechanical aperture E [m], mobilised JRC [-]
      real(wp), intent(in) :: mechanical, jrc_mobilised

      hydraulic = max(mechanical, 0.0_wp)
      hydraulic = min(hydraulic, sqrt(hydraulic*micrometre)*max(jrc_mobilised, 0.0_wp))
   end function sheared_aperture

   !> Hydraulic aperture by a law [m].
   elemental real(wp) function hydraulic_aperture(law, mechanical, jrc, mobilisation, jrc_mobilised) result(hydraulic)
      integer, intent(in) :: law
      !> Mechanical aperture [m], JRC of the laboratory sample [-]
      real(wp), intent(in) :: mechanical, jrc
      !> Slip over peak slip [-] and mobilised JRC [-], for Olsson and Barton
      real(wp), intent(in) :: mobilisation, jrc_mobilised
      real(wp) :: sheared

      select case (law)
      case (hydraulic_barton)
         hydraulic = barton_aperture(mechanical, jrc)
      case (hydraulic_olsson_barton)
         ! The first up to 0.75 of the peak slip, the second from the peak on, between them their linear mean
         sheared = min(max((mobilisation - sheared_from)/(sheared_whole - sheared_from), 0.0_wp), 1.0_wp)
         hydraulic = (1.0_wp - sheared)*barton_aperture(mechanical, jrc) + sheared*sheared_aperture(mechanical, jrc_mobilised)
      case default
         hydraulic = max(mechanical, 0.0_wp)
      end select
   end function hydraulic_aperture

end module hydraulic_aperture_m
