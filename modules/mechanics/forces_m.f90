!> The forces of every solver, found in one place: loads, rock, bonds, viscosity, walls with their corners, other surfaces.
module forces_m
   use kinds_m, only: wp
   use stopwatch_m, only: doing, now_doing, work_loads, work_rock, work_bonds, work_walls, work_laws, work_search, work_contact
   use model_m, only: model_t
   use solver_choice_m, only: solver_explicit, solver_implicit
   use state_m, only: state_t
   use solid_m, only: solid_forces, viscous_forces
   use wall_contact_m, only: meet_walls, add_wall_forces
   use corners_m, only: add_corner_forces
   use contact_m, only: contact_energy_t
   use joints_m, only: couple_walls, couple_potential
   use loads_m, only: nodal_loads
   use bonds_m, only: hold_together
   use release_m, only: release_factor
   implicit none
   private

   public :: find_forces, net_force, total_force

contains

   !> All nodal forces at the current displacement, joints and bonds taken there in one step from what they remember. The terms
   !> are added in the order loads, rock, bonds, viscosity, walls, other surfaces; those that a scene does not need are not there.
   subroutine find_forces(model, level, state, searched)
      type(model_t), intent(in) :: model
      !> Loads: 0 at the start of the stage, 1 at its end
      real(wp), intent(in) :: level
      type(state_t), intent(inout) :: state
      !> Has contact found new pairs, so that the stable step has to be looked at again?
      logical, intent(out) :: searched
      !> Does contact of other surfaces act? Not in the equations of the implicit solver, which measures it
      logical :: others
      integer :: before

      before = doing()
      call now_doing(work_loads)
      searched = .false.
      call nodal_loads(model%loads, model%split%x, state%u, level, state%load_level, state%load)
      call now_doing(work_rock)
      call clear(state%solid)
      call solid_forces(model%solid, state%u, state%solid)
      if (model%can_break) then
         call now_doing(work_bonds)
         ! Points that stay behind have a place to catch up from when nothing ever goes back
         call hold_together(model%bonds, model%split%x, state%u, model%solver == solver_explicit, state%bonds, state%solid)
         if (release_factor(state) > 0.0_wp) &
            state%solid = state%solid + release_factor(state)*state%release
      end if
      if (size(state%damping, 2) > 0) then
         call now_doing(work_rock)
         call clear(state%damping)
         call viscous_forces(model%solid, state%u, state%v, state%damping)
      end if
      others = model%has_contact .and. model%solver /= solver_implicit
      if (model%has_walls .or. others) then
         call now_doing(work_walls)
         call clear_at(model%touching, state%normal)
         call clear_at(model%touching, state%friction)
      end if
      if (model%has_walls) then
         call meet_walls(model%walls, model%split%x, state%u, state%walls)
         call now_doing(work_laws)
         call couple_walls(model%joints, model%walls, state%walls, model%solid, model%split%x, state%u, state%v, &
                           state%tractions, state%joint, state%opening, state%aperture)
         call now_doing(work_walls)
         call add_wall_forces(state%walls, state%tractions%pressure, state%tractions%shear, state%normal, state%friction)
         call add_corner_forces(model%corners, state%corners, state%u, state%normal)
      end if
      if (others) call find_contact_forces(model, state, searched)
      call now_doing(before)
   end subroutine find_forces

   !> No force yet. In pieces, so that what is cleared stays in the caches: beyond some 2 kB the C library goes past them.
   pure subroutine clear(force)
      real(wp), contiguous, intent(out) :: force(:, :)
      integer, parameter :: piece = 64
      integer :: first

      do first = 1, size(force, 2), piece
         force(:, first:min(first + piece - 1, size(force, 2))) = 0.0_wp
      end do
   end subroutine clear

   !> No force yet at some nodes.
   pure subroutine clear_at(node, force)
      integer, intent(in) :: node(:)
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: i

      do i = 1, size(node)
         force(:, node(i)) = 0.0_wp
      end do
   end subroutine clear_at

   !> Forces between surfaces that meet, with a new search when something has moved half the skin.
   subroutine find_contact_forces(model, state, searched)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      logical, intent(out) :: searched
      type(contact_energy_t) :: energy
      real(wp) :: normal(size(state%joint)), shear(size(state%joint))
      integer :: e

      call now_doing(work_contact)
      searched = model%contact%needs_search(state%contact, state%u)
      if (searched) then
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
      end if
      call now_doing(work_contact)
      call model%contact%forces(model%exposed, state%u, state%v, state%surface_friction, state%contact, state%normal, &
                                state%friction, energy)
   end subroutine find_contact_forces

   !> Sum of all nodal forces but viscous ones (2, nodes) [N per m of thickness].
   pure function net_force(state) result(force)
      type(state_t), intent(in) :: state
      real(wp) :: force(2, size(state%u, 2))

      force = state%solid + state%normal + state%friction + state%load
   end function net_force

   !> All forces on the nodes but prescribed ones' reactions (2, nodes) [N per m].
   function total_force(state) result(force)
      type(state_t), intent(in) :: state
      real(wp), allocatable :: force(:, :)

      force = net_force(state)
      if (size(state%damping, 2) > 0) force = force + state%damping
   end function total_force

end module forces_m
