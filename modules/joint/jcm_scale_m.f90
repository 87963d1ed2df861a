!> The JCM at the scale of a block edge (eqs 8 to 10), and its roughness at a normal stress (eqs 12, 14 and 15).
module jcm_scale_m
   use kinds_m, only: wp
   use constants_m, only: radians, is_set, unset
   use units_m, only: millimetres_per_metre
   use jcm_closure_m, only: closure_curves_t, cycles, last_cycle, initial_stiffness, maximum_closure
   implicit none
   private

   public :: jcm_option, jcm_scale, scaled_roughness, scaled_strength, initial_aperture, roughness_logarithm, &
             roughness_at, peak_displacement_eq14, peak_displacement, logarithm_slope, relative_peak_sensitivity, &
             secant_squared, between, onset, peak_ratio, post_peak_exponent, largest_stress, largest_slip, &
             largest_ratio, steepest

   !> Names of the deck's choices (values are distinct so that one name function serves all)
   integer, parameter, public :: unknown_option = 0
   integer, parameter, public :: peak_eq14 = 1, peak_eq15 = 2
   integer, parameter, public :: post_peak_table = 3, post_peak_eq16 = 4
   integer, parameter, public :: short_edges_extrapolate = 5, short_edges_l0 = 6
   integer, parameter, public :: reversal_symmetric = 7, reversal_barton = 8

   !> In place of a loading cycle: from one to the next
   integer, parameter, public :: closure_hysteresis = 0

   !> Floors of vm (as a share of a0), kn0 [MPa/mm] and a0 [mm]: what the fits of eqs 6 and 7 give below them is noise
   real(wp), parameter, public :: least_closure_share = 0.05_wp, least_stiffness = 0.1_wp, least_aperture = 0.01_wp

   !> The joint as measured in the laboratory
   type, public :: jcm_parameters_t
      !> Roughness coefficient at length l0 [-]
      real(wp) :: jrc0 = 0.0_wp
      !> Wall compressive strength at length l0; uniaxial strength of the rock (unset: jcs0) [MPa]
      real(wp) :: jcs0 = 0.0_wp, sigma_c = unset
      !> Length of the laboratory sample [m]
      real(wp) :: l0 = 0.1_wp
      !> Residual friction angle [deg]
      real(wp) :: phi_r = 30.0_wp
      !> Initial aperture (unset: eq 10) [mm]
      real(wp) :: a0 = unset
      !> Formula of the peak displacement; of the mobilisation after the peak; of edges shorter than l0
      integer :: peak = peak_eq15, post_peak = post_peak_table, short_edges = short_edges_extrapolate
      !> Loading cycle of the closure, or closure_hysteresis; strength of a joint that slides back
      integer :: closure_cycle = last_cycle, reversal = reversal_symmetric
      !> Largest total friction angle, the usual limit of validity of eq 12 [deg]
      real(wp) :: max_angle = 70.0_wp
   end type jcm_parameters_t

   !> The joint at the scale of its block edge: everything that depends on the effective length alone
   type, public :: jcm_edge_t
      !> Effective length the scaling used [m]
      real(wp) :: ln = 0.0_wp
      !> Scaled roughness [-] and wall strength [MPa], eqs 8 and 9
      real(wp) :: jrcn = 0.0_wp, jcsn = 1.0_wp
      !> Initial normal stiffness [MPa/mm], maximum closure [mm], initial aperture [mm]
      real(wp) :: kn0 = 1.0_wp, vm = 1.0_wp, a0 = 0.0_wp
      !> Residual friction angle [deg]; d tan(mobilised angle)/d(u/up) where the onset reaches it [-]
      real(wp) :: phi_r = 0.0_wp, onset_slope = 0.0_wp
      !> Peak displacement: formula, and its factor that does not depend on the stress [mm]
      integer :: peak = peak_eq15
      real(wp) :: peak_scale = 1.0_wp
      integer :: post_peak = post_peak_table
      !> Does closure go through the cycles, with these curves? Is a joint weaker when it slides back?
      logical :: hysteretic = .false., weaker_back = .false.
      type(closure_curves_t) :: curves
      !> Largest log10(JCSn/sn), where the total angle reaches its cap, and the normal stress there [-, MPa]
      real(wp) :: largest_logarithm = 0.0_wp, least_stress = 1.0_wp
      !> Guards that acted: vm or kn0 came out too small, a0 too small, ln is below l0 and the scaling extrapolates
      logical :: vm_clamped = .false., kn0_clamped = .false., a0_clamped = .false., extrapolated = .false.
   end type jcm_edge_t

   !> What the roughness does at a given normal stress
   type, public :: roughness_t
      !> log10(JCSn/sn) within its bounds [-]; JRCn times it [deg]
      real(wp) :: logarithm, angle
      !> Peak displacement [mm]
      real(wp) :: peak
   end type roughness_t

   !> u/up at which roughness begins to act, and at the peak
   real(wp), parameter :: onset = 0.3_wp, peak_ratio = 1.0_wp

   !> Exponents of eqs 16 and 15
   real(wp), parameter :: post_peak_exponent = 0.381_wp, stress_exponent = 0.34_wp
   real(wp), parameter :: ln10 = log(10.0_wp)

   !> The roughness terms see JCSn/sn no larger than 10 to this power
   real(wp), parameter :: widest_logarithm = 6.0_wp

   !> Floor of JRCn in eq 14, which would give a smooth joint no peak displacement
   real(wp), parameter :: least_roughness = 0.01_wp

   !> Bounds that keep any finite input finite: lengths [m], roughness, strengths and stresses [MPa], slips [mm], u/up
   real(wp), parameter :: shortest = 1.0e-6_wp, longest = 1.0e6_wp, roughest = 100.0_wp, weakest = 1.0e-6_wp
   real(wp), parameter :: largest_stress = 1.0e9_wp, largest_slip = 1.0e9_wp, largest_ratio = 1.0e9_wp

   !> Floor of d tan(mobilised angle)/d(u/up) in the elastic stiffness, for a joint without friction
   real(wp), parameter :: least_slope = 1.0e-6_wp

   !> Lengths that differ by no more than this share are the same
   real(wp), parameter :: same_length = 1.0e-6_wp

   !> Largest angle a tangent is taken of [deg]
   real(wp), parameter :: steepest = 89.0_wp

contains

   !> The choice a deck word names, unknown_option when it names none.
   pure integer function jcm_option(word)
      !> Word from the deck, lower case
      character(len=*), intent(in) :: word

      select case (word)
      case ('eq14')
         jcm_option = peak_eq14
      case ('eq15')
         jcm_option = peak_eq15
      case ('table')
         jcm_option = post_peak_table
      case ('eq16')
         jcm_option = post_peak_eq16
      case ('extrapolate')
         jcm_option = short_edges_extrapolate
      case ('l0')
         jcm_option = short_edges_l0
      case ('symmetric')
         jcm_option = reversal_symmetric
      case ('barton')
         jcm_option = reversal_barton
      case default
         jcm_option = unknown_option
      end select
   end function jcm_option

   !> Scale the laboratory parameters to a block edge.
   pure function jcm_scale(parameters, ln) result(edge)
      !> The joint as measured
      type(jcm_parameters_t), intent(in) :: parameters
      !> Length of the block edge [m]
      real(wp), intent(in) :: ln
      type(jcm_edge_t) :: edge
      real(wp) :: jrc0, jcs0, l0, sigma_c, a0, vm, kn0, roughness_cap
      integer :: cycle_number

      jrc0 = between(0.0_wp, parameters%jrc0, roughest)
      jcs0 = between(weakest, parameters%jcs0, largest_stress)
      l0 = between(shortest, parameters%l0, longest)
      edge%ln = between(shortest, ln, longest)
      edge%extrapolated = edge%ln < l0*(1.0_wp - same_length) .and. parameters%short_edges /= short_edges_l0
      if (parameters%short_edges == short_edges_l0) edge%ln = max(edge%ln, l0)
      edge%jrcn = scaled_roughness(jrc0, edge%ln, l0)
      edge%jcsn = scaled_strength(jcs0, jrc0, edge%ln, l0)

      a0 = parameters%a0
      if (.not. is_set(a0)) then
         sigma_c = jcs0
         if (is_set(parameters%sigma_c)) sigma_c = between(0.0_wp, parameters%sigma_c, largest_stress)
         a0 = initial_aperture(jrc0, sigma_c, jcs0)
      end if
      edge%a0 = between(least_aperture, a0, largest_slip)
      edge%a0_clamped = a0 < least_aperture
      kn0 = initial_stiffness(edge%jrcn, edge%jcsn, edge%a0)
      edge%kn0 = max(kn0, least_stiffness)
      edge%kn0_clamped = kn0 < least_stiffness
      edge%hysteretic = parameters%closure_cycle == closure_hysteresis
      edge%curves%kn0 = edge%kn0
      do cycle_number = 1, cycles
         vm = maximum_closure(edge%jrcn, edge%jcsn, edge%a0, cycle_number)
         edge%curves%vm(cycle_number) = max(vm, least_closure_share*edge%a0)
         if (edge%hysteretic .or. parameters%closure_cycle == cycle_number) &
            edge%vm_clamped = edge%vm_clamped .or. vm < least_closure_share*edge%a0
      end do
      edge%vm = edge%curves%vm(merge(1, parameters%closure_cycle, edge%hysteretic))
      edge%weaker_back = parameters%reversal == reversal_barton

      edge%phi_r = between(0.0_wp, parameters%phi_r, steepest)
      edge%onset_slope = max(radians*edge%phi_r/onset*secant_squared(edge%phi_r), least_slope)
      roughness_cap = max(0.0_wp, min(parameters%max_angle, steepest) - edge%phi_r)
      edge%largest_logarithm = widest_logarithm
      if (edge%jrcn*widest_logarithm > roughness_cap) edge%largest_logarithm = roughness_cap/edge%jrcn
      edge%least_stress = edge%jcsn*10.0_wp**(-edge%largest_logarithm)

      edge%peak = parameters%peak
      edge%post_peak = parameters%post_peak
      if (edge%peak == peak_eq14) then
         edge%peak_scale = millimetres_per_metre*peak_displacement_eq14(edge%ln, edge%jrcn)
      else
         edge%peak_scale = millimetres_per_metre*peak_length(edge%ln)
      end if
   end function jcm_scale

   ! ---- Scaling: eqs 8 to 10 ---------------------------------------------------------------------------

   !> Eq 8: JRC at the scale of the block edge.
   pure real(wp) function scaled_roughness(jrc0, ln, l0)
      !> Laboratory JRC; edge and laboratory length [m]
      real(wp), intent(in) :: jrc0, ln, l0

      scaled_roughness = jrc0*(ln/l0)**(-0.02_wp*jrc0)                                              ! (8)
   end function scaled_roughness

   !> Eq 9: JCS at the scale of the block edge [MPa].
   pure real(wp) function scaled_strength(jcs0, jrc0, ln, l0)
      !> Laboratory JCS [MPa], JRC; edge and laboratory length [m]
      real(wp), intent(in) :: jcs0, jrc0, ln, l0

      scaled_strength = jcs0*(ln/l0)**(-0.03_wp*jrc0)                                               ! (9)
   end function scaled_strength

   !> Eq 10: initial aperture of the laboratory sample [mm].
   pure real(wp) function initial_aperture(jrc0, sigma_c, jcs0)
      !> Laboratory JRC; uniaxial strength of the rock, wall strength [MPa]
      real(wp), intent(in) :: jrc0, sigma_c, jcs0

      initial_aperture = jrc0/5.0_wp*(0.2_wp*sigma_c/jcs0 - 0.1_wp)                                 ! (10)
   end function initial_aperture

   ! ---- Roughness at a normal stress -------------------------------------------------------------------------------

   !> log10(JCSn/sn): zero above JCSn, capped where the total angle reaches its limit [-]. (log10 itself is twice as
   !> slow.)
   pure real(wp) function roughness_logarithm(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      roughness_logarithm = between(0.0_wp, log(edge%jcsn/max(sn, edge%least_stress))/ln10, edge%largest_logarithm)
   end function roughness_logarithm

   !> Logarithm, roughness angle and peak displacement at a normal stress.
   pure function roughness_at(edge, sn) result(rough)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      type(roughness_t) :: rough

      rough%logarithm = roughness_logarithm(edge, sn)
      rough%angle = edge%jrcn*rough%logarithm
      rough%peak = edge%peak_scale
      if (edge%peak == peak_eq15) rough%peak = rough%peak*peak_stress_factor(rough%logarithm, rough%angle)
   end function roughness_at

   !> Eq 14: peak displacement of a block edge [m].
   pure real(wp) function peak_displacement_eq14(ln, jrcn)
      !> Length of the edge [m], scaled JRC
      real(wp), intent(in) :: ln, jrcn

      peak_displacement_eq14 = ln/500.0_wp*(max(jrcn, least_roughness)/ln)**0.33_wp                 ! (14)
   end function peak_displacement_eq14

   !> The factor of eq 15 that depends on length [m].
   pure real(wp) function peak_length(ln)
      !> Length of the edge [m]
      real(wp), intent(in) :: ln

      peak_length = 0.0077_wp*ln**0.45_wp
   end function peak_length

   !> The factor of eq 15 that depends on stress: (sn/JCSn)^0.34 cos(JRCn log10(JCSn/sn)) [-].
   pure real(wp) function peak_stress_factor(logarithm, roughness)
      !> log10(JCSn/sn); JRCn times it [deg]
      real(wp), intent(in) :: logarithm, roughness

      peak_stress_factor = exp(-stress_exponent*ln10*logarithm)*cos(roughness*radians)
   end function peak_stress_factor

   !> Peak displacement by the formula of the edge [mm].
   pure real(wp) function peak_displacement(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      type(roughness_t) :: rough

      rough = roughness_at(edge, sn)
      peak_displacement = rough%peak
   end function peak_displacement

   !> sn d log10(JCSn/sn)/d sn: zero where the logarithm is held at a bound [-].
   pure real(wp) function logarithm_slope(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      logarithm_slope = 0.0_wp
      if (sn > edge%least_stress .and. sn < edge%jcsn) logarithm_slope = -1.0_wp/ln10
   end function logarithm_slope

   !> (sn/up) d up/d sn [-].
   pure real(wp) function relative_peak_sensitivity(edge, rough, sn)
      type(jcm_edge_t), intent(in) :: edge
      type(roughness_t), intent(in) :: rough
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      real(wp) :: per_logarithm

      relative_peak_sensitivity = 0.0_wp
      if (edge%peak /= peak_eq15) return
      per_logarithm = -stress_exponent*ln10 - radians*edge%jrcn*tan(radians*rough%angle)
      relative_peak_sensitivity = logarithm_slope(edge, sn)*per_logarithm
   end function relative_peak_sensitivity

   ! ---- Small helpers ----------------------------------------------------------------------------------------------

   !> Square of the secant of an angle.
   pure real(wp) function secant_squared(angle)
      !> Angle [deg]
      real(wp), intent(in) :: angle

      secant_squared = 1.0_wp + tan(radians*angle)**2
   end function secant_squared

   !> The value, or the bound it exceeds.
   elemental real(wp) function between(lowest, value, highest)
      real(wp), intent(in) :: lowest, value, highest

      between = max(lowest, min(value, highest))
   end function between

end module jcm_scale_m
