!> Impacts in explicit steps. Over the way du from one displacement to the next an overlap does the work d.du, d = (f + f')/2
!> with its forces at either end; what it stores changes from E to E'. The two agree while its energy is quadratic in the way,
!> but not when two triangles meet or part somewhere on it: an impact then gives or takes energy of the order of
!> (omega dt)^2/4 of its own, and what many nodes of a face do at once adds up. So the push d over the step is made shorter
!> (or longer) by a time j
!>
!>     j d.v - j^2/2 sum(d^2/m) = e,     e = d.du + E' - E
!>
!> that takes what is too much, e, out of the motion. Forces that are in balance change neither momentum nor its moment.
module impact_m
   use kinds_m, only: wp
   implicit none
   private

   !> Nodes of a target and of a contactor, one after the other
   integer, parameter :: corners = 3, both = 2*corners
   !> Room for overlaps at first
   integer, parameter :: first_room = 16
   !> Part of the energy of an overlap that is worth mending: much less in a contact that lasts, much more in an impact
   real(wp), parameter :: noticeable = 1.0e-4_wp
   !> Change of its energy within a step below which a contact lasts
   real(wp), parameter :: lasting = 1.0e-2_wp

   !> Overlap of a target with a contactor, in one role
   type :: overlap_t
      !> Objects, and their nodes
      integer :: target = 0, contactor = 0, node(both) = 0
      !> Forces on the nodes (2, nodes) [N/m], energy [J/m]
      real(wp) :: force(2, both) = 0.0_wp, energy = 0.0_wp
   end type overlap_t

   !> Overlaps at this displacement and at the last one; mean forces and e of those whose work was not what they store
   type, public :: impacts_t
      private
      type(overlap_t), allocatable :: now(:), before(:), wrong(:)
      !> How many there are
      integer :: number = 0, number_before = 0, number_wrong = 0
      !> First overlap before of each target (objects), and the next one of the same target (overlaps before); 0: none
      integer, allocatable :: first(:), next(:)
   contains
      procedure :: start
      procedure :: forget
      procedure :: carry_on
      procedure :: begin
      procedure :: note
      procedure :: compare
      procedure :: any_wrong
      procedure :: settle
   end type impacts_t

contains

   !> Nothing overlaps yet.
   subroutine start(self, objects)
      class(impacts_t), intent(out) :: self
      !> Number of objects
      integer, intent(in) :: objects

      allocate (self%now(first_room), self%before(first_room), self%wrong(first_room))
      allocate (self%first(objects), self%next(first_room), source=0)
   end subroutine start

   !> There is nothing near: what overlapped last is of no use.
   pure subroutine forget(self)
      class(impacts_t), intent(inout) :: self

      self%number = 0
   end subroutine forget

   !> Go on with the overlaps of the same rock before it was cut: those of triangles that have parted since are new.
   pure subroutine carry_on(self, old, object, node)
      class(impacts_t), intent(inout) :: self
      type(impacts_t), intent(in) :: old
      !> What each object of old is now, 0 for none (objects of old); nodes of the objects (3, objects)
      integer, intent(in) :: object(:), node(:, :)
      integer :: i

      do i = 1, old%number
         associate (target => object(old%now(i)%target), contactor => object(old%now(i)%contactor))
            if (target == 0 .or. contactor == 0) cycle
            call self%note(target, contactor, node(:, target), node(:, contactor), old%now(i)%force(:, :corners), &
                           old%now(i)%force(:, corners + 1:), old%now(i)%energy)
         end associate
      end do
   end subroutine carry_on

   !> The overlaps of another displacement follow.
   pure subroutine begin(self)
      class(impacts_t), intent(inout) :: self
      type(overlap_t), allocatable :: list(:)

      call move_alloc(self%before, list)
      call move_alloc(self%now, self%before)
      call move_alloc(list, self%now)
      self%number_before = self%number
      self%number = 0
   end subroutine begin

   !> Note an overlap.
   pure subroutine note(self, target, contactor, target_node, contactor_node, target_force, contactor_force, energy)
      class(impacts_t), intent(inout) :: self
      !> Objects, nodes of each
      integer, intent(in) :: target, contactor, target_node(corners), contactor_node(corners)
      !> Forces on the nodes of each (2, nodes) [N/m], energy [J/m]
      real(wp), intent(in) :: target_force(2, corners), contactor_force(2, corners), energy

      call make_room(self%now, self%number)
      associate (new => self%now(self%number))
         new%target = target
         new%contactor = contactor
         new%node(:corners) = target_node
         new%node(corners + 1:) = contactor_node
         new%force(:, :corners) = target_force
         new%force(:, corners + 1:) = contactor_force
         new%energy = energy
      end associate
   end subroutine note

   !> Room for one more overlap at the end of a list.
   pure subroutine make_room(list, number)
      type(overlap_t), allocatable, intent(inout) :: list(:)
      integer, intent(inout) :: number
      type(overlap_t), allocatable :: longer(:)

      if (number == size(list)) then
         allocate (longer(2*number))
         longer(:number) = list
         call move_alloc(longer, list)
      end if
      number = number + 1
   end subroutine make_room

   !> Find the overlaps whose work since the last displacement was not what they have stored or given back.
   subroutine compare(self, x, displacement, before, place)
      class(impacts_t), intent(inout) :: self
      !> Reference coordinates, displacement now (2, nodes) and at the last call (2, layer nodes) [m]
      real(wp), contiguous, intent(in) :: x(:, :), displacement(:, :), before(:, :)
      !> Place of each node in before (nodes)
      integer, intent(in) :: place(:)
      type(overlap_t) :: none
      integer :: i, j

      if (self%number_before > size(self%next)) then
         deallocate (self%next)
         allocate (self%next(size(self%before)))
      end if
      do i = 1, self%number_before
         associate (target => self%before(i)%target)
            self%next(i) = self%first(target)
            self%first(target) = i
         end associate
      end do
      do i = 1, self%number
         j = self%first(self%now(i)%target)
         do while (j > 0)
            if (self%before(j)%contactor == self%now(i)%contactor) exit
            j = self%next(j)
         end do
         if (j > 0) then
            call check(self%before(j), self%now(i))
            ! It is not among those that have gone
            self%before(j)%contactor = 0
         else
            none%node = self%now(i)%node
            call check(none, self%now(i))
         end if
      end do
      do i = 1, self%number_before
         self%first(self%before(i)%target) = 0
         if (self%before(i)%contactor == 0) cycle
         none%node = self%before(i)%node
         call check(self%before(i), none)
      end do

   contains

      !> Compare the work of one overlap with what it stores.
      subroutine check(start, finish)
         type(overlap_t), intent(in) :: start, finish
         real(wp) :: force(2, both), excess
         integer :: k

         excess = finish%energy - start%energy
         ! What lasts changes little, and is wrong by the square of that
         if (abs(excess) <= lasting*(start%energy + finish%energy)) return
         do k = 1, both
            associate (node => finish%node(k))
               force(:, k) = 0.5_wp*(start%force(:, k) + finish%force(:, k))
               excess = excess + force(1, k)*(displacement(1, node) - before(1, place(node))) &
                        + force(2, k)*(displacement(2, node) - before(2, place(node)))
            end associate
         end do
         if (abs(excess) <= noticeable*(start%energy + finish%energy)) return
         call balance_moment(x(:, finish%node) + displacement(:, finish%node), force)
         call make_room(self%wrong, self%number_wrong)
         self%wrong(self%number_wrong) = overlap_t(node=finish%node, force=force, energy=excess)
      end subroutine check
   end subroutine compare

   !> Forces that were in balance where the nodes were before: a couple on the target puts their moment right where they are now.
   pure subroutine balance_moment(position, force)
      !> Positions [m] and forces [N/m] of the nodes of target and contactor (2, nodes)
      real(wp), intent(in) :: position(2, both)
      real(wp), intent(inout) :: force(2, both)
      real(wp) :: arm(2, both), couple
      integer :: k

      arm = position - spread(sum(position(:, :corners), dim=2)/real(corners, wp), 2, both)
      couple = sum(arm(1, :)*force(2, :) - arm(2, :)*force(1, :))/sum(arm(:, :corners)**2)
      do k = 1, corners
         force(:, k) = force(:, k) - couple*[-arm(2, k), arm(1, k)]
      end do
   end subroutine balance_moment

   !> Is there an overlap whose work was not what it stored?
   pure logical function any_wrong(self)
      class(impacts_t), intent(in) :: self

      any_wrong = self%number_wrong > 0
   end function any_wrong

   !> Take what the overlaps did too much, or too little, out of the motion of their nodes, and book it.
   pure subroutine settle(self, mass, fixed, longest, v, contact, external)
      class(impacts_t), intent(inout) :: self
      !> Nodal mass (nodes) [kg per m], prescribed components (2, nodes)
      real(wp), intent(in) :: mass(:)
      logical, intent(in) :: fixed(:, :)
      !> The step that the mean forces acted for [s]
      real(wp), intent(in) :: longest
      !> Velocity at the time of the displacement (2, nodes) [m/s], work against contact and of reactions [J per m]
      real(wp), intent(inout) :: v(:, :), contact, external
      real(wp) :: power, power_fixed, yield, root, time
      integer :: i, k, axis

      do i = 1, self%number_wrong
         associate (force => self%wrong(i)%force, node => self%wrong(i)%node, excess => self%wrong(i)%energy)
            power = 0.0_wp
            power_fixed = 0.0_wp
            yield = 0.0_wp
            do k = 1, both
               do axis = 1, 2
                  power = power + force(axis, k)*v(axis, node(k))
                  if (fixed(axis, node(k))) then
                     power_fixed = power_fixed + force(axis, k)*v(axis, node(k))
                  else
                     yield = yield + force(axis, k)**2/mass(node(k))
                  end if
               end do
            end do
            if (yield <= 0.0_wp) cycle
            root = power**2 - 2.0_wp*yield*excess
            if (root > 0.0_wp) then
               time = 2.0_wp*excess/(power + sign(sqrt(root), power))
            else
               ! They have less energy than that: what is between them stops
               time = power/yield
            end if
            time = sign(min(abs(time), longest), time)
            do k = 1, both
               where (.not. fixed(:, node(k))) v(:, node(k)) = v(:, node(k)) - time*force(:, k)/mass(node(k))
            end do
            contact = contact + time*power - 0.5_wp*time**2*yield
            external = external + time*power_fixed
         end associate
      end do
      self%number_wrong = 0
   end subroutine settle

end module impact_m
