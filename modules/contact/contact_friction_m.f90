!> Friction between surfaces in potential contact. Every surface edge has one spring and slider, whatever it touches: sliding from
!> one triangle to the next carries its force along.
module contact_friction_m
   use kinds_m, only: wp
   use friction_m, only: slide, velocity_friction, friction_slider, friction_velocity
   use potential_m, only: push_t
   use contact_layer_m, only: contact_layer_t
   implicit none
   private

   public :: no_touches, loose_springs, list_touches, rub

   !> A surface edge (of the target) pushed by a triangle (the contactor)
   type, public :: touch_t
      !> Surface edge, its object and the contactor's object
      integer :: edge = 0, target = 0, contactor = 0
      !> Which edge of the target it is (1..3), and nodes at its start and end
      integer :: side = 0, from = 0, to = 0
      !> Normal force [N/m], its place along the edge (0..1) and its area coordinates in the contactor
      real(wp) :: normal = 0.0_wp, place = 0.0_wp, lambda(3) = 0.0_wp
      !> Normal stiffness per length of edge [Pa/m]
      real(wp) :: stiffness = 0.0_wp
      !> Slip of the target against the contactor along the edge since the last step [m]
      real(wp) :: slip = 0.0_wp
   end type touch_t

   !> What touches now, and what that does to the surface edges
   type, public :: touches_t
      !> Touches of the present step, and their number
      type(touch_t), allocatable :: touch(:)
      integer :: number = 0
      !> Force on each surface edge over the last step: normal (compression positive) and shear, the tangential force on
      !> the rock that owns the edge along the edge's direction (surface edges) [N/m]
      real(wp), allocatable :: normal(:), shear(:)
      !> Direction of the surface edges of the near objects (2, surface edges)
      real(wp), allocatable :: along(:, :)
      !> Sums of the touches on each edge: normal force, its products with slip and stiffness (surface edges)
      real(wp), allocatable :: load(:), load_slip(:), load_stiffness(:)
   end type touches_t

   !> What friction remembers
   type, public :: contact_springs_t
      !> Friction spring of each surface edge: elongation [m], stiffness [N/m per metre of thickness] (surface edges)
      real(wp), allocatable :: elongation(:), stiffness(:)
      !> Displacement of the layer's nodes at the last call of forces (2, layer nodes) [m]
      real(wp), allocatable :: before(:, :)
      !> Energy in all friction springs [J/m]
      real(wp) :: spring_energy = 0.0_wp
   end type contact_springs_t

   !> Room for touches at first
   integer, parameter :: first_touches = 16

contains

   !> Nothing touches yet.
   pure subroutine no_touches(layer, touches)
      type(contact_layer_t), intent(in) :: layer
      type(touches_t), intent(out) :: touches

      associate (edges => size(layer%length))
         allocate (touches%normal(edges), touches%shear(edges), touches%along(2, edges), touches%load(edges), &
                   touches%load_slip(edges), touches%load_stiffness(edges), source=0.0_wp)
      end associate
      allocate (touches%touch(first_touches))
   end subroutine no_touches

   !> Springs that have not been stretched.
   pure subroutine loose_springs(layer, springs)
      type(contact_layer_t), intent(in) :: layer
      type(contact_springs_t), intent(out) :: springs

      associate (edges => size(layer%length))
         allocate (springs%elongation(edges), springs%stiffness(edges), springs%before(2, size(layer%nodes)), source=0.0_wp)
      end associate
   end subroutine loose_springs

   !> Append the pushed edges of a target that are surface edges.
   subroutine list_touches(layer, target, contactor, penalty, push, touches)
      type(contact_layer_t), intent(in) :: layer
      !> Objects
      integer, intent(in) :: target, contactor
      !> Penalty of the pair [Pa]
      real(wp), intent(in) :: penalty
      type(push_t), intent(in) :: push
      type(touches_t), intent(inout) :: touches
      type(touch_t), allocatable :: longer(:)
      integer :: side

      do side = 1, 3
         if (layer%edge(side, target) == 0 .or. push%normal(side) <= 0.0_wp) cycle
         if (touches%number == size(touches%touch)) then
            allocate (longer(2*touches%number))
            longer(:touches%number) = touches%touch
            call move_alloc(longer, touches%touch)
         end if
         touches%number = touches%number + 1
         associate (touch => touches%touch(touches%number))
            touch%edge = layer%edge(side, target)
            touch%target = target
            touch%contactor = contactor
            touch%side = side
            touch%from = layer%node(side, target)
            touch%to = layer%node(mod(side, 3) + 1, target)
            touch%normal = push%normal(side)
            touch%place = push%place(side)
            touch%lambda = push%lambda(:, side)
            touch%stiffness = 3.0_wp*penalty/layer%surface_height(contactor)
         end associate
      end do
   end subroutine list_touches

   !> Friction of all touched edges. The spring belongs to the edge, so that sliding from one contactor to the next
   !> carries its force along; its slip is the mean over the edge's touches weighted with their normal forces.
   subroutine rub(layer, displacement, velocity, friction, touches, springs, force, dissipated)
      type(contact_layer_t), intent(in) :: layer
      !> Displacement [m] and velocity [m/s] of every node (2, nodes)
      real(wp), intent(in), contiguous :: displacement(:, :), velocity(:, :)
      !> Friction coefficient (surface edges)
      real(wp), intent(in) :: friction(:)
      type(touches_t), intent(inout) :: touches
      type(contact_springs_t), intent(inout) :: springs
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout), contiguous :: force(:, :)
      !> Energy spent in this step [J/m]
      real(wp), intent(out) :: dissipated
      real(wp) :: tangential
      integer :: i

      touches%load = 0.0_wp
      touches%load_slip = 0.0_wp
      touches%load_stiffness = 0.0_wp
      do i = 1, touches%number
         associate (touch => touches%touch(i))
            touch%slip = dot_product(slip_of(layer, displacement, touch) - slip_before(layer, springs, touch), &
                                     touches%along(:, touch%edge))
            touches%load(touch%edge) = touches%load(touch%edge) + touch%normal
            touches%load_slip(touch%edge) = touches%load_slip(touch%edge) + touch%normal*touch%slip
            touches%load_stiffness(touch%edge) = touches%load_stiffness(touch%edge) + touch%normal*touch%stiffness
         end associate
      end do

      dissipated = 0.0_wp
      if (layer%options%friction == friction_slider) call work_springs(layer, friction, touches, springs, dissipated)

      do i = 1, touches%number
         associate (touch => touches%touch(i), edge => touches%touch(i)%edge)
            if (layer%options%friction == friction_velocity) then
               tangential = velocity_friction(friction(edge)*touch%normal, &
                                              dot_product(slip_of(layer, velocity, touch), touches%along(:, edge)))
               dissipated = dissipated + tangential*touch%slip
            else
               tangential = springs%stiffness(edge)*springs%elongation(edge)*touch%normal/touches%load(edge)
            end if
            call drag(layer, touch, -tangential*touches%along(:, edge), force)
            call credit(layer, touch, -tangential, touches)
         end associate
      end do
   end subroutine rub

   !> Stretch the friction springs of all surface edges. An edge that has lost its contact lets go of its spring.
   subroutine work_springs(layer, friction, touches, springs, dissipated)
      type(contact_layer_t), intent(in) :: layer
      !> Friction coefficient (surface edges)
      real(wp), intent(in) :: friction(:)
      type(touches_t), intent(in) :: touches
      type(contact_springs_t), intent(inout) :: springs
      !> Energy spent [J/m]
      real(wp), intent(inout) :: dissipated
      real(wp) :: stiffness, tangential, stored, spent
      integer :: edge

      do edge = 1, size(touches%load)
         if (touches%load(edge) > 0.0_wp) then
            ! A contactor of another size comes under the edge: the force goes on, the elongation follows
            stiffness = layer%options%tangential_factor*layer%length(edge)*touches%load_stiffness(edge)/touches%load(edge)
            tangential = springs%stiffness(edge)*springs%elongation(edge)
            springs%spring_energy = springs%spring_energy - 0.5_wp*tangential*springs%elongation(edge)
            springs%elongation(edge) = tangential/stiffness
            springs%spring_energy = springs%spring_energy + 0.5_wp*tangential*springs%elongation(edge)
            springs%stiffness(edge) = stiffness
            call slide(stiffness, friction(edge)*touches%load(edge), touches%load_slip(edge)/touches%load(edge), &
                       springs%elongation(edge), tangential, stored, spent)
         else if (springs%stiffness(edge) > 0.0_wp) then
            call slide(springs%stiffness(edge), 0.0_wp, 0.0_wp, springs%elongation(edge), tangential, stored, spent)
            springs%stiffness(edge) = 0.0_wp
         else
            cycle
         end if
         springs%spring_energy = springs%spring_energy + stored
         dissipated = dissipated + spent
      end do
   end subroutine work_springs

   !> Motion of the target against the contactor at the place of the normal force, from a nodal field.
   pure function slip_of(layer, field, touch) result(slip)
      type(contact_layer_t), intent(in) :: layer
      !> Displacement [m] or velocity [m/s] of every node (2, nodes)
      real(wp), intent(in), contiguous :: field(:, :)
      type(touch_t), intent(in) :: touch
      real(wp) :: slip(2)
      integer :: k

      slip = (1.0_wp - touch%place)*field(:, touch%from) + touch%place*field(:, touch%to)
      do k = 1, 3
         slip = slip - touch%lambda(k)*field(:, layer%node(k, touch%contactor))
      end do
   end function slip_of

   !> The same from the displacements at the last call.
   pure function slip_before(layer, springs, touch) result(slip)
      type(contact_layer_t), intent(in) :: layer
      type(contact_springs_t), intent(in) :: springs
      type(touch_t), intent(in) :: touch
      real(wp) :: slip(2)
      integer :: k

      slip = (1.0_wp - touch%place)*springs%before(:, layer%place(touch%from)) &
             + touch%place*springs%before(:, layer%place(touch%to))
      do k = 1, 3
         slip = slip - touch%lambda(k)*springs%before(:, layer%place(layer%node(k, touch%contactor)))
      end do
   end function slip_before

   !> A force on the target at a touched place, and its reaction on the contactor, to their nodes: both act at one
   !> point, so that momentum and moment of momentum are kept.
   pure subroutine drag(layer, touch, pull, force)
      type(contact_layer_t), intent(in) :: layer
      type(touch_t), intent(in) :: touch
      !> Force on the target (2) [N/m]
      real(wp), intent(in) :: pull(2)
      !> Force on every node (2, nodes) [N/m]
      real(wp), intent(inout), contiguous :: force(:, :)
      integer :: k

      force(:, touch%from) = force(:, touch%from) + (1.0_wp - touch%place)*pull
      force(:, touch%to) = force(:, touch%to) + touch%place*pull
      do k = 1, 3
         associate (node => layer%node(k, touch%contactor))
            force(:, node) = force(:, node) - touch%lambda(k)*pull
         end associate
      end do
   end subroutine drag

   !> Book a touch on the surface edge of the target, and its reaction on the contactor's surface edge that faces it
   !> best.
   pure subroutine credit(layer, touch, shear, touches)
      type(contact_layer_t), intent(in) :: layer
      type(touch_t), intent(in) :: touch
      !> Tangential force on the target along its edge [N/m]
      real(wp), intent(in) :: shear
      type(touches_t), intent(inout) :: touches
      real(wp) :: along(2), facing(2), reaction(2), cosine, best
      integer :: k, edge

      touches%normal(touch%edge) = touches%normal(touch%edge) + touch%normal
      touches%shear(touch%edge) = touches%shear(touch%edge) + shear
      along = touches%along(:, touch%edge)
      best = 0.0_wp
      edge = 0
      do k = 1, 3
         if (layer%edge(k, touch%contactor) == 0) cycle
         cosine = -dot_product(touches%along(:, layer%edge(k, touch%contactor)), along)
         if (cosine <= best) cycle
         best = cosine
         edge = layer%edge(k, touch%contactor)
      end do
      if (edge == 0) return
      facing = touches%along(:, edge)
      reaction = touch%normal*[along(2), -along(1)] - shear*along
      touches%normal(edge) = touches%normal(edge) - dot_product(reaction, [facing(2), -facing(1)])
      touches%shear(edge) = touches%shear(edge) + dot_product(reaction, facing)
   end subroutine credit

end module contact_friction_m
