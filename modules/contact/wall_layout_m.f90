!> Walls of fractures and the surfaces that they walk on, before any motion: which surface edges are walls of which joint, and which
!> edge goes on from which, straight across crossings of fractures and on to the outer boundary. The contact between them is
!> wall_contact_m.
module wall_layout_m
   use kinds_m, only: wp
   use rows_m, only: fill_rows
   use mesh_m, only: split_mesh_t
   implicit none
   private

   public :: init_wall_contact, surfaces_walked, walls_touching, facing_cosine, deepest

   !> Surfaces face each other when their normals are within 60 degrees of opposite; they continue each other within 60
   real(wp), parameter :: facing_cosine = 0.5_wp
   !> Directions closer than this are the same
   real(wp), parameter :: same_direction = 1.0e-9_wp
   !> Walls that have passed through each other by more than this part of an edge are not in contact but lost
   real(wp), parameter :: deepest = 1.0_wp
   !> The same for the walls of new cracks, whose fragments may go anywhere. In both cases beyond the overlap before: contact
   !> that deepens bit by bit is held at any depth
   real(wp), parameter :: deepest_crack = 1.0e-3_wp

   !> The walls and the surface they walk on
   type, public :: wall_contact_t
      !> Joint of each wall edge (walls), the upper wall of a joint directly before the lower one; its nodes A', B' or
      !> B, A (2, walls), surface edge of the other wall of the joint (walls)
      integer, allocatable :: joint(:), node(:, :), opposite(:)
      !> Surface edges (2, edges), rock on their left; the edges that go on straight from their start and end (0: none)
      integer, allocatable :: surface(:, :), before(:), after(:)
      !> Joint whose wall a surface edge is (edges); 0: none
      integer, allocatable :: wall_of(:)
      !> By how much the overlap of a wall edge over its length may be deeper than when it was looked at last: beyond that it has
      !> come from elsewhere and is not in contact (walls)
      real(wp), allocatable :: deepest(:)
   end type wall_contact_t

contains

   !> Set up the wall contact of the given joints. Tips with coinciding ends are allowed.
   subroutine init_wall_contact(split, handled, walls, bonded)
      type(split_mesh_t), intent(in) :: split
      !> Joints whose walls are in wall contact (joints)
      logical, intent(in) :: handled(:)
      type(wall_contact_t), intent(out) :: walls
      !> Joints whose walls are still bonded and no surface yet (joints); none when not given
      logical, intent(in), optional :: bonded(:)
      !> Surface edge of the lower and upper wall of each joint (joints)
      integer, allocatable :: edge_of(:, :)
      integer, allocatable :: joint(:)
      logical :: whole(size(handled))
      integer :: j, e, w

      whole = .false.
      if (present(bonded)) whole = bonded
      joint = pack([(j, j=1, size(handled))], walls_touching(handled, whole))
      walls%joint = [(joint((w + 1)/2), w=1, 2*size(joint))]
      walls%deepest = merge(deepest, deepest_crack, split%joint_group(walls%joint) > 0)
      walls%surface = split%surface
      allocate (edge_of(2, size(handled)), source=0)
      do e = 1, size(split%surface, 2)
         if (split%surface_joint(e) == 0) cycle
         edge_of(merge(1, 2, split%surface_side(e) > 0), split%surface_joint(e)) = e
      end do
      call continue_straight(split, whole, walls%before, walls%after)
      allocate (walls%node(2, size(walls%joint)), walls%opposite(size(walls%joint)))
      allocate (walls%wall_of(size(split%surface, 2)), source=0)
      do w = 1, size(walls%joint)
         associate (own => edge_of(merge(1, 2, is_upper(w)), walls%joint(w)))
            walls%node(:, w) = split%surface(:, own)
            walls%opposite(w) = edge_of(merge(2, 1, is_upper(w)), walls%joint(w))
            walls%wall_of(own) = walls%joint(w)
         end associate
      end do
   end subroutine init_wall_contact

   !> Joints whose walls are in wall contact and not held by a bond (joints).
   pure function walls_touching(handled, bonded) result(touching)
      logical, intent(in) :: handled(:), bonded(:)
      logical :: touching(size(handled))

      touching = handled .and. .not. bonded
   end function walls_touching

   !> Is a wall edge the upper wall of its joint?
   pure logical function is_upper(w)
      integer, intent(in) :: w

      is_upper = mod(w, 2) == 1
   end function is_upper

   !> Free surface edges that follow a wall edge in one direction, as long as they run on as the wall does.
   pure function free_run(neighbour, split, e) result(run)
      !> Next edge in the direction of the walk (surface edges)
      integer, intent(in) :: neighbour(:)
      type(split_mesh_t), intent(in) :: split
      !> Wall edge
      integer, intent(in) :: e
      integer, allocatable :: run(:)
      integer :: next

      allocate (run(0))
      next = neighbour(e)
      do while (next > 0)
         if (split%surface_joint(next) > 0) return
         if (dot_product(direction(split, e), direction(split, next)) < facing_cosine) return
         run = [run, next]
         next = neighbour(next)
      end do
   end function free_run

   !> Join surface edges that continue each other, across crossings of fractures too: at each node the two that do so most
   !> nearly straight first, then of those left. Two that do so alike: the one that turns away from its own rock and towards
   !> what slides there. Straightness alone counts, so that the answer does not know how a mesh is drawn: a corner of a
   !> block that turns by less than 60 degrees is not taken for the wall where another block goes on straight.
   subroutine continue_straight(split, bonded, before, after)
      type(split_mesh_t), intent(in) :: split
      !> Joints whose walls nothing may walk on (joints)
      logical, intent(in) :: bonded(:)
      !> Edge that ends where this one starts, edge that starts where this one ends (edges); 0: none
      integer, allocatable, intent(out) :: before(:), after(:)
      integer, allocatable :: start_first(:), starts(:), end_first(:), ends(:)
      integer :: node, best(2)

      allocate (before(size(split%surface, 2)), after(size(split%surface, 2)), source=0)
      call edges_at_nodes(split, 1, start_first, starts)
      call edges_at_nodes(split, 2, end_first, ends)
      do node = 1, size(start_first) - 1
         do
            best = straightest(ends(end_first(node):end_first(node + 1) - 1), &
                               starts(start_first(node):start_first(node + 1) - 1))
            if (best(1) == 0) exit
            after(best(1)) = best(2)
            before(best(2)) = best(1)
         end do
      end do

   contains

      !> The two edges that meet most nearly straight among those that have no other; 0: none.
      pure function straightest(ending, starting) result(best)
         integer, intent(in) :: ending(:), starting(:)
         integer :: best(2)
         real(wp) :: cosine, best_cosine, turn, best_turn
         integer :: i, k

         best = 0
         best_cosine = facing_cosine
         best_turn = 0.0_wp
         do i = 1, size(ending)
            if (after(ending(i)) > 0 .or. held(ending(i))) cycle
            do k = 1, size(starting)
               if (before(starting(k)) > 0 .or. held(starting(k))) cycle
               associate (along => direction(split, ending(i)), next => direction(split, starting(k)))
                  cosine = dot_product(along, next)
                  turn = along(1)*next(2) - along(2)*next(1)
               end associate
               if (cosine < best_cosine - same_direction) cycle
               if (cosine <= best_cosine + same_direction .and. turn >= best_turn .and. best(1) > 0) cycle
               best = [ending(i), starting(k)]
               best_cosine = cosine
               best_turn = turn
            end do
         end do
      end function straightest

      !> Is it the wall of a bond, on which nothing may walk, neither forwards nor backwards?
      pure logical function held(edge)
         integer, intent(in) :: edge

         held = .false.
         if (split%surface_joint(edge) > 0) held = bonded(split%surface_joint(edge))
      end function held

   end subroutine continue_straight

   !> Surface edges whose contact belongs to the walls: the walls themselves, and the free surface straight ahead of them.
   !> Their fracture group; 0 for all others (surface edges).
   function surfaces_walked(walls, split) result(group)
      type(wall_contact_t), intent(in) :: walls
      type(split_mesh_t), intent(in) :: split
      integer, allocatable :: group(:)
      integer :: e

      allocate (group(size(split%surface, 2)), source=0)
      do e = 1, size(group)
         if (walls%wall_of(e) > 0) group(e) = split%joint_group(walls%wall_of(e))
      end do
      do e = 1, size(group)
         if (walls%wall_of(e) == 0) cycle
         call mark(free_run(walls%before, split, e))
         call mark(free_run(walls%after, split, e))
      end do

   contains

      !> Give free edges the group of edge e.
      subroutine mark(run)
         integer, intent(in) :: run(:)

         where (group(run) == 0) group(run) = group(e)
      end subroutine mark

   end function surfaces_walked

   !> Surface edges sorted by the original node at one of their ends (compressed rows).
   subroutine edges_at_nodes(split, which, first, edge)
      type(split_mesh_t), intent(in) :: split
      !> 1: by their start, 2: by their end
      integer, intent(in) :: which
      !> Edges at original node i: edge(first(i):first(i+1)-1)
      integer, allocatable, intent(out) :: first(:), edge(:)

      call fill_rows(split%origin(split%surface(which, :)), maxval(split%origin), first, edge)
   end subroutine edges_at_nodes

   !> Unit vector along a surface edge before any motion.
   pure function direction(split, e)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: e
      real(wp) :: direction(2)

      direction = split%x(:, split%surface(2, e)) - split%x(:, split%surface(1, e))
      direction = direction/sqrt(sum(direction**2))
   end function direction

end module wall_layout_m
