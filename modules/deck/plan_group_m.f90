!> The group &plan: what a scene does not need is skipped, unless a switch says that it be done all the same. Answers do not
!> depend on these switches; they are there so that this can be checked.
module plan_group_m
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_switch, namelist_text, require_clean_read
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   public :: read_plan, write_plan

   !> &plan
   type, public :: plan_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Contact where no two surfaces can meet
      logical :: skip_contact = .true.
      !> A contact search before anything has moved half the skin
      logical :: skip_search = .true.
      !> Clearing the contact forces of nodes that contact cannot push
      logical :: skip_nodes = .true.
      !> Viscous forces where no viscosity is asked for
      logical :: skip_viscosity = .true.
      !> Finding the stable step, or fictitious masses, before contact or a joint's stiffness has changed
      logical :: skip_step = .true.
      !> Finding the nodal loads before their level has changed
      logical :: skip_loads = .true.
   end type plan_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('skip_contact', a_switch), &
                                  variable_t('skip_search', a_switch), &
                                  variable_t('skip_nodes', a_switch), &
                                  variable_t('skip_viscosity', a_switch), &
                                  variable_t('skip_step', a_switch), &
                                  variable_t('skip_loads', a_switch)]

contains

   !> Read the group; a switch has no wrong values.
   subroutine read_plan(slice, plan, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(plan_t), intent(out) :: plan
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ plan

      plan%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
   end subroutine read_plan

   !> Write the effective group, every variable.
   subroutine write_plan(plan, unit)
      type(plan_t), intent(in) :: plan
      integer, intent(in) :: unit

      call begin_group(unit, 'plan')
      call put(unit, 'skip_contact', plan%skip_contact)
      call put(unit, 'skip_search', plan%skip_search)
      call put(unit, 'skip_nodes', plan%skip_nodes)
      call put(unit, 'skip_viscosity', plan%skip_viscosity)
      call put(unit, 'skip_step', plan%skip_step)
      call put(unit, 'skip_loads', plan%skip_loads)
      call end_group(unit)
   end subroutine write_plan

end module plan_group_m
