!> Flow that changes with time: implicit Euler, in steps of one length or as long as the error of each allows.
module transient_flow_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use flow_m, only: flow_equations_t, init_flow, solve_flow
   use flow_domain_m, only: flow_domain_t, boundary_flow_t, boundary_values, add_sources, finish_flow
   use sparse_lu_m, only: linear_ok
   use text_m, only: to_text
   implicit none
   private

   public :: start_transient, advance, end_transient

   !> A step is redone when its error is above the tolerance, and the next is longer when it is well below it
   real(wp), parameter :: longest_growth = 2.0_wp, shortest_cut = 0.2_wp, caution = 0.9_wp, worth_it = 1.2_wp
   !> A remainder of a step that is rounding of the time [-]
   real(wp), parameter :: nothing = 1.0e-9_wp
   !> Steps below this part of the duration will not come to an end [-]
   real(wp), parameter :: shortest_step = 1.0e-12_wp

   !> Where a run in time is
   type, public :: transient_flow_t
      real(wp) :: time = 0.0_wp
      integer :: steps = 0, redone = 0
      !> Step that the error allows; that of the equations; that taken last [s]
      real(wp) :: wanted = 0.0_wp, factored = 0.0_wp, last = 0.0_wp
      !> Pressure before anything flowed [Pa]
      real(wp) :: initial = 0.0_wp
      !> Pressure now [Pa], and how it changed in the last step [Pa/s] (nodes)
      real(wp), allocatable :: pressure(:), rate(:)
      logical, allocatable :: fixed(:)
      real(wp), allocatable :: prescribed(:), source(:)
      integer, allocatable :: owner(:)
      type(flow_equations_t) :: equations
   end type transient_flow_t

contains

   !> Before anything flows.
   subroutine start_transient(model, transient)
      type(flow_domain_t), intent(in) :: model
      type(transient_flow_t), intent(out) :: transient

      call boundary_values(model, transient%fixed, transient%prescribed, transient%owner)
      allocate (transient%pressure(size(transient%fixed)), source=model%deck%transient%initial_pressure)
      transient%initial = model%deck%transient%initial_pressure
      transient%wanted = model%deck%transient%step
   end subroutine start_transient

   !> Go on to a time.
   subroutine advance(model, until, transient, flow, errors)
      type(flow_domain_t), intent(in) :: model
      !> Time [s]
      real(wp), intent(in) :: until
      type(transient_flow_t), intent(inout) :: transient
      !> Of the last step
      type(boundary_flow_t), intent(inout) :: flow
      type(error_list_t), intent(inout) :: errors
      real(wp) :: step, left, error
      logical :: adaptive
      integer :: before

      before = errors%count()
      adaptive = model%deck%transient%steps == 'adaptive'
      do
         left = until - transient%time
         if (left <= nothing*transient%wanted) exit
         ! Steps of equal length up to the output
         step = left/real(ceiling(left/transient%wanted - nothing), wp)
         call one_step(model, step, transient, flow, errors)
         if (errors%count() > before) return
         error = error_of(transient, flow%field%pressure, step)/model%deck%transient%tolerance
         if (adaptive .and. error > 1.0_wp) then
            transient%redone = transient%redone + 1
            transient%wanted = step*max(shortest_cut, caution/sqrt(error))
            if (transient%wanted < shortest_step*model%deck%transient%duration) then
               call errors%add('flow at '//to_text(transient%time)//' s: no step is short enough for a tolerance of '// &
                               to_text(model%deck%transient%tolerance)//'; try a larger one, or steps = ''fixed''')
               return
            end if
            cycle
         end if
         where (transient%equations%reached)
            transient%rate = (flow%field%pressure - transient%pressure)/step
            transient%pressure = flow%field%pressure
         end where
         transient%time = transient%time + step
         transient%last = step
         transient%steps = transient%steps + 1
         if (.not. adaptive) cycle
         ! A longer step needs new factors: not for little
         if (caution/sqrt(max(error, tiny(error))) > worth_it) &
            transient%wanted = max(transient%wanted, step*min(longest_growth, caution/sqrt(max(error, tiny(error)))))
      end do
      call finish_flow(model, transient%equations, transient%owner, flow)
   end subroutine advance

   !> One step of implicit Euler from the pressure now.
   subroutine one_step(model, step, transient, flow, errors)
      type(flow_domain_t), intent(in) :: model
      real(wp), intent(in) :: step
      type(transient_flow_t), intent(inout) :: transient
      type(boundary_flow_t), intent(inout) :: flow
      type(error_list_t), intent(inout) :: errors
      integer :: status, before

      before = errors%count()
      status = linear_ok
      if (abs(step - transient%factored) > nothing*step) then
         call init_flow(model%conductors, transient%fixed, transient%equations, status, step)
         transient%factored = step
      end if
      if (.not. allocated(transient%source)) then
         allocate (transient%source(size(transient%fixed)), transient%rate(size(transient%fixed)), source=0.0_wp)
         call add_sources(model, transient%equations, transient%source, errors)
         if (errors%count() > before) return
      end if
      if (status == linear_ok) call solve_flow(model%conductors, transient%equations, transient%prescribed, transient%source, &
                                               flow%field, status, transient%pressure)
      if (status /= linear_ok) call errors%add('flow at '//to_text(transient%time)//' s: '//transient%equations%lu%message())
   end subroutine one_step

   !> Error of a step, from how the rate of the pressure has changed since the last one, over the range of pressures [-]. The first
   !> step has no rate before it: a sudden change of the boundary is taken as it is.
   pure real(wp) function error_of(transient, pressure, step) result(error)
      type(transient_flow_t), intent(in) :: transient
      !> At the end of the step (nodes)
      real(wp), intent(in) :: pressure(:)
      real(wp), intent(in) :: step
      real(wp) :: range, largest
      integer :: i

      error = 0.0_wp
      if (transient%steps == 0) return
      largest = 0.0_wp
      range = tiny(range)
      do i = 1, size(pressure)
         if (.not. transient%equations%reached(i)) cycle
         range = max(range, abs(pressure(i) - transient%initial))
         if (transient%fixed(i)) cycle
         largest = max(largest, abs(pressure(i) - transient%pressure(i) - step*transient%rate(i)))
      end do
      error = step/(step + transient%last)*largest/range

   end function error_of

   !> Give back the factors.
   subroutine end_transient(transient)
      type(transient_flow_t), intent(inout) :: transient

      call transient%equations%lu%free()
   end subroutine end_transient

end module transient_flow_m
