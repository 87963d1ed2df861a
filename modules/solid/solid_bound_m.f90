!> Bounds of the stiffness and the damping of constant-strain triangles: what limits the stable step.
module solid_bound_m
   use kinds_m, only: wp
   use solid_m, only: solid_t
   implicit none
   private

   public :: solid_stiffness_bound, solid_damping_bound

contains

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

end module solid_bound_m
