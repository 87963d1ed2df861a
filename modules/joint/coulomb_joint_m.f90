!> A joint with constant friction angle and cohesion (Coulomb), elastic below its strength. It neither mobilises nor
!> dilates. Units as in jcm_m: MPa, mm, degrees.
module coulomb_joint_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use jcm_m, only: jcm_edge_t, closure, closure_stress, normal_stiffness, residual_shear_stiffness
   use joint_point_m, only: joint_point_t, joint_tangent_t
   implicit none
   private

   public :: coulomb_update, coulomb_tangent
   public :: coulomb_closure_stress, coulomb_closure, coulomb_normal_stiffness, coulomb_shear_stiffness

   !> A Coulomb joint
   type, public :: coulomb_joint_t
      !> Friction angle [deg], cohesion [MPa]
      real(wp) :: friction_angle = 30.0_wp, cohesion = 0.0_wp
      !> Normal and shear stiffness [MPa/mm]; a shear stiffness of 0 means the current normal stiffness, or that of a rough
      !> joint until it mobilises its residual friction
      real(wp) :: kn = 1.0_wp, ks = 0.0_wp
      logical :: as_rough = .false.
      !> That rough joint
      type(jcm_edge_t) :: rough
      !> Maximum closure of the hyperbolic closure of eq 5, whose initial stiffness is kn; 0: closure is linear [mm]
      real(wp) :: vm = 0.0_wp
      !> Initial aperture [mm]
      real(wp) :: a0 = 0.0_wp
   end type coulomb_joint_t

contains

   !> Advance one joint element by a slip du to a new normal stress.
   pure subroutine coulomb_update(joint, du, sn_new, state)
      type(coulomb_joint_t), intent(in) :: joint
      !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
      real(wp), intent(in) :: du, sn_new
      type(joint_point_t), intent(inout) :: state
      real(wp) :: trial, strength

      state%step_u = du
      state%u = state%u + du
      state%u_max = max(state%u_max, abs(state%u))
      state%sn = max(sn_new, 0.0_wp)
      state%mu_mob = tan(radians*joint%friction_angle)
      if (state%sn > 0.0_wp) then
         state%knn = coulomb_normal_stiffness(joint, state%sn)
         state%vn = coulomb_closure(joint, state%sn)
         state%ktt = coulomb_shear_stiffness(joint, state%sn)
         strength = joint%cohesion + state%sn*state%mu_mob
         trial = state%tau + state%ktt*du
         state%sliding = abs(trial) >= strength
         if (state%sliding) state%ktt = 0.0_wp
         state%tau = sign(min(abs(trial), strength), trial)
      else
         state%knn = 0.0_wp
         state%vn = 0.0_wp
         state%ktt = 0.0_wp
         state%tau = 0.0_wp
         state%sliding = .true.
      end if
      state%v = state%vn
   end subroutine coulomb_update

   !> Tangent of the step that led to this state.
   pure function coulomb_tangent(joint, state) result(tangent)
      type(coulomb_joint_t), intent(in) :: joint
      type(joint_point_t), intent(in) :: state
      type(joint_tangent_t) :: tangent

      tangent%vn_sn = 1.0_wp/coulomb_normal_stiffness(joint, state%sn)
      if (state%sn <= 0.0_wp) return
      tangent%tau_u = state%ktt
      if (state%sliding) then
         tangent%tau_sn = sign(state%mu_mob, state%tau)
      else if (joint%ks <= 0.0_wp .and. joint%as_rough) then
         tangent%tau_sn = state%step_u*rough_stiffness_slope(joint, state%sn)
      else if (joint%ks <= 0.0_wp .and. joint%vm > 0.0_wp) then
         ! d knn/d sn of eq 11
         tangent%tau_sn = state%step_u*2.0_wp*sqrt(state%knn/(joint%kn*joint%vm**2))
      end if
   end function coulomb_tangent

   !> Change of the rough joint's shear stiffness with normal stress, by a central difference [1/mm].
   pure real(wp) function rough_stiffness_slope(joint, sn) result(slope)
      type(coulomb_joint_t), intent(in) :: joint
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      !> Relative difference whose error, of rounding and of curvature, is least
      real(wp), parameter :: share = epsilon(1.0_wp)**(1.0_wp/3.0_wp)

      slope = (residual_shear_stiffness(joint%rough, sn*(1.0_wp + share)) &
               - residual_shear_stiffness(joint%rough, sn*(1.0_wp - share)))/(2.0_wp*share*sn)
   end function rough_stiffness_slope

   !> Normal stress of a closure [MPa]; none when the walls are apart.
   pure real(wp) function coulomb_closure_stress(joint, v)
      type(coulomb_joint_t), intent(in) :: joint
      !> Closure [mm]
      real(wp), intent(in) :: v

      if (joint%vm > 0.0_wp) then
         coulomb_closure_stress = closure_stress(joint%kn, joint%vm, v)
      else
         coulomb_closure_stress = joint%kn*max(v, 0.0_wp)
      end if
   end function coulomb_closure_stress

   !> Closure under a normal stress [mm], the inverse of coulomb_closure_stress.
   pure real(wp) function coulomb_closure(joint, sn)
      type(coulomb_joint_t), intent(in) :: joint
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      if (joint%vm > 0.0_wp) then
         coulomb_closure = closure(joint%kn, joint%vm, sn)
      else
         coulomb_closure = max(sn, 0.0_wp)/joint%kn
      end if
   end function coulomb_closure

   !> Normal stiffness [MPa/mm].
   pure real(wp) function coulomb_normal_stiffness(joint, sn)
      type(coulomb_joint_t), intent(in) :: joint
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      coulomb_normal_stiffness = joint%kn
      if (joint%vm > 0.0_wp) coulomb_normal_stiffness = normal_stiffness(joint%kn, joint%vm, sn)
   end function coulomb_normal_stiffness

   !> Elastic shear stiffness [MPa/mm].
   pure real(wp) function coulomb_shear_stiffness(joint, sn)
      type(coulomb_joint_t), intent(in) :: joint
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      coulomb_shear_stiffness = joint%ks
      if (joint%ks > 0.0_wp) return
      if (joint%as_rough) then
         coulomb_shear_stiffness = residual_shear_stiffness(joint%rough, sn)
      else
         coulomb_shear_stiffness = coulomb_normal_stiffness(joint, sn)
      end if
   end function coulomb_shear_stiffness

end module coulomb_joint_m
