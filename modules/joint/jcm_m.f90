!> The empirical joint constitutive model (JCM) of Barton and Bandis: closure, shear strength, mobilisation and
!> dilation of a rough joint, and the incremental law that a solver calls at every step.
!>
!> Units of this module: MPa, mm, degrees; joint lengths in m. Compression and closure are positive.
!> Equation numbers are those of Lei, Latham and Xiang (2016), Rock Mech. Rock Eng. 49:4799-4816.
!> Sources: Barton and Choubey 1977 (strength, dilation); Bandis et al. 1983 (closure); Barton et al. 1985 (scaling,
!> mobilisation); Olsson and Barton 2001 (dilation after the peak); Asadollahi and Tonon 2010 (peak displacement).
module jcm_m
   use kinds_m, only: wp
   use constants_m, only: radians, is_set, unset
   use jcm_closure_m, only: closure_curves_t, cycles, last_cycle, initial_stiffness, maximum_closure, closure_stress, closure, &
                            normal_stiffness, path_closure, path_stiffness, follow_path
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t, joint_dilation_t
   implicit none
   private

   public :: joint_point_t, joint_tangent_t
   public :: jcm_option, jcm_scale, jcm_update, jcm_tangent, jcm_dilation, jcm_retrace
   public :: scaled_roughness, scaled_strength, initial_aperture, initial_stiffness, maximum_closure
   public :: closure_stress, closure, normal_stiffness
   public :: peak_strength, shear_strength, mobilised_ratio, mobilised_ratio_slope, mobilised_angle, mobilised_friction
   public :: roughness_logarithm, peak_displacement_eq14, peak_displacement_eq15, peak_displacement
   public :: shear_stiffness, shear_stress_sensitivity, elastic_shear_stiffness, residual_shear_stiffness
   public :: damage_coefficient, peak_dilation_ratio, dilation_angle, dilation_increment, aperture

   !> Names of the deck's choices (values are distinct so that one name function serves all)
   integer, parameter, public :: unknown_option = 0
   integer, parameter, public :: peak_eq14 = 1, peak_eq15 = 2
   integer, parameter, public :: post_peak_table = 3, post_peak_eq16 = 4
   integer, parameter, public :: short_edges_extrapolate = 5, short_edges_l0 = 6
   integer, parameter, public :: reversal_symmetric = 7, reversal_barton = 8
   !> In place of a loading cycle: from one to the next
   integer, parameter, public :: closure_hysteresis = 0

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
   type :: roughness_t
      !> log10(JCSn/sn) within its bounds [-]; JRCn times it [deg]
      real(wp) :: logarithm, angle
      !> Peak displacement [mm]
      real(wp) :: peak
   end type roughness_t

   !> Table 1 from u/up = 0.3 on: JRCmob/JRCn at the nodes, read linearly between them
   integer, parameter :: table_nodes = 8
   real(wp), parameter :: table_u(table_nodes) = [0.3_wp, 0.6_wp, 1.0_wp, 2.0_wp, 4.0_wp, 10.0_wp, 25.0_wp, 100.0_wp]
   real(wp), parameter :: table_jrc(table_nodes) = [0.0_wp, 0.75_wp, 1.0_wp, 0.85_wp, 0.70_wp, 0.50_wp, 0.40_wp, 0.0_wp]
   real(wp), parameter :: table_slope(table_nodes - 1) = (table_jrc(2:) - table_jrc(:table_nodes - 1)) &
      &/(table_u(2:) - table_u(:table_nodes - 1))
   !> u/up at which roughness begins to act, and at the peak
   real(wp), parameter :: onset = 0.3_wp, peak_ratio = 1.0_wp
   !> u/up up to which eq 19 contracts
   real(wp), parameter :: contraction_end = 0.25_wp
   !> Exponents of eqs 16 and 15
   real(wp), parameter :: post_peak_exponent = 0.381_wp, stress_exponent = 0.34_wp
   real(wp), parameter :: ln10 = log(10.0_wp)
   real(wp), parameter :: millimetres_per_metre = 1000.0_wp

   !> Floors of vm (as a share of a0), kn0 [MPa/mm] and a0 [mm]: what the fits of eqs 6 and 7 give below them is noise
   real(wp), parameter, public :: least_closure_share = 0.05_wp, least_stiffness = 0.1_wp, least_aperture = 0.01_wp
   !> The roughness terms see JCSn/sn no larger than 10 to this power
   real(wp), parameter :: widest_logarithm = 6.0_wp
   !> Floor of the logarithm in eq 21, which divides by it
   real(wp), parameter :: least_logarithm = 1.0e-3_wp
   !> Floor of JRCn in eq 14, which would give a smooth joint no peak displacement
   real(wp), parameter :: least_roughness = 0.01_wp
   !> Bounds that keep any finite input finite: lengths [m], roughness, strengths and stresses [MPa], slips [mm], u/up
   real(wp), parameter :: shortest = 1.0e-6_wp, longest = 1.0e6_wp, roughest = 100.0_wp, weakest = 1.0e-6_wp
   real(wp), parameter :: largest_stress = 1.0e9_wp, largest_slip = 1.0e9_wp, largest_ratio = 1.0e9_wp
   !> Floor of d tan(mobilised angle)/d(u/up) in the elastic stiffness, for a joint without friction
   real(wp), parameter :: least_slope = 1.0e-6_wp
   !> A step that mobilises less says nothing of how the normal stress changes with slip [-]
   real(wp), parameter :: least_step = 1.0e-3_wp
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

   !> Eq 15: peak displacement of a block edge under a normal stress [m].
   pure real(wp) function peak_displacement_eq15(ln, jrcn, jcsn, sn)
      !> Length of the edge [m], scaled JRC, scaled JCS and normal stress [MPa]
      real(wp), intent(in) :: ln, jrcn, jcsn, sn
      real(wp) :: logarithm

      logarithm = between(0.0_wp, log10(jcsn/max(sn, jcsn*10.0_wp**(-widest_logarithm))), widest_logarithm)
      peak_displacement_eq15 = peak_length(ln)*peak_stress_factor(logarithm, jrcn*logarithm)        ! (15)
   end function peak_displacement_eq15

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

   ! ---- Shear strength: eqs 12, 13, 16, 17, 33 and Table 1 ---------------------------------------------------------

   !> JRCmob/JRCn at u/up = ratio: Table 1, with eq 16 after the peak where the edge asks for it [-]. Zero before the
   !> onset when roughness is too small a share of phi_r to divide by; the laws themselves work in angles and don't
   !> divide.
   pure real(wp) function mobilised_ratio(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      if (ratio < onset) then
         mobilised_ratio = -residual_share(edge, sn)*(1.0_wp - max(ratio, 0.0_wp)/onset)
      else
         mobilised_ratio = share_beyond_onset(edge%post_peak, ratio)
      end if
   end function mobilised_ratio

   !> Slope of mobilised_ratio against u/up, on the right of a node [-].
   pure real(wp) function mobilised_ratio_slope(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      if (ratio < onset) then
         mobilised_ratio_slope = residual_share(edge, sn)/onset
      else
         mobilised_ratio_slope = share_slope(edge%post_peak, ratio)
      end if
   end function mobilised_ratio_slope

   !> phi_r/[JRCn log10(JCSn/sn)], Table 1 at u = 0 [-]; zero where the divisor vanishes.
   pure real(wp) function residual_share(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      real(wp) :: roughness

      roughness = edge%jrcn*roughness_logarithm(edge, sn)
      residual_share = 0.0_wp
      if (edge%phi_r < roughness*largest_ratio) residual_share = edge%phi_r/roughness
   end function residual_share

   !> Table 1 at u/up >= 0.3, read linearly, or eq 16 after the peak [-].
   pure real(wp) function share_beyond_onset(post_peak, ratio)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up [-]
      real(wp), intent(in) :: ratio
      integer :: i

      if (post_peak == post_peak_eq16 .and. ratio > peak_ratio) then
         share_beyond_onset = ratio**(-post_peak_exponent)                                          ! (16)
         return
      end if
      share_beyond_onset = table_jrc(table_nodes)
      do i = 2, table_nodes
         if (ratio < table_u(i)) then
            share_beyond_onset = table_jrc(i - 1) + table_slope(i - 1)*(ratio - table_u(i - 1))
            exit
         end if
      end do
   end function share_beyond_onset

   !> Slope of share_beyond_onset, on the right of a node [-].
   pure real(wp) function share_slope(post_peak, ratio)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up [-]
      real(wp), intent(in) :: ratio
      integer :: i

      if (post_peak == post_peak_eq16 .and. ratio >= peak_ratio) then
         share_slope = -post_peak_exponent*ratio**(-post_peak_exponent - 1.0_wp)
         return
      end if
      share_slope = 0.0_wp
      do i = 2, table_nodes
         if (ratio < table_u(i)) then
            share_slope = table_slope(i - 1)
            exit
         end if
      end do
   end function share_slope

   !> Mobilised friction angle, the angle of eqs 13 and 33 [deg].
   pure real(wp) function mobilised_angle(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      mobilised_angle = angle_at(edge, ratio, edge%jrcn*roughness_logarithm(edge, sn))
   end function mobilised_angle

   !> Mobilised friction angle for a known roughness angle [deg]. Before the onset Table 1 amounts to phi_r*(u/up)/0.3.
   pure real(wp) function angle_at(edge, ratio, roughness)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], JRCn log10(JCSn/sn) [deg]
      real(wp), intent(in) :: ratio, roughness

      if (ratio < onset) then
         angle_at = edge%phi_r*max(ratio, 0.0_wp)/onset
      else
         angle_at = edge%phi_r + share_beyond_onset(edge%post_peak, ratio)*roughness
      end if
   end function angle_at

   !> d mobilised angle/d(u/up) [deg].
   pure real(wp) function angle_slope(edge, ratio, roughness)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], JRCn log10(JCSn/sn) [deg]
      real(wp), intent(in) :: ratio, roughness

      if (ratio < onset) then
         angle_slope = edge%phi_r/onset
      else
         angle_slope = share_slope(edge%post_peak, ratio)*roughness
      end if
   end function angle_slope

   !> Eq 12: peak shear strength [MPa].
   pure real(wp) function peak_strength(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      peak_strength = shear_strength(edge, peak_ratio, sn)                                          ! (12)
   end function peak_strength

   !> Eq 13: shear strength mobilised at u/up = ratio [MPa].
   pure real(wp) function shear_strength(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn
      real(wp) :: pressed

      pressed = between(0.0_wp, sn, largest_stress)
      shear_strength = pressed*tan(radians*mobilised_angle(edge, ratio, pressed))                   ! (13)
   end function shear_strength

   !> Eq 33: friction coefficient the joint has mobilised, for eq 4 [-].
   pure real(wp) function mobilised_friction(edge, state)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(in) :: state

      mobilised_friction = tan(radians*mobilised_angle(edge, state%ratio, state%sn))                ! (33)
   end function mobilised_friction

   !> Eq 17: d tau/du of eq 13 at constant normal stress [MPa/mm].
   pure real(wp) function shear_stiffness(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn
      type(roughness_t) :: rough
      real(wp) :: pressed, slope

      pressed = between(0.0_wp, sn, largest_stress)
      rough = roughness_at(edge, pressed)
      slope = radians*angle_slope(edge, ratio, rough%angle)*secant_squared(angle_at(edge, ratio, rough%angle))
      shear_stiffness = pressed/rough%peak*slope                                                    ! (17)
   end function shear_stiffness

   !> d tau/d sn of eq 13 at constant u/up [-].
   pure real(wp) function shear_stress_sensitivity(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn
      real(wp) :: angle, pressed, share

      pressed = between(0.0_wp, sn, largest_stress)
      angle = mobilised_angle(edge, ratio, pressed)
      share = 0.0_wp
      if (ratio >= onset) share = share_beyond_onset(edge%post_peak, ratio)
      shear_stress_sensitivity = tan(radians*angle) &
         &+ secant_squared(angle)*radians*share*edge%jrcn*logarithm_slope(edge, pressed)
   end function shear_stress_sensitivity

   !> sn d log10(JCSn/sn)/d sn: zero where the logarithm is held at a bound [-].
   pure real(wp) function logarithm_slope(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      logarithm_slope = 0.0_wp
      if (sn > edge%least_stress .and. sn < edge%jcsn) logarithm_slope = -1.0_wp/ln10
   end function logarithm_slope

   !> Stiffness in shear of a joint that does not slide: the steepest slope of eq 13 before the peak, so that loading
   !> from rest follows eq 13 and unloading is never softer than loading [MPa/mm].
   pure real(wp) function elastic_shear_stiffness(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      type(roughness_t) :: rough
      real(wp) :: pressed

      pressed = between(0.0_wp, sn, largest_stress)
      rough = roughness_at(edge, pressed)
      elastic_shear_stiffness = pressed/rough%peak*steepest_slope(edge, rough%angle)
   end function elastic_shear_stiffness

   !> Secant stiffness up to where the residual friction angle is mobilised (u/up = 0.3 of Table 1) [MPa/mm].
   pure real(wp) function residual_shear_stiffness(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      type(roughness_t) :: rough
      real(wp) :: pressed

      pressed = between(0.0_wp, sn, largest_stress)
      rough = roughness_at(edge, pressed)
      residual_shear_stiffness = pressed*tan(radians*edge%phi_r)/(onset*rough%peak)
   end function residual_shear_stiffness

   !> Largest d tan(mobilised angle)/d(u/up) before the peak [-]. The angle grows linearly between the nodes of Table
   !> 1, so that the tangent is steepest at the end of one of the three intervals.
   pure real(wp) function steepest_slope(edge, roughness)
      type(jcm_edge_t), intent(in) :: edge
      !> JRCn log10(JCSn/sn) [deg]
      real(wp), intent(in) :: roughness

      steepest_slope = max(edge%onset_slope, &
         &radians*table_slope(1)*roughness*secant_squared(edge%phi_r + table_jrc(2)*roughness), &
         &radians*table_slope(2)*roughness*secant_squared(edge%phi_r + table_jrc(3)*roughness))
   end function steepest_slope

   ! ---- Dilation: eqs 18 to 22 -------------------------------------------------------------------------------------

   !> Eq 21: damage coefficient; its divisor has a floor, so that it stays finite at sn >= JCSn [-].
   pure real(wp) function damage_coefficient(jrcn, logarithm)
      !> Scaled JRC, log10(JCSn/sn)
      real(wp), intent(in) :: jrcn, logarithm

      damage_coefficient = jrcn/(12.0_wp*max(logarithm, least_logarithm)) + 0.70_wp                 ! (21)
   end function damage_coefficient

   !> Peak dilation angle, eq 22 at u = up [deg].
   pure real(wp) function peak_dilation_angle(edge, logarithm)
      type(jcm_edge_t), intent(in) :: edge
      !> log10(JCSn/sn)
      real(wp), intent(in) :: logarithm

      peak_dilation_angle = min(edge%jrcn*logarithm/damage_coefficient(edge%jrcn, logarithm), steepest)
   end function peak_dilation_angle

   !> d peak_dilation_angle/d logarithm [deg].
   pure real(wp) function peak_dilation_angle_slope(edge, logarithm) result(slope)
      type(jcm_edge_t), intent(in) :: edge
      !> log10(JCSn/sn)
      real(wp), intent(in) :: logarithm
      real(wp) :: damage

      slope = 0.0_wp
      damage = damage_coefficient(edge%jrcn, logarithm)
      if (edge%jrcn*logarithm/damage >= steepest) return
      slope = edge%jrcn/damage
      if (logarithm > least_logarithm) slope = slope*(1.0_wp + edge%jrcn/(12.0_wp*logarithm*damage))
   end function peak_dilation_angle_slope

   !> Eq 20: dilation at the peak over peak displacement, vp/up [-].
   pure real(wp) function peak_dilation_ratio(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      peak_dilation_ratio = dilation_ratio(peak_dilation_angle(edge, roughness_logarithm(edge, sn)))
   end function peak_dilation_ratio

   !> Eq 20 for a known peak dilation angle [-].
   pure real(wp) function dilation_ratio(peak_angle)
      !> JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: peak_angle

      dilation_ratio = tan(radians*peak_angle/3.0_wp)                                               ! (20)
   end function dilation_ratio

   !> Eqs 19 and 22: mobilised dilation angle at u/up = ratio [deg].
   pure real(wp) function dilation_angle(edge, ratio, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> u/up [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      dilation_angle = atan(dilation_tangent(edge%post_peak, ratio, &
         &peak_dilation_angle(edge, roughness_logarithm(edge, sn))))/radians
   end function dilation_angle

   !> Tangent of the mobilised dilation angle for a known peak dilation angle [-].
   pure real(wp) function dilation_tangent(post_peak, ratio, peak_angle)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up [-], JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: ratio, peak_angle

      if (ratio < peak_ratio) then
         dilation_tangent = dilation_ratio(peak_angle)*(4.0_wp*ratio - 1.0_wp)                      ! (19)
      else
         dilation_tangent = tan(radians*peak_angle*share_beyond_onset(post_peak, ratio))            ! (22)
      end if
   end function dilation_tangent

   !> d dilation_tangent/d(u/up) [-].
   pure real(wp) function dilation_tangent_slope(post_peak, ratio, peak_angle) result(slope)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up [-], JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: ratio, peak_angle

      if (ratio < peak_ratio) then
         slope = 4.0_wp*dilation_ratio(peak_angle)
      else
         slope = radians*peak_angle*share_slope(post_peak, ratio)*(1.0_wp + dilation_tangent(post_peak, ratio, peak_angle)**2)
      end if
   end function dilation_tangent_slope

   !> Eq 18: closure by a slip du at a mobilised dilation angle [mm].
   pure real(wp) function dilation_increment(angle, du)
      !> Mobilised dilation angle [deg], slip [mm]
      real(wp), intent(in) :: angle, du

      dilation_increment = -tan(radians*angle)*du                                                   ! (18)
   end function dilation_increment

   !> Dilation between two values of u/up at constant stress, over up [-]: exact before the peak, the mid-point rule
   !> after.
   pure real(wp) function dilation_between(post_peak, from, to, peak_angle)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up at the start and at the end, from <= to [-]; JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: from, to, peak_angle
      real(wp) :: start, end

      dilation_between = 0.0_wp
      if (from < peak_ratio) then
         end = min(to, peak_ratio)
         dilation_between = dilation_ratio(peak_angle)*(end - from)*(2.0_wp*(from + end) - 1.0_wp)  ! (18, 19)
      end if
      if (to > peak_ratio) then
         start = max(from, peak_ratio)
         dilation_between = dilation_between &
            &+ (to - start)*dilation_tangent(post_peak, 0.5_wp*(start + to), peak_angle)            ! (18, 22)
      end if
   end function dilation_between

   !> Dilation from rest to u/up = ratio at constant stress, over up [-]: the sum of dilation_between over the
   !> intervals of Table 1, each by the three-point Gauss rule.
   pure real(wp) function dilation_from_rest(post_peak, ratio, peak_angle)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up [-], JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: ratio, peak_angle
      integer, parameter :: peak_node = 3
      real(wp), parameter :: interval_end(table_nodes) = [table_u(2:), largest_ratio]
      real(wp), parameter :: gauss_point = sqrt(0.6_wp), side_weight = 5.0_wp/18.0_wp, middle_weight = 8.0_wp/18.0_wp
      real(wp) :: start, end, middle, half
      integer :: i

      end = min(ratio, peak_ratio)
      dilation_from_rest = dilation_ratio(peak_angle)*end*(2.0_wp*end - 1.0_wp)
      do i = peak_node, table_nodes
         start = table_u(i)
         if (ratio <= start) exit
         end = min(ratio, interval_end(i))
         middle = 0.5_wp*(start + end)
         half = 0.5_wp*(end - start)
         dilation_from_rest = dilation_from_rest + (end - start) &
            &*(side_weight*(dilation_tangent(post_peak, middle - gauss_point*half, peak_angle) &
            &             + dilation_tangent(post_peak, middle + gauss_point*half, peak_angle)) &
            & + middle_weight*dilation_tangent(post_peak, middle, peak_angle))
      end do
   end function dilation_from_rest

   !> Dilation of a slip beyond u_max at a normal stress, contraction and dilation apart, with the derivatives of both.
   pure function jcm_dilation(edge, state, slip, sn) result(dilation)
      type(jcm_edge_t), intent(in) :: edge
      !> State at the start of the slip
      type(joint_point_t), intent(in) :: state
      !> Slip beyond u_max [mm], normal stress [MPa]
      real(wp), intent(in) :: slip, sn
      type(joint_dilation_t) :: dilation
      type(roughness_t) :: rough
      real(wp) :: peak_angle, end, peak_sn, angle_sn

      rough = roughness_at(edge, sn)
      peak_angle = peak_dilation_angle(edge, rough%logarithm)
      end = min(state%ratio + slip/rough%peak, largest_ratio)
      peak_sn = 0.0_wp
      angle_sn = 0.0_wp
      if (sn > 0.0_wp) then
         peak_sn = rough%peak*relative_peak_sensitivity(edge, rough, sn)/sn
         angle_sn = peak_dilation_angle_slope(edge, rough%logarithm)*logarithm_slope(edge, sn)/sn
      end if
      if (state%ratio < contraction_end) call add_part(state%ratio, min(end, contraction_end), dilation%contraction, &
                                                       dilation%contraction_u, dilation%contraction_sn)
      if (end > contraction_end) call add_part(max(state%ratio, contraction_end), end, dilation%expansion, &
                                               dilation%expansion_u, dilation%expansion_sn)

   contains

      !> Dilation between two values of u/up and its derivatives by slip and normal stress.
      pure subroutine add_part(from, to, part, part_u, part_sn)
         real(wp), intent(in) :: from, to
         real(wp), intent(out) :: part, part_u, part_sn
         real(wp) :: over_peak

         over_peak = dilation_between(edge%post_peak, from, to, peak_angle)
         part = rough%peak*over_peak
         part_u = 0.0_wp
         if (to >= end) part_u = dilation_by_ratio(edge%post_peak, from, to, peak_angle)
         part_sn = peak_sn*(over_peak - part_u*slip/rough%peak) &
            &+ rough%peak*dilation_by_angle(edge%post_peak, from, to, peak_angle)*angle_sn
      end subroutine add_part

   end function jcm_dilation

   !> d dilation_between/d to [-].
   pure real(wp) function dilation_by_ratio(post_peak, from, to, peak_angle)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up at the start and at the end, from <= to [-]; JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: from, to, peak_angle
      real(wp) :: start, middle, tangent

      if (to <= peak_ratio) then
         dilation_by_ratio = dilation_ratio(peak_angle)*(4.0_wp*to - 1.0_wp)
      else
         ! That of the mid-point rule
         start = max(from, peak_ratio)
         middle = 0.5_wp*(start + to)
         tangent = dilation_tangent(post_peak, middle, peak_angle)
         dilation_by_ratio = tangent + 0.5_wp*(to - start)*radians*peak_angle*share_slope(post_peak, middle) &
                            &*(1.0_wp + tangent**2)
      end if
   end function dilation_by_ratio

   !> d dilation_between/d peak angle [1/deg].
   pure real(wp) function dilation_by_angle(post_peak, from, to, peak_angle)
      !> Post-peak form
      integer, intent(in) :: post_peak
      !> u/up at the start and at the end, from <= to [-]; JRCn log10(JCSn/sn)/M [deg]
      real(wp), intent(in) :: from, to, peak_angle
      real(wp) :: start, end

      dilation_by_angle = 0.0_wp
      if (from < peak_ratio) then
         end = min(to, peak_ratio)
         dilation_by_angle = radians/3.0_wp*secant_squared(peak_angle/3.0_wp)*(end - from)*(2.0_wp*(from + end) - 1.0_wp)
      end if
      if (to > peak_ratio) then
         start = max(from, peak_ratio)
         associate (share => share_beyond_onset(post_peak, 0.5_wp*(start + to)))
            dilation_by_angle = dilation_by_angle + (to - start)*radians*share*secant_squared(peak_angle*share)
         end associate
      end if
   end function dilation_by_angle

   ! ---- Aperture: eq 31 --------------------------------------------------------------------------------------------

   !> Eq 31: aperture [mm], never below zero (vm can exceed a0).
   pure real(wp) function aperture(a0, w, v)
      !> Initial aperture; opening, positive when the walls are apart; accumulated closure, eq 23a [mm]
      real(wp), intent(in) :: a0, w, v

      if (w >= 0.0_wp) then
         aperture = a0 + w                                                                          ! (31)
      else
         aperture = max(a0 - v, 0.0_wp)                                                             ! (31)
      end if
   end function aperture

   ! ---- The incremental law ----------------------------------------------------------------------------------------

   !> Advance one joint element by a slip du to a new normal stress.
   !>
   !> Slip beyond the largest |u| reached mobilises roughness (ratio) and dilates; slip below it does neither: the
   !> dilation is then a function of |u|. The shear stress is that of a spring and a slider: elastic, bounded by the
   !> mobilised strength. An open joint carries no shear; slip while open leaves the roughness as it was.
   !>
   !> The slip mobilises and dilates under the normal stress at the end of the step, or as `path` says.
   pure subroutine jcm_update(edge, du, sn_new, state, path)
      type(jcm_edge_t), intent(in) :: edge
      !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
      real(wp), intent(in) :: du, sn_new
      type(joint_point_t), intent(inout) :: state
      type(joint_slip_t), intent(in), optional :: path
      type(roughness_t) :: rough
      real(wp) :: sn, slip, peak_angle, rate, change

      sn = between(0.0_wp, sn_new, largest_stress)
      if (abs(du) <= 0.0_wp .and. abs(sn - state%sn) <= 0.0_wp) then
         state%step_u = 0.0_wp
         state%step_ratio = 0.0_wp
         return
      end if
      slip = between(-largest_slip, du, largest_slip)
      state%step_u = slip
      state%u = between(-largest_slip, state%u + slip, largest_slip)
      change = sn - state%sn
      state%sn = sn
      rough = roughness_at(edge, sn)
      rate = 1.0_wp/rough%peak
      if (present(path)) then
         call slip_on_path(edge, path, change, state, rate)
      else if (sn > 0.0_wp) then
         peak_angle = peak_dilation_angle(edge, rough%logarithm)
         call slip_on_roughness(edge, rough%peak, peak_angle, state)
      else
         call slip_while_open(edge, state)
      end if
      if (sn > 0.0_wp) then
         call return_to_strength(edge, rough, rate, state)
         state%knn = normal_stiffness(edge%kn0, edge%vm, sn)
         state%vn = closure(edge%kn0, edge%vm, sn)                                                  ! (5b, 23a)
         if (edge%hysteretic) state%knn = path_stiffness(edge%curves, state%memory, sn)
      else
         state%tau = 0.0_wp
         state%ktt = 0.0_wp
         state%sliding = .true.
         state%knn = 0.0_wp
         state%vn = 0.0_wp
      end if
      if (edge%hysteretic) then
         state%vn = path_closure(edge%curves, state%memory, sn)
         call follow_path(edge%curves, sn, state%memory)
         state%set = path_closure(edge%curves, state%memory, 0.0_wp)
      end if
      state%v = state%vn - state%dilation                                                           ! (23a)
   end subroutine jcm_update

   !> Mobilise and dilate: the state already holds the new u, its u_max is still the old one.
   pure subroutine slip_on_roughness(edge, peak, peak_angle, state)
      type(jcm_edge_t), intent(in) :: edge
      !> Peak displacement [mm], peak dilation angle [deg] at the new normal stress
      real(wp), intent(in) :: peak, peak_angle
      type(joint_point_t), intent(inout) :: state
      real(wp) :: start

      if (abs(state%u) > state%u_max) then
         start = state%ratio
         state%ratio = min(start + (abs(state%u) - state%u_max)/peak, largest_ratio)
         state%step_ratio = state%ratio - start
         state%u_max = abs(state%u)
         state%dilation_max = state%dilation_max &
            &+ peak*dilation_between(edge%post_peak, start, state%ratio, peak_angle)
         state%path_peak = peak
         state%path_angle = peak_angle
         state%dilation = state%dilation_max
         state%dilation_slope = sign(1.0_wp, state%u)*dilation_tangent(edge%post_peak, state%ratio, peak_angle)
      else
         state%step_ratio = 0.0_wp
         call retrace_dilation(edge, state)
      end if
   end subroutine slip_on_roughness

   !> The same under the stress of a path, with the dilation it has found.
   pure subroutine slip_on_path(edge, path, change, state, rate)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_slip_t), intent(in) :: path
      !> Change of the normal stress [MPa]
      real(wp), intent(in) :: change
      type(joint_point_t), intent(inout) :: state
      !> Mobilisation by slip [1/mm]
      real(wp), intent(out) :: rate
      type(roughness_t) :: rough

      rough = roughness_at(edge, path%stress)
      rate = 1.0_wp/rough%peak
      state%last_change = 0.0_wp
      if (abs(state%u) <= state%u_max .or. .not. path%touching) then
         call slip_while_open(edge, state)
         return
      end if
      state%step_ratio = min(rate*(abs(state%u) - state%u_max), largest_ratio - state%ratio)
      state%ratio = state%ratio + state%step_ratio
      state%u_max = abs(state%u)
      state%dilation_max = state%dilation_max + path%dilation
      state%dilation = state%dilation_max
      state%dilation_slope = path%dilation_u
      state%path_peak = rough%peak
      state%path_angle = peak_dilation_angle(edge, rough%logarithm)
      if (state%step_ratio > least_step) state%last_change = change
   end subroutine slip_on_path

   !> Slip without contact: u_max moves with |u|, roughness and its dilation stay.
   pure subroutine slip_while_open(edge, state)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(inout) :: state

      state%step_ratio = 0.0_wp
      if (abs(state%u) >= state%u_max) then
         state%u_max = abs(state%u)
         state%dilation = state%dilation_max
         state%dilation_slope = 0.0_wp
      else
         call retrace_dilation(edge, state)
      end if
   end subroutine slip_while_open

   !> Dilation [mm] of a joint whose |u| is at most u_max, or that slips on without contact, and its slope [-].
   pure subroutine jcm_retrace(edge, state, u, dilation, slope)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(in) :: state
      !> Shear displacement [mm]
      real(wp), intent(in) :: u
      real(wp), intent(out) :: dilation, slope
      type(joint_point_t) :: there

      there = state
      there%u = u
      call slip_while_open(edge, there)
      dilation = there%dilation
      slope = there%dilation_slope
   end subroutine jcm_retrace

   !> Dilation below u_max, a function of |u| alone: the walls go down the curve of constant stress that ran through the last
   !> extension of u_max, to where it is lowest, u/up = 1/4. What has contracted before that stays: the walls have seated, and
   !> there is no edge to go over at u = 0. A parabola makes the curve end at u_max with the dilation reached there and the
   !> slope with which it goes on: a kink would leave implicit solvers no direction. At constant stress it vanishes.
   pure subroutine retrace_dilation(edge, state)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(inout) :: state
      real(wp) :: share, rest, bend, ratio, slope

      state%dilation = state%dilation_max
      state%dilation_slope = 0.0_wp
      if (state%ratio <= contraction_end) return
      share = abs(state%u)/state%u_max
      ratio = max(share*state%ratio, contraction_end)
      rest = state%dilation_max - state%path_peak*dilation_from_rest(edge%post_peak, state%ratio, state%path_angle)
      bend = rest + (state%path_peak*state%ratio - state%u_max)*dilation_tangent(edge%post_peak, state%ratio, state%path_angle)
      state%dilation = state%path_peak*dilation_from_rest(edge%post_peak, ratio, state%path_angle) &
         &+ share*(rest + (1.0_wp - share)*bend)
      slope = rest + (1.0_wp - 2.0_wp*share)*bend
      if (ratio > contraction_end) slope = slope &
         &+ state%path_peak*state%ratio*dilation_tangent(edge%post_peak, ratio, state%path_angle)
      state%dilation_slope = sign(1.0_wp, state%u)*slope/state%u_max
   end subroutine retrace_dilation

   !> Shear stress: elastic trial, returned to the mobilised strength when beyond it.
   pure subroutine return_to_strength(edge, rough, rate, state)
      type(jcm_edge_t), intent(in) :: edge
      !> Roughness at the normal stress of the state
      type(roughness_t), intent(in) :: rough
      !> Mobilisation by slip in this step [1/mm]
      real(wp), intent(in) :: rate
      type(joint_point_t), intent(inout) :: state
      real(wp) :: slope, stiffness, trial, strength, mu_back, mu_back_u

      state%mu_mob = tan(radians*angle_at(edge, state%ratio, rough%angle))                          ! (33)
      strength = state%sn*state%mu_mob                                                              ! (13)
      if (edge%weaker_back .and. state%u*state%step_u < 0.0_wp) then
         call friction_back(edge, state, mu_back, mu_back_u)
         if (mu_back < state%mu_mob) then
            call slide_back(edge, rough, mu_back, mu_back_u, state)
            return
         end if
      end if
      slope = 0.0_wp
      if (abs(state%u) >= state%u_max) &
         & slope = radians*angle_slope(edge, state%ratio, rough%angle)*(1.0_wp + state%mu_mob**2)
      ! These two slopes are bounds of the elastic one from below. A joint driven on to its strength by them slides for
      ! certain, and needs no dearer bound.
      stiffness = state%sn/rough%peak*max(edge%onset_slope, slope)
      trial = state%tau + stiffness*state%step_u
      if (abs(trial) < strength .or. state%tau*state%step_u < 0.0_wp) then
         stiffness = state%sn/rough%peak*steepest_slope(edge, rough%angle)
         trial = state%tau + stiffness*state%step_u
      end if
      state%sliding = abs(trial) >= strength
      if (state%sliding) then
         state%tau = sign(strength, trial)
         state%ktt = state%sn*rate*slope                                                            ! (17)
         if (trial*state%u < 0.0_wp) state%ktt = -state%ktt
      else
         state%tau = trial
         state%ktt = stiffness
      end if
   end subroutine return_to_strength

   !> Friction coefficient of a joint that slides back down the asperities that it has climbed, and its derivative by u [1/mm]:
   !> tan(phi_r - d), d the dilation angle where it is (Fei and Choo 2022). Never below zero: no joint pushes itself back.
   pure subroutine friction_back(edge, state, mu, mu_u)
      type(jcm_edge_t), intent(in) :: edge
      !> With the dilation of its u
      type(joint_point_t), intent(in) :: state
      real(wp), intent(out) :: mu, mu_u
      real(wp) :: flat, steepness

      flat = tan(radians*edge%phi_r)
      steepness = max(0.0_wp, sign(1.0_wp, state%u)*state%dilation_slope)
      mu = (flat - steepness)/(1.0_wp + flat*steepness)
      mu_u = 0.0_wp
      if (steepness > 0.0_wp .and. mu > 0.0_wp) &
         mu_u = -(1.0_wp + flat**2)/(1.0_wp + flat*steepness)**2*sign(1.0_wp, state%u)*retraced_curvature(edge, state)
      mu = max(mu, 0.0_wp)
   end subroutine friction_back

   !> d |dilation slope|/d|u| of a joint on its way back [1/mm].
   pure real(wp) function retraced_curvature(edge, state) result(curvature)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(in) :: state
      real(wp) :: ratio, rest, bend

      curvature = 0.0_wp
      if (state%ratio <= contraction_end .or. abs(state%u) >= state%u_max) return
      ratio = abs(state%u)/state%u_max*state%ratio
      rest = state%dilation_max - state%path_peak*dilation_from_rest(edge%post_peak, state%ratio, state%path_angle)
      bend = rest + (state%path_peak*state%ratio - state%u_max)*dilation_tangent(edge%post_peak, state%ratio, state%path_angle)
      curvature = -2.0_wp*bend
      if (ratio > contraction_end) curvature = curvature &
         &+ state%path_peak*state%ratio**2*dilation_tangent_slope(edge%post_peak, ratio, state%path_angle)
      curvature = curvature/state%u_max**2
   end function retraced_curvature

   !> Shear stress of a joint that goes back: elastic trial, returned to a strength that is lower than on the way out.
   pure subroutine slide_back(edge, rough, mu_back, mu_back_u, state)
      type(jcm_edge_t), intent(in) :: edge
      type(roughness_t), intent(in) :: rough
      !> Friction coefficient on the way back [-], its derivative by u [1/mm]
      real(wp), intent(in) :: mu_back, mu_back_u
      type(joint_point_t), intent(inout) :: state
      real(wp) :: stiffness, trial

      stiffness = state%sn/rough%peak*steepest_slope(edge, rough%angle)
      trial = state%tau + stiffness*state%step_u
      ! While it still leans outward it is the strength of the way out that counts
      state%sliding = trial*state%u < 0.0_wp .and. abs(trial) >= state%sn*mu_back
      if (state%sliding) then
         state%mu_mob = mu_back
         state%tau = sign(state%sn*mu_back, trial)
         state%ktt = sign(state%sn, trial)*mu_back_u
      else
         state%tau = sign(min(abs(trial), state%sn*state%mu_mob), trial)
         state%ktt = stiffness
      end if
   end subroutine slide_back

   !> Tangent of the step that led to this state: how its results change with its du, its sn_new and its path.
   pure function jcm_tangent(edge, state, path) result(tangent)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(in) :: state
      type(joint_slip_t), intent(in), optional :: path
      type(joint_tangent_t) :: tangent
      type(roughness_t) :: rough
      real(wp) :: peak_sensitivity, ratio_sensitivity, slope

      tangent%dilation_u = state%dilation_slope
      tangent%vn_sn = 1.0_wp/normal_stiffness(edge%kn0, edge%vm, state%sn)
      if (state%sn <= 0.0_wp) return
      if (edge%hysteretic) tangent%vn_sn = 1.0_wp/state%knn
      rough = roughness_at(edge, state%sn)
      peak_sensitivity = relative_peak_sensitivity(edge, rough, state%sn)
      tangent%tau_u = state%ktt
      if (state%sliding .and. edge%weaker_back .and. state%tau*state%u < 0.0_wp .and. state%step_u*state%u < 0.0_wp) then
         tangent%tau_sn = sign(state%mu_mob, state%tau)
      else if (state%sliding) then
         ! Along eq 13, and through up(sn), which sets how much this step's slip mobilised.
         slope = radians*angle_slope(edge, state%ratio, rough%angle)*(1.0_wp + state%mu_mob**2)
         ratio_sensitivity = peak_sensitivity
         if (present(path)) then
            ratio_sensitivity = 0.0_wp
            if (path%stress > 0.0_wp) ratio_sensitivity = state%sn*path%stress_sn/path%stress &
                                                     &*relative_peak_sensitivity(edge, roughness_at(edge, path%stress), path%stress)
         end if
         tangent%tau_sn = sign(1.0_wp, state%tau)*(shear_stress_sensitivity(edge, state%ratio, state%sn) &
            &- slope*state%step_ratio*ratio_sensitivity)
      else
         tangent%tau_sn = state%step_u/rough%peak*(steepest_slope(edge, rough%angle)*(1.0_wp - peak_sensitivity) &
            &+ steepest_slope_sensitivity(edge, rough%angle)*edge%jrcn*logarithm_slope(edge, state%sn))
      end if
   end function jcm_tangent

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

   !> d steepest_slope/d roughness angle [1/deg].
   pure real(wp) function steepest_slope_sensitivity(edge, roughness)
      type(jcm_edge_t), intent(in) :: edge
      !> JRCn log10(JCSn/sn) [deg]
      real(wp), intent(in) :: roughness
      real(wp) :: slope, angle, curvature
      integer :: i

      steepest_slope_sensitivity = 0.0_wp
      slope = steepest_slope(edge, roughness)
      do i = 1, 2
         angle = edge%phi_r + table_jrc(i + 1)*roughness
         if (radians*table_slope(i)*roughness*secant_squared(angle) < slope) cycle
         curvature = 1.0_wp + 2.0_wp*radians*roughness*table_jrc(i + 1)*tan(radians*angle)
         steepest_slope_sensitivity = radians*table_slope(i)*secant_squared(angle)*curvature
      end do
   end function steepest_slope_sensitivity

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

end module jcm_m
