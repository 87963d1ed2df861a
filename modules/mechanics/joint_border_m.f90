!> Between the rock, in SI units, and the laws of its joints, in MPa and mm: the one place where one becomes the other. Each step
!> (section 2.3.3 of the paper, eqs 27 to 33), when the model is built, and when a crack takes a law.
!>
!> From the displacements come each joint's opening and shear (eqs 27-30, paired as at the start) and, where the walls
!> touch now, their overlap; from the overlap the contact pressure; from pressure and shear the joint's law gives shear
!> stress, closure, dilation and mobilised friction; pressure and shear stress go back to the walls as forces.
!>
!> The record of a joint (joint_point_t), its opening and its aperture are in MPa and mm, as its law and the tables have them.
module joint_border_m
   use kinds_m, only: wp
   use units_m, only: megapascal, millimetre, megapascal_per_millimetre
   use joint_point_m, only: joint_point_t, joint_tangent_t
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use joint_law_m, only: law_item_t, joint_law_t
   use jcm_m, only: aperture
   use riding_m, only: ride, closure_pressure, closure_under, pressure_stiffness
   use in_situ_m, only: resolve, close_joint
   use solid_m, only: solid_t
   use solid_stress_m, only: solid_stress
   use joints_m, only: joints_t, tractions_t, make_room
   use wall_layout_m, only: wall_contact_t
   use wall_contact_m, only: wall_meeting_t, points_of_joints, wall_slip_rate
   implicit none
   private

   public :: set_penalty, settle, largest_closure, couple_walls, couple_potential, press_softer, begin_tangents, joint_stiffness, &
             stiffness_at_points, slip_of_step, answer_of, are_apart, pressing, show_bond

   !> How a joint answers a small motion of its walls, for the tangent of the implicit solver
   type, public :: joint_answer_t
      !> Normal stress [Pa], shear stress over it [-]; 0 when open
      real(wp) :: stress = 0.0_wp, friction = 0.0_wp
      !> d tau/du [Pa/m], d tau/d sn [-]
      real(wp) :: tau_u = 0.0_wp, tau_sn = 0.0_wp
      !> Normal stiffness at first touch, and what is kept of it where walls are apart [Pa/m]
      real(wp) :: first_touch = 0.0_wp, apart = 0.0_wp
      !> Does it bear no more than rounding of the overlap makes?
      logical :: unstressed = .true.
      !> What d tau/du lacks for the system to be regular: where walls are apart, and where they touch without stress [Pa/m]
      real(wp) :: shear_apart = 0.0_wp, shear_unstressed = 0.0_wp
   end type joint_answer_t

   !> Walls no further apart than rounding touch [mm]
   real(wp), parameter :: touching = 1.0e-9_wp

contains

   ! ---- When the model is built -------------------------------------------------------------------------------------------

   !> Give the walls of a joint a penalty stiffness, which a law without a stiffness of its own takes for its own.
   pure subroutine set_penalty(joints, j, stiffness)
      type(joints_t), intent(inout) :: joints
      !> Joint
      integer, intent(in) :: j
      !> 0: the walls press by the law [Pa/m]
      real(wp), intent(in) :: stiffness

      joints%penalty(j) = stiffness/megapascal_per_millimetre
      call joints%law(j)%raw%lend(joints%penalty(j))
   end subroutine set_penalty

   !> Bring a joint that has never been loaded to the in-situ stress of the rock around it.
   pure subroutine settle(joints, j, stress, along, point, closed, slipped, too_weak)
      type(joints_t), intent(in) :: joints
      !> Joint
      integer, intent(in) :: j
      !> sxx, syy, sxy, tension positive [Pa]; from A to B of the joint (2) [m]
      real(wp), intent(in) :: stress(3), along(2)
      type(joint_point_t), intent(out) :: point
      !> Overlap of the walls and slip that make this stress [m]
      real(wp), intent(out) :: closed, slipped
      !> Is it weaker than the shear stress along it? It then ends at its strength
      logical, intent(out) :: too_weak
      real(wp) :: sn, tau

      call resolve(stress, along, sn, tau)
      call close_joint(joints%law(j)%raw, joints%penalty(j), joints%coupled(j), sn/megapascal, tau/megapascal, point, closed, &
                       slipped, too_weak)
      closed = closed*millimetre
      slipped = slipped*millimetre
   end subroutine settle

   !> Largest closure of a joint by its law; 0: its walls press by a stiffness that the deck gives [m].
   pure real(wp) function largest_closure(law) result(closure)
      class(joint_law_t), intent(in) :: law

      closure = law%own_closure()*millimetre
   end function largest_closure

   !> Slip of the peak strength of a joint under pressure and what it has slipped before, against which a step of its law is long or
   !> short; 0: no pressure, or a law without a peak [m].
   elemental real(wp) function slip_of_step(law, point) result(slip)
      type(law_item_t), intent(in) :: law
      type(joint_point_t), intent(in) :: point

      slip = 0.0_wp
      if (point%sn > 0.0_wp) slip = law%raw%slip_of_peak(point%sn)
      if (slip > 0.0_wp) slip = (slip + abs(point%u))*millimetre
   end function slip_of_step

   ! ---- In every step -----------------------------------------------------------------------------------------------------

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
         associate (overlap => (joints%closed(j) - met%gap(first:last))/millimetre, &
                    weight => met%weight(first:last)/max(tiny(covered), covered), &
                    du => slip_of(joints, j, frame) - point(j)%u, found => tractions%ride(j), &
                    by_overlap => tractions%by_overlap(first:last), by_weight => tractions%by_weight(first:last), &
                    other => merge(met%faced_joint(first:last), j, met%faced_joint(first:last) > 0))
            if (joints%stress_from_walls(j)) then
               call ride(joints%law, joints%penalty, point, j, other, du, overlap, weight, found, by_overlap, by_weight, &
                         wall_stress(joints, j, solid, u, frame%j)/megapascal)
            else
               call ride(joints%law, joints%penalty, point, j, other, du, overlap, weight, found, by_overlap, by_weight)
            end if
            by_weight = by_weight*millimetre
         end associate
      end if
      force = 0.0_wp
      stiffest = 0.0_wp
      weighed = 0.0_wp
      do k = first, last
         overlap = overlap_at(joints, met, tractions, j, k)
         if (tractions%tangents%on .and. .not. joints%coupled(j)) then
            call press_on_tangent(joints, met, point, j, k, overlap, tractions%tangents%touch(k), stress, tractions%by_closure(k))
            tractions%by_closure(k) = tractions%by_closure(k)*megapascal_per_millimetre
            tractions%pressure(k) = stress*megapascal
            force = force + stress*met%weight(k)
            cycle
         end if
         call press_softer(joints, met, point, j, k, overlap, softer, stress)
         tractions%pressure(k) = stress*megapascal
         force = force + stress*met%weight(k)
         if (stress <= 0.0_wp) cycle
         tractions%by_closure(k) = joints%penalty(softer)*megapascal_per_millimetre
         if (joints%penalty(softer) > 0.0_wp) cycle
         stiffness = joints%law(softer)%raw%normal_stiffness(point(softer), stress)
         tractions%by_closure(k) = stiffness*megapascal_per_millimetre
         stiffest = max(stiffest, stiffness)
         weighed = weighed + stiffness*met%weight(k)
      end do
      tractions%contact_stress(j) = 0.0_wp
      if (covered > 0.0_wp) tractions%contact_stress(j) = force/covered
      tractions%covered(j) = 0.0_wp
      if (last >= first) tractions%covered(j) = covered/met%length(met%wall(first))
      ! A point may bear on one node of an edge alone, of which the bound gives each half
      tractions%contact_stiffness(j) = min(stiffest, 2.0_wp*weighed/joints%length(j))*megapascal_per_millimetre
   end subroutine find_pressure

   !> Overlap of the walls at an integration point, positive when they touch; of walls that ride with their dilation [mm].
   pure real(wp) function overlap_at(joints, met, tractions, j, k) result(overlap)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      !> Joint, integration point
      integer, intent(in) :: j, k

      overlap = (joints%closed(j) - met%gap(k))/millimetre
      if (joints%coupled(j)) overlap = overlap + tractions%ride(j)%dilation
   end function overlap_at

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

   !> Closure by tangents from here on, for Newton's method far from rest: they touch where the walls press now.
   pure subroutine begin_tangents(met, tractions)
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(inout) :: tractions

      call tractions%tangents%begin(met, tractions%pressure(:met%points)/megapascal)
   end subroutine begin_tangents

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

   !> Slip of a joint, with that of the in-situ state [mm].
   pure real(wp) function slip_of(joints, j, frame)
      type(joints_t), intent(in) :: joints
      integer, intent(in) :: j
      type(joint_frame_t), intent(in) :: frame

      slip_of = (joints%slipped(j) + frame%shear)/millimetre
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

      opening = (frame%opening - joints%closed(j))/millimetre
      stress = tractions%contact_stress(j)
      if (joints%stress_from_walls(j) .and. stress > 0.0_wp) stress = wall_stress(joints, j, solid, u, frame%j)/megapascal
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

   !> Stiffness of a joint that bounds the stable step, the larger of normal and shear [Pa/m].
   elemental real(wp) function joint_stiffness(law, penalty, contact_stiffness, point) result(stiffness)
      type(law_item_t), intent(in) :: law
      !> Penalty stiffness, 0 for the joint's own [MPa/mm], and its stiffness where it is stiffest [Pa/m]
      real(wp), intent(in) :: penalty, contact_stiffness
      type(joint_point_t), intent(in) :: point

      stiffness = penalty*megapascal_per_millimetre
      if (penalty <= 0.0_wp) &
         stiffness = max(contact_stiffness, law%raw%normal_stiffness(point, point%sn)*megapascal_per_millimetre)
      stiffness = max(stiffness, law%raw%shear_stiffness(point, point%sn)*megapascal_per_millimetre)
   end function joint_stiffness

   !> Stiffness of the closure at the walls' integration points, where they are now and by the joints as they are, with the room
   !> for stiffening that their joint has until the stable step is looked at again [Pa/m].
   pure function stiffness_at_points(joints, walls, met, tractions, point) result(stiffness)
      type(joints_t), intent(in) :: joints
      type(wall_contact_t), intent(in) :: walls
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      !> (joints)
      type(joint_point_t), contiguous, intent(in) :: point(:)
      real(wp) :: stiffness(met%points), overlap, stress, room
      integer :: j, k, softer

      do k = 1, met%points
         j = walls%joint(met%wall(k))
         overlap = joints%closed(j)/millimetre - met%gap(k)/millimetre
         if (joints%coupled(j)) overlap = overlap + point(j)%dilation
         stiffness(k) = 0.0_wp
         call press_softer(joints, met, point, j, k, overlap, softer, stress)
         if (stress <= 0.0_wp) cycle
         room = 1.0_wp
         if (tractions%contact_stiffness(j) > 0.0_wp) room = max(1.0_wp, tractions%stiffness_then(j)/tractions%contact_stiffness(j))
         stiffness(k) = room*megapascal_per_millimetre &
                        *pressure_stiffness(joints%law(softer)%raw, joints%penalty(softer), point(softer), stress)
      end do
   end function stiffness_at_points

   !> How a joint in wall contact answers, at the state it was last updated to.
   pure function answer_of(joints, tractions, j, point, apart, unstressed) result(answer)
      type(joints_t), intent(in) :: joints
      type(tractions_t), intent(in) :: tractions
      !> Joint
      integer, intent(in) :: j
      type(joint_point_t), intent(in) :: point
      !> Parts of its first normal stiffness that it keeps, in shear too: where walls are apart, and where they touch without stress
      real(wp), intent(in) :: apart, unstressed
      type(joint_answer_t) :: answer
      type(joint_tangent_t) :: tangent
      real(wp) :: first

      associate (law => joints%law(j)%raw)
         if (joints%coupled(j)) then
            tangent = law%tangent(point, tractions%ride(j)%slip)
         else
            tangent = law%tangent(point)
         end if
         if (point%sn > 0.0_wp) then
            answer%stress = point%sn*megapascal
            answer%friction = point%tau/point%sn
         end if
         answer%tau_u = tangent%tau_u*megapascal_per_millimetre
         answer%tau_sn = tangent%tau_sn
         first = pressure_stiffness(law, joints%penalty(j), point, 0.0_wp)
         answer%first_touch = first*megapascal_per_millimetre
         answer%unstressed = point%sn <= first*touching
         answer%apart = apart*first*megapascal_per_millimetre
         if (tangent%tau_u < 0.0_wp) return
         first = law%normal_stiffness(point, 0.0_wp)
         answer%shear_apart = max(0.0_wp, first*apart - tangent%tau_u)*megapascal_per_millimetre
         answer%shear_unstressed = max(0.0_wp, first*unstressed - tangent%tau_u)*megapascal_per_millimetre
      end associate
   end function answer_of

   !> Are the walls apart at an integration point?
   pure logical function are_apart(joints, met, tractions, j, k)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      !> Joint and integration point
      integer, intent(in) :: j, k

      are_apart = overlap_at(joints, met, tractions, j, k) < -touching
   end function are_apart

   ! ---- Cracks ------------------------------------------------------------------------------------------------------------

   !> Stress that the walls of a joint element press on each other with, 0 where they do not [Pa].
   elemental real(wp) function pressing(point)
      type(joint_point_t), intent(in) :: point

      pressing = max(0.0_wp, point%sn)*megapascal
   end function pressing

   !> Let the joint element of a bond show what the bond feels: slip, opening, stresses.
   pure subroutine show_bond(frame, normal, shear, point, opening, open_aperture)
      type(joint_frame_t), intent(in) :: frame
      !> Normal stress, tension positive, and shear stress of the bond [Pa]
      real(wp), intent(in) :: normal, shear
      type(joint_point_t), intent(inout) :: point
      real(wp), intent(out) :: opening, open_aperture

      point%u = frame%shear/millimetre
      point%tau = shear/megapascal
      point%sn = max(0.0_wp, -normal)/megapascal
      opening = frame%opening/millimetre
      open_aperture = max(0.0_wp, opening)
   end subroutine show_bond

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

   !> Eq 32: normal stress from the triangles on the two walls, compression positive [Pa].
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
      stress = max(0.0_wp, stress)
   end function wall_stress

end module joint_border_m
