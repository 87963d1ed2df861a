!> A joint with constant friction angle and cohesion (Coulomb), elastic below its strength. It neither mobilises nor
!> dilates. Units as in jcm_m: MPa, mm, degrees.
module coulomb_law_m
   use kinds_m, only: wp
   use bounds_m, only: most_stress, least_stiffness, most_stiffness
   use constants_m, only: radians, is_set
   use units_m, only: megapascal, megapascal_per_millimetre
   use jcm_scale_m, only: jcm_edge_t, jcm_scale
   use jcm_strength_m, only: residual_shear_stiffness
   use jcm_closure_m, only: hyperbola => closure, hyperbola_stress => closure_stress, hyperbola_stiffness => normal_stiffness
   use jcm_law_m, only: jcm_variables, jcm_parameters_of, has_roughness, check_initial_aperture
   use joint_law_m, only: joint_law_t, law_result_t
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t
   use law_variable_m, only: law_variable_t, law_settings_t, complaints_t, a_real
   implicit none
   private

   public :: coulomb_variables, coulomb_walls

   real(wp), parameter :: right_angle = 90.0_wp

   !> A Coulomb joint
   type, extends(joint_law_t), public :: coulomb_law_t
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
   contains
      procedure, nopass :: variables
      procedure, nopass :: check
      procedure :: scale
      procedure :: lend
      procedure :: results
      procedure :: initial_aperture
      procedure :: update
      procedure :: tangent
      procedure :: closure_stress
      procedure :: closure
      procedure :: normal_stiffness
      procedure :: shear_stiffness
   end type coulomb_law_t

contains

   !> Walls that rub with an angle and have no cohesion, as stiff as what they were before.
   pure function coulomb_walls(friction_angle, stiffness) result(law)
      !> [deg], and stiffness in both directions [Pa/m]
      real(wp), intent(in) :: friction_angle, stiffness
      type(coulomb_law_t) :: law

      law = coulomb_law_t(friction_angle=friction_angle, cohesion=0.0_wp, kn=stiffness/megapascal_per_millimetre, &
                          ks=stiffness/megapascal_per_millimetre, a0=0.0_wp)
   end function coulomb_walls

   !> Variables of laws with constant friction angle.
   function coulomb_variables() result(variables)
      type(law_variable_t), allocatable :: variables(:)

      variables = [a_real('friction_angle', least=0.0_wp, below=right_angle, instead='phi_r'), &
                   a_real('cohesion', default=0.0_wp, least=0.0_wp, most=most_stress), &
                   a_real('kn_mpa_mm', least=least_stiffness, most=most_stiffness, &
                          instead='closure of eqs 5 to 7 at the mean length of the block edges'), &
                   a_real('ks_mpa_mm', least=least_stiffness, most=most_stiffness, &
                          instead='of the JCM at that length, up to its residual friction')]
   end function coulomb_variables

   !> Those, and the rough joint that it takes from what it isn't given.
   function variables()
      type(law_variable_t), allocatable :: variables(:)

      variables = [coulomb_variables(), jcm_variables()]
   end function variables

   !> It has what it needs, by itself or from a rough joint.
   subroutine check(settings, complaints)
      type(law_settings_t), intent(in) :: settings
      type(complaints_t), intent(inout) :: complaints
      character(len=*), parameter :: law = "law = 'coulomb'"

      if (.not. settings%has('phi_r')) call complaints%need(settings, 'friction_angle', law)
      if (has_roughness(settings)) then
         call check_initial_aperture(settings, complaints)
      else if (settings%word('normal') == 'joint') then
         call complaints%need(settings, 'kn_mpa_mm', law//" with normal = 'joint'")
         if (settings%word('friction') == 'slider') then
            call complaints%need(settings, 'ks_mpa_mm', law//" with friction = 'slider'")
         end if
      end if
      if (settings%word('closure_cycle') == 'hysteresis') then
         call complaints%error('closure_cycle', ": goes with law = 'jcm' and 'jcm_mean'; must be 1, 2 or 3 with "//law)
      end if
      if (.not. any(is_set([settings%number('jrc0'), settings%number('jcs0_mpa'), settings%number('sigma_c_mpa'), &
                            settings%number('l0'), settings%number('phi_r')]))) return
      if ((settings%has('friction_angle') .and. settings%has('kn_mpa_mm') .and. settings%has('ks_mpa_mm')) &
          .or. .not. has_roughness(settings)) call complaints%warning('', law//': the parameters of the JCM have no effect')
   end subroutine check

   !> The law; what it isn't given it takes from a rough joint of mean length.
   pure subroutine scale(self, settings, edge_length, mean_length)
      class(coulomb_law_t), intent(inout) :: self
      type(law_settings_t), intent(in) :: settings
      !> Length of the block edge, mean length of the group's block edges [m]
      real(wp), intent(in) :: edge_length, mean_length

      associate (no_matter => edge_length)
      end associate
      self%friction_angle = settings%number('friction_angle')
      if (.not. is_set(self%friction_angle)) self%friction_angle = settings%number('phi_r')
      self%cohesion = settings%number('cohesion')/megapascal
      self%kn = settings%number('kn_mpa_mm')
      self%ks = settings%number('ks_mpa_mm')
      self%a0 = settings%number('a0_mm')
      if (.not. is_set(self%a0)) self%a0 = 0.0_wp
      if (.not. has_roughness(settings)) return
      self%as_rough = .true.
      self%rough = jcm_scale(jcm_parameters_of(settings), mean_length)
      self%a0 = self%rough%a0
      if (is_set(self%kn)) return
      self%kn = self%rough%kn0
      self%vm = self%rough%vm
   end subroutine scale

   !> Without a stiffness of its own it has that of the penalty, which it then slides with too.
   pure subroutine lend(self, penalty)
      class(coulomb_law_t), intent(inout) :: self
      !> Penalty stiffness of its walls [MPa/mm]
      real(wp), intent(in) :: penalty

      if (.not. is_set(self%kn)) self%kn = penalty
   end subroutine lend

   !> Its values.
   pure function results(self) result(list)
      class(coulomb_law_t), intent(in) :: self
      type(law_result_t), allocatable :: list(:)

      list = [law_result_t('friction_angle_deg', 'degrees', 'friction angle of the law: the residual one of the JCM', &
                           self%friction_angle), &
              law_result_t('kn_MPa_mm', 'MPa/mm', 'normal stiffness of the walls, or the initial one where it grows with stress', &
                           self%kn), &
              law_result_t('cohesion_MPa', 'MPa', 'cohesion', self%cohesion), &
              law_result_t('ks_MPa_mm', 'MPa/mm', 'shear stiffness that the deck gives; 0 where it goes with the normal stress', &
                           max(self%ks, 0.0_wp))]
   end function results

   !> Initial aperture [mm].
   pure real(wp) function initial_aperture(self)
      class(coulomb_law_t), intent(in) :: self

      initial_aperture = self%a0
   end function initial_aperture

   !> Advance one joint element by a slip du to a new normal stress.
   pure subroutine update(self, du, sn, state, path)
      class(coulomb_law_t), intent(in) :: self
      !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
      real(wp), intent(in) :: du, sn
      type(joint_point_t), intent(inout) :: state
      !> It does not dilate: of no matter
      type(joint_slip_t), intent(in), optional :: path
      real(wp) :: trial, strength

      associate (no_matter => present(path))
      end associate
      state%step_u = du
      state%u = state%u + du
      state%u_max = max(state%u_max, abs(state%u))
      state%sn = max(sn, 0.0_wp)
      state%mu_mob = tan(radians*self%friction_angle)
      if (state%sn > 0.0_wp) then
         state%knn = self%normal_stiffness(state, state%sn)
         state%vn = self%closure(state, state%sn)
         state%ktt = self%shear_stiffness(state, state%sn)
         strength = self%cohesion + state%sn*state%mu_mob
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
   end subroutine update

   !> Tangent of the step that led to this state.
   pure function tangent(self, state, path)
      class(coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      type(joint_slip_t), intent(in), optional :: path
      type(joint_tangent_t) :: tangent

      associate (no_matter => present(path))
      end associate
      tangent%vn_sn = 1.0_wp/self%normal_stiffness(state, state%sn)
      if (state%sn <= 0.0_wp) return
      tangent%tau_u = state%ktt
      if (state%sliding) then
         tangent%tau_sn = sign(state%mu_mob, state%tau)
      else if (self%ks <= 0.0_wp .and. self%as_rough) then
         tangent%tau_sn = state%step_u*rough_stiffness_slope(self, state%sn)
      else if (self%ks <= 0.0_wp .and. self%vm > 0.0_wp) then
         ! d knn/d sn of eq 11
         tangent%tau_sn = state%step_u*2.0_wp*sqrt(state%knn/(self%kn*self%vm**2))
      end if
   end function tangent

   !> Change of the rough joint's shear stiffness with normal stress, by a central difference [1/mm].
   pure real(wp) function rough_stiffness_slope(joint, sn) result(slope)
      type(coulomb_law_t), intent(in) :: joint
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      !> Relative difference whose error, of rounding and of curvature, is least
      real(wp), parameter :: share = epsilon(1.0_wp)**(1.0_wp/3.0_wp)

      slope = (residual_shear_stiffness(joint%rough, sn*(1.0_wp + share)) &
               - residual_shear_stiffness(joint%rough, sn*(1.0_wp - share)))/(2.0_wp*share*sn)
   end function rough_stiffness_slope

   !> Normal stress of a closure [MPa]; none when the walls are apart.
   pure real(wp) function closure_stress(self, state, value)
      class(coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Closure [mm]
      real(wp), intent(in) :: value

      associate (no_matter => state)
      end associate
      if (self%vm > 0.0_wp) then
         closure_stress = hyperbola_stress(self%kn, self%vm, value)
      else
         closure_stress = self%kn*max(value, 0.0_wp)
      end if
   end function closure_stress

   !> Closure under a normal stress [mm], the inverse of closure_stress.
   pure real(wp) function closure(self, state, value)
      class(coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      associate (no_matter => state)
      end associate
      if (self%vm > 0.0_wp) then
         closure = hyperbola(self%kn, self%vm, value)
      else
         closure = max(value, 0.0_wp)/self%kn
      end if
   end function closure

   !> Normal stiffness [MPa/mm].
   pure real(wp) function normal_stiffness(self, state, value)
      class(coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      associate (no_matter => state)
      end associate
      normal_stiffness = self%kn
      if (self%vm > 0.0_wp) normal_stiffness = hyperbola_stiffness(self%kn, self%vm, value)
   end function normal_stiffness

   !> Elastic shear stiffness [MPa/mm].
   pure real(wp) function shear_stiffness(self, state, value)
      class(coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      shear_stiffness = self%ks
      if (self%ks > 0.0_wp) return
      if (self%as_rough) then
         shear_stiffness = residual_shear_stiffness(self%rough, value)
      else
         shear_stiffness = self%normal_stiffness(state, value)
      end if
   end function shear_stiffness

end module coulomb_law_m
