!> Bodies that nothing holds: without supports their equilibrium is not unique, and an implicit solver has no answer.
!>
!> A body is rock joined by triangles; bodies that share a joint lean on each other or are bonded, and form an assembly. An
!> assembly is held when the prescribed displacement components of its nodes exclude both translations and the rotation.
module support_m
   use kinds_m, only: wp
   use union_find_m, only: each_alone, join, representatives
   implicit none
   private

   public :: find_loose, assemblies

   !> Rigid motions in the plane
   integer, parameter :: motions = 3
   !> A motion is excluded when the pivot of the supports' matrix exceeds this share of the largest
   real(wp), parameter :: least_pivot = 1.0e-9_wp

contains

   !> Assemblies that nothing holds: a node of each.
   subroutine find_loose(x, triangle, joint, fixed, node)
      !> Coordinates (2, nodes) [m]
      real(wp), intent(in) :: x(:, :)
      !> Corner nodes (3, triangles); nodes of the joints (4, joints)
      integer, intent(in) :: triangle(:, :), joint(:, :)
      !> Prescribed components (2, nodes)
      logical, intent(in) :: fixed(:, :)
      !> (loose assemblies)
      integer, allocatable, intent(out) :: node(:)
      integer :: of_node(size(x, 2)), first
      logical :: meshed(size(x, 2))
      !> Centre and size of each assembly, matrix of its supports, at the node that stands for it
      real(wp), allocatable :: centre(:, :), size_of(:), matrix(:, :, :)

      call find_assemblies(triangle, joint, of_node, meshed)
      call measure_assemblies(x, of_node, centre, size_of)
      call add_supports(x, fixed, of_node, centre, size_of, matrix)
      node = pack([(first, first=1, size(of_node))], &
                  [(of_node(first) == first .and. meshed(first) .and. .not. holds(matrix(:, :, first)), first=1, size(of_node))])
   end subroutine find_loose

   !> Number of assemblies.
   pure integer function assemblies(nodes, triangle, joint)
      !> Number of nodes
      integer, intent(in) :: nodes
      !> Corner nodes (3, triangles); nodes of the joints (4, joints)
      integer, intent(in) :: triangle(:, :), joint(:, :)
      integer :: of_node(nodes), n
      logical :: meshed(nodes)

      call find_assemblies(triangle, joint, of_node, meshed)
      assemblies = count([(of_node(n) == n .and. meshed(n), n=1, size(of_node))])
   end function assemblies

   !> A node that stands for the assembly of each node, and whether the node belongs to rock (nodes).
   pure subroutine find_assemblies(triangle, joint, of_node, meshed)
      integer, intent(in) :: triangle(:, :), joint(:, :)
      integer, intent(out) :: of_node(:)
      logical, intent(out) :: meshed(:)
      integer :: e, k

      of_node = each_alone(size(of_node))
      meshed = .false.
      do e = 1, size(triangle, 2)
         do k = 2, 3
            call join(of_node, triangle(1, e), triangle(k, e))
         end do
         meshed(triangle(:, e)) = .true.
      end do
      do e = 1, size(joint, 2)
         do k = 2, 4
            call join(of_node, joint(1, e), joint(k, e))
         end do
      end do
      of_node = representatives(of_node)
   end subroutine find_assemblies

   !> Centre of the nodes of each assembly, and its half width, both at the node that stands for it (nodes).
   pure subroutine measure_assemblies(x, of_node, centre, size_of)
      real(wp), intent(in) :: x(:, :)
      integer, intent(in) :: of_node(:)
      !> (2, nodes) [m] and (nodes) [m]
      real(wp), allocatable, intent(out) :: centre(:, :), size_of(:)
      integer :: members(size(of_node)), n

      allocate (centre(2, size(of_node)), size_of(size(of_node)), source=0.0_wp)
      members = 0
      do n = 1, size(of_node)
         members(of_node(n)) = members(of_node(n)) + 1
         centre(:, of_node(n)) = centre(:, of_node(n)) + x(:, n)
      end do
      do n = 1, size(of_node)
         if (members(n) > 0) centre(:, n) = centre(:, n)/real(members(n), wp)
      end do
      do n = 1, size(of_node)
         size_of(of_node(n)) = max(size_of(of_node(n)), maxval(abs(x(:, n) - centre(:, of_node(n)))))
      end do
   end subroutine measure_assemblies

   !> Matrix of the supports of each assembly: the sum over its prescribed components of what they do in the rigid motions.
   pure subroutine add_supports(x, fixed, of_node, centre, size_of, matrix)
      real(wp), intent(in) :: x(:, :)
      logical, intent(in) :: fixed(:, :)
      integer, intent(in) :: of_node(:)
      real(wp), intent(in) :: centre(:, :), size_of(:)
      !> (motions, motions, nodes)
      real(wp), allocatable, intent(out) :: matrix(:, :, :)
      real(wp) :: row(motions)
      integer :: n, i, k

      allocate (matrix(motions, motions, size(of_node)), source=0.0_wp)
      do n = 1, size(of_node)
         associate (a => of_node(n))
            do i = 1, 2
               if (.not. fixed(i, n) .or. size_of(a) <= 0.0_wp) cycle
               ! Motion of this component in the two translations and the rotation about the centre
               if (i == 1) row = [1.0_wp, 0.0_wp, -(x(2, n) - centre(2, a))/size_of(a)]
               if (i == 2) row = [0.0_wp, 1.0_wp, (x(1, n) - centre(1, a))/size_of(a)]
               do k = 1, motions
                  matrix(:, k, a) = matrix(:, k, a) + row*row(k)
               end do
            end do
         end associate
      end do
   end subroutine add_supports

   !> Do the supports exclude every rigid motion?
   pure logical function holds(supports)
      !> Their matrix (motions, motions)
      real(wp), intent(in) :: supports(:, :)
      real(wp) :: matrix(motions, motions), pivot
      integer :: k, best, excluded
      logical :: used(motions)

      matrix = supports
      used = .false.
      pivot = least_pivot*max(matrix(1, 1), matrix(2, 2), matrix(3, 3))
      do excluded = 1, motions
         best = maxloc([(matrix(k, k), k=1, motions)], mask=.not. used, dim=1)
         holds = matrix(best, best) > pivot
         if (.not. holds) return
         used(best) = .true.
         do k = 1, motions
            if (.not. used(k)) matrix(:, k) = matrix(:, k) - matrix(:, best)*(matrix(best, k)/matrix(best, best))
         end do
      end do
   end function holds

end module support_m
