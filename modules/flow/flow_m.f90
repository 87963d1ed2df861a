!> Flow of a fluid, steady or in a step of implicit Euler, along lines (fractures, cubic law) and through triangles (rock,
!> Darcy's law) that share their nodes: one pressure a node, linear in between. Plain arrays; knows nothing of decks and mesh files.
!>
!> Nodes that nothing conducting touches have no unknown, and parts of the network that no prescribed pressure reaches are
!> left out: their pressure is not a number. Flows through nodes are those of the equations themselves (consistent), so what
!> flows in flows out.
module flow_m
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use kinds_m, only: wp
   use sparse_lu_m, only: sparse_lu_t, linear_ok
   use union_find_m, only: each_alone, join, representatives
   implicit none
   private

   public :: find_network, init_flow, solve_flow, describe_flow, cubic_law, line_length, triangle_area, triangle_gradients
   public :: no_pressure

   !> What conducts
   type, public :: conductors_t
      !> Nodes (2, nodes) [m]
      real(wp), allocatable :: x(:, :)
      !> Lines (2, lines), and what flows along each for a unit gradient of pressure, e^3/(12 mu) [m3/(Pa s) per metre]
      integer, allocatable :: line(:, :)
      real(wp), allocatable :: line_mobility(:)
      !> Triangles (3, triangles), and permeability over viscosity [m2/(Pa s)]
      integer, allocatable :: triangle(:, :)
      real(wp), allocatable :: mobility(:)
      !> Storage: fluid that a node takes up for each pascal [m2/Pa] (nodes); not allocated: flow is steady
      real(wp), allocatable :: storage(:)
      !> Weight of the fluid, density times gravity [Pa/m]
      real(wp) :: weight(2) = 0.0_wp
   end type conductors_t

   !> The equations for one set of nodes of known pressure, factored
   type, public :: flow_equations_t
      type(sparse_lu_t) :: lu
      !> Pressure known? (nodes)
      logical, allocatable :: fixed(:)
      !> Is a known pressure felt there? (nodes)
      logical, allocatable :: reached(:)
      !> Part of the network: its lowest node, 0 for nodes that nothing conducting touches (nodes)
      integer, allocatable :: part(:)
      !> Parts of the network, and those that no known pressure reaches
      integer :: parts = 0, parts_left_out = 0
      !> Storage over the time step [m2/(Pa s)] (nodes); 0 in steady flow
      real(wp), allocatable :: storing(:)
      !> Unknown of each node, 0 for none; root of the diagonal that scales it (unknowns)
      integer, allocatable :: number(:)
      real(wp), allocatable :: scale(:)
   end type flow_equations_t

   !> A solution
   type, public :: flow_field_t
      !> Pressure [Pa], not a number where there is none (nodes)
      real(wp), allocatable :: pressure(:)
      !> Flow along each line from its first to its second node [m2/s] (lines); Darcy's flux in triangles [m/s] (2, triangles)
      real(wp), allocatable :: along(:), flux(:, :)
      !> What flows in through each node: at known pressures what the equations need, elsewhere what is prescribed [m2/s] (nodes)
      real(wp), allocatable :: inflow(:)
      !> What is stored [m2/s]; what is left of the inflows after it, over the sum of the positive ones [-]
      real(wp) :: stored = 0.0_wp, imbalance = 0.0_wp
   end type flow_field_t

   !> Plates without roughness: flow is e^3/(12 mu) times the gradient
   real(wp), parameter :: cubic_divisor = 12.0_wp
   !> Refinements of a solution at most; they stop when the equations are met to so many roundings of the largest flow
   integer, parameter :: most_refinements = 4
   real(wp), parameter :: enough = 4.0_wp*epsilon(1.0_wp)

contains

   !> What flows between smooth parallel walls for a unit pressure gradient, e^3/(12 mu) [m3/(Pa s)].
   elemental real(wp) function cubic_law(aperture, viscosity)
      !> Hydraulic aperture [m], viscosity [Pa s]
      real(wp), intent(in) :: aperture, viscosity

      cubic_law = max(aperture, 0.0_wp)**3/(cubic_divisor*viscosity)
   end function cubic_law

   !> The pressure of nodes that have none: not a number.
   real(wp) function no_pressure()

      no_pressure = ieee_value(0.0_wp, ieee_quiet_nan)
   end function no_pressure

   !> Find the parts of the network and where a known pressure is felt.
   subroutine find_network(conductors, fixed, equations, step)
      type(conductors_t), intent(in) :: conductors
      !> Is the pressure known? (nodes)
      logical, intent(in) :: fixed(:)
      type(flow_equations_t), intent(inout) :: equations
      !> Time step of implicit Euler [s]; steady when not given
      real(wp), intent(in), optional :: step
      integer :: i

      equations%fixed = fixed
      equations%storing = [(0.0_wp, i=1, size(fixed))]
      if (present(step)) equations%storing = conductors%storage/step
      call find_parts(conductors, equations)
   end subroutine find_network

   !> Find the parts of the network, number the unknowns and factor the equations.
   subroutine init_flow(conductors, fixed, equations, status, step)
      type(conductors_t), intent(in) :: conductors
      !> Is the pressure known? (nodes)
      logical, intent(in) :: fixed(:)
      type(flow_equations_t), intent(inout) :: equations
      !> As in sparse_lu_m
      integer, intent(out) :: status
      !> Time step of implicit Euler [s]; steady when not given
      real(wp), intent(in), optional :: step
      integer, allocatable :: row(:), column(:)
      real(wp), allocatable :: value(:)
      integer :: i, unknowns

      call find_network(conductors, fixed, equations, step)
      equations%number = [(0, i=1, size(fixed))]
      unknowns = 0
      do i = 1, size(fixed)
         if (fixed(i) .or. .not. equations%reached(i)) cycle
         unknowns = unknowns + 1
         equations%number(i) = unknowns
      end do
      status = linear_ok
      if (allocated(equations%scale)) deallocate (equations%scale)
      allocate (equations%scale(unknowns))
      if (unknowns == 0) return
      call assemble(conductors, equations, row, column, value)
      ! Mobilities differ by many powers of ten: a diagonal of ones keeps small ones from being taken for nothing
      equations%scale = 0.0_wp
      do i = 1, size(row)
         if (row(i) == column(i)) equations%scale(row(i)) = equations%scale(row(i)) + value(i)
      end do
      equations%scale = sqrt(equations%scale)
      value = value/(equations%scale(row)*equations%scale(column))
      call equations%lu%analyse(unknowns, row, column, status)
      if (status == linear_ok) call equations%lu%factor(value, status)
   end subroutine init_flow

   !> Parts of the network that hang together by what conducts, and which of them a known pressure reaches.
   subroutine find_parts(conductors, equations)
      type(conductors_t), intent(in) :: conductors
      type(flow_equations_t), intent(inout) :: equations
      integer, allocatable :: parent(:)
      logical, allocatable :: touched(:), has_pressure(:)
      integer :: i, n

      n = size(conductors%x, 2)
      allocate (parent(n), touched(n), has_pressure(n))
      parent = each_alone(n)
      touched = .false.
      do i = 1, size(conductors%line, 2)
         if (.not. conductors%line_mobility(i) > 0.0_wp) cycle
         call join(parent, conductors%line(1, i), conductors%line(2, i))
         touched(conductors%line(:, i)) = .true.
      end do
      do i = 1, size(conductors%triangle, 2)
         if (.not. conductors%mobility(i) > 0.0_wp) cycle
         call join(parent, conductors%triangle(1, i), conductors%triangle(2, i))
         call join(parent, conductors%triangle(1, i), conductors%triangle(3, i))
         touched(conductors%triangle(:, i)) = .true.
      end do
      equations%part = representatives(parent)
      where (.not. touched) equations%part = 0
      has_pressure = .false.
      do i = 1, n
         if (touched(i) .and. (equations%fixed(i) .or. equations%storing(i) > 0.0_wp)) has_pressure(equations%part(i)) = .true.
      end do
      equations%parts = count(touched .and. equations%part == [(i, i=1, n)])
      equations%parts_left_out = equations%parts - count(has_pressure)
      equations%reached = touched
      do i = 1, n
         if (touched(i)) equations%reached(i) = has_pressure(equations%part(i))
      end do
   end subroutine find_parts

   !> Entries of the equations of the unknowns; the linear solver adds up those of one place.
   subroutine assemble(conductors, equations, row, column, value)
      type(conductors_t), intent(in) :: conductors
      type(flow_equations_t), intent(in) :: equations
      integer, allocatable, intent(out) :: row(:), column(:)
      real(wp), allocatable, intent(out) :: value(:)
      real(wp) :: conductance, gradient(2, 3), area
      integer :: i, a, b, n, most

      most = 4*count(conductors%line_mobility > 0.0_wp) + 9*count(conductors%mobility > 0.0_wp) + size(equations%storing)
      allocate (row(most), column(most), value(most))
      n = 0
      do i = 1, size(conductors%line, 2)
         if (.not. conductors%line_mobility(i) > 0.0_wp) cycle
         conductance = conductors%line_mobility(i)/line_length(conductors, i)
         do a = 1, 2
            do b = 1, 2
               call put(conductors%line(a, i), conductors%line(b, i), merge(conductance, -conductance, a == b))
            end do
         end do
      end do
      do i = 1, size(conductors%triangle, 2)
         if (.not. conductors%mobility(i) > 0.0_wp) cycle
         area = triangle_area(conductors, i)
         gradient = triangle_gradients(conductors, i)
         do a = 1, 3
            do b = 1, 3
               call put(conductors%triangle(a, i), conductors%triangle(b, i), &
                        conductors%mobility(i)*area*dot_product(gradient(:, a), gradient(:, b)))
            end do
         end do
      end do
      do i = 1, size(equations%storing)
         if (equations%storing(i) > 0.0_wp) call put(i, i, equations%storing(i))
      end do
      row = row(:n)
      column = column(:n)
      value = value(:n)

   contains

      subroutine put(node_a, node_b, entry)
         integer, intent(in) :: node_a, node_b
         real(wp), intent(in) :: entry

         if (equations%number(node_a) == 0 .or. equations%number(node_b) == 0) return
         n = n + 1
         row(n) = equations%number(node_a)
         column(n) = equations%number(node_b)
         value(n) = entry
      end subroutine put

   end subroutine assemble

   !> Solve for given pressures and inflows.
   subroutine solve_flow(conductors, equations, pressure, source, field, status, before)
      type(conductors_t), intent(in) :: conductors
      type(flow_equations_t), intent(inout) :: equations
      !> Pressure of the nodes where it is known [Pa]; inflow prescribed at the others [m2/s] (nodes)
      real(wp), intent(in) :: pressure(:), source(:)
      type(flow_field_t), intent(out) :: field
      integer, intent(out) :: status
      !> Pressure at the start of the time step [Pa] (nodes); needed when the equations have one
      real(wp), intent(in), optional :: before(:)
      real(wp), allocatable :: p(:), out(:), x(:), start(:)
      real(wp) :: reference, through
      integer :: i, pass

      allocate (p(size(pressure)), out(size(pressure)), x(size(equations%scale)))
      ! Differences of pressure drive the flow: digits of a common pressure would be lost to them
      reference = 0.0_wp
      if (any(equations%fixed .and. equations%reached)) then
         reference = 0.5_wp*(minval(pressure, mask=equations%fixed .and. equations%reached) + &
                             maxval(pressure, mask=equations%fixed .and. equations%reached))
      end if
      if (present(before) .and. .not. any(equations%fixed .and. equations%reached)) reference = before(1)
      allocate (start(size(pressure)), source=0.0_wp)
      if (present(before)) start = before - reference
      p = start
      where (equations%fixed .and. equations%reached) p = pressure - reference
      status = linear_ok
      do pass = 0, most_refinements
         call flows(conductors, equations, p, field, out)
         out = out + equations%storing*(p - start)
         if (size(x) == 0) exit
         through = maxval(abs(out), mask=equations%reached)
         if (any(equations%number > 0 .and. abs(source) > 0.0_wp)) &
            through = max(through, maxval(abs(source), mask=equations%number > 0))
         do i = 1, size(p)
            if (equations%number(i) > 0) x(equations%number(i)) = source(i) - out(i)
         end do
         if (pass > 0 .and. maxval(abs(x)) <= enough*through) exit
         x = x/equations%scale
         call equations%lu%solve(x, status)
         if (status /= linear_ok) return
         x = x/equations%scale
         do i = 1, size(p)
            if (equations%number(i) > 0) p(i) = p(i) + x(equations%number(i))
         end do
      end do
      allocate (field%pressure(size(p)), field%inflow(size(p)))
      field%pressure = no_pressure()
      where (equations%reached) field%pressure = p + reference
      field%inflow = 0.0_wp
      where (equations%fixed .and. equations%reached) field%inflow = out
      where (equations%number > 0) field%inflow = source
      through = sum(field%inflow, mask=field%inflow > 0.0_wp)
      field%stored = sum(equations%storing*(p - start), mask=equations%reached)
      if (through > 0.0_wp) field%imbalance = (sum(field%inflow) - field%stored)/through
   end subroutine solve_flow

   !> Flow along lines and in triangles of a pressure that is known.
   subroutine describe_flow(conductors, equations, pressure, field)
      type(conductors_t), intent(in) :: conductors
      !> Its network is known
      type(flow_equations_t), intent(in) :: equations
      !> (nodes) [Pa]
      real(wp), intent(in) :: pressure(:)
      !> Without inflows
      type(flow_field_t), intent(out) :: field
      real(wp) :: out(size(pressure))

      call flows(conductors, equations, pressure, field, out)
      allocate (field%pressure(size(pressure)))
      field%pressure = no_pressure()
      where (equations%reached) field%pressure = pressure
   end subroutine describe_flow

   !> Flow along lines, flux in triangles, and what leaves each node into them.
   subroutine flows(conductors, equations, p, field, out)
      type(conductors_t), intent(in) :: conductors
      type(flow_equations_t), intent(in) :: equations
      !> Pressure (nodes) [Pa]
      real(wp), intent(in) :: p(:)
      type(flow_field_t), intent(inout) :: field
      !> [m2/s] (nodes)
      real(wp), intent(out) :: out(:)
      real(wp) :: gradient(2, 3), slope(2)
      integer :: i, a, b, k

      if (.not. allocated(field%along)) allocate (field%along(size(conductors%line, 2)), &
                                                  field%flux(2, size(conductors%triangle, 2)))
      out = 0.0_wp
      field%along = 0.0_wp
      field%flux = 0.0_wp
      do i = 1, size(conductors%line, 2)
         a = conductors%line(1, i)
         b = conductors%line(2, i)
         if (.not. (conductors%line_mobility(i) > 0.0_wp .and. equations%reached(a))) cycle
         field%along(i) = conductors%line_mobility(i)/line_length(conductors, i)* &
                          (p(a) - p(b) + dot_product(conductors%weight, conductors%x(:, b) - conductors%x(:, a)))
         out(a) = out(a) + field%along(i)
         out(b) = out(b) - field%along(i)
      end do
      do i = 1, size(conductors%triangle, 2)
         if (.not. conductors%mobility(i) > 0.0_wp) cycle
         if (.not. equations%reached(conductors%triangle(1, i))) cycle
         gradient = triangle_gradients(conductors, i)
         ! The gradients add up to nothing: differences from the first corner
         slope = gradient(:, 2)*(p(conductors%triangle(2, i)) - p(conductors%triangle(1, i))) + &
                 gradient(:, 3)*(p(conductors%triangle(3, i)) - p(conductors%triangle(1, i)))
         field%flux(:, i) = -conductors%mobility(i)*(slope - conductors%weight)
         do k = 1, 3
            out(conductors%triangle(k, i)) = out(conductors%triangle(k, i)) &
                                             - triangle_area(conductors, i)*dot_product(gradient(:, k), field%flux(:, i))
         end do
      end do
   end subroutine flows

   !> Length of a line [m].
   pure real(wp) function line_length(conductors, i)
      type(conductors_t), intent(in) :: conductors
      integer, intent(in) :: i

      line_length = norm2(conductors%x(:, conductors%line(2, i)) - conductors%x(:, conductors%line(1, i)))
   end function line_length

   !> Area of a triangle [m2].
   pure real(wp) function triangle_area(conductors, i)
      type(conductors_t), intent(in) :: conductors
      integer, intent(in) :: i
      real(wp) :: u(2), v(2)

      u = conductors%x(:, conductors%triangle(2, i)) - conductors%x(:, conductors%triangle(1, i))
      v = conductors%x(:, conductors%triangle(3, i)) - conductors%x(:, conductors%triangle(1, i))
      triangle_area = 0.5_wp*(u(1)*v(2) - u(2)*v(1))
   end function triangle_area

   !> Gradients of the three linear functions of a triangle (2, 3) [1/m].
   pure function triangle_gradients(conductors, i) result(gradient)
      type(conductors_t), intent(in) :: conductors
      integer, intent(in) :: i
      real(wp) :: gradient(2, 3)
      real(wp) :: side(2)
      integer :: k
      integer, parameter :: next(3) = [2, 3, 1], last(3) = [3, 1, 2]

      do k = 1, 3
         side = conductors%x(:, conductors%triangle(last(k), i)) - conductors%x(:, conductors%triangle(next(k), i))
         gradient(:, k) = [-side(2), side(1)]/(2.0_wp*triangle_area(conductors, i))
      end do
   end function triangle_gradients

end module flow_m
