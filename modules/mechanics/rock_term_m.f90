!> The rock: triangles of solid_m.
module rock_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_rock
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use field_list_m, only: field_list_t, on_triangles
   use model_m, only: model_t, term_t, increment_t
   use state_m, only: state_t
   use solid_forces_m, only: solid_forces
   use solid_stress_m, only: solid_stress, strain_energy
   use solid_tangent_m, only: triangle_tangent
   use sparse_system_m, only: sparse_system_t, node_groups_t
   implicit none
   private

   type, extends(term_t), public :: rock_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_tangent
      procedure, nopass :: join_nodes
      procedure, nopass :: add_stiffness_bound
      procedure, nopass :: find_energy
      procedure, nopass :: results
      procedure, nopass :: keep
   end type rock_term_t

contains

   !> Where there is rock: in every scene that moves.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = size(model%solid%node, 2) > 0
   end function is_there

   !> The first of all terms: the forces of the rock start anew here.
   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      call now_doing(work_rock)
      call solid_forces(model%solid, state%u, state%solid)
   end subroutine add_forces

   subroutine add_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside
      integer :: c, t

      associate (unused => increment, also => outside)
      end associate
      ! Patches of a colour share no node, and so no entry
      !$omp parallel default(none) shared(model, state, system) private(c, t)
      do c = 1, size(model%solid%patches%colour) - 1
         !$omp do schedule(static)
         do t = model%solid%patches%colour(c), model%solid%patches%colour(c + 1) - 1
            call add_patch(model, t, state%u, system)
         end do
         !$omp end do
      end do
      !$omp end parallel
   end subroutine add_tangent

   !> Stiffness of the triangles of a patch.
   subroutine add_patch(model, t, u, system)
      type(model_t), intent(in) :: model
      integer, intent(in) :: t
      !> (2, nodes) [m]
      real(wp), intent(in) :: u(:, :)
      type(sparse_system_t), intent(inout) :: system
      real(wp) :: stiffness(6, 6)
      integer :: e, i, j

      do e = model%solid%patches%first(t), model%solid%patches%last(t)
         stiffness = triangle_tangent(model%solid, e, u(:, model%solid%node(:, e)))
         do j = 1, 6
            do i = 1, 6
               associate (entry => system%triangle_entry(6*(j - 1) + i, e))
                  if (entry > 0) system%value(entry) = system%value(entry) + stiffness(i, j)
               end associate
            end do
         end do
      end do
   end subroutine add_patch

   subroutine join_nodes(model, state, groups)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(node_groups_t), intent(inout) :: groups
      integer :: e

      associate (unused => state)
      end associate
      do e = 1, size(model%split%triangle, 2)
         call groups%join(model%split%triangle(:, e))
      end do
   end subroutine join_nodes

   subroutine add_stiffness_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(inout) :: bound(:)

      associate (unused => state)
      end associate
      bound = bound + model%nodes%rock_stiffness
   end subroutine add_stiffness_bound

   subroutine find_energy(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      state%energy%strain = strain_energy(model%solid, state%u)
   end subroutine find_energy

   subroutine results(model, state, list)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(field_list_t), intent(inout) :: list
      real(wp) :: stress(3, size(model%solid%area))
      integer :: e

      do e = 1, size(stress, 2)
         stress(:, e) = solid_stress(model%solid, e, state%u)
      end do
      call list%add_stress(stress)
      if (any(model%deck%stage%remove /= '')) &
         call list%add('removed', '-', '1 where the rock was taken out, else 0', on_triangles, &
                       merge(0.0_wp, 1.0_wp, model%split%present))
   end subroutine results

   subroutine keep(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors

      associate (unused => model)
      end associate
      call file%keep('solid_force', state%solid, errors)
   end subroutine keep

end module rock_term_m
