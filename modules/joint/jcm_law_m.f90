!> The JCM as a joint law (jcm_m has its equations), with the scaling to each block edge's length, or to their mean length.
module jcm_law_m
   use kinds_m, only: wp
   use bounds_m, only: least_wall, most_wall, least_sample, most_sample, least_angle, least_aperture, most_aperture
   use constants_m, only: is_set
   use jcm_scale_m, only: jcm_parameters_t, jcm_edge_t, jcm_option, jcm_scale
   use jcm_dilation_m, only: jcm_dilation
   use jcm_m, only: jcm_update, jcm_tangent, jcm_retrace
   use jcm_closure_m, only: path_stress, path_closure, path_stiffness, last_cycle
   use jcm_scale_m, only: closure_hysteresis, peak_displacement
   use jcm_strength_m, only: elastic_shear_stiffness, mobilised_ratio
   use jcm_closure_m, only: hyperbola => closure, hyperbola_stress => closure_stress, hyperbola_stiffness => normal_stiffness
   use joint_law_m, only: joint_law_t, law_result_t, guard_t
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t, joint_dilation_t
   use law_variable_m, only: law_variable_t, law_settings_t, complaints_t, a_real, a_choice
   use text_m, only: exact_text
   implicit none
   private

   public :: jcm_variables, jcm_parameters_of, has_roughness, check_initial_aperture

   !> Beyond this it cannot be a JRC [-]: profiles reach 20
   real(wp), parameter :: roughest = 30.0_wp
   real(wp), parameter :: right_angle = 90.0_wp

   !> The JCM at the scale of a block edge
   type, extends(joint_law_t), public :: jcm_law_t
      type(jcm_edge_t) :: edge
   contains
      procedure, nopass :: variables => jcm_variables
      procedure, nopass :: check
      procedure :: scale
      procedure :: guards
      procedure :: own_closure
      procedure :: results
      procedure :: initial_aperture
      procedure :: update
      procedure :: tangent
      procedure :: riding_slip
      procedure :: dilation
      procedure :: retrace
      procedure :: closure_stress
      procedure :: closure
      procedure :: normal_stiffness
      procedure :: shear_stiffness
      procedure :: mobilised_roughness
      procedure :: slip_of_peak
   end type jcm_law_t

   !> The same on edges that are all scaled to their mean length (the paper's Model-I)
   type, extends(jcm_law_t), public :: jcm_mean_law_t
   contains
      procedure :: scale => scale_to_mean
   end type jcm_mean_law_t

contains

   ! ---- From the deck ----------------------------------------------------------------------------------------------

   !> Variables of a rough joint.
   function jcm_variables() result(variables)
      type(law_variable_t), allocatable :: variables(:)

      variables = [a_real('jrc0', least=0.0_wp, most=roughest), &
                   a_real('jcs0_mpa', least=least_wall, most=most_wall), &
                   a_real('sigma_c_mpa', least=least_wall, most=most_wall, instead='jcs0_mpa'), &
                   a_real('l0', least=least_sample, most=most_sample), &
                   a_real('phi_r', least=least_angle, below=right_angle), &
                   a_real('a0_mm', least=least_aperture, most=most_aperture, &
                          instead='from jrc0, jcs0_mpa and sigma_c_mpa by eq 10'), &
                   a_choice('peak', 'eq15 eq14'), &
                   a_choice('post_peak', 'table eq16'), &
                   a_choice('short_edges', 'extrapolate l0'), &
                   a_choice('closure_cycle', '3 1 2 hysteresis'), &
                   a_choice('reversal', 'symmetric barton'), &
                   a_real('max_angle', default=70.0_wp, least=least_angle, below=right_angle)]
   end function jcm_variables

   !> It has what it needs.
   subroutine check(settings, complaints)
      type(law_settings_t), intent(in) :: settings
      type(complaints_t), intent(inout) :: complaints
      character(len=:), allocatable :: law

      law = 'law = '''//trim(settings%word('law'))//''''
      call complaints%need(settings, 'jrc0', law)
      call complaints%need(settings, 'jcs0_mpa', law)
      call complaints%need(settings, 'l0', law)
      call complaints%need(settings, 'phi_r', law)
      call check_initial_aperture(settings, complaints)
   end subroutine check

   !> Are the parameters there that make a joint rough?
   pure logical function has_roughness(settings)
      type(law_settings_t), intent(in) :: settings

      has_roughness = settings%has('jrc0') .and. settings%has('jcs0_mpa') .and. settings%has('l0') .and. settings%has('phi_r')
   end function has_roughness

   !> The initial aperture of eq 10 must come out positive; roughness and strength within what the law was fitted to.
   subroutine check_initial_aperture(settings, complaints)
      type(law_settings_t), intent(in) :: settings
      type(complaints_t), intent(inout) :: complaints
      !> Roughest standard profile
      real(wp), parameter :: roughest_profile = 20.0_wp
      real(wp) :: jrc0, jcs0, sigma_c

      jrc0 = settings%number('jrc0')
      jcs0 = settings%number('jcs0_mpa')
      sigma_c = settings%number('sigma_c_mpa')
      if (jrc0 > roughest_profile) call complaints%warning('jrc0', ': standard profiles end at 20')
      if (is_set(sigma_c) .and. jcs0 > sigma_c) then
         call complaints%warning('jcs0_mpa', ': walls stronger than the rock, sigma_c_mpa = '//exact_text(sigma_c))
      end if
      if (settings%has('a0_mm')) return
      if (is_set(jrc0) .and. abs(jrc0) <= 0.0_wp) then
         call complaints%error('jrc0', ': eq 10 gives no initial aperture; must be above 0, or a0_mm be given')
      end if
      if (.not. (is_set(sigma_c) .and. is_set(jcs0))) return
      ! Eq 10: a0 = JRC0/5 (0.2 sc/JCS0 - 0.1)
      if (jcs0 >= 2.0_wp*sigma_c) then
         call complaints%error('sigma_c_mpa', ': eq 10 gives no initial aperture; must be above half of jcs0_mpa ('// &
                               exact_text(0.5_wp*jcs0)//'), or a0_mm be given')
      end if
   end subroutine check_initial_aperture

   !> The joint as measured, from the settings.
   pure function jcm_parameters_of(settings) result(parameters)
      type(law_settings_t), intent(in) :: settings
      type(jcm_parameters_t) :: parameters

      parameters = jcm_parameters_t(jrc0=settings%number('jrc0'), jcs0=settings%number('jcs0_mpa'), &
                                    sigma_c=settings%number('sigma_c_mpa'), l0=settings%number('l0'), &
                                    phi_r=settings%number('phi_r'), a0=settings%number('a0_mm'), &
                                    peak=jcm_option(settings%word('peak')), &
                                    post_peak=jcm_option(settings%word('post_peak')), &
                                    short_edges=jcm_option(settings%word('short_edges')), &
                                    reversal=jcm_option(settings%word('reversal')), &
                                    closure_cycle=cycle_of(settings%word('closure_cycle')), &
                                    max_angle=settings%number('max_angle'))
   end function jcm_parameters_of

   !> The loading cycle a deck word means.
   pure integer function cycle_of(word)
      character(len=*), intent(in) :: word

      select case (word)
      case ('1')
         cycle_of = 1
      case ('2')
         cycle_of = 2
      case ('hysteresis')
         cycle_of = closure_hysteresis
      case default
         cycle_of = last_cycle
      end select
   end function cycle_of

   !> At the scale of its block edge.
   pure subroutine scale(self, settings, edge_length, mean_length)
      class(jcm_law_t), intent(inout) :: self
      type(law_settings_t), intent(in) :: settings
      !> Length of the block edge, mean length of the group's block edges [m]
      real(wp), intent(in) :: edge_length, mean_length

      associate (no_matter => mean_length)
      end associate
      self%edge = jcm_scale(jcm_parameters_of(settings), edge_length)
   end subroutine scale

   !> At the scale of the mean block edge.
   pure subroutine scale_to_mean(self, settings, edge_length, mean_length)
      class(jcm_mean_law_t), intent(inout) :: self
      type(law_settings_t), intent(in) :: settings
      !> Length of the block edge, mean length of the group's block edges [m]
      real(wp), intent(in) :: edge_length, mean_length

      associate (no_matter => edge_length)
      end associate
      self%edge = jcm_scale(jcm_parameters_of(settings), mean_length)
   end subroutine scale_to_mean

   ! ---- What it says of itself -------------------------------------------------------------------------------------

   !> Where its fits end.
   pure function guards(self)
      class(jcm_law_t), intent(in) :: self
      type(guard_t), allocatable :: guards(:)

      guards = [guard_t('lie on block edges shorter than l0: eqs 8 and 9 extrapolate JRC and JCS above their laboratory values '// &
                        '(short_edges = ''l0'' keeps them)', self%edge%extrapolated), &
                guard_t('have a maximum closure (eq 7) that is negative or tiny: raised to a small share of the aperture', &
                        self%edge%vm_clamped), &
                guard_t('have an initial stiffness (eq 6) that is negative or tiny: raised to its floor', self%edge%kn0_clamped), &
                guard_t('have an initial aperture that is tiny: raised to its floor', self%edge%a0_clamped)]
   end function guards

   !> Its maximum closure [mm].
   pure real(wp) function own_closure(self) result(largest)
      class(jcm_law_t), intent(in) :: self

      largest = self%edge%vm
      if (self%edge%hysteretic) largest = maxval(self%edge%curves%vm)
   end function own_closure

   !> Its values.
   pure function results(self) result(list)
      class(jcm_law_t), intent(in) :: self
      type(law_result_t), allocatable :: list(:)

      list = [law_result_t('effective_length', 'm', '', self%edge%ln), &
              law_result_t('jrcn', '-', 'joint roughness coefficient at the scale of the block edge (eq 8)', self%edge%jrcn), &
              law_result_t('jcsn_MPa', 'MPa', 'joint wall strength at the scale of the block edge (eq 9)', self%edge%jcsn), &
              law_result_t('friction_angle_deg', 'degrees', 'friction angle of the law: the residual one of the JCM', &
                           self%edge%phi_r), &
              law_result_t('kn_MPa_mm', 'MPa/mm', 'normal stiffness of the walls, or the initial one where it grows with stress', &
                           self%edge%kn0)]
   end function results

   !> Initial aperture [mm].
   pure real(wp) function initial_aperture(self)
      class(jcm_law_t), intent(in) :: self

      initial_aperture = self%edge%a0
   end function initial_aperture

   ! ---- In every step ----------------------------------------------------------------------------------------------

   !> Advance one joint element by a slip du to a new normal stress.
   pure subroutine update(self, du, sn, state, path)
      class(jcm_law_t), intent(in) :: self
      !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
      real(wp), intent(in) :: du, sn
      type(joint_point_t), intent(inout) :: state
      !> Stresses under which walls that ride on their asperities slip; the end's when not given
      type(joint_slip_t), intent(in), optional :: path

      call jcm_update(self%edge, du, sn, state, path)
   end subroutine update

   !> Tangent of the step that led to this state.
   pure function tangent(self, state, path)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> As for the update
      type(joint_slip_t), intent(in), optional :: path
      type(joint_tangent_t) :: tangent

      tangent = jcm_tangent(self%edge, state, path)
   end function tangent

   !> Slip beyond u_max rides.
   pure subroutine riding_slip(self, state, du, slip, rides)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Slip of the step, and of it what lies beyond u_max [mm]
      real(wp), intent(in) :: du
      real(wp), intent(out) :: slip
      logical, intent(out) :: rides
      !> A joint this near to u_max goes on, as far as derivatives are concerned [mm]: increments start there, most on their way
      !> out, and the slope by which walls go back is another
      real(wp), parameter :: at_end = 1.0e-12_wp

      associate (no_matter => self)
      end associate
      slip = sign(max(0.0_wp, abs(state%u + du) - state%u_max), state%u + du)
      rides = abs(state%u + du) >= state%u_max - at_end
   end subroutine riding_slip

   !> Dilation of a slip beyond u_max at a normal stress.
   pure function dilation(self, state, slip, sn)
      class(jcm_law_t), intent(in) :: self
      !> State at the start of the slip
      type(joint_point_t), intent(in) :: state
      !> Slip beyond u_max [mm], normal stress [MPa]
      real(wp), intent(in) :: slip, sn
      type(joint_dilation_t) :: dilation

      dilation = jcm_dilation(self%edge, state, abs(slip), sn)
   end function dilation

   !> Dilation [mm] of a joint whose |u| is at most u_max, or that slips on without contact, and its slope [-].
   pure subroutine retrace(self, state, u, dilation, slope)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Shear displacement [mm]
      real(wp), intent(in) :: u
      real(wp), intent(out) :: dilation, slope

      call jcm_retrace(self%edge, state, u, dilation, slope)
   end subroutine retrace

   !> Normal stress of a closure [MPa], eq 5a.
   pure real(wp) function closure_stress(self, state, value)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Closure [mm]
      real(wp), intent(in) :: value

      if (self%edge%hysteretic) then
         closure_stress = path_stress(self%edge%curves, state%memory, value)
      else
         closure_stress = hyperbola_stress(self%edge%kn0, self%edge%vm, value)
      end if
   end function closure_stress

   !> Closure under a normal stress [mm], eq 5b.
   pure real(wp) function closure(self, state, value)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      if (self%edge%hysteretic) then
         closure = path_closure(self%edge%curves, state%memory, value)
      else
         closure = hyperbola(self%edge%kn0, self%edge%vm, value)
      end if
   end function closure

   !> Normal stiffness at a normal stress [MPa/mm], eq 11.
   pure real(wp) function normal_stiffness(self, state, value)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      if (self%edge%hysteretic) then
         normal_stiffness = path_stiffness(self%edge%curves, state%memory, value)
      else
         normal_stiffness = hyperbola_stiffness(self%edge%kn0, self%edge%vm, value)
      end if
   end function normal_stiffness

   !> Elastic shear stiffness at a normal stress [MPa/mm].
   pure real(wp) function shear_stiffness(self, state, value)
      class(jcm_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Normal stress [MPa]
      real(wp), intent(in) :: value

      associate (no_matter => state)
      end associate
      shear_stiffness = elastic_shear_stiffness(self%edge, value)
   end function shear_stiffness

   !> JRC that a slip has mobilised [-]: Table 1 times JRCn.
   pure real(wp) function mobilised_roughness(self, ratio, sn)
      class(jcm_law_t), intent(in) :: self
      !> Slip over that of the peak [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      mobilised_roughness = self%edge%jrcn*mobilised_ratio(self%edge, ratio, max(sn, 0.0_wp))
   end function mobilised_roughness

   !> Slip at the peak [mm], eq 14 or 15.
   pure real(wp) function slip_of_peak(self, sn)
      class(jcm_law_t), intent(in) :: self
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      slip_of_peak = peak_displacement(self%edge, max(sn, 0.0_wp))
   end function slip_of_peak

end module jcm_law_m
