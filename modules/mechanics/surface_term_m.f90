!> Other surfaces that meet: Munjiza's potential (contact_m), and the joints in it.
module surface_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_contact, work_search, work_laws
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use model_m, only: model_t, term_t
   use solver_choice_m, only: solver_implicit
   use state_m, only: state_t
   use contact_m, only: contact_energy_t
   use joint_border_m, only: couple_potential
   use shares_m, only: no_share, begin_share, end_share
   implicit none
   private

   type, extends(term_t), public :: surface_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_stiffness_bound
      procedure, nopass :: keep
   end type surface_term_t

contains

   !> Where they can. Not in the equations of the implicit solver, which measures it.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = model%has_contact .and. model%solver /= solver_implicit
   end function is_there

   !> With a new search when something has moved half the skin.
   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(contact_energy_t) :: energy
      real(wp) :: normal(size(state%joint)), shear(size(state%joint))
      logical :: meets
      integer :: e

      call now_doing(work_contact)
      if (model%contact%needs_search(state%contact, state%u)) then
         call now_doing(work_search)
         call model%contact%search(model%exposed, state%u, state%contact)
         call now_doing(work_contact)
      end if
      if (model%has_potential_joints) then
         call now_doing(work_laws)
         call model%contact%joint_tractions(state%contact, model%exposed, normal, shear)
         call couple_potential(model%joints, model%solid, model%split%x, state%u, normal, shear, state%tractions, &
                               state%joint, state%opening, state%aperture)
         do e = 1, size(state%surface_friction)
            associate (j => model%exposed%surface_joint(e))
               if (j == 0) cycle
               ! Walls in wall contact have their own friction, and that of surfaces where they meet others
               if (.not. model%joints%wall_handled(j)) state%surface_friction(e) = state%joint(j)%mu_mob              ! (33)
            end associate
         end do
         call now_doing(work_contact)
      end if
      meets = state%contact%pairs() > 0
      if (meets) then
         call begin_share(model%surface_reach, state%normal, state%friction, state%surface_force)
      else
         call no_share(state%surface_force)
      end if
      call model%contact%forces(model%exposed, state%u, state%v, state%surface_friction, state%contact, state%normal, &
                                state%friction, energy)
      if (meets) call end_share(model%surface_reach, state%normal, state%friction, state%surface_force)
   end subroutine add_forces

   subroutine add_stiffness_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(inout) :: bound(:)

      call model%contact%add_stiffness(state%contact, bound)
   end subroutine add_stiffness_bound

   subroutine keep(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: list(:)

      if (.not. model%has_contact) return
      allocate (list, source=state%contact%values())
      if (.not. file%writing) deallocate (list)
      call file%keep('contact', list, errors)
      if (errors%any() .or. file%writing) return
      if (.not. model%contact%restore_state(model%exposed, list, state%contact)) &
         call errors%add('the contact of the checkpoint does not fit this mesh')
   end subroutine keep

end module surface_term_m
