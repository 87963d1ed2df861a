!> Rock that may break: bonds in its cuts, and the forces that new cuts let go of smoothly.
module bond_term_m
   use kinds_m, only: wp
   use stopwatch_m, only: now_doing, work_bonds
   use errors_m, only: error_list_t
   use checkpoint_m, only: checkpoint_t
   use field_list_m, only: field_list_t, on_joints
   use model_m, only: model_t, term_t, increment_t
   use state_m, only: state_t
   use bond_m, only: bond_tangent
   use bonds_m, only: hold_together, bonds_stiffness_bound, bonds_work, bond_damage, event_values, restore_events, has_stiffness
   use release_m, only: release_factor
   use solver_choice_m, only: solver_explicit
   use sparse_system_m, only: sparse_system_t, node_groups_t, add_block
   implicit none
   private

   type, extends(term_t), public :: bond_term_t
   contains
      procedure, nopass :: is_there
      procedure, nopass :: add_forces
      procedure, nopass :: add_tangent
      procedure, nopass :: join_nodes
      procedure, nopass :: add_stiffness_bound
      procedure, nopass :: find_energy
      procedure, nopass :: results
      procedure, nopass :: keep
   end type bond_term_t

contains

   !> Where rock may break.
   pure logical function is_there(model)
      type(model_t), intent(in) :: model

      is_there = model%can_break
   end function is_there

   subroutine add_forces(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      call now_doing(work_bonds)
      ! Points that stay behind have a place to catch up from when nothing ever goes back
      call hold_together(model%bonds, model%split%x, state%u, model%solver == solver_explicit, state%bonds, state%solid)
      if (release_factor(state) > 0.0_wp) state%solid = state%solid + release_factor(state)*state%release
   end subroutine add_forces

   subroutine add_tangent(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      logical, intent(inout) :: outside
      logical :: has(size(state%bonds%active))
      integer :: b

      has = has_stiffness(model%bonds, state%bonds)
      do b = 1, size(has)
         if (.not. has(b)) cycle
         associate (bonds => model%bonds, node => model%bonds%node(:, b))
            call add_block(system, node, bond_tangent(bonds%length(b), bonds%law(b), bonds%shift(:, :, b), &
                                                      model%split%x(:, node), state%u(:, node), increment%start%bonds%point(:, b), &
                                                      softens=state%bonds%softens), outside)
         end associate
      end do
   end subroutine add_tangent

   subroutine join_nodes(model, state, groups)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(node_groups_t), intent(inout) :: groups
      logical :: has(size(state%bonds%active))
      integer :: b

      has = has_stiffness(model%bonds, state%bonds)
      do b = 1, size(has)
         if (has(b)) call groups%join(model%bonds%node(:, b))
      end do
   end subroutine join_nodes

   subroutine add_stiffness_bound(model, state, bound)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp), contiguous, intent(inout) :: bound(:)

      call bonds_stiffness_bound(model%bonds, state%bonds, bound)
   end subroutine add_stiffness_bound

   subroutine find_energy(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      state%energy%fracture = bonds_work(model%bonds, state%bonds)
   end subroutine find_energy

   subroutine results(model, state, list)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(field_list_t), intent(inout) :: list
      real(wp) :: broken(size(state%joint))

      if (.not. model%can_break) return
      call list%add('damage', '-', 'damage of cohesive joints, 0 whole to 1 broken; 1 on fractures', on_joints, &
                    bond_damage(model%bonds, state%bonds, size(state%joint)))
      broken = 1.0_wp
      broken(model%bonds%fractures + 1:) = merge(1.0_wp, 0.0_wp, state%bonds%broken)
      call list%add('broken', '-', '1 where two of three points of a cohesive joint have broken, else 0; 1 on fractures', &
                    on_joints, broken)
   end subroutine results

   !> What has broken, and forces not let go of yet. The bonds themselves come with the cuts they are in (run_checkpoint_m).
   subroutine keep(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: table(:, :)

      if (.not. model%can_break) return
      if (.not. file%writing) then
         if (.not. file%has('crack_events')) return
      end if
      allocate (table, source=event_values(state%bonds))
      if (.not. file%writing) deallocate (table)
      call file%keep('crack_events', table, errors)
      if (errors%any()) return
      if (.not. file%writing) call restore_events(table, state%bonds)
      call file%keep('release_start', state%release_start, errors)
      call file%keep('release_time', state%release_time, errors)
      if (state%release_time > 0.0_wp) call file%keep('release', state%release, errors)
   end subroutine keep

end module bond_term_m
