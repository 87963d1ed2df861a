!> Stresses and energy of constant-strain triangles (solid_forces_m).
module solid_stress_m
   use kinds_m, only: wp
   use solid_m, only: solid_t
   use solid_forces_m, only: displacement_gradient, rotation_and_strain, in_situ_part
   implicit none
   private

   public :: solid_stress, strain_energy, turned_over, in_situ_scale

contains

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

end module solid_stress_m
