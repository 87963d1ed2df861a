!> Fluid that may lag behind the tip of a crack: what opens fills only as fast as fluid gets there.
!>
!> Each node of what conducts holds a volume of fluid. Where that fills what is open at it the pressure is what flows need, above
!> zero; where it does not the pressure is zero and nothing flows out (fluid lag: Garagash 2006, Int J Solids Struct 43:5811;
!> cavitation that conserves mass: Elrod 1981, J Lubr Technol 103:350). Over a step of implicit Euler
!>
!>      over = content + duration net inflow - capacity,     pressure >= 0,  over <= 0,  one of them 0
!>
!> and the pressures come by Newton's method, with the answer of the walls to the pressure of every node: what lubrication asks of
!> one place, w^3 grad p, hangs on the pressures of all others through the rock.
module fluid_front_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use flow_m, only: flow_equations_t, flow_field_t, find_network, describe_flow, line_length
   use flow_domain_m, only: flow_domain_t, boundary_values, add_sources
   implicit none
   private

   public :: find_capacity, find_balance, wet_nodes, newton_step, longest_part

   !> The fluid of a step for pressures tried
   type, public :: front_balance_t
      !> Is there a pressure, and is it prescribed? (nodes)
      logical, allocatable :: conducts(:), fixed(:)
      !> What is open; what flows in from outside (out as far as there is any); that and what comes along the lines
      !> [m2, m2/s, m2/s] (nodes)
      real(wp), allocatable :: capacity(:), inflow(:), net(:)
      !> More than there is room for (less: below zero); the part of it that must not be (nodes) [m2]
      real(wp), allocatable :: over(:), missed(:)
      !> Flow along lines (lines) [m2/s]
      real(wp), allocatable :: along(:)
   end type front_balance_t

   !> A Newton step may take this part of an aperture at most
   real(wp), parameter :: most_closed = 0.8_wp
   !> Walls that press on each other: pressures go this far beyond what opens the one that presses hardest, and no further at once
   real(wp), parameter :: just_open = 1.05_wp

   interface
      subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         integer, intent(in) :: n, nrhs, lda, ldb
         real(wp), intent(inout) :: a(lda, *), b(ldb, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgesv
   end interface

contains

   !> What the lines can hold at their nodes, half at either end, as volume at no pressure [m2] (nodes).
   pure function find_capacity(domain, pressure) result(capacity)
      !> With the apertures of a state
      type(flow_domain_t), intent(in) :: domain
      !> (nodes) [Pa]
      real(wp), intent(in) :: pressure(:)
      real(wp) :: capacity(size(pressure))
      integer :: i

      capacity = 0.0_wp
      do i = 1, size(domain%conductors%line, 2)
         associate (node => domain%conductors%line(:, i))
            capacity(node) = capacity(node) + 0.5_wp*line_length(domain%conductors, i)*domain%mechanical(i)* &
                             (1.0_wp + domain%deck%fluid%compressibility*pressure(node))
         end associate
      end do
   end function find_capacity

   !> Where the fluid of a step goes with the pressures tried.
   subroutine find_balance(domain, content, duration, pressure, balance, errors)
      !> With the apertures of the state at rest under the pressures
      type(flow_domain_t), intent(in) :: domain
      !> At the start of the step (nodes) [m2]
      real(wp), intent(in) :: content(:)
      !> [s]
      real(wp), intent(in) :: duration
      !> (nodes) [Pa]
      real(wp), intent(in) :: pressure(:)
      type(front_balance_t), intent(out) :: balance
      type(error_list_t), intent(inout) :: errors
      type(flow_equations_t) :: equations
      type(flow_field_t) :: field
      real(wp), allocatable :: prescribed(:)
      integer, allocatable :: owner(:)
      integer :: i

      call boundary_values(domain, balance%fixed, prescribed, owner)
      call find_network(domain%conductors, balance%fixed, equations)
      equations%reached = equations%part > 0
      balance%conducts = equations%reached
      call describe_flow(domain%conductors, equations, pressure, field)
      balance%along = field%along
      allocate (balance%inflow(size(pressure)), source=0.0_wp)
      call add_sources(domain, equations, balance%inflow, errors)
      balance%net = balance%inflow
      do i = 1, size(balance%along)
         ! What has no pressure lets nothing out, whatever its weight
         associate (from => domain%conductors%line(merge(1, 2, balance%along(i) > 0.0_wp), i))
            if (.not. (pressure(from) > 0.0_wp .or. balance%fixed(from))) balance%along(i) = 0.0_wp
         end associate
         associate (a => domain%conductors%line(1, i), b => domain%conductors%line(2, i))
            balance%net(a) = balance%net(a) - balance%along(i)
            balance%net(b) = balance%net(b) + balance%along(i)
         end associate
      end do
      balance%capacity = find_capacity(domain, pressure)
      balance%over = content + duration*balance%net - balance%capacity
      ! Where the pressure is prescribed as much flows in as there is room for
      where (balance%fixed .and. balance%conducts)
         balance%inflow = -balance%over/duration
         balance%net = balance%net + balance%inflow
         balance%over = 0.0_wp
      end where
      ! No more can be taken out than there is
      where (balance%conducts .and. balance%inflow < 0.0_wp .and. .not. (balance%fixed .or. pressure > 0.0_wp))
         balance%net = balance%net - balance%inflow
         balance%inflow = min(0.0_wp, max(balance%inflow, -(content/duration + balance%net)))
         balance%net = balance%net + balance%inflow
         balance%over = content + duration*balance%net - balance%capacity
      end where
      balance%missed = merge(balance%over, max(balance%over, 0.0_wp), pressure > 0.0_wp)
      where (.not. balance%conducts) balance%missed = 0.0_wp
   end subroutine find_balance

   !> Nodes whose pressure is to be found: full ones, and those that more flows to than they hold.
   pure function wet_nodes(balance, pressure) result(node)
      type(front_balance_t), intent(in) :: balance
      real(wp), intent(in) :: pressure(:)
      integer, allocatable :: node(:)
      integer :: n

      node = pack([(n, n=1, size(pressure))], &
                  balance%conducts .and. .not. balance%fixed .and. (pressure > 0.0_wp .or. balance%over > 0.0_wp))
   end function wet_nodes

   !> Change of the pressures that makes what is over vanish, to first order.
   subroutine newton_step(domain, balance, node, answer, duration, pressure, step, found)
      type(flow_domain_t), intent(in) :: domain
      type(front_balance_t), intent(in) :: balance
      !> Wet nodes
      integer, intent(in) :: node(:)
      !> What the walls open by for a pascal more at each of them (lines, wet nodes) [m/Pa]
      real(wp), intent(in) :: answer(:, :)
      !> [s], [Pa] (nodes)
      real(wp), intent(in) :: duration, pressure(:)
      !> (nodes) [Pa]
      real(wp), allocatable, intent(out) :: step(:)
      !> Is there one?
      logical, intent(out) :: found
      real(wp), allocatable :: matrix(:, :), side(:, :), rise(:)
      integer :: pivot(size(node)), place(size(pressure)), i, k, e, info

      place = 0
      place(node) = [(k, k=1, size(node))]
      allocate (matrix(size(node), size(node)), source=0.0_wp)
      do i = 1, size(domain%conductors%line, 2)
         if (.not. domain%conductors%line_mobility(i) > 0.0_wp) cycle
         associate (a => place(domain%conductors%line(1, i)), b => place(domain%conductors%line(2, i)), &
                    conductance => domain%conductors%line_mobility(i)/line_length(domain%conductors, i))
            ! Flow from a to b: cubic in the aperture, linear in the pressures
            rise = 3.0_wp*balance%along(i)/domain%mechanical(i)*answer(i, :)
            if (a > 0) rise(a) = rise(a) + conductance
            if (b > 0) rise(b) = rise(b) - conductance
            if (a > 0) matrix(a, :) = matrix(a, :) + duration*rise
            if (b > 0) matrix(b, :) = matrix(b, :) - duration*rise
            do e = 1, 2
               associate (n => domain%conductors%line(e, i), half => 0.5_wp*line_length(domain%conductors, i))
                  k = place(n)
                  if (k == 0) cycle
                  matrix(k, :) = matrix(k, :) + half*(1.0_wp + domain%deck%fluid%compressibility*pressure(n))*answer(i, :)
                  matrix(k, k) = matrix(k, k) + half*domain%deck%fluid%compressibility*domain%mechanical(i)
               end associate
            end do
         end associate
      end do
      side = reshape(balance%over(node), [size(node), 1])
      call dgesv(size(node), 1, matrix, size(node), pivot, side, size(node), info)
      found = info == 0
      if (found) found = all(abs(side) < huge(1.0_wp))
      allocate (step(size(pressure)), source=0.0_wp)
      if (found) step(node) = side(:, 1)
   end subroutine newton_step

   !> Part of a step that neither closes what is open nor goes far beyond what opens walls that press on each other [-].
   pure real(wp) function longest_part(domain, node, answer, press, least, step) result(part)
      type(flow_domain_t), intent(in) :: domain
      !> Wet nodes
      integer, intent(in) :: node(:)
      !> As for newton_step
      real(wp), intent(in) :: answer(:, :)
      !> Stress that the walls press on each other with (lines) [Pa]
      real(wp), intent(in) :: press(:)
      !> That the solver cannot tell from none [Pa]
      real(wp), intent(in) :: least
      !> (nodes) [Pa]
      real(wp), intent(in) :: step(:)
      real(wp) :: change(size(node)), opens, hardest, rise
      integer :: i

      part = 1.0_wp
      change = step(node)
      hardest = 0.0_wp
      rise = 0.0_wp
      do i = 1, size(answer, 1)
         if (.not. domain%conductors%line_mobility(i) > 0.0_wp) cycle
         opens = dot_product(answer(i, :), change)
         if (opens < 0.0_wp) part = min(part, most_closed*domain%mechanical(i)/(-opens))
         if (.not. press(i) > 0.0_wp) cycle
         hardest = max(hardest, press(i))
         rise = max(rise, 0.5_wp*sum(step(domain%conductors%line(:, i))))
      end do
      associate (most => max(just_open*hardest, least))
         if (hardest > 0.0_wp .and. rise > most) part = min(part, most/rise)
      end associate
   end function longest_part

end module fluid_front_m
