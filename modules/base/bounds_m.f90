!> What numbers of a deck can mean: limits far beyond any rock, model or test, within which all that is made of them (squares,
!> ratios) is a number. A value outside is a slip of the unit or of the exponent.
module bounds_m
   use kinds_m, only: wp
   implicit none
   private

   !> Density [kg/m3]: aerogel to osmium
   real(wp), parameter, public :: lightest = 1.0_wp, heaviest = 25000.0_wp
   !> Young's modulus [Pa]: less than any jelly to ten times diamond
   real(wp), parameter, public :: softest = 1.0_wp, stiffest = 1.0e13_wp
   !> Penalties over Young's modulus, and penalties [Pa]
   real(wp), parameter, public :: least_factor = 1.0e-6_wp, most_factor = 1.0e6_wp, least_penalty = 1.0_wp, &
                                  most_penalty = 1.0e17_wp
   !> Strengths, tractions, pressures [Pa], and smallest one that is not 0
   real(wp), parameter, public :: most_stress = 1.0e12_wp
   !> Fracture energy [J/m2]
   real(wp), parameter, public :: least_energy = 1.0e-6_wp, most_energy = 1.0e12_wp
   !> Stiffness of joints [MPa/mm], their aperture [mm], size of the sample [m], strength of walls [MPa]
   real(wp), parameter, public :: least_stiffness = 1.0e-6_wp, most_stiffness = 1.0e9_wp, least_aperture = 1.0e-6_wp, &
                                  most_aperture = 1.0e3_wp, least_sample = 1.0e-3_wp, most_sample = 100.0_wp, &
                                  least_wall = 1.0e-3_wp, most_wall = 1000.0_wp
   !> Smallest angle that is not 0 [degrees]
   real(wp), parameter, public :: least_angle = 1.0e-3_wp
   !> Velocity [m/s]: beyond the speed of sound in any rock
   real(wp), parameter, public :: fastest = 1.0e4_wp
   !> Durations [s]: less than any time step, more than 30 000 years; time steps [s]
   real(wp), parameter, public :: least_time = 1.0e-12_wp, most_time = 1.0e12_wp, least_step = 1.0e-15_wp
   !> Parts of a whole and factors that would never be meant; tolerances below the rounding errors
   real(wp), parameter, public :: least_part = 1.0e-4_wp, least_tolerance = 1.0e-15_wp
   !> Threads: more than any machine has cores
   real(wp), parameter, public :: most_threads = 1024.0_wp
   !> Smallest size of a velocity or load that is not 0: what is meant as 0 is to be written so
   real(wp), parameter, public :: least_size = 1.0e-20_wp

end module bounds_m
