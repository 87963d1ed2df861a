!> What flow and stress say to each other. Apertures conduct; with coupling = 'two-way' the pressure found pushes the walls of the
!> fractures and, by Biot's coefficient, the rock, and a step is done again until pressure and apertures agree.
!>
!> Flow knows nothing of forces, the solver nothing of flow: a step sees nodal loads that go from those of the last pressure to
!> those of the new one. The signs are those of pore_pressure_m: stresses of the rock and of the joints are effective ones.
!>
!> With time (&transient) the fluid that is pressed out of rock and fractures while they are strained is what flows: the balance
!> of each node over a step of implicit Euler is what must vanish (fluid_storage_m), and the pressure follows it by the fixed-stress
!> split (Kim, Tchelepi and Juanes 2011, Comput Methods Appl Mech Engrg 200:2094) with Anderson's acceleration.
module fluid_coupling_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use anderson_m, only: anderson_t
   use cracks_m, only: breaks_t, find_breaks
   use deck_m, only: deck_t
   use errors_m, only: error_list_t
   use forces_m, only: find_forces
   use flow_domain_m, only: flow_domain_t, boundary_flow_t, init_flow_domain, set_moment, set_lines, set_apertures, &
                            solve_boundary_flow, boundary_values
   use fluid_front_m, only: find_capacity
   use front_passes_m, only: front_t, pass_agrees, pass_next, pass_fails
   use implicit_m, only: implicit_solver_t
   use fluid_storage_m, only: fluid_storage_t, start_storage, begin_balance, make_room, pressure_in_time
   use joint_law_m, only: law_item_t
   use loads_m, only: push_t
   use pore_pressure_m, only: press_rock, press_walls
   use model_m, only: model_t, holds_fluid
   use state_m, only: state_t
   use text_m, only: to_text, quoted
   implicit none
   private

   public :: conducting_lines, mobilised_roughness, is_two_way, hold_pressure, start_cycle, end_pass, go_on_broken, halve_step

   !> What the coupling needs besides model and state
   type, public :: fluid_coupling_t
      private
      logical :: started = .false.
      type(flow_domain_t) :: model
      type(fluid_storage_t) :: storage
      type(anderson_t) :: past
      type(front_t) :: front
      !> Loads of the fluid for the next pass
      type(push_t), public :: push
      !> Start and end of the step as parts of the cycle
      real(wp), public :: part(2) = 0.0_wp
      !> Is the cycle over? Has rock broken in the step, so that its passes are at its end alone?
      logical, public :: over = .false., settles = .false.
      !> State at the start of the step, and that the passes start from
      type(state_t) :: before, start
      !> Passes so far; pressure of the next one (nodes of the mesh as read) [Pa]; way from start to rest in the last one
      !> (2, nodes) [m]
      integer :: pass = 0
      real(wp), allocatable :: pressure(:), move(:, :)
      !> Rock that may break: last pressures that were too low and too high for what they open (nodes of the mesh as read) [Pa]; not
      !> allocated: none yet
      real(wp), allocatable :: low(:), high(:)
   contains
      procedure :: may_be_halved
   end type fluid_coupling_t

   !> Rock that may break: passes after which pressures are sought between one too low and one too high, and the difference of these
   !> over the higher one at which none in between agrees [-]
   integer, parameter :: steady_passes = 8
   real(wp), parameter :: jump = 2.0e-3_wp
   !> Fluid that may lag: growth of the step of time after one that was found
   real(wp), parameter :: front_growth = 1.4_wp
   !> Shortest of its steps over that of the deck [-]: elements hold their fluid at nodes that then do not hear of each other
   real(wp), parameter :: shortest_front = 1.0e-6_wp
   !> A remainder of a cycle that is rounding of its parts [-]
   real(wp), parameter :: rounding = 1.0e-9_wp
   !> Shortest step over the first one of the deck [-]
   real(wp), parameter :: shortest = 1.0e-12_wp
   !> A step that changes the pressure by less than this part of it is as exact as one that changes it by so much [-]
   real(wp), parameter :: least_change = 1.0e-2_wp
   !> A step is done again when its error is above the tolerance, and the next is longer when it is well below it
   real(wp), parameter :: longest_growth = 2.0_wp, shortest_cut = 0.2_wp, caution = 0.9_wp

contains

   !> Does the pressure push back?
   pure logical function is_two_way(deck)
      type(deck_t), intent(in) :: deck

      is_two_way = deck%flow%line > 0 .and. deck%flow%coupling == 'two-way'
   end function is_two_way

   !> Let the fluid push as it did at the end of the last step, whatever the level of the loads.
   subroutine hold_pressure(self, model, state)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state

      if (.not. self%started) call start_coupling(self, model, state)
      call fluid_loads(self, model, state%fluid%pressure, state%fluid%filled > 0, self%push%from)
      self%push%to = self%push%from
      self%push%level = [0.0_wp, 1.0_wp]
   end subroutine hold_pressure

   !> Start a cycle: one step of steady flow, or as many steps of time as the deck or their errors ask for.
   subroutine start_cycle(self, model, stage, cycle, state, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors

      ! A stage brings sudden changes: steps begin anew
      if (cycle == 1) then
         state%fluid%wanted = model%deck%transient%step
         state%fluid%last = 0.0_wp
         state%fluid%rate = 0.0_wp
      end if
      self%over = .false.
      self%part(2) = 0.0_wp
      call start_step(self, model, stage, cycle, state, errors)
   end subroutine start_cycle

   !> Start a step where the last one ended, with the pressure tried first.
   subroutine start_step(self, model, stage, cycle, state, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: inflow(:), prescribed(:), first(:)
      logical, allocatable :: fixed(:)
      integer, allocatable :: owner(:)
      real(wp) :: imbalance

      self%part = [self%part(2), next_part(model%deck, state, model%deck%stage(stage)%move_time, self%part(2))]
      call set_moment(self%model, stage, (real(cycle - 1, wp) + self%part(2))/real(model%deck%stage(stage)%cycles, wp))
      call take_apertures(self, model, state, state)
      self%pressure = state%fluid%pressure
      if (model%deck%transient%line > 0) then
         if (.not. model%deck%flow%fluid_lag) then
            call begin_balance(self%storage, self%model, model%split, state)
            self%pressure = self%pressure + duration(self, model, stage)*state%fluid%rate
         end if
         call boundary_values(self%model, fixed, prescribed, owner)
         where (fixed) self%pressure = prescribed
      else
         ! Steady flow follows the apertures: that of those there are is the first try
         call find_pressure(self, model, state, stage, first, inflow, imbalance, errors)
         if (errors%any()) return
         call move_alloc(first, self%pressure)
      end if
      self%before = state
      self%settles = .false.
      call start_passes(self, model, cycle, state)
   end subroutine start_step

   !> Rock has broken in a step, and the model has been brought up to it: the passes go on from here.
   subroutine go_on_broken(self, model, cycle, state)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: cycle
      type(state_t), intent(inout) :: state

      self%settles = .true.
      call make_room(self%storage, size(model%split%joint, 2))
      call start_passes(self, model, cycle, state)
   end subroutine go_on_broken

   !> The first pass from a state.
   subroutine start_passes(self, model, cycle, state)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: cycle
      type(state_t), intent(inout) :: state

      self%start = state
      self%pass = 0
      if (allocated(self%move)) deallocate (self%move)
      if (allocated(self%low)) deallocate (self%low)
      if (allocated(self%high)) deallocate (self%high)
      call self%past%forget(size(self%pressure))
      call set_push(self, model, cycle)
      state%load_level = unset
   end subroutine start_passes

   !> A pass is done: do its apertures lead to the pressure that it had? Then rock may break, and else the step is over. If not,
   !> back to where the passes started, with a pressure nearer to that.
   subroutine end_pass(self, solver, model, stage, cycle, state, breaks, errors)
      type(fluid_coupling_t), intent(inout) :: self
      !> That found the rest
      type(implicit_solver_t), intent(inout) :: solver
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      !> What the rock asks for; filled: fluid gets into a crack
      type(breaks_t), intent(out) :: breaks
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: found(:), miss(:), step(:), inflow(:)
      real(wp) :: apart, scale, imbalance

      if (model%deck%flow%fluid_lag) then
         call end_front_pass(self, solver, model, stage, cycle, state, breaks, errors)
         return
      end if
      call take_apertures(self, model, self%start, state)
      call find_pressure(self, model, state, stage, found, inflow, imbalance, errors)
      if (errors%any()) return
      self%pass = self%pass + 1
      miss = found - self%pressure
      scale = max(maxval(abs(found)), maxval(abs(self%pressure)), tiny(scale))
      ! What is missed in each of many steps adds up
      if (model%deck%transient%line > 0) scale = max(maxval(abs(found - self%before%fluid%pressure)), least_change*scale)
      apart = maxval(abs(miss))/scale
      if (apart <= model%deck%flow%tolerance) then
         if (model%can_break) then
            call find_breaks(model, state, breaks)
            breaks%filled = breaks%filled .or. any(holds_fluid(model, state) .neqv. holds_fluid(model, self%start))
            if (breaks%any()) return
         end if
         state%fluid%pressure = self%pressure
         state%fluid%filled = merge(1, 0, holds_fluid(model, state))
         state%fluid%inflow = inflow
         state%fluid%imbalance = imbalance
         call end_step(self, model, stage, cycle, state, errors)
         return
      end if
      if (model%can_break) then
         ! One that was too high may not be so any more, where there is more than one rest
         if (sum(miss) > 0.0_wp .and. is_jump(self)) deallocate (self%high)
         if (sum(miss) > 0.0_wp) self%low = self%pressure
         if (sum(miss) < 0.0_wp) self%high = self%pressure
         if (is_jump(self) .and. sum(miss) < 0.0_wp) then
            ! No pressure agrees: rock softens by itself there, and goes on from where it has
            call find_breaks(model, state, breaks)
            breaks%filled = .true.
            return
         end if
      end if
      if (self%pass == model%deck%flow%max_passes) then
         call errors%add('stage '//quoted(model%deck%stage(stage)%name)//', cycle '//to_text(cycle)// &
                         ': pressure of the fluid and apertures do not agree after '//to_text(self%pass)// &
                         ' passes; the pressure still changes by '//to_text(100.0_wp*apart)// &
                         ' % of its largest change. Try more cycles, or a larger max_passes of &flow')
         return
      end if
      if (is_jump(self)) then
         self%pressure = self%high
      else if (self%pass > steady_passes .and. allocated(self%low) .and. allocated(self%high)) then
         self%pressure = 0.5_wp*(self%low + self%high)
      else
         allocate (step(size(miss)))
         call self%past%next_step(miss, step)
         call self%past%took(step)
         self%pressure = self%pressure + step
      end if
      call try_again(self, model, cycle, state)
   end subroutine end_pass

   !> Back to where the passes started, with another pressure.
   subroutine try_again(self, model, cycle, state)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: cycle
      type(state_t), intent(inout) :: state

      self%move = state%u - self%start%u
      call set_push(self, model, cycle)
      state = self%start
      state%load_level = unset
      if (self%settles) return
      state%guess%move = self%move
      state%guess%move_part = self%part(2) - self%part(1)
   end subroutine try_again

   !> A pass of fluid that may lag behind the tip of a crack: if pressures and apertures do not agree, back with others, or in
   !> half the time. Then rock may break, at these pressures, and fluid gets into what has broken from the next step on.
   subroutine end_front_pass(self, solver, model, stage, cycle, state, breaks, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(implicit_solver_t), intent(inout) :: solver
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(breaks_t), intent(out) :: breaks
      type(error_list_t), intent(inout) :: errors
      integer :: verdict

      if (.not. self%settles) then
         call take_apertures(self, model, self%start, state)
         self%pass = self%pass + 1
         call self%front%end_pass(solver, model, self%model, holds_fluid(model, self%start), self%before%fluid%content, &
                                  duration(self, model, stage), self%pass, state, self%pressure, verdict, errors)
         if (errors%any()) return
         if (verdict == pass_next) call try_again(self, model, cycle, state)
         if (verdict == pass_fails) call halve_step(self, model, stage, cycle, state, errors)
         if (verdict /= pass_agrees) return
      end if
      if (model%can_break) then
         call find_breaks(model, state, breaks)
         if (breaks%any()) return
      end if
      state%fluid%pressure = self%pressure
      state%fluid%filled = merge(1, 0, holds_fluid(model, state))
      state%fluid%content = self%front%content
      state%fluid%inflow = self%front%inflow
      state%fluid%imbalance = self%front%imbalance
      state%fluid%last = duration(self, model, stage)
      if (model%deck%transient%steps == 'adaptive') &
         state%fluid%wanted = min(model%deck%transient%step, front_growth*max(self%before%fluid%wanted, state%fluid%last))
      self%over = self%part(2) >= 1.0_wp
      if (.not. self%over) call start_step(self, model, stage, cycle, state, errors)
   end subroutine end_front_pass

   !> May a step that found no rest be tried in half the time?
   pure logical function may_be_halved(self, model)
      class(fluid_coupling_t), intent(in) :: self
      type(model_t), intent(in) :: model

      may_be_halved = model%deck%flow%fluid_lag .and. .not. self%settles
   end function may_be_halved

   !> Half a step of time from where the last one ended.
   subroutine halve_step(self, model, stage, cycle, state, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: try

      self%before%fluid%wanted = 0.5_wp*duration(self, model, stage)
      state = self%before
      self%part(2) = self%part(1)
      if (model%deck%transient%steps == 'fixed' .or. state%fluid%wanted < shortest_front*model%deck%transient%step) then
         try = 'smaller elements (steps so short ring), a larger tolerance or max_passes of &flow'
         if (model%deck%transient%steps == 'fixed') try = 'steps = ''adaptive'' of &transient'
         call errors%add('flow at '//to_text(state%time)//' s: pressures of the fluid and apertures do not agree in a step of '// &
                         to_text(2.0_wp*state%fluid%wanted)//' s; try '//try)
         return
      end if
      call start_step(self, model, stage, cycle, state, errors)
   end subroutine halve_step

   !> Is there next to nothing between a pressure that is too low and one that is too high?
   pure logical function is_jump(self)
      type(fluid_coupling_t), intent(in) :: self

      is_jump = self%pass > steady_passes .and. allocated(self%low) .and. allocated(self%high)
      if (is_jump) is_jump = maxval(abs(self%high - self%low)) <= jump*maxval(abs(self%high))
   end function is_jump

   !> A step is over: it is done again if it was too long, else the next one starts, or the cycle is over.
   subroutine end_step(self, model, stage, cycle, state, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp) :: error
      logical :: again

      again = .false.
      if (model%deck%transient%line > 0) call judge_step(model%deck, self%before, duration(self, model, stage), self%settles, &
                                                         state, error, again)
      if (again) then
         self%before%fluid%wanted = state%fluid%wanted
         state = self%before
         self%part(2) = self%part(1)
         if (state%fluid%wanted < shortest*model%deck%transient%step) then
            call errors%add('flow at '//to_text(state%time)//' s: no step is short enough for a tolerance of '// &
                            to_text(model%deck%transient%tolerance)//' of &transient; try a larger one, or steps = ''fixed''')
            return
         end if
      end if
      self%over = self%part(2) >= 1.0_wp
      if (.not. self%over) call start_step(self, model, stage, cycle, state, errors)
   end subroutine end_step

   !> Of a step [s].
   pure real(wp) function duration(self, model, stage)
      type(fluid_coupling_t), intent(in) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage

      duration = (self%part(2) - self%part(1))*model%deck%stage(stage)%move_time
   end function duration

   !> End of the next step as a part of the cycle: its end when flow is steady, else steps of equal length up to there.
   pure real(wp) function next_part(deck, state, duration, done) result(to)
      type(deck_t), intent(in) :: deck
      type(state_t), intent(in) :: state
      !> Of the cycle [s]
      real(wp), intent(in) :: duration
      !> Part of the cycle that is over
      real(wp), intent(in) :: done
      integer :: steps

      to = 1.0_wp
      if (deck%transient%line == 0) return
      steps = ceiling((1.0_wp - done)*duration/state%fluid%wanted - rounding)
      if (steps > 1) to = done + (1.0_wp - done)/real(steps, wp)
   end function next_part

   !> The error of a step, from how the rate of the pressure has changed since the last one, over the range of pressures, and
   !> what it says of the steps to come.
   pure subroutine judge_step(deck, start, step, once, state, error, again)
      type(deck_t), intent(in) :: deck
      type(state_t), intent(in) :: start
      !> Length [s]
      real(wp), intent(in) :: step
      !> Can it not be done again? (rock has broken)
      logical, intent(in) :: once
      !> At its end
      type(state_t), intent(inout) :: state
      !> Over the tolerance
      real(wp), intent(out) :: error
      !> Is it to be done again with a shorter one?
      logical, intent(out) :: again
      real(wp) :: range

      error = 0.0_wp
      range = max(state%fluid%range, maxval(abs(state%fluid%pressure - deck%transient%initial_pressure)), tiny(range))
      ! The first step has no rate before it: a sudden change is taken as it is
      if (start%fluid%last > 0.0_wp) &
         error = step/(step + start%fluid%last)*maxval(abs(state%fluid%pressure - start%fluid%pressure - step*start%fluid%rate)) &
                 /range/deck%transient%tolerance
      again = deck%transient%steps == 'adaptive' .and. error > 1.0_wp .and. .not. once
      if (again) then
         state%fluid%wanted = step*max(shortest_cut, caution/sqrt(error))
         return
      end if
      state%fluid%range = range
      state%fluid%rate = (state%fluid%pressure - start%fluid%pressure)/step
      state%fluid%last = step
      if (deck%transient%steps == 'adaptive') &
         state%fluid%wanted = max(state%fluid%wanted, step*min(longest_growth, caution/sqrt(max(error, tiny(error)))))
   end subroutine judge_step

   !> Build the flow model, and what the fluid remembers where there is nothing yet: the pressure before anything flows.
   subroutine start_coupling(self, model, state)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(state_t) :: unstrained
      logical :: searched

      call init_flow_domain(model%deck, model%whole, self%model)
      call start_storage(self%model, model%whole, model%solid, self%storage)
      self%started = .true.
      if (allocated(state%fluid%pressure)) then
         ! From a run whose fluid could not lag: all that conducts was full
         if (model%deck%flow%fluid_lag .and. .not. allocated(state%fluid%content)) call fill()
         return
      end if
      associate (nodes => size(model%whole%x, 2))
         allocate (state%fluid%rate(nodes), state%fluid%inflow(nodes), source=0.0_wp)
         allocate (state%fluid%pressure(nodes), source=0.0_wp)
      end associate
      state%fluid%filled = merge(1, 0, holds_fluid(model, state))
      if (model%deck%transient%line == 0) return
      ! Fractures are full of fluid before anything moves
      unstrained = state
      call find_forces(model, 0.0_wp, unstrained, searched)
      state%aperture = unstrained%aperture
      state%fluid%pressure = model%deck%transient%initial_pressure
      if (model%deck%flow%fluid_lag) call fill()

   contains

      !> All that conducts is full.
      subroutine fill()

         call take_apertures(self, model, state, state)
         state%fluid%content = find_capacity(self%model, state%fluid%pressure)
      end subroutine fill

   end subroutine start_coupling

   !> Loads that go from those of the fluid at the start of a step to those of the pressure tried at its end; those alone once rock
   !> has broken in it.
   subroutine set_push(self, model, cycle)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: cycle

      call fluid_loads(self, model, self%pressure, holds_fluid(model, self%start), self%push%to)
      if (self%settles) then
         self%push%from = self%push%to
      else
         call fluid_loads(self, model, self%before%fluid%pressure, self%before%fluid%filled > 0, self%push%from)
      end if
      self%push%level = (real(cycle - 1, wp) + self%part)/real(model%deck%stage(model%stage)%cycles, wp)
   end subroutine set_push

   !> What a pressure pushes with: walls and rock.
   subroutine fluid_loads(self, model, pressure, filled, force)
      type(fluid_coupling_t), intent(in) :: self
      type(model_t), intent(in) :: model
      !> (nodes of the mesh as read) [Pa]
      real(wp), intent(in) :: pressure(:)
      !> Is there fluid between the walls? (joints)
      logical, intent(in) :: filled(:)
      !> (2, nodes) [N per m of thickness]
      real(wp), allocatable, intent(out) :: force(:, :)
      real(wp) :: in_rock(size(model%split%triangle, 2)), in_crack(size(model%split%joint, 2))
      integer :: i

      do i = 1, size(in_rock)
         in_rock(i) = self%model%biot(i)*sum(pressure(model%whole%triangle(:, i)))/3.0_wp
      end do
      do i = 1, size(in_crack)
         in_crack(i) = 0.5_wp*sum(pressure(model%split%origin(model%split%joint(1:2, i))))
      end do
      allocate (force(2, size(model%split%x, 2)), source=0.0_wp)
      call press_rock(model%split, in_rock, force)
      call press_walls(model%split, in_rock, in_crack, filled, force)
   end subroutine fluid_loads

   !> The lines that conduct at the start of a pass, with the apertures of another state.
   subroutine take_apertures(self, model, start, state)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: start, state
      logical, allocatable :: filled(:)
      integer, allocatable :: line(:, :)

      call conducting_lines(model, start, line, filled)
      call set_lines(self%model, model%whole, line, model%split%joint_group, model%topology%edge_of_joint)
      call set_apertures(self%model, state%aperture, state%joint%ratio, &
                         mobilised_roughness(model%joints%law, state%joint%ratio, state%joint%sn), filled)
   end subroutine take_apertures

   !> Pressure that the apertures taken over lead to, 0 where no prescribed pressure is felt; with time, one step of the
   !> fixed-stress split from the pressure tried.
   subroutine find_pressure(self, model, state, stage, found, inflow, imbalance, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      integer, intent(in) :: stage
      !> (nodes of the mesh as read) [Pa]; what flows in at each of them [m2/s]
      real(wp), allocatable, intent(out) :: found(:), inflow(:)
      !> What is left of the inflows, over them [-]
      real(wp), intent(out) :: imbalance
      type(error_list_t), intent(inout) :: errors
      type(boundary_flow_t) :: flow

      if (model%deck%transient%line > 0) then
         call pressure_in_time(self%storage, self%model, model%split, state, duration(self, model, stage), self%pressure, found, &
                               inflow, imbalance, errors)
         return
      end if
      call solve_boundary_flow(self%model, flow, errors)
      imbalance = flow%field%imbalance
      if (errors%any()) return
      found = flow%field%pressure
      where (.not. flow%reached) found = 0.0_wp
      inflow = flow%field%inflow
   end subroutine find_pressure

   !> Joint elements as lines of the mesh as read, and whether they can conduct: fractures, and cracks that have broken.
   subroutine conducting_lines(model, state, line, filled)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> Nodes of the mesh as read (2, joints)
      integer, allocatable, intent(out) :: line(:, :)
      logical, allocatable, intent(out) :: filled(:)
      integer :: j

      allocate (line(2, size(model%split%joint, 2)))
      do j = 1, size(line, 2)
         line(:, j) = model%split%origin(model%split%joint(1:2, j))
      end do
      filled = holds_fluid(model, state)
   end subroutine conducting_lines

   !> Mobilised JRC of each joint [-]; 0 for laws that know no mobilisation.
   elemental real(wp) function mobilised_roughness(law, ratio, sn)
      type(law_item_t), intent(in) :: law
      !> Slip over peak slip [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      mobilised_roughness = law%raw%mobilised_roughness(ratio, sn)
   end function mobilised_roughness

end module fluid_coupling_m
