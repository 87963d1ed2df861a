!> The law of a cohesive joint at a point: rock that softens while a crack forms in it (the smeared crack of Munjiza,
!> Andrews and White 1999), and the friction that is left. SI units; opening and tension positive.
!>
!> One damage D, 0 to 1, for opening o and slip s. The surface (o/o_D)^2 + (s/s_D)^2 = 1 grows with D from the strength
!> (o_D = o_p, s_D = s_p at D = 0) to separation (o_t, s_t at D = 1). On it tension and bond shear stress lie on the
!> ellipse of half axes f_t z(D) and f_b z(D); inside they go back along the secant. D never falls. Under pressure the
!> walls press with the penalty stiffness and rub on the broken part: the shear strength c + sn tan(phi) at D = 0 goes
!> over into the residual friction sn tan(phi_r) at D = 1, which is the law of contact. manual/theory_cracks.md derives it.
module cohesive_m
   use kinds_m, only: wp
   implicit none
   private

   public :: cohesive_law, cohesive_update, cohesive_tangent, start_point, softening, softening_integral, overstress, &
             strengthened, on_strength
   public :: cohesive_values, cohesive_from_values, point_values, point_from_values

   !> Numbers that make up a law and the state of a point
   integer, parameter, public :: cohesive_value_count = 8, point_value_count = 9

   !> Constants of the softening curve (Munjiza, Andrews and White 1999); c is a whole number here
   real(wp), parameter :: a = 0.63_wp, b = 1.8_wp
   integer, parameter :: c = 6
   real(wp), parameter :: weight = (a + b - 1.0_wp)/(a + b)
   real(wp), parameter :: exponent = (a + real(c, wp)*b)/((a + b)*(1.0_wp - a - b))
   !> A residual friction steeper than the internal one would use up the bond at high pressure: this part of the cohesion
   !> stays
   real(wp), parameter :: least_bond = 1.0e-2_wp
   !> Least softening range over the elastic one, where the stiffness is too low for the fracture energy
   real(wp), parameter :: least_range = 0.1_wp
   integer, parameter :: most_iterations = 50
   real(wp), parameter :: close_enough = 1.0e-14_wp
   !> Damage that may grow in one part of a way, and halvings of the way to find where damage begins and ends
   real(wp), parameter :: largest_growth = 0.05_wp
   integer, parameter :: halvings = 40
   !> Damage that is as good as 1: nothing is left to spend
   real(wp), parameter :: largest_damage = 1.0_wp - 1.0e-12_wp
   !> Difference over the opening at the strength from which the tangent is found: the square root of rounding is 1e-8, and
   !> the law is smooth over its own peak
   real(wp), parameter :: difference = 1.0e-6_wp

   !> Parameters of a cohesive joint
   type, public :: cohesive_t
      !> Tensile strength [Pa], cohesion [Pa], tangents of the internal and the residual friction angle
      real(wp) :: tensile_strength = 0.0_wp, cohesion = 0.0_wp, internal = 0.0_wp, residual = 0.0_wp
      !> Fracture energy in mode I and in mode II [J/m2]
      real(wp) :: g_i = 0.0_wp, g_ii = 0.0_wp
      !> Penalty stiffness, normal and tangential [Pa/m]
      real(wp) :: stiffness = 0.0_wp
      !> Does the joint start at its strength, with no elastic branch to pay for? (see cohesive_law)
      logical :: rigid_start = .false.
      !> Integral of z(D) over 0..1; opening o_p at the strength and range o_t - o_p over which it softens [m]
      real(wp) :: integral = 0.0_wp, peak_opening = 0.0_wp, opening_range = 0.0_wp
      !> Is the stiffness high enough for both fracture energies?
      logical :: sound = .true.
   end type cohesive_t

   !> What a point of a cohesive joint remembers, and its stresses
   type, public :: cohesive_point_t
      !> Largest damage reached, 0 to 1
      real(wp) :: damage = 0.0_wp
      !> Slip at which the spring of the friction is relaxed [m]
      real(wp) :: slide = 0.0_wp
      !> Opening (positive) and slip of the last update [m]
      real(wp) :: opening = 0.0_wp, slip = 0.0_wp
      !> Normal stress, tension positive, and shear stress, with the sign of the slip it resists [Pa]
      real(wp) :: normal = 0.0_wp, shear = 0.0_wp
      !> Fracture energy spent by opening and by slip [J/m2]
      real(wp) :: spent_i = 0.0_wp, spent_ii = 0.0_wp
      !> Work done on the point so far: what it stores, what breaking and what friction has spent [J/m2]
      real(wp) :: work = 0.0_wp
   end type cohesive_point_t

contains

   !> Complete the parameters. The energy spent from zero stress to separation is g_i in pure opening and, above the
   !> residual friction, g_ii in pure slip: the elastic branch is part of it. A joint put in at its strength (rigid_start)
   !> has no elastic branch of its own, the rock has; then all of g_i and g_ii is spent beyond the strength.
   pure type(cohesive_t) function cohesive_law(tensile_strength, cohesion, internal, residual, g_i, g_ii, stiffness, &
                                               rigid_start) result(law)
      !> See cohesive_t
      real(wp), intent(in) :: tensile_strength, cohesion, internal, residual, g_i, g_ii, stiffness
      logical, intent(in) :: rigid_start
      real(wp) :: bond, peak_slip, range

      law%tensile_strength = tensile_strength
      law%cohesion = cohesion
      law%internal = internal
      law%residual = residual
      law%g_i = g_i
      law%g_ii = g_ii
      law%stiffness = stiffness
      law%rigid_start = rigid_start
      law%integral = softening_integral()
      law%peak_opening = tensile_strength/stiffness
      law%opening_range = softening_range(law, g_i, tensile_strength, law%peak_opening)
      call slip_limits(law, 0.0_wp, bond, peak_slip, range)
      law%sound = law%opening_range > least_range*law%peak_opening .and. range > least_range*peak_slip
   end function cohesive_law

   !> The law with both strengths multiplied by a factor; its fracture energies stay.
   pure type(cohesive_t) function strengthened(law, factor)
      type(cohesive_t), intent(in) :: law
      real(wp), intent(in) :: factor

      strengthened = cohesive_law(law%tensile_strength*factor, law%cohesion*factor, law%internal, law%residual, law%g_i, &
                                  law%g_ii, law%stiffness, law%rigid_start)
   end function strengthened

   !> Softening z(D), 1 at D = 0 and 0 at D = 1.
   elemental real(wp) function softening(damage) result(z)
      real(wp), intent(in) :: damage

      z = (1.0_wp - weight*exp(exponent*damage))*(a*(1.0_wp - damage) + b*(1.0_wp - damage)**c)
   end function softening

   !> Integral of z(D) over 0..1, exactly: with E_n the integral of (1-D)^n exp(k D), E_0 = (exp(k) - 1)/k and
   !> E_n = (n E_(n-1) - 1)/k by parts, it is a/2 + b/(c+1) - w (a E_1 + b E_c).
   pure real(wp) function softening_integral() result(integral)
      real(wp) :: moment(0:c)
      integer :: n

      moment(0) = (exp(exponent) - 1.0_wp)/exponent
      do n = 1, c
         moment(n) = (real(n, wp)*moment(n - 1) - 1.0_wp)/exponent
      end do
      integral = a/2.0_wp + b/real(c + 1, wp) - weight*(a*moment(1) + b*moment(c))
   end function softening_integral

   !> Displacement over which a strength softens so that the fracture energy is spent [m].
   pure real(wp) function softening_range(law, energy, strength, peak) result(range)
      type(cohesive_t), intent(in) :: law
      !> Fracture energy [J/m2], strength [Pa], displacement at the strength [m]
      real(wp), intent(in) :: energy, strength, peak
      real(wp) :: elastic

      elastic = 0.5_wp*strength*peak
      if (law%rigid_start) elastic = 0.0_wp
      range = max((energy - elastic)/(strength*law%integral), least_range*peak)
   end function softening_range

   !> The bond's part of the shear strength, the slip at the whole strength and the range over which the bond softens.
   pure subroutine slip_limits(law, pressure, bond, peak_slip, range)
      type(cohesive_t), intent(in) :: law
      !> Pressure on the walls, 0 when they are under tension [Pa]
      real(wp), intent(in) :: pressure
      !> Shear strength above the residual friction [Pa]
      real(wp), intent(out) :: bond
      !> [m]
      real(wp), intent(out) :: peak_slip, range

      bond = max(law%cohesion + pressure*(law%internal - law%residual), least_bond*law%cohesion)
      peak_slip = (bond + law%residual*pressure)/law%stiffness
      range = softening_range(law, law%g_ii, bond, peak_slip)
   end subroutine slip_limits

   !> Stress over strength at an elastic stress: 1 on the strength surface, the ellipse of f_t and c under tension and
   !> c + sn tan(phi) under pressure.
   elemental real(wp) function overstress(law, normal, shear)
      type(cohesive_t), intent(in) :: law
      !> Normal stress, tension positive, and shear stress [Pa]
      real(wp), intent(in) :: normal, shear

      if (normal > 0.0_wp) then
         overstress = hypot(normal/law%tensile_strength, shear/law%cohesion)
      else
         overstress = abs(shear)/(law%cohesion - normal*law%internal)
      end if
   end function overstress

   !> The part of a stress that the law can carry: as it is within the strength, on its surface beyond. Pressure stays.
   pure function on_strength(law, normal, shear) result(carried)
      type(cohesive_t), intent(in) :: law
      !> Normal stress, tension positive, and shear stress [Pa]
      real(wp), intent(in) :: normal, shear
      real(wp) :: carried(2)
      real(wp) :: factor

      factor = max(1.0_wp, overstress(law, normal, shear))
      carried = [merge(normal/factor, normal, normal > 0.0_wp), shear/factor]
   end function on_strength

   !> Bring a point to a new opening and slip.
   pure subroutine cohesive_update(law, opening, slip, point, overdue)
      type(cohesive_t), intent(in) :: law
      !> Opening, negative when the walls overlap, and slip [m]
      real(wp), intent(in) :: opening, slip
      type(cohesive_point_t), intent(inout) :: point
      !> Was it left behind far below its strength, so that no damage counts as little? Not unless given
      logical, intent(in), optional :: overdue
      type(cohesive_point_t) :: before
      real(wp) :: damage, growth

      growth = largest_growth
      if (present(overdue)) growth = merge(0.0_wp, largest_growth, overdue)
      damage = damage_on(law, opening, slip, point%damage)
      if (damage - point%damage <= growth) then
         call step_to(law, opening, slip, damage, point)
      else
         before = point
         call step_to(law, opening, slip, damage, point)
         call spend_on_way(law, opening, slip, before, point)
      end if
   end subroutine cohesive_update

   !> Damage has grown much: energy and work along the straight way, in parts, so that they do not depend on how long the
   !> way is. State and stresses stay those of the one step: they must not jump with the number of parts.
   pure subroutine spend_on_way(law, opening, slip, before, point)
      type(cohesive_t), intent(in) :: law
      !> Opening and slip at the end [m]
      real(wp), intent(in) :: opening, slip
      !> Point at the start and at the end
      type(cohesive_point_t), intent(in) :: before
      type(cohesive_point_t), intent(inout) :: point
      type(cohesive_point_t) :: on_way
      real(wp) :: from(2), way(2), place(2), first, last
      integer :: i, parts

      from = [before%opening, before%slip]
      way = [opening, slip] - from
      parts = ceiling((point%damage - before%damage)/largest_growth)
      ! No damage up to the first place, none beyond the last
      first = place_of_damage(law, from, way, before%damage, before%damage)
      last = 1.0_wp
      if (point%damage >= 1.0_wp) last = place_of_damage(law, from, way, before%damage, largest_damage)
      on_way = before
      do i = 0, parts
         place = from + (first + real(i, wp)/real(parts, wp)*(last - first))*way
         call step_to(law, place(1), place(2), damage_on(law, place(1), place(2), on_way%damage), on_way)
      end do
      call step_to(law, opening, slip, point%damage, on_way)
      point%spent_i = on_way%spent_i
      point%spent_ii = on_way%spent_ii
      point%work = on_way%work
   end subroutine spend_on_way

   !> Part of a way, 0 to 1, at which the damage passes a value; at the end of the way it has.
   pure real(wp) function place_of_damage(law, from, way, before, passed) result(part)
      type(cohesive_t), intent(in) :: law
      !> Opening and slip at the start, and the way from there (2) [m]; damage at the start, and the one to pass
      real(wp), intent(in) :: from(2), way(2), before, passed
      real(wp) :: low, middle
      integer :: i

      low = 0.0_wp
      part = 1.0_wp
      do i = 1, halvings
         middle = 0.5_wp*(low + part)
         if (damage_on(law, from(1) + middle*way(1), from(2) + middle*way(2), before) > passed) then
            part = middle
         else
            low = middle
         end if
      end do
   end function place_of_damage

   !> Damage at an opening and slip, not less than before.
   pure real(wp) function damage_on(law, opening, slip, before) result(damage)
      type(cohesive_t), intent(in) :: law
      !> Opening, negative when the walls overlap, and slip [m]
      real(wp), intent(in) :: opening, slip
      real(wp), intent(in) :: before
      real(wp) :: bond, peak_slip, range

      call slip_limits(law, max(-law%stiffness*opening, 0.0_wp), bond, peak_slip, range)
      damage = damage_at(law, max(opening, 0.0_wp), abs(slip), peak_slip, range, before)
   end function damage_on

   !> Take a point to an opening and slip at which the damage is known.
   pure subroutine step_to(law, opening, slip, damage, point)
      type(cohesive_t), intent(in) :: law
      !> Opening, negative when the walls overlap, and slip [m]
      real(wp), intent(in) :: opening, slip
      !> Not less than that of the point
      real(wp), intent(in) :: damage
      type(cohesive_point_t), intent(inout) :: point
      real(wp) :: pressure, bond, peak_slip, range, tension, tension_before, shear_before, shear_stiffness, limit, spring

      if (damage <= 0.0_wp) then
         call move_point(opening, slip, law%stiffness*opening, law%stiffness*slip, point)
         return
      end if

      pressure = max(-law%stiffness*opening, 0.0_wp)
      call slip_limits(law, pressure, bond, peak_slip, range)
      tension_before = secant(law%tensile_strength, law%peak_opening, law%opening_range, point%damage)
      shear_before = secant(bond, peak_slip, range, point%damage)
      tension = secant(law%tensile_strength, law%peak_opening, law%opening_range, damage)
      shear_stiffness = secant(bond, peak_slip, range, damage)
      ! Work of the mean stress less what is stored: a secant that falls from K1 to K2 spends (K1 - K2) d1 d2/2
      point%spent_i = point%spent_i + 0.5_wp*(tension_before - tension)*max(point%opening, 0.0_wp)*max(opening, 0.0_wp)
      point%spent_ii = point%spent_ii + 0.5_wp*(shear_before - shear_stiffness)*max(point%slip*slip, 0.0_wp)
      point%damage = damage

      ! Friction on the broken part: a spring, so stiff that spring and bond together have the penalty stiffness, and a
      ! slider that gives way at the residual friction
      spring = law%stiffness - shear_stiffness
      if (spring > 0.0_wp) then
         limit = law%residual*pressure/spring
         point%slide = max(slip - limit, min(slip + limit, point%slide))
      end if
      call move_point(opening, slip, merge(tension, law%stiffness, opening > 0.0_wp)*opening, &
                      shear_stiffness*slip + spring*(slip - point%slide), point)
   end subroutine step_to

   !> Derivatives of normal and shear stress by opening and slip (2, 2) [Pa/m], for a law that goes from the point `before`
   !> straight to an opening and slip. Differences in the direction of the motion: at a kink the side that is being entered.
   pure function cohesive_tangent(law, opening, slip, before) result(tangent)
      type(cohesive_t), intent(in) :: law
      !> Opening, negative when the walls overlap, and slip [m]
      real(wp), intent(in) :: opening, slip
      !> State that the law starts from
      type(cohesive_point_t), intent(in) :: before
      real(wp) :: tangent(2, 2)
      type(cohesive_point_t) :: here, ahead
      real(wp) :: step

      here = before
      call cohesive_update(law, opening, slip, here)
      step = sign(difference*law%peak_opening, opening - before%opening)
      ahead = before
      call cohesive_update(law, opening + step, slip, ahead)
      tangent(:, 1) = [ahead%normal - here%normal, ahead%shear - here%shear]/step
      step = sign(difference*law%peak_opening, slip - before%slip)
      ahead = before
      call cohesive_update(law, opening, slip + step, ahead)
      tangent(:, 2) = [ahead%normal - here%normal, ahead%shear - here%shear]/step
   end function cohesive_tangent

   !> Take over a new place and its stresses, and the work of the mean stresses on the way.
   pure subroutine move_point(opening, slip, normal, shear, point)
      real(wp), intent(in) :: opening, slip, normal, shear
      type(cohesive_point_t), intent(inout) :: point

      point%work = point%work + 0.5_wp*((point%normal + normal)*(opening - point%opening) &
                                        + (point%shear + shear)*(slip - point%slip))
      point%opening = opening
      point%slip = slip
      point%normal = normal
      point%shear = shear
   end subroutine move_point

   !> A point of a joint that is put into rock under stress: at the stress the rock has there, nothing spent.
   pure subroutine start_point(law, normal, shear, point)
      type(cohesive_t), intent(in) :: law
      !> Normal stress, tension positive, and shear stress [Pa]; not beyond the strength
      real(wp), intent(in) :: normal, shear
      type(cohesive_point_t), intent(out) :: point

      call cohesive_update(law, normal/law%stiffness, shear/law%stiffness, point)
      ! What the spring holds at the start was stored in the rock: it does not count as spent in the end
      point%spent_i = -0.5_wp*max(normal, 0.0_wp)*point%opening
      point%spent_ii = -0.5_wp*shear*point%slip
      point%work = 0.0_wp
   end subroutine start_point

   !> Damage at an opening and slip, not less than before.
   pure real(wp) function damage_at(law, opening, slip, peak_slip, range, before) result(damage)
      type(cohesive_t), intent(in) :: law
      !> Opening and slip, not negative; slip at the strength and range over which it softens [m]
      real(wp), intent(in) :: opening, slip, peak_slip, range
      real(wp), intent(in) :: before
      real(wp) :: part_i, part_ii, excess, slope, step
      integer :: i

      damage = before
      if (damage >= 1.0_wp) return
      if (opening <= 0.0_wp) then
         damage = max(before, min(1.0_wp, (slip - peak_slip)/range))
         return
      end if
      ! excess(D) = (o/o_D)^2 + (s/s_D)^2 - 1 falls and is convex: Newton from below never passes the root
      do i = 1, most_iterations
         part_i = law%peak_opening + damage*law%opening_range
         part_ii = peak_slip + damage*range
         excess = (opening/part_i)**2 + (slip/part_ii)**2 - 1.0_wp
         if (excess <= close_enough) return
         slope = 2.0_wp*((opening/part_i)**2*law%opening_range/part_i + (slip/part_ii)**2*range/part_ii)
         step = excess/slope
         damage = damage + step
         if (damage >= 1.0_wp) then
            damage = 1.0_wp
            return
         end if
      end do
   end function damage_at

   !> Secant stiffness of a softening branch at a damage [Pa/m]; it ends at 0.
   pure real(wp) function secant(strength, peak, range, damage)
      !> Strength [Pa], displacement at it and range over which it softens [m]
      real(wp), intent(in) :: strength, peak, range, damage

      secant = 0.0_wp
      if (damage < 1.0_wp) secant = strength*softening(damage)/(peak + damage*range)
   end function secant

   !> The law as the list of numbers it is made from, for checkpoints.
   pure function cohesive_values(law) result(value)
      type(cohesive_t), intent(in) :: law
      real(wp) :: value(cohesive_value_count)

      value = [law%tensile_strength, law%cohesion, law%internal, law%residual, law%g_i, law%g_ii, law%stiffness, &
               merge(1.0_wp, 0.0_wp, law%rigid_start)]
   end function cohesive_values

   !> The law from its list of numbers.
   pure function cohesive_from_values(value) result(law)
      real(wp), intent(in) :: value(cohesive_value_count)
      type(cohesive_t) :: law

      law = cohesive_law(value(1), value(2), value(3), value(4), value(5), value(6), value(7), value(8) > 0.5_wp)
   end function cohesive_from_values

   !> The state of a point as a list of numbers, for checkpoints.
   pure function point_values(point) result(value)
      type(cohesive_point_t), intent(in) :: point
      real(wp) :: value(point_value_count)

      value = [point%damage, point%slide, point%opening, point%slip, point%normal, point%shear, point%spent_i, &
               point%spent_ii, point%work]
   end function point_values

   !> The state of a point from its list of numbers.
   pure function point_from_values(value) result(point)
      real(wp), intent(in) :: value(point_value_count)
      type(cohesive_point_t) :: point

      point = cohesive_point_t(damage=value(1), slide=value(2), opening=value(3), slip=value(4), normal=value(5), &
                               shear=value(6), spent_i=value(7), spent_ii=value(8), work=value(9))
   end function point_from_values

end module cohesive_m
