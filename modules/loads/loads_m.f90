!> Boundary conditions of the stages: prescribed velocities, tractions, far-field stress, follower pressure, gravity.
!>
!> At the start of a stage everything the deck says about it is compiled into nodal arrays; during the stage the loads go
!> from their value at the end of the previous stage to that at the end of this one, and prescribed velocities act while
!> the stage moves and are zero while it rests. A load keeps its value until a later stage gives another one.
module loads_m
   use kinds_m, only: wp
   use constants_m, only: is_set, unset
   use mesh_m, only: split_mesh_t, find_group, a_point, a_curve, a_surface, curve_first
   use boundary_group_m, only: boundary_t, prescribed
   use absorbing_m, only: absorbing_t, absorbing_sides
   implicit none
   private

   !> What a fluid pushes with, of two-way coupling: nodal loads at two levels of the stage, linear in between (2, nodes)
   !> [N per m of thickness]; not allocated without
   type, public :: push_t
      real(wp), allocatable :: from(:, :), to(:, :)
      real(wp) :: level(2) = [0.0_wp, 1.0_wp]
   end type push_t

   !> Loads and prescribed motion of the current stage
   type, public :: loads_t
      !> Is the displacement component prescribed? (2, nodes)
      logical, allocatable :: fixed(:, :)
      !> Prescribed velocity while the stage moves (2, nodes) [m/s]
      real(wp), allocatable :: velocity(:, :)
      !> Dead nodal loads at the start and end of the stage (2, nodes) [N per m of thickness]
      real(wp), allocatable :: dead_start(:, :), dead_end(:, :)
      !> Stage that each condition of the deck is given for (conditions; 0: all), from the first stage on
      integer, allocatable :: given_in(:)
      !> Do the dead loads change during the stage?
      logical :: dead_changes = .false.
      !> Find them in every call, whether or not their level has changed? (a check: the same loads)
      logical :: every_time = .false.
      type(push_t) :: fluid
      !> Follower pressure on surface edges at the start and end of the stage (loaded edges) [Pa]
      real(wp), allocatable :: pressure_start(:), pressure_end(:)
      !> Nodes of the edges under pressure, rock on the left (2, loaded edges), and their surface edge
      integer, allocatable :: pressure_edge(:, :), pressure_surface(:)
      !> Dashpots of the sides that absorb waves
      type(absorbing_t) :: absorbing
   end type loads_t

   public :: init_loads, start_stage, start_absorbing, absorbing_edges, on_group, nodal_loads, pressure_stiffness, group_nodes, &
             smooth_ramp, stage_number

contains

   !> No loads yet: the state before the first stage.
   subroutine init_loads(split, boundary, loads, every_time)
      type(split_mesh_t), intent(in) :: split
      !> All boundary groups of the deck
      type(boundary_t), intent(in) :: boundary(:)
      type(loads_t), intent(out) :: loads
      !> Are they found in every call? Not unless given
      logical, intent(in), optional :: every_time
      logical, allocatable :: pressed(:)
      integer :: nodes, b, e

      if (present(every_time)) loads%every_time = every_time
      nodes = size(split%x, 2)
      allocate (loads%fixed(2, nodes), source=.false.)
      allocate (loads%velocity(2, nodes), loads%dead_start(2, nodes), loads%dead_end(2, nodes), source=0.0_wp)
      allocate (pressed(size(split%surface, 2)), source=.false.)
      do b = 1, size(boundary)
         if (is_set(boundary(b)%pressure)) pressed = pressed .or. on_group(split, boundary(b)%group)
      end do
      loads%pressure_surface = pack([(e, e=1, size(pressed))], pressed)
      loads%pressure_edge = split%surface(:, loads%pressure_surface)
      allocate (loads%pressure_start(count(pressed)), loads%pressure_end(count(pressed)), source=0.0_wp)
   end subroutine init_loads

   !> Compile the boundary conditions of a stage. Velocities: what is given for this stage, else for all stages. Loads:
   !> what was given last, for this stage or one before it, else for all stages. Each component goes its own way: a stage
   !> that gives vx leaves alone the vy given for all stages. Where two groups share nodes, the later of the deck holds.
   !> What absorbs waves is not held any more.
   subroutine start_stage(split, boundary, stage_name, stage, body_force, loads)
      type(split_mesh_t), intent(in) :: split
      type(boundary_t), intent(in) :: boundary(:)
      !> Names of all stages in order, and the number of the one that starts
      character(len=*), intent(in) :: stage_name(:)
      integer, intent(in) :: stage
      !> Weight of the nodes at the end of this stage (2, nodes) [N per m of thickness]
      real(wp), intent(in) :: body_force(:, :)
      type(loads_t), intent(inout) :: loads
      type(boundary_t) :: condition
      integer :: b, other

      if (.not. allocated(loads%given_in)) &
         loads%given_in = [(stage_number(stage_name, boundary(b)%stage), b=1, size(boundary))]
      loads%fixed = .false.
      loads%velocity = 0.0_wp
      loads%dead_start = loads%dead_end
      loads%dead_end = body_force
      loads%pressure_start = loads%pressure_end
      loads%pressure_end = 0.0_wp
      associate (given_in => loads%given_in)
         do b = 1, size(boundary)
            if (given_in(b) > stage) cycle
            condition = boundary(b)
            if (given_in(b) /= 0 .and. given_in(b) /= stage) call end_motion(condition)
            ! What is left of most stages that are over, and there can be thousands
            if (.not. any(prescribed(condition))) cycle
            do other = 1, size(boundary)
               if (boundary(other)%group /= condition%group) cycle
               if (given_in(other) > stage .or. given_in(other) <= given_in(b)) cycle
               if (given_in(other) == stage) call replace_motion(condition, boundary(other))
               if (boundary(other)%absorbing) call end_motion(condition)
               call replace_load(condition, boundary(other))
            end do
            call prescribe_velocity(split, condition, loads)
            call add_traction(split, condition, loads%dead_end)
            call set_pressure(split, condition, loads)
         end do
      end associate
      loads%dead_changes = any(abs(loads%dead_end - loads%dead_start) > 0.0_wp)
   end subroutine start_stage

   !> Take the velocities out of a condition whose stage is over.
   pure subroutine end_motion(condition)
      type(boundary_t), intent(inout) :: condition

      condition%vx = unset
      condition%vy = unset
   end subroutine end_motion

   !> Take out of a condition the velocities that a later one gives.
   pure subroutine replace_motion(condition, later)
      type(boundary_t), intent(inout) :: condition
      type(boundary_t), intent(in) :: later

      if (is_set(later%vx)) condition%vx = unset
      if (is_set(later%vy)) condition%vy = unset
   end subroutine replace_motion

   !> Dashpots of the sides that absorb in a stage: those given for it, for one before it, or for all.
   subroutine start_absorbing(split, boundary, stage_name, stage, impedance, loads)
      type(split_mesh_t), intent(in) :: split
      type(boundary_t), intent(in) :: boundary(:)
      !> Names of all stages in order, and the number of the one that starts
      character(len=*), intent(in) :: stage_name(:)
      integer, intent(in) :: stage
      !> rho cp and rho cs of the rock (2, triangles) [Pa s/m]
      real(wp), intent(in) :: impedance(:, :)
      type(loads_t), intent(inout) :: loads

      loads%absorbing = absorbing_sides(split, absorbing_edges(split, boundary, stage_name, stage), impedance)
   end subroutine start_absorbing

   !> Which surface edges absorb in a stage (surface edges).
   function absorbing_edges(split, boundary, stage_name, stage) result(edge)
      type(split_mesh_t), intent(in) :: split
      type(boundary_t), intent(in) :: boundary(:)
      character(len=*), intent(in) :: stage_name(:)
      integer, intent(in) :: stage
      logical, allocatable :: edge(:)
      integer :: b

      allocate (edge(size(split%surface, 2)), source=.false.)
      do b = 1, size(boundary)
         if (.not. boundary(b)%absorbing .or. stage_number(stage_name, boundary(b)%stage) > stage) cycle
         edge = edge .or. on_group(split, boundary(b)%group)
      end do
   end function absorbing_edges

   !> Take out of a condition the loads that a later one gives. A far-field stress is the whole traction on its edges: it
   !> replaces and is replaced by any other load.
   pure subroutine replace_load(condition, later)
      type(boundary_t), intent(inout) :: condition
      type(boundary_t), intent(in) :: later
      logical :: whole

      whole = is_set(later%sxx)
      if (is_set(later%tx) .or. whole) condition%tx = unset
      if (is_set(later%ty) .or. whole) condition%ty = unset
      if (is_set(later%pressure) .or. whole) condition%pressure = unset
      if (any(is_set([later%tx, later%ty, later%pressure])) .or. whole) then
         condition%sxx = unset
         condition%syy = unset
         condition%sxy = unset
      end if
   end subroutine replace_load

   !> Number of a stage; 0 for 'all'.
   pure integer function stage_number(stage_name, name) result(number)
      character(len=*), intent(in) :: stage_name(:), name
      integer :: s

      number = 0
      do s = size(stage_name), 1, -1
         if (stage_name(s) /= name) cycle
         number = s
         return
      end do
   end function stage_number

   subroutine prescribe_velocity(split, boundary, loads)
      type(split_mesh_t), intent(in) :: split
      type(boundary_t), intent(in) :: boundary
      type(loads_t), intent(inout) :: loads
      logical, allocatable :: member(:)

      if (.not. (is_set(boundary%vx) .or. is_set(boundary%vy))) return
      member = group_nodes(split, boundary%group, curve_first)
      if (is_set(boundary%vx)) then
         where (member)
            loads%fixed(1, :) = .true.
            loads%velocity(1, :) = boundary%vx
         end where
      end if
      if (is_set(boundary%vy)) then
         where (member)
            loads%fixed(2, :) = .true.
            loads%velocity(2, :) = boundary%vy
         end where
      end if
   end subroutine prescribe_velocity

   !> Add a boundary's dead traction or far-field stress, lumped to the ends of its edges.
   subroutine add_traction(split, boundary, force)
      type(split_mesh_t), intent(in) :: split
      type(boundary_t), intent(in) :: boundary
      real(wp), intent(inout) :: force(:, :)
      logical, allocatable :: loaded(:)
      real(wp) :: along(2), outward(2), resultant(2)
      integer :: e, i

      if (.not. (is_set(boundary%tx) .or. is_set(boundary%ty) .or. is_set(boundary%sxx))) return
      loaded = on_group(split, boundary%group)
      do e = 1, size(loaded)
         if (.not. loaded(e)) cycle
         along = split%x(:, split%surface(2, e)) - split%x(:, split%surface(1, e))
         ! Outward normal times length: the rock is on the left of the edge
         outward = [along(2), -along(1)]
         resultant = 0.0_wp
         if (is_set(boundary%tx)) resultant(1) = boundary%tx*norm2(along)
         if (is_set(boundary%ty)) resultant(2) = boundary%ty*norm2(along)
         if (is_set(boundary%sxx)) then
            resultant = resultant - [boundary%sxx*outward(1) + boundary%sxy*outward(2), &
                                     boundary%sxy*outward(1) + boundary%syy*outward(2)]
         end if
         do i = 1, 2
            force(:, split%surface(i, e)) = force(:, split%surface(i, e)) + 0.5_wp*resultant
         end do
      end do
   end subroutine add_traction

   subroutine set_pressure(split, boundary, loads)
      type(split_mesh_t), intent(in) :: split
      type(boundary_t), intent(in) :: boundary
      type(loads_t), intent(inout) :: loads
      logical, allocatable :: pressed(:)

      if (.not. is_set(boundary%pressure)) return
      pressed = on_group(split, boundary%group)
      where (pressed(loads%pressure_surface)) loads%pressure_end = boundary%pressure
   end subroutine set_pressure

   !> Loads at a point of the stage: dead loads interpolated, pressure on the edges where they are now. Nothing is done
   !> while they stay as they are.
   pure subroutine nodal_loads(loads, x, u, level, level_then, force)
      type(loads_t), intent(in) :: loads
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> 0 at the start of the stage, 1 at its end
      real(wp), intent(in) :: level
      !> Level of the last call (unset: none in this stage)
      real(wp), intent(inout) :: level_then
      !> Nodal loads (2, nodes) [N per m of thickness], as the last call left them
      real(wp), contiguous, intent(inout) :: force(:, :)
      real(wp) :: along(2), half_push(2)
      integer :: e
      logical :: same

      same = is_set(level_then) .and. (.not. (loads%dead_changes .or. allocated(loads%fluid%to)) &
                                       .or. abs(level - level_then) <= 0.0_wp)
      same = same .and. .not. loads%every_time
      if (same .and. size(loads%pressure_surface) == 0) return
      level_then = level
      force = loads%dead_start + level*(loads%dead_end - loads%dead_start)
      if (allocated(loads%fluid%to)) then
         associate (fluid => loads%fluid)
            force = force + fluid%from + (level - fluid%level(1))/(fluid%level(2) - fluid%level(1))*(fluid%to - fluid%from)
         end associate
      end if
      do e = 1, size(loads%pressure_surface)
         associate (p => loads%pressure_edge(1, e), q => loads%pressure_edge(2, e))
            along = x(:, q) + u(:, q) - x(:, p) - u(:, p)
            half_push = 0.5_wp*(loads%pressure_start(e) + level*(loads%pressure_end(e) - loads%pressure_start(e)))* &
                        [-along(2), along(1)]
            force(:, p) = force(:, p) + half_push
            force(:, q) = force(:, q) + half_push
         end associate
      end do
   end subroutine nodal_loads

   !> Stiffness of a follower pressure, which turns and lengthens with its edge: minus the derivative of its nodal forces.
   pure function pressure_stiffness(loads, e, level) result(stiffness)
      type(loads_t), intent(in) :: loads
      !> Loaded edge
      integer, intent(in) :: e
      real(wp), intent(in) :: level
      !> Components x, y of the edge's start and end (4, 4) [N/m per m of thickness]
      real(wp) :: stiffness(4, 4)
      real(wp) :: half

      half = 0.5_wp*(loads%pressure_start(e) + level*(loads%pressure_end(e) - loads%pressure_start(e)))
      ! Each end is pushed by half*[-along_y, along_x], along = end - start
      stiffness = 0.0_wp
      stiffness([1, 3], 2) = -half
      stiffness([2, 4], 1) = half
      stiffness([1, 3], 4) = half
      stiffness([2, 4], 3) = -half
   end function pressure_stiffness

   !> Nodes that belong to a physical point, curve or surface (nodes): of those of that name, to the first that has any.
   function group_nodes(split, name, order) result(member)
      type(split_mesh_t), intent(in) :: split
      character(len=*), intent(in) :: name
      !> Which dimension goes before which
      integer, intent(in) :: order(:)
      logical, allocatable :: member(:), edge(:)
      integer :: group, d, i

      allocate (member(size(split%x, 2)), source=.false.)
      do d = 1, size(order)
         group = find_group(split%group, name, order(d))
         if (group == 0) cycle
         select case (order(d))
         case (a_point)
            do i = 1, size(split%point)
               if (split%point_group(i) == group) member(split%point(i)) = .true.
            end do
         case (a_curve)
            edge = on_group(split, name)
            do i = 1, size(edge)
               if (edge(i)) member(split%surface(:, i)) = .true.
            end do
         case (a_surface)
            do i = 1, size(split%triangle, 2)
               if (split%triangle_group(i) == group) member(split%triangle(:, i)) = .true.
            end do
         end select
         if (any(member)) return
      end do
   end function group_nodes

   !> Surface edges of a physical curve (surface edges).
   function on_group(split, name) result(edge)
      type(split_mesh_t), intent(in) :: split
      character(len=*), intent(in) :: name
      logical, allocatable :: edge(:)
      integer :: group

      group = find_group(split%group, name, a_curve)
      if (group > 0) then
         edge = split%surface_group == group
      else
         allocate (edge(size(split%surface, 2)), source=.false.)
      end if
   end function on_group

   !> Ramp from 0 to 1 that starts and ends at rest.
   pure real(wp) function smooth_ramp(fraction)
      !> Part of the move that is over, 0 to 1
      real(wp), intent(in) :: fraction
      real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp)

      smooth_ramp = fraction - sin(turn*fraction)/turn
   end function smooth_ramp

end module loads_m
