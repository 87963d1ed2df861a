!> Whose work contact and friction do. Walls, corners of blocks and other surfaces push the same nodes, and the account finds the
!> work of their forces node by node, by kind of force. What corners add, and what surfaces add where there are walls too, is noted
!> here beside, at the nodes they can reach; what is left of contact and friction is the walls'.
module shares_m
   use kinds_m, only: wp
   use model_m, only: model_t
   use state_m, only: state_t, share_t
   implicit none
   private

   public :: begin_share, end_share, speeds_of_shares, book_step, book_increment

contains

   !> Note the forces at the nodes of a term before it adds its own.
   pure subroutine begin_share(node, state, share)
      !> Nodes that it can reach
      integer, intent(in) :: node(:)
      type(state_t), intent(in) :: state
      type(share_t), intent(inout) :: share

      share%force = -(state%normal(:, node) + state%friction(:, node))
   end subroutine begin_share

   !> What it has added.
   pure subroutine end_share(node, state, share)
      integer, intent(in) :: node(:)
      type(state_t), intent(in) :: state
      type(share_t), intent(inout) :: share

      share%force = share%force + state%normal(:, node) + state%friction(:, node)
   end subroutine end_share

   !> Velocities before a step at the nodes that book_step asks for.
   pure subroutine speeds_of_shares(model, state, corners, surfaces)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> At the nodes of corners, and of surfaces (2, nodes) [m/s]
      real(wp), allocatable, intent(out) :: corners(:, :), surfaces(:, :)

      allocate (corners(2, 0), surfaces(2, 0))
      if (size(state%corner_share%force) > 0) corners = state%v(:, model%corner_reach)
      if (size(state%surface_share%force) > 0) surfaces = state%v(:, model%surface_reach)
   end subroutine speeds_of_shares

   !> Add the work of a step: that of the shares on the way of the velocities, as move_nodes has it.
   pure subroutine book_step(model, corners, surfaces, kick, state)
      type(model_t), intent(in) :: model
      !> Velocities before (2, nodes) [m/s]
      real(wp), intent(in) :: corners(:, :), surfaces(:, :)
      !> Time that the forces acted on the velocities [s]
      real(wp), intent(in) :: kick
      type(state_t), intent(inout) :: state

      associate (energy => state%energy)
         if (size(corners) > 0) &
            energy%corners = energy%corners + work(state%corner_share, 0.5_wp*kick*(corners + state%v(:, model%corner_reach)))
         if (size(surfaces) > 0) &
            energy%surfaces = energy%surfaces + work(state%surface_share, 0.5_wp*kick*(surfaces + state%v(:, model%surface_reach)))
      end associate
      call book_rest(model, state)
   end subroutine book_step

   !> Add the work of an increment, forces taken as the mean of start and end.
   pure subroutine book_increment(model, start, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: start
      type(state_t), intent(inout) :: state

      associate (energy => state%energy, corners => model%corner_reach, surfaces => model%surface_reach)
         energy%corners = energy%corners + 0.5_wp*(work(start%corner_share, state%u(:, corners) - start%u(:, corners)) &
                                                   + work(state%corner_share, state%u(:, corners) - start%u(:, corners)))
         energy%surfaces = energy%surfaces + 0.5_wp*(work(start%surface_share, state%u(:, surfaces) - start%u(:, surfaces)) &
                                                     + work(state%surface_share, state%u(:, surfaces) - start%u(:, surfaces)))
      end associate
      call book_rest(model, state)
   end subroutine book_increment

   !> Without walls all of contact and friction is that of surfaces.
   pure subroutine book_rest(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      if (.not. model%has_walls) state%energy%surfaces = state%energy%contact + state%energy%friction - state%energy%corners
   end subroutine book_rest

   !> Work done against a share on a way [J per m of thickness]; none where nothing was near.
   pure real(wp) function work(share, way)
      type(share_t), intent(in) :: share
      !> (2, nodes) [m]
      real(wp), intent(in) :: way(:, :)

      work = 0.0_wp
      if (size(share%force, 2) == size(way, 2)) work = -sum(share%force*way)
   end function work

end module shares_m
