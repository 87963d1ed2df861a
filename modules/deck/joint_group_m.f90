!> The group &joint: the fractures of one physical curve of the mesh, and the law they follow.
module joint_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use bounds_m, only: least_wall, most_wall, least_sample, most_sample, least_angle, least_aperture, &
                       most_aperture, least_penalty, most_penalty, most_stress, least_stiffness, most_stiffness
   use errors_m, only: error_list_t
   use text_m, only: exact_text, quoted
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_name, a_number, an_option, name_length, option_length, namelist_text, &
                              require_clean_read, check_range, check_choice, check_given, &
                              check_needed, check_idle
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   public :: read_joint, write_joint, has_roughness

   !> Beyond these the unit must be wrong: JRC [-] (profiles reach 20), strength [MPa], laboratory sample [m]
   real(wp), parameter :: roughest = 30.0_wp
   real(wp), parameter :: right_angle = 90.0_wp

   !> &joint
   type, public :: joint_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical curve of the mesh
      character(len=name_length) :: group = ''
      !> Law of the joint: 'jcm_mean' has one JRC and JCS from the mean block-edge length
      character(len=option_length) :: law = 'jcm'
      !> JRC of the laboratory sample [-]
      real(wp) :: jrc0 = unset
      !> JCS of the laboratory sample [MPa]
      real(wp) :: jcs0_mpa = unset
      !> Uniaxial strength of the rock [MPa]; jcs0_mpa when not given
      real(wp) :: sigma_c_mpa = unset
      !> Length of the laboratory sample [m]
      real(wp) :: l0 = unset
      !> Residual friction angle [degrees]
      real(wp) :: phi_r = unset
      !> Initial aperture [mm]; eq 10 when not given
      real(wp) :: a0_mm = unset
      !> Equation of the peak displacement
      character(len=option_length) :: peak = 'eq15'
      !> Mobilised JRC after the peak: Table 1 or eq 16
      character(len=option_length) :: post_peak = 'table'
      !> Block edges shorter than l0: eqs 8 and 9 as they are, or the length taken as l0
      character(len=option_length) :: short_edges = 'extrapolate'
      !> Largest total friction angle [degrees]
      real(wp) :: max_angle = 70.0_wp
      !> Closure and dilation update the aperture only, or push the walls
      character(len=option_length) :: coupling = 'paper'
      !> Spring-slider, or eq 4 with the relative velocity
      character(len=option_length) :: friction = 'slider'
      !> Normal stiffness of the contact: the joint's own, or the penalty
      character(len=option_length) :: normal = 'joint'
      !> Force between the walls: wall contact, or Munjiza's potential (eq 3)
      character(len=option_length) :: contact = 'wall'
      !> Penalty [Pa]; penalty_factor times young of the wall rock when not given
      real(wp) :: penalty = unset
      !> Normal stress of the law: from the contact force, or from the walls' elements (eq 32)
      character(len=option_length) :: normal_stress = 'contact'
      !> Aperture of walls that part: with the dilation they keep, or eq 31 to the letter
      character(len=option_length) :: aperture = 'continuous'
      !> Friction angle of the Coulomb law [degrees]; phi_r when not given
      real(wp) :: friction_angle = unset
      !> Cohesion of the Coulomb law [Pa]
      real(wp) :: cohesion = 0.0_wp
      !> Normal stiffness of the Coulomb law [MPa/mm]; closure as in jcm_mean when not given
      real(wp) :: kn_mpa_mm = unset
      !> Shear stiffness of the Coulomb law [MPa/mm]; that of jcm_mean up to its residual friction when not given
      real(wp) :: ks_mpa_mm = unset
   end type joint_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('group', a_name), &
                                  variable_t('law', an_option), &
                                  variable_t('jrc0', a_number), &
                                  variable_t('jcs0_mpa', a_number), &
                                  variable_t('sigma_c_mpa', a_number), &
                                  variable_t('l0', a_number), &
                                  variable_t('phi_r', a_number), &
                                  variable_t('a0_mm', a_number), &
                                  variable_t('peak', an_option), &
                                  variable_t('post_peak', an_option), &
                                  variable_t('short_edges', an_option), &
                                  variable_t('max_angle', a_number), &
                                  variable_t('coupling', an_option), &
                                  variable_t('friction', an_option), &
                                  variable_t('normal', an_option), &
                                  variable_t('contact', an_option), &
                                  variable_t('penalty', a_number), &
                                  variable_t('normal_stress', an_option), &
                                  variable_t('aperture', an_option), &
                                  variable_t('friction_angle', a_number), &
                                  variable_t('cohesion', a_number), &
                                  variable_t('kn_mpa_mm', a_number), &
                                  variable_t('ks_mpa_mm', a_number)]
   character(len=*), parameter :: laws(*) = ['jcm     ', 'jcm_mean', 'coulomb ']
   character(len=*), parameter :: peaks(*) = ['eq15', 'eq14']
   character(len=*), parameter :: post_peaks(*) = ['table', 'eq16 ']
   character(len=*), parameter :: short_edge_rules(*) = ['extrapolate', 'l0         ']
   character(len=*), parameter :: couplings(*) = ['paper  ', 'coupled']
   character(len=*), parameter :: frictions(*) = ['slider  ', 'velocity']
   character(len=*), parameter :: normals(*) = ['joint  ', 'penalty']
   character(len=*), parameter :: contacts(*) = ['wall     ', 'potential']
   character(len=*), parameter :: normal_stresses(*) = ['contact', 'walls  ']
   character(len=*), parameter :: apertures(*) = ['continuous', 'eq31      ']

contains

   !> Read and check the group.
   subroutine read_joint(slice, joint, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(joint_t), intent(out) :: joint
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ joint

      joint%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_joint(slice, joint, errors)
      call check_law(slice, joint, errors)
      call check_aperture(slice, joint, errors)
   end subroutine read_joint

   !> Ranges and choices.
   subroutine check_joint(slice, joint, errors)
      type(group_slice_t), intent(in) :: slice
      type(joint_t), intent(inout) :: joint
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', joint%group, 'a physical curve of the mesh')
      call check_choice(errors, slice, 'law', joint%law, laws)
      call check_choice(errors, slice, 'peak', joint%peak, peaks)
      call check_choice(errors, slice, 'post_peak', joint%post_peak, post_peaks)
      call check_choice(errors, slice, 'short_edges', joint%short_edges, short_edge_rules)
      call check_choice(errors, slice, 'coupling', joint%coupling, couplings)
      call check_choice(errors, slice, 'friction', joint%friction, frictions)
      call check_choice(errors, slice, 'normal', joint%normal, normals)
      call check_choice(errors, slice, 'contact', joint%contact, contacts)
      call check_choice(errors, slice, 'normal_stress', joint%normal_stress, normal_stresses)
      call check_choice(errors, slice, 'aperture', joint%aperture, apertures)
      call check_range(errors, slice, 'jrc0', joint%jrc0, least=0.0_wp, most=roughest)
      call check_range(errors, slice, 'jcs0_mpa', joint%jcs0_mpa, least=least_wall, most=most_wall)
      call check_range(errors, slice, 'sigma_c_mpa', joint%sigma_c_mpa, least=least_wall, most=most_wall)
      call check_range(errors, slice, 'l0', joint%l0, least=least_sample, most=most_sample)
      call check_range(errors, slice, 'phi_r', joint%phi_r, least=least_angle, below=right_angle)
      call check_range(errors, slice, 'a0_mm', joint%a0_mm, least=least_aperture, most=most_aperture)
      call check_range(errors, slice, 'max_angle', joint%max_angle, least=least_angle, below=right_angle)
      call check_range(errors, slice, 'penalty', joint%penalty, least=least_penalty, most=most_penalty)
      call check_range(errors, slice, 'friction_angle', joint%friction_angle, least=0.0_wp, below=right_angle)
      call check_range(errors, slice, 'cohesion', joint%cohesion, least=0.0_wp, most=most_stress)
      call check_range(errors, slice, 'kn_mpa_mm', joint%kn_mpa_mm, least=least_stiffness, most=most_stiffness)
      call check_range(errors, slice, 'ks_mpa_mm', joint%ks_mpa_mm, least=least_stiffness, most=most_stiffness)
   end subroutine check_joint

   !> The law has the parameters it needs, and the contact chosen can give it its stresses.
   subroutine check_law(slice, joint, errors)
      type(group_slice_t), intent(in) :: slice
      type(joint_t), intent(in) :: joint
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: law

      law = 'law = '//quoted(joint%law)
      select case (joint%law)
      case ('jcm', 'jcm_mean')
         call check_needed(errors, slice, 'jrc0', joint%jrc0, law)
         call check_needed(errors, slice, 'jcs0_mpa', joint%jcs0_mpa, law)
         call check_needed(errors, slice, 'l0', joint%l0, law)
         call check_needed(errors, slice, 'phi_r', joint%phi_r, law)
      case ('coulomb')
         if (.not. is_set(joint%phi_r)) call check_needed(errors, slice, 'friction_angle', joint%friction_angle, law)
         if (joint%normal == 'joint' .and. .not. has_roughness(joint)) then
            call check_needed(errors, slice, 'kn_mpa_mm', joint%kn_mpa_mm, law//" with normal = 'joint'")
            if (joint%friction == 'slider') then
               call check_needed(errors, slice, 'ks_mpa_mm', joint%ks_mpa_mm, law//" with friction = 'slider'")
            end if
         end if
      end select
      if (joint%coupling == 'coupled' .and. joint%contact == 'potential') then
         call errors%add(slice%place('coupling')//" = 'coupled': dilation does not push the walls of contact = 'potential'; "// &
                         "must be 'paper', or contact = 'wall'")
      end if
      if (joint%normal == 'joint') then
         if (joint%contact == 'potential') then
            call errors%add(slice%place('contact')//": has a penalty only, not the stiffness of normal = 'joint'; "// &
                            "must be 'wall', or go with normal = 'penalty'")
         end if
         call check_idle(errors, slice, 'penalty', joint%penalty, "normal = 'penalty'")
      end if
   end subroutine check_law

   !> Are the parameters of the JCM there, from which stiffness and closure of a Coulomb joint can be had?
   pure logical function has_roughness(joint)
      type(joint_t), intent(in) :: joint

      has_roughness = all(is_set([joint%jrc0, joint%jcs0_mpa, joint%l0, joint%phi_r]))
   end function has_roughness

   !> The initial aperture of eq 10 must come out positive.
   subroutine check_aperture(slice, joint, errors)
      type(group_slice_t), intent(in) :: slice
      type(joint_t), intent(in) :: joint
      type(error_list_t), intent(inout) :: errors

      if ((joint%law == 'coulomb' .and. .not. has_roughness(joint)) .or. is_set(joint%a0_mm)) return
      if (is_set(joint%jrc0) .and. abs(joint%jrc0) <= 0) then
         call errors%add(slice%place('jrc0')//': eq 10 gives no initial aperture; must be above 0, or a0_mm be given')
      end if
      if (.not. (is_set(joint%sigma_c_mpa) .and. is_set(joint%jcs0_mpa))) return
      ! Eq 10: a0 = JRC0/5 (0.2 sc/JCS0 - 0.1)
      if (joint%jcs0_mpa >= 2*joint%sigma_c_mpa) then
         call errors%add(slice%place('sigma_c_mpa')//': eq 10 gives no initial aperture; must be above '// &
                         'half of jcs0_mpa ('//exact_text(joint%jcs0_mpa/2)//'), or a0_mm be given')
      end if
   end subroutine check_aperture

   !> Write the effective group, every variable.
   subroutine write_joint(joint, unit)
      type(joint_t), intent(in) :: joint
      integer, intent(in) :: unit

      call begin_group(unit, 'joint')
      call put(unit, 'group', joint%group)
      call put(unit, 'law', joint%law)
      call put(unit, 'jrc0', joint%jrc0)
      call put(unit, 'jcs0_mpa', joint%jcs0_mpa)
      call put(unit, 'sigma_c_mpa', joint%sigma_c_mpa, 'jcs0_mpa')
      call put(unit, 'l0', joint%l0)
      call put(unit, 'phi_r', joint%phi_r)
      call put(unit, 'a0_mm', joint%a0_mm, 'from jrc0, jcs0_mpa and sigma_c_mpa by eq 10')
      call put(unit, 'peak', joint%peak)
      call put(unit, 'post_peak', joint%post_peak)
      call put(unit, 'short_edges', joint%short_edges)
      call put(unit, 'max_angle', joint%max_angle)
      call put(unit, 'coupling', joint%coupling)
      call put(unit, 'friction', joint%friction)
      call put(unit, 'normal', joint%normal)
      call put(unit, 'contact', joint%contact)
      call put(unit, 'penalty', joint%penalty, 'penalty_factor times young of the wall rock')
      call put(unit, 'normal_stress', joint%normal_stress)
      call put(unit, 'aperture', joint%aperture)
      call put(unit, 'friction_angle', joint%friction_angle, 'phi_r')
      call put(unit, 'cohesion', joint%cohesion)
      call put(unit, 'kn_mpa_mm', joint%kn_mpa_mm, 'closure of eqs 5 to 7 at the mean length of the block edges')
      call put(unit, 'ks_mpa_mm', joint%ks_mpa_mm, 'of the JCM at that length, up to its residual friction')
      call end_group(unit)
   end subroutine write_joint

end module joint_group_m
