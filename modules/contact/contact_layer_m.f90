!> The layer of triangles that contact looks at: those with a node on a surface, under the walls and the outer boundary, as deep
!> as a sound contact ever reaches. They are its objects. So are those that bonds hold to such a node: they have nodes of their
!> own, but what comes between the edges of their neighbours meets them. Without them it could lie deep in rock that is no
!> object yet, and feel all of it when a bond there parts.
module contact_layer_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use friction_m, only: friction_slider
   use potential_m, only: twice_area
   use surfaces_m, only: groups_at_triangles, groups_t
   implicit none
   private

   public :: init_layer, beside_surface, same_objects, box_around

   !> Choices of the deck's &contact group
   type, public :: contact_options_t
      !> Skin around each triangle over its mean edge length
      real(wp) :: skin_factor = 0.2_wp
      !> Stiffness of the friction spring over the normal contact stiffness (slider law)
      real(wp) :: tangential_factor = 1.0_wp
      !> friction_slider or friction_velocity of friction_m
      integer :: friction = friction_slider
      !> Look where no two surfaces can meet too, and before anything has moved half the skin (checks: the same forces)
      logical :: everywhere = .false., every_time = .false.
      !> Is contact that begins or ends within a step to be noted (impacts of the state; for the explicit solver)?
      logical :: impacts = .false.
   end type contact_options_t

   type, public :: contact_layer_t
      type(contact_options_t) :: options
      !> Nodes of each object (3, objects); surface edge each of its edges is, 0 inside the rock (3, objects)
      integer, allocatable :: node(:, :), edge(:, :)
      !> Number of each node that is the same for nodes held together (3, objects)
      integer, allocatable :: same(:, :)
      !> Height of each object over each of its edges (3, objects) [m], its penalty [Pa] and half its skin [m] (objects)
      real(wp), allocatable :: height(:, :), penalty(:), half_skin(:)
      !> Height that the potential rises over from the surface, the least where there is a choice (objects) [m]
      real(wp), allocatable :: surface_height(:)
      !> Groups handled elsewhere that each object touches
      type(groups_t) :: handled
      !> Length of each surface edge [m]
      real(wp), allocatable :: length(:)
      !> Nodes of the objects; how far each may move before the next search [m]
      integer, allocatable :: nodes(:)
      real(wp), allocatable :: reach(:)
      !> Place of each node in nodes, 0 for the others (nodes of the mesh)
      integer, allocatable :: place(:)
   end type contact_layer_t

contains

   !> Collect the objects.
   subroutine init_layer(split, penalty, handled, options, number, layer)
      type(split_mesh_t), intent(in) :: split
      !> Penalty of each triangle's rock (triangles) [Pa]
      real(wp), intent(in) :: penalty(:)
      !> Fracture group of each surface edge whose contact another law handles, 0 for the others (surface edges)
      integer, intent(in) :: handled(:)
      type(contact_options_t), intent(in) :: options
      !> The same for nodes held together: triangles that share one never meet (nodes)
      integer, intent(in) :: number(:)
      type(contact_layer_t), intent(out) :: layer
      integer, allocatable :: object_of(:), chosen(:)
      integer :: i, k, edges

      layer%options = options
      edges = size(split%surface, 2)
      allocate (layer%length(edges))
      call choose_objects(split, number, chosen, object_of)
      allocate (layer%node(3, size(chosen)), layer%edge(3, size(chosen)), layer%height(3, size(chosen)))
      layer%node = split%triangle(:, chosen)
      layer%penalty = penalty(chosen)
      layer%same = reshape(number(reshape(layer%node, [size(layer%node)])), shape(layer%node))
      layer%edge = 0
      do i = 1, edges
         associate (object => object_of(split%surface_triangle(i)))
            do k = 1, 3
               if (layer%node(k, object) == split%surface(1, i)) layer%edge(k, object) = i
            end do
         end associate
         layer%length(i) = norm2(split%x(:, split%surface(2, i)) - split%x(:, split%surface(1, i)))
      end do
      layer%handled = groups_at_triangles(split, handled, number, chosen)
      call measure(layer, split)
   end subroutine init_layer

   !> Has each triangle a node on a surface, or one held to such a node? (triangles)
   pure function beside_surface(split, number) result(beside)
      type(split_mesh_t), intent(in) :: split
      !> The same for nodes held together (nodes)
      integer, intent(in) :: number(:)
      logical, allocatable :: beside(:), on_surface(:)
      integer :: i

      allocate (beside(size(split%triangle, 2)))
      allocate (on_surface(size(split%x, 2)), source=.false.)
      do i = 1, size(split%surface, 2)
         on_surface(number(split%surface(:, i))) = .true.
      end do
      do i = 1, size(beside)
         beside(i) = any(on_surface(number(split%triangle(:, i))))
      end do
   end function beside_surface

   !> These triangles, and which of them each triangle is.
   subroutine choose_objects(split, number, chosen, object_of)
      type(split_mesh_t), intent(in) :: split
      !> The same for nodes held together (nodes)
      integer, intent(in) :: number(:)
      !> Triangle of each object (objects); object of each triangle, 0 for none (triangles)
      integer, allocatable, intent(out) :: chosen(:), object_of(:)
      integer :: i

      chosen = pack([(i, i=1, size(split%triangle, 2))], beside_surface(split, number))
      allocate (object_of(size(split%triangle, 2)), source=0)
      object_of(chosen) = [(i, i=1, size(chosen))]
   end subroutine choose_objects

   !> Heights and skins of the objects; their nodes and how far these may move.
   subroutine measure(layer, split)
      type(contact_layer_t), intent(inout) :: layer
      type(split_mesh_t), intent(in) :: split
      real(wp), allocatable :: reach(:)
      real(wp) :: corner(2, 3), side(3)
      integer :: i, k, n

      allocate (reach(size(split%x, 2)), layer%half_skin(size(layer%node, 2)), &
                layer%surface_height(size(layer%node, 2)))
      ! Nodes of no object keep this and are told by it
      reach = huge(1.0_wp)
      do i = 1, size(layer%node, 2)
         corner = split%x(:, layer%node(:, i))
         do k = 1, 3
            side(k) = norm2(corner(:, mod(k, 3) + 1) - corner(:, k))
         end do
         layer%height(:, i) = twice_area(corner)/side
         layer%surface_height(i) = minval(layer%height(:, i), mask=layer%edge(:, i) > 0)
         if (all(layer%edge(:, i) == 0)) layer%surface_height(i) = minval(layer%height(:, i))
         layer%half_skin(i) = 0.5_wp*layer%options%skin_factor*sum(side)/3.0_wp
         reach(layer%node(:, i)) = min(reach(layer%node(:, i)), layer%half_skin(i))
      end do
      n = count(reach < huge(1.0_wp))
      allocate (layer%nodes(n), layer%place(size(reach)))
      layer%nodes = pack([(i, i=1, size(reach))], reach < huge(1.0_wp))
      layer%reach = reach(layer%nodes)
      layer%place = 0
      layer%place(layer%nodes) = [(i, i=1, n)]
   end subroutine measure

   !> The object that each object of another layer has become, 0 for none (objects of the other one).
   pure function same_objects(layer, old, parent) result(object)
      type(contact_layer_t), intent(in) :: layer, old
      !> Node of the old mesh that each node was (nodes)
      integer, intent(in) :: parent(:)
      integer :: object(size(old%node, 2))
      !> First object at each old node, as its first corner, and the next one there (objects)
      integer :: first(size(old%place)), next(size(layer%node, 2))
      integer :: i, k

      first = 0
      do i = 1, size(next)
         associate (corner => parent(layer%node(1, i)))
            next(i) = first(corner)
            first(corner) = i
         end associate
      end do
      object = 0
      do i = 1, size(object)
         k = first(old%node(1, i))
         do while (k > 0)
            if (all(parent(layer%node(:, k)) == old%node(:, i))) object(i) = k
            k = next(k)
         end do
      end do
   end function same_objects

   !> Box around a triangle: xmin, xmax, ymin, ymax.
   pure function box_around(corner) result(box)
      real(wp), intent(in) :: corner(2, 3)
      real(wp) :: box(4)

      box = [min(corner(1, 1), corner(1, 2), corner(1, 3)), max(corner(1, 1), corner(1, 2), corner(1, 3)), &
             min(corner(2, 1), corner(2, 2), corner(2, 3)), max(corner(2, 1), corner(2, 2), corner(2, 3))]
   end function box_around

end module contact_layer_m
