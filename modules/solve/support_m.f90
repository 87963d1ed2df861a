!> Bodies that nothing holds: without supports their equilibrium is not unique, and an implicit solver has no answer.
!>
!> A body is rock joined by triangles; bodies that share a joint lean on each other or are bonded, and form an assembly. An
!> assembly is held when the prescribed displacement components of its nodes exclude both translations and the rotation.
module support_m
   use kinds_m, only: wp
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

      call find_assemblies(triangle, joint, of_node, meshed)
      allocate (node(0))
      do first = 1, size(of_node)
         if (of_node(first) /= first .or. .not. meshed(first)) cycle
         if (.not. held(x, fixed, of_node == first)) node = [node, first]
      end do
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
      integer :: n, e

      of_node = [(n, n=1, size(of_node))]
      meshed = .false.
      do e = 1, size(triangle, 2)
         call join(of_node, triangle(:, e))
         meshed(triangle(:, e)) = .true.
      end do
      do e = 1, size(joint, 2)
         call join(of_node, joint(:, e))
      end do
      do n = 1, size(of_node)
         of_node(n) = root(of_node, n)
      end do
   end subroutine find_assemblies

   !> Put nodes into one set.
   pure subroutine join(of_node, node)
      integer, intent(inout) :: of_node(:)
      integer, intent(in) :: node(:)
      integer :: i, a, b

      a = root(of_node, node(1))
      do i = 2, size(node)
         b = root(of_node, node(i))
         of_node(max(a, b)) = min(a, b)
         a = min(a, b)
         ! Shorten the way to the root
         of_node(node(i)) = a
      end do
   end subroutine join

   !> The node that stands for a set.
   pure integer function root(of_node, node)
      integer, intent(in) :: of_node(:), node

      root = node
      do while (of_node(root) /= root)
         root = of_node(root)
      end do
   end function root

   !> Do the prescribed components of the member nodes exclude every rigid motion?
   pure logical function held(x, fixed, member)
      real(wp), intent(in) :: x(:, :)
      logical, intent(in) :: fixed(:, :), member(:)
      real(wp) :: matrix(motions, motions), centre(2), size_of, row(motions), pivot
      integer :: n, i, k, best, excluded
      logical :: used(motions)

      centre = [sum(x(1, :), mask=member), sum(x(2, :), mask=member)]/real(count(member), wp)
      size_of = max(maxval(abs(x(1, :) - centre(1)), mask=member), maxval(abs(x(2, :) - centre(2)), mask=member))
      matrix = 0.0_wp
      do n = 1, size(member)
         if (.not. member(n)) cycle
         do i = 1, 2
            if (.not. fixed(i, n)) cycle
            ! Motion of this component in the two translations and the rotation about the centre
            if (i == 1) row = [1.0_wp, 0.0_wp, -(x(2, n) - centre(2))/size_of]
            if (i == 2) row = [0.0_wp, 1.0_wp, (x(1, n) - centre(1))/size_of]
            do k = 1, motions
               matrix(:, k) = matrix(:, k) + row*row(k)
            end do
         end do
      end do
      used = .false.
      pivot = least_pivot*max(matrix(1, 1), matrix(2, 2), matrix(3, 3))
      do excluded = 1, motions
         best = maxloc([(matrix(k, k), k=1, motions)], mask=.not. used, dim=1)
         held = matrix(best, best) > pivot
         if (.not. held) return
         used(best) = .true.
         do k = 1, motions
            if (.not. used(k)) matrix(:, k) = matrix(:, k) - matrix(:, best)*(matrix(best, k)/matrix(best, best))
         end do
      end do
   end function held

end module support_m
