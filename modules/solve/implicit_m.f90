!> Implicit quasi-static solver: one load increment of a stage after the other, each brought to equilibrium by Newton's
!> method.
!>
!> A cycle is a load increment: prescribed velocities times the move time are its prescribed displacements, loads go to
!> their value at the cycle's end. Every iteration starts from the joints as they were at the start of the increment, so
!> that an increment is one step of the joint law, however many iterations it takes. The matrix is kept as long as
!> iterations converge with it (anderson_m), and made anew when they don't.
module implicit_m
   use kinds_m, only: wp, i8
   use constants_m, only: unset
   use errors_m, only: error_list_t
   use text_m, only: to_text
   use log_m, only: log_t, progress_t
   use implicit_group_m, only: implicit_t
   use scene_m, only: scene_t
   use state_m, only: state_t
   use solid_m, only: solid_forces
   use solid_tangent_m, only: triangle_tangent
   use wall_contact_m, only: find_overlaps, add_wall_forces
   use joints_m, only: couple_walls
   use wall_tangent_m, only: wall_element_t, wall_tangent, points_of_walls
   use loads_m, only: nodal_loads
   use motion_m, only: unbalanced_ratio
   use sparse_system_m, only: sparse_system_t, build_system, add_block, gather, scatter
   use mumps_m, only: sparse_lu_t, linear_ok, linear_singular
   use anderson_m, only: anderson_t
   use support_m, only: find_loose
   use contact_m, only: contact_energy_t
   use explicit_m, only: cycle_report_t, fraction_done
   use increment_m, only: increment_t, joints_from_start, keep_unmoved, account_increment
   implicit none
   private

   public :: implicit_cycle

   !> What the solver remembers from one cycle to the next
   type, public :: implicit_solver_t
      private
      type(sparse_system_t) :: system
      type(sparse_lu_t) :: lu
      type(anderson_t) :: past
      !> Stage the system was laid out for (0: none); does the matrix belong to it?
      integer :: stage = 0
      logical :: factored = .false.
      !> Are there bodies that only weak springs hold? Has contact of other surfaces been warned of?
      logical :: weak_springs = .false., warned = .false.
      !> Part of a cycle's increment to try next
      real(wp) :: part = 1.0_wp
      !> Displacement of the last increment (2, nodes) [m], and what part of a cycle it was (0: none to go by)
      real(wp), allocatable :: move(:, :)
      real(wp) :: move_part = 0.0_wp
      !> Diagonal of the last matrix (unknowns) [N/m]
      real(wp), allocatable :: diagonal(:)
      !> Work done so far
      integer(i8), public :: iterations = 0_i8, factorisations = 0_i8, patterns = 0_i8
   contains
      procedure :: close => close_solver
   end type implicit_solver_t

   !> One increment, and what the iteration needs to know of it
   type, extends(increment_t) :: newton_increment_t
      !> Surface edges that the walls faced at its start (walls)
      integer, allocatable :: facing(:)
      !> Longest correction of one iteration [m]
      real(wp) :: longest = huge(1.0_wp)
   end type newton_increment_t

   !> An iteration with a kept matrix must reduce the unbalanced force to this share, or the matrix is made anew
   real(wp), parameter :: good_reduction = 0.3_wp
   !> Least share by which a step of length 1 must reduce the unbalanced force
   real(wp), parameter :: sufficient = 1.0e-4_wp
   !> A correction may move a node this many joint lengths (plus what the increment prescribes)
   real(wp), parameter :: longest_correction = 0.5_wp
   !> An increment that took no more iterations than this is followed by a longer one
   integer, parameter :: easy = 12
   !> A first guess with a greater unbalanced force ratio than this is compared with standing still
   real(wp), parameter :: near = 0.1_wp
   !> Rounding of the forces: this many times the machine's precision
   real(wp), parameter :: rounding = 4.0_wp*epsilon(1.0_wp)
   !> Weak springs over the stiffness of the rock
   real(wp), parameter :: weak = 1.0e-8_wp
   !> Contact of other surfaces may carry this share of all forces before the answer is refused
   real(wp), parameter :: negligible = 1.0e-2_wp
   !> Dilation that pushes the walls is found together with the pressure [mm]
   real(wp), parameter :: dilation_tolerance = 1.0e-13_wp
   integer, parameter :: dilation_iterations = 30

contains

   !> One cycle of a stage, in as many increments as it needs. On failure errors says when, where and what.
   subroutine implicit_cycle(self, scene, stage, cycle, log, progress, state, report, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      !> Stage and cycle, from 1
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(progress_t), intent(inout) :: progress
      type(state_t), intent(inout) :: state
      type(cycle_report_t), intent(out) :: report
      type(error_list_t), intent(inout) :: errors
      type(newton_increment_t) :: increment
      real(wp) :: done, part
      integer :: iterations
      logical :: converged

      if (stage /= self%stage) call prepare_stage(self, scene, stage, cycle, log, state, errors)
      if (errors%any()) return
      done = 0.0_wp
      do while (done < 1.0_wp)
         part = min(self%part, 1.0_wp - done)
         increment%start = state
         increment%facing = scene%walls%facing
         increment%level = (real(cycle - 1, wp) + min(1.0_wp, done + part))/real(scene%deck%stage(stage)%cycles, wp)
         call first_guess(self, scene, stage, part, increment, state)
         call equilibrate(self, scene, increment, state, iterations, converged)
         self%iterations = self%iterations + int(iterations, i8)
         if (converged) then
            call account_increment(scene, increment%start, state)
            self%move = state%u - increment%start%u
            self%move_part = part
            done = done + part
            if (1.0_wp - done < 0.5_wp**(scene%deck%implicit%largest_cut + 1)) done = 1.0_wp
            state%time = state%time + part*scene%deck%stage(stage)%move_time
            state%step = state%step + 1_i8
            report%steps = report%steps + 1_i8
            report%smallest_step = min(report%smallest_step, part*scene%deck%stage(stage)%move_time)
            if (iterations <= easy) self%part = min(1.0_wp, 2.0_wp*self%part)
            call progress%tick(log, fraction_done(scene, stage, cycle, .true., done))
         else
            call give_up_increment(self, scene, increment, state)
            if (self%part < 0.5_wp**scene%deck%implicit%largest_cut) then
               call report_failure(scene, stage, cycle, increment, state, errors)
               return
            end if
         end if
      end do
      if (scene%has_contact) call check_other_contact(self, scene, stage, log, state, errors)
      state%time = state%time + max(0.0_wp, scene%deck%stage(stage)%rest_time)
      report%unbalanced = unbalanced_ratio(scene%loads, state)
   end subroutine implicit_cycle

   !> A new stage prescribes other displacements: other unknowns, another pattern, nothing to extrapolate from.
   subroutine prepare_stage(self, scene, stage, cycle, log, state, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      integer, intent(in) :: stage, cycle
      type(log_t), intent(in) :: log
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      type(newton_increment_t) :: increment

      call check_support(self, scene, stage, log, errors)
      if (errors%any()) return
      self%stage = stage
      self%part = 1.0_wp
      self%move_part = 0.0_wp
      self%move = 0.0_wp*state%u
      state%v = 0.0_wp
      ! The forces of the start are needed for the energy account
      increment%start = state
      increment%facing = scene%walls%facing
      increment%level = real(cycle - 1, wp)/real(scene%deck%stage(stage)%cycles, wp)
      call evaluate(scene, increment, state)
      call lay_out(self, scene, state)
   end subroutine prepare_stage

   !> Find what nothing holds: refuse it, or hold it by weak springs in the matrix alone, which carry no force.
   subroutine check_support(self, scene, stage, log, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: stage
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: loose(:)
      character(len=:), allocatable :: what
      integer :: i

      call find_loose(scene%split%x, scene%split%triangle, scene%split%joint(:, scene%walls%joint), &
                      scene%loads%fixed, loose)
      self%weak_springs = size(loose) > 0
      do i = 1, size(loose)
         what = 'stage '''//trim(scene%deck%stage(stage)%name)//''': nothing holds the rock around x = '// &
                to_text(scene%split%x(1, loose(i)))//', y = '//to_text(scene%split%x(2, loose(i)))
         if (scene%deck%implicit%loose_bodies == 'hold') then
            call log%warn(what//'; its loads must be in balance')
         else
            call errors%add(what//' against sliding or turning as a whole, and an implicit solver finds no equilibrium '// &
                            'there; prescribe displacements (&boundary vx, vy = 0), set &implicit loose_bodies = ''hold'' '// &
                            'if its loads are in balance, or use solver = ''explicit''')
         end if
      end do
   end subroutine check_support

   !> Number the unknowns and lay out the matrix for where the walls are now.
   subroutine lay_out(self, scene, state)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(in) :: state
      integer :: status

      call find_overlaps(scene%walls, scene%split%x, state%u)
      call build_system(scene%loads%fixed, scene%split%triangle, scene%joints, scene%walls, self%system)
      call self%lu%analyse(self%system%unknowns, self%system%row, self%system%column, status)
      self%factored = .false.
      self%patterns = self%patterns + 1_i8
      call self%past%forget(self%system%unknowns)
   end subroutine lay_out

   !> First guess of an increment: prescribed displacements in full, the others as in the last increment or, where that
   !> is far off and worse, as they are.
   subroutine first_guess(self, scene, stage, part, increment, state)
      type(implicit_solver_t), intent(in) :: self
      type(scene_t), intent(inout) :: scene
      integer, intent(in) :: stage
      !> Part of the cycle
      real(wp), intent(in) :: part
      type(newton_increment_t), intent(inout) :: increment
      type(state_t), intent(inout) :: state
      real(wp) :: duration, unbalanced

      duration = part*scene%deck%stage(stage)%move_time
      increment%longest = huge(1.0_wp)
      if (size(scene%joints%length) > 0) increment%longest = longest_correction*minval(scene%joints%length) &
                                                             + duration*maxval(abs(scene%loads%velocity))
      where (scene%loads%fixed) state%u = state%u + duration*scene%loads%velocity
      if (self%move_part > 0.0_wp) then
         where (.not. scene%loads%fixed) state%u = state%u + part/self%move_part*self%move
      end if
      call evaluate(scene, increment, state)
      unbalanced = free_norm(scene, state)
      if (self%move_part <= 0.0_wp .or. unbalanced_ratio(scene%loads, state) <= near) return
      where (.not. scene%loads%fixed) state%u = increment%start%u
      call evaluate(scene, increment, state)
      if (free_norm(scene, state) <= unbalanced) return
      where (.not. scene%loads%fixed) state%u = state%u + part/self%move_part*self%move
      call evaluate(scene, increment, state)
   end subroutine first_guess

   !> Norm of the unbalanced forces [N per m of thickness].
   pure real(wp) function free_norm(scene, state)
      type(scene_t), intent(in) :: scene
      type(state_t), intent(in) :: state

      free_norm = norm2(pack(net_force(state),.not. scene%loads%fixed))
   end function free_norm

   !> Newton's method from the first guess in state%u, whose forces are known.
   subroutine equilibrate(self, scene, increment, state, iterations, converged)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      integer, intent(out) :: iterations
      logical, intent(out) :: converged
      real(wp) :: residual(self%system%unknowns), step(self%system%unknowns), unbalanced, before
      logical :: fresh, slow, regular

      converged = .false.
      slow = scene%deck%implicit%matrix == 'new'
      call self%past%forget(self%system%unknowns)
      call gather(self%system, net_force(state), residual)
      unbalanced = norm2(residual)
      do iterations = 0, scene%deck%implicit%max_iterations
         if (unbalanced_ratio(scene%loads, state) <= scene%deck%implicit%tolerance) then
            converged = .true.
            return
         end if
         fresh = slow .or. .not. self%factored
         if (fresh) then
            call renew_matrix(self, scene, increment%level, state, residual, regular)
            if (.not. regular) return
         end if
         call correction(self, residual, increment%longest, step, regular)
         if (.not. regular) return
         before = unbalanced
         call search_line(self, scene, increment, step, fresh, state, residual, unbalanced)
         if (unbalanced < before) then
            call self%past%took(step)
            slow = unbalanced > good_reduction*before
         else if (fresh) then
            ! As good as rounding allows?
            converged = unbalanced <= rounding*norm2(self%diagonal*displacement(self, state))
            return
         else
            slow = .true.
         end if
         if (scene%deck%implicit%matrix == 'new') slow = .true.
      end do
   end subroutine equilibrate

   !> Step of an iteration: the matrix' answer to the unbalanced force, with what earlier iterations taught.
   subroutine correction(self, residual, longest, step, regular)
      type(implicit_solver_t), intent(inout) :: self
      !> Unbalanced force (unknowns) [N/m]
      real(wp), intent(in) :: residual(:)
      !> Longest correction [m]
      real(wp), intent(in) :: longest
      real(wp), intent(out) :: step(:)
      logical, intent(out) :: regular
      real(wp) :: answer(size(residual)), largest
      integer :: status

      answer = residual
      call self%lu%solve(answer, status)
      regular = status == linear_ok .and. all(abs(answer) < huge(1.0_wp))
      if (.not. regular) return
      call self%past%next_step(answer, step)
      largest = maxval(abs(step))
      if (largest > longest) step = step*(longest/largest)
   end subroutine correction

   !> Take the step, or the longest half, quarter, ... of it that reduces the unbalanced force. A kept matrix gets one
   !> try. Without success the state is where it was.
   subroutine search_line(self, scene, increment, step, fresh, state, residual, unbalanced)
      type(implicit_solver_t), intent(in) :: self
      type(scene_t), intent(inout) :: scene
      type(newton_increment_t), intent(in) :: increment
      !> Step in, the part of it that was taken out (unknowns) [m]
      real(wp), intent(inout) :: step(:)
      !> Does the matrix belong to this state?
      logical, intent(in) :: fresh
      type(state_t), intent(inout) :: state
      !> Unbalanced force (unknowns) [N/m] and its norm, at the state
      real(wp), intent(inout) :: residual(:), unbalanced
      real(wp) :: origin(2, size(state%u, 2)), share, before
      integer :: halvings, most

      origin = state%u
      before = unbalanced
      share = 1.0_wp
      most = merge(scene%deck%implicit%line_search, 0, fresh)
      do halvings = 0, most
         state%u = origin
         call scatter(self%system, share, step, state%u)
         call evaluate(scene, increment, state)
         call gather(self%system, net_force(state), residual)
         unbalanced = norm2(residual)
         ! A comparison with NaN is false
         if (unbalanced <= (1.0_wp - sufficient*share)*before) then
            step = share*step
            return
         end if
         share = 0.5_wp*share
      end do
      state%u = origin
      call evaluate(scene, increment, state)
      call gather(self%system, net_force(state), residual)
      unbalanced = norm2(residual)
   end subroutine search_line

   !> Assemble and factor the matrix of the present state, on a new pattern where walls have slid out of the old one.
   subroutine renew_matrix(self, scene, increment_level, state, residual, regular)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      !> Loads, 0 to 1 over the stage
      real(wp), intent(in) :: increment_level
      type(state_t), intent(in) :: state
      !> Unbalanced force (unknowns)
      real(wp), intent(in) :: residual(:)
      logical, intent(out) :: regular
      integer :: status
      logical :: outside

      call assemble(scene, increment_level, state, self%system, outside)
      if (outside) then
         call lay_out(self, scene, state)
         call assemble(scene, increment_level, state, self%system, outside)
      end if
      self%diagonal = diagonal_of(self%system)
      if (self%weak_springs) then
         where (self%system%row == self%system%column) self%system%value = (1.0_wp + weak)*self%system%value
      end if
      call self%lu%factor(self%system%value, status)
      self%factorisations = self%factorisations + 1_i8
      regular = status == linear_ok .and. .not. outside .and. size(residual) == self%system%unknowns
      self%factored = regular
      call self%past%forget(self%system%unknowns)
   end subroutine renew_matrix

   !> Tangent stiffness of rock, walls and follower pressure.
   subroutine assemble(scene, level, state, system, outside)
      type(scene_t), intent(in) :: scene
      !> Loads, 0 to 1 over the stage
      real(wp), intent(in) :: level
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      !> Is the pattern too small?
      logical, intent(out) :: outside
      type(wall_element_t) :: element
      real(wp) :: stiffness(36)
      integer :: first(size(scene%walls%joint) + 1), e, w, i

      outside = .false.
      system%value = 0.0_wp
      do e = 1, size(scene%solid%node, 2)
         stiffness = reshape(triangle_tangent(scene%solid, e, state%u(:, scene%solid%node(:, e))), [36])
         do i = 1, 36
            associate (entry => system%triangle_entry(i, e))
               if (entry > 0) system%value(entry) = system%value(entry) + stiffness(i)
            end associate
         end do
      end do
      do e = 1, size(scene%loads%pressure_surface)
         call add_block(system, scene%loads%pressure_edge(:, e), pressure_stiffness(scene, e, level), outside)
      end do
      if (.not. scene%has_walls) return
      call points_of_walls(scene%walls, first)
      do w = 1, size(scene%walls%joint)
         call wall_tangent(scene%joints, scene%walls, w, first(w), first(w + 1) - 1, scene%split%x, state%u, &
                           state%joint(scene%walls%joint(w)), element)
         call add_block(system, element%node(:element%nodes), element%stiffness, outside)
      end do
   end subroutine assemble

   !> Stiffness of a follower pressure, which turns and lengthens with its edge: minus the derivative of its nodal forces.
   pure function pressure_stiffness(scene, e, level) result(stiffness)
      type(scene_t), intent(in) :: scene
      !> Loaded edge
      integer, intent(in) :: e
      real(wp), intent(in) :: level
      !> Components x, y of the edge's start and end (4, 4) [N/m per m of thickness]
      real(wp) :: stiffness(4, 4)
      real(wp) :: half

      associate (start => scene%loads%pressure_start(e), finish => scene%loads%pressure_end(e))
         half = 0.5_wp*(start + level*(finish - start))
      end associate
      ! Each end is pushed by half*[-along_y, along_x], along = end - start
      stiffness = 0.0_wp
      stiffness([1, 3], 2) = -half
      stiffness([2, 4], 1) = half
      stiffness([1, 3], 4) = half
      stiffness([2, 4], 3) = -half
   end function pressure_stiffness

   !> Diagonal of the matrix.
   pure function diagonal_of(system) result(diagonal)
      type(sparse_system_t), intent(in) :: system
      real(wp) :: diagonal(system%unknowns)
      integer :: k

      diagonal = 0.0_wp
      do k = 1, size(system%value)
         if (system%row(k) == system%column(k)) diagonal(system%row(k)) = system%value(k)
      end do
   end function diagonal_of

   !> Displacements that are unknown (unknowns) [m].
   pure function displacement(self, state) result(vector)
      type(implicit_solver_t), intent(in) :: self
      type(state_t), intent(in) :: state
      real(wp) :: vector(self%system%unknowns)

      call gather(self%system, state%u, vector)
   end function displacement

   !> Forces and joints at the displacement state%u, the joints updated from the start of the increment in one step.
   subroutine evaluate(scene, increment, state)
      type(scene_t), intent(inout) :: scene
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      real(wp) :: guess(size(state%joint))
      integer :: i

      call nodal_loads(scene%loads, scene%split%x, state%u, increment%level, state%load)
      state%solid = 0.0_wp
      call solid_forces(scene%solid, state%u, state%solid)
      if (.not. scene%has_walls) return
      ! Walls walk to what they face now from where they were, not from where the last iteration took them
      scene%walls%facing = increment%facing
      call find_overlaps(scene%walls, scene%split%x, state%u)
      if (any(scene%joints%coupled)) then
         ! The pressure depends on the dilation, and that a little on the pressure
         guess = state%joint%dilation
         do i = 1, dilation_iterations
            call update_joints(scene, increment, guess, state)
            if (all(abs(state%joint%dilation - guess) <= dilation_tolerance .or. .not. scene%joints%coupled)) exit
            guess = state%joint%dilation
         end do
      else
         call update_joints(scene, increment, increment%start%joint%dilation, state)
      end if
      state%normal = 0.0_wp
      state%friction = 0.0_wp
      call add_wall_forces(scene%walls, scene%joints%pressure, scene%joints%shear, state%normal, state%friction)
   end subroutine evaluate

   !> Joints and tractions of the walls for a guess of the dilation that pushes them.
   subroutine update_joints(scene, increment, dilation, state)
      type(scene_t), intent(inout) :: scene
      type(newton_increment_t), intent(in) :: increment
      !> (joints) [mm]
      real(wp), intent(in) :: dilation(:)
      type(state_t), intent(inout) :: state

      call joints_from_start(increment%start%joint, dilation, state%joint)
      call couple_walls(scene%joints, scene%walls, scene%solid, scene%split%x, state%u, state%v, state%joint, &
                        state%opening, state%aperture)
      call keep_unmoved(increment%start%joint, state%joint)
   end subroutine update_joints

   !> Sum of all nodal forces (2, nodes) [N per m of thickness].
   pure function net_force(state) result(force)
      type(state_t), intent(in) :: state
      real(wp) :: force(2, size(state%u, 2))

      force = state%solid + state%normal + state%friction + state%load
   end function net_force

   !> Do surfaces that are no fracture walls press on each other? That contact is not in the equations.
   subroutine check_other_contact(self, scene, stage, log, state, errors)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      integer, intent(in) :: stage
      type(log_t), intent(in) :: log
      type(state_t), intent(in) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp) :: push(2, size(state%u, 2)), rub(2, size(state%u, 2)), share
      type(contact_energy_t) :: energy
      character(len=:), allocatable :: what
      integer :: node

      if (scene%contact%needs_search(state%u)) call scene%contact%search(scene%split, state%u)
      push = 0.0_wp
      rub = 0.0_wp
      call scene%contact%forces(scene%split, state%u, state%v, scene%friction, push, rub, energy)
      share = norm2(push)
      if (share <= 0.0_wp) return
      share = share/norm2([norm2(state%normal), norm2(state%friction), norm2(state%load), share])
      node = maxloc(push(1, :)**2 + push(2, :)**2, dim=1)
      what = 'surfaces that are not the two walls of a fracture overlap in stage '''// &
             trim(scene%deck%stage(stage)%name)//''', most near x = '//to_text(scene%split%x(1, node))//', y = '// &
             to_text(scene%split%x(2, node))//': their contact would be '//to_text(100.0_wp*share)//' % of all forces'
      if (share > negligible) then
         call errors%add(what//', which the implicit solver leaves out; use solver = ''explicit'', or &contact '// &
                         'active = .false. if this does not matter')
      else if (.not. self%warned) then
         call log%warn(what//'; it is left out')
         self%warned = .true.
      end if
   end subroutine check_other_contact

   !> Back to the start of the increment; try half of it next.
   subroutine give_up_increment(self, scene, increment, state)
      type(implicit_solver_t), intent(inout) :: self
      type(scene_t), intent(inout) :: scene
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state

      state = increment%start
      scene%walls%facing = increment%facing
      ! The loads are no longer those of the last call
      scene%loads%level_then = unset
      self%factored = .false.
      self%part = 0.5_wp*self%part
   end subroutine give_up_increment

   subroutine report_failure(scene, stage, cycle, increment, state, errors)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: stage, cycle
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(error_list_t), intent(inout) :: errors

      call errors%add('no equilibrium found at time '//to_text(state%time)//' s (stage '''// &
                      trim(scene%deck%stage(stage)%name)//''', cycle '//to_text(cycle)//', load level '// &
                      to_text(increment%level)//') though the increment was halved '// &
                      to_text(scene%deck%implicit%largest_cut)//' times; try more cycles, a larger &implicit '// &
                      'largest_cut, or solver = ''explicit'' where blocks come loose or the load exceeds what holds them')
   end subroutine report_failure

   !> Say what it took and give back the memory of the matrix.
   subroutine close_solver(self, log)
      class(implicit_solver_t), intent(inout) :: self
      type(log_t), intent(in) :: log

      if (self%stage > 0) call log%say('implicit  '//to_text(self%system%unknowns)//' unknowns in the last stage; '// &
                                       to_text(self%iterations)//' iterations, '//to_text(self%factorisations)// &
                                       ' factorisations, '//to_text(self%patterns)//' patterns')
      call self%lu%free()
   end subroutine close_solver

end module implicit_m
