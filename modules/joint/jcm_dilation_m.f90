!> Dilation of the JCM: eqs 18 to 22.
module jcm_dilation_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use joint_point_m, only: joint_point_t, joint_dilation_t
   use jcm_scale_m, only: roughness_logarithm, roughness_at, logarithm_slope, relative_peak_sensitivity, secant_squared, &
                          peak_ratio, largest_ratio, steepest, jcm_edge_t, roughness_t
   use jcm_strength_m, only: share_beyond_onset, share_slope, table_nodes, table_u
   implicit none
   private

   public :: damage_coefficient, peak_dilation_angle, dilation_angle, dilation_tangent, dilation_tangent_slope, &
             dilation_between, dilation_from_rest, jcm_dilation, contraction_end

   !> u/up up to which eq 19 contracts
   real(wp), parameter :: contraction_end = 0.25_wp

   !> Floor of the logarithm in eq 21, which divides by it
   real(wp), parameter :: least_logarithm = 1.0e-3_wp

contains

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

end module jcm_dilation_m
