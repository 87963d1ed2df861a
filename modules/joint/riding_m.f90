!> Walls that ride on their asperities (`coupling = 'coupled'`): the dilation that pushes a joint's walls, found together with
!> the pressure it makes.
!>
!> At the integration points of a joint the closure by stress is the overlap plus the dilation d (eq 23a, integrated). The
!> dilation of a slip in turn depends on the normal stress sn, the mean of the points. A step takes it at the mean closure
!> of its start and its end,
!>
!>     d = d0 + C(s_p) + E(s(sn)),    s(sn) = stress((v0 + closure(sn))/2),    sn = mean of stress(overlap + d)
!>
!> which makes the step of second order. E, what dilates, falls with the stress: the equation has one root. C, what contracts
!> before u/up = 1/4, grows with it: a stress that rises makes a rough joint contract less, which raises the stress, and there
!> may be no root or several; even where there is one, the closure of stiff walls says little of the stress they will be
!> under. C is therefore taken at a stress s_p that changes as in the step before, and takes no more than the closure of the
!> start: stress presses asperities into each other, and cannot thereby part the walls. Walls that come to bear in a step
!> dilate by a part of its slip: nothing jumps when they touch.
module riding_m
   use kinds_m, only: wp
   use joint_point_m, only: joint_point_t, joint_slip_t, joint_dilation_t
   use joint_law_m, only: joint_law_t, law_item_t
   implicit none
   private

   public :: ride, closure_pressure, closure_under, pressure_stiffness

   !> The dilation of one joint at the end of a step
   type, public :: ride_t
      !> Dilation [mm] and its derivative by the slip of the step [-]
      real(wp) :: dilation = 0.0_wp, by_slip = 0.0_wp
      !> How the law is to take the slip
      type(joint_slip_t) :: slip
   end type ride_t

   !> Part of the slip beyond u_max that dilates
   type :: share_t
      !> [-]; d (slip that dilates)/d slip [-]
      real(wp) :: part = 1.0_wp, by_slip = 1.0_wp
      !> Point that decides (0: none), and d part/d its overlap [1/mm]
      integer :: top = 0
      real(wp) :: by_top = 0.0_wp
   end type share_t

   !> One joint in a step
   type :: step_t
      !> Its number
      integer :: joint
      !> Penalty stiffness of the walls; 0: the joint's own [MPa/mm]
      real(wp) :: penalty
      !> At the start of the step; its closure by stress [mm]
      type(joint_point_t) :: start
      real(wp) :: closure
      !> Size and sign of the slip that rides, and the part of it that dilates, with its sign [mm]
      real(wp) :: beyond = 0.0_wp, side = 1.0_wp, dilating = 0.0_wp
   end type step_t

   !> The root is as good as the rounding of the closures lets it be [mm]; steps to it, at most
   real(wp), parameter :: least_error = 1.0e-16_wp, relative_error = 4.0_wp*epsilon(1.0_wp)
   integer, parameter :: most_steps = 100

contains

   !> Find the dilation of a joint at the end of a step.
   pure subroutine ride(law, penalty, start, joint, faced, du, overlap, weight, found, by_overlap, by_weight, rock_stress)
      !> Laws (joints); penalty stiffness of the walls, 0: the law's own (joints) [MPa/mm]; joints at the start of the step (joints)
      type(law_item_t), intent(in) :: law(:)
      real(wp), intent(in) :: penalty(:)
      type(joint_point_t), intent(in) :: start(:)
      !> The joint, and the one whose wall each point faces, the joint itself where there is no other: the softer one holds (points)
      integer, intent(in) :: joint, faced(:)
      !> Slip of the step [mm]
      real(wp), intent(in) :: du
      !> Overlap of the integration points without dilation [mm], their weight as a part of what is covered (points)
      real(wp), intent(in) :: overlap(:), weight(:)
      type(ride_t), intent(out) :: found
      !> d dilation/d overlap [-] and d dilation/d weight [mm] (points)
      real(wp), intent(out) :: by_overlap(:), by_weight(:)
      !> Normal stress that the law is given, when it is not that of the points [MPa]
      real(wp), intent(in), optional :: rock_stress
      type(step_t) :: step
      real(wp) :: stress(size(overlap)), stiffness(size(overlap)), mean, slope
      type(share_t) :: share
      type(joint_dilation_t) :: part
      real(wp) :: slip
      logical :: rides

      by_overlap = 0.0_wp
      by_weight = 0.0_wp
      step%joint = joint
      step%penalty = penalty(joint)
      step%start = start(joint)
      call law(joint)%raw%riding_slip(step%start, du, slip, rides)
      step%beyond = abs(slip)
      step%side = sign(1.0_wp, slip)
      step%closure = closure_of(law(joint)%raw, step, step%start%sn)
      call law(joint)%raw%retrace(step%start, step%start%u + du, found%dilation, found%by_slip)
      if (abs(du) <= 0.0_wp) found%dilation = step%start%dilation
      call press(law, penalty, start, faced, step, overlap, weight, found%dilation, stress, stiffness, mean, slope)
      if (present(rock_stress)) mean = rock_stress
      call mean_stress(law(joint)%raw, step, mean, found%slip%stress, found%slip%stress_sn)
      found%slip%touching = step%start%sn > 0.0_wp .or. mean > 0.0_wp
      if (.not. (found%slip%touching .and. rides)) return
      call share_slip(step, overlap, found%dilation, share)
      found%slip%dilation = 0.0_wp
      call contract(law(joint)%raw, step, found%slip%dilation, found%slip%dilation_u)
      if (present(rock_stress)) then
         ! The stress of the rock does not depend on the dilation
         found%slip%stress_sn = 0.0_wp
         part = law(joint)%raw%dilation(step%start, step%dilating, found%slip%stress)
         found%slip%dilation = found%slip%dilation + part%expansion
         found%slip%dilation_u = step%side*(found%slip%dilation_u + share%by_slip*part%expansion_u)
      else
         call expand(law, penalty, start, faced, step, share, overlap, weight, found, by_overlap, by_weight)
      end if
      found%dilation = found%dilation + found%slip%dilation
      found%by_slip = found%slip%dilation_u
   end subroutine ride

   !> Part of the slip that dilates: all of it where the walls touched at the start; where they come to bear it grows from
   !> nothing over a closure as large as the slip.
   pure subroutine share_slip(step, overlap, dilation, share)
      type(step_t), intent(inout) :: step
      real(wp), intent(in) :: overlap(:)
      !> Dilation without slip beyond u_max [mm]
      real(wp), intent(in) :: dilation
      type(share_t), intent(out) :: share
      real(wp) :: closing

      if (step%start%sn <= 0.0_wp .and. size(overlap) > 0) then
         share%top = maxloc(overlap, dim=1)
         closing = max(0.0_wp, overlap(share%top) + dilation)
         share%part = closing/max(tiny(1.0_wp), closing + step%beyond)
         share%by_slip = share%part**2
         if (closing > 0.0_wp) share%by_top = step%beyond/(closing + step%beyond)**2
      end if
      step%dilating = step%side*share%part*step%beyond
   end subroutine share_slip

   !> Contraction under a stress that changes as in the last step, within bounds, for who knows; the closure of the start is
   !> the most there is to take.
   pure subroutine contract(law, step, contraction, by_slip)
      class(joint_law_t), intent(in) :: law
      type(step_t), intent(in) :: step
      !> [mm], and its derivative by the slip beyond u_max [-]
      real(wp), intent(out) :: contraction, by_slip
      real(wp), parameter :: most = 1.5_wp
      !> Walls that are closed by less only just touch: what they could contract is over before it has begun [mm]
      real(wp), parameter :: just_touching = 1.0e-6_wp
      type(joint_dilation_t) :: part
      real(wp) :: closure, root

      contraction = 0.0_wp
      by_slip = 0.0_wp
      closure = law%closure(step%start, step%start%sn)
      if (closure <= just_touching) return
      associate (sn => step%start%sn, change => step%start%last_change)
         part = law%dilation(step%start, step%side*step%beyond, min(max(sn + 0.5_wp*change, sn/most), sn*most))
      end associate
      ! Of second order in the step
      root = sqrt(1.0_wp + (part%contraction/closure)**2)
      contraction = part%contraction/root
      by_slip = part%contraction_u/root**3
   end subroutine contract

   !> Expansion at the mean of start and end: the root of dilation - known part - E(s(sn(dilation))), which grows with the
   !> dilation, by Newton's method within the bounds it is found to lie between.
   pure subroutine expand(law, penalty, start, faced, step, share, overlap, weight, found, by_overlap, by_weight)
      !> As for ride
      type(law_item_t), intent(in) :: law(:)
      real(wp), intent(in) :: penalty(:)
      type(joint_point_t), intent(in) :: start(:)
      integer, intent(in) :: faced(:)
      type(step_t), intent(in) :: step
      type(share_t), intent(in) :: share
      real(wp), intent(in) :: overlap(:), weight(:)
      !> Its slip%dilation is the contraction in, with its derivative; all that the slip adds out
      type(ride_t), intent(inout) :: found
      real(wp), intent(inout) :: by_overlap(:), by_weight(:)
      type(joint_dilation_t) :: part
      real(wp) :: stress(size(overlap)), stiffness(size(overlap)), mean, slope
      real(wp) :: known, low, high, dilation, error, by_mean
      integer :: i

      known = found%dilation + found%slip%dilation
      low = known
      high = huge(high)
      dilation = known
      do i = 1, most_steps
         call press(law, penalty, start, faced, step, overlap, weight, dilation, stress, stiffness, mean, slope)
         call mean_stress(law(step%joint)%raw, step, mean, found%slip%stress, found%slip%stress_sn)
         part = law(step%joint)%raw%dilation(step%start, step%dilating, found%slip%stress)
         by_mean = part%expansion_sn*found%slip%stress_sn
         error = dilation - known - part%expansion
         if (error < 0.0_wp) then
            low = max(low, dilation)
         else
            high = min(high, dilation)
         end if
         if (abs(error) <= least_error + relative_error*(abs(dilation) + part%expansion)) exit
         if (high - low <= least_error + relative_error*abs(high)) exit
         ! What expands falls with the stress, but where the mid-point rule takes very long slips
         dilation = dilation - error/max(1.0_wp, 1.0_wp - by_mean*slope)
         if (.not. (dilation > low .and. dilation < high)) dilation = 0.5_wp*(low + high)
      end do
      found%slip%dilation = dilation - found%dilation
      by_overlap = by_mean*stiffness
      if (share%top > 0) by_overlap(share%top) = by_overlap(share%top) + part%expansion_u*step%beyond*share%by_top
      by_weight = by_mean*stress
      ! All of it changes the pressure, and that the dilation
      by_overlap = by_overlap/(1.0_wp - by_mean*slope)
      by_weight = by_weight/(1.0_wp - by_mean*slope)
      found%slip%dilation_u = step%side*(found%slip%dilation_u + share%by_slip*part%expansion_u)/(1.0_wp - by_mean*slope)
   end subroutine expand

   !> Pressure of the integration points for a dilation.
   pure subroutine press(law, penalty, start, faced, step, overlap, weight, dilation, stress, stiffness, mean, slope)
      !> As for ride
      type(law_item_t), intent(in) :: law(:)
      real(wp), intent(in) :: penalty(:)
      type(joint_point_t), intent(in) :: start(:)
      integer, intent(in) :: faced(:)
      type(step_t), intent(in) :: step
      real(wp), intent(in) :: overlap(:), weight(:)
      !> [mm]
      real(wp), intent(in) :: dilation
      !> Normal stress [MPa] and d mean/d overlap [MPa/mm] (points)
      real(wp), intent(out) :: stress(:), stiffness(:)
      !> Normal stress of the joint [MPa], d mean/d dilation [MPa/mm]
      real(wp), intent(out) :: mean, slope
      real(wp) :: other
      integer :: k

      stiffness = 0.0_wp
      do k = 1, size(overlap)
         stress(k) = stress_of(law(step%joint)%raw, step, overlap(k) + dilation)
         if (stress(k) <= 0.0_wp) cycle
         stiffness(k) = weight(k)*stiffness_of(law(step%joint)%raw, step, stress(k))
         if (faced(k) == step%joint) cycle
         associate (j => faced(k))
            other = closure_pressure(law(j)%raw, penalty(j), start(j), overlap(k) + dilation)
            if (other >= stress(k)) cycle
            stress(k) = other
            stiffness(k) = weight(k)*pressure_stiffness(law(j)%raw, penalty(j), start(j), other)
         end associate
      end do
      mean = sum(weight*stress)
      slope = sum(stiffness)
   end subroutine press

   !> Normal stress at the mean of the closures of start and end, or at another share of the end's.
   pure subroutine mean_stress(law, step, sn, stress, stress_sn)
      class(joint_law_t), intent(in) :: law
      type(step_t), intent(in) :: step
      !> Normal stress at the end [MPa]
      real(wp), intent(in) :: sn
      !> [MPa], and its derivative by sn [-]
      real(wp), intent(out) :: stress, stress_sn
      real(wp) :: share

      share = law%end_share()
      stress = stress_of(law, step, (1.0_wp - share)*step%closure + share*closure_of(law, step, sn))
      stress_sn = share*stiffness_of(law, step, stress)/stiffness_of(law, step, sn)
   end subroutine mean_stress

   !> Normal stress of a closure [MPa].
   pure real(wp) function stress_of(law, step, closure)
      class(joint_law_t), intent(in) :: law
      type(step_t), intent(in) :: step
      !> [mm]
      real(wp), intent(in) :: closure

      stress_of = closure_pressure(law, step%penalty, step%start, closure)
   end function stress_of

   !> Pressure of walls that have closed, by a joint's law or its penalty [MPa].
   pure real(wp) function closure_pressure(law, penalty, start, closure) result(pressure)
      class(joint_law_t), intent(in) :: law
      !> 0: the law's own stiffness [MPa/mm]
      real(wp), intent(in) :: penalty
      !> The joint at the start of the step
      type(joint_point_t), intent(in) :: start
      !> [mm]
      real(wp), intent(in) :: closure

      if (penalty > 0.0_wp) then
         pressure = max(0.0_wp, penalty*closure)
      else
         pressure = law%closure_stress(start, closure)
      end if
   end function closure_pressure

   !> d closure_pressure/d closure at a pressure [MPa/mm].
   pure real(wp) function pressure_stiffness(law, penalty, start, pressure) result(stiffness)
      class(joint_law_t), intent(in) :: law
      !> [MPa/mm], [MPa]
      real(wp), intent(in) :: penalty, pressure
      !> The joint at the start of the step
      type(joint_point_t), intent(in) :: start

      stiffness = penalty
      if (penalty <= 0.0_wp) stiffness = law%normal_stiffness(start, pressure)
   end function pressure_stiffness

   !> Closure under a normal stress, the inverse of stress_of [mm].
   pure real(wp) function closure_of(law, step, stress)
      class(joint_law_t), intent(in) :: law
      type(step_t), intent(in) :: step
      !> [MPa]
      real(wp), intent(in) :: stress

      closure_of = closure_under(law, step%penalty, step%start, stress)
   end function closure_of

   !> Closure of a joint under a pressure, the inverse of closure_pressure [mm].
   pure real(wp) function closure_under(law, penalty, start, pressure) result(closure)
      class(joint_law_t), intent(in) :: law
      !> 0: the law's own stiffness [MPa/mm]; [MPa]
      real(wp), intent(in) :: penalty, pressure
      !> The joint at the start of the step
      type(joint_point_t), intent(in) :: start

      if (penalty > 0.0_wp) then
         closure = pressure/penalty
      else
         closure = law%closure(start, pressure)
      end if
   end function closure_under

   !> d stress_of/d closure [MPa/mm].
   pure real(wp) function stiffness_of(law, step, stress)
      class(joint_law_t), intent(in) :: law
      type(step_t), intent(in) :: step
      !> [MPa]
      real(wp), intent(in) :: stress

      stiffness_of = pressure_stiffness(law, step%penalty, step%start, stress)
   end function stiffness_of

end module riding_m
