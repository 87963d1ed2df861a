!> Newton's method for one increment of the implicit solver: the forces of a trial displacement, their tangent, and the
!> iteration between them.
!>
!> Every trial starts from joints and bonds as they were at the start of the increment, so that an increment is one step of
!> every law, however many iterations it takes. The matrix is kept as long as iterations converge with it (anderson_m), and
!> made anew when they don't.
module newton_m
   use kinds_m, only: wp, i8
   use stopwatch_m, only: now_doing, work_analysis, work_assembly, work_factors, work_solves, work_other
   use model_m, only: model_t
   use state_m, only: state_t
   use wall_contact_m, only: meet_walls
   use joint_border_m, only: begin_tangents
   use forces_m, only: net_force
   use motion_m, only: unbalanced_ratio
   use sparse_system_m, only: sparse_system_t, node_groups_t, kept_matrix_t, restore_system, build_system, gather, scatter
   use elimination_m, only: dissection, large
   use sparse_lu_m, only: sparse_lu_t, linear_ok, linear_failed
   use anderson_m, only: anderson_t
   use lagged_m, only: solve_lagged
   use softening_m, only: softening_t
   use increment_m, only: increment_t, begin_increment, forces_from_start
   implicit none
   private

   public :: start_increment_at, lay_out, lay_out_as_kept, equilibrate, evaluate, free_norm, renew_matrix, factor_matrix

   !> What Newton's method remembers from one increment to the next
   type, public :: newton_t
      type(sparse_system_t) :: system
      type(sparse_lu_t) :: lu
      type(anderson_t) :: past
      !> Are there factors for the present pattern, and do they belong to a state that has been left?
      logical :: factored = .false., outdated = .false.
      !> What the linear solver failed of: no iteration can go on
      character(len=:), allocatable :: failure
      !> Are there bodies that only weak springs hold?
      logical :: weak_springs = .false.
      !> Diagonal of the last matrix (unknowns) [N/m]
      real(wp), allocatable :: diagonal(:)
      !> Work done so far
      integer(i8) :: iterations = 0_i8, factorisations = 0_i8, patterns = 0_i8
      !> Iterations that took the present matrix with older factors, and the steps of these solutions
      integer(i8) :: lagged = 0_i8, lagged_steps = 0_i8
   end type newton_t

   !> One increment, and what the iteration needs to know of it
   type, public, extends(increment_t) :: newton_increment_t
      !> Longest correction of one iteration [m]
      real(wp) :: longest = huge(1.0_wp)
      !> Softening of bonds in the matrix from the start on? For steps of pseudo-time
      logical :: softens = .false.
      !> Times that a correction is halved at the most, if not less by the deck: where there is another way, searching costs more
      integer :: halvings = huge(1)
   end type newton_increment_t

   !> An iteration with a kept matrix must reduce the unbalanced force to this share, or the matrix is made anew
   real(wp), parameter :: good_reduction = 0.3_wp
   !> Least share by which a step of length 1 must reduce the unbalanced force
   real(wp), parameter :: sufficient = 1.0e-4_wp
   !> A correction may move a node this many joint lengths (plus what the increment prescribes)
   real(wp), parameter :: longest_correction = 0.5_wp
   !> Solutions with older factors: their tolerance, and the steps after which a factorisation costs less
   real(wp), parameter :: lagged_tolerance = 0.1_wp
   integer, parameter :: most_lagged = 5
   !> Unbalanced force ratio above which closure is taken by tangents, and below which no longer
   real(wp), parameter :: far = 1.0e-3_wp, near = 1.0e-4_wp
   !> With tangents the unbalanced force may rise by this factor, so many times: it is small walls and corners that have met
   real(wp), parameter :: highest_rise = 20.0_wp
   integer, parameter :: most_rises = 4
   !> Where the force rises: most work that a step may leave along it where corners can be hit, over what there was, and share at
   !> which its least is near
   real(wp), parameter :: most_work = 3.0_wp, least_work = 0.5_wp
   !> Rounding of the forces: this many times the machine's precision
   real(wp), parameter :: rounding = 4.0_wp*epsilon(1.0_wp)
   !> Weak springs over the stiffness of the rock
   real(wp), parameter :: weak = 1.0e-8_wp

contains

   !> An increment that starts from the present state and goes to a load level.
   subroutine start_increment_at(model, level, duration, state, increment)
      type(model_t), intent(in) :: model
      !> Loads at its end, 0 to 1 over the stage
      real(wp), intent(in) :: level
      !> Time that prescribed velocities act [s]
      real(wp), intent(in) :: duration
      type(state_t), intent(in) :: state
      type(newton_increment_t), intent(out) :: increment

      call begin_increment(level, state, increment)
      if (size(model%joints%length) > 0) increment%longest = longest_correction*minval(model%joints%length) &
                                                             + duration*maxval(abs(model%loads%velocity))
   end subroutine start_increment_at

   !> Number the unknowns and lay out the matrix for where the walls are now.
   subroutine lay_out(self, model, state)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(node_groups_t) :: groups
      integer :: i

      call meet_walls(model%walls, model%split%x, state%u, state%walls)
      do i = 1, size(model%term)
         if (model%term(i)%raw%is_there(model)) call model%term(i)%raw%join_nodes(model, state, groups)
      end do
      call build_system(model%loads%fixed, model%split%triangle, groups, self%system)
      call plan_factors(self, model)
      self%patterns = self%patterns + 1_i8
      call self%past%forget(self%system%unknowns)
   end subroutine lay_out

   !> Go on with the matrix of a checkpoint: as if there had been none, to the last bit.
   subroutine lay_out_as_kept(self, model, matrix)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(kept_matrix_t), intent(in) :: matrix

      call restore_system(model%loads%fixed, model%split%triangle, matrix, self%system)
      call plan_factors(self, model)
      call self%past%forget(self%system%unknowns)
      if (size(matrix%value) == 0 .or. allocated(self%failure)) return
      self%diagonal = diagonal_of(self%system)
      if (self%weak_springs) self%diagonal = self%diagonal/(1.0_wp + weak)
      call factor_matrix(self)
      self%outdated = matrix%outdated
   end subroutine lay_out_as_kept

   !> Order the unknowns of the system and plan its factors.
   subroutine plan_factors(self, model)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      integer, allocatable :: place(:)
      integer :: status

      call now_doing(work_analysis)
      self%lu%max_memory = model%deck%implicit%max_memory
      allocate (place(0))
      if (self%system%unknowns >= large) place = dissection(self%system)
      if (size(place) > 0) then
         call self%lu%analyse(self%system%unknowns, self%system%row, self%system%column, status, place)
      else
         call self%lu%analyse(self%system%unknowns, self%system%row, self%system%column, status)
      end if
      ! Where everything is prescribed there is nothing to solve for
      if (status == linear_failed .and. self%system%unknowns > 0) self%failure = self%lu%message()
      self%factored = .false.
      self%outdated = .false.
      call now_doing(work_other)
   end subroutine plan_factors

   !> Norm of the unbalanced forces [N per m of thickness].
   pure real(wp) function free_norm(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state

      free_norm = norm2(pack(net_force(state),.not. model%loads%fixed))
   end function free_norm

   !> Rest from the first guess in state%u, whose forces are known: by tangents of the closure curves at first where that is far,
   !> and where they do not lead to it by the curves alone, from the better one of where they led and the guess.
   subroutine equilibrate(self, model, increment, tolerance, state, iterations, converged)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      !> Unbalanced force ratio
      real(wp), intent(in) :: tolerance
      type(state_t), intent(inout) :: state
      integer, intent(out) :: iterations
      logical, intent(out) :: converged
      real(wp) :: guess(2, size(state%u, 2)), unbalanced
      integer :: more
      logical :: by_tangents

      guess = state%u
      unbalanced = free_norm(model, state)
      by_tangents = model%has_walls .and. increment%drag <= 0.0_wp
      call iterate(self, model, increment, tolerance, by_tangents, state, iterations, converged)
      if (converged .or. .not. by_tangents .or. allocated(self%failure)) return
      call evaluate(model, increment, state)
      if (free_norm(model, state) >= unbalanced) then
         state%u = guess
         call evaluate(model, increment, state)
      end if
      by_tangents = .false.
      call iterate(self, model, increment, tolerance, by_tangents, state, more, converged)
      iterations = iterations + more
   end subroutine equilibrate

   !> Newton's method.
   subroutine iterate(self, model, increment, tolerance, by_tangents, state, iterations, converged)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      !> Unbalanced force ratio
      real(wp), intent(in) :: tolerance
      !> May closure be taken by tangents? Has it been?
      logical, intent(inout) :: by_tangents
      type(state_t), intent(inout) :: state
      integer, intent(out) :: iterations
      logical, intent(out) :: converged
      real(wp) :: residual(self%system%unknowns), step(self%system%unknowns), unbalanced, before, bound, left
      type(softening_t) :: softening
      logical :: fresh, slow, regular, whole, taken, may
      integer :: rises

      converged = .false.
      may = by_tangents
      by_tangents = .false.
      rises = 0
      slow = model%deck%implicit%matrix == 'new'
      softening = softening_t(may=model%can_break .and. .not. increment%softens)
      state%bonds%softens = increment%softens
      call self%past%forget(self%system%unknowns)
      call gather(self%system, net_force(state), residual)
      unbalanced = norm2(residual)
      associate (tangents => state%tractions%tangents)
         do iterations = 0, model%deck%implicit%max_iterations
            if (iterations > 0) self%iterations = self%iterations + 1_i8
            if (tangents%on .and. unbalanced_ratio(model%loads, state) <= max(tolerance, near)) then
               tangents%on = .false.
               call find_residual(self, model, increment, state, residual, unbalanced)
            end if
            converged = .not. tangents%on .and. unbalanced_ratio(model%loads, state) <= tolerance
            if (converged) exit
            fresh = slow .or. self%outdated .or. .not. self%factored
            if (fresh) then
               if (may .and. .not. tangents%on .and. unbalanced_ratio(model%loads, state) > far) then
                  by_tangents = .true.
                  call begin_tangents(state%walls, state%tractions)
               end if
               call exact_correction(self, model, increment, state, residual, step, regular)
            else
               call correction(self, residual, step, regular)
            end if
            if (.not. regular) then
               call softening%give_up(state%bonds%softens, slow)
               if (slow) cycle
               exit
            end if
            call shorten(increment%longest, step, whole)
            before = unbalanced
            bound = 1.0_wp
            if (tangents%on .and. fresh .and. rises < most_rises) bound = highest_rise
            call search_line(self, model, increment, bound, fresh, step, state, residual, unbalanced, left, taken)
            if (taken) then
               if (tangents%on) call tangents%advance(state%walls)
               if (unbalanced > before) rises = rises + 1
               call self%past%took(step)
               slow = unbalanced > good_reduction*before
               if (.not. whole) left = 0.0_wp
               call softening%judge(left, unbalanced/before, unbalanced_ratio(model%loads, state) < far, state%bonds%softens)
            else if (fresh) then
               call softening%give_up(state%bonds%softens, slow)
               if (slow) cycle
               ! As good as rounding allows?
               converged = .not. tangents%on .and. unbalanced <= rounding*norm2(self%diagonal*displacement(self, state))
               exit
            else
               slow = .true.
            end if
            if (model%deck%implicit%matrix == 'new') slow = .true.
         end do
         tangents%on = .false.
         state%bonds%softens = .false.
      end associate
   end subroutine iterate

   !> Step of an iteration with the factors at hand: their answer to the unbalanced force, with what earlier iterations taught.
   subroutine correction(self, residual, step, regular)
      class(newton_t), intent(inout) :: self
      !> Unbalanced force (unknowns) [N/m]
      real(wp), intent(in) :: residual(:)
      real(wp), intent(out) :: step(:)
      logical, intent(out) :: regular
      real(wp) :: answer(size(residual))
      integer :: status

      answer = residual
      call now_doing(work_solves)
      call self%lu%solve(answer, status)
      call now_doing(work_other)
      regular = status == linear_ok .and. all(abs(answer) < huge(1.0_wp))
      if (regular) call self%past%next_step(answer, step)
   end subroutine correction

   !> Step of an iteration by the matrix of the present state: with older factors where these give it in few steps.
   subroutine exact_correction(self, model, increment, state, residual, step, regular)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      !> Unbalanced force (unknowns) [N/m]
      real(wp), intent(in) :: residual(:)
      real(wp), intent(out) :: step(:)
      logical, intent(out) :: regular
      integer :: steps
      logical :: outside

      regular = .false.
      call renew_matrix(self, model, increment, state, outside)
      if (outside .or. allocated(self%failure)) return
      if (self%factored .and. model%deck%implicit%matrix == 'kept') then
         call now_doing(work_solves)
         call solve_lagged(self%system, self%lu, residual, lagged_tolerance, most_lagged, step, steps, regular)
         call now_doing(work_other)
         self%lagged_steps = self%lagged_steps + int(steps, i8)
         if (regular) self%lagged = self%lagged + 1_i8
         self%outdated = .true.
         if (regular) return
      end if
      call factor_matrix(self)
      if (self%factored) call correction(self, residual, step, regular)
   end subroutine exact_correction

   !> No node moves by more than the longest correction.
   pure subroutine shorten(longest, step, whole)
      !> [m]
      real(wp), intent(in) :: longest
      !> (unknowns) [m]
      real(wp), intent(inout) :: step(:)
      !> Is it no longer?
      logical, intent(out) :: whole
      real(wp) :: largest

      largest = maxval(abs(step))
      whole = largest <= longest
      if (.not. whole) step = step*(longest/largest)
   end subroutine shorten

   !> Take the step, or the longest half, quarter, ... of it that reduces the unbalanced force, or lets it rise no further than
   !> the bound without going far beyond the least of the work along the step, or that comes near that least: walls that press where
   !> the matrix has them open, bonds that load where it has them unload, or the other way round, are known to the next matrix.
   !> A kept matrix gets one try. Without success the state is where it was.
   subroutine search_line(self, model, increment, bound, fresh, step, state, residual, unbalanced, left, taken)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      !> Largest unbalanced force to take, over the present one: 1 for a reduction, more for a rise
      real(wp), intent(in) :: bound
      !> Does the matrix belong to this state?
      logical, intent(in) :: fresh
      !> Step in, the part of it that was taken out (unknowns) [m]
      real(wp), intent(inout) :: step(:)
      type(state_t), intent(inout) :: state
      !> Unbalanced force (unknowns) [N/m] and its norm, at the state
      real(wp), intent(inout) :: residual(:), unbalanced
      !> Work that a step taken at full length by the matrix of this state leaves along it, over what there was; otherwise 0
      real(wp), intent(out) :: left
      logical, intent(out) :: taken
      real(wp) :: origin(2, size(state%u, 2)), share, before, work
      integer :: halvings, most
      logical :: tells, has_corners

      origin = state%u
      before = unbalanced
      work = dot_product(residual, step)
      tells = fresh .and. work > 0.0_wp
      has_corners = size(model%corners%stiffness) > 0
      left = 0.0_wp
      share = 1.0_wp
      most = merge(min(model%deck%implicit%line_search, increment%halvings), 0, fresh)
      do halvings = 0, most
         state%u = origin
         call scatter(self%system, share, step, state%u)
         call find_residual(self, model, increment, state, residual, unbalanced)
         ! A comparison with NaN is false
         taken = unbalanced <= (bound - sufficient*share)*before
         if (tells) left = dot_product(residual, step)/work
         if (has_corners .and. unbalanced > before) taken = taken .and. tells .and. abs(left) <= most_work
         if (tells) taken = taken .or. (abs(left) <= least_work .and. unbalanced <= highest_rise*before)
         if (taken) then
            if (halvings > 0) left = 0.0_wp
            step = share*step
            return
         end if
         share = 0.5_wp*share
      end do
      state%u = origin
      call find_residual(self, model, increment, state, residual, unbalanced)
   end subroutine search_line

   !> Unbalanced force at a displacement, and its norm.
   subroutine find_residual(self, model, increment, state, residual, unbalanced)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      !> (unknowns) [N/m], [N/m]
      real(wp), intent(out) :: residual(:), unbalanced

      call evaluate(model, increment, state)
      call gather(self%system, net_force(state), residual)
      unbalanced = norm2(residual)
   end subroutine find_residual

   !> Assemble the matrix of the present state, on a new pattern where walls have slid out of the old one.
   subroutine renew_matrix(self, model, increment, state, outside)
      class(newton_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      !> Is even the new pattern too small?
      logical, intent(out) :: outside

      call assemble(model, increment, state, self%system, outside)
      if (outside) then
         call lay_out(self, model, state)
         call assemble(model, increment, state, self%system, outside)
      end if
      self%diagonal = diagonal_of(self%system)
      if (self%weak_springs) then
         where (self%system%row == self%system%column) self%system%value = (1.0_wp + weak)*self%system%value
      end if
      call self%past%forget(self%system%unknowns)
   end subroutine renew_matrix

   !> Factor the matrix.
   subroutine factor_matrix(self)
      class(newton_t), intent(inout) :: self
      integer :: status

      call now_doing(work_factors)
      call self%lu%factor(self%system%value, status)
      call now_doing(work_other)
      if (status == linear_failed) self%failure = self%lu%message()
      self%factorisations = self%factorisations + 1_i8
      self%factored = status == linear_ok
      self%outdated = .false.
   end subroutine factor_matrix

   !> Tangent stiffness of all terms.
   subroutine assemble(model, increment, state, system, outside)
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(in) :: state
      type(sparse_system_t), intent(inout) :: system
      !> Is the pattern too small?
      logical, intent(out) :: outside
      integer :: i

      call now_doing(work_assembly)
      outside = .false.
      system%value = 0.0_wp
      do i = 1, size(model%term)
         if (model%term(i)%raw%is_there(model)) &
            call model%term(i)%raw%add_tangent(model, increment%increment_t, state, system, outside)
      end do
      call now_doing(work_other)
   end subroutine assemble

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
      class(newton_t), intent(in) :: self
      type(state_t), intent(in) :: state
      real(wp) :: vector(self%system%unknowns)

      call gather(self%system, state%u, vector)
   end function displacement

   !> Forces and joints at the displacement state%u, the joints updated from the start of the increment in one step.
   subroutine evaluate(model, increment, state)
      type(model_t), intent(in) :: model
      type(newton_increment_t), intent(in) :: increment
      type(state_t), intent(inout) :: state
      logical :: searched

      ! Walls walk to what they face now from where they were, not from where the last iteration took them
      if (model%has_walls) then
         state%walls%facing = increment%start%walls%facing
         state%walls%reached = increment%start%walls%reached
      end if
      call forces_from_start(model, increment, increment%level, state, searched)
      if (increment%drag > 0.0_wp) then
         where (.not. model%loads%fixed) state%solid = state%solid - increment%drag*spread(model%nodes%rock_stiffness, 1, 2)* &
                                                       (state%u - increment%start%u)
      end if
   end subroutine evaluate

end module newton_m
