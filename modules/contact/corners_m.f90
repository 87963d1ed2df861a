!> Corners of blocks where fractures cross: blocks that share a crossing and no fracture must not pass through each other.
!>
!> Where two fractures cross and both slip, the blocks of one diagonal are driven point against point. No wall of one faces a
!> wall of the other there but over the length that the corners have already passed each other, which holds next to nothing.
!> Each pair of such blocks therefore has a contact of its own, from the slips of the fractures between them:
!>
!>          \ N /       r, the way that corner P has slid into corner Q, is the sum of the slips of the arms
!>         W \ / E      between them (here N and S; by W and by E, the mean of both ways round). Closure of
!>            X         the arms has no part in it: it is no overlap of rock. P is in Q when r lies in the cone
!>         W / \ E      that Q and P turned by half a turn span; a and b are the depths behind its two sides.
!>          / S \
!>
!> P may leave Q sideways, behind either side; which of two rigid points gives way is not determined by their shape. Here the
!> fracture that slips more at the crossing goes through and the lesser depth b is held, by the energy K/2 (b - b0)^2; of two
!> alike both are. Less and more are of what has slipped in the stage: what an earlier one has left may be more than a drive has
!> moved by its first increment. This is decided at rest (decide_corners), and remembered until P has come out of Q or is driven
!> against the side that holds (turn_corners). What is to turn once more stands point against point, and holds at both sides.
!> b0 is first b at that rest, which no choice disturbs; from there it falls to a quarter at a time as far as there is
!> rest. While nothing is decided the corners are free, so that the choice does not know of meshes or of the way to
!> equilibrium, and what is held is convex: a force from the lesser of both depths at every moment would make points
!> balance on each other, an equilibrium that is none. All is of second degree: slip is proportional to load. K is of the
!> order of the stiffness of the rock at a node, whatever the size of the elements. Beyond half an element walls face each
!> other (wall_contact_m) and the corner lets go. Directions are those before any motion.
module corners_m
   use kinds_m, only: wp
   use crossings_m, only: corners_t
   implicit none
   private

   !> What corners remember: which of them are held, and where
   type, public :: corner_choices_t
      !> Sides behind which P is held: free, 1, 2, both (pairs). A cone wider than half a turn holds at both
      integer, allocatable :: held(:)
      !> Depth at which each side holds (2, pairs) [m]: the corner had come so far when it was free
      real(wp), allocatable :: passed(:, :)
      !> Depths behind both sides when the stage began (2, pairs) [m]
      real(wp), allocatable :: stage_depth(:, :)
      !> Times that the side that holds has turned since P came into Q, or since the stage began (pairs)
      integer, allocatable :: turns(:)
      !> Is the closure between the corners kept as it is, and what is it then (2, pairs) [m]? See keep_closure
      logical :: closure_kept = .false.
      real(wp), allocatable :: closure(:, :)
   end type corner_choices_t

   !> Bound of the stiffness that a held side has for the stable step, over its own: forces on two nodes, each of which moves
   !> the way of P by itself at the most
   real(wp), parameter :: bound_factor = 6.0_wp
   !> Choices for a corner, beside 1 and 2, the side that holds
   integer, parameter :: free = 0, both = 3
   !> Depths below this part of the reach are none; depths that differ by less than this part are alike
   real(wp), parameter :: least_depth = 1.0e-4_wp, alike = 0.02_wp

   !> Of two sides that hold one lets go when its force is so many times the other's
   real(wp), parameter :: clearly = 4.0_wp
   !> What P has moved by in the stage counts when it is more than this part of its depths
   real(wp), parameter :: least_move = 1.0e-3_wp

   !> Depth that counts, over the largest slip at a crossing and over the reach
   real(wp), parameter :: slip_passed = 5.0e-3_wp, reach_passed = 5.0e-4_wp
   !> Part that b0 falls to at a time
   real(wp), parameter, public :: press_back = 0.25_wp
   !> Times in an increment; times that sides are chosen anew in one
   integer, parameter, public :: most_pressed = 6, most_chosen = 3
   !> Unbalanced force ratio at which those that are pressed back may be pressed further
   real(wp), parameter, public :: while_pressed = 1.0e-4_wp

   public :: init_choices, free_choices, any_chosen, note_depths, decide_corners, turn_corners, press_further, any_passed, &
             any_held, keep_choices, keep_closure, follow_closure, add_corner_forces, corner_tangent, corner_nodes, &
             corner_stiffness_bound, corner_overlap

contains

   !> Nothing has slid yet: only cones wider than half a turn hold.
   pure subroutine init_choices(corners, choices)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(out) :: choices

      choices%held = merge(both, free, corners%wide)
      allocate (choices%turns(size(corners%wide)), source=0)
      allocate (choices%passed(2, size(corners%wide)), choices%stage_depth(2, size(corners%wide)), &
                choices%closure(2, size(corners%wide)), source=0.0_wp)
   end subroutine init_choices

   !> Way that corner P of a pair has slid into corner Q: slips and openings of the arms between them, without closure [m].
   pure function way(corners, p, u) result(r)
      type(corners_t), intent(in) :: corners
      !> Pair
      integer, intent(in) :: p
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp) :: r(2), jump(2)
      integer :: l

      r = 0.0_wp
      do l = corners%first(p), corners%first(p + 1) - 1
         jump = u(:, corners%across(2, l)) - u(:, corners%across(1, l))
         r = r + corners%share(l)*(dot_product(jump, corners%along(:, l))*corners%along(:, l) &
                                   + max(0.0_wp, dot_product(jump, corners%normal(:, l)))*corners%normal(:, l))
      end do
   end function way

   !> Keep the closure between the corners as it is, for solvers that follow a motion. What a pair feels then are its own two
   !> nodes alone: a force that has an energy. Else it feels nodes that feel nothing of it, which may feed an oscillation.
   pure subroutine keep_closure(corners, u, choices)
      type(corners_t), intent(in) :: corners
      real(wp), contiguous, intent(in) :: u(:, :)
      type(corner_choices_t), intent(inout) :: choices
      integer :: p

      choices%closure_kept = .true.
      do p = 1, size(corners%stiffness)
         choices%closure(:, p) = u(:, corners%node(1, p)) - u(:, corners%node(2, p)) - way(corners, p, u)
      end do
   end subroutine keep_closure

   !> After a step of a motion: the closure that was kept goes on to what it is now, and corners that were let pass are pressed
   !> back, as far as the corners then hold no more energy than there is for them; what they hold may always become less. With the
   !> closure as it is at every moment, as solvers that know rest alone have it, their forces have no energy, and feed a motion that
   !> nothing damps.
   pure subroutine follow_closure(corners, u, left, energy, choices)
      type(corners_t), intent(in) :: corners
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      !> Part that is left of what was let pass; 1: corners are not pressed back
      real(wp), intent(in) :: left
      !> What has gone into the corners, and what else there is for them [J per m of thickness]
      real(wp), intent(in) :: energy
      type(corner_choices_t), intent(inout) :: choices
      !> Halvings of the way to the closure where it can be gone in part only
      integer, parameter :: halvings = 10
      real(wp), dimension(2, size(corners%stiffness)) :: kept, now, passed
      real(wp) :: most, low, high
      integer :: i

      if (size(corners%stiffness) == 0) return
      if (.not. choices%closure_kept) then
         call keep_closure(corners, u, choices)
         return
      end if
      kept = choices%closure
      passed = choices%passed
      most = max(energy, corner_energy(corners, choices, u))
      call keep_closure(corners, u, choices)
      call press_further(choices, left)
      if (corner_energy(corners, choices, u) <= most) return
      choices%passed = passed
      if (corner_energy(corners, choices, u) <= most) return
      now = choices%closure
      low = 0.0_wp
      high = 1.0_wp
      do i = 1, halvings
         choices%closure = kept + 0.5_wp*(low + high)*(now - kept)
         if (corner_energy(corners, choices, u) <= most) then
            low = 0.5_wp*(low + high)
         else
            high = 0.5_wp*(low + high)
         end if
      end do
      choices%closure = kept + low*(now - kept)
      do i = 1, size(choices%held)
         if (choices%held(i) == free) choices%closure(:, i) = now(:, i)
      end do
   end subroutine follow_closure

   !> Energy that corners hold, that of the forces of press [J per m of thickness].
   pure real(wp) function corner_energy(corners, choices, u) result(energy)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp) :: depth(2), beyond(2), part, slope, curvature
      integer :: p, i

      energy = 0.0_wp
      do p = 1, size(corners%stiffness)
         if (choices%held(p) == free) cycle
         depth = matmul(way_felt(corners, choices, p, u), corners%inward(:, :, p))
         beyond = behind_held(choices, p, max(0.0_wp, depth - choices%passed(:, p)))
         do i = 1, 2
            part = 1.0_wp
            if (.not. corners%wide(p)) call let_go(depth(3 - i)/corners%reach(p), part, slope, curvature)
            energy = energy + 0.5_wp*corners%stiffness(p)*part*beyond(i)**2
         end do
      end do
   end function corner_energy

   !> Way of P into Q that the forces know of: with the closure between them as it is, or as it was kept [m].
   pure function way_felt(corners, choices, p, u) result(r)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      integer, intent(in) :: p
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp) :: r(2)

      if (choices%closure_kept) then
         r = u(:, corners%node(1, p)) - u(:, corners%node(2, p)) - choices%closure(:, p)
      else
         r = way(corners, p, u)
      end if
   end function way_felt

   !> Let all corners go that are held by choice.
   pure subroutine free_choices(corners, choices)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(inout) :: choices

      where (.not. corners%wide) choices%held = free
      choices%passed = 0.0_wp
   end subroutine free_choices

   !> Is any corner held by choice?
   pure logical function any_chosen(corners, choices)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices

      any_chosen = any(choices%held /= free .and. .not. corners%wide)
   end function any_chosen

   !> Is any corner held?
   pure logical function any_held(choices)
      type(corner_choices_t), intent(in) :: choices

      any_held = any(choices%held /= free)
   end function any_held

   !> Is any corner held at a depth that it had come to when it was free, and that counts against the slips at crossings?
   pure logical function any_passed(corners, choices, u)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp) :: slip, deepest
      integer :: p, l

      slip = 0.0_wp
      do l = 1, size(corners%share)
         slip = max(slip, abs(dot_product(u(:, corners%across(2, l)) - u(:, corners%across(1, l)), corners%along(:, l))))
      end do
      any_passed = .false.
      do p = 1, size(choices%held)
         if (corners%wide(p)) cycle
         deepest = maxval(behind_held(choices, p, choices%passed(:, p)))
         any_passed = any_passed .or. deepest > min(slip_passed*slip, reach_passed*corners%reach(p))
      end do
   end function any_passed

   !> Press corners that were let pass further back.
   pure subroutine press_further(choices, part)
      type(corner_choices_t), intent(inout) :: choices
      !> Part that is left; press_back unless given
      real(wp), intent(in), optional :: part

      if (present(part)) then
         choices%passed = part*choices%passed
      else
         choices%passed = press_back*choices%passed
      end if
   end subroutine press_further

   !> Of two depths those behind sides that are held, 0 for the other [m].
   pure function behind_held(choices, p, depth) result(held)
      type(corner_choices_t), intent(in) :: choices
      integer, intent(in) :: p
      real(wp), intent(in) :: depth(2)
      real(wp) :: held(2)

      held = merge(depth, 0.0_wp, [any(choices%held(p) == [1, both]), any(choices%held(p) == [2, both])])
   end function behind_held

   !> Slope and curvature of the energy of a pair by the way that P has slid into Q.
   pure subroutine press(corners, choices, p, r, slope, curvature)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      integer, intent(in) :: p
      !> [m]
      real(wp), intent(in) :: r(2)
      !> [N per m of thickness], [N/m per m of thickness]
      real(wp), intent(out) :: slope(2), curvature(2, 2)
      real(wp) :: depth(2), beyond(2), part, part_1, part_2
      integer :: i

      slope = 0.0_wp
      curvature = 0.0_wp
      depth = matmul(r, corners%inward(:, :, p))
      beyond = depth - choices%passed(:, p)
      do i = 1, 2
         if (beyond(i) <= 0.0_wp .or. .not. any(choices%held(p) == [i, both])) cycle
         part = 1.0_wp
         part_1 = 0.0_wp
         part_2 = 0.0_wp
         if (.not. corners%wide(p)) call let_go(depth(3 - i)/corners%reach(p), part, part_1, part_2)
         part_1 = part_1/corners%reach(p)
         part_2 = part_2/corners%reach(p)**2
         associate (k => corners%stiffness(p), own => corners%inward(:, i, p), other => corners%inward(:, 3 - i, p))
            slope = slope + k*beyond(i)*(part*own + 0.5_wp*beyond(i)*part_1*other)
            curvature = curvature + k*(part*outer(own, own) + beyond(i)*part_1*(outer(own, other) + outer(other, own)) &
                                       + 0.5_wp*beyond(i)**2*part_2*outer(other, other))
         end associate
      end do
   end subroutine press

   !> Part of its force that a corner still has when it has passed the other one by a distance over its reach: (1 - d^2)^2,
   !> all before it has passed; with two derivatives.
   pure subroutine let_go(distance, part, slope, curvature)
      real(wp), intent(in) :: distance
      real(wp), intent(out) :: part, slope, curvature
      real(wp) :: d

      d = min(1.0_wp, max(0.0_wp, distance))
      part = (1.0_wp - d**2)**2
      slope = -4.0_wp*d*(1.0_wp - d**2)
      curvature = 0.0_wp
      if (d > 0.0_wp .and. d < 1.0_wp) curvature = 12.0_wp*d**2 - 4.0_wp
   end subroutine let_go

   !> A stage begins: how far P is in Q.
   pure subroutine note_depths(corners, u, choices)
      type(corners_t), intent(in) :: corners
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      type(corner_choices_t), intent(inout) :: choices
      integer :: p

      choices%turns = 0
      do p = 1, size(corners%stiffness)
         choices%stage_depth(:, p) = matmul(way(corners, p, u), corners%inward(:, :, p))
      end do
   end subroutine note_depths

   !> At rest: hold the corners that have come into each other, where they are, and let those go that have come out. What is at
   !> rest stays so, unless a side that turned out to be the wrong one lets go.
   pure subroutine decide_corners(corners, u, choices, changed, let_go)
      type(corners_t), intent(in) :: corners
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      type(corner_choices_t), intent(inout) :: choices
      !> Has any choice changed?
      logical, intent(out) :: changed
      !> Has a side let go that pressed? Where it is not asked for none does
      logical, intent(out), optional :: let_go
      real(wp) :: depth(2), came(2)
      integer :: p, held

      changed = .false.
      if (present(let_go)) let_go = .false.
      do p = 1, size(corners%stiffness)
         if (corners%wide(p)) cycle
         depth = matmul(way(corners, p, u), corners%inward(:, :, p))
         came = depth - choices%stage_depth(:, p)
         held = choices%held(p)
         if (held /= free) then
            if (present(let_go)) held = side_that_stays(corners, choices, p, depth)
            if (present(let_go)) let_go = let_go .or. held /= choices%held(p)
            if (minval(depth) < -least_depth*corners%reach(p) .or. maxval(depth) >= corners%reach(p)) held = free
         else if (minval(depth) > least_depth*corners%reach(p) .and. maxval(depth) < corners%reach(p)) then
            if (maxval(abs(came)) < least_move*maxval(depth)) came = depth
            held = minloc(came, dim=1)
            if (maxval(came) - minval(came) <= alike*maxval(abs(came))) held = both
         end if
         choices%passed(:, p) = max(0.0_wp, min(choices%passed(:, p), depth))
         if (held == choices%held(p)) cycle
         changed = .true.
         ! A side that stays goes on with its force
         if (choices%held(p) /= both .or. held == free) choices%passed(:, p) = max(0.0_wp, depth)
         choices%held(p) = held
         if (held == free) choices%turns(p) = 0
      end do
   end subroutine decide_corners

   !> At rest: where P is driven against the side that holds, the other side holds in its place. The force on a side moves rock by
   !> about F/E; a side lets go when that is more than P stands behind the other side, the height of the step that holds it,
   !> or when in the increment it has grown by more than P has gone on there.
   pure subroutine turn_corners(corners, began, u, choices, turned)
      type(corners_t), intent(in) :: corners
      !> Displacement at the start of the increment and at rest (2, nodes) [m]
      real(wp), contiguous, intent(in) :: began(:, :), u(:, :)
      type(corner_choices_t), intent(inout) :: choices
      logical, intent(out) :: turned
      real(wp) :: before(2), depth(2), given, more, none
      integer :: p, other

      turned = .false.
      do p = 1, size(corners%stiffness)
         if (corners%wide(p) .or. .not. any(choices%held(p) == [1, 2])) cycle
         before = matmul(way(corners, p, began), corners%inward(:, :, p))
         depth = matmul(way(corners, p, u), corners%inward(:, :, p))
         none = least_depth*corners%reach(p)
         associate (held => choices%held(p))
            other = 3 - held
            given = corners%factor*(depth(held) - choices%passed(held, p))
            more = given - corners%factor*max(0.0_wp, before(held) - choices%passed(held, p))
            if (given <= max(before(other), depth(other), none) .and. &
                more <= max(depth(other) - before(other), none)) cycle
            held = other
            choices%turns(p) = choices%turns(p) + 1
            if (choices%turns(p) > 1) held = both
         end associate
         turned = .true.
         choices%passed(:, p) = max(0.0_wp, before)
      end do
   end subroutine turn_corners

   !> Of two sides that hold, the one to go on with when the force on the other has become far larger: P has been driven behind that
   !> one since they were chosen.
   pure integer function side_that_stays(corners, choices, p, depth) result(held)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      integer, intent(in) :: p
      !> Behind both sides [m]
      real(wp), intent(in) :: depth(2)
      real(wp) :: driven(2)

      held = choices%held(p)
      if (held /= both .or. choices%turns(p) > 1) return
      driven = max(depth - choices%passed(:, p), least_depth*corners%reach(p)/max(1.0_wp, corners%factor))
      if (driven(1) > clearly*driven(2)) held = 2
      if (driven(2) > clearly*driven(1)) held = 1
   end function side_that_stays

   !> Choices go on after cuts of the mesh: those of the pair whose nodes were the same.
   pure subroutine keep_choices(before, chosen, parent, corners, choices)
      type(corners_t), intent(in) :: before
      type(corner_choices_t), intent(in) :: chosen
      !> Node that each node was before (nodes)
      integer, intent(in) :: parent(:)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(out) :: choices
      integer :: p, old

      call init_choices(corners, choices)
      do p = 1, size(corners%stiffness)
         do old = 1, size(before%stiffness)
            if (any(before%node(:, old) /= parent(corners%node(:, p))) .or. corners%wide(p)) cycle
            choices%held(p) = chosen%held(old)
            choices%passed(:, p) = chosen%passed(:, old)
            choices%turns(p) = chosen%turns(old)
            choices%stage_depth(:, p) = chosen%stage_depth(:, old)
         end do
      end do
   end subroutine keep_choices

   !> Product of a column and a row.
   pure function outer(column, row) result(product)
      real(wp), intent(in) :: column(2), row(2)
      real(wp) :: product(2, 2)

      product(:, 1) = column*row(1)
      product(:, 2) = column*row(2)
   end function outer

   !> Add the forces of all corners: each pair pushes its two nodes apart.
   pure subroutine add_corner_forces(corners, choices, u, force)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      !> Nodal forces (2, nodes) [N per m of thickness]
      real(wp), contiguous, intent(inout) :: force(:, :)
      real(wp) :: slope(2), curvature(2, 2)
      integer :: p

      do p = 1, size(corners%stiffness)
         if (choices%held(p) == free) cycle
         call press(corners, choices, p, way_felt(corners, choices, p, u), slope, curvature)
         associate (node => corners%node(:, p))
            force(:, node(1)) = force(:, node(1)) - slope
            force(:, node(2)) = force(:, node(2)) + slope
         end associate
      end do
   end subroutine add_corner_forces

   !> Nodes that the stiffness of a pair joins: its two, then those of its legs, in pairs; some more than once.
   pure function corner_nodes(corners, p) result(node)
      type(corners_t), intent(in) :: corners
      integer, intent(in) :: p
      integer, allocatable :: node(:)
      integer :: legs

      legs = corners%first(p + 1) - corners%first(p)
      node = [corners%node(:, p), reshape(corners%across(:, corners%first(p):corners%first(p + 1) - 1), [2*legs])]
   end function corner_nodes

   !> Stiffness of a pair: minus the derivative of its forces by the displacements of its corner_nodes, components x, y of
   !> node after node (2 nodes, 2 nodes) [N/m per m of thickness]. Not symmetric: what lies between feels nothing.
   pure function corner_tangent(corners, choices, p, u) result(stiffness)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      integer, intent(in) :: p
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp), allocatable :: stiffness(:, :)
      real(wp) :: slope(2), curvature(2, 2), leg(2, 2), jump(2)
      integer :: l, at

      associate (legs => corners%first(p + 1) - corners%first(p))
         allocate (stiffness(4*(legs + 1), 4*(legs + 1)), source=0.0_wp)
      end associate
      call press(corners, choices, p, way(corners, p, u), slope, curvature)
      do l = corners%first(p), corners%first(p + 1) - 1
         jump = u(:, corners%across(2, l)) - u(:, corners%across(1, l))
         leg = outer(corners%along(:, l), corners%along(:, l))
         if (dot_product(jump, corners%normal(:, l)) > 0.0_wp) leg = leg + outer(corners%normal(:, l), corners%normal(:, l))
         leg = corners%share(l)*matmul(curvature, leg)
         at = 4*(l - corners%first(p) + 1)
         stiffness(1:2, at + 1:at + 2) = -leg
         stiffness(1:2, at + 3:at + 4) = leg
      end do
      stiffness(3:4, :) = -stiffness(1:2, :)
   end function corner_tangent

   !> Add the stiffness of the corners that are held to the nodal bounds (see solid_m): it holds until a choice changes.
   pure subroutine corner_stiffness_bound(corners, choices, bound)
      type(corners_t), intent(in) :: corners
      type(corner_choices_t), intent(in) :: choices
      !> (nodes) [N/m per m of thickness]
      real(wp), intent(inout) :: bound(:)
      integer :: p

      do p = 1, size(corners%stiffness)
         associate (node => corners%node(:, p))
            bound(node) = bound(node) + bound_factor*real(sides_held(choices, p), wp)*corners%stiffness(p)
         end associate
      end do
   end subroutine corner_stiffness_bound

   !> Number of sides behind which a corner is held.
   pure integer function sides_held(choices, p)
      type(corner_choices_t), intent(in) :: choices
      integer, intent(in) :: p

      sides_held = merge(1, 0, any(choices%held(p) == [1, 2, both])) + merge(1, 0, choices%held(p) == both)
   end function sides_held

   !> Deepest overlap of two corners beyond the closure of the joints [m], and where (pair, 0: nowhere).
   pure subroutine corner_overlap(corners, u, deepest, where)
      type(corners_t), intent(in) :: corners
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp), intent(out) :: deepest
      integer, intent(out) :: where
      real(wp) :: depth(2)
      integer :: p

      deepest = 0.0_wp
      where = 0
      do p = 1, size(corners%stiffness)
         depth = matmul(way(corners, p, u), corners%inward(:, :, p))
         if (minval(depth) <= deepest .or. norm2(depth) > corners%reach(p)) cycle
         deepest = minval(depth)
         where = p
      end do
   end subroutine corner_overlap

end module corners_m
