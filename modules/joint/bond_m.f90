!> Cohesive joint elements: four nodes, three integration points with the law of cohesive_m. They hold the two sides of
!> an edge together until they have softened; a kernel of plain arrays that knows nothing of meshes.
module bond_m
   use constants_m, only: no_length
   use kinds_m, only: wp
   use rows_m, only: fill_rows
   use cohesive_m, only: cohesive_t, cohesive_point_t, cohesive_update, cohesive_tangent
   implicit none
   private

   public :: bond_forces, init_rows, resting_bond_forces, follow_points, bond_tangent, bond_stiffness_bound, bond_is_broken, &
             bond_has_parted, bond_energy, bond_mode

   !> Integration points of a bond
   integer, parameter, public :: bond_points = 3
   !> A bond is broken when this many of its points have softened completely
   integer, parameter :: points_to_break = 2
   !> Gauss points on [0,1] and their weights
   real(wp), parameter, public :: bond_place(bond_points) = &
                                  [0.5_wp - sqrt(0.15_wp), 0.5_wp, 0.5_wp + sqrt(0.15_wp)]
   real(wp), parameter, public :: bond_weight(bond_points) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp

   !> How closely a bond is looked at: its points do not follow while it rests far below its strength; they are up to date; they
   !> have to be, as it is damaged, was put in under stress or holds no more
   integer, parameter, public :: resting = 0, watched = 1, followed = 2
   !> A bond rests up to this part of its strength
   real(wp), parameter :: resting_part = 0.9_wp
   !> Bonds handled together: gathered, computed as vectors, scattered
   integer, parameter :: block_size = 64

   !> What the vectorised loop needs of every bond, in the order in which it goes through them: by the turn of the patch of
   !> triangles that they are in (patches_m). Bonds of patches that share no node share none.
   type, public :: bond_rows_t
      !> First row of each turn, and one beyond the last (turns + 1), first turn of each colour (colours + 1), bond of each row
      integer, allocatable :: first(:), colour(:), bond(:)
      !> Nodes A, B, A', B' (4, rows)
      integer, allocatable :: node(:, :)
      !> Twice the edge before any motion (2, rows) [m], a sixth of stiffness times length (rows) [N/m per m of thickness]
      real(wp), allocatable :: edge(:, :), pull(:)
      !> Slip up to which it rests without pressure [m], what that grows by with each metre of overlap, and slip at the strength
      !> over opening at the strength (rows)
      real(wp), allocatable :: slip(:), friction(:), ratio(:)
   end type bond_rows_t

   !> How a bond broke: by opening, by slip, or by both; a mode is called pure when it spent this part of the energy
   integer, parameter, public :: mode_i = 1, mode_ii = 2, mode_mixed = 3
   real(wp), parameter :: pure_part = 0.8_wp

contains

   !> Add the forces of all bonds to the nodal forces and update their points.
   !>
   !>     A'-------->B'    i along the median line, j normal to it; opening and slip at a place are the relative
   !>   j ^ :        :     displacement of the upper wall along j and i, plus the shift with which the bond was put in.
   !>     | A------->B     Forces act along the length before any motion, so that a bond spends its fracture energy times
   !>     +--> i           that length.
   !>
   !> The forces on the two walls are opposite and, with the small couple of the stresses on the opening, keep the moment
   !> of momentum; this couple is also what makes their work that of the stresses on opening and slip.
   pure subroutine bond_forces(active, node, length, law, shift, x, u, point, force)
      !> Bonds that still hold or press (bonds)
      logical, contiguous, intent(in) :: active(:)
      !> Nodes A, B, A', B' (4, bonds), length before any motion (bonds) [m]
      integer, contiguous, intent(in) :: node(:, :)
      real(wp), contiguous, intent(in) :: length(:)
      type(cohesive_t), intent(in) :: law(:)
      !> Opening and slip that come on top of those of the nodes (2, points, bonds) [m]
      real(wp), contiguous, intent(in) :: shift(:, :, :)
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> State (points, bonds)
      type(cohesive_point_t), contiguous, intent(inout) :: point(:, :)
      !> Nodal forces (2, nodes) [N per m of thickness]
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: b

      do b = 1, size(node, 2)
         if (active(b)) call hold(node(:, b), length(b), law(b), shift(:, :, b), x, u, .false., point(:, b), force)
      end do
   end subroutine bond_forces

   !> Add the forces of one bond, see bond_forces.
   pure subroutine hold(node, length, law, shift, x, u, overdue, point, force)
      integer, intent(in) :: node(4)
      real(wp), intent(in) :: length
      type(cohesive_t), intent(in) :: law
      real(wp), intent(in) :: shift(2, bond_points)
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> Have the points not followed for a while (see resting_bond_forces)?
      logical, intent(in) :: overdue
      type(cohesive_point_t), intent(inout) :: point(bond_points)
      real(wp), contiguous, intent(inout) :: force(:, :)
      real(wp) :: i(2), j(2), along(bond_points), across(bond_points), median, couple, pull(2), at_start(2), at_end(2)
      integer :: k

      call place_points(node, x, u, i, j, median, along, across)
      couple = 0.0_wp
      at_start = 0.0_wp
      at_end = 0.0_wp
      do k = 1, bond_points
         call cohesive_update(law, across(k) + shift(1, k), along(k) + shift(2, k), point(k), overdue)
         pull = (point(k)%normal*j + point(k)%shear*i)*bond_weight(k)*length
         at_start = at_start + (1.0_wp - bond_place(k))*pull
         at_end = at_end + bond_place(k)*pull
         couple = couple + (point(k)%normal*along(k) - point(k)%shear*across(k))*bond_weight(k)*length
      end do
      call add_nodal_forces(node, at_start, at_end, force)
      ! Turning the element by d(angle) changes opening and slip by -along and +across times it
      pull = 0.5_wp*couple/median*j
      associate (p => node(1), q => node(2), pp => node(3), qq => node(4))
         force(:, p) = force(:, p) - pull
         force(:, pp) = force(:, pp) - pull
         force(:, q) = force(:, q) + pull
         force(:, qq) = force(:, qq) + pull
      end associate
   end subroutine hold

   !> Directions of a bond, length of its median line, and the relative displacement of its walls at the points.
   pure subroutine place_points(node, x, u, i, j, length, along, across)
      !> Nodes A, B, A', B'
      integer, intent(in) :: node(4)
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      real(wp), intent(out) :: i(2), j(2), length
      !> Displacement of the upper wall against the lower one along i and along j (points) [m]
      real(wp), intent(out) :: along(bond_points), across(bond_points)
      real(wp) :: median(2), start(2), end(2), delta(2)
      integer :: k

      associate (p => node(1), q => node(2), pp => node(3), qq => node(4))
         start = u(:, pp) - u(:, p)
         end = u(:, qq) - u(:, q)
         median = 0.5_wp*((x(:, q) - x(:, p)) + (x(:, qq) - x(:, pp)) + (u(:, q) - u(:, p)) + (u(:, qq) - u(:, pp)))
      end associate
      length = max(sqrt(median(1)**2 + median(2)**2), no_length)
      i = median/length
      j = [-i(2), i(1)]
      do k = 1, bond_points
         delta = start + bond_place(k)*(end - start)
         along(k) = delta(1)*i(1) + delta(2)*i(2)
         across(k) = delta(1)*j(1) + delta(2)*j(2)
      end do
   end subroutine place_points

   !> What resting_bond_forces needs to know of the bonds.
   pure subroutine init_rows(node, length, law, x, turn, colour, rows)
      !> As in bond_forces
      integer, intent(in) :: node(:, :)
      real(wp), intent(in) :: length(:), x(:, :)
      type(cohesive_t), intent(in) :: law(:)
      !> Turn of each bond (bonds), first turn of each colour (colours + 1)
      integer, intent(in) :: turn(:), colour(:)
      type(bond_rows_t), intent(out) :: rows

      call fill_rows(turn, colour(size(colour)) - 1, rows%first, rows%bond)
      allocate (rows%colour(size(colour)))
      rows%colour = colour
      rows%node = node(:, rows%bond)
      allocate (rows%edge(2, size(length)))
      rows%edge = (x(:, rows%node(2, :)) - x(:, rows%node(1, :))) + (x(:, rows%node(4, :)) - x(:, rows%node(3, :)))
      rows%pull = law(rows%bond)%stiffness*length(rows%bond)/6.0_wp
      rows%slip = resting_part*law(rows%bond)%cohesion/law(rows%bond)%stiffness
      rows%friction = resting_part*law(rows%bond)%internal
      rows%ratio = law(rows%bond)%cohesion/law(rows%bond)%tensile_strength
   end subroutine init_rows

   !> The same forces, faster where a bond is undamaged, was put in without a stress and is well below its strength: it rests.
   !> Its traction then is stiffness times relative displacement whatever its direction, and there is no couple. The forces on
   !> the ends are the integrals of that linear traction times the linear shape functions: L k (2 d_start + d_end)/6.
   !>
   !> That it rests is seen from its ends: the strength grows with the pressure and falls with the slip, so the larger opening
   !> together with the larger slip is worse than any point between. The points of a bond at rest do not follow; they catch up
   !> when it no longer rests, or when asked to (follow_points). Up to its strength a bond is elastic: they miss nothing.
   subroutine resting_bond_forces(active, rows, length, law, shift, x, u, watch, point, force)
      !> As in bond_forces
      logical, contiguous, intent(in) :: active(:)
      type(bond_rows_t), intent(in) :: rows
      real(wp), contiguous, intent(in) :: length(:)
      type(cohesive_t), contiguous, intent(in) :: law(:)
      real(wp), contiguous, intent(in) :: shift(:, :, :)
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> resting, watched or followed (bonds)
      integer, contiguous, intent(inout) :: watch(:)
      type(cohesive_point_t), contiguous, intent(inout) :: point(:, :)
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: c, t, first

      !$omp parallel default(none) shared(active, rows, length, law, shift, x, u, watch, point, force) private(c, t, first)
      do c = 1, size(rows%colour) - 1
         !$omp do schedule(static)
         do t = rows%colour(c), rows%colour(c + 1) - 1
            do first = rows%first(t), rows%first(t + 1) - 1, block_size
               call hold_block(first, min(first + block_size, rows%first(t + 1)) - 1, active, rows, length, law, shift, x, u, &
                               watch, point, force)
            end do
         end do
         !$omp end do
      end do
      !$omp end parallel
   end subroutine resting_bond_forces

   !> The same for a block of rows.
   pure subroutine hold_block(first, last, active, rows, length, law, shift, x, u, watch, point, force)
      integer, intent(in) :: first, last
      !> As in resting_bond_forces
      logical, contiguous, intent(in) :: active(:)
      type(bond_rows_t), intent(in) :: rows
      real(wp), contiguous, intent(in) :: length(:)
      type(cohesive_t), contiguous, intent(in) :: law(:)
      real(wp), contiguous, intent(in) :: shift(:, :, :), x(:, :), u(:, :)
      integer, contiguous, intent(inout) :: watch(:)
      type(cohesive_point_t), contiguous, intent(inout) :: point(:, :)
      real(wp), contiguous, intent(inout) :: force(:, :)
      real(wp) :: at_start(2, block_size), at_end(2, block_size)
      logical :: rests(block_size), all_rest
      integer :: k, r, b

      call pull_block(last - first + 1, size(u, 2), rows%node(:, first:last), u, rows%edge(:, first:last), rows%pull(first:last), &
                      rows%slip(first:last), rows%friction(first:last), rows%ratio(first:last), at_start, at_end, rests)
      all_rest = .true.
      do r = first, last
         k = r - first + 1
         rests(k) = rests(k) .and. watch(rows%bond(r)) /= followed
         all_rest = all_rest .and. rests(k) .and. watch(rows%bond(r)) == resting
      end do
      if (all_rest) then
         call add_block(last - first + 1, size(u, 2), rows%node(:, first:last), at_start, at_end, force)
         return
      end if
      do r = first, last
         k = r - first + 1
         b = rows%bond(r)
         if (rests(k)) then
            watch(b) = resting
            call add_nodal_forces(rows%node(:, r), at_start(:, k), at_end(:, k), force)
         else if (active(b)) then
            call hold(rows%node(:, r), length(b), law(b), shift(:, :, b), x, u, watch(b) == resting, point(:, b), force)
            if (watch(b) /= followed) watch(b) = merge(followed, watched, any(point(:, b)%damage > 0.0_wp))
         end if
      end do
   end subroutine hold_block

   !> Pull on the ends of the lower wall of a block of bonds, were they all at rest, and which of them are.
   pure subroutine pull_block(n, nodes, node, u, edge, pull, slip, friction, ratio, at_start, at_end, rests)
      !> Bonds of the block, nodes of the mesh
      integer, intent(in) :: n, nodes
      !> As in bond_forces
      integer, intent(in) :: node(4, n)
      real(wp), intent(in) :: u(2, nodes)
      !> As in bond_rows_t
      real(wp), intent(in) :: edge(2, n), pull(n), slip(n), friction(n), ratio(n)
      !> [N per m of thickness]
      real(wp), intent(out) :: at_start(2, n), at_end(2, n)
      logical, intent(out) :: rests(n)
      real(wp), dimension(n) :: sx, sy, ex, ey, mx, my
      real(wp) :: length, opening, sliding, strength
      integer :: k, p, q, pp, qq

      do k = 1, n
         p = node(1, k)
         q = node(2, k)
         pp = node(3, k)
         qq = node(4, k)
         sx(k) = u(1, pp) - u(1, p)
         sy(k) = u(2, pp) - u(2, p)
         ex(k) = u(1, qq) - u(1, q)
         ey(k) = u(2, qq) - u(2, q)
         mx(k) = edge(1, k) + ((u(1, q) - u(1, p)) + (u(1, qq) - u(1, pp)))
         my(k) = edge(2, k) + ((u(2, q) - u(2, p)) + (u(2, qq) - u(2, pp)))
      end do
      do k = 1, n
         ! All times the length of twice the median line
         length = sqrt(mx(k)**2 + my(k)**2)
         opening = max(sy(k)*mx(k) - sx(k)*my(k), ey(k)*mx(k) - ex(k)*my(k))
         sliding = max(abs(sx(k)*mx(k) + sy(k)*my(k)), abs(ex(k)*mx(k) + ey(k)*my(k)))
         strength = slip(k)*length + friction(k)*max(-opening, 0.0_wp)
         rests(k) = sliding**2 + (ratio(k)*max(opening, 0.0_wp))**2 <= strength**2
         at_start(1, k) = pull(k)*(2.0_wp*sx(k) + ex(k))
         at_start(2, k) = pull(k)*(2.0_wp*sy(k) + ey(k))
         at_end(1, k) = pull(k)*(sx(k) + 2.0_wp*ex(k))
         at_end(2, k) = pull(k)*(sy(k) + 2.0_wp*ey(k))
      end do
   end subroutine pull_block

   !> Add the pulls of a block of bonds to the nodal forces.
   pure subroutine add_block(n, nodes, node, at_start, at_end, force)
      integer, intent(in) :: n, nodes, node(4, n)
      real(wp), intent(in) :: at_start(2, n), at_end(2, n)
      real(wp), intent(inout) :: force(2, nodes)
      integer :: k, i

      do k = 1, n
         do i = 1, 2
            force(i, node(1, k)) = force(i, node(1, k)) + at_start(i, k)
            force(i, node(2, k)) = force(i, node(2, k)) + at_end(i, k)
            force(i, node(3, k)) = force(i, node(3, k)) - at_start(i, k)
            force(i, node(4, k)) = force(i, node(4, k)) - at_end(i, k)
         end do
      end do
   end subroutine add_block

   !> Let the points of bonds at rest catch up with the displacement.
   pure subroutine follow_points(node, law, x, u, watch, point)
      !> As in bond_forces
      integer, contiguous, intent(in) :: node(:, :)
      type(cohesive_t), intent(in) :: law(:)
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> resting, watched or followed (bonds)
      integer, contiguous, intent(inout) :: watch(:)
      type(cohesive_point_t), contiguous, intent(inout) :: point(:, :)
      real(wp) :: i(2), j(2), length, along(bond_points), across(bond_points)
      integer :: b, k

      do b = 1, size(watch)
         if (watch(b) /= resting) cycle
         call place_points(node(:, b), x, u, i, j, length, along, across)
         do k = 1, bond_points
            call cohesive_update(law(b), across(k), along(k), point(k, b), .true.)
         end do
         watch(b) = watched
      end do
   end subroutine follow_points

   !> Stiffness of a bond, minus the derivative of its nodal forces, when its points go from `before` to the displacement u in
   !> one step. How the directions of opening and slip turn is left out where it is multiplied by a stress: that part is
   !> smaller by stress over modulus.
   pure function bond_tangent(length, law, shift, x, u, before, softens) result(stiffness)
      !> Length before any motion [m]
      real(wp), intent(in) :: length
      type(cohesive_t), intent(in) :: law
      !> Opening and slip that come on top of those of the nodes (2, points) [m]
      real(wp), intent(in) :: shift(:, :)
      !> Reference coordinates and displacement of A, B, A', B' (2, 4) [m]
      real(wp), intent(in) :: x(2, 4), u(2, 4)
      !> State that the points start from (points)
      type(cohesive_point_t), intent(in) :: before(:)
      !> With its softening, or with that taken as no stiffness? Without it the matrix of a body is regular, and an iteration
      !> with it moves away from equilibria that are not stable.
      logical, intent(in) :: softens
      !> Components x, y of node after node (8, 8) [N/m per m of thickness]
      real(wp) :: stiffness(8, 8)
      real(wp) :: i(2), j(2), median(2), delta(2), place(2, 4), along, across, tangent(2, 2), shape(4)
      real(wp) :: turn(8), gradient(8, 2), extent
      real(wp), parameter :: upper(4) = [-1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp], end(4) = [-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
      integer :: k, n

      place = x + u
      median = 0.5_wp*matmul(place, end)
      extent = max(norm2(median), no_length)
      i = median/extent
      j = [-i(2), i(1)]
      turn = [(0.5_wp*end(n)/extent*j, n=1, 4)]
      stiffness = 0.0_wp
      do k = 1, bond_points
         shape = upper*[1.0_wp - bond_place(k), bond_place(k), 1.0_wp - bond_place(k), bond_place(k)]
         delta = matmul(u, shape)
         along = dot_product(delta, i)
         across = dot_product(delta, j)
         gradient(:, 1) = [(shape(n)*j, n=1, 4)] - along*turn
         gradient(:, 2) = [(shape(n)*i, n=1, 4)] + across*turn
         tangent = cohesive_tangent(law, across + shift(1, k), along + shift(2, k), before(k))
         if (.not. softens) tangent = without_softening(tangent)
         stiffness = stiffness + bond_weight(k)*length*matmul(gradient, matmul(tangent, transpose(gradient)))
      end do
   end function bond_tangent

   !> A tangent whose symmetric part has its negative eigenvalues taken as zero.
   pure function without_softening(tangent) result(regular)
      real(wp), intent(in) :: tangent(2, 2)
      real(wp) :: regular(2, 2)
      real(wp) :: mean, half, shear, radius, low, high, along(2), skew

      mean = 0.5_wp*(tangent(1, 1) + tangent(2, 2))
      half = 0.5_wp*(tangent(1, 1) - tangent(2, 2))
      shear = 0.5_wp*(tangent(1, 2) + tangent(2, 1))
      skew = 0.5_wp*(tangent(1, 2) - tangent(2, 1))
      radius = hypot(half, shear)
      low = mean - radius
      high = mean + radius
      regular = tangent
      if (low >= 0.0_wp) return
      regular = reshape([0.0_wp, -skew, skew, 0.0_wp], [2, 2])
      if (high <= 0.0_wp) return
      ! Direction of the larger eigenvalue: twice its angle has cosine half/radius and sine shear/radius
      along = [cos(0.5_wp*atan2(shear, half)), sin(0.5_wp*atan2(shear, half))]
      regular = regular + high*spread(along, 2, 2)*spread(along, 1, 2)
   end function without_softening

   !> Add opposite forces to the ends of a bond: they pull the walls together.
   pure subroutine add_nodal_forces(node, at_start, at_end, force)
      !> A, B, A', B'
      integer, intent(in) :: node(4)
      !> Pull on A and on B (2) [N per m]
      real(wp), intent(in) :: at_start(2), at_end(2)
      real(wp), contiguous, intent(inout) :: force(:, :)

      force(:, node(1)) = force(:, node(1)) + at_start
      force(:, node(2)) = force(:, node(2)) + at_end
      force(:, node(3)) = force(:, node(3)) - at_start
      force(:, node(4)) = force(:, node(4)) - at_end
   end subroutine add_nodal_forces

   !> Add the bonds' part to the nodal bounds of the stiffness (see solid_m): a bond's matrix k N N^T has the row sums
   !> 2 k integral of N = k L at each of its nodes.
   pure subroutine bond_stiffness_bound(active, node, length, law, bound)
      logical, contiguous, intent(in) :: active(:)
      integer, contiguous, intent(in) :: node(:, :)
      real(wp), contiguous, intent(in) :: length(:)
      type(cohesive_t), intent(in) :: law(:)
      !> Nodal bound (nodes) [N/m per m of thickness]
      real(wp), contiguous, intent(inout) :: bound(:)
      integer :: b, k

      do b = 1, size(node, 2)
         if (.not. active(b)) cycle
         do k = 1, 4
            bound(node(k, b)) = bound(node(k, b)) + law(b)%stiffness*length(b)
         end do
      end do
   end subroutine bond_stiffness_bound

   !> Have two of the three points softened completely?
   pure logical function bond_is_broken(point)
      type(cohesive_point_t), intent(in) :: point(bond_points)

      bond_is_broken = count(point%damage >= 1.0_wp) >= points_to_break
   end function bond_is_broken

   !> Have all points softened, so that nothing but contact is left?
   pure logical function bond_has_parted(point)
      type(cohesive_point_t), intent(in) :: point(bond_points)

      bond_has_parted = all(point%damage >= 1.0_wp)
   end function bond_has_parted

   !> Fracture energy that a bond has spent by opening and by slip [J per m of thickness].
   pure function bond_energy(length, point) result(energy)
      real(wp), intent(in) :: length
      type(cohesive_point_t), intent(in) :: point(bond_points)
      real(wp) :: energy(2)

      energy = length*[dot_product(bond_weight, point%spent_i), dot_product(bond_weight, point%spent_ii)]
   end function bond_energy

   !> Mode in which a bond spent its energy.
   pure integer function bond_mode(energy) result(mode)
      !> By opening and by slip [J/m]
      real(wp), intent(in) :: energy(2)

      mode = mode_mixed
      if (energy(1) >= pure_part*sum(energy)) mode = mode_i
      if (energy(2) >= pure_part*sum(energy)) mode = mode_ii
   end function bond_mode

end module bond_m
