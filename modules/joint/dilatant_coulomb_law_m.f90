!> A Coulomb joint that dilates at a constant angle: elastic below its strength, and where it slides it rides up by the
!> tangent of the dilation angle; sliding back it comes down again by the same. Units: MPa, mm, degrees.
!>
!>     tau <= c + sn tan(phi),   d dilation = tan(psi) d|p|,   p the slip less its elastic part, tau/ks
module dilatant_coulomb_law_m
   use bounds_m, only: least_aperture, most_aperture
   use kinds_m, only: wp
   use bounds_m, only: least_aperture, most_aperture
   use constants_m, only: radians
   use units_m, only: megapascal
   use joint_law_m, only: joint_law_t, law_result_t
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t, joint_dilation_t
   use law_variable_m, only: law_variable_t, law_settings_t, complaints_t, a_real
   use coulomb_law_m, only: coulomb_variables
   implicit none
   private

   real(wp), parameter :: right_angle = 90.0_wp
   !> The slip less its elastic part [mm]: its place in the law's own memory
   integer, parameter :: slid = 1

   !> A dilatant Coulomb joint
   type, extends(joint_law_t), public :: dilatant_coulomb_law_t
      !> Friction and dilation angle [deg], cohesion [MPa]
      real(wp) :: friction_angle = 30.0_wp, dilation_angle = 0.0_wp, cohesion = 0.0_wp
      !> Normal and shear stiffness [MPa/mm]; initial aperture [mm]
      real(wp) :: kn = 1.0_wp, ks = 1.0_wp, a0 = 0.0_wp
   contains
      procedure, nopass :: variables
      procedure, nopass :: check
      procedure :: scale
      procedure :: results
      procedure :: initial_aperture
      procedure :: update
      procedure :: tangent
      procedure :: riding_slip
      procedure :: end_share
      procedure :: dilation
      procedure :: closure_stress
      procedure :: closure
      procedure :: normal_stiffness
      procedure :: shear_stiffness
   end type dilatant_coulomb_law_t

contains

   !> Those of the Coulomb law, its dilation, its aperture.
   function variables()
      type(law_variable_t), allocatable :: variables(:)

      variables = [coulomb_variables(), &
                   a_real('dilation_angle', default=0.0_wp, least=0.0_wp, below=right_angle), &
                   a_real('a0_mm', least=least_aperture, most=most_aperture, &
                          instead='from jrc0, jcs0_mpa and sigma_c_mpa by eq 10')]
   end function variables

   !> It has what it needs; asperities steeper than friction would push themselves apart.
   subroutine check(settings, complaints)
      type(law_settings_t), intent(in) :: settings
      type(complaints_t), intent(inout) :: complaints
      character(len=*), parameter :: law = "law = 'dilatant_coulomb'"

      call complaints%need(settings, 'friction_angle', law)
      call complaints%need(settings, 'kn_mpa_mm', law)
      call complaints%need(settings, 'ks_mpa_mm', law)
      if (.not. settings%has('friction_angle')) return
      if (settings%number('dilation_angle') > settings%number('friction_angle')) then
         call complaints%error('dilation_angle', ': must be at most friction_angle: sliding would give out energy')
      end if
   end subroutine check

   !> The law: the same on block edges of any length.
   pure subroutine scale(self, settings, edge_length, mean_length)
      class(dilatant_coulomb_law_t), intent(inout) :: self
      type(law_settings_t), intent(in) :: settings
      real(wp), intent(in) :: edge_length, mean_length

      associate (no_matter => edge_length, nor => mean_length)
      end associate
      self%friction_angle = settings%number('friction_angle')
      self%dilation_angle = settings%number('dilation_angle')
      self%cohesion = settings%number('cohesion')/megapascal
      self%kn = settings%number('kn_mpa_mm')
      self%ks = settings%number('ks_mpa_mm')
      if (settings%has('a0_mm')) self%a0 = settings%number('a0_mm')
   end subroutine scale

   !> Its values.
   pure function results(self) result(list)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(law_result_t), allocatable :: list(:)

      list = [law_result_t('friction_angle_deg', 'degrees', 'friction angle of the law: the residual one of the JCM', &
                           self%friction_angle), &
              law_result_t('dilation_angle_deg', 'degrees', 'constant dilation angle', self%dilation_angle), &
              law_result_t('kn_MPa_mm', 'MPa/mm', 'normal stiffness of the walls, or the initial one where it grows with stress', &
                           self%kn), &
              law_result_t('cohesion_MPa', 'MPa', 'cohesion', self%cohesion), &
              law_result_t('ks_MPa_mm', 'MPa/mm', 'shear stiffness that the deck gives; 0 where it goes with the normal stress', &
                           self%ks)]
   end function results

   !> Initial aperture [mm].
   pure real(wp) function initial_aperture(self)
      class(dilatant_coulomb_law_t), intent(in) :: self

      initial_aperture = self%a0
   end function initial_aperture

   !> Advance one joint element by a slip du to a new normal stress.
   pure subroutine update(self, du, sn, state, path)
      class(dilatant_coulomb_law_t), intent(in) :: self
      !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
      real(wp), intent(in) :: du, sn
      type(joint_point_t), intent(inout) :: state
      !> Dilation that walls which ride have found
      type(joint_slip_t), intent(in), optional :: path
      real(wp) :: trial, strength

      trial = state%tau + self%ks*du
      state%mu_mob = tan(radians*self%friction_angle)
      state%step_u = du
      state%u = state%u + du
      state%u_max = max(state%u_max, abs(state%u))
      state%sn = max(sn, 0.0_wp)
      state%vn = state%sn/self%kn
      strength = self%cohesion + state%sn*state%mu_mob
      state%sliding = abs(trial) >= strength .or. sn <= 0.0_wp
      state%dilation_slope = 0.0_wp
      if (sn > 0.0_wp) then
         state%knn = self%kn
         state%ktt = merge(0.0_wp, self%ks, state%sliding)
         state%tau = sign(min(abs(trial), strength), trial)
         state%memory(slid) = state%memory(slid) + (trial - state%tau)/self%ks
         if (state%sliding) state%dilation_slope = sign(tan(radians*self%dilation_angle), state%memory(slid))
         state%dilation = merge(state%dilation, tan(radians*self%dilation_angle)*abs(state%memory(slid)), present(path))
      else
         state%knn = 0.0_wp
         state%ktt = 0.0_wp
         state%tau = 0.0_wp
      end if
      if (present(path)) state%dilation = state%dilation + path%dilation
      state%v = state%vn - state%dilation
   end subroutine update

   !> Tangent of the step that led to this state.
   pure function tangent(self, state, path)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      type(joint_slip_t), intent(in), optional :: path
      type(joint_tangent_t) :: tangent

      associate (no_matter => present(path))
      end associate
      tangent%vn_sn = 1.0_wp/self%kn
      tangent%dilation_u = state%dilation_slope
      if (state%sn <= 0.0_wp) return
      tangent%tau_u = state%ktt
      if (state%sliding) tangent%tau_sn = sign(state%mu_mob, state%tau)
   end function tangent

   !> All of a slip may ride: where it slides the dilation follows from the normal stress.
   pure subroutine riding_slip(self, state, du, slip, rides)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Slip of the step, and of it what rides [mm]
      real(wp), intent(in) :: du
      real(wp), intent(out) :: slip
      logical, intent(out) :: rides

      associate (no_matter => self, nor => state)
      end associate
      slip = du
      rides = .true.
   end subroutine riding_slip

   !> Its slider is at the strength of the end of a step, and so is what it dilates.
   pure real(wp) function end_share(self)
      class(dilatant_coulomb_law_t), intent(in) :: self

      associate (no_matter => self)
      end associate
      end_share = 1.0_wp
   end function end_share

   !> Dilation of a slip at a normal stress: on the way out it expands, on the way back it contracts.
   pure function dilation(self, state, slip, sn)
      class(dilatant_coulomb_law_t), intent(in) :: self
      !> State at the start of the slip
      type(joint_point_t), intent(in) :: state
      !> Slip [mm], normal stress [MPa]
      real(wp), intent(in) :: slip, sn
      type(joint_dilation_t) :: dilation
      real(wp) :: trial, excess, steepness, after, change, by_slip, by_stress

      steepness = tan(radians*self%dilation_angle)
      trial = state%tau + self%ks*slip
      excess = max(0.0_wp, abs(trial) - self%cohesion - max(sn, 0.0_wp)*tan(radians*self%friction_angle))
      after = state%memory(slid) + sign(excess/self%ks, trial)
      change = steepness*abs(after) - state%dilation
      by_slip = 0.0_wp
      by_stress = 0.0_wp
      if (excess > 0.0_wp) then
         by_slip = sign(1.0_wp, slip)*sign(steepness, after)
         by_stress = -sign(1.0_wp, trial)*sign(steepness, after)*tan(radians*self%friction_angle)/self%ks
      end if
      if (change < 0.0_wp) then
         dilation%contraction = change
         dilation%contraction_u = by_slip
         dilation%contraction_sn = by_stress
      else
         dilation%expansion = change
         dilation%expansion_u = by_slip
         dilation%expansion_sn = by_stress
      end if
   end function dilation

   !> Normal stress of a closure [MPa]; none when the walls are apart.
   pure real(wp) function closure_stress(self, state, value)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Closure [mm]
      real(wp), intent(in) :: value

      associate (no_matter => state)
      end associate
      closure_stress = self%kn*max(value, 0.0_wp)
   end function closure_stress

   !> Closure under a normal stress [mm].
   pure real(wp) function closure(self, state, value)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      associate (no_matter => state)
      end associate
      closure = max(value, 0.0_wp)/self%kn
   end function closure

   !> Normal stiffness [MPa/mm].
   pure real(wp) function normal_stiffness(self, state, value)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      associate (no_matter => state, nor => value)
      end associate
      normal_stiffness = self%kn
   end function normal_stiffness

   !> Elastic shear stiffness [MPa/mm].
   pure real(wp) function shear_stiffness(self, state, value)
      class(dilatant_coulomb_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      associate (no_matter => state, nor => value)
      end associate
      shear_stiffness = self%ks
   end function shear_stiffness

end module dilatant_coulomb_law_m
