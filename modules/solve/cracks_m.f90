!> Cracks: where rock may break, which edges the stress asks to be cut, what has broken, and when a crack's walls become a
!> matter of contact.
module cracks_m
   use kinds_m, only: wp
   use constants_m, only: megapascal, millimetre, radians
   use text_m, only: to_text
   use log_m, only: log_t
   use cohesive_group_m, only: all_rock
   use cohesive_m, only: cohesive_t, overstress
   use bond_m, only: bond_is_broken, bond_has_parted, bond_energy, bond_mode, bond_weight
   use bonds_m, only: crack_event_t, start_bond, is_closed
   use joint_kinematics_m, only: joint_frame_t, joint_kinematics
   use edges_m, only: next_corner
   use recut_m, only: recut, renew_contact, renew_loads, rock_law
   use model_m, only: model_t
   use solid_m, only: solid_t, solid_stress
   use state_m, only: state_t
   implicit none
   private

   public :: start_cracks, note_cracks, overstressed_edges, cut_overstressed, crack_at_rest, describe_bonds, hold_back, &
             restart_release, release_factor

   !> New cracks let go of the force that their bonds do not carry over this many times the time a wave takes through an
   !> element
   real(wp), parameter :: release_passages = 10.0_wp

contains

   !> Find where rock may break, and cut what is to be cut from the start.
   subroutine start_cracks(model, log, state)
      type(model_t), intent(inout) :: model
      type(log_t), intent(in) :: log
      type(state_t), intent(inout) :: state
      logical, allocatable :: at_start(:)
      integer, allocatable :: chosen(:), parent(:)
      integer :: e

      call find_breakable(model, at_start)
      model%can_break = any(model%breakable > 0)
      if (.not. model%can_break) return
      model%bonds%fractures = size(model%split%joint, 2)
      model%check_every = minval(model%deck%cohesive%check_every)
      chosen = pack([(e, e=1, size(at_start))], at_start)
      call recut(model, state, chosen, parent)
      model%breakable(chosen) = 0
      model%is_adaptive = any(model%breakable > 0)
      allocate (state%release(2, size(state%mass)), source=0.0_wp)
      call warn_of_bonds(model, log)
   end subroutine start_cracks

   !> Which &cohesive each edge of the mesh follows, and whether it is cut from the start.
   subroutine find_breakable(model, at_start)
      type(model_t), intent(inout) :: model
      logical, allocatable, intent(out) :: at_start(:)
      integer :: e, k, of(2), chosen
      character(len=:), allocatable :: insertion

      allocate (model%breakable(size(model%edges%triangles)), source=0)
      allocate (at_start(size(model%edges%triangles)), source=.false.)
      if (size(model%deck%cohesive) == 0) return
      do e = 1, size(model%breakable)
         if (model%edges%triangles(e) /= 2) cycle
         do k = 1, 2
            of(k) = cohesive_of(model, model%edges%triangle(k, e))
         end do
         ! Between two kinds of rock the weaker breaks; an edge of a surface to rock that cannot break belongs to
         ! 'everywhere' only
         if (all(of > 0)) then
            chosen = of(1)
            if (model%deck%cohesive(of(2))%tensile_strength < model%deck%cohesive(of(1))%tensile_strength) chosen = of(2)
         else
            chosen = maxval(of)
            if (chosen == 0) cycle
            if (model%deck%cohesive(chosen)%insertion /= 'everywhere') cycle
         end if
         insertion = trim(model%deck%cohesive(chosen)%insertion)
         if (insertion == 'none') cycle
         model%breakable(e) = chosen
         at_start(e) = insertion /= 'adaptive'
      end do
      model%breakable(model%cut%edge) = 0
      at_start(model%cut%edge) = .false.
   end subroutine find_breakable

   !> Index of the &cohesive group of a triangle: that of its surface before that of all rock; 0: none.
   pure integer function cohesive_of(model, triangle) result(fracture)
      type(model_t), intent(in) :: model
      integer, intent(in) :: triangle
      integer :: i

      fracture = 0
      do i = 1, size(model%deck%cohesive)
         if (fracture == 0 .and. model%deck%cohesive(i)%group == all_rock) fracture = i
      end do
      do i = 1, size(model%deck%cohesive)
         if (model%deck%cohesive(i)%group == model%split%group(model%split%triangle_group(triangle))%name) fracture = i
      end do
   end function cohesive_of

   !> Say when the stiffness of the bonds is too low for the fracture energies.
   subroutine warn_of_bonds(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      integer :: soft

      soft = count(.not. model%bonds%law%sound)
      if (soft > 0) call log%warn(to_text(soft)//' of '//to_text(size(model%bonds%law))//' cohesive joints store more energy '// &
                                  'up to their strength than breaking them takes: larger penalty_factor or smaller elements')
   end subroutine warn_of_bonds

   !> Look at the bonds: note those that have broken, which lets fluid in, and hand those that have parted to the contact.
   subroutine note_cracks(model, state, changed)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      !> Has the contact changed, or have the loads?
      logical, intent(out) :: changed
      type(crack_event_t), allocatable :: event(:)
      logical :: parted
      integer :: b, n, events

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
         if (model%joints%law(model%bonds%fractures + b)%raw%own_closure() > 0.0_wp .and. &
             any(state%bonds%point(:, b)%normal < 0.0_wp)) cycle
         call hand_over(model, state, b)
         parted = .true.
      end do
      if (parted) call renew_contact(model, [(n, n=1, size(state%mass))], state)
      changed = parted
      if (events == 0) return
      state%bonds%event = [state%bonds%event, event(:events)]
      if (size(model%deck%pore_pressure) == 0) return
      call renew_loads(model, state)
      changed = .true.
   end subroutine note_cracks

   !> Note that a bond broke.
   subroutine note_event(model, state, b, event)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      integer, intent(in) :: b
      type(crack_event_t), intent(out) :: event
      real(wp) :: along(2), energy(2)

      associate (x => model%split%x, node => model%bonds%node(:, b))
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
      state%bonds%broken(b) = .true.
   end subroutine note_event

   !> A bond has parted: its walls go to the contact with the stresses they have.
   subroutine hand_over(model, state, b)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      integer, intent(in) :: b
      integer :: j

      j = model%bonds%fractures + b
      call describe_bond(model, state, b)
      state%bonds%active(b) = .false.
      model%joints%bonded(j) = .false.
      state%tractions%contact_stress(j) = state%joint(j)%sn
      state%joint(j)%u_max = abs(state%joint(j)%u)
   end subroutine hand_over

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
      type(joint_frame_t) :: frame

      associate (node => model%bonds%node(:, b), point => state%bonds%point(:, b), j => model%bonds%fractures + b)
         frame = joint_kinematics(model%split%x(:, node), state%u(:, node))
         state%joint(j)%u = frame%shear/millimetre
         state%joint(j)%tau = dot_product(bond_weight, point%shear)/megapascal
         state%joint(j)%sn = max(0.0_wp, -dot_product(bond_weight, point%normal))/megapascal
         state%opening(j) = frame%opening/millimetre
         state%aperture(j) = max(0.0_wp, state%opening(j))
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

   !> Cut edges and let their bonds start at the stress of the rock. So do bonds that could not open until now: what they
   !> were put in with is no longer true.
   subroutine cut_overstressed(model, state, edge, no_jump, parent)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      !> Edges of the mesh as read
      integer, intent(in) :: edge(:)
      !> Are bonds made as strong as the stress they start at, so that no force jumps?
      logical, intent(in) :: no_jump
      !> Node that each node was before (nodes)
      integer, allocatable, intent(out) :: parent(:)
      logical, allocatable :: fresh(:)
      real(wp) :: normal, shear
      integer :: b, e, before

      before = size(state%bonds%active)
      allocate (fresh(before + size(edge)), source=.true.)
      do b = 1, before
         fresh(b) = is_closed(model%bonds%node(:, b))
      end do
      call recut(model, state, edge, parent)
      model%breakable(edge) = 0
      do b = 1, size(fresh)
         if (.not. fresh(b)) cycle
         e = model%cut%edge(model%bonds%fractures + b)
         associate (beside => model%edges%triangle(:, e))
            call stress_across(model, state, e, 0.5_wp*(solid_stress(model%solid, beside(1), state%u) + &
                                                        solid_stress(model%solid, beside(2), state%u)), normal, shear)
         end associate
         call start_bond(model%bonds, state%bonds, b, rock_law(model, model%bonds%fractures + b, model%bonds%setting(b)), &
                         normal, shear, no_jump)
      end do
   end subroutine cut_overstressed

   !> Note what has broken and cut the edges whose stress has reached the strength, in a state of rest. No force is held back:
   !> equilibrium is to be found anew.
   subroutine crack_at_rest(model, state, changed, parent)
      type(model_t), intent(inout) :: model
      type(state_t), intent(inout) :: state
      !> Have mesh or contact changed, so that there is no equilibrium any more?
      logical, intent(out) :: changed
      !> Node that each node was before (nodes); not allocated when no edge was cut
      integer, allocatable, intent(out) :: parent(:)
      integer, allocatable :: edge(:)

      call note_cracks(model, state, changed)
      if (.not. model%is_adaptive) return
      edge = overstressed_edges(model, state)
      if (size(edge) == 0) return
      changed = .true.
      call cut_overstressed(model, state, edge, .false., parent)
   end subroutine crack_at_rest

   !> Hold back the forces that new cuts would set free at once, and let go of them over some passages of a wave through
   !> an element: so the acceleration of no node jumps.
   subroutine hold_back(parent, acceleration, force, state)
      !> Node that each node was before the cut (nodes)
      integer, intent(in) :: parent(:)
      !> Acceleration before the cut (2, nodes before) [m/s2], force after it, with what is held back already (2, nodes) [N/m]
      real(wp), intent(in) :: acceleration(:, :), force(:, :)
      type(state_t), intent(inout) :: state
      integer :: copies(size(acceleration, 2)), n

      copies = 0
      do n = 1, size(parent)
         copies(parent(n)) = copies(parent(n)) + 1
      end do
      do n = 1, size(parent)
         if (copies(parent(n)) > 1) state%release(:, n) = state%release(:, n) + state%mass(n)*acceleration(:, parent(n)) &
                                                          - force(:, n)
      end do
   end subroutine hold_back

   !> What is left to let go of at the present time goes to the copies of the nodes as one; the clock starts again.
   subroutine restart_release(solid, parent, state)
      type(solid_t), intent(in) :: solid
      integer, intent(in) :: parent(:)
      type(state_t), intent(inout) :: state
      real(wp) :: left(2, size(state%release, 2))
      integer :: copies(size(state%release, 2)), n

      left = state%release*release_factor(state)
      copies = 0
      do n = 1, size(parent)
         copies(parent(n)) = copies(parent(n)) + 1
      end do
      deallocate (state%release)
      allocate (state%release(2, size(parent)), source=0.0_wp)
      do n = 1, size(parent)
         if (copies(parent(n)) == 1) state%release(:, n) = left(:, parent(n))
      end do
      state%release_start = state%time
      state%release_time = release_passages*maxval(solid%height*sqrt(solid%density/solid%young))
   end subroutine restart_release

   !> Part of the forces held back that still acts.
   pure real(wp) function release_factor(state) result(factor)
      type(state_t), intent(in) :: state

      factor = 0.0_wp
      if (state%release_time > 0.0_wp) factor = max(0.0_wp, 1.0_wp - (state%time - state%release_start)/state%release_time)
   end function release_factor

end module cracks_m
