!> The joints of a scene: what they are and what passes between their walls, in SI units. Their laws work in MPa and mm:
!> joint_border_m stands between the two.
module joints_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use joint_law_m, only: law_item_t
   use riding_m, only: ride_t
   use closure_tangents_m, only: closure_tangents_t
   use wall_contact_m, only: wall_meeting_t
   implicit none
   private

   !> All joint elements and what their decks say of the coupling
   type, public :: joints_t
      !> Nodes A, B, A', B' (4, joints) and triangles of the lower and upper wall (2, joints)
      integer, allocatable :: node(:, :), triangle(:, :)
      !> Index of the deck's &joint group (joints)
      integer, allocatable :: group(:)
      !> Law with its parameters at the scale of the joint's block edge (joints); penalty stiffness of the walls in its place,
      !> 0: the law's own (joints) [MPa/mm, as the law]. set_law of joint_border_m sets both
      type(law_item_t), allocatable :: law(:)
      real(wp), allocatable :: penalty(:)
      !> Length before any motion (joints) [m]
      real(wp), allocatable :: length(:)
      !> Does dilation push the walls? Velocity friction (eq 4)? Normal stress from the rock (eq 32)? (joints)
      logical, allocatable :: coupled(:), velocity_friction(:), stress_from_walls(:)
      !> Aperture by eq 31 to the letter? (joints)
      logical, allocatable :: literal_aperture(:)
      !> Joints in wall contact (joints); the others are in potential contact
      logical, allocatable :: wall_handled(:)
      !> Is it a bond that has not parted, whose walls are no matter of contact yet? (joints)
      logical, allocatable :: bonded(:)
      !> Has the rock on a side of it been taken out, so that it is a joint no more? (joints)
      logical, allocatable :: gone(:)
      !> Overlap of the walls and slip in the in-situ state, in which nothing has moved (joints) [m]
      real(wp), allocatable :: closed(:), slipped(:)
   end type joints_t

   !> What passes between the walls of joints
   type, public :: tractions_t
      !> Pressure and shear stress at the walls' integration points [Pa]; what is covered of each joint's walls over their length
      !> now [-] (joints)
      real(wp), allocatable :: pressure(:), shear(:), covered(:)
      !> d pressure/d overlap at those of the walls' integration points that press [Pa/m]
      real(wp), allocatable :: by_closure(:)
      !> Normal stiffness of each joint where it is stiffest, weighed by what it covers there (joints) [Pa/m]
      real(wp), allocatable :: contact_stiffness(:)
      !> Larger of normal and shear stiffness when the stable step was last computed (joints) [Pa/m]
      real(wp), allocatable :: stiffness_then(:)
      !> Coupled joints: d dilation/d overlap [-] and d dilation/d weight, the weight as a part of what is covered of the joint's
      !> walls [m], at the integration points
      real(wp), allocatable :: by_overlap(:), by_weight(:)
      !> What the laws are given in a step, as they work, in MPa and mm: mean contact pressure on what is covered of the walls, and
      !> the dilation of coupled joints (joints); Newton's method far from rest: closure by tangents
      real(wp), allocatable :: contact_stress(:)
      type(ride_t), allocatable :: ride(:)
      type(closure_tangents_t) :: tangents
   end type tractions_t

   public :: init_joints, init_tractions, add_joints, make_room, have_stiffened

   !> The stable step has to be computed again when a joint has become this much stiffer
   real(wp), parameter :: stiffer = 1.1_wp

contains

   !> Room and geometry; the caller fills in law, group and options from the deck.
   subroutine init_joints(split, joints)
      type(split_mesh_t), intent(in) :: split
      type(joints_t), intent(out) :: joints
      integer :: n, j

      n = size(split%joint, 2)
      joints%node = split%joint
      joints%triangle = split%joint_triangle
      allocate (joints%group(n), source=0)
      allocate (joints%law(n))
      allocate (joints%penalty(n), source=0.0_wp)
      allocate (joints%coupled(n), joints%velocity_friction(n), joints%stress_from_walls(n), joints%literal_aperture(n), &
                source=.false.)
      allocate (joints%wall_handled(n), source=.true.)
      allocate (joints%bonded(n), source=.false.)
      allocate (joints%closed(n), joints%slipped(n), source=0.0_wp)
      allocate (joints%length(n), joints%gone(n))
      do j = 1, n
         joints%gone(j) = .not. all(split%present(split%joint_triangle(:, j)))
         joints%length(j) = norm2(split%x(:, split%joint(2, j)) - split%x(:, split%joint(1, j)))
      end do
   end subroutine init_joints

   !> Walls that feel nothing yet.
   pure subroutine init_tractions(joints, tractions)
      !> Number of joint elements
      integer, intent(in) :: joints
      type(tractions_t), intent(out) :: tractions

      allocate (tractions%contact_stress(joints), tractions%contact_stiffness(joints), tractions%stiffness_then(joints), &
                source=0.0_wp)
      allocate (tractions%covered(joints), source=1.0_wp)
      allocate (tractions%ride(joints))
      allocate (tractions%pressure(0), tractions%shear(0), tractions%by_closure(0), tractions%by_overlap(0), tractions%by_weight(0))
   end subroutine init_tractions

   !> Room for more joint elements, whose walls feel nothing yet.
   pure subroutine add_joints(joints, tractions)
      !> Number of joint elements, with the new ones
      integer, intent(in) :: joints
      type(tractions_t), intent(inout) :: tractions
      type(tractions_t) :: old

      old = tractions
      call init_tractions(joints, tractions)
      associate (n => size(old%covered))
         tractions%contact_stress(:n) = old%contact_stress
         tractions%contact_stiffness(:n) = old%contact_stiffness
         tractions%covered(:n) = old%covered
         tractions%stiffness_then(:n) = old%stiffness_then
      end associate
   end subroutine add_joints

   !> Room for what is known at the integration points.
   subroutine make_room(met, tractions)
      type(wall_meeting_t), intent(in) :: met
      type(tractions_t), intent(inout) :: tractions

      if (size(tractions%pressure) >= met%points) return
      deallocate (tractions%pressure, tractions%shear, tractions%by_closure, tractions%by_overlap, tractions%by_weight)
      allocate (tractions%pressure(size(met%wall)), tractions%shear(size(met%wall)), tractions%by_closure(size(met%wall)))
      allocate (tractions%by_overlap(size(met%wall)), tractions%by_weight(size(met%wall)))
   end subroutine make_room

   !> Has any joint become so much stiffer against closure that the stable step must be computed again?
   pure logical function have_stiffened(joints, tractions)
      type(joints_t), intent(in) :: joints
      type(tractions_t), intent(in) :: tractions
      integer :: j

      have_stiffened = .true.
      do j = 1, size(joints%penalty)
         if (joints%penalty(j) > 0.0_wp .or. .not. joints%wall_handled(j)) cycle
         if (tractions%contact_stiffness(j) > stiffer*tractions%stiffness_then(j)) return
      end do
      have_stiffened = .false.
   end function have_stiffened

end module joints_m
