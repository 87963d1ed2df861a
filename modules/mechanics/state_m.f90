!> The state: all that a run remembers. Going back to it is one assignment; a checkpoint is it (keep_state of run_checkpoint_m).
module state_m
   use kinds_m, only: wp, i8
   use constants_m, only: unset
   use joint_point_m, only: joint_point_t
   use wall_contact_m, only: wall_meeting_t
   use corners_m, only: corner_choices_t
   use contact_m, only: contact_state_t
   use bonds_m, only: bond_memory_t
   use joints_m, only: tractions_t, init_tractions
   implicit none
   private

   !> Energy account, J per metre of thickness. What was put in equals what is stored and what was spent:
   !> external = kinetic + strain + contact + friction + fracture + damping + absorbed + residual
   type, public :: energy_t
      !> Stored now: in motion, in the rock
      real(wp) :: kinetic = 0.0_wp, strain = 0.0_wp
      !> Work done so far against normal contact forces (nearly all stored), against friction (with what the joints'
      !> shear springs hold), and against damping
      real(wp) :: contact = 0.0_wp, friction = 0.0_wp, damping = 0.0_wp
      !> Of the work against contact and friction, that of corners of blocks and that of surfaces that are no walls; the rest is
      !> that of walls (shares_m)
      real(wp) :: corners = 0.0_wp, surfaces = 0.0_wp
      !> Work done so far on the cohesive joints: what broke, what rubs in them, what they store
      real(wp) :: fracture = 0.0_wp
      !> Taken away so far by waves that left through absorbing sides
      real(wp) :: absorbed = 0.0_wp
      !> Work done so far by loads, gravity and prescribed motion
      real(wp) :: external = 0.0_wp
      !> Kinetic and strain energy the run started with
      real(wp) :: initial = 0.0_wp
   contains
      procedure :: walls
      procedure :: residual
   end type energy_t

   !> What the implicit solver goes on from, as long as the stage lasts
   type, public :: guess_t
      !> Was the state found by it, in this stage?
      logical :: known = .false.
      !> Part of a cycle's increment to try next
      real(wp) :: part = 1.0_wp
      !> The part that joints have slipped too far in a longer one of, if they have (1: not)
      real(wp) :: slip_part = 1.0_wp
      !> Displacement of the last increment (2, nodes) [m], and what part of a cycle it was (0: none to go by)
      real(wp), allocatable :: move(:, :)
      real(wp) :: move_part = 0.0_wp
   end type guess_t

   !> What two-way coupling remembers of the fluid; nothing is allocated without
   type, public :: fluid_memory_t
      !> At the end of the last step, at the nodes of the mesh as read: pressure, 0 where there is none [Pa]; how it changed in that
      !> step [Pa/s]; what flowed in [m2/s]
      real(wp), allocatable :: pressure(:), rate(:), inflow(:)
      !> Was there fluid between the walls? 1 yes, 0 no (joints)
      integer, allocatable :: filled(:)
      !> What each node holds, where fluid may lag behind the tip of a crack (nodes of the mesh as read) [m2]; not allocated else
      real(wp), allocatable :: content(:)
      !> Last step of time (0: none yet), step that the error allows [s], largest change of pressure so far [Pa]
      real(wp) :: last = 0.0_wp, wanted = 0.0_wp, range = 0.0_wp
      !> What was left in that step of the inflows after what was taken up, over the larger of both [-]
      real(wp) :: imbalance = 0.0_wp
   end type fluid_memory_t

   !> State of the run
   type, public :: state_t
      !> Time [s] and number of steps
      real(wp) :: time = 0.0_wp
      integer(i8) :: step = 0_i8
      !> Displacement [m] and velocity [m/s] (2, nodes)
      real(wp), allocatable :: u(:, :), v(:, :)
      !> Nodal mass, with what mass scaling has added (nodes) [kg per m]
      real(wp), allocatable :: mass(:)
      !> Nodal forces by origin (2, nodes) [N per m]: rock, contact along the normal, friction, loads
      real(wp), allocatable :: solid(:, :), normal(:, :), friction(:, :), load(:, :)
      !> What corners and other surfaces have of normal and friction, at the nodes they can reach (2, nodes) [N per m]; size
      !> zero where nothing is near (shares_m)
      real(wp), allocatable :: corner_force(:, :), surface_force(:, :)
      !> Joint elements (joints), their opening w and aperture (joints) [mm]
      type(joint_point_t), allocatable :: joint(:)
      real(wp), allocatable :: opening(:), aperture(:)
      !> Where walls meet, what passes between them, and which corners of blocks are held
      type(wall_meeting_t) :: walls
      type(tractions_t) :: tractions
      type(corner_choices_t) :: corners
      !> Contact between other surfaces, and friction coefficient of every surface edge in it (surface edges)
      type(contact_state_t) :: contact
      real(wp), allocatable :: surface_friction(:)
      !> Bonds that hold rock together that may break
      type(bond_memory_t) :: bonds
      !> Forces that new cracks let go of smoothly (2, nodes) [N per m], from when and for how long [s]
      real(wp), allocatable :: release(:, :)
      real(wp) :: release_start = 0.0_wp, release_time = 0.0_wp
      !> Forces that the rock taken out in this stage had exerted on the rest, which are let go of over the stage (2, nodes)
      !> [N per m]; size zero where none was
      real(wp), allocatable :: relief(:, :)
      !> Forces that absorbing sides go on with: what their supports had carried, or the in-situ stress (2, nodes) [N per m]; size
      !> zero where there are none
      real(wp), allocatable :: held(:, :)
      !> Viscous nodal forces (2, nodes) [N per m]; size zero without viscous damping
      real(wp), allocatable :: damping(:, :)
      !> Loads now, 0 at the start of the stage, 1 at its end
      real(wp) :: level = 0.0_wp
      !> Level that the nodal loads were found for last (unset: not yet)
      real(wp) :: load_level = unset
      type(guess_t) :: guess
      type(fluid_memory_t) :: fluid
      type(energy_t) :: energy
   end type state_t

   public :: init_state, laws_go_back, kinetic_energy

contains

   !> Everything at rest and unstrained.
   subroutine init_state(mass, joints, damped, state)
      !> Nodal mass (nodes) [kg per m]
      real(wp), intent(in) :: mass(:)
      !> Number of joint elements
      integer, intent(in) :: joints
      !> Is there viscous damping?
      logical, intent(in) :: damped
      type(state_t), intent(out) :: state
      integer :: n

      n = size(mass)
      state%mass = mass
      allocate (state%u(2, n), state%v(2, n), state%solid(2, n), state%normal(2, n), state%friction(2, n), &
                state%load(2, n), state%damping(2, merge(n, 0, damped)), source=0.0_wp)
      allocate (state%guess%move(2, n), source=0.0_wp)
      allocate (state%relief(2, 0), state%held(2, 0), state%corner_force(2, 0), state%surface_force(2, 0))
      allocate (state%joint(joints))
      call init_tractions(joints, state%tractions)
      allocate (state%opening(joints), state%aperture(joints), source=0.0_wp)
   end subroutine init_state

   !> Let joints, bonds and friction springs remember what they did in another state of the same mesh. All else stays: motion,
   !> forces, and where contact is looked for.
   pure subroutine laws_go_back(start, state)
      type(state_t), intent(in) :: start
      type(state_t), intent(inout) :: state

      state%joint = start%joint
      if (allocated(start%bonds%point)) state%bonds%point = start%bonds%point
      if (allocated(start%contact%touches%normal)) state%contact%springs = start%contact%springs
   end subroutine laws_go_back

   !> Energy of motion [J per m of thickness].
   pure real(wp) function kinetic_energy(mass, v)
      !> Nodal mass (nodes) [kg per m]
      real(wp), intent(in) :: mass(:)
      !> Velocity (2, nodes) [m/s]
      real(wp), intent(in) :: v(:, :)

      kinetic_energy = 0.5_wp*(dot_product(mass, v(1, :)**2) + dot_product(mass, v(2, :)**2))
   end function kinetic_energy

   !> Work done so far against contact and friction of walls [J per m of thickness].
   pure real(wp) function walls(self)
      class(energy_t), intent(in) :: self

      walls = self%contact + self%friction - self%corners - self%surfaces
   end function walls

   !> What the account cannot explain [J per m of thickness].
   pure real(wp) function residual(self)
      class(energy_t), intent(in) :: self

      residual = self%initial + self%external - self%kinetic - self%strain - self%contact - self%friction - self%damping &
                 - self%fracture - self%absorbed
   end function residual

end module state_m
