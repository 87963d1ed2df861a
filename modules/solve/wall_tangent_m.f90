!> Tangent stiffness of fracture walls in contact, for the implicit solver.
!>
!> At an integration point the lower wall pushes the upper one with the pressure p along n and drags it with the shear
!> stress s = (tau/sn) p against t. The pressure follows the gap there (eq 5a, and the dilation when it pushes the walls),
!> while tau follows the slip of the joint's own four nodes (eqs 27-30) and its mean normal stress sn (eqs 13, 24-26): the
!> tangent joins the joint's nodes with those under its points and is not symmetric. Positions and directions of the
!> points are held: what their change adds is smaller by stress over stiffness of the rock.
module wall_tangent_m
   use kinds_m, only: wp
   use constants_m, only: megapascal, millimetre, megapascal_per_millimetre
   use wall_contact_m, only: wall_contact_t
   use joint_point_m, only: joint_point_t, joint_tangent_t
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use joint_law_m, only: joint_law_t, joint_tangent, joint_normal_stiffness
   use joints_m, only: joints_t
   implicit none
   private

   public :: wall_tangent, points_of_walls

   !> Stiffness of one wall edge and what it faces
   type, public :: wall_element_t
      !> Nodes it joins: number, list (room)
      integer :: nodes = 0
      integer, allocatable :: node(:)
      !> (2 room, 2 room) [N/m per m of thickness], components x, y of node after node
      real(wp), allocatable :: stiffness(:, :)
   end type wall_element_t

   !> An open joint keeps this share of its first stiffness in the tangent (not in the forces), a closed one without
   !> stress the other for shear: blocks that nothing holds yet must not make the system singular
   real(wp), parameter :: open_share = 1.0e-4_wp, unstressed_share = 0.1_wp
   !> Own nodes of a joint element
   integer, parameter :: own_nodes = 4
   real(wp), parameter :: side(4) = [1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp]

contains

   !> First integration point of every wall; those of wall w are first(w) to first(w + 1) - 1 (walls + 1).
   pure subroutine points_of_walls(walls, first)
      type(wall_contact_t), intent(in) :: walls
      integer, intent(out) :: first(:)
      integer :: k, w

      k = 1
      do w = 1, size(walls%joint)
         first(w) = k
         do while (k <= walls%points)
            if (walls%wall(k) /= w) exit
            k = k + 1
         end do
      end do
      first(size(walls%joint) + 1) = k
   end subroutine points_of_walls

   !> Stiffness of one wall at the state its joint was last updated to.
   pure subroutine wall_tangent(joints, walls, w, first, last, x, u, point, element)
      type(joints_t), intent(in) :: joints
      type(wall_contact_t), intent(in) :: walls
      !> Wall, its first and last integration point
      integer, intent(in) :: w, first, last
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> State of the wall's joint
      type(joint_point_t), intent(in) :: point
      type(wall_element_t), intent(inout) :: element
      type(joint_tangent_t) :: tangent
      real(wp), allocatable :: slip(:), gap(:), drag(:), pressure(:, :), stress(:), shear(:)
      real(wp) :: n(2), t(2), friction, stiffness
      integer :: place(own_nodes), own(own_nodes), k, i, j

      j = walls%joint(w)
      call collect_nodes(joints%node(:, j), walls%point_node(:, first:last), element, own)
      associate (m => 2*element%nodes)
         element%stiffness(:m, :m) = 0.0_wp
         if (last < first) return
         allocate (slip(m), gap(m), drag(m), pressure(m, last - first + 1), stress(m), shear(m))
         t = walls%tangent(:, w)
         n = [-t(2), t(1)]
         tangent = joint_tangent(joints%law(j), point)
         slip = slip_gradient(joint_kinematics(x(:, joints%node(:, j)), u(:, joints%node(:, j))), own, m)
         stress = 0.0_wp
         do k = first, last
            place = places(walls%point_node(:, k), element)
            gap = spread_to(place, walls%shape(:, k), n, m)
            associate (dp => pressure(:, k - first + 1))
               dp = -gap
               if (joints%coupled(j)) dp = dp + tangent%dilation_u*slip
               dp = normal_stiffness_at(joints, walls, j, k, point)*dp
               stress = stress + walls%weight(k)/walls%length(w)*dp
            end associate
         end do
         friction = 0.0_wp
         if (point%sn > 0.0_wp) friction = point%tau/point%sn
         do k = first, last
            place = places(walls%point_node(:, k), element)
            drag = spread_to(place, walls%shape(:, k), t, m)
            stiffness = shear_floor(joints, j, tangent, point)
            shear = stiffness*drag
            if (point%sn > 0.0_wp .and. joints%pressure(k) > 0.0_wp) then
               shear = shear + friction*pressure(:, k - first + 1) + joints%pressure(k)/(point%sn*megapascal)* &
                       (tangent%tau_u*megapascal_per_millimetre*slip + (tangent%tau_sn - friction)*stress)
            end if
            gap = spread_to(place, walls%shape(:, k), n, m)
            do i = 1, m
               element%stiffness(:m, i) = element%stiffness(:m, i) + &
                                          walls%weight(k)*(drag*shear(i) - gap*pressure(i, k - first + 1))
            end do
         end do
      end associate
   end subroutine wall_tangent

   !> Distinct nodes of a joint and under its integration points, and where its own stand among them.
   pure subroutine collect_nodes(own_node, point_node, element, own)
      integer, intent(in) :: own_node(:), point_node(:, :)
      type(wall_element_t), intent(inout) :: element
      integer, intent(out) :: own(:)
      integer :: room, k, i

      room = own_nodes + size(point_node)
      if (allocated(element%node)) then
         if (size(element%node) < room) deallocate (element%node, element%stiffness)
      end if
      if (.not. allocated(element%node)) allocate (element%node(room), element%stiffness(2*room, 2*room))
      element%nodes = 0
      do i = 1, own_nodes
         call add_node(own_node(i), element, own(i))
      end do
      do k = 1, size(point_node, 2)
         do i = 1, size(point_node, 1)
            call add_node(point_node(i, k), element, room)
         end do
      end do
   end subroutine collect_nodes

   !> Add a node to the element's list unless it is there.
   pure subroutine add_node(node, element, place)
      integer, intent(in) :: node
      type(wall_element_t), intent(inout) :: element
      !> Where it stands
      integer, intent(out) :: place

      place = findloc(element%node(:element%nodes), node, dim=1)
      if (place > 0) return
      element%nodes = element%nodes + 1
      element%node(element%nodes) = node
      place = element%nodes
   end subroutine add_node

   !> Where nodes stand in the element's list.
   pure function places(node, element) result(place)
      integer, intent(in) :: node(own_nodes)
      type(wall_element_t), intent(in) :: element
      integer :: place(own_nodes), i

      do i = 1, own_nodes
         place(i) = findloc(element%node(:element%nodes), node(i), dim=1)
      end do
   end function places

   !> Derivative of the upper wall's displacement against the lower one's along a direction, by the nodal displacements.
   pure function spread_to(place, shape, direction, m) result(gradient)
      integer, intent(in) :: place(own_nodes)
      real(wp), intent(in) :: shape(own_nodes), direction(2)
      !> Components
      integer, intent(in) :: m
      real(wp) :: gradient(m)
      integer :: i

      gradient = 0.0_wp
      do i = 1, own_nodes
         associate (at => 2*place(i))
            gradient(at - 1:at) = gradient(at - 1:at) + side(i)*shape(i)*direction
         end associate
      end do
   end function spread_to

   !> Derivative of the shear displacement of eqs 27-30 by the nodal displacements, with the turning of the median line.
   pure function slip_gradient(frame, own, m) result(gradient)
      type(joint_frame_t), intent(in) :: frame
      !> Places of A, B, A', B'
      integer, intent(in) :: own(own_nodes)
      integer, intent(in) :: m
      real(wp) :: gradient(m)
      integer :: i
      real(wp), parameter :: wall(own_nodes) = [-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp]
      real(wp), parameter :: end(own_nodes) = [-0.5_wp, 0.5_wp, -0.5_wp, 0.5_wp]

      gradient = 0.0_wp
      do i = 1, own_nodes
         associate (at => 2*own(i))
            gradient(at - 1:at) = gradient(at - 1:at) + wall(i)*frame%i + end(i)*frame%opening/frame%length*frame%j
         end associate
      end do
   end function slip_gradient

   !> d pressure/d overlap at an integration point [Pa/m].
   pure real(wp) function normal_stiffness_at(joints, walls, j, k, point) result(stiffness)
      type(joints_t), intent(in) :: joints
      type(wall_contact_t), intent(in) :: walls
      !> Joint and integration point
      integer, intent(in) :: j, k
      type(joint_point_t), intent(in) :: point
      real(wp) :: overlap

      overlap = -walls%gap(k)/millimetre
      if (joints%coupled(j)) overlap = overlap + point%dilation
      stiffness = joints%penalty(j)
      if (stiffness <= 0.0_wp) stiffness = joint_normal_stiffness(joints%law(j), joints%pressure(k)/megapascal)
      if (overlap < 0.0_wp) stiffness = open_share*stiffness
      stiffness = stiffness*megapascal_per_millimetre
   end function normal_stiffness_at

   !> What the shear stiffness lacks for the system to be regular [Pa/m].
   pure real(wp) function shear_floor(joints, j, tangent, point) result(stiffness)
      type(joints_t), intent(in) :: joints
      integer, intent(in) :: j
      type(joint_tangent_t), intent(in) :: tangent
      type(joint_point_t), intent(in) :: point

      stiffness = 0.0_wp
      if (tangent%tau_u < 0.0_wp) return
      stiffness = joint_normal_stiffness(joints%law(j), 0.0_wp)*merge(open_share, unstressed_share, &
                                                                        point%sn > 0.0_wp .or. joints%contact_stress(j) < 0.0_wp)
      stiffness = max(0.0_wp, stiffness - tangent%tau_u)*megapascal_per_millimetre
   end function shear_floor

end module wall_tangent_m
