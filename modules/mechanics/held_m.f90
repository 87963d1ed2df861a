!> What a side that begins to absorb waves goes on to hold: dashpots carry nothing at rest.
!>
!> Where supports had held it until then, what they carried stays as a load: rock at rest remains so. In rock under in-situ stress,
!> a side without a load of its own that absorbs from the first stage on has that stress on it.
module held_m
   use kinds_m, only: wp
   use boundary_group_m, only: prescribed, loads
   use in_situ_group_m, only: in_situ_stress
   use loads_m, only: loads_t, start_stage, absorbing_edges, on_group, stage_number
   use forces_m, only: forces_now
   use model_m, only: model_t
   use state_m, only: state_t
   implicit none
   private

   public :: hold_absorbing_sides

contains

   !> A stage has begun: find what the sides that absorb from now on hold. Its loads are to be found anew with that.
   subroutine hold_absorbing_sides(model, stage, state)
      !> With the loads of the stage
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(state_t), intent(inout) :: state
      logical :: edge(size(model%split%surface, 2))

      if (stage == 1 .and. model%deck%in_situ%line == 0) return
      edge = absorbing_edges(model%split, model%deck%boundary, model%deck%stage%name, stage)
      if (size(state%held, 2) == 0) state%held = 0.0_wp*state%u
      if (stage == 1) then
         call hold_in_situ_stress(model, edge .and. .not. loaded_edges(model), state%held)
      else
         call hold_reactions(model, stage, edge, state)
      end if
   end subroutine hold_absorbing_sides

   !> The traction of the in-situ stress, linear along an edge: it is in balance with the rock to the last digit.
   subroutine hold_in_situ_stress(model, edge, held)
      type(model_t), intent(in) :: model
      !> On which edges (surface edges)
      logical, intent(in) :: edge(:)
      !> Forces on the nodes (2, nodes) [N per m]
      real(wp), intent(inout) :: held(:, :)
      real(wp) :: along(2), traction(2, 2), stress(3)
      integer :: e, i

      do e = 1, size(edge)
         if (.not. edge(e)) cycle
         associate (node => model%split%surface(:, e))
            along = model%split%x(:, node(2)) - model%split%x(:, node(1))
            do i = 1, 2
               stress = in_situ_stress(model%deck%in_situ, model%split%datum(2) + model%split%x(2, node(i)))
               ! S0 times the outward normal and the length: the rock is on the left of the edge
               traction(:, i) = [stress(1)*along(2) - stress(3)*along(1), stress(3)*along(2) - stress(2)*along(1)]
            end do
            do i = 1, 2
               held(:, node(i)) = held(:, node(i)) + (sum(traction, dim=2) + traction(:, i))/6.0_wp
            end do
         end associate
      end do
   end subroutine hold_in_situ_stress

   !> What supports of the stage before carried that let go now.
   subroutine hold_reactions(model, stage, edge, state)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      !> Edges that absorb (surface edges)
      logical, intent(in) :: edge(:)
      type(state_t), intent(inout) :: state
      type(loads_t) :: before
      logical :: let_go(2, size(state%u, 2))
      real(wp) :: force(2, size(state%u, 2))
      integer :: e

      before = model%loads
      call start_stage(model%split, model%deck%boundary, model%deck%stage%name, stage - 1, model%nodes%weight, before)
      let_go = .false.
      do e = 1, size(edge)
         if (edge(e)) let_go(:, model%split%surface(:, e)) = .true.
      end do
      let_go = let_go .and. before%fixed .and. .not. model%loads%fixed
      ! At its start the stage has the loads that the one before ended with
      force = forces_now(model, 0.0_wp, state)
      where (let_go) state%held = state%held - force
   end subroutine hold_reactions

   !> Surface edges that the deck gives a load in the first stage (surface edges).
   function loaded_edges(model) result(edge)
      type(model_t), intent(in) :: model
      logical :: edge(size(model%split%surface, 2)), given(size(prescribed(model%deck%boundary(1))))
      integer :: b

      edge = .false.
      do b = 1, size(model%deck%boundary)
         if (stage_number(model%deck%stage%name, model%deck%boundary(b)%stage) > 1) cycle
         given = prescribed(model%deck%boundary(b))
         if (any(given(loads))) edge = edge .or. on_group(model%split, model%deck%boundary(b)%group)
      end do
   end function loaded_edges

end module held_m
