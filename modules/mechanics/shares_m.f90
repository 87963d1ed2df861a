!> Whose work contact and friction do. Walls, corners of blocks and other surfaces push the same nodes, and the account finds the
!> work of their forces node by node, by kind of force. What corners add, and what surfaces add where there are walls too, is noted
!> here beside, at the nodes they can reach; what is left of contact and friction is the walls'.
module shares_m
   use kinds_m, only: wp
   use model_m, only: model_t
   use state_m, only: state_t
   implicit none
   private

   public :: no_share, begin_share, end_share, speeds_of_shares, book_step, book_increment

contains

   !> A term that has nothing near it adds nothing.
   pure subroutine no_share(share)
      real(wp), allocatable, intent(inout) :: share(:, :)

      if (size(share) > 0) share = reshape([real(wp) ::], [2, 0])
   end subroutine no_share

   !> Note the forces at the nodes of a term before it adds its own.
   pure subroutine begin_share(node, normal, friction, share)
      !> Nodes that it can reach
      integer, intent(in) :: node(:)
      !> Forces of all contact (2, nodes of the mesh) [N per m]
      real(wp), intent(in) :: normal(:, :), friction(:, :)
      !> Of the term (2, nodes that it can reach) [N per m]
      real(wp), allocatable, intent(inout) :: share(:, :)

      share = -(normal(:, node) + friction(:, node))
   end subroutine begin_share

   !> What it has added.
   pure subroutine end_share(node, normal, friction, share)
      !> As for begin_share
      integer, intent(in) :: node(:)
      real(wp), intent(in) :: normal(:, :), friction(:, :)
      real(wp), intent(inout) :: share(:, :)

      share = share + normal(:, node) + friction(:, node)
   end subroutine end_share

   !> Velocities before a step at the nodes that book_step asks for.
   pure subroutine speeds_of_shares(model, state, corners, surfaces)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> At the nodes of corners, and of surfaces (2, nodes) [m/s]
      real(wp), allocatable, intent(out) :: corners(:, :), surfaces(:, :)

      allocate (corners(2, 0), surfaces(2, 0))
      if (size(state%corner_force) > 0) corners = state%v(:, model%corner_reach)
      if (size(state%surface_force) > 0) surfaces = state%v(:, model%surface_reach)
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
            energy%corners = energy%corners + work(state%corner_force, 0.5_wp*kick*(corners + state%v(:, model%corner_reach)))
         if (size(surfaces) > 0) &
            energy%surfaces = energy%surfaces + work(state%surface_force, 0.5_wp*kick*(surfaces + state%v(:, model%surface_reach)))
      end associate
      call book_rest(model, state)
   end subroutine book_step

   !> Add the work of an increment, forces taken as the mean of start and end.
   pure subroutine book_increment(model, start, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: start
      type(state_t), intent(inout) :: state
      real(wp) :: corners(2, size(model%corner_reach)), surfaces(2, size(model%surface_reach))

      corners = state%u(:, model%corner_reach) - start%u(:, model%corner_reach)
      surfaces = state%u(:, model%surface_reach) - start%u(:, model%surface_reach)
      associate (energy => state%energy)
         energy%corners = energy%corners + 0.5_wp*(work(start%corner_force, corners) + work(state%corner_force, corners))
         energy%surfaces = energy%surfaces + 0.5_wp*(work(start%surface_force, surfaces) + work(state%surface_force, surfaces))
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
      !> (2, nodes) [N per m]
      real(wp), intent(in) :: share(:, :)
      !> (2, nodes) [m]
      real(wp), intent(in) :: way(:, :)

      work = 0.0_wp
      if (size(share, 2) == size(way, 2)) work = -sum(share*way)
   end function work

end module shares_m
