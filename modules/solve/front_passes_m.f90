!> Passes of fluid that may lag behind the tip of a crack: Newton's method for the pressures of a step, between one rest of the rock
!> and the next (fluid_front_m has the equations, the implicit solver the rock's answer).
module front_passes_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use flow_domain_m, only: flow_domain_t
   use fluid_front_m, only: front_balance_t, find_balance, wet_nodes, newton_step, longest_part
   use implicit_m, only: implicit_solver_t
   use joint_border_m, only: pressing
   use model_m, only: model_t
   use state_m, only: state_t
   implicit none
   private

   !> What a pass says: pressures and apertures agree, the next pass has pressures to try, or there are none
   integer, parameter, public :: pass_agrees = 1, pass_next = 2, pass_fails = 3

   !> The way to the pressures of a step
   type, public :: front_t
      !> What the nodes hold at the end of the step and what flows in then, when they agree (nodes of the mesh as read) [m2, m2/s];
      !> what was missed over what went through [-]
      real(wp), allocatable :: content(:), inflow(:)
      real(wp) :: imbalance = 0.0_wp
      !> Pressures that came nearest so far, the step from there (nodes of the mesh as read) [Pa], the part of it that is tried
      real(wp), allocatable, private :: pressure(:), step(:)
      real(wp), private :: part = 0.0_wp
      !> What they missed [m2]; parts tried since
      real(wp), private :: missed = 0.0_wp
      integer, private :: cuts = 0
   contains
      procedure :: end_pass
   end type front_t

   !> A pass must miss less than the best before by this part of what Newton's step promises, after so many cuts at the most
   real(wp), parameter :: sufficient = 1.0e-4_wp
   integer, parameter :: most_cuts = 4
   !> Passes of a step at the most
   integer, parameter :: most_passes = 15
   !> Walls that press by less than this times the tolerance of rest, of the largest pressure, may as well be open
   real(wp), parameter :: beyond_rest = 100.0_wp
   !> Where next to nothing flows this part of what the largest node can hold counts as what goes through
   real(wp), parameter :: least_through = 1.0e-2_wp

contains

   !> A pass is done: does the fluid go where there is room for it? If not, other pressures.
   subroutine end_pass(self, solver, model, domain, filled, content, duration, pass, state, pressure, verdict, errors)
      class(front_t), intent(inout) :: self
      !> That found the rest
      type(implicit_solver_t), intent(inout) :: solver
      type(model_t), intent(in) :: model
      !> With the apertures of the state
      type(flow_domain_t), intent(in) :: domain
      !> Is the fluid felt between the walls? (joints)
      logical, intent(in) :: filled(:)
      !> At the start of the step (nodes of the mesh as read) [m2]; how long it is [s]
      real(wp), intent(in) :: content(:), duration
      !> Number, from 1
      integer, intent(in) :: pass
      !> At rest under the pressures
      type(state_t), intent(inout) :: state
      !> Tried, and to be tried next (nodes of the mesh as read) [Pa]
      real(wp), intent(inout) :: pressure(:)
      !> pass_agrees, pass_next, pass_fails
      integer, intent(out) :: verdict
      type(error_list_t), intent(inout) :: errors
      type(front_balance_t) :: balance
      real(wp) :: missed, through
      logical :: found

      verdict = pass_fails
      call find_balance(domain, content, duration, pressure, balance, errors)
      if (errors%any()) return
      through = max(duration*max(maxval(abs(balance%inflow)), maxval(abs(balance%along))), &
                    least_through*maxval(balance%capacity), tiny(through))
      if (maxval(abs(balance%missed)) <= model%deck%flow%tolerance*through) then
         verdict = pass_agrees
         self%content = max(0.0_wp, content + duration*balance%net)
         self%inflow = balance%inflow
         self%imbalance = sum(balance%missed)/through
         return
      end if
      if (pass >= min(most_passes, model%deck%flow%max_passes)) return
      missed = norm2(balance%missed)
      found = pass == 1
      if (.not. found) found = missed <= (1.0_wp - sufficient*self%part)*self%missed
      if (found) then
         self%pressure = pressure
         self%missed = missed
         self%cuts = 0
         call find_step()
         if (.not. found) return
      else
         ! The last: walls that have just come apart give way many times as much as the step knows
         self%part = self%part*merge(0.5_wp, min(0.5_wp, self%missed/missed), self%cuts < most_cuts - 1)
         self%cuts = self%cuts + 1
         if (self%cuts > most_cuts) return
      end if
      verdict = pass_next
      pressure = self%pressure
      where (.not. balance%fixed) pressure = max(0.0_wp, self%pressure + self%part*self%step)

   contains

      !> Newton's step from these pressures, and how much of it to take.
      subroutine find_step()
         integer, allocatable :: node(:)
         real(wp), allocatable :: answer(:, :)

         allocate (node, source=wet_nodes(balance, pressure))
         call solver%answer_of_walls(model, state, node, filled, answer, found)
         if (.not. found) return
         where (spread(domain%given_mm >= 0.0_wp, 2, size(node))) answer = 0.0_wp
         call newton_step(domain, balance, node, answer, duration, pressure, self%step, found)
         if (found) self%part = longest_part(domain, node, answer, pressing(state%joint), &
                                             beyond_rest*model%rest_tolerance()*maxval(pressure), self%step)
      end subroutine find_step

   end subroutine end_pass

end module front_passes_m
