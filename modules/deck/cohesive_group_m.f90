!> The group &cohesive: where and how the rock of one physical surface of the mesh can break.
module cohesive_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set, radians
   use bounds_m, only: most_stress, least_energy, most_energy, &
                       least_factor, most_factor, least_part
   use errors_m, only: error_list_t
   use text_m, only: exact_text
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, option_length, check_range, check_least, check_choice, check_given
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_cohesive, write_cohesive

   real(wp), parameter :: right_angle = 90.0_wp
   !> Group that stands for all rock
   character(len=*), parameter, public :: all_rock = 'all'

   !> &cohesive
   type, public :: cohesive_group_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical surface of the mesh, or 'all'
      character(len=name_length) :: group = ''
      !> Physical curve that cracks keep to; empty: anywhere in the group
      character(len=name_length) :: curve = ''
      !> When edges become cohesive joints: never, where the stress asks for it, or all of them from the start, in this
      !> surface ('regions') or wherever rock is ('everywhere')
      character(len=option_length) :: insertion = 'adaptive'
      !> Tensile strength [Pa]
      real(wp) :: tensile_strength = unset
      !> Cohesion [Pa] and internal friction angle [degrees]
      real(wp) :: cohesion = unset, friction_angle = unset
      !> Fracture energy in mode I and in mode II [J/m2]
      real(wp) :: g_i = unset, g_ii = unset
      !> Stiffness of the cohesive joints times element size over Young's modulus [-]
      real(wp) :: penalty_factor = 20.0_wp
      !> Friction angle of the new cracks [degrees]; friction_angle when not given
      real(wp) :: crack_friction_angle = unset
      !> Fracture group whose &joint gives the law of new cracks; empty: Coulomb friction with crack_friction_angle
      character(len=name_length) :: crack_joint = ''
      !> Part of the strength at which an edge is cut (adaptive)
      real(wp) :: insertion_level = 0.7_wp
      !> Steps between two looks at the stress (adaptive)
      integer :: check_every = 10
   end type cohesive_group_t

   character(len=*), parameter :: insertions(*) = ['none      ', 'regions   ', 'adaptive  ', 'everywhere']

contains

   !> Read and check the group.
   subroutine read_cohesive(slice, cohesive, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(cohesive_group_t), intent(out) :: cohesive
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      cohesive%line = slice%line
      call variables%read(slice)
      call name_variables(variables, cohesive)
      call variables%end_reading(errors)
      call check_cohesive(slice, cohesive, errors)
   end subroutine read_cohesive

   !> The variables, for reading and writing.
   subroutine name_variables(variables, cohesive)
      type(group_variables_t), intent(inout) :: variables
      type(cohesive_group_t), intent(inout) :: cohesive

      call variables%keep('group', cohesive%group)
      call variables%keep('curve', cohesive%curve)
      call variables%keep('insertion', cohesive%insertion)
      call variables%keep('tensile_strength', cohesive%tensile_strength)
      call variables%keep('cohesion', cohesive%cohesion)
      call variables%keep('friction_angle', cohesive%friction_angle)
      call variables%keep('g_i', cohesive%g_i)
      call variables%keep('g_ii', cohesive%g_ii)
      call variables%keep('penalty_factor', cohesive%penalty_factor)
      call variables%keep('crack_friction_angle', cohesive%crack_friction_angle)
      call variables%keep('crack_joint', cohesive%crack_joint)
      call variables%keep('insertion_level', cohesive%insertion_level)
      call variables%keep('check_every', cohesive%check_every)
   end subroutine name_variables

   !> Ranges and choices.
   subroutine check_cohesive(slice, cohesive, errors)
      type(group_slice_t), intent(in) :: slice
      type(cohesive_group_t), intent(inout) :: cohesive
      type(error_list_t), intent(inout) :: errors

      call check_given(errors, slice, 'group', cohesive%group, "a physical surface of the mesh or 'all'")
      call check_choice(errors, slice, 'insertion', cohesive%insertion, insertions)
      call check_range(errors, slice, 'tensile_strength', cohesive%tensile_strength, least=1.0_wp, most=most_stress, &
                       required=.true.)
      call check_range(errors, slice, 'cohesion', cohesive%cohesion, least=1.0_wp, most=most_stress, required=.true.)
      call check_range(errors, slice, 'friction_angle', cohesive%friction_angle, least=0.0_wp, below=right_angle, &
                       required=.true.)
      call check_range(errors, slice, 'g_i', cohesive%g_i, least=least_energy, most=most_energy, required=.true.)
      call check_range(errors, slice, 'g_ii', cohesive%g_ii, least=least_energy, most=most_energy, required=.true.)
      call check_range(errors, slice, 'penalty_factor', cohesive%penalty_factor, least=least_factor, most=most_factor)
      call check_range(errors, slice, 'crack_friction_angle', cohesive%crack_friction_angle, least=0.0_wp, below=right_angle)
      call check_range(errors, slice, 'insertion_level', cohesive%insertion_level, least=least_part, most=1.0_wp)
      call check_least(errors, slice, 'check_every', cohesive%check_every, 1)
      call check_cut_off(slice, cohesive, errors)
      if (.not. is_set(cohesive%crack_friction_angle)) cohesive%crack_friction_angle = cohesive%friction_angle
   end subroutine check_cohesive

   !> The tension cut-off must lie below the tip of the Mohr-Coulomb cone.
   subroutine check_cut_off(slice, cohesive, errors)
      type(group_slice_t), intent(in) :: slice
      type(cohesive_group_t), intent(in) :: cohesive
      type(error_list_t), intent(inout) :: errors
      real(wp) :: slope

      if (.not. all(is_set([cohesive%tensile_strength, cohesive%cohesion, cohesive%friction_angle]))) return
      if (cohesive%friction_angle <= 0.0_wp .or. cohesive%friction_angle >= right_angle) return
      slope = tan(radians*cohesive%friction_angle)
      if (cohesive%tensile_strength*slope <= cohesive%cohesion) return
      call errors%add(slice%place('tensile_strength')//': must be at most cohesion/tan(friction_angle) = '// &
                      exact_text(cohesive%cohesion/slope)//', the tip of the cone')
   end subroutine check_cut_off

   !> Write the effective group, every variable.
   subroutine write_cohesive(cohesive, unit)
      type(cohesive_group_t), intent(in) :: cohesive
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(cohesive_group_t) :: effective

      effective = cohesive
      call variables%write(unit, 'cohesive')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_cohesive

end module cohesive_group_m
