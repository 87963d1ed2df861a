!> What fractures and rock take up of the fluid in a step of time, and the pressure that follows from it.
!>
!> At each node what flows in is what is taken up (Biot 1941, J Appl Phys 12:155): the opening of the walls and the pressing
!> together of the fluid between them; b times the volume the rock gains, and its storage at constant strain (1/M) times the
!> pressure.
!>
!> Fixed-stress split: while the pressure changes the stress is taken to stay, so that rock takes up b^2/(lambda + mu) and walls
!> 1/kn for each pascal more. Only how fast the passes converge hangs on it: what is left to be balanced is exact.
!>
!> Linear pressures on linear displacements ring where the fluid has no time to flow: rock feels the mean of a triangle alone.
!> What the pressure's change has besides that mean is therefore held back by the compliance of rock that can only be strained
!> upright, as if each corner had a third of it: nothing is lost by it, and it vanishes with the square of the size of the
!> elements (the perturbation of Aguilar, Gaspar, Lisbona and Rodrigo 2008, Int J Numer Meth Eng 75:1282, element by element).
module fluid_storage_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use flow_m, only: flow_equations_t, flow_field_t, init_flow, solve_flow, line_length, triangle_area
   use flow_domain_m, only: flow_domain_t, boundary_values, add_sources, rock_storage
   use mesh_m, only: mesh_t, split_mesh_t
   use sparse_lu_m, only: linear_ok
   use pore_pressure_m, only: rock_growth
   use solid_m, only: solid_t
   use state_m, only: state_t
   implicit none
   private

   public :: start_storage, begin_balance, make_room, pressure_in_time

   type, public :: fluid_storage_t
      private
      !> Storage of the rock at constant strain (triangles) [1/Pa]
      real(wp), allocatable :: specific(:)
      !> Of the rock: lambda + mu and mu (triangles) [Pa]; least Young's modulus [Pa] and extent [m]
      real(wp), allocatable :: bulk(:), shear(:)
      real(wp) :: young = 0.0_wp, extent = 0.0_wp
      !> At the start of the step: growth of the rock (triangles) [m2], fluid in the joints (joints) [m], pressure (nodes) [Pa]
      real(wp), allocatable :: growth(:), content(:), pressure(:)
   end type fluid_storage_t

contains

   !> What stays as it is through the run.
   subroutine start_storage(model, mesh, solid, storage)
      type(flow_domain_t), intent(in) :: model
      type(mesh_t), intent(in) :: mesh
      type(solid_t), intent(in) :: solid
      type(fluid_storage_t), intent(out) :: storage

      storage%specific = rock_storage(model, mesh)
      storage%bulk = (solid%lambda_area + solid%mu_area)/solid%area
      storage%shear = solid%mu_area/solid%area
      storage%young = minval(solid%young)
      storage%extent = maxval(maxval(mesh%x, dim=2) - minval(mesh%x, dim=2))
   end subroutine start_storage

   !> Remember what there is at the start of a step.
   subroutine begin_balance(storage, model, split, state)
      type(fluid_storage_t), intent(inout) :: storage
      !> With the apertures of the state
      type(flow_domain_t), intent(in) :: model
      type(split_mesh_t), intent(in) :: split
      type(state_t), intent(in) :: state

      storage%growth = rock_growth(split, state%u)
      storage%content = merge(model%mechanical, 0.0_wp, state%fluid%filled > 0)
      storage%pressure = state%fluid%pressure
   end subroutine begin_balance

   !> Joint elements that cracks have added in the step: there was no fluid in them.
   subroutine make_room(storage, joints)
      type(fluid_storage_t), intent(inout) :: storage
      !> Number of joint elements
      integer, intent(in) :: joints
      integer :: i

      if (allocated(storage%content)) storage%content = [storage%content, [(0.0_wp, i=size(storage%content) + 1, joints)]]
   end subroutine make_room

   !> Pressure at the end of the step from that tried and what is left to be balanced with it.
   subroutine pressure_in_time(storage, model, split, state, duration, pressure, found, inflow, imbalance, errors)
      type(fluid_storage_t), intent(in) :: storage
      !> With the apertures of the state
      type(flow_domain_t), intent(inout) :: model
      type(split_mesh_t), intent(in) :: split
      !> At rest under the pressure tried
      type(state_t), intent(in) :: state
      !> Of the step [s]
      real(wp), intent(in) :: duration
      !> Tried (nodes of the mesh as read) [Pa]
      real(wp), intent(in) :: pressure(:)
      !> (nodes of the mesh as read) [Pa]; what flows in at each of them [m2/s]
      real(wp), allocatable, intent(out) :: found(:), inflow(:)
      !> What is left of the inflows after what is taken up, over the larger of what flows and what is taken up [-]
      real(wp), intent(out) :: imbalance
      type(error_list_t), intent(inout) :: errors
      type(flow_equations_t) :: equations
      type(flow_field_t) :: field
      real(wp), allocatable :: prescribed(:), taken(:)
      logical, allocatable :: fixed(:)
      integer, allocatable :: owner(:)
      integer :: status, before

      before = errors%count()
      imbalance = 0.0_wp
      call balance(storage, model, split, state, pressure, taken)
      call boundary_values(model, fixed, prescribed, owner)
      call init_flow(model%conductors, fixed, equations, status, duration)
      allocate (inflow(size(pressure)), source=0.0_wp)
      call add_sources(model, equations, inflow, errors)
      if (status == linear_ok .and. errors%count() == before) &
         call solve_flow(model%conductors, equations, prescribed, inflow - taken/duration, field, status, pressure)
      if (status /= linear_ok) call errors%add('flow: '//equations%lu%message())
      call equations%lu%free()
      if (errors%count() > before) return
      found = field%pressure
      where (.not. equations%reached) found = 0.0_wp
      where (fixed .and. equations%reached) inflow = field%inflow + taken/duration
      imbalance = sum(inflow - taken/duration, mask=equations%reached)/ &
                  max(sum(abs(inflow)), sum(abs(taken), mask=equations%reached)/duration, tiny(imbalance))
   end subroutine pressure_in_time

   !> What the nodes have taken up since the start of the step, and what more they would for each pascal at constant stress.
   subroutine balance(storage, model, split, state, pressure, taken)
      type(fluid_storage_t), intent(in) :: storage
      !> Its storage is set
      type(flow_domain_t), intent(inout) :: model
      type(split_mesh_t), intent(in) :: split
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: pressure(:)
      !> (nodes of the mesh as read) [m2]
      real(wp), allocatable, intent(out) :: taken(:)
      real(wp) :: growth(size(storage%specific)), half, area, held, change(size(pressure)), walls, open_length, least_stiffness
      integer :: i

      growth = rock_growth(split, state%u) - storage%growth
      change = pressure - storage%pressure
      allocate (taken(size(pressure)), source=0.0_wp)
      associate (conductors => model%conductors)
         conductors%storage = 0.0_wp*pressure
         ! The rock around a crack is as stiff against it as the crack is short
         open_length = 0.0_wp
         do i = 1, size(conductors%line, 2)
            if (max(model%mechanical(i), storage%content(i)) > 0.0_wp) open_length = open_length + line_length(conductors, i)
         end do
         least_stiffness = 0.0_wp
         if (open_length > 0.0_wp) least_stiffness = storage%young/min(open_length, storage%extent)
         do i = 1, size(conductors%line, 2)
            associate (node => conductors%line(:, i), wide => model%mechanical(i))
               if (.not. max(wide, storage%content(i)) > 0.0_wp) cycle
               half = 0.5_wp*line_length(conductors, i)
               walls = max(least_stiffness, state%tractions%contact_stiffness(i))
               taken(node) = taken(node) + half*(wide - storage%content(i) &
                                                 + wide*model%deck%fluid%compressibility*change(node))
               conductors%storage(node) = conductors%storage(node) &
                                          + half*(wide*model%deck%fluid%compressibility + 1.0_wp/walls)
            end associate
         end do
         do i = 1, size(conductors%triangle, 2)
            if (.not. conductors%mobility(i) > 0.0_wp) cycle
            associate (node => conductors%triangle(:, i), b => model%biot(i))
               area = triangle_area(conductors, i)
               held = area*b**2/(3.0_wp*(storage%bulk(i) + storage%shear(i)))
               taken(node) = taken(node) + b*growth(i)/3.0_wp + area*storage%specific(i)*change(node)/3.0_wp &
                             + held*(change(node) - sum(change(node))/3.0_wp)
               conductors%storage(node) = conductors%storage(node) &
                                          + area*(storage%specific(i) + b**2/storage%bulk(i))/3.0_wp + held
            end associate
         end do
      end associate
   end subroutine balance

end module fluid_storage_m
