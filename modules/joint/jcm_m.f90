!> The empirical joint constitutive model (JCM) of Barton and Bandis: the incremental law that a solver calls at every step, made
!> of scaling (jcm_scale_m), closure (jcm_closure_m), shear strength (jcm_strength_m) and dilation (jcm_dilation_m).
!>
!> Units of these modules: MPa, mm, degrees; joint lengths in m. Compression and closure are positive.
!> Equation numbers are those of Lei, Latham and Xiang (2016), Rock Mech. Rock Eng. 49:4799-4816.
!> Sources: Barton and Choubey 1977 (strength, dilation); Bandis et al. 1983 (closure); Barton et al. 1985 (scaling,
!> mobilisation); Olsson and Barton 2001 (dilation after the peak); Asadollahi and Tonon 2010 (peak displacement).
module jcm_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use jcm_closure_m, only: closure, normal_stiffness, path_closure, path_stiffness, follow_path
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t
   use jcm_scale_m, only: roughness_at, logarithm_slope, relative_peak_sensitivity, between, largest_stress, largest_slip, &
                          largest_ratio, jcm_edge_t, roughness_t
   use jcm_strength_m, only: angle_at, angle_slope, shear_stress_sensitivity, steepest_slope, steepest_slope_sensitivity
   use jcm_dilation_m, only: peak_dilation_angle, dilation_tangent, dilation_tangent_slope, dilation_between, &
                             dilation_from_rest, contraction_end
   implicit none
   private

   public :: aperture, jcm_update, jcm_retrace, jcm_tangent

   !> A step that mobilises less says nothing of how the normal stress changes with slip [-]
   real(wp), parameter :: least_step = 1.0e-3_wp

contains

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

end module jcm_m
