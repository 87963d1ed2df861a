!> Equations of the JCM as they stand in the papers, one by one. The program works them in one go (jcm_m); the tests compare.
module jcm_equations
   use kinds_m, only: wp
   use constants_m, only: radians
   use joint_point_m, only: joint_point_t
   use jcm_scale_m, only: jcm_edge_t, roughness_logarithm
   use jcm_strength_m, only: mobilised_angle
   use jcm_dilation_m, only: peak_dilation_angle
   implicit none
   private

   public :: peak_strength, shear_strength, mobilised_friction, peak_dilation_ratio

   !> u/up at the peak
   real(wp), parameter :: peak_ratio = 1.0_wp

contains

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

      shear_strength = max(sn, 0.0_wp)*tan(radians*mobilised_angle(edge, ratio, max(sn, 0.0_wp)))                   ! (13)
   end function shear_strength

   !> Eq 33: friction coefficient the joint has mobilised, for eq 4 [-].
   pure real(wp) function mobilised_friction(edge, state)
      type(jcm_edge_t), intent(in) :: edge
      type(joint_point_t), intent(in) :: state

      mobilised_friction = tan(radians*mobilised_angle(edge, state%ratio, state%sn))                ! (33)
   end function mobilised_friction

   !> Eq 20: dilation at the peak over peak displacement, vp/up [-].
   pure real(wp) function peak_dilation_ratio(edge, sn)
      type(jcm_edge_t), intent(in) :: edge
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      peak_dilation_ratio = tan(radians*peak_dilation_angle(edge, roughness_logarithm(edge, sn))/3.0_wp)  ! (20)
   end function peak_dilation_ratio

end module jcm_equations
