!> Block edges: the pieces of fracture between intersections, tips and the boundary, whose length is the effective
!> length Ln of all joint elements on them. Binary-tree scan of Lei, Latham & Xiang (2016), section 2.3.2.
module topology_m
   use chains_m, only: find_neighbours, no_neighbour
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   implicit none
   private

   public :: scan_topology, no_neighbour

   !> Which block edge every joint element is on
   type, public :: topology_t
      !> Block edge of each joint element (joints)
      integer, allocatable :: edge_of_joint(:)
      !> Length of each block edge, the Ln of eqs 8, 9, 14 and 15 (block edges) [m]
      real(wp), allocatable :: edge_length(:)
      !> Number of joint elements on each block edge, and their group (block edges)
      integer, allocatable :: edge_joints(:), edge_group(:)
      !> Neighbours of each joint element at A and at B, no_neighbour (-1) where there is none (2, joints)
      integer, allocatable :: neighbour(:, :)
   end type topology_t

contains

   !> Find the block edges, numbered in the order of their first joint elements.
   !>
   !> Each joint element is a tree node and its neighbours are its two children; visited and missing ones are dead. What
   !> is alive in the tree of one joint element is a block edge. Joint elements are neighbours when they, and no others,
   !> meet at a node of the unsplit mesh inside the rock and are of one group (see find_neighbours).
   pure subroutine scan_topology(split, topology)
      type(split_mesh_t), intent(in) :: split
      type(topology_t), intent(out) :: topology
      integer, allocatable :: segment(:, :)
      integer :: j, joints, edges

      joints = size(split%joint, 2)
      allocate (segment(2, joints), topology%neighbour(2, joints), topology%edge_of_joint(joints))
      do j = 1, joints
         segment(:, j) = split%origin(split%joint(1:2, j))
      end do
      call find_neighbours(segment, split%joint_group, boundary_nodes(split), topology%neighbour)

      topology%edge_of_joint = 0
      edges = 0
      do j = 1, joints
         if (topology%edge_of_joint(j) > 0) cycle
         edges = edges + 1
         call scan_tree(topology%neighbour, j, edges, topology%edge_of_joint)
      end do
      call measure(split, edges, topology)
   end subroutine scan_topology

   !> Nodes of the unsplit mesh that are on its outer boundary.
   pure function boundary_nodes(split) result(on_boundary)
      type(split_mesh_t), intent(in) :: split
      logical, allocatable :: on_boundary(:)
      integer :: i

      allocate (on_boundary(maxval(split%origin)))
      on_boundary = .false.
      do i = 1, size(split%surface, 2)
         if (split%surface_joint(i) == 0) on_boundary(split%origin(split%surface(:, i))) = .true.
      end do
   end function boundary_nodes

   !> Give all joint elements in the tree of one of them the number of its block edge.
   pure subroutine scan_tree(neighbour, trunk, edge, edge_of_joint)
      !> Neighbours of each joint element (2, joints)
      integer, intent(in) :: neighbour(:, :)
      !> Joint element the tree begins at, number of its block edge
      integer, intent(in) :: trunk, edge
      !> Block edge of each joint element, 0 while it is not visited (joints)
      integer, intent(inout) :: edge_of_joint(:)
      ! Taking one joint element off and putting its children on leaves one more at most: only one child of any but the
      ! trunk is alive, so three places would do; a child is marked when it is put on, so none stands there twice.
      integer :: stack(3), height, joint, k, child

      stack(1) = trunk
      height = 1
      edge_of_joint(trunk) = edge
      do while (height > 0)
         joint = stack(height)
         height = height - 1
         do k = 1, 2
            child = neighbour(k, joint)
            if (child == no_neighbour) cycle
            if (edge_of_joint(child) > 0) cycle
            edge_of_joint(child) = edge
            height = height + 1
            stack(height) = child
         end do
      end do
   end subroutine scan_tree

   !> Length, number of joint elements and group of each block edge.
   pure subroutine measure(split, edges, topology)
      type(split_mesh_t), intent(in) :: split
      integer, intent(in) :: edges
      type(topology_t), intent(inout) :: topology
      integer :: j, edge

      allocate (topology%edge_length(edges), topology%edge_joints(edges), topology%edge_group(edges))
      topology%edge_length = 0.0_wp
      topology%edge_joints = 0
      do j = 1, size(split%joint, 2)
         edge = topology%edge_of_joint(j)
         topology%edge_length(edge) = topology%edge_length(edge) &
                                      + norm2(split%x(:, split%joint(2, j)) - split%x(:, split%joint(1, j)))
         topology%edge_joints(edge) = topology%edge_joints(edge) + 1
         topology%edge_group(edge) = split%joint_group(j)
      end do
   end subroutine measure

end module topology_m
