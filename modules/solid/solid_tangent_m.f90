!> Tangent stiffness of the triangles of solid_m, exact at any rotation.
!>
!> The energy of a triangle is A [mu (|F|^2 - 2 tr U + 2) + lambda/2 (tr U - 2)^2] with F = R U. With tr U = R:F,
!> d(tr U) = R:dF and dR = W dtheta, dtheta = W:dF/tr U, W = dR/dtheta, its second derivative is
!> A [2 mu I + lambda R x R + (lambda (tr U - 2) - 2 mu)/tr U W x W]: symmetric, and of rank three beyond the first term. In-situ
!> stress adds grad N_i.S0 grad N_j to the diagonal of each pair of corners.
module solid_tangent_m
   use kinds_m, only: wp
   use solid_m, only: solid_t
   use solid_forces_m, only: decompose
   implicit none
   private

   public :: triangle_tangent

contains

   !> Stiffness of one triangle: minus the derivative of its corner forces by the corner displacements, in the order
   !> x1, y1, x2, y2, x3, y3.
   pure function triangle_tangent(solid, e, u) result(stiffness)
      type(solid_t), intent(in) :: solid
      !> Triangle
      integer, intent(in) :: e
      !> Displacement of the corners (2, 3) [m]
      real(wp), intent(in) :: u(2, 3)
      !> (6, 6) [N/m per m of thickness]
      real(wp) :: stiffness(6, 6)
      real(wp) :: b(3), c(3), h(2, 2), cosine, sine, stretch, strain(3), spin_factor, along(6), spin(6), shear
      integer :: i, j

      b(1:2) = [solid%b1(e), solid%b2(e)]
      c(1:2) = [solid%c1(e), solid%c2(e)]
      b(3) = -b(1) - b(2)
      c(3) = -c(1) - c(2)
      h(:, 1) = (u(:, 1) - u(:, 3))*b(1) + (u(:, 2) - u(:, 3))*b(2)
      h(:, 2) = (u(:, 1) - u(:, 3))*c(1) + (u(:, 2) - u(:, 3))*c(2)
      call decompose(h(1, 1), h(1, 2), h(2, 1), h(2, 2), cosine, sine, stretch, strain(1), strain(2), strain(3))
      do i = 1, 3
         ! R grad N and W grad N, with R = [c -s; s c] and W = [-s -c; c -s]
         along(2*i - 1:2*i) = [cosine*b(i) - sine*c(i), sine*b(i) + cosine*c(i)]
         spin(2*i - 1:2*i) = [-sine*b(i) - cosine*c(i), cosine*b(i) - sine*c(i)]
      end do
      spin_factor = (solid%lambda_area(e)*(stretch - 2.0_wp) - 2.0_wp*solid%mu_area(e))/stretch
      do j = 1, 6
         stiffness(:, j) = solid%lambda_area(e)*along(j)*along + spin_factor*spin(j)*spin
      end do
      do j = 1, 3
         do i = 1, 3
            shear = 2.0_wp*solid%mu_area(e)*(b(i)*b(j) + c(i)*c(j))
            if (allocated(solid%in_situ_area)) then
               associate (s => solid%in_situ_area(:, e))
                  shear = shear + s(1)*b(i)*b(j) + s(2)*c(i)*c(j) + s(3)*(b(i)*c(j) + c(i)*b(j))
               end associate
            end if
            stiffness(2*i - 1, 2*j - 1) = stiffness(2*i - 1, 2*j - 1) + shear
            stiffness(2*i, 2*j) = stiffness(2*i, 2*j) + shear
         end do
      end do
   end function triangle_tangent

end module solid_tangent_m
