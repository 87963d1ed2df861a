!> Absorbing sides: waves that reach them leave (Lysmer & Kuhlemeyer 1969).
!>
!> A side has dashpots, for each metre rho cp across and rho cs along it: what a plane wave that goes straight through it would
!> feel of the rock beyond. They act on the sides as they were before any motion, and are lumped to the nodes as tractions are. Over
!> a step they act with the mean of the velocities before and after, which is solved for node by node: the stable step stays that
!> without them.
module absorbing_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   implicit none
   private

   !> Dashpots at the nodes of absorbing sides
   type, public :: absorbing_t
      !> Their nodes in ascending order; not allocated without any
      integer, allocatable :: node(:)
      !> Damping matrix of each: xx, yy, xy (3, size(node)) [N s/m per m of thickness]
      real(wp), allocatable :: damping(:, :)
   contains
      procedure :: number => dashpots
   end type absorbing_t

   public :: absorbing_sides, dashpot_force

contains

   !> The dashpots of some edges.
   pure function absorbing_sides(split, edge, impedance) result(absorbing)
      type(split_mesh_t), intent(in) :: split
      !> Which surface edges absorb (surface edges)
      logical, intent(in) :: edge(:)
      !> rho cp and rho cs of the rock (2, triangles) [Pa s/m]
      real(wp), intent(in) :: impedance(:, :)
      type(absorbing_t) :: absorbing
      real(wp) :: damping(3, size(split%x, 2)), along(2), n(2), length
      logical :: has(size(split%x, 2))
      integer :: e, i

      damping = 0.0_wp
      has = .false.
      do e = 1, size(edge)
         if (.not. edge(e)) cycle
         along = split%x(:, split%surface(2, e)) - split%x(:, split%surface(1, e))
         length = norm2(along)
         n = [along(2), -along(1)]/length
         associate (z => impedance(:, split%surface_triangle(e)))
            do i = 1, 2
               associate (node => split%surface(i, e))
                  has(node) = .true.
                  ! C = L/2 (rho cp n n^T + rho cs t t^T), t t^T = I - n n^T
                  damping(:, node) = damping(:, node) + 0.5_wp*length* &
                                     [z(1)*n(1)**2 + z(2)*n(2)**2, z(1)*n(2)**2 + z(2)*n(1)**2, (z(1) - z(2))*n(1)*n(2)]
               end associate
            end do
         end associate
      end do
      allocate (absorbing%node(count(has)), absorbing%damping(3, count(has)))
      absorbing%node = pack([(i, i=1, size(has))], has)
      absorbing%damping = damping(:, absorbing%node)
   end function absorbing_sides

   !> Number of nodes with dashpots.
   pure integer function dashpots(self)
      class(absorbing_t), intent(in) :: self

      dashpots = 0
      if (allocated(self%node)) dashpots = size(self%node)
   end function dashpots

   !> Force of a node's dashpots over a step, -C (v + v')/2, with the velocity v' that it leads to: where the node is free
   !> m (v' - v) = kick (force - C (v + v')/2) [N per m of thickness].
   pure function dashpot_force(damping, mass, v, free, moved, force, kick) result(dashpot)
      !> Damping matrix xx, yy, xy (3) [N s/m], mass [kg], each per m of thickness
      real(wp), intent(in) :: damping(3), mass
      !> Velocity before (2) [m/s]; 0 where the component is prescribed, else 1; what it is then (2) [m/s]
      real(wp), intent(in) :: v(2), free(2), moved(2)
      !> All other forces (2) [N per m], and how long they act [s]
      real(wp), intent(in) :: force(2), kick
      real(wp) :: dashpot(2), a(2, 2), right(2), mean(2)

      ! (m + kick/2 C) mean = m v + kick/2 force
      a(1, 1) = mass + 0.5_wp*kick*damping(1)
      a(2, 2) = mass + 0.5_wp*kick*damping(2)
      a(1, 2) = free(1)*0.5_wp*kick*damping(3)
      a(2, 1) = free(2)*0.5_wp*kick*damping(3)
      right = mass*v + 0.5_wp*kick*force
      where (free < 0.5_wp) right = 0.5_wp*(v + moved)*[a(1, 1), a(2, 2)]
      mean = [a(2, 2)*right(1) - a(1, 2)*right(2), a(1, 1)*right(2) - a(2, 1)*right(1)]/(a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1))
      dashpot = -[damping(1)*mean(1) + damping(3)*mean(2), damping(3)*mean(1) + damping(2)*mean(2)]
   end function dashpot_force

end module absorbing_m
