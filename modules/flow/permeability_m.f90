!> Equivalent permeability of a model: that of a uniform rock which conducts as much.
!>
!> With linear pressure on the whole boundary, p = -G.x, the mean flux is -k grad p/mu with a symmetric and positive k:
!> the boundary sees every fracture that crosses it, and k is an upper bound. With two sides closed and a difference of pressure
!> between the others there is one number for each axis; only fractures that lead through count. (Long and others 1982, Water
!> Resour Res 18:645; Lei and others 2017, Hydrogeol J 25:2251.)
module permeability_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use flow_m, only: conductors_t, flow_equations_t, flow_field_t, init_flow, solve_flow, line_length, no_pressure
   use sparse_lu_m, only: linear_ok
   use outline_m, only: outline_t, left_side, right_side, bottom_side, top_side
   implicit none
   private

   public :: find_permeability, top_share, principal_permeability

   !> Share of the block edges that are looked at in the measure of channelling
   real(wp), parameter :: top_part = 0.1_wp

   type, public :: permeability_t
      !> kxx, kyy, kxy with linear pressure on all sides [m2]; their principal values [m2] and the direction of the larger,
      !> anticlockwise from x, above -90 to 90 [degrees]
      real(wp) :: linear(3) = 0.0_wp, principal(2) = 0.0_wp, angle = 0.0_wp
      !> With two sides closed, along x and y [m2]; not a number where the model is no rectangle along the axes
      real(wp) :: closed(2) = 0.0_wp
      !> Are there sides to close? Does anything lead from one to the other, along x and y?
      logical :: has_sides = .false.
      logical :: percolates(2) = .false.
      !> Share of the flow that the top tenth of the block edges carry, along x and y [-]; not a number without flow
      real(wp) :: top(2) = 0.0_wp
      !> Parts of the network, and those that do not reach the boundary
      integer :: parts = 0, parts_left_out = 0
      !> Largest imbalance of a load case, inflow less outflow over inflow [-]
      real(wp) :: imbalance = 0.0_wp
   end type permeability_t

contains

   !> Solve the load cases: two with linear pressure, and one for each pair of sides of a rectangle.
   subroutine find_permeability(conductors, outline, viscosity, block_edge, permeability, status)
      type(conductors_t), intent(in) :: conductors
      type(outline_t), intent(in) :: outline
      !> Viscosity of the fluid [Pa s]
      real(wp), intent(in) :: viscosity
      !> Block edge of each line, 0 for none (lines)
      integer, intent(in) :: block_edge(:)
      type(permeability_t), intent(out) :: permeability
      !> As in sparse_lu_m
      integer, intent(out) :: status
      type(conductors_t) :: weightless
      integer :: axis

      weightless = conductors
      weightless%weight = 0.0_wp
      call linear_pressure(weightless, outline, viscosity, permeability, status)
      permeability%closed = no_pressure()
      permeability%top = no_pressure()
      permeability%has_sides = outline%rectangle
      if (.not. outline%rectangle) return
      do axis = 1, 2
         if (status /= linear_ok) return
         call closed_sides(weightless, outline, viscosity, block_edge, axis, permeability, status)
      end do
   end subroutine find_permeability

   !> The tensor, from linear pressure on all sides.
   subroutine linear_pressure(conductors, outline, viscosity, permeability, status)
      type(conductors_t), intent(in) :: conductors
      type(outline_t), intent(in) :: outline
      real(wp), intent(in) :: viscosity
      type(permeability_t), intent(inout) :: permeability
      integer, intent(out) :: status
      type(flow_equations_t) :: equations
      type(flow_field_t) :: field
      real(wp) :: k(2, 2), centre(2), x(2, size(conductors%x, 2)), none(size(conductors%x, 2))
      integer :: i, j

      none = 0.0_wp
      k = 0.0_wp
      centre = 0.5_wp*(outline%low + outline%high)
      do i = 1, 2
         x(i, :) = conductors%x(i, :) - centre(i)
      end do
      call init_flow(conductors, outline%boundary, equations, status)
      permeability%parts = equations%parts
      permeability%parts_left_out = equations%parts_left_out
      do j = 1, 2
         if (status /= linear_ok) exit
         call solve_flow(conductors, equations, -x(j, :), none, field, status)
         if (status /= linear_ok) exit
         permeability%imbalance = max(permeability%imbalance, abs(field%imbalance))
         ! The mean flux of a divergence-free field is that of its boundary: area q_i = -sum x_i inflow
         do i = 1, 2
            k(i, j) = -viscosity*sum(x(i, :)*field%inflow, mask=outline%boundary)/outline%area
         end do
      end do
      call equations%lu%free()
      permeability%linear = [k(1, 1), k(2, 2), 0.5_wp*(k(1, 2) + k(2, 1))]
      call principal_permeability(permeability%linear, permeability%principal, permeability%angle)
   end subroutine linear_pressure

   !> One axis, the sides along it closed.
   subroutine closed_sides(conductors, outline, viscosity, block_edge, axis, permeability, status)
      type(conductors_t), intent(in) :: conductors
      type(outline_t), intent(in) :: outline
      real(wp), intent(in) :: viscosity
      integer, intent(in) :: block_edge(:), axis
      type(permeability_t), intent(inout) :: permeability
      integer, intent(out) :: status
      integer, parameter :: from(2) = [left_side, bottom_side], to(2) = [right_side, top_side]
      type(flow_equations_t) :: equations
      type(flow_field_t) :: field
      real(wp) :: pressure(size(conductors%x, 2)), none(size(conductors%x, 2)), width(2)

      none = 0.0_wp
      pressure = 0.0_wp
      width = outline%high - outline%low
      associate (start => outline%side(:, from(axis)), finish => outline%side(:, to(axis)))
         where (start) pressure = 1.0_wp
         call init_flow(conductors, start .or. finish, equations, status)
         permeability%closed(axis) = 0.0_wp
         permeability%percolates(axis) = leads_through(equations%part, start, finish)
         if (status == linear_ok .and. permeability%percolates(axis)) then
            call solve_flow(conductors, equations, pressure, none, field, status)
            if (status == linear_ok) then
               permeability%imbalance = max(permeability%imbalance, abs(field%imbalance))
               permeability%closed(axis) = viscosity*sum(field%inflow, mask=start)*width(axis)/width(3 - axis)
               permeability%top(axis) = top_share(conductors, field%along, block_edge)
            end if
         end if
      end associate
      call equations%lu%free()
   end subroutine closed_sides

   !> Is there a part of the network with nodes of both kinds?
   pure logical function leads_through(part, start, finish)
      !> Part of each node, 0 for none (nodes)
      integer, intent(in) :: part(:)
      logical, intent(in) :: start(:), finish(:)
      logical :: begun(0:size(part))
      integer :: i

      begun = .false.
      leads_through = .false.
      do i = 1, size(part)
         if (start(i)) begun(part(i)) = .true.
      end do
      begun(0) = .false.
      do i = 1, size(part)
         if (finish(i)) leads_through = leads_through .or. begun(part(i))
      end do
   end function leads_through

   !> Share of the flow times length that the tenth of the block edges with the largest flows carry (at least one edge) [-].
   real(wp) function top_share(conductors, along, block_edge) result(share)
      type(conductors_t), intent(in) :: conductors
      !> Flow along each line [m2/s], and its block edge, 0 for none (lines)
      real(wp), intent(in) :: along(:)
      integer, intent(in) :: block_edge(:)
      real(wp), allocatable :: carried(:), length(:)
      logical, allocatable :: left(:)
      real(wp) :: total, line
      integer :: i, best, edges, most

      edges = 0
      if (size(block_edge) > 0) edges = max(0, maxval(block_edge))
      allocate (carried(edges), length(edges), source=0.0_wp)
      do i = 1, size(along)
         if (block_edge(i) < 1) cycle
         line = line_length(conductors, i)
         carried(block_edge(i)) = carried(block_edge(i)) + abs(along(i))*line
         length(block_edge(i)) = length(block_edge(i)) + line
      end do
      share = no_pressure()
      total = sum(carried)
      if (.not. total > 0.0_wp) return
      where (length > 0.0_wp) length = carried/length
      left = length >= 0.0_wp
      most = ceiling(top_part*real(edges, wp) - epsilon(1.0_wp))
      share = 0.0_wp
      do i = 1, most
         best = maxloc(length, dim=1, mask=left)
         left(best) = .false.
         share = share + carried(best)/total
      end do
   end function top_share

   !> Principal values, the larger first, and its direction anticlockwise from x [degrees].
   pure subroutine principal_permeability(tensor, principal, angle)
      !> kxx, kyy, kxy
      real(wp), intent(in) :: tensor(3)
      real(wp), intent(out) :: principal(2), angle
      real(wp) :: mean, radius

      mean = 0.5_wp*(tensor(1) + tensor(2))
      radius = hypot(0.5_wp*(tensor(1) - tensor(2)), tensor(3))
      principal = [mean + radius, mean - radius]
      angle = 0.0_wp
      if (radius > 0.0_wp) angle = 0.5_wp*atan2(tensor(3), 0.5_wp*(tensor(1) - tensor(2)))/radians
   end subroutine principal_permeability

end module permeability_m
