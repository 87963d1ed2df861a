!> The group &explicit: step, damping and mass scaling of the explicit solver.
module explicit_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use bounds_m, only: least_part, most_factor, least_step, most_time
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: option_length, check_range, check_choice, check_needed, check_idle
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_explicit, write_explicit

   !> Damping factors when none is given: the viscosity 2 h sqrt(E rho), and the share of Cundall's local damping
   real(wp), parameter :: critical = 1.0_wp, usual_local = 0.8_wp

   !> &explicit
   type, public :: explicit_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Kind of damping
      character(len=option_length) :: damping = 'none'
      !> Strength of the damping [-]
      real(wp) :: damping_factor = unset
      !> Step over the stable step [-]
      real(wp) :: safety = 0.9_wp
      !> Time step [s]
      real(wp) :: step = unset
      !> Masses as they are, or raised until scaled_step is stable
      character(len=option_length) :: mass_scaling = 'none'
      !> Time step to be reached by mass scaling [s]
      real(wp) :: scaled_step = unset
   end type explicit_t

   character(len=*), parameter :: dampings(*) = ['none   ', 'viscous', 'local  ']
   character(len=*), parameter :: mass_scalings(*) = ['none', 'step']

contains

   !> Read and check the group.
   subroutine read_explicit(slice, explicit, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(explicit_t), intent(out) :: explicit
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      explicit%line = slice%line
      call variables%read(slice)
      call name_variables(variables, explicit)
      call variables%end_reading(errors)
      call check_explicit(slice, explicit, errors)
   end subroutine read_explicit

   !> The variables, for reading and writing.
   subroutine name_variables(variables, explicit)
      type(group_variables_t), intent(inout) :: variables
      type(explicit_t), intent(inout) :: explicit

      call variables%keep('damping', explicit%damping)
      call variables%keep('damping_factor', explicit%damping_factor, 'there is no damping')
      call variables%keep('safety', explicit%safety)
      call variables%keep('step', explicit%step, 'the stable step times safety')
      call variables%keep('mass_scaling', explicit%mass_scaling)
      call variables%keep('scaled_step', explicit%scaled_step)
   end subroutine name_variables

   !> Ranges and choices, and one way only of choosing the step.
   subroutine check_explicit(slice, explicit, errors)
      type(group_slice_t), intent(in) :: slice
      type(explicit_t), intent(inout) :: explicit
      type(error_list_t), intent(inout) :: errors

      call check_choice(errors, slice, 'damping', explicit%damping, dampings)
      select case (explicit%damping)
      case ('viscous')
         if (.not. is_set(explicit%damping_factor)) explicit%damping_factor = critical
         call check_range(errors, slice, 'damping_factor', explicit%damping_factor, least=least_part, most=most_factor)
      case ('local')
         if (.not. is_set(explicit%damping_factor)) explicit%damping_factor = usual_local
         call check_range(errors, slice, 'damping_factor', explicit%damping_factor, least=least_part, below=1.0_wp)
      end select
      call check_range(errors, slice, 'safety', explicit%safety, least=least_part, most=1.0_wp)
      call check_range(errors, slice, 'step', explicit%step, least=least_step, most=most_time)
      call check_choice(errors, slice, 'mass_scaling', explicit%mass_scaling, mass_scalings)
      call check_range(errors, slice, 'scaled_step', explicit%scaled_step, least=least_step, most=most_time)
      if (explicit%mass_scaling == 'step') then
         call check_needed(errors, slice, 'scaled_step', explicit%scaled_step, "mass_scaling = 'step'")
         if (is_set(explicit%step)) then
            call errors%add(slice%place('step')//": mass_scaling = 'step' steps by scaled_step; leave out one of them")
         end if
      else
         call check_idle(errors, slice, 'scaled_step', explicit%scaled_step, "mass_scaling = 'step'")
      end if
   end subroutine check_explicit

   !> Write the effective group, every variable.
   subroutine write_explicit(explicit, unit)
      type(explicit_t), intent(in) :: explicit
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(explicit_t) :: effective

      effective = explicit
      call variables%write(unit, 'explicit')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_explicit

end module explicit_group_m
