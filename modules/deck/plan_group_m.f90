!> The group &plan: what a scene does not need is skipped, unless a switch says that it be done all the same. Answers do not
!> depend on these switches; they are there so that this can be checked.
module plan_group_m
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use group_variables_m, only: group_variables_t
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

contains

   !> Read the group; a switch has no wrong values.
   subroutine read_plan(slice, plan, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(plan_t), intent(out) :: plan
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      plan%line = slice%line
      call variables%read(slice)
      call name_variables(variables, plan)
      call variables%end_reading(errors)
   end subroutine read_plan

   !> The variables, for reading and writing.
   subroutine name_variables(variables, plan)
      type(group_variables_t), intent(inout) :: variables
      type(plan_t), intent(inout) :: plan

      call variables%keep('skip_contact', plan%skip_contact)
      call variables%keep('skip_search', plan%skip_search)
      call variables%keep('skip_nodes', plan%skip_nodes)
      call variables%keep('skip_viscosity', plan%skip_viscosity)
      call variables%keep('skip_step', plan%skip_step)
      call variables%keep('skip_loads', plan%skip_loads)
   end subroutine name_variables

   !> Write the effective group, every variable.
   subroutine write_plan(plan, unit)
      type(plan_t), intent(in) :: plan
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(plan_t) :: effective

      effective = plan
      call variables%write(unit, 'plan')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_plan

end module plan_group_m
