!> Shear strength and stiffness of the JCM: angles and slopes of eqs 13, 16, 17, 33 and Table 1.
module jcm_strength_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use jcm_scale_m, only: roughness_logarithm, roughness_at, logarithm_slope, secant_squared, between, post_peak_eq16, onset, &
                          peak_ratio, post_peak_exponent, largest_stress, largest_ratio, jcm_edge_t, roughness_t
   implicit none
   private

   public :: mobilised_ratio, share_beyond_onset, share_slope, mobilised_angle, angle_at, angle_slope, shear_stiffness, &
             shear_stress_sensitivity, elastic_shear_stiffness, residual_shear_stiffness, steepest_slope, &
             steepest_slope_sensitivity, table_nodes, table_u

   !> Table 1 from u/up = 0.3 on: JRCmob/JRCn at the nodes, read linearly between them
   integer, parameter :: table_nodes = 8
   real(wp), parameter :: table_u(table_nodes) = [0.3_wp, 0.6_wp, 1.0_wp, 2.0_wp, 4.0_wp, 10.0_wp, 25.0_wp, 100.0_wp]
   real(wp), parameter :: table_jrc(table_nodes) = [0.0_wp, 0.75_wp, 1.0_wp, 0.85_wp, 0.70_wp, 0.50_wp, 0.40_wp, 0.0_wp]
   real(wp), parameter :: table_slope(table_nodes - 1) = (table_jrc(2:) - table_jrc(:table_nodes - 1)) &
      &/(table_u(2:) - table_u(:table_nodes - 1))

contains

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

end module jcm_strength_m
