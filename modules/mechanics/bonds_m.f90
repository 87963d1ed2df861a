!> The cohesive joints of a scene: rock that may break, edge by edge, and what is known of the cracks in it.
module bonds_m
   use kinds_m, only: wp
   use cohesive_m, only: cohesive_t, cohesive_point_t, strengthened, on_strength, overstress, start_point, &
                         cohesive_values, cohesive_from_values, point_values, point_from_values, cohesive_value_count, &
                         point_value_count
   use bond_m, only: bond_points, bond_weight, bond_rows_t, init_rows, bond_forces, resting_bond_forces, follow_points, &
                     bond_stiffness_bound, watched, followed
   implicit none
   private

   public :: init_bonds, add_bonds, place_bonds, hold_together, follow_bonds, bonds_stiffness_bound, bonds_work, bond_damage, &
             release_stored, is_closed, has_stiffness, start_bond
   public :: bond_values, restore_bonds, event_values, restore_events

   !> Numbers that make up a bond (does it hold, is it broken, law, shifts, points) and a crack event
   integer, parameter :: flags = 2, shift_value_count = 2*bond_points, event_value_count = 12
   integer, parameter, public :: bond_value_count = flags + cohesive_value_count + shift_value_count + &
                                 bond_points*point_value_count

   !> A crack event: a bond that broke
   type, public :: crack_event_t
      !> Time [s] and number of the stage
      real(wp) :: time = 0.0_wp
      integer :: stage = 0
      !> Middle of the edge [m] before any motion, its direction from x, -90 to 90 [degrees], its length [m]
      real(wp) :: place(2) = 0.0_wp, angle = 0.0_wp, length = 0.0_wp
      !> mode_i, mode_ii or mode_mixed of bond_m, and the energy spent [J per m of thickness]
      integer :: mode = 0
      real(wp) :: energy = 0.0_wp
      !> Moments xx, yy, xy, zz, opening positive (crack_moment) [N m per m of thickness]
      real(wp) :: moment(4) = 0.0_wp
   end type crack_event_t

   !> All bonds, in the order in which they were put in: joint elements that follow those of the fractures
   type, public :: bonds_t
      !> Number of joint elements on fractures; bond b is joint element fractures + b
      integer :: fractures = 0
      !> Nodes A, B, A', B' (4, bonds), length before any motion (bonds) [m]
      integer, allocatable :: node(:, :)
      real(wp), allocatable :: length(:)
      !> Law of each bond, opening and slip it was put in with (2, points, bonds) [m]
      type(cohesive_t), allocatable :: law(:)
      real(wp), allocatable :: shift(:, :, :)
      !> Index of the deck's &cohesive group (bonds)
      integer, allocatable :: setting(:)
      !> The same for the loop over bonds at rest
      type(bond_rows_t) :: rows
   end type bonds_t

   !> What the bonds remember
   type, public :: bond_memory_t
      !> State (points, bonds)
      type(cohesive_point_t), allocatable :: point(:, :)
      !> Does it still hold or press? (bonds) A bond that has parted belongs to the contact
      logical, allocatable :: active(:)
      !> Do the points follow the motion? resting, watched or followed of bond_m (bonds)
      integer, allocatable :: watch(:)
      !> Has its breaking been noted? (bonds)
      logical, allocatable :: broken(:)
      !> What has broken, in the order of time
      type(crack_event_t), allocatable :: event(:)
      !> Is their softening in the tangent? (implicit solver)
      logical :: softens = .false.
   end type bond_memory_t

contains

   !> No bonds yet.
   subroutine init_bonds(fractures, bonds, memory)
      !> Number of joint elements on fractures
      integer, intent(in) :: fractures
      type(bonds_t), intent(out) :: bonds
      type(bond_memory_t), intent(out) :: memory

      bonds%fractures = fractures
      allocate (bonds%length(0), bonds%law(0), bonds%shift(2, bond_points, 0), bonds%setting(0), bonds%node(4, 0))
      ! No colours
      allocate (bonds%rows%colour(1), source=1)
      allocate (memory%point(bond_points, 0), memory%active(0), memory%watch(0), memory%broken(0), memory%event(0))
   end subroutine init_bonds

   !> Put in bonds without stress at the end of the list.
   subroutine add_bonds(bonds, memory, length, law, setting)
      type(bonds_t), intent(inout) :: bonds
      type(bond_memory_t), intent(inout) :: memory
      !> Of the new bonds
      real(wp), intent(in) :: length(:)
      type(cohesive_t), intent(in) :: law(:)
      integer, intent(in) :: setting(:)
      type(cohesive_t), allocatable :: laws(:)
      type(cohesive_point_t), allocatable :: points(:, :)
      real(wp), allocatable :: shifts(:, :, :)
      integer :: before, after, b

      before = size(bonds%length)
      after = before + size(length)
      allocate (laws(after), points(bond_points, after), shifts(2, bond_points, after))
      shifts = 0.0_wp
      do b = 1, before
         laws(b) = bonds%law(b)
         points(:, b) = memory%point(:, b)
         shifts(:, :, b) = bonds%shift(:, :, b)
      end do
      do b = before + 1, after
         laws(b) = law(b - before)
      end do
      call move_alloc(laws, bonds%law)
      call move_alloc(points, memory%point)
      call move_alloc(shifts, bonds%shift)
      bonds%length = [bonds%length, length]
      bonds%setting = [bonds%setting, setting]
      memory%active = [memory%active, [(.true., b=1, size(length))]]
      memory%watch = [memory%watch, [(watched, b=1, size(length))]]
      memory%broken = [memory%broken, [(.false., b=1, size(length))]]
   end subroutine add_bonds

   !> Tell the bonds their nodes, and which of them are worked on at the same time.
   subroutine place_bonds(bonds, node, x, turn, colour)
      type(bonds_t), intent(inout) :: bonds
      !> Nodes A, B, A', B' (4, bonds), reference coordinates (2, nodes) [m]
      integer, intent(in) :: node(:, :)
      real(wp), intent(in) :: x(:, :)
      !> Turn of each bond: that of a triangle beside it (bonds); first turn of each colour (patches_t)
      integer, intent(in) :: turn(:), colour(:)

      bonds%node = node
      call init_rows(node, bonds%length, bonds%law, x, turn, colour, bonds%rows)
   end subroutine place_bonds

   !> Let a bond start at the stress of the rock, at or within its strength. Where the stress is beyond the strength, either
   !> the bond is made as strong as that, so that no force jumps (its fracture energies stay), or it carries what its
   !> strength allows and equilibrium has to be found anew.
   pure subroutine start_bond(bonds, memory, b, law, normal, shear, no_jump)
      type(bonds_t), intent(inout) :: bonds
      type(bond_memory_t), intent(inout) :: memory
      integer, intent(in) :: b
      !> Law of the rock
      type(cohesive_t), intent(in) :: law
      !> Normal stress, tension positive, and shear stress on the edge [Pa]
      real(wp), intent(in) :: normal, shear
      logical, intent(in) :: no_jump
      real(wp) :: stress(2)
      integer :: k

      bonds%law(b) = law
      memory%watch(b) = followed
      stress = [normal, shear]
      if (no_jump) then
         if (overstress(law, normal, shear) > 1.0_wp) &
            bonds%law(b) = strengthened(law, strength_factor(law, normal, shear))
      else
         stress = on_strength(law, normal, shear)
      end if
      do k = 1, bond_points
         bonds%shift(:, k, b) = stress/law%stiffness
         call start_point(bonds%law(b), stress(1), stress(2), memory%point(k, b))
      end do
   end subroutine start_bond

   !> Factor of f_t and c that brings a stress onto the strength surface.
   pure real(wp) function strength_factor(law, normal, shear) result(factor)
      type(cohesive_t), intent(in) :: law
      real(wp), intent(in) :: normal, shear

      if (normal > 0.0_wp) then
         factor = overstress(law, normal, shear)
      else
         factor = (abs(shear) + normal*law%internal)/law%cohesion
      end if
   end function strength_factor

   !> Add the forces of all bonds to the nodal forces.
   subroutine hold_together(bonds, x, u, may_rest, memory, force)
      type(bonds_t), intent(in) :: bonds
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      !> May points stay behind where their bond rests? Then follow_bonds brings them up to date
      logical, intent(in) :: may_rest
      type(bond_memory_t), intent(inout) :: memory
      !> Nodal forces (2, nodes) [N per m of thickness]
      real(wp), contiguous, intent(inout) :: force(:, :)

      if (may_rest) then
         call resting_bond_forces(memory%active, bonds%rows, bonds%length, bonds%law, bonds%shift, x, u, &
                                  memory%watch, memory%point, force)
      else
         call bond_forces(memory%active, bonds%node, bonds%length, bonds%law, bonds%shift, x, u, memory%point, force)
      end if
   end subroutine hold_together

   !> Bring the points of all bonds up to date.
   subroutine follow_bonds(bonds, x, u, memory)
      type(bonds_t), intent(in) :: bonds
      !> Reference coordinates and displacement (2, nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), u(:, :)
      type(bond_memory_t), intent(inout) :: memory

      call follow_points(bonds%node, bonds%law, x, u, memory%watch, memory%point)
   end subroutine follow_bonds

   !> Add the bonds' part to the nodal bounds of the stiffness (nodes) [N/m per m of thickness].
   subroutine bonds_stiffness_bound(bonds, memory, bound)
      type(bonds_t), intent(in) :: bonds
      type(bond_memory_t), intent(in) :: memory
      real(wp), contiguous, intent(inout) :: bound(:)

      call bond_stiffness_bound(memory%active, bonds%node, bonds%length, bonds%law, bound)
   end subroutine bonds_stiffness_bound

   !> Work done on all bonds so far [J per m of thickness].
   pure real(wp) function bonds_work(bonds, memory) result(work)
      type(bonds_t), intent(in) :: bonds
      type(bond_memory_t), intent(in) :: memory
      integer :: b

      work = 0.0_wp
      do b = 1, size(bonds%length)
         work = work + bonds%length(b)*dot_product(bond_weight, memory%point(:, b)%work)
      end do
   end function bonds_work

   !> Let go of what a bond that has parted still stores: its walls press on each other and rub on, but that is not the bond's any
   !> more.
   pure subroutine release_stored(bonds, b, memory, normal, shear)
      type(bonds_t), intent(in) :: bonds
      integer, intent(in) :: b
      type(bond_memory_t), intent(inout) :: memory
      !> In the pressure, and in the spring of its friction [J per m of thickness]
      real(wp), intent(out) :: normal, shear
      real(wp) :: stored(2, bond_points)

      associate (point => memory%point(:, b))
         stored(1, :) = 0.5_wp*min(point%normal, 0.0_wp)**2/bonds%law(b)%stiffness
         stored(2, :) = 0.5_wp*point%shear**2/bonds%law(b)%stiffness
         point%work = point%work - stored(1, :) - stored(2, :)
      end associate
      normal = bonds%length(b)*dot_product(bond_weight, stored(1, :))
      shear = bonds%length(b)*dot_product(bond_weight, stored(2, :))
   end subroutine release_stored

   !> Damage of every joint element: 1 on fractures, the mean over the points of a bond (joints).
   pure function bond_damage(bonds, memory, joints) result(damage)
      type(bonds_t), intent(in) :: bonds
      type(bond_memory_t), intent(in) :: memory
      !> Number of joint elements
      integer, intent(in) :: joints
      real(wp) :: damage(joints)
      integer :: b

      damage = 1.0_wp
      do b = 1, size(bonds%length)
         damage(bonds%fractures + b) = dot_product(bond_weight, memory%point(:, b)%damage)
      end do
   end function bond_damage

   !> Do both ends of a bond share their nodes, so that it cannot open?
   pure logical function is_closed(node)
      integer, intent(in) :: node(4)

      is_closed = node(1) == node(3) .and. node(2) == node(4)
   end function is_closed

   !> Does a bond hold or press, and can it open? (bonds)
   pure function has_stiffness(bonds, memory) result(has)
      type(bonds_t), intent(in) :: bonds
      type(bond_memory_t), intent(in) :: memory
      logical :: has(size(memory%active))
      integer :: b

      has = [(memory%active(b) .and. .not. is_closed(bonds%node(:, b)), b=1, size(has))]
   end function has_stiffness

   !> All bonds as lists of numbers, for checkpoints (values, bonds).
   pure function bond_values(bonds, memory) result(value)
      type(bonds_t), intent(in) :: bonds
      type(bond_memory_t), intent(in) :: memory
      real(wp), allocatable :: value(:, :)
      integer :: b, k

      allocate (value(bond_value_count, size(bonds%length)))
      do b = 1, size(bonds%length)
         value(:, b) = [merge(1.0_wp, 0.0_wp, [memory%active(b), memory%broken(b)]), cohesive_values(bonds%law(b)), &
                        reshape(bonds%shift(:, :, b), [shift_value_count]), (point_values(memory%point(k, b)), k=1, bond_points)]
      end do
   end function bond_values

   !> Bonds that are in place already, from their lists of numbers.
   pure subroutine restore_bonds(value, bonds, memory)
      !> As bond_values gave them (values, bonds)
      real(wp), intent(in) :: value(:, :)
      type(bonds_t), intent(inout) :: bonds
      type(bond_memory_t), intent(inout) :: memory
      integer :: b, k, next

      do b = 1, size(value, 2)
         memory%active(b) = value(1, b) > 0.5_wp
         memory%broken(b) = value(2, b) > 0.5_wp
         next = flags
         bonds%law(b) = cohesive_from_values(value(next + 1:next + cohesive_value_count, b))
         next = next + cohesive_value_count
         bonds%shift(:, :, b) = reshape(value(next + 1:next + shift_value_count, b), [2, bond_points])
         next = next + shift_value_count
         do k = 1, bond_points
            memory%point(k, b) = point_from_values(value(next + 1:next + point_value_count, b))
            next = next + point_value_count
         end do
         memory%watch(b) = merge(followed, watched,.not. memory%active(b) .or. any(memory%point(:, b)%damage > 0.0_wp) .or. &
                                 any(abs(bonds%shift(:, :, b)) > 0.0_wp))
      end do
   end subroutine restore_bonds

   !> All crack events as lists of numbers, for checkpoints (values, events).
   pure function event_values(memory) result(value)
      type(bond_memory_t), intent(in) :: memory
      real(wp), allocatable :: value(:, :)
      integer :: i

      allocate (value(event_value_count, size(memory%event)))
      do i = 1, size(memory%event)
         associate (e => memory%event(i))
            value(:, i) = [e%time, real(e%stage, wp), e%place, e%angle, e%length, real(e%mode, wp), e%energy, e%moment]
         end associate
      end do
   end function event_values

   !> Crack events from their lists of numbers.
   pure subroutine restore_events(value, memory)
      !> As event_values gave them (values, events)
      real(wp), intent(in) :: value(:, :)
      type(bond_memory_t), intent(inout) :: memory
      integer :: i

      memory%event = [(crack_event_t(time=value(1, i), stage=nint(value(2, i)), place=value(3:4, i), angle=value(5, i), &
                                     length=value(6, i), mode=nint(value(7, i)), energy=value(8, i), moment=value(9:12, i)), i=1, &
                       size(value, 2))]
   end subroutine restore_events

end module bonds_m
