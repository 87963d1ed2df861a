!> What flow and stress say to each other. Apertures conduct; with coupling = 'two-way' the pressure found pushes the walls of the
!> fractures and, by Biot's coefficient, the rock, and a cycle is done again until pressure and apertures agree.
!>
!> Flow knows nothing of forces, the solver nothing of flow: a cycle sees nodal loads that go from those of the last pressure to
!> those of the new one. The signs are those of pore_pressure_m: stresses of the rock and of the joints are effective ones.
module fluid_coupling_m
   use kinds_m, only: wp
   use constants_m, only: unset
   use deck_m, only: deck_t
   use errors_m, only: error_list_t
   use flow_model_m, only: flow_model_t, boundary_flow_t, init_flow_model, set_moment, set_lines, set_apertures, solve_boundary_flow
   use joint_law_m, only: law_item_t
   use pore_pressure_m, only: press_rock, press_walls
   use loads_m, only: loads_t
   use model_m, only: model_t
   use state_m, only: state_t
   use text_m, only: to_text, quoted
   implicit none
   private

   public :: conducting_lines, mobilised_roughness, is_two_way, start_passes, end_pass

   !> Part of the new loads that is taken in the next pass: at first, least and most (Aitken's rule finds it in between)
   real(wp), parameter :: first_part = 1.0_wp, least_part = 0.05_wp, most_part = 2.0_wp

   !> What the coupling remembers from one cycle to the next
   type, public :: fluid_coupling_t
      private
      logical :: started = .false.
      type(flow_model_t) :: model
      !> Loads of the fluid at the end of the last cycle (2, nodes) [N per m of thickness]
      real(wp), allocatable :: force(:, :)
      !> Stage whose loads these are, without the fluid's, at its start and end (2, nodes) [N per m of thickness]
      integer :: stage = 0
      real(wp), allocatable :: dead_start(:, :), dead_end(:, :)
      !> What was added to the loads at the end of the last stage (2, nodes)
      real(wp), allocatable :: added(:, :)
      !> Loads of the stage such that those of the fluid go from one value to the other in this cycle
      type(loads_t), public :: loads
      !> State at the start of the cycle, passes since
      type(state_t) :: start
      integer :: pass = 0
      !> Loads of the fluid at the start of the cycle, those tried at its end, what was missed in the last pass (2, nodes), and
      !> the part of it that was taken
      real(wp), allocatable :: before(:, :), trial(:, :), last_miss(:, :)
      real(wp) :: part = first_part
   end type fluid_coupling_t

contains

   !> Does the pressure push back?
   pure logical function is_two_way(deck)
      type(deck_t), intent(in) :: deck

      is_two_way = deck%flow%line > 0 .and. deck%flow%coupling == 'two-way'
   end function is_two_way

   !> Start the passes of a cycle: each is a cycle of the solver with loads of the fluid, until these are what its apertures
   !> lead to.
   subroutine start_passes(self, model, stage, cycle, state, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors

      if (.not. self%started) call start_coupling(self, model, stage, cycle, state, errors)
      if (stage /= self%stage) call take_stage(self, model, stage)
      if (errors%any()) return
      self%start = state
      self%before = self%force
      self%last_miss = 0.0_wp*self%force
      self%pass = 0
      self%part = first_part
      call set_moment(self%model, stage, real(cycle, wp)/real(model%deck%stage(stage)%cycles, wp))
      call fluid_loads(self, model, state, self%trial, errors)
      if (errors%any()) return
      call set_loads(self, model, cycle)
      state%load_level = unset
   end subroutine start_passes

   !> A pass is done: do its apertures lead to the loads that it had? Else back to the start, with loads nearer to that.
   subroutine end_pass(self, model, stage, cycle, state, agreed, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(state_t), intent(inout) :: state
      logical, intent(out) :: agreed
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: found(:, :), miss(:, :)
      real(wp) :: apart

      agreed = .false.
      call fluid_loads(self, model, state, found, errors)
      if (errors%any()) return
      self%pass = self%pass + 1
      miss = found - self%trial
      apart = maxval(abs(miss))/max(maxval(abs(found)), maxval(abs(self%trial)), tiny(apart))
      self%force = self%trial
      agreed = apart <= model%deck%flow%tolerance
      if (agreed) return
      if (self%pass == model%deck%flow%max_passes) then
         call errors%add('stage '//quoted(model%deck%stage(stage)%name)//', cycle '//to_text(cycle)// &
                         ': pressure of the fluid and apertures do not agree after '//to_text(self%pass)// &
                         ' passes; the loads of the fluid still change by '//to_text(100.0_wp*apart)// &
                         ' % of the largest. Try more cycles, or a larger max_passes of &flow')
         return
      end if
      if (self%pass > 1) self%part = aitken(self%part, miss, self%last_miss)
      self%last_miss = miss
      self%trial = self%trial + self%part*miss
      call set_loads(self, model, cycle)
      state = self%start
      state%load_level = unset
   end subroutine end_pass

   !> The part of the miss to take next (Irons and Tuck 1969, Int J Numer Meth Eng 1:275).
   pure real(wp) function aitken(part, miss, last_miss)
      !> Part taken last; what was missed after it, and before (2, nodes)
      real(wp), intent(in) :: part, miss(:, :), last_miss(:, :)
      real(wp) :: change

      change = sum((miss - last_miss)**2)
      aitken = part
      if (change > 0.0_wp) aitken = -part*sum(last_miss*(miss - last_miss))/change
      aitken = min(max(aitken, least_part), most_part)
   end function aitken

   !> Build the flow model. A run that goes on from a checkpoint has the fluid's loads already.
   subroutine start_coupling(self, model, stage, cycle, state, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      !> Stage and cycle that begin
      integer, intent(in) :: stage, cycle
      type(state_t), intent(in) :: state
      type(error_list_t), intent(inout) :: errors

      call init_flow_model(model%deck, model%whole, self%model)
      allocate (self%force(2, size(model%split%x, 2)), self%added(2, size(model%split%x, 2)), source=0.0_wp)
      call set_moment(self%model, stage, real(cycle - 1, wp)/real(model%deck%stage(stage)%cycles, wp))
      if (state%step > 0) call fluid_loads(self, model, state, self%force, errors)
      self%started = .true.
   end subroutine start_coupling

   !> The loads of a new stage without the fluid's.
   subroutine take_stage(self, model, stage)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage

      self%dead_start = model%loads%dead_start - self%added
      self%dead_end = model%loads%dead_end
      self%stage = stage
   end subroutine take_stage

   !> Make the loads of the stage such that those of the fluid go to the ones tried in this cycle.
   subroutine set_loads(self, model, cycle)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: cycle
      real(wp) :: cycles

      ! Loads are linear in the level, which goes from (cycle - 1)/cycles to cycle/cycles
      cycles = real(model%deck%stage(self%stage)%cycles, wp)
      self%loads = model%loads
      associate (change => self%trial - self%before)
         self%loads%dead_start = self%dead_start + self%before - real(cycle - 1, wp)*change
         self%loads%dead_end = self%dead_end + self%before + (cycles - real(cycle - 1, wp))*change
      end associate
      self%loads%dead_changes = .true.
      self%added = self%trial
   end subroutine set_loads

   !> Loads of the fluid for the apertures of a state: the pressure they lead to pushes walls and rock.
   subroutine fluid_loads(self, model, state, force, errors)
      type(fluid_coupling_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> (2, nodes) [N per m of thickness]
      real(wp), allocatable, intent(inout) :: force(:, :)
      type(error_list_t), intent(inout) :: errors
      type(boundary_flow_t) :: flow
      logical, allocatable :: filled(:)
      integer, allocatable :: line(:, :)
      real(wp) :: in_rock(size(model%split%triangle, 2)), in_crack(size(model%split%joint, 2))
      real(wp), allocatable :: pressure(:)
      integer :: i

      call conducting_lines(model, state, line, filled)
      call set_lines(self%model, model%whole, line, model%split%joint_group, model%topology%edge_of_joint)
      call set_apertures(self%model, state%aperture, state%joint%ratio, &
                         mobilised_roughness(model%joints%law, state%joint%ratio, state%joint%sn), filled)
      call solve_boundary_flow(self%model, flow, errors)
      if (errors%any()) return
      ! Where no prescribed pressure is felt there is none
      pressure = flow%field%pressure
      where (.not. flow%reached) pressure = 0.0_wp
      do i = 1, size(in_rock)
         in_rock(i) = self%model%biot(i)*sum(pressure(model%whole%triangle(:, i)))/3.0_wp
      end do
      do i = 1, size(in_crack)
         in_crack(i) = 0.5_wp*sum(pressure(line(:, i)))
      end do
      if (.not. allocated(force)) allocate (force(2, size(model%split%x, 2)))
      force = 0.0_wp
      call press_rock(model%split, in_rock, force)
      call press_walls(model%split, in_rock, in_crack, filled, force)
   end subroutine fluid_loads

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
      allocate (filled(size(line, 2)), source=.true.)
      ! Bonds that hold do not conduct
      if (model%can_break) filled(model%bonds%fractures + 1:) = state%bonds%broken
   end subroutine conducting_lines

   !> Mobilised JRC of each joint [-]; 0 for laws that know no mobilisation.
   elemental real(wp) function mobilised_roughness(law, ratio, sn)
      type(law_item_t), intent(in) :: law
      !> Slip over peak slip [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      mobilised_roughness = law%raw%mobilised_roughness(ratio, sn)
   end function mobilised_roughness

end module fluid_coupling_m
