!> Potential contact of two triangles: each carries a potential, 0 on its edges and 1 at its centroid, and pushes the
!> edges of the other out of itself. In role one triangle is the contactor, which owns the potential, and the other
!> the target, whose edges are pushed; a pair is worked twice with the roles swapped.
!>
!> The potential phi = 3 min(lambda_1, lambda_2, lambda_3) is linear on three sub-triangles, lambda being the area
!> coordinates of the contactor. Along a straight target edge it is piecewise linear with kinks only where two area
!> coordinates are equal, so that every integral here is exact. The forces on the nodes are the negative gradient of the
!> energy p * integral of phi over the overlap, whether the triangles move, turn or deform.
!>
!> References: A. Munjiza, K.R.F. Andrews (2000), Penalty function method for combined finite-discrete element systems
!> comprising large number of separate bodies, Int. J. Numer. Meth. Eng. 49:1377-1396; A. Munjiza (2004), The Combined
!> Finite-Discrete Element Method, Wiley. Equations 2 and 3 of Lei, Latham, Xiang (2016).
module potential_m
   use kinds_m, only: wp
   implicit none
   private

   public :: area_coordinates, edge_moments, push_target, pair_penalty, twice_area

   !> What the target's edges feel in one role. Edge k runs from corner k to the next one, anticlockwise.
   type, public :: push_t
      !> Force on the corners of the target and of the contactor (2, 3) [N/m]
      real(wp) :: target_force(2, 3) = 0.0_wp, contactor_force(2, 3) = 0.0_wp
      !> Normal force of each target edge, pushing the target back (3) [N/m]
      real(wp) :: normal(3) = 0.0_wp
      !> Place of its resultant along the edge, 0 at the first corner and 1 at the second (3)
      real(wp) :: place(3) = 0.0_wp
      !> Area coordinates of that place in the contactor (3 coordinates, 3 edges)
      real(wp) :: lambda(3, 3) = 0.0_wp
      !> Energy of the contactor's potential over the overlap [J/m]
      real(wp) :: energy = 0.0_wp
   end type push_t

   !> Largest potential that energies are computed with: keeps the integrand, singular at the centroid, finite
   real(wp), parameter :: highest_potential = 1.0_wp - 1.0e-9_wp

contains

   !> Push of a contactor triangle on the edges of a target triangle (eqs 2-3) in one role.
   pure subroutine push_target(target, contactor, penalty, push)
      !> Corners of both triangles, anticlockwise (2, 3) [m]
      real(wp), intent(in) :: target(2, 3), contactor(2, 3)
      !> Penalty p of the pair [Pa]
      real(wp), intent(in) :: penalty
      type(push_t), intent(out) :: push
      real(wp) :: lambda(3, 3), moment(0:1), excess, centroid(2), along(2), outward(2), force(2), area2, scale, integral
      integer :: edge, from, to, k

      area2 = twice_area(contactor)
      if (area2 <= 0.0_wp) return
      scale = 1.0_wp/area2
      do k = 1, 3
         from = mod(k, 3) + 1
         to = mod(k + 1, 3) + 1
         lambda(k, :) = ((contactor(1, to) - contactor(1, from))*(target(2, :) - contactor(2, from)) &
                         - (contactor(2, to) - contactor(2, from))*(target(1, :) - contactor(1, from)))*scale
         ! The target lies wholly beyond this edge of the contactor
         if (max(lambda(k, 1), lambda(k, 2), lambda(k, 3)) <= 0.0_wp) return
      end do

      centroid = (contactor(:, 1) + contactor(:, 2) + contactor(:, 3))/3.0_wp
      integral = 0.0_wp
      do edge = 1, 3
         from = edge
         to = mod(edge, 3) + 1
         call edge_moments(lambda(:, from), lambda(:, to), moment, excess)
         if (moment(0) <= 0.0_wp) cycle
         along = target(:, to) - target(:, from)
         ! Normal times edge length
         outward = [along(2), -along(1)]
         push%normal(edge) = penalty*moment(0)*sqrt(along(1)**2 + along(2)**2)
         push%place(edge) = moment(1)/moment(0)
         push%lambda(:, edge) = lambda(:, from) + push%place(edge)*(lambda(:, to) - lambda(:, from))
         ! Equation 3: f_n = -n integral of p phi dl, given to both triangles at its own place
         force = -penalty*outward*moment(0)
         push%target_force(:, from) = push%target_force(:, from) + (1.0_wp - push%place(edge))*force
         push%target_force(:, to) = push%target_force(:, to) + push%place(edge)*force
         do k = 1, 3
            push%contactor_force(:, k) = push%contactor_force(:, k) - push%lambda(k, edge)*force
         end do
         integral = integral - dot_product(target(:, from) - centroid, outward)*excess
      end do
      if (all(area_coordinates(target, centroid) > 0.0_wp)) integral = integral + area2/6.0_wp
      push%energy = penalty*integral
      call squeeze(contactor, area2, push%energy, push%contactor_force)
   end subroutine push_target

   !> A contactor that grows carries its potential further out: the forces -E grad(lambda), in balance among themselves,
   !> that make the contactor's forces the exact gradient of the energy when it deforms.
   pure subroutine squeeze(contactor, area2, energy, force)
      !> Corners (2, 3) [m]
      real(wp), intent(in) :: contactor(2, 3)
      !> Twice its area [m2]
      real(wp), intent(in) :: area2
      !> Energy of its potential over the overlap [J/m]
      real(wp), intent(in) :: energy
      !> Forces on its corners (2, 3) [N/m]
      real(wp), intent(inout) :: force(2, 3)
      real(wp) :: opposite(2)
      integer :: k

      do k = 1, 3
         opposite = contactor(:, mod(k + 1, 3) + 1) - contactor(:, mod(k, 3) + 1)
         force(:, k) = force(:, k) - energy/area2*[-opposite(2), opposite(1)]
      end do
   end subroutine squeeze

   !> Integrals of the contactor's potential along a target edge, s running from 0 to 1 over the whole edge.
   !>
   !> The energy comes from the edges alone: with r from the centroid and psi = 1 - phi, which grows linearly along r,
   !> div(r f) = phi for f = 1/2 - psi/3 - 1/(6 psi**2) = -phi**2 (3 - 2 phi)/(6 psi**2). f vanishes where phi does, so
   !> that only the target's edges count (and a third of the contactor's area when its centroid is covered).
   pure subroutine edge_moments(start, finish, moment, excess)
      !> Area coordinates in the contactor of the edge's two ends (3)
      real(wp), intent(in) :: start(3), finish(3)
      !> Integrals of phi and of phi s over the edge
      real(wp), intent(out) :: moment(0:1)
      !> Integral of -f over the edge
      real(wp), intent(out) :: excess
      real(wp) :: kink(5), low, high, a, b, length
      integer :: i, n, active

      moment = 0.0_wp
      excess = 0.0_wp
      low = 0.0_wp
      high = 1.0_wp
      do i = 1, 3
         if (max(start(i), finish(i)) <= 0.0_wp) return
         if (start(i) < 0.0_wp) low = max(low, start(i)/(start(i) - finish(i)))
         if (finish(i) < 0.0_wp) high = min(high, start(i)/(start(i) - finish(i)))
      end do
      if (high <= low) return

      call find_kinks(start, finish, low, high, kink, n)
      do i = 1, n - 1
         length = kink(i + 1) - kink(i)
         ! One coordinate is the least between two kinks. At a kink another is as small, but perhaps with fewer digits.
         active = least(start + 0.5_wp*(kink(i) + kink(i + 1))*(finish - start))
         a = potential_at(kink(i))
         b = potential_at(kink(i + 1))
         moment(0) = moment(0) + 0.5_wp*length*(a + b)
         moment(1) = moment(1) + length*((2.0_wp*a + b)*kink(i) + (a + 2.0_wp*b)*kink(i + 1))/6.0_wp
         excess = excess + length*(a**2 + a*b + b**2 - a*b*(a + b))/(6.0_wp*(1.0_wp - a)*(1.0_wp - b))
      end do

   contains

      pure real(wp) function potential_at(s)
         real(wp), intent(in) :: s

         potential_at = 3.0_wp*(start(active) + s*(finish(active) - start(active)))
         potential_at = max(0.0_wp, min(highest_potential, potential_at))
      end function potential_at
   end subroutine edge_moments

   !> Ends of the clipped edge and the places between them where two area coordinates are equal, in order.
   pure subroutine find_kinks(start, finish, low, high, kink, n)
      !> Area coordinates of the edge's ends (3)
      real(wp), intent(in) :: start(3), finish(3)
      !> Clipped edge, 0 <= low < high <= 1
      real(wp), intent(in) :: low, high
      !> Places (n used)
      real(wp), intent(out) :: kink(5)
      integer, intent(out) :: n
      real(wp) :: at_start, at_finish, s
      integer :: i, j, k

      n = 2
      kink = high
      kink(1) = low
      do i = 1, 3
         j = mod(i, 3) + 1
         at_start = start(i) - start(j)
         at_finish = finish(i) - finish(j)
         if (.not. differ_in_sign(at_start, at_finish)) cycle
         s = at_start/(at_start - at_finish)
         if (s <= low .or. s >= high) cycle
         k = n
         do while (kink(k) > s)
            kink(k + 1) = kink(k)
            k = k - 1
         end do
         kink(k + 1) = s
         n = n + 1
      end do
   end subroutine find_kinks

   !> Which of three numbers is the least.
   pure integer function least(value)
      real(wp), intent(in) :: value(3)

      least = 1
      if (value(2) < value(1)) least = 2
      if (value(3) < value(least)) least = 3
   end function least

   pure logical function differ_in_sign(a, b)
      real(wp), intent(in) :: a, b

      differ_in_sign = (a < 0.0_wp .and. b > 0.0_wp) .or. (a > 0.0_wp .and. b < 0.0_wp)
   end function differ_in_sign

   !> Area coordinates of a point in a triangle.
   pure function area_coordinates(corner, point) result(lambda)
      !> Corners, anticlockwise (2, 3) [m]
      real(wp), intent(in) :: corner(2, 3)
      !> Point (2) [m]
      real(wp), intent(in) :: point(2)
      real(wp) :: lambda(3)
      integer :: k, from, to

      ! Each from its own edge: an edge that the point lies on gives an exact zero
      do k = 1, 3
         from = mod(k, 3) + 1
         to = mod(k + 1, 3) + 1
         lambda(k) = (corner(1, to) - corner(1, from))*(point(2) - corner(2, from)) &
                     - (corner(2, to) - corner(2, from))*(point(1) - corner(1, from))
      end do
      lambda = lambda/twice_area(corner)
   end function area_coordinates

   !> Twice the area of a triangle, negative when it is turned inside out.
   pure real(wp) function twice_area(corner)
      !> Corners (2, 3) [m]
      real(wp), intent(in) :: corner(2, 3)

      twice_area = (corner(1, 2) - corner(1, 1))*(corner(2, 3) - corner(2, 1)) &
                   - (corner(2, 2) - corner(2, 1))*(corner(1, 3) - corner(1, 1))
   end function twice_area

   !> Penalty of a pair: the harmonic mean, as of two springs in series, so that the softer rock sets it.
   pure real(wp) function pair_penalty(a, b)
      !> Penalties of the two rocks [Pa]
      real(wp), intent(in) :: a, b

      pair_penalty = 0.0_wp
      if (a > 0.0_wp .and. b > 0.0_wp) pair_penalty = 2.0_wp*a/(1.0_wp + a/b)
   end function pair_penalty

end module potential_m
