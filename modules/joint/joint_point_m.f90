!> State of one joint element, shared by all joint laws. The laws work in MPa and mm; compression and closure are
!> positive.
module joint_point_m
   use kinds_m, only: wp
   implicit none
   private

   public :: joint_values, joint_from_values

   !> Numbers that a law may keep for itself; numbers that make up a joint's state
   integer, parameter, public :: memory_size = 5, joint_value_count = 20 + memory_size

   !> What one joint element remembers between steps
   type, public :: joint_point_t
      !> Shear displacement; largest |u| reached [mm]
      real(wp) :: u = 0.0_wp, u_max = 0.0_wp
      !> Mobilisation: the integral of d|u|/up over the steps that took |u| beyond u_max [-]
      real(wp) :: ratio = 0.0_wp
      !> Shear stress, with the sign of the slip that drives it; normal stress, 0 when open [MPa]
      real(wp) :: tau = 0.0_wp, sn = 0.0_wp
      !> Closure by normal stress; dilation by shear; their sum v = vn - dilation, the closure of eq 23a [mm]
      real(wp) :: vn = 0.0_wp, dilation = 0.0_wp, v = 0.0_wp
      !> The part of vn that stays without stress: it has set, and is no opening [mm]
      real(wp) :: set = 0.0_wp
      !> Mobilised friction coefficient, eq 33 [-]
      real(wp) :: mu_mob = 0.0_wp
      !> d dilation/du, with the sign of u: moving back along |u| contracts what moving out dilated [-]
      real(wp) :: dilation_slope = 0.0_wp
      !> Normal stiffness, eq 11; shear stiffness of the last step: eq 17 when sliding, elastic when not [MPa/mm]
      real(wp) :: knn = 0.0_wp, ktt = 0.0_wp
      !> Dilation at u_max, and the peak displacement [mm] and peak dilation angle [deg] in force when u_max was last
      !> extended: they fix the dilation as a function of |u| for as long as |u| stays below u_max
      real(wp) :: dilation_max = 0.0_wp, path_peak = 0.0_wp, path_angle = 0.0_wp
      !> Slip [mm] and mobilisation [-] of the last step, for its tangent
      real(wp) :: step_u = 0.0_wp, step_ratio = 0.0_wp
      !> Change of the normal stress in the last step, when coupled walls mobilised in it, for the next [MPa]
      real(wp) :: last_change = 0.0_wp
      !> What a law remembers beside all this; each law says what its numbers are
      real(wp) :: memory(memory_size) = 0.0_wp
      !> Did the last step end at the shear strength?
      logical :: sliding = .false.
   end type joint_point_t

   !> How walls that ride on their asperities slip in a step
   type, public :: joint_slip_t
      !> Do they touch, so that slip beyond u_max mobilises?
      logical :: touching = .true.
      !> Normal stress under which it does, between those of start and end [MPa], and its derivative by that of the end [-]
      real(wp) :: stress = 0.0_wp, stress_sn = 0.0_wp
      !> Dilation that slip beyond u_max has added [mm], and its derivative by the slip [-]
      real(wp) :: dilation = 0.0_wp, dilation_u = 0.0_wp
   end type joint_slip_t

   !> Dilation of a slip beyond u_max at one normal stress: what contracts before u/up = 1/4, and what dilates after it
   type, public :: joint_dilation_t
      !> [mm]
      real(wp) :: contraction = 0.0_wp, expansion = 0.0_wp
      !> Derivatives by the slip [-] and by the normal stress [mm/MPa]
      real(wp) :: contraction_u = 0.0_wp, expansion_u = 0.0_wp, contraction_sn = 0.0_wp, expansion_sn = 0.0_wp
   end type joint_dilation_t

   !> Tangent of the last step, for implicit solvers
   type, public :: joint_tangent_t
      !> d tau/du, d tau/d sn [MPa/mm, -]
      real(wp) :: tau_u = 0.0_wp, tau_sn = 0.0_wp
      !> d dilation/du, d vn/d sn [-, mm/MPa]
      real(wp) :: dilation_u = 0.0_wp, vn_sn = 0.0_wp
   end type joint_tangent_t

contains

   !> The state as a list of numbers, for checkpoints.
   pure function joint_values(point) result(value)
      type(joint_point_t), intent(in) :: point
      real(wp) :: value(joint_value_count)

      value = [point%u, point%u_max, point%ratio, point%tau, point%sn, point%vn, point%dilation, point%v, &
               point%mu_mob, point%dilation_slope, point%knn, point%ktt, point%dilation_max, point%path_peak, &
               point%path_angle, point%step_u, point%step_ratio, point%last_change, point%set, point%memory, &
               merge(1.0_wp, 0.0_wp, point%sliding)]
   end function joint_values

   !> The state from its list of numbers.
   pure function joint_from_values(value) result(point)
      real(wp), intent(in) :: value(joint_value_count)
      type(joint_point_t) :: point

      point = joint_point_t(u=value(1), u_max=value(2), ratio=value(3), tau=value(4), sn=value(5), vn=value(6), &
                            dilation=value(7), v=value(8), mu_mob=value(9), dilation_slope=value(10), knn=value(11), &
                            ktt=value(12), dilation_max=value(13), path_peak=value(14), path_angle=value(15), &
                            step_u=value(16), step_ratio=value(17), last_change=value(18), &
                            set=value(19), memory=value(20:19 + memory_size), &
                            sliding=value(joint_value_count) > 0.5_wp)
   end function joint_from_values

end module joint_point_m
