!> The rock: constant-strain triangles in plane strain, of unit thickness. What they are made of; their forces are in
!> solid_forces_m, stresses and energy in solid_stress_m, bounds of their stiffness in solid_bound_m.
module solid_m
   use kinds_m, only: wp
   use patches_m, only: patches_t, colour_patches
   implicit none
   private

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

   public :: init_solid, renumber, set_in_situ, take_out, set_viscosity, lumped_mass, wave_impedance

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

   !> rho cp and rho cs of the rock (2, triangles) [Pa s/m].
   pure function wave_impedance(solid) result(impedance)
      type(solid_t), intent(in) :: solid
      real(wp) :: impedance(2, size(solid%area))

      impedance(1, :) = sqrt(solid%density*(solid%lambda_area + 2.0_wp*solid%mu_area)/solid%area)
      impedance(2, :) = sqrt(solid%density*solid%mu_area/solid%area)
   end function wave_impedance

end module solid_m
