!> Tangent stiffness of fracture walls in contact, for the implicit solver.
!>
!> At an integration point the lower wall pushes the upper one with the pressure p along n and drags it with the shear
!> stress s = (tau/sn) p against t. The pressure follows the gap there (eq 5a, and the dilation when it pushes the walls),
!> while tau follows the slip of the joint's own four nodes (eqs 27-30) and its mean normal stress sn (eqs 13, 24-26): the
!> tangent joins the joint's nodes with those under its points and is not symmetric. Place, weight and direction of the
!> points move with the walls; at corners of blocks, where short overlaps carry much, Newton's method needs that part too.
module wall_tangent_m
   use kinds_m, only: wp
   use wall_contact_m, only: wall_meeting_t
   use wall_point_m, only: geometry_t, point_geometry, positions, point_nodes, components, own_nodes, side
   use joint_point_m, only: joint_point_t
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use joints_m, only: joints_t, tractions_t
   use joint_border_m, only: joint_answer_t, answer_of, are_apart
   implicit none
   private

   public :: joint_wall_tangent

   !> Stiffness of one wall edge and what it faces
   type, public :: wall_element_t
      !> Nodes it joins: number, list (room)
      integer :: nodes = 0
      integer, allocatable :: node(:)
      !> [N/m per m of thickness] (room for 2 nodes, the same), components x, y of node after node
      real(wp), allocatable :: stiffness(:, :)
   end type wall_element_t

   !> A joint and the first and last integration point of its walls
   type :: span_t
      integer :: joint, first, last
   end type span_t

   !> An open joint keeps this share of its first stiffness in the tangent (not in the forces), a closed one without
   !> stress the other for shear: blocks that nothing holds yet must not make the system singular
   real(wp), parameter, public :: open_share = 1.0e-4_wp
   !> The same for a crack, whose first stiffness is many times that of the rock around it
   real(wp), parameter :: open_crack_share = 1.0e-9_wp
   real(wp), parameter :: unstressed_share = 0.1_wp

contains

   !> Stiffness of both walls of a joint at the state the joint was last updated to.
   pure subroutine joint_wall_tangent(joints, met, tractions, j, first, last, x, u, point, element)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      !> Joint, the first and last integration point of its walls
      integer, intent(in) :: j, first, last
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> State of the joint
      type(joint_point_t), intent(in) :: point
      type(wall_element_t), intent(inout) :: element
      integer :: node(point_nodes, first:last), own(own_nodes), k

      do k = first, last
         node(:, k) = [met%point_node(:, k), met%beside(:, k)]
      end do
      call collect_nodes(joints%node(:, j), node, element, own)
      call fill_element(joints, met, tractions, span_t(j, first, last), x, u, point, node, own, element)
   end subroutine joint_wall_tangent

   !> The stiffness of an element whose nodes are known.
   pure subroutine fill_element(joints, met, tractions, span, x, u, point, node, own, element)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      type(span_t), intent(in) :: span
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(joint_point_t), intent(in) :: point
      !> Nodes of the points, places of the joint's own in the element
      integer, intent(in) :: node(point_nodes, span%first:span%last), own(own_nodes)
      type(wall_element_t), intent(inout) :: element
      type(joint_answer_t) :: answer
      type(geometry_t) :: geometry(span%first:span%last)
      real(wp), dimension(2*element%nodes) :: slip, dilation, stress
      real(wp), dimension(2*element%nodes, span%first:span%last) :: pressure, weight
      real(wp) :: row(2*element%nodes, 2*element%nodes), covered
      integer :: place(point_nodes, span%first:span%last), first, last, j, k, m

      j = span%joint
      first = span%first
      last = span%last
      m = 2*element%nodes
      element%stiffness(:m, :m) = 0.0_wp
      if (last < first) return
      answer = answer_of(joints, tractions, j, point, share_when_open(joints, j), unstressed_share)
      slip = slip_gradient(joint_kinematics(x(:, joints%node(:, j)), u(:, joints%node(:, j))), own, m)
      covered = sum(met%weight(first:last))
      do k = first, last
         place(:, k) = places(node(:, k), element)
         geometry(k) = point_geometry(met, k, positions(node(:, k), x, u))
         pressure(:, k) = -onto_element(geometry(k)%gap, place(:, k), m)
         weight(:, k) = onto_element(geometry(k)%weight, place(:, k), m)/covered
      end do
      ! Of what is covered each point has a part: what one gains the others lose
      stress = sum(weight, dim=2)
      do k = first, last
         weight(:, k) = weight(:, k) - met%weight(k)/covered*stress
      end do
      dilation = 0.0_wp
      if (joints%coupled(j)) then
         associate (ride => tractions%ride(j))
            dilation = ride%by_slip*slip
            do k = first, last
               dilation = dilation + tractions%by_overlap(k)*pressure(:, k) + tractions%by_weight(k)*weight(:, k)
            end do
         end associate
      end if
      stress = 0.0_wp
      do k = first, last
         pressure(:, k) = normal_stiffness_at(joints, met, tractions, answer, j, k)*(pressure(:, k) + dilation)
         stress = stress + met%weight(k)/covered*pressure(:, k) + tractions%pressure(k)*weight(:, k)
      end do
      row = 0.0_wp
      do k = first, last
         call add_point(met, tractions, k, answer, shear_floor(joints, met, tractions, answer, j, k), geometry(k), place(:, k), &
                        slip, pressure(:, k), stress, row)
      end do
      element%stiffness(:m, :m) = transpose(row)
   end subroutine fill_element

   !> Add an integration point's part, minus the derivative of the nodal forces of its tractions.
   pure subroutine add_point(met, tractions, k, answer, floor, geometry, place, slip, pressure, stress, row)
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      !> Integration point
      integer, intent(in) :: k
      !> That of its joint, and what the shear stiffness lacks (shear_floor)
      type(joint_answer_t), intent(in) :: answer
      real(wp), intent(in) :: floor
      type(geometry_t), intent(in) :: geometry
      !> Places of the point's nodes in the element
      integer, intent(in) :: place(point_nodes)
      !> Derivatives of slip [-], pressure and mean normal stress [Pa/m] by the element's displacements
      real(wp), intent(in) :: slip(:), pressure(:), stress(:)
      !> Rows of the element's stiffness (components, row)
      real(wp), intent(inout) :: row(:, :)
      real(wp) :: shear(size(slip)), along_n(size(slip)), along_t(size(slip)), shape(size(slip), own_nodes)
      real(wp) :: n(2), t(2), p, s
      integer :: i, c, at

      t = met%tangent(:, met%wall(k))
      n = [-t(2), t(1)]
      p = tractions%pressure(k)
      s = 0.0_wp
      shear = floor*spread_to(place, met%shape(:, k), t, size(slip))
      if (answer%stress > 0.0_wp .and. p > 0.0_wp) then
         s = answer%friction*p
         shear = shear + answer%friction*pressure &
                 + p/answer%stress*(answer%tau_u*slip + (answer%tau_sn - answer%friction)*stress)
      end if
      ! Tractions times weight, turned with the wall: p n - s t, with dn = -t dtheta and dt = n dtheta
      along_n = met%weight(k)*(pressure - s*onto_element(geometry%turn, place, size(slip))) &
                + p*onto_element(geometry%weight, place, size(slip))
      along_t = met%weight(k)*(-shear - p*onto_element(geometry%turn, place, size(slip))) &
                - s*onto_element(geometry%weight, place, size(slip))
      do i = 1, own_nodes
         shape(:, i) = onto_element(geometry%shape(:, i), place, size(slip))
         do c = 1, 2
            at = 2*(place(i) - 1) + c
            row(:, at) = row(:, at) - side(i)*(met%shape(i, k)*(along_n*n(c) + along_t*t(c)) &
                                               + shape(:, i)*met%weight(k)*(p*n(c) - s*t(c)))
         end do
      end do
   end subroutine add_point

   !> Distinct nodes of a joint and under its integration points, and where its own stand among them.
   pure subroutine collect_nodes(own_node, point_node, element, own)
      integer, intent(in) :: own_node(:), point_node(:, :)
      type(wall_element_t), intent(inout) :: element
      integer, intent(out) :: own(:)
      integer :: room, k, i

      room = own_nodes + size(point_node)
      if (allocated(element%node)) then
         if (size(element%node) < room) deallocate (element%node)
      end if
      if (.not. allocated(element%node)) allocate (element%node(room))
      element%nodes = 0
      do i = 1, own_nodes
         call add_node(own_node(i), element, own(i))
      end do
      do k = 1, size(point_node, 2)
         do i = 1, size(point_node, 1)
            if (point_node(i, k) > 0) call add_node(point_node(i, k), element, room)
         end do
      end do
      ! Most nodes are those of several points: there is far less to store than there is room for
      if (allocated(element%stiffness)) then
         if (size(element%stiffness, 1) < 2*element%nodes) deallocate (element%stiffness)
      end if
      if (.not. allocated(element%stiffness)) allocate (element%stiffness(2*element%nodes, 2*element%nodes))
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

   !> Where an integration point's nodes stand in the element's list, 0 where there is none.
   pure function places(node, element) result(place)
      integer, intent(in) :: node(point_nodes)
      type(wall_element_t), intent(in) :: element
      integer :: place(point_nodes), i

      do i = 1, point_nodes
         place(i) = findloc(element%node(:element%nodes), node(i), dim=1)
      end do
   end function places

   !> A derivative by a point's displacement components as one by the element's.
   pure function onto_element(of_point, place, m) result(gradient)
      real(wp), intent(in) :: of_point(components)
      integer, intent(in) :: place(point_nodes)
      !> Components of the element
      integer, intent(in) :: m
      real(wp) :: gradient(m)
      integer :: i

      gradient = 0.0_wp
      do i = 1, point_nodes
         if (place(i) == 0) cycle
         associate (at => 2*place(i))
            gradient(at - 1:at) = gradient(at - 1:at) + of_point(2*i - 1:2*i)
         end associate
      end do
   end function onto_element

   !> Derivative of the upper wall's displacement against the lower one's along a direction, by the nodal displacements.
   pure function spread_to(place, shape, direction, m) result(gradient)
      integer, intent(in) :: place(point_nodes)
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
   pure real(wp) function normal_stiffness_at(joints, met, tractions, answer, j, k) result(stiffness)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      type(joint_answer_t), intent(in) :: answer
      !> Joint and integration point
      integer, intent(in) :: j, k
      logical :: apart

      apart = are_apart(joints, met, tractions, j, k)
      if (tractions%pressure(k) > 0.0_wp) then
         stiffness = tractions%by_closure(k)
         if (apart) stiffness = share_when_open(joints, j)*stiffness
      else
         stiffness = merge(answer%apart, answer%first_touch, apart)
      end if
   end function normal_stiffness_at

   !> What the shear stiffness at an integration point lacks for the system to be regular [Pa/m].
   pure real(wp) function shear_floor(joints, met, tractions, answer, j, k) result(stiffness)
      type(joints_t), intent(in) :: joints
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(in) :: tractions
      type(joint_answer_t), intent(in) :: answer
      !> Joint and integration point
      integer, intent(in) :: j, k

      stiffness = answer%shear_apart
      if (answer%unstressed .and. .not. are_apart(joints, met, tractions, j, k)) stiffness = answer%shear_unstressed
   end function shear_floor

   !> Part of its first stiffness that a joint keeps in the tangent when it is open.
   pure real(wp) function share_when_open(joints, j) result(share)
      type(joints_t), intent(in) :: joints
      integer, intent(in) :: j

      ! Cracks belong to no &joint group
      share = merge(open_share, open_crack_share, joints%group(j) > 0)
   end function share_when_open

end module wall_tangent_m
