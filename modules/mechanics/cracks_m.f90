!> Cracks: which edges the stress asks to be cut, what has broken, and when a crack's walls become a matter of contact. What
!> these ask of the model is for recut_m, as is what an excavation does.
module cracks_m
   use kinds_m, only: wp
   use constants_m, only: radians
   use cohesive_m, only: cohesive_t, overstress
   use bond_m, only: bond_is_broken, bond_has_parted, bond_energy, bond_mode, bond_weight
   use bonds_m, only: crack_event_t
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use joint_border_m, only: show_bond
   use emission_m, only: crack_moment
   use edges_m, only: next_corner
   use model_m, only: model_t
   use solid_stress_m, only: solid_stress
   use state_m, only: state_t
   implicit none
   private

   public :: find_breaks, describe_bonds, describe_bond, stress_across

   !> What of a model is to change, because rock breaks, has broken or is taken out
   type, public :: breaks_t
      !> Edges of the mesh as read that are to be cut: interior and not cut yet
      integer, allocatable :: edge(:)
      !> Bonds that have parted
      integer, allocatable :: parted(:)
      !> Is the triangle to be taken out? (triangles) Not allocated: none is
      logical, allocatable :: taken(:)
      !> Has fluid got into a crack?
      logical :: filled = .false.
      !> Before any step of this run? Bonds are then without stress, or as a checkpoint has them, and contact has yet to start
      logical :: at_start = .false.
      !> All bonds of the checkpoint (values, bonds); not allocated: none
      real(wp), allocatable :: bond(:, :)
   contains
      procedure :: any => any_breaks
   end type breaks_t

contains

   !> Is there anything to change?
   pure logical function any_breaks(self)
      class(breaks_t), intent(in) :: self

      any_breaks = self%filled .or. allocated(self%taken)
      if (allocated(self%edge)) any_breaks = any_breaks .or. size(self%edge) > 0
      if (allocated(self%parted)) any_breaks = any_breaks .or. size(self%parted) > 0
   end function any_breaks

   !> What the rock asks for now: edges whose stress has reached the strength, and bonds that have parted. What has broken is noted.
   subroutine find_breaks(model, state, breaks)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(breaks_t), intent(out) :: breaks

      call note_cracks(model, state, breaks)
      if (model%is_adaptive) then
         breaks%edge = overstressed_edges(model, state)
      else
         allocate (breaks%edge(0))
      end if
   end subroutine find_breaks

   !> Look at the bonds: note those that have broken, which lets fluid in, and find those that have parted.
   subroutine note_cracks(model, state, breaks)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(breaks_t), intent(inout) :: breaks
      type(crack_event_t), allocatable :: event(:)
      logical :: parted(size(state%bonds%active))
      integer :: b, events

      parted = .false.
      events = 0
      do b = 1, size(state%bonds%active)
         if (.not. state%bonds%active(b)) cycle
         if (.not. bond_is_broken(state%bonds%point(:, b))) cycle
         if (.not. state%bonds%broken(b)) then
            if (events == 0) allocate (event(size(state%bonds%active)))
            events = events + 1
            call note_event(model, state, b, event(events))
         end if
         if (.not. bond_has_parted(state%bonds%point(:, b))) cycle
         ! A law with a closure of its own can only take over walls that do not press on each other
         parted(b) = .not. (model%joints%law(model%bonds%fractures + b)%raw%own_closure() > 0.0_wp .and. &
                            any(state%bonds%point(:, b)%normal < 0.0_wp))
      end do
      breaks%parted = pack([(b, b=1, size(parted))], parted)
      if (events == 0) return
      state%bonds%event = [state%bonds%event, event(:events)]
      breaks%filled = size(model%deck%pore_pressure) > 0
   end subroutine note_cracks

   !> Note that a bond broke.
   subroutine note_event(model, state, b, event)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      integer, intent(in) :: b
      type(crack_event_t), intent(out) :: event
      type(joint_frame_t) :: frame
      real(wp) :: along(2), energy(2)

      associate (x => model%split%x, node => model%bonds%node(:, b))
         frame = joint_kinematics(x(:, node), state%u(:, node))
         along = x(:, node(2)) - x(:, node(1))
         event%place = model%split%datum + 0.5_wp*(x(:, node(1)) + x(:, node(2)))
      end associate
      if (along(1) < 0.0_wp) along = -along
      event%angle = atan2(along(2), along(1))/radians
      event%time = state%time
      event%stage = model%stage
      event%length = model%bonds%length(b)
      energy = bond_energy(event%length, state%bonds%point(:, b))
      event%mode = bond_mode(energy)
      event%energy = sum(energy)
      associate (solid => model%solid, beside => model%split%joint_triangle(:, model%bonds%fractures + b))
         event%moment = crack_moment(event%length, frame%j, frame%shear*frame%i + frame%opening*frame%j, &
                                     0.5_wp*sum(solid%lambda_area(beside)/solid%area(beside)), &
                                     0.5_wp*sum(solid%mu_area(beside)/solid%area(beside)))
      end associate
      state%bonds%broken(b) = .true.
   end subroutine note_event

   !> Let the joint elements of the bonds show what the bonds feel: slip, opening, stresses.
   subroutine describe_bonds(model, state)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      integer :: b

      if (.not. model%can_break) return
      do b = 1, size(state%bonds%active)
         if (state%bonds%active(b)) call describe_bond(model, state, b)
      end do
   end subroutine describe_bonds

   subroutine describe_bond(model, state, b)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      integer, intent(in) :: b

      associate (node => model%bonds%node(:, b), point => state%bonds%point(:, b), j => model%bonds%fractures + b)
         call show_bond(joint_kinematics(model%split%x(:, node), state%u(:, node)), dot_product(bond_weight, point%normal), &
                        dot_product(bond_weight, point%shear), state%joint(j), state%opening(j), state%aperture(j))
      end associate
   end subroutine describe_bond

   !> Edges whose stress, the mean of the two triangles beside them, has reached the strength.
   function overstressed_edges(model, state) result(edge)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      integer, allocatable :: edge(:)
      type(cohesive_t) :: rock(size(model%deck%cohesive))
      logical, allocatable :: over(:)
      real(wp), allocatable :: stress(:, :)
      real(wp) :: normal, shear
      integer :: e, t

      rock%tensile_strength = model%deck%cohesive%tensile_strength
      rock%cohesion = model%deck%cohesive%cohesion
      rock%internal = tan(model%deck%cohesive%friction_angle*radians)
      allocate (stress(3, size(model%split%triangle, 2)), over(size(model%breakable)))
      do t = 1, size(stress, 2)
         stress(:, t) = solid_stress(model%solid, t, state%u)
      end do
      over = .false.
      do e = 1, size(over)
         if (model%breakable(e) == 0) cycle
         associate (beside => model%edges%triangle(:, e))
            call stress_across(model, state, e, 0.5_wp*(stress(:, beside(1)) + stress(:, beside(2))), normal, shear)
         end associate
         over(e) = overstress(rock(model%breakable(e)), normal, shear) >= &
            model%deck%cohesive(model%breakable(e))%insertion_level
      end do
      edge = pack([(e, e=1, size(over))], over)
   end function overstressed_edges

   !> Normal stress, tension positive, and shear stress across an edge, along j and i of its joint element [Pa].
   pure subroutine stress_across(model, state, e, stress, normal, shear)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> Edge of the mesh as read
      integer, intent(in) :: e
      !> Stress sxx, syy, sxy, tension positive [Pa]
      real(wp), intent(in) :: stress(3)
      real(wp), intent(out) :: normal, shear
      real(wp) :: i(2), j(2), traction(2)
      integer :: k, a, b

      ! The edge as the triangle on its left has it
      associate (t => model%edges%triangle(1, e))
         k = 1
         do while (model%whole%triangle(k, t) /= model%edges%node(1, e))
            k = k + 1
         end do
         a = model%split%triangle(k, t)
         b = model%split%triangle(next_corner(k), t)
      end associate
      i = (model%split%x(:, b) - model%split%x(:, a)) + (state%u(:, b) - state%u(:, a))
      i = i/norm2(i)
      j = [-i(2), i(1)]
      traction = [stress(1)*j(1) + stress(3)*j(2), stress(3)*j(1) + stress(2)*j(2)]
      normal = dot_product(traction, j)
      shear = dot_product(traction, i)
   end subroutine stress_across

end module cracks_m
