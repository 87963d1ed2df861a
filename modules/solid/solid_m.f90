!> Constant-strain triangles with finite rotation, plane strain, unit thickness.
!>
!> The deformation gradient F = I + H of each triangle is split into rotation and stretch, F = R U (in two dimensions in
!> closed form), and the stretch is elastic: T = 2 mu (U - I) + lambda tr(U - I) I is conjugate to U, the first
!> Piola-Kirchhoff stress is P = R T and the nodal forces are -A P grad N. They derive from the energy
!> A (mu |U - I|^2 + lambda/2 tr(U - I)^2), so a rigid rotation costs nothing and energy is kept.
!> Rock under a stress S0 before any motion has A S0:E besides, E = (F^T F - I)/2 of Green: P = R T + F S0, which turns with the
!> rock and is S0 where nothing has moved.
!> Everything is built from displacements, not positions, so that small strains are not lost in cancellation.
module solid_m
   use kinds_m, only: wp
   use patches_m, only: patches_t, colour_patches
   implicit none
   private

   !> Triangles handled together: gathered, computed as vectors, scattered
   integer, parameter :: block_size = 64

   !> The rock: connectivity, reference geometry and elastic constants of the triangles
   type, public :: solid_t
      !> Corner nodes (3, triangles)
      integer, allocatable :: node(:, :)
      !> Gradients of the first two shape functions (triangles) [1/m]; the third is minus their sum
      real(wp), allocatable :: b1(:), c1(:), b2(:), c2(:)
      !> Area (triangles) [m2], shortest height [m]
      real(wp), allocatable :: area(:), height(:)
      !> Lame constants times area (triangles) [N/m per m of thickness]
      real(wp), allocatable :: lambda_area(:), mu_area(:)
      !> Density [kg/m3] and Young's modulus [Pa] (triangles)
      real(wp), allocatable :: density(:), young(:)
      !> Viscosity times area of the viscous damping (triangles) [Pa s m2]; not allocated without it
      real(wp), allocatable :: viscosity_area(:)
      !> Stress S0 before any motion times area: sxx, syy, sxy, tension positive (3, triangles) [N/m per m of thickness], and the
      !> energy stored by it (triangles) [J per m]; not allocated where there is none
      real(wp), allocatable :: in_situ_area(:, :), in_situ_energy(:)
      !> Patches of triangles that threads work on, and the nodes that are met first in each turn: those of turn t are
      !> met(met_first(t):met_first(t + 1) - 1)
      type(patches_t) :: patches
      integer, allocatable :: met(:), met_first(:)
   end type solid_t

   public :: init_solid, renumber, set_in_situ, take_out, set_viscosity, lumped_mass, solid_forces, viscous_forces, solid_stress, &
             in_situ_scale, wave_impedance, strain_energy, turned_over, solid_stiffness_bound, solid_damping_bound, decompose

contains

   !> Set up the triangles. Degenerate triangles must have been refused before.
   subroutine init_solid(x, triangle, density, young, poisson, solid, patch)
      !> Reference coordinates (2, nodes) [m]
      real(wp), intent(in) :: x(:, :)
      !> Corner nodes, anticlockwise (3, triangles)
      integer, intent(in) :: triangle(:, :)
      !> Density [kg/m3], Young's modulus [Pa], Poisson's ratio, each (triangles)
      real(wp), intent(in) :: density(:), young(:), poisson(:)
      type(solid_t), intent(out) :: solid
      !> First triangle of each patch of neighbours (patches); one patch unless given
      integer, intent(in), optional :: patch(:)
      integer :: e, n
      real(wp) :: p1(2), p2(2), p3(2), twice_area, longest

      n = size(triangle, 2)
      if (present(patch)) then
         call colour_patches(triangle, size(x, 2), patch, solid%patches)
      else
         call colour_patches(triangle, size(x, 2), [1], solid%patches)
      end if
      call renumber(triangle, size(x, 2), solid)
      solid%density = density
      solid%young = young
      allocate (solid%b1(n), solid%c1(n), solid%b2(n), solid%c2(n), solid%area(n), solid%height(n))
      do e = 1, n
         p1 = x(:, triangle(1, e))
         p2 = x(:, triangle(2, e))
         p3 = x(:, triangle(3, e))
         twice_area = (p2(1) - p1(1))*(p3(2) - p1(2)) - (p3(1) - p1(1))*(p2(2) - p1(2))
         solid%b1(e) = (p2(2) - p3(2))/twice_area
         solid%c1(e) = (p3(1) - p2(1))/twice_area
         solid%b2(e) = (p3(2) - p1(2))/twice_area
         solid%c2(e) = (p1(1) - p3(1))/twice_area
         solid%area(e) = 0.5_wp*twice_area
         longest = sqrt(max(sum((p2 - p1)**2), sum((p3 - p2)**2), sum((p1 - p3)**2)))
         solid%height(e) = twice_area/longest
      end do
      solid%mu_area = solid%area*young/(2.0_wp*(1.0_wp + poisson))
      solid%lambda_area = solid%area*young*poisson/((1.0_wp + poisson)*(1.0_wp - 2.0_wp*poisson))
   end subroutine init_solid

   !> Stress that the triangles are under before any motion, and its energy.
   pure subroutine set_in_situ(stress, solid)
      !> sxx, syy, sxy, tension positive (3, triangles) [Pa]
      real(wp), intent(in) :: stress(:, :)
      type(solid_t), intent(inout) :: solid

      solid%in_situ_area = stress*spread(solid%area, 1, 3)
      associate (s => solid%in_situ_area, lambda => solid%lambda_area, mu => solid%mu_area)
         solid%in_situ_energy = (s(1, :)**2 + s(2, :)**2 + 2.0_wp*s(3, :)**2 &
                                 - lambda/(2.0_wp*(lambda + mu))*(s(1, :) + s(2, :))**2)/(4.0_wp*mu)
      end associate
   end subroutine set_in_situ

   !> Give the triangles their nodes, at first or after cuts: patches that share no node go on to share none.
   subroutine renumber(triangle, nodes, solid)
      !> Corner nodes (3, triangles), number of nodes
      integer, intent(in) :: triangle(:, :), nodes
      type(solid_t), intent(inout) :: solid
      integer :: met(nodes), t, e, i, n
      logical :: known(nodes)

      solid%node = triangle
      known = .false.
      n = 0
      if (allocated(solid%met_first)) deallocate (solid%met_first)
      allocate (solid%met_first(size(solid%patches%first) + 1))
      do t = 1, size(solid%patches%first)
         solid%met_first(t) = n + 1
         do e = solid%patches%first(t), solid%patches%last(t)
            do i = 1, 3
               if (known(triangle(i, e))) cycle
               known(triangle(i, e)) = .true.
               n = n + 1
               met(n) = triangle(i, e)
            end do
         end do
      end do
      solid%met_first(size(solid%met_first)) = n + 1
      solid%met = met(:n)
   end subroutine renumber

   !> Triangles that are taken out have neither mass nor stiffness any more.
   pure subroutine take_out(there, solid)
      !> Is the triangle there? (triangles)
      logical, intent(in) :: there(:)
      type(solid_t), intent(inout) :: solid

      where (.not. there)
         solid%density = 0.0_wp
         solid%lambda_area = 0.0_wp
         solid%mu_area = 0.0_wp
      end where
      if (allocated(solid%in_situ_area)) then
         where (spread(.not. there, 1, 3)) solid%in_situ_area = 0.0_wp
         where (.not. there) solid%in_situ_energy = 0.0_wp
      end if
      if (allocated(solid%viscosity_area)) then
         where (.not. there) solid%viscosity_area = 0.0_wp
      end if
   end subroutine take_out

   !> Viscous damping of the paper: eta = factor * 2 h sqrt(E rho), h the square root of twice the triangle's area.
   subroutine set_viscosity(solid, factor)
      type(solid_t), intent(inout) :: solid
      !> 1 is the critical value of the paper
      real(wp), intent(in) :: factor

      solid%viscosity_area = factor*2.0_wp*sqrt(2.0_wp*solid%area)*sqrt(solid%young*solid%density)*solid%area
   end subroutine set_viscosity

   !> Lumped mass: a third of each triangle's mass to each corner.
   pure subroutine lumped_mass(solid, mass)
      type(solid_t), intent(in) :: solid
      !> Nodal mass (nodes) [kg per m of thickness]
      real(wp), intent(out) :: mass(:)
      integer :: e, i

      mass = 0.0_wp
      do e = 1, size(solid%node, 2)
         do i = 1, 3
            mass(solid%node(i, e)) = mass(solid%node(i, e)) + solid%density(e)*solid%area(e)/3.0_wp
         end do
      end do
   end subroutine lumped_mass

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

   !> Norm of the forces of the in-situ stress, corner by corner, before they balance each other [N per m of thickness].
   pure real(wp) function in_situ_scale(solid) result(scale)
      type(solid_t), intent(in) :: solid
      integer :: e

      scale = 0.0_wp
      do e = 1, size(solid%area)
         associate (s => solid%in_situ_area(:, e), b1 => solid%b1(e), b2 => solid%b2(e), c1 => solid%c1(e), c2 => solid%c2(e))
            scale = scale + sum((s(1)*[b1, b2, b1 + b2] + s(3)*[c1, c2, c1 + c2])**2 &
                                + (s(3)*[b1, b2, b1 + b2] + s(2)*[c1, c2, c1 + c2])**2)
         end associate
      end do
      scale = sqrt(scale)
   end function in_situ_scale

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

   !> Cauchy stress [sxx, syy, sxy] of one triangle, tension positive [Pa].
   pure function solid_stress(solid, e, u) result(stress)
      type(solid_t), intent(in) :: solid
      !> Triangle
      integer, intent(in) :: e
      !> Displacement (2, nodes) [m]
      real(wp), intent(in) :: u(:, :)
      real(wp) :: stress(3), h(2, 2), c, s, strain(3), t(2, 2), rotation(2, 2), f(2, 2), sigma(2, 2), trace, det

      h = displacement_gradient(solid, e, u)
      call rotation_and_strain(h, c, s, strain)
      trace = solid%lambda_area(e)*(strain(1) + strain(2))
      t(1, 1) = trace + 2.0_wp*solid%mu_area(e)*strain(1)
      t(2, 2) = trace + 2.0_wp*solid%mu_area(e)*strain(2)
      t(1, 2) = 2.0_wp*solid%mu_area(e)*strain(3)
      t(2, 1) = t(1, 2)
      rotation(:, 1) = [c, s]
      rotation(:, 2) = [-s, c]
      f = h
      f(1, 1) = f(1, 1) + 1.0_wp
      f(2, 2) = f(2, 2) + 1.0_wp
      det = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
      ! A triangle without area has a stress of any size, but a number
      det = sign(max(abs(det), epsilon(1.0_wp)), det)
      t = matmul(rotation, t)
      if (allocated(solid%in_situ_area)) t = t + in_situ_part(solid, e, h)
      sigma = matmul(t, transpose(f))/(det*solid%area(e))
      stress = [sigma(1, 1), sigma(2, 2), 0.5_wp*(sigma(1, 2) + sigma(2, 1))]
   end function solid_stress

   !> Elastic energy stored in the rock [J per m of thickness].
   pure real(wp) function strain_energy(solid, u)
      type(solid_t), intent(in) :: solid
      !> Displacement (2, nodes) [m]
      real(wp), intent(in) :: u(:, :)
      real(wp) :: c, s, strain(3), h(2, 2)
      integer :: e

      strain_energy = 0.0_wp
      do e = 1, size(solid%node, 2)
         h = displacement_gradient(solid, e, u)
         if (allocated(solid%in_situ_area)) then
            ! S0:E, E = (H + H^T + H^T H)/2
            strain = [h(1, 1) + 0.5_wp*sum(h(:, 1)**2), h(2, 2) + 0.5_wp*sum(h(:, 2)**2), &
                      h(1, 2) + h(2, 1) + dot_product(h(:, 1), h(:, 2))]
            strain_energy = strain_energy + solid%in_situ_energy(e) + dot_product(solid%in_situ_area(:, e), strain)
         end if
         call rotation_and_strain(h, c, s, strain)
         strain_energy = strain_energy + solid%mu_area(e)*(strain(1)**2 + strain(2)**2 + 2.0_wp*strain(3)**2) &
                         + 0.5_wp*solid%lambda_area(e)*(strain(1) + strain(2))**2
      end do
   end function strain_energy

   !> Which triangles are turned inside out: those whose area has fallen through zero, which no rock does (triangles).
   pure function turned_over(solid, u) result(turned)
      type(solid_t), intent(in) :: solid
      !> Displacement (2, nodes) [m]
      real(wp), intent(in) :: u(:, :)
      logical :: turned(size(solid%area))
      real(wp) :: h(2, 2)
      integer :: e

      do e = 1, size(turned)
         h = displacement_gradient(solid, e, u)
         ! What was taken out is no rock
         turned(e) = solid%mu_area(e) > 0.0_wp .and. (1.0_wp + h(1, 1))*(1.0_wp + h(2, 2)) - h(1, 2)*h(2, 1) <= 0.0_wp
      end do
   end function turned_over

   !> rho cp and rho cs of the rock (2, triangles) [Pa s/m].
   pure function wave_impedance(solid) result(impedance)
      type(solid_t), intent(in) :: solid
      real(wp) :: impedance(2, size(solid%area))

      impedance(1, :) = sqrt(solid%density*(solid%lambda_area + 2.0_wp*solid%mu_area)/solid%area)
      impedance(2, :) = sqrt(solid%density*solid%mu_area/solid%area)
   end function wave_impedance

   !> Add each triangle's largest stiffness eigenvalue to its corners: with s(i) the sum over triangles, bonds and
   !> contacts, u.K u <= sum s(i)|u_i|^2, so that no frequency exceeds max sqrt(s(i)/m(i)).
   pure subroutine solid_stiffness_bound(solid, bound)
      type(solid_t), intent(in) :: solid
      !> Nodal bound (nodes) [N/m per m of thickness]
      real(wp), intent(inout) :: bound(:)
      integer :: e

      do e = 1, size(solid%node, 2)
         associate (node => solid%node(:, e))
            bound(node) = bound(node) + largest_eigenvalue(solid, e, solid%lambda_area(e), solid%mu_area(e))
            if (allocated(solid%in_situ_area)) bound(node) = bound(node) + stiffness_of_tension(solid, e)
         end associate
      end do
   end subroutine solid_stiffness_bound

   !> What in-situ stress adds to the stiffness at most, as a string's tension does: the larger principal tension times the sum of
   !> the squared gradients. Compression takes stiffness away.
   pure real(wp) function stiffness_of_tension(solid, e) result(stiffness)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: e
      real(wp) :: largest

      associate (s => solid%in_situ_area(:, e), b1 => solid%b1(e), b2 => solid%b2(e), c1 => solid%c1(e), c2 => solid%c2(e))
         largest = 0.5_wp*(s(1) + s(2)) + hypot(0.5_wp*(s(1) - s(2)), s(3))
         stiffness = max(0.0_wp, largest)*(b1**2 + b2**2 + (b1 + b2)**2 + c1**2 + c2**2 + (c1 + c2)**2)
      end associate
   end function stiffness_of_tension

   !> The same for the matrix of the viscous damping: eta D is an elasticity with lambda = 0, mu = eta/2.
   pure subroutine solid_damping_bound(solid, bound)
      type(solid_t), intent(in) :: solid
      !> Nodal bound (nodes) [N s/m per m of thickness]
      real(wp), intent(inout) :: bound(:)
      integer :: e

      do e = 1, size(solid%node, 2)
         associate (node => solid%node(:, e))
            bound(node) = bound(node) + largest_eigenvalue(solid, e, 0.0_wp, 0.5_wp*solid%viscosity_area(e))
         end associate
      end do
   end subroutine solid_damping_bound

   !> Largest eigenvalue of B^T D B, which is that of the symmetric 3 x 3 matrix D^1/2 B B^T D^1/2.
   pure real(wp) function largest_eigenvalue(solid, e, lambda_area, mu_area) result(eigenvalue)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: e
      !> Lame constants times area
      real(wp), intent(in) :: lambda_area, mu_area
      real(wp) :: b3, c3, sbb, scc, sbc, sum_root, difference_root, root(3, 3), bbt(3, 3)

      b3 = -solid%b1(e) - solid%b2(e)
      c3 = -solid%c1(e) - solid%c2(e)
      sbb = solid%b1(e)**2 + solid%b2(e)**2 + b3**2
      scc = solid%c1(e)**2 + solid%c2(e)**2 + c3**2
      sbc = solid%b1(e)*solid%c1(e) + solid%b2(e)*solid%c2(e) + b3*c3
      bbt(:, 1) = [sbb, 0.0_wp, sbc]
      bbt(:, 2) = [0.0_wp, scc, sbc]
      bbt(:, 3) = [sbc, sbc, sbb + scc]
      ! D = [lambda + 2 mu, lambda; lambda, lambda + 2 mu] has the eigenvalues 2 (lambda + mu) and 2 mu
      sum_root = sqrt(2.0_wp*(lambda_area + mu_area))
      difference_root = sqrt(2.0_wp*mu_area)
      root = 0.0_wp
      root(1, 1) = 0.5_wp*(sum_root + difference_root)
      root(2, 2) = root(1, 1)
      root(1, 2) = 0.5_wp*(sum_root - difference_root)
      root(2, 1) = root(1, 2)
      root(3, 3) = sqrt(mu_area)
      eigenvalue = largest_of_symmetric(matmul(root, matmul(bbt, root)))
   end function largest_eigenvalue

   !> Largest eigenvalue of a symmetric 3 x 3 matrix in closed form (Cardano, with the trigonometric root).
   pure real(wp) function largest_of_symmetric(matrix) result(eigenvalue)
      real(wp), intent(in) :: matrix(3, 3)
      !> Stay on the safe side of rounding
      real(wp), parameter :: margin = 1.0_wp + 1.0e-9_wp
      real(wp) :: mean, spread, a(3, 3), half_det
      integer :: i

      mean = (matrix(1, 1) + matrix(2, 2) + matrix(3, 3))/3.0_wp
      a = matrix
      do i = 1, 3
         a(i, i) = a(i, i) - mean
      end do
      spread = sqrt(sum(a**2)/6.0_wp)
      eigenvalue = margin*mean
      if (spread <= 0.0_wp) return
      a = a/spread
      half_det = 0.5_wp*(a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) &
                         + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1)))
      eigenvalue = margin*(mean + 2.0_wp*spread*cos(acos(max(-1.0_wp, min(1.0_wp, half_det)))/3.0_wp))
   end function largest_of_symmetric

end module solid_m
