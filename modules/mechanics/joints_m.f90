!> The joints of a scene and their coupling with the rock, each step (section 2.3.3 of the paper, eqs 27 to 33).
!>
!> From the displacements come each joint's opening and shear (eqs 27-30, paired as at the start) and, where the walls
!> touch now, their overlap; from the overlap the contact pressure; from pressure and shear the joint's law gives shear
!> stress, closure, dilation and mobilised friction; pressure and shear stress go back to the walls as forces.
module joints_m
   use kinds_m, only: wp
   use constants_m, only: megapascal, millimetre
   use mesh_m, only: split_mesh_t
   use joint_point_m, only: joint_point_t
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use joint_law_m, only: law_item_t
   use jcm_m, only: aperture
   use riding_m, only: ride_t, ride, closure_pressure, closure_under, pressure_stiffness
   use solid_m, only: solid_t, solid_stress
   use closure_tangents_m, only: closure_tangents_t
   use wall_layout_m, only: wall_contact_t
   use wall_contact_m, only: wall_meeting_t, points_of_joints, wall_slip_rate
   implicit none
   private

   !> All joint elements and what their decks say of the coupling
   type, public :: joints_t
      !> Nodes A, B, A', B' (4, joints) and triangles of the lower and upper wall (2, joints)
      integer, allocatable :: node(:, :), triangle(:, :)
      !> Index of the deck's &joint group (joints)
      integer, allocatable :: group(:)
      !> Law with its parameters at the scale of the joint's block edge (joints)
      type(law_item_t), allocatable :: law(:)
      !> Length before any motion (joints) [m]
      real(wp), allocatable :: length(:)
      !> Penalty stiffness of the walls; 0: the joint's own stiffness (joints) [MPa/mm]
      real(wp), allocatable :: penalty(:)
      !> Does dilation push the walls? Velocity friction (eq 4)? Normal stress from the rock (eq 32)? (joints)
      logical, allocatable :: coupled(:), velocity_friction(:), stress_from_walls(:)
      !> Aperture by eq 31 to the letter? (joints)
      logical, allocatable :: literal_aperture(:)
      !> Joints in wall contact (joints); the others are in potential contact
      logical, allocatable :: wall_handled(:)
      !> Is it a bond that has not parted, whose walls are no matter of contact yet? (joints)
      logical, allocatable :: bonded(:)
      !> Has the rock on a side of it been taken out, so that it is a joint no more? (joints)
      logical, allocatable :: gone(:)
      !> Overlap of the walls and slip in the in-situ state, in which nothing has moved (joints) [mm]
      real(wp), allocatable :: closed(:), slipped(:)
   end type joints_t

   !> What passes between the walls of joints
   type, public :: tractions_t
      !> Pressure and shear stress at the walls' integration points [Pa]; mean contact pressure of each joint on what is covered
      !> of its walls [MPa], and what is covered over their length now [-] (joints)
      real(wp), allocatable :: pressure(:), shear(:), contact_stress(:), covered(:)
      !> d pressure/d overlap at those of the walls' integration points that press [MPa/mm]
      real(wp), allocatable :: by_closure(:)
      !> Normal stiffness of each joint where it is stiffest, weighed by what it covers there (joints) [MPa/mm]
      real(wp), allocatable :: contact_stiffness(:)
      !> Larger of normal and shear stiffness when the stable step was last computed (joints) [MPa/mm]
      real(wp), allocatable :: stiffness_then(:)
      !> Coupled joints: dilation of the last step (joints); d dilation/d overlap [-] and d dilation/d weight, the weight as a
      !> part of what is covered of the joint's walls [mm], at the integration points
      type(ride_t), allocatable :: ride(:)
      real(wp), allocatable :: by_overlap(:), by_weight(:)
      !> Newton's method far from rest: closure by tangents
      type(closure_tangents_t) :: tangents
   end type tractions_t

   public :: init_joints, init_tractions, add_joints, couple_walls, couple_potential, joint_stiffness, have_stiffened, &
             wall_overlap, press_softer

   !> The stable step has to be computed again when a joint has become this much stiffer
   real(wp), parameter :: stiffer = 1.1_wp

contains

   !> Room and geometry; the caller fills in law, group and options from the deck.
   subroutine init_joints(split, joints)
      type(split_mesh_t), intent(in) :: split
      type(joints_t), intent(out) :: joints
      integer :: n, j

      n = size(split%joint, 2)
      joints%node = split%joint
      joints%triangle = split%joint_triangle
      allocate (joints%group(n), source=0)
      allocate (joints%law(n))
      allocate (joints%penalty(n), source=0.0_wp)
      allocate (joints%coupled(n), joints%velocity_friction(n), joints%stress_from_walls(n), joints%literal_aperture(n), &
                source=.false.)
      allocate (joints%wall_handled(n), source=.true.)
      allocate (joints%bonded(n), source=.false.)
      allocate (joints%closed(n), joints%slipped(n), source=0.0_wp)
      allocate (joints%length(n), joints%gone(n))
      do j = 1, n
         joints%gone(j) = .not. all(split%present(split%joint_triangle(:, j)))
         joints%length(j) = norm2(split%x(:, split%joint(2, j)) - split%x(:, split%joint(1, j)))
      end do
   end subroutine init_joints

   !> Walls that feel nothing yet.
   pure subroutine init_tractions(joints, tractions)
      !> Number of joint elements
      integer, intent(in) :: joints
      type(tractions_t), intent(out) :: tractions

      allocate (tractions%contact_stress(joints), tractions%contact_stiffness(joints), tractions%stiffness_then(joints), &
                source=0.0_wp)
      allocate (tractions%covered(joints), source=1.0_wp)
      allocate (tractions%ride(joints))
      allocate (tractions%pressure(0), tractions%shear(0), tractions%by_closure(0), tractions%by_overlap(0), tractions%by_weight(0))
   end subroutine init_tractions

   !> Room for more joint elements, whose walls feel nothing yet.
   pure subroutine add_joints(joints, tractions)
      !> Number of joint elements, with the new ones
      integer, intent(in) :: joints
      type(tractions_t), intent(inout) :: tractions
      type(tractions_t) :: old

      old = tractions
      call init_tractions(joints, tractions)
      associate (n => size(old%covered))
         tractions%contact_stress(:n) = old%contact_stress
         tractions%contact_stiffness(:n) = old%contact_stiffness
         tractions%covered(:n) = old%covered
         tractions%stiffness_then(:n) = old%stiffness_then
      end associate
   end subroutine add_joints

   !> Update all joints in wall contact; leaves the tractions at the walls' integration points.
   subroutine couple_walls(joints, walls, met, solid, x, u, v, tractions, point, opening, open_aperture)
      type(joints_t), intent(in) :: joints
      type(wall_contact_t), intent(in) :: walls
      !> Where they meet, found for the displacement u
      type(wall_meeting_t), intent(in) :: met
      type(solid_t), intent(in) :: solid
      !> Reference coordinates [m], displacement [m] and velocity [m/s] (2, nodes)
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :), v(:, :)
      type(tractions_t), intent(inout) :: tractions
      !> State of the joints (joints)
      type(joint_point_t), contiguous, intent(inout) :: point(:)
      !> Opening w and aperture (joints) [mm]
      real(wp), intent(inout) :: opening(:), open_aperture(:)
      type(joint_frame_t) :: frame(size(walls%joint)/2)
      integer :: first(size(walls%joint)/2 + 1), i, j, k
      real(wp) :: slip_rate, force

      call make_room(met, tractions)
      if (tractions%tangents%on) call tractions%tangents%carry(met)
      call points_of_joints(met, first)
      ! All pressures by the joints as they were at the start of the step: walls may face another joint's
      do i = 1, size(frame)
         j = walls%joint(2*i)
         frame(i) = frame_of(joints, j, x, u)
         call find_pressure(joints, met, j, first(i), first(i + 1) - 1, solid, u, frame(i), point, tractions)
      end do
      do i = 1, size(frame)
         j = walls%joint(2*i)
         call update(joints, tractions, j, solid, u, frame(i), point(j), opening(j), open_aperture(j))
      end do
      do k = 1, met%points
         j = walls%joint(met%wall(k))
         force = tractions%pressure(k)
         tractions%shear(k) = 0.0_wp
         if (force <= 0.0_wp .or. point(j)%sn <= 0.0_wp) cycle
         if (joints%velocity_friction(j)) then
            slip_rate = wall_slip_rate(met, k, v)
            if (abs(slip_rate) > 0.0_wp) tractions%shear(k) = sign(point(j)%mu_mob*force, slip_rate)     ! (4)
         else
            tractions%shear(k) = point(j)%tau/point(j)%sn*force
         end if
      end do
   end subroutine couple_walls

   !> Room for what is known at the integration points.
   subroutine make_room(met, tractions)
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(inout) :: tractions

      if (size(tractions%pressure) >= met%points) return
      deallocate (tractions%pressure, tractions%shear, tractions%by_closure, tractions%by_overlap, tractions%by_weight)
      allocate (tractions%pressure(size(met%wall)), tractions%shear(size(met%wall)), tractions%by_closure(size(met%wall)))
      allocate (tractions%by_overlap(size(met%wall)), tractions%by_weight(size(met%wall)))
   end subroutine make_room

   !> Contact pressure from the overlap at the integration points of a joint's walls, and its mean over what is covered of them.
   subroutine find_pressure(joints, met, j, first, last, solid, u, frame, point, tractions)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      !> Joint, the first and last integration point of its walls
      integer, intent(in) :: j, first, last
      type(solid_t), intent(in) :: solid
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      type(joint_frame_t), intent(in) :: frame
      !> State of the joints at the start of the step (joints)
      type(joint_point_t), contiguous, intent(in) :: point(:)
      type(tractions_t), intent(inout) :: tractions
      real(wp) :: stress, overlap, force, covered, stiffness, stiffest, weighed
      integer :: k, softer

      covered = sum(met%weight(first:last))
      ! Coupled walls ride up on their asperities: the closure by stress is the overlap plus the dilation
      if (joints%coupled(j)) then
         associate (gap => joints%closed(j) - met%gap(first:last)/millimetre, &
                    weight => met%weight(first:last)/max(tiny(covered), covered), &
                    du => slip_of(joints, j, frame) - point(j)%u, found => tractions%ride(j), &
                    by_overlap => tractions%by_overlap(first:last), by_weight => tractions%by_weight(first:last), &
                    other => merge(met%faced_joint(first:last), j, met%faced_joint(first:last) > 0))
            if (joints%stress_from_walls(j)) then
               call ride(joints%law, joints%penalty, point, j, other, du, gap, weight, found, by_overlap, by_weight, &
                         wall_stress(joints, j, solid, u, frame%j))
            else
               call ride(joints%law, joints%penalty, point, j, other, du, gap, weight, found, by_overlap, by_weight)
            end if
         end associate
      end if
      force = 0.0_wp
      stiffest = 0.0_wp
      weighed = 0.0_wp
      do k = first, last
         overlap = wall_overlap(joints, met, tractions, j, k)
         if (tractions%tangents%on .and. .not. joints%coupled(j)) then
            call press_on_tangent(joints, met, point, j, k, overlap, tractions%tangents%touch(k), stress, tractions%by_closure(k))
            tractions%pressure(k) = stress*megapascal
            force = force + stress*met%weight(k)
            cycle
         end if
         call press_softer(joints, met, point, j, k, overlap, softer, stress)
         tractions%pressure(k) = stress*megapascal
         force = force + stress*met%weight(k)
         if (stress <= 0.0_wp) cycle
         tractions%by_closure(k) = joints%penalty(softer)
         if (joints%penalty(softer) > 0.0_wp) cycle
         stiffness = joints%law(softer)%raw%normal_stiffness(point(softer), stress)
         tractions%by_closure(k) = stiffness
         stiffest = max(stiffest, stiffness)
         weighed = weighed + stiffness*met%weight(k)
      end do
      tractions%contact_stress(j) = 0.0_wp
      if (covered > 0.0_wp) tractions%contact_stress(j) = force/covered
      tractions%covered(j) = 0.0_wp
      if (last >= first) tractions%covered(j) = covered/met%length(met%wall(first))
      ! A point may bear on one node of an edge alone, of which the bound gives each half
      tractions%contact_stiffness(j) = min(stiffest, 2.0_wp*weighed/joints%length(j))
   end subroutine find_pressure

   !> Overlap of the walls at an integration point, positive when they touch; of walls that ride with their dilation [mm].
   pure real(wp) function wall_overlap(joints, met, tractions, j, k) result(overlap)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      !> Joint, integration point
      integer, intent(in) :: j, k

      overlap = joints%closed(j) - met%gap(k)/millimetre
      if (joints%coupled(j)) overlap = overlap + tractions%ride(j)%dilation
   end function wall_overlap

   !> The joint whose closure holds at an integration point. Where a wall has come to face the wall of another joint, beyond a
   !> crossing or on another block edge, it is the softer of the two: the closure that one has is no overlap for the other.
   pure subroutine press_softer(joints, met, point, j, k, overlap, softer, stress)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      !> Joints at the start of the step (joints)
      type(joint_point_t), contiguous, intent(in) :: point(:)
      !> Joint of the wall, integration point
      integer, intent(in) :: j, k
      !> [mm]
      real(wp), intent(in) :: overlap
      integer, intent(out) :: softer
      !> Contact pressure by its closure or its penalty [MPa]
      real(wp), intent(out) :: stress
      real(wp) :: faced

      softer = j
      stress = closure_pressure(joints%law(j)%raw, joints%penalty(j), point(j), overlap)
      associate (other => met%faced_joint(k))
         if (other == 0 .or. other == j .or. overlap <= 0.0_wp) return
         faced = closure_pressure(joints%law(other)%raw, joints%penalty(other), point(other), overlap)
         if (faced >= stress) return
         softer = other
         stress = faced
      end associate
   end subroutine press_softer

   !> Contact pressure at an integration point by a tangent of the closure curve (closure_tangents_m). Of two joints that face each
   !> other the softer one holds, which at a pressure is the one that has closed more.
   pure subroutine press_on_tangent(joints, met, point, j, k, overlap, touch, stress, stiffness)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      !> Joints at the start of the step (joints)
      type(joint_point_t), contiguous, intent(in) :: point(:)
      !> Joint of the wall, integration point
      integer, intent(in) :: j, k
      !> [mm]
      real(wp), intent(in) :: overlap
      !> Pressure at which the tangent touches: that of the iteration before in, of this one out [MPa]
      real(wp), intent(inout) :: touch
      !> [MPa], [MPa/mm]
      real(wp), intent(out) :: stress, stiffness

      call follow_tangent(stress, stiffness)
      touch = stress
      call follow_tangent(stress, stiffness)

   contains

      !> Pressure of the overlap on the tangent that touches there, and its slope.
      pure subroutine follow_tangent(stress, stiffness)
         real(wp), intent(out) :: stress, stiffness
         real(wp) :: closure, faced
         integer :: softer

         softer = j
         closure = closure_under(joints%law(j)%raw, joints%penalty(j), point(j), touch)
         associate (other => met%faced_joint(k))
            if (other > 0 .and. other /= j) then
               faced = closure_under(joints%law(other)%raw, joints%penalty(other), point(other), touch)
               if (faced > closure) softer = other
               closure = max(closure, faced)
            end if
         end associate
         stiffness = pressure_stiffness(joints%law(softer)%raw, joints%penalty(softer), point(softer), touch)
         stress = max(0.0_wp, touch + stiffness*(overlap - closure))
      end subroutine follow_tangent

   end subroutine press_on_tangent

   !> Update all joints in potential contact from the contact forces of the step before; their mobilised friction then
   !> bounds the friction of the next.
   subroutine couple_potential(joints, solid, x, u, normal, shear, tractions, point, opening, open_aperture)
      type(joints_t), intent(in) :: joints
      type(solid_t), intent(in) :: solid
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> Normal and shear stress of the contact, as means over the joints (joints) [Pa]
      real(wp), intent(in) :: normal(:), shear(:)
      type(tractions_t), intent(inout) :: tractions
      type(joint_point_t), contiguous, intent(inout) :: point(:)
      !> Opening w and aperture (joints) [mm]
      real(wp), intent(inout) :: opening(:), open_aperture(:)
      integer :: j

      do j = 1, size(joints%law)
         if (joints%wall_handled(j)) cycle
         tractions%contact_stress(j) = normal(j)/megapascal
         call update(joints, tractions, j, solid, u, frame_of(joints, j, x, u), point(j), opening(j), open_aperture(j))
         ! The contact, not the law, holds the walls: what counts is the shear stress it found
         point(j)%tau = shear(j)/megapascal
      end do
   end subroutine couple_potential

   !> Where a joint's walls are now.
   pure function frame_of(joints, j, x, u) result(frame)
      type(joints_t), intent(in) :: joints
      !> Joint
      integer, intent(in) :: j
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(joint_frame_t) :: frame
      real(wp) :: corner(2, 4), moved(2, 4)
      integer :: i

      do i = 1, 4
         corner(:, i) = x(:, joints%node(i, j))
         moved(:, i) = u(:, joints%node(i, j))
      end do
      frame = joint_kinematics(corner, moved)
   end function frame_of

   !> Slip of a joint, with that of the in-situ state [mm].
   pure real(wp) function slip_of(joints, j, frame)
      type(joints_t), intent(in) :: joints
      integer, intent(in) :: j
      type(joint_frame_t), intent(in) :: frame

      slip_of = joints%slipped(j) + frame%shear/millimetre
   end function slip_of

   !> Update one joint: normal stress, law, aperture.
   subroutine update(joints, tractions, j, solid, u, frame, point, opening, open_aperture)
      type(joints_t), intent(in) :: joints
      type(tractions_t), intent(in) :: tractions
      integer, intent(in) :: j
      type(solid_t), intent(in) :: solid
      real(wp), contiguous, intent(in) :: u(:, :)
      type(joint_frame_t), intent(in) :: frame
      type(joint_point_t), intent(inout) :: point
      real(wp), intent(inout) :: opening, open_aperture
      real(wp) :: stress

      opening = frame%opening/millimetre - joints%closed(j)
      stress = tractions%contact_stress(j)
      if (joints%stress_from_walls(j) .and. stress > 0.0_wp) stress = wall_stress(joints, j, solid, u, frame%j)
      associate (law => joints%law(j)%raw, du => slip_of(joints, j, frame) - point%u)
         if (joints%coupled(j)) then
            call law%update(du, stress, point, tractions%ride(j)%slip)
         else
            call law%update(du, stress, point)
         end if
         if (joints%literal_aperture(j)) then
            open_aperture = aperture(law%initial_aperture(), opening, point%v)                    ! (31)
         else
            ! Walls that part keep the dilation until they slide back. Where it pushes them it is a part of the opening.
            ! What closure has set is none
            open_aperture = aperture(law%initial_aperture() + point%dilation - point%set, &
                                     opening - merge(point%dilation, 0.0_wp, joints%coupled(j)) + point%set, &
                                     point%vn - point%set)
         end if
      end associate
   end subroutine update

   !> Eq 32: normal stress from the triangles on the two walls, compression positive [MPa].
   pure real(wp) function wall_stress(joints, j, solid, u, normal) result(stress)
      type(joints_t), intent(in) :: joints
      !> Joint
      integer, intent(in) :: j
      type(solid_t), intent(in) :: solid
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      !> Normal of the joint (2)
      real(wp), intent(in) :: normal(2)
      real(wp) :: sigma(3)

      sigma = 0.5_wp*(solid_stress(solid, joints%triangle(1, j), u) + solid_stress(solid, joints%triangle(2, j), u))
      stress = -(normal(1)**2*sigma(1) + normal(2)**2*sigma(2) + 2.0_wp*normal(1)*normal(2)*sigma(3)) ! (32)
      stress = max(0.0_wp, stress/megapascal)
   end function wall_stress

   !> Stiffness of a joint that bounds the stable step, the larger of normal and shear [MPa/mm].
   elemental real(wp) function joint_stiffness(law, penalty, contact_stiffness, point) result(stiffness)
      type(law_item_t), intent(in) :: law
      !> Penalty stiffness, 0 for the joint's own, and its stiffness where it is stiffest [MPa/mm]
      real(wp), intent(in) :: penalty, contact_stiffness
      type(joint_point_t), intent(in) :: point

      stiffness = penalty
      if (penalty <= 0.0_wp) stiffness = max(contact_stiffness, law%raw%normal_stiffness(point, point%sn))
      stiffness = max(stiffness, law%raw%shear_stiffness(point, point%sn))
   end function joint_stiffness

   !> Has any joint become so much stiffer against closure that the stable step must be computed again?
   pure logical function have_stiffened(joints, tractions)
      type(joints_t), intent(in) :: joints
      type(tractions_t), intent(in) :: tractions
      integer :: j

      have_stiffened = .true.
      do j = 1, size(joints%penalty)
         if (joints%penalty(j) > 0.0_wp .or. .not. joints%wall_handled(j)) cycle
         if (tractions%contact_stiffness(j) > stiffer*tractions%stiffness_then(j)) return
      end do
      have_stiffened = .false.
   end function have_stiffened

end module joints_m
