!> An integration point of facing walls: how its gap, its weight, its place and the direction of its wall change with the nodes.
!>
!> What walls store there by their overlap o, pressed by a spring, is the energy E = p o/2 times the weight. The pressure along the
!> normal is its derivative by the gap alone. As walls slide, turn and stretch the weight changes too, and with it E: where neither
!> feels that, contact gives or takes energy on a closed way. add_energy_forces adds what then makes all forces the gradient of E.
module wall_point_m
   use constants_m, only: no_length
   use kinds_m, only: wp
   use wall_contact_m, only: wall_meeting_t, facing_part, facing_part_slope
   implicit none
   private

   public :: point_geometry, positions, add_energy_forces

   !> Nodes of an integration point: A', B' of the wall, p, q of the edge it faces, and the ends of the blocks beside that
   !> share the wall at either end (0 where none does); and their displacement components
   integer, parameter, public :: point_nodes = 6, components = 2*point_nodes

   !> Those of the wall and of the edge it faces, of which the wall is pushed one way and the edge the other
   integer, parameter, public :: own_nodes = 4
   real(wp), parameter, public :: side(own_nodes) = [1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp]

   !> Derivatives of an integration point's geometry by the positions of its nodes: gap [-], weight [-], length of
   !> the wall [-], its direction [1/m], shape functions of the first four (component, function) [1/m]
   type, public :: geometry_t
      real(wp) :: gap(components), weight(components), length(components), turn(components)
      real(wp) :: shape(components, 4)
   end type geometry_t

contains

   !> Add the forces that make those of the pressure the gradient of the energy of the overlaps.
   pure subroutine add_energy_forces(met, elastic, pressure, x, u, force)
      type(wall_meeting_t), intent(in) :: met
      !> Does the pressure grow in proportion to the overlap? (points)
      logical, intent(in) :: elastic(:)
      !> Normal stress, compression positive (points) [Pa]
      real(wp), intent(in) :: pressure(:)
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> Nodal forces (2, nodes) [N per m of thickness]
      real(wp), contiguous, intent(inout) :: force(:, :)
      type(geometry_t) :: geometry
      real(wp) :: n(2), more(components)
      integer :: node(point_nodes), k, i

      do k = 1, met%points
         if (.not. elastic(k) .or. pressure(k) <= 0.0_wp) cycle
         node = [met%point_node(:, k), met%beside(:, k)]
         geometry = point_geometry(met, k, positions(node, x, u))
         n = [-met%tangent(2, met%wall(k)), met%tangent(1, met%wall(k))]
         do i = 1, own_nodes
            geometry%gap(2*i - 1:2*i) = geometry%gap(2*i - 1:2*i) - side(i)*met%shape(i, k)*n
         end do
         ! -dE of E = p o W/2, where dp o = p do and do = -dgap, without p W n: that force is there
         more = pressure(k)*(met%weight(k)*geometry%gap + 0.5_wp*met%gap(k)*geometry%weight)
         do i = 1, point_nodes
            if (node(i) > 0) force(:, node(i)) = force(:, node(i)) + more(2*i - 1:2*i)
         end do
      end do
   end subroutine add_energy_forces

   !> Positions of an integration point's nodes (2, nodes) [m].
   pure function positions(node, x, u) result(position)
      !> 0 where there is none
      integer, intent(in) :: node(point_nodes)
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      real(wp) :: position(2, point_nodes)
      integer :: i

      position = 0.0_wp
      do i = 1, point_nodes
         if (node(i) > 0) position(:, i) = x(:, node(i)) + u(:, node(i))
      end do
   end function positions

   !> How place, weight, gap and direction of an integration point change with the positions of its nodes.
   pure function point_geometry(met, k, position) result(geometry)
      type(wall_meeting_t), intent(in) :: met
      !> Integration point
      integer, intent(in) :: k
      !> Of its nodes (2, nodes) [m]
      real(wp), intent(in) :: position(2, point_nodes)
      type(geometry_t) :: geometry
      real(wp) :: n(2), length, start, finish, from(components), to(components), low(components), high(components), &
                  xi(components), eta(components), low_end, high_end, share, held
      integer :: i

      n = [-met%tangent(2, met%wall(k)), met%tangent(1, met%wall(k))]
      length = met%length(met%wall(k))
      geometry%length = 0.0_wp
      geometry%length(:4) = [-met%tangent(:, met%wall(k)), met%tangent(:, met%wall(k))]
      geometry%turn = 0.0_wp
      geometry%turn(:4) = [-n, n]/length
      associate (p => position(:, 3), q => position(:, 4), t => met%tangent(:, met%wall(k)))
         finish = dot_product(p - position(:, 1), t)/length
         start = dot_product(q - position(:, 1), t)/length
         to = place_on_wall(geometry, position, 3, n, t, length)
         from = place_on_wall(geometry, position, 4, n, t, length)
         ! An end of the covered part does not move where the wall itself ends; where blocks share, both move it by half
         low_end = max(0.0_wp, met%part(1, k))
         high_end = min(1.0_wp, met%part(2, k))
         low = 0.0_wp
         high = 0.0_wp
         if (low_end > 0.0_wp) low = from
         if (high_end < 1.0_wp) high = to
         if (low_end > 0.0_wp .and. met%beside(1, k) > 0) &
            low = 0.5_wp*(from + place_on_wall(geometry, position, 5, n, t, length))
         if (high_end < 1.0_wp .and. met%beside(2, k) > 0) &
            high = 0.5_wp*(to + place_on_wall(geometry, position, 6, n, t, length))
         share = (met%shape(2, k) - low_end)/(high_end - low_end)
         xi = low + share*(high - low)
         eta = (to - xi - met%shape(4, k)*(to - from))/(finish - start)
         geometry%gap = -dot_product(q - p, n)*eta
         do i = 1, own_nodes
            geometry%gap(2*i - 1:2*i) = geometry%gap(2*i - 1:2*i) + side(i)*met%shape(i, k)*n
         end do
      end associate
      ! What the other wall has, surfaces at an angle and deep overlaps of new cracks are not held whole
      held = met%weight(k)/(0.5_wp*(high_end - low_end)*length)
      geometry%weight = held*0.5_wp*((high - low)*length + (high_end - low_end)*geometry%length) &
                        + met%weight(k)*facing_change(met, k, geometry, position)
      geometry%shape(:, 1) = -xi
      geometry%shape(:, 2) = xi
      geometry%shape(:, 3) = -eta
      geometry%shape(:, 4) = eta
   end function point_geometry

   !> How the part of its pressure that a point has at the angle of its two edges changes with its nodes, over itself [1/m].
   pure function facing_change(met, k, geometry, position) result(change)
      type(wall_meeting_t), intent(in) :: met
      !> Integration point
      integer, intent(in) :: k
      !> Its turn is known
      type(geometry_t), intent(in) :: geometry
      real(wp), intent(in) :: position(2, point_nodes)
      real(wp) :: change(components), along(2), across(2), length, cosine, part

      change = 0.0_wp
      along = position(:, 3) - position(:, 4)
      length = max(norm2(along), no_length)
      along = along/length
      associate (t => met%tangent(:, met%wall(k)))
         cosine = dot_product(along, t)
         part = facing_part(cosine)
         if (part <= 0.0_wp) return
         ! cos = t.m with dt = n dtheta, and m the direction of q -> p
         across = (t - cosine*along)/length
         change = dot_product(along, [-t(2), t(1)])*geometry%turn
      end associate
      change(5:6) = change(5:6) + across
      change(7:8) = change(7:8) - across
      change = facing_part_slope(cosine)/part*change
   end function facing_change

   !> How the place of one of the nodes, projected on the wall from 0 at A' to 1 at B', moves with the nodes [1/m].
   pure function place_on_wall(geometry, position, node, n, t, length) result(place)
      !> Its length and turn are known
      type(geometry_t), intent(in) :: geometry
      real(wp), intent(in) :: position(2, point_nodes)
      !> Which of the nodes
      integer, intent(in) :: node
      !> Normal, tangent and length of the wall
      real(wp), intent(in) :: n(2), t(2), length
      real(wp) :: place(components), away(2)

      away = position(:, node) - position(:, 1)
      place = dot_product(away, n)*geometry%turn - dot_product(away, t)/length*geometry%length
      place(:2) = place(:2) - t
      place(2*node - 1:2*node) = place(2*node - 1:2*node) + t
      place = place/length
   end function place_on_wall

end module wall_point_m
