!> Forces of constant-strain triangles with finite rotation, plane strain, unit thickness.
!>
!> The deformation gradient F = I + H of each triangle is split into rotation and stretch, F = R U (in two dimensions in
!> closed form), and the stretch is elastic: T = 2 mu (U - I) + lambda tr(U - I) I is conjugate to U, the first
!> Piola-Kirchhoff stress is P = R T and the nodal forces are -A P grad N. They derive from the energy
!> A (mu |U - I|^2 + lambda/2 tr(U - I)^2), so a rigid rotation costs nothing and energy is kept.
!> Rock under a stress S0 before any motion has A S0:E besides, E = (F^T F - I)/2 of Green: P = R T + F S0, which turns with the
!> rock and is S0 where nothing has moved.
!> Everything is built from displacements, not positions, so that small strains are not lost in cancellation.
module solid_forces_m
   use kinds_m, only: wp
   use solid_m, only: solid_t
   implicit none
   private

   !> Triangles handled together: gathered, computed as vectors, scattered
   integer, parameter :: block_size = 64

   public :: solid_forces, viscous_forces, displacement_gradient, decompose, rotation_and_strain, in_situ_part

contains

   !> The internal forces of the triangles, -f_int of eq 1.
   subroutine solid_forces(solid, u, force)
      type(solid_t), intent(in) :: solid
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      !> Nodal force (2, nodes) [N per m of thickness]; that of nodes without triangles stays
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: c, t

      !$omp parallel default(none) shared(solid, u, force) private(c, t)
      do c = 1, size(solid%patches%colour) - 1
         !$omp do schedule(static)
         do t = solid%patches%colour(c), solid%patches%colour(c + 1) - 1
            call strain_patch(solid, t, u, force)
         end do
         !$omp end do
      end do
      !$omp end parallel
   end subroutine solid_forces

   !> The same in one turn: the forces of nodes that are met first start here.
   pure subroutine strain_patch(solid, t, u, force)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: t
      real(wp), contiguous, intent(in) :: u(:, :)
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: first, last, i

      do i = solid%met_first(t), solid%met_first(t + 1) - 1
         force(:, solid%met(i)) = 0.0_wp
      end do
      do first = solid%patches%first(t), solid%patches%last(t), block_size
         last = min(first + block_size - 1, solid%patches%last(t))
         call strain_block(last - first + 1, size(u, 2), solid%node(:, first:last), solid%b1(first:last), solid%c1(first:last), &
                           solid%b2(first:last), solid%c2(first:last), solid%lambda_area(first:last), &
                           solid%mu_area(first:last), u, force)
      end do
      if (allocated(solid%in_situ_area)) call in_situ_forces(solid, solid%patches%first(t), solid%patches%last(t), u, force)
   end subroutine strain_patch

   !> The same for a block of triangles. Shapes are explicit, so that the compiler knows how far nodes are apart.
   pure subroutine strain_block(n, nodes, node, b1, c1, b2, c2, lambda_area, mu_area, u, force)
      !> Triangles of the block, nodes of the mesh
      integer, intent(in) :: n, nodes
      !> As in solid_t
      integer, intent(in) :: node(3, n)
      real(wp), intent(in), dimension(n) :: b1, c1, b2, c2, lambda_area, mu_area
      real(wp), intent(in) :: u(2, nodes)
      real(wp), intent(inout) :: force(2, nodes)
      real(wp), dimension(block_size) :: d1x, d1y, d2x, d2y, f1x, f1y, f2x, f2y
      real(wp) :: h11, h12, h21, h22, c, s, trace_u, e11, e22, e12, trace, t11, t22, t12, p11, p12, p21, p22
      integer :: k

      do k = 1, n
         d1x(k) = u(1, node(1, k)) - u(1, node(3, k))
         d1y(k) = u(2, node(1, k)) - u(2, node(3, k))
         d2x(k) = u(1, node(2, k)) - u(1, node(3, k))
         d2y(k) = u(2, node(2, k)) - u(2, node(3, k))
      end do
      do k = 1, n
         h11 = d1x(k)*b1(k) + d2x(k)*b2(k)
         h12 = d1x(k)*c1(k) + d2x(k)*c2(k)
         h21 = d1y(k)*b1(k) + d2y(k)*b2(k)
         h22 = d1y(k)*c1(k) + d2y(k)*c2(k)
         call decompose(h11, h12, h21, h22, c, s, trace_u, e11, e22, e12)
         trace = lambda_area(k)*(e11 + e22)
         t11 = trace + 2.0_wp*mu_area(k)*e11
         t22 = trace + 2.0_wp*mu_area(k)*e22
         t12 = 2.0_wp*mu_area(k)*e12
         p11 = c*t11 - s*t12
         p12 = c*t12 - s*t22
         p21 = s*t11 + c*t12
         p22 = s*t12 + c*t22
         f1x(k) = p11*b1(k) + p12*c1(k)
         f1y(k) = p21*b1(k) + p22*c1(k)
         f2x(k) = p11*b2(k) + p12*c2(k)
         f2y(k) = p21*b2(k) + p22*c2(k)
      end do
      call scatter(n, nodes, node, f1x, f1y, f2x, f2y, force)
   end subroutine strain_block

   !> Add the part of the in-situ stress, P = F S0, of triangles that follow each other.
   pure subroutine in_situ_forces(solid, from, to, u, force)
      type(solid_t), intent(in) :: solid
      !> First and last triangle
      integer, intent(in) :: from, to
      !> Displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: u(:, :)
      !> Nodal force (2, nodes) [N per m of thickness]
      real(wp), contiguous, intent(inout) :: force(:, :)
      real(wp), dimension(block_size) :: f1x, f1y, f2x, f2y
      real(wp) :: p(2, 2)
      integer :: first, m, k, e

      do first = from, to, block_size
         m = min(block_size, to - first + 1)
         do k = 1, m
            e = first + k - 1
            p = in_situ_part(solid, e, displacement_gradient(solid, e, u))
            f1x(k) = p(1, 1)*solid%b1(e) + p(1, 2)*solid%c1(e)
            f1y(k) = p(2, 1)*solid%b1(e) + p(2, 2)*solid%c1(e)
            f2x(k) = p(1, 1)*solid%b2(e) + p(1, 2)*solid%c2(e)
            f2y(k) = p(2, 1)*solid%b2(e) + p(2, 2)*solid%c2(e)
         end do
         call scatter(m, size(u, 2), solid%node(:, first:first + m - 1), f1x, f1y, f2x, f2y, force)
      end do
   end subroutine in_situ_forces

   !> F S0 of one triangle, times its area.
   pure function in_situ_part(solid, e, h) result(p)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: e
      !> H = F - I
      real(wp), intent(in) :: h(2, 2)
      real(wp) :: p(2, 2), s(2, 2)

      s = reshape(solid%in_situ_area([1, 3, 3, 2], e), [2, 2])
      p = s + matmul(h, s)
   end function in_situ_part

   !> Add the forces of the viscous damping, Cauchy stress eta D with D the rate of deformation.
   subroutine viscous_forces(solid, u, v, force)
      type(solid_t), intent(in) :: solid
      !> Displacement (2, nodes) [m] and velocity (2, nodes) [m/s]
      real(wp), contiguous, intent(in) :: u(:, :), v(:, :)
      !> Nodal force (2, nodes) [N per m of thickness]
      real(wp), contiguous, intent(inout) :: force(:, :)
      integer :: c, t, first

      !$omp parallel default(none) shared(solid, u, v, force) private(c, t, first)
      do c = 1, size(solid%patches%colour) - 1
         !$omp do schedule(static)
         do t = solid%patches%colour(c), solid%patches%colour(c + 1) - 1
            do first = solid%patches%first(t), solid%patches%last(t), block_size
               call flow_block(solid, first, min(first + block_size - 1, solid%patches%last(t)), u, v, force)
            end do
         end do
         !$omp end do
      end do
      !$omp end parallel
   end subroutine viscous_forces

   !> The same for a block of triangles.
   pure subroutine flow_block(solid, first, last, u, v, force)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: first, last
      real(wp), contiguous, intent(in) :: u(:, :), v(:, :)
      real(wp), contiguous, intent(inout) :: force(:, :)
      real(wp), dimension(block_size) :: f1x, f1y, f2x, f2y
      real(wp) :: f(2, 2), rate(2, 2), inverse(2, 2), det, gradient(2, 2), stress(2, 2), p(2, 2)
      integer :: k, e

      do e = first, last
         k = e - first + 1
         f = displacement_gradient(solid, e, u)
         f(1, 1) = f(1, 1) + 1.0_wp
         f(2, 2) = f(2, 2) + 1.0_wp
         det = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
         ! A triangle without area has a stress of any size, but a number
         det = sign(max(abs(det), epsilon(1.0_wp)), det)
         inverse(:, 1) = [f(2, 2), -f(2, 1)]/det
         inverse(:, 2) = [-f(1, 2), f(1, 1)]/det
         rate = displacement_gradient(solid, e, v)
         gradient = matmul(rate, inverse)
         stress = 0.5_wp*(gradient + transpose(gradient))*solid%viscosity_area(e)
         p = det*matmul(stress, transpose(inverse))
         f1x(k) = p(1, 1)*solid%b1(e) + p(1, 2)*solid%c1(e)
         f1y(k) = p(2, 1)*solid%b1(e) + p(2, 2)*solid%c1(e)
         f2x(k) = p(1, 1)*solid%b2(e) + p(1, 2)*solid%c2(e)
         f2y(k) = p(2, 1)*solid%b2(e) + p(2, 2)*solid%c2(e)
      end do
      call scatter(last - first + 1, size(force, 2), solid%node(:, first:last), f1x, f1y, f2x, f2y, force)
   end subroutine flow_block

   !> Subtract the corner forces of a block of triangles from the nodal forces.
   pure subroutine scatter(n, nodes, node, f1x, f1y, f2x, f2y, force)
      !> Triangles of the block, nodes of the mesh
      integer, intent(in) :: n, nodes
      !> Corner nodes
      integer, intent(in) :: node(3, n)
      !> P grad N times area at the first two corners
      real(wp), intent(in), dimension(n) :: f1x, f1y, f2x, f2y
      real(wp), intent(inout) :: force(2, nodes)
      integer :: k, n1, n2, n3

      do k = 1, n
         n1 = node(1, k)
         n2 = node(2, k)
         n3 = node(3, k)
         force(1, n1) = force(1, n1) - f1x(k)
         force(2, n1) = force(2, n1) - f1y(k)
         force(1, n2) = force(1, n2) - f2x(k)
         force(2, n2) = force(2, n2) - f2y(k)
         force(1, n3) = force(1, n3) + (f1x(k) + f2x(k))
         force(2, n3) = force(2, n3) + (f1y(k) + f2y(k))
      end do
   end subroutine scatter

   !> H(i,j) = d u_i / d X_j of one triangle.
   pure function displacement_gradient(solid, e, u) result(h)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: e
      real(wp), intent(in) :: u(:, :)
      real(wp) :: h(2, 2), d1(2), d2(2)

      d1 = u(:, solid%node(1, e)) - u(:, solid%node(3, e))
      d2 = u(:, solid%node(2, e)) - u(:, solid%node(3, e))
      h(:, 1) = d1*solid%b1(e) + d2*solid%b2(e)
      h(:, 2) = d1*solid%c1(e) + d2*solid%c2(e)
   end function displacement_gradient

   !> Polar decomposition I + H = R U of the displacement gradient H of a triangle. Scalars, so that loops over triangles that call
   !> it are vectorised. A triangle that is its own mirror image (trace 0) has no rotation: R = 0 there and
   !> U - I = -I.
   pure subroutine decompose(h11, h12, h21, h22, c, s, trace, e11, e22, e12)
      real(wp), intent(in) :: h11, h12, h21, h22
      !> Rotation R = [c -s; s c], trace of the stretch U, and U - I
      real(wp), intent(out) :: c, s, trace, e11, e22, e12
      real(wp) :: r, bend

      c = 2.0_wp + h11 + h22
      s = h21 - h12
      trace = max(sqrt(c*c + s*s), epsilon(1.0_wp))
      r = 1.0_wp/trace
      c = c*r
      s = s*r
      ! U - I = R^T (I + H) - I, with 1 - c written as s^2/(1 + c) where that is the more exact
      bend = merge(s*s/(1.0_wp + abs(c)), 1.0_wp - c, c > 0.0_wp)
      e11 = c*h11 + s*h21 - bend
      e22 = c*h22 - s*h12 - bend
      e12 = 0.5_wp*(c*(h12 + h21) + s*(h22 - h11))
   end subroutine decompose

   !> Rotation [c, s] and stretch U - I as [e11, e22, e12] of one triangle.
   pure subroutine rotation_and_strain(h, c, s, strain)
      real(wp), intent(in) :: h(2, 2)
      real(wp), intent(out) :: c, s, strain(3)
      real(wp) :: trace

      call decompose(h(1, 1), h(1, 2), h(2, 1), h(2, 2), c, s, trace, strain(1), strain(2), strain(3))
   end subroutine rotation_and_strain

end module solid_forces_m
