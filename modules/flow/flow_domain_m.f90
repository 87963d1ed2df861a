!> The flow model of a deck and a mesh: what conducts, its outline, and what is prescribed at its boundary.
!>
!> The mesh is taken as read, where the walls of a fracture share their nodes: one pressure a node.
module flow_domain_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use units_m, only: millimetre
   use deck_m, only: deck_t
   use boundary_group_m, only: every_stage
   use conduit_group_m, only: as_flow
   use edges_m, only: edge_table_t, build_edges
   use errors_m, only: error_list_t
   use flow_m, only: conductors_t, flow_equations_t, flow_field_t, find_network, init_flow, solve_flow, describe_flow, &
                     cubic_law, line_length, triangle_area
   use hydraulic_aperture_m, only: hydraulic_law_named, hydraulic_equal, hydraulic_aperture
   use loads_m, only: stage_number
   use mesh_m, only: mesh_t, find_group, place_text, a_point, a_curve, a_surface
   use sparse_lu_m, only: linear_ok
   use outline_m, only: outline_t, find_outline
   use permeability_m, only: permeability_t, find_permeability
   use text_m, only: quoted, to_text
   implicit none
   private

   public :: init_flow_domain, set_moment, set_lines, set_apertures, set_storage, solve_boundary_flow, solve_permeability
   public :: outer_edges
   public :: boundary_values, add_sources, finish_flow, rock_storage, known_flow

   !> What is asked of one &flow_boundary, and its nodes
   type :: prescription_t
      !> Its nodes, each once; what flows in through each for a flux or rate of one, before nodes that do not conduct are left out
      integer, allocatable :: node(:)
      real(wp), allocatable :: share(:)
   end type prescription_t

   type, public :: flow_domain_t
      type(deck_t) :: deck
      type(conductors_t) :: conductors
      type(outline_t) :: outline
      type(prescription_t), allocatable :: boundary(:)
      !> Of each line: law of its hydraulic aperture, JRC in it, aperture prescribed by the deck [mm] or unset (lines)
      integer, allocatable :: law(:)
      real(wp), allocatable :: jrc(:), given_mm(:)
      !> Stiffness of the walls, 0 for rigid ones [Pa/m]; mechanical and hydraulic aperture [m]; block edge, 0 for none (lines)
      real(wp), allocatable :: wall_stiffness(:), mechanical(:), hydraulic(:)
      integer, allocatable :: block_edge(:)
      !> Part of each &flow_boundary that is there now (boundaries)
      real(wp), allocatable :: part(:)
      !> Biot's coefficient of the rock that conducts, 0 elsewhere (triangles)
      real(wp), allocatable :: biot(:)
      real(wp) :: datum(2) = 0.0_wp
   end type flow_domain_t

   !> What the boundary conditions of the deck give
   type, public :: boundary_flow_t
      type(flow_field_t) :: field
      !> Inflow through each &flow_boundary; nodes of two count for the later [m2/s] (boundaries)
      real(wp), allocatable :: inflow(:)
      integer :: parts = 0, parts_left_out = 0
      !> Is a known pressure felt there? (nodes)
      logical, allocatable :: reached(:)
      !> Lines in parts that no known pressure reaches
      integer :: lines_left_out = 0
   end type boundary_flow_t

contains

   !> Build what does not change: rock, outline, boundary. Names were checked (flow_check_m).
   subroutine init_flow_domain(deck, mesh, model)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(flow_domain_t), intent(out) :: model
      integer, allocatable :: edge(:, :)
      real(wp) :: permeability(0:size(mesh%group)), biot(0:size(mesh%group)), u(2), v(2), area
      integer :: i, t

      model%deck = deck
      model%datum = mesh%datum
      model%conductors%x = mesh%x
      model%conductors%triangle = mesh%triangle
      model%conductors%weight = deck%fluid%density*[deck%gravity%gx, deck%gravity%gy]
      permeability = 0.0_wp
      biot = 0.0_wp
      do i = 1, size(deck%porous)
         permeability(find_group(mesh%group, deck%porous(i)%group, a_surface)) = deck%porous(i)%permeability
         if (deck%porous(i)%permeability > 0.0_wp) &
            biot(find_group(mesh%group, deck%porous(i)%group, a_surface)) = deck%porous(i)%biot
      end do
      model%biot = biot(mesh%triangle_group)
      model%conductors%mobility = permeability(mesh%triangle_group)/deck%fluid%viscosity
      area = 0.0_wp
      do t = 1, size(mesh%triangle, 2)
         u = mesh%x(:, mesh%triangle(2, t)) - mesh%x(:, mesh%triangle(1, t))
         v = mesh%x(:, mesh%triangle(3, t)) - mesh%x(:, mesh%triangle(1, t))
         area = area + 0.5_wp*(u(1)*v(2) - u(2)*v(1))
      end do
      call outer_edges(deck, mesh, edge)
      call find_outline(mesh%x, edge, area, model%outline)
      allocate (model%boundary(size(deck%flow_boundary)))
      model%part = [(merge(1.0_wp, 0.0_wp, deck%flow_boundary(i)%stage == every_stage), i=1, size(deck%flow_boundary))]
      do i = 1, size(model%boundary)
         call prescribe(mesh, deck%flow_boundary(i)%group, is_set(deck%flow_boundary(i)%flux), model%boundary(i))
      end do
   end subroutine init_flow_domain

   !> Edges of the outer boundary: of one triangle each or, where there are none, the lines that are no conduit.
   subroutine outer_edges(deck, mesh, edge)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      !> (2, edges)
      integer, allocatable, intent(out) :: edge(:, :)
      type(edge_table_t) :: edges
      logical :: outline(0:size(mesh%group))
      integer :: i

      if (size(mesh%triangle, 2) > 0) then
         call build_edges(mesh%triangle, size(mesh%x, 2), edges)
         edge = edges%node(:, pack([(i, i=1, size(edges%triangles))], edges%triangles == 1))
      else
         outline = .true.
         do i = 1, size(deck%conduit)
            outline(find_group(mesh%group, deck%conduit(i)%group, a_curve)) = .false.
         end do
         edge = mesh%line(:, pack([(i, i=1, size(mesh%line_group))], outline(mesh%line_group)))
      end if
   end subroutine outer_edges

   !> Nodes of a boundary group, and their shares of its inflow: half of each edge's length for a flux, one each for a rate.
   subroutine prescribe(mesh, name, by_length, prescription)
      type(mesh_t), intent(in) :: mesh
      character(len=*), intent(in) :: name
      logical, intent(in) :: by_length
      type(prescription_t), intent(out) :: prescription
      real(wp) :: share(size(mesh%x, 2))
      logical :: member(size(mesh%x, 2))
      integer :: group, i

      share = 0.0_wp
      member = .false.
      group = find_group(mesh%group, name, a_curve)
      if (group > 0) then
         do i = 1, size(mesh%line, 2)
            if (mesh%line_group(i) /= group) cycle
            associate (a => mesh%line(1, i), b => mesh%line(2, i))
               member([a, b]) = .true.
               share([a, b]) = share([a, b]) + 0.5_wp*norm2(mesh%x(:, b) - mesh%x(:, a))
            end associate
         end do
      else
         group = find_group(mesh%group, name, a_point)
         do i = 1, size(mesh%point)
            if (mesh%point_group(i) == group) member(mesh%point(i)) = .true.
         end do
      end if
      if (.not. by_length) share = 1.0_wp
      prescription%node = pack([(i, i=1, size(member))], member)
      prescription%share = share(prescription%node)
   end subroutine prescribe

   !> What is there of the boundary conditions: those of this stage grow evenly over its cycles, those of earlier ones are there.
   subroutine set_moment(model, stage, level)
      type(flow_domain_t), intent(inout) :: model
      !> Number of the stage; 0 at its start, 1 at its end
      integer, intent(in) :: stage
      real(wp), intent(in) :: level
      integer :: i, given

      do i = 1, size(model%part)
         given = stage_number(model%deck%stage%name, model%deck%flow_boundary(i)%stage)
         model%part(i) = 0.0_wp
         if (given < stage) model%part(i) = 1.0_wp
         if (given == stage) model%part(i) = level
      end do
   end subroutine set_moment

   !> The lines that may conduct.
   subroutine set_lines(model, mesh, line, group, block_edge)
      type(flow_domain_t), intent(inout) :: model
      type(mesh_t), intent(in) :: mesh
      !> Nodes of the mesh as read (2, lines); group of the mesh, 0 for cracks (lines); block edge, 0 for none (lines)
      integer, intent(in) :: line(:, :), group(:), block_edge(:)
      integer :: law(0:size(mesh%group)), i, g
      real(wp), dimension(0:size(mesh%group)) :: jrc, given_mm, wall_stiffness

      wall_stiffness = 0.0_wp
      law = hydraulic_law_named(model%deck%flow%hydraulic)
      law(0) = hydraulic_equal
      jrc = 0.0_wp
      given_mm = -1.0_wp
      do i = 1, size(model%deck%joint)
         g = find_group(mesh%group, model%deck%joint(i)%group, a_curve)
         jrc(g) = max(model%deck%joint(i)%settings%number('jrc0'), 0.0_wp)
      end do
      do i = 1, size(model%deck%conduit)
         associate (conduit => model%deck%conduit(i))
            g = find_group(mesh%group, conduit%group, a_curve)
            if (conduit%hydraulic /= as_flow) law(g) = hydraulic_law_named(conduit%hydraulic)
            if (is_set(conduit%jrc)) jrc(g) = conduit%jrc
            if (is_set(conduit%aperture_mm)) given_mm(g) = conduit%aperture_mm
            if (is_set(conduit%wall_stiffness)) wall_stiffness(g) = conduit%wall_stiffness
         end associate
      end do
      model%conductors%line = line
      model%law = law(group)
      model%jrc = jrc(group)
      model%given_mm = given_mm(group)
      model%wall_stiffness = wall_stiffness(group)
      model%block_edge = block_edge
   end subroutine set_lines

   !> Hydraulic apertures of the lines, and what they conduct.
   subroutine set_apertures(model, aperture_mm, mobilisation, jrc_mobilised, filled)
      type(flow_domain_t), intent(inout) :: model
      !> Mechanical aperture, where the deck does not give it [mm] (lines)
      real(wp), intent(in) :: aperture_mm(:)
      !> Slip over peak slip, and mobilised JRC [-] (lines)
      real(wp), intent(in) :: mobilisation(:), jrc_mobilised(:)
      !> Is it a fracture or a crack that is open, rather than a bond that holds? (lines)
      logical, intent(in) :: filled(:)

      model%mechanical = millimetre*merge(model%given_mm, aperture_mm, model%given_mm >= 0.0_wp)
      where (.not. filled) model%mechanical = 0.0_wp
      model%hydraulic = hydraulic_aperture(model%law, model%mechanical, model%jrc, mobilisation, jrc_mobilised)
      model%conductors%line_mobility = cubic_law(model%hydraulic, model%deck%fluid%viscosity)
   end subroutine set_apertures

   !> What nodes take up: fluid pressed together in fractures, walls that give way, the storage of the rock. A joint of length
   !> L has L (a cf + 1/kn), half of it at either end; a triangle a third of its own at each corner.
   subroutine set_storage(model, mesh)
      type(flow_domain_t), intent(inout) :: model
      type(mesh_t), intent(in) :: mesh
      real(wp) :: specific(size(mesh%triangle_group)), taken
      integer :: i

      specific = rock_storage(model, mesh)
      associate (conductors => model%conductors)
         conductors%storage = [(0.0_wp, i=1, size(conductors%x, 2))]
         do i = 1, size(conductors%line, 2)
            if (.not. conductors%line_mobility(i) > 0.0_wp) cycle
            taken = model%mechanical(i)*model%deck%fluid%compressibility
            if (model%wall_stiffness(i) > 0.0_wp) taken = taken + 1.0_wp/model%wall_stiffness(i)
            associate (node => conductors%line(:, i))
               conductors%storage(node) = conductors%storage(node) + 0.5_wp*line_length(conductors, i)*taken
            end associate
         end do
         do i = 1, size(conductors%triangle, 2)
            if (.not. conductors%mobility(i) > 0.0_wp) cycle
            associate (node => conductors%triangle(:, i))
               conductors%storage(node) = conductors%storage(node) &
                                          + triangle_area(conductors, i)*specific(i)/3.0_wp
            end associate
         end do
      end associate
   end subroutine set_storage

   !> Storage of the rock (triangles) [1/Pa].
   pure function rock_storage(model, mesh) result(storage)
      type(flow_domain_t), intent(in) :: model
      type(mesh_t), intent(in) :: mesh
      real(wp) :: storage(size(mesh%triangle_group))
      real(wp) :: specific(0:size(mesh%group))
      integer :: i

      specific = 0.0_wp
      do i = 1, size(model%deck%porous)
         specific(find_group(mesh%group, model%deck%porous(i)%group, a_surface)) = model%deck%porous(i)%storage
      end do
      storage = specific(mesh%triangle_group)
   end function rock_storage

   !> Nodes where the deck prescribes a pressure, and that [Pa]; the boundary that each node counts for, 0 for none (nodes).
   subroutine boundary_values(model, fixed, pressure, owner)
      type(flow_domain_t), intent(in) :: model
      logical, allocatable, intent(out) :: fixed(:)
      real(wp), allocatable, intent(out) :: pressure(:)
      integer, allocatable, intent(out) :: owner(:)
      integer :: i

      allocate (pressure(size(model%conductors%x, 2)), source=0.0_wp)
      allocate (fixed(size(pressure)), source=.false.)
      allocate (owner(size(pressure)), source=0)
      do i = 1, size(model%boundary)
         associate (boundary => model%deck%flow_boundary(i), node => model%boundary(i)%node)
            if (.not. model%part(i) > 0.0_wp) cycle
            owner(node) = i
            if (.not. is_set(boundary%pressure)) cycle
            fixed(node) = .true.
            pressure(node) = model%part(i)* &
                             (boundary%pressure + boundary%pressure_dx*(model%datum(1) + model%conductors%x(1, node)) &
                              + boundary%pressure_dy*(model%datum(2) + model%conductors%x(2, node)))
         end associate
      end do
   end subroutine boundary_values

   !> Sums over boundaries, and what was left out.
   subroutine finish_flow(model, equations, owner, flow)
      type(flow_domain_t), intent(in) :: model
      type(flow_equations_t), intent(in) :: equations
      integer, intent(in) :: owner(:)
      type(boundary_flow_t), intent(inout) :: flow
      integer :: k

      flow%parts = equations%parts
      flow%reached = equations%reached
      flow%parts_left_out = equations%parts_left_out
      flow%lines_left_out = count(model%conductors%line_mobility > 0.0_wp .and. &
                                  .not. equations%reached(model%conductors%line(1, :)))
      flow%inflow = [(0.0_wp, k=1, size(model%boundary))]
      do k = 1, size(owner)
         if (owner(k) > 0) flow%inflow(owner(k)) = flow%inflow(owner(k)) + flow%field%inflow(k)
      end do
   end subroutine finish_flow

   !> The flow of a pressure that is known, and the inflows it was found with.
   subroutine known_flow(model, pressure, inflow, imbalance, flow)
      type(flow_domain_t), intent(in) :: model
      !> (nodes) [Pa], [m2/s]
      real(wp), intent(in) :: pressure(:), inflow(:)
      !> What was left of the inflows after what was taken up [-]
      real(wp), intent(in) :: imbalance
      type(boundary_flow_t), intent(out) :: flow
      type(flow_equations_t) :: equations
      real(wp), allocatable :: prescribed(:)
      logical, allocatable :: fixed(:)
      integer, allocatable :: owner(:)

      call boundary_values(model, fixed, prescribed, owner)
      call find_network(model%conductors, fixed, equations)
      ! What conducts takes up fluid, and has a pressure
      equations%reached = equations%part > 0
      equations%parts_left_out = 0
      call describe_flow(model%conductors, equations, pressure, flow%field)
      flow%field%inflow = inflow
      flow%field%imbalance = imbalance
      call finish_flow(model, equations, owner, flow)
   end subroutine known_flow

   !> Solve for what the deck prescribes at the boundary.
   subroutine solve_boundary_flow(model, flow, errors)
      type(flow_domain_t), intent(in) :: model
      type(boundary_flow_t), intent(out) :: flow
      !> An inflow into a part that no pressure reaches, or a failure of the linear solver
      type(error_list_t), intent(inout) :: errors
      type(flow_equations_t) :: equations
      real(wp), allocatable :: pressure(:), source(:)
      logical, allocatable :: fixed(:)
      integer, allocatable :: owner(:)
      integer :: status, before

      before = errors%count()
      call boundary_values(model, fixed, pressure, owner)
      allocate (source(size(pressure)), source=0.0_wp)
      call init_flow(model%conductors, fixed, equations, status)
      call add_sources(model, equations, source, errors)
      if (status == linear_ok .and. errors%count() == before) &
         call solve_flow(model%conductors, equations, pressure, source, flow%field, status)
      if (status /= linear_ok) call errors%add('flow: '//equations%lu%message())
      call equations%lu%free()
      if (errors%count() == before) call finish_flow(model, equations, owner, flow)
   end subroutine solve_boundary_flow

   !> Inflows at the nodes. An inflow into what does not conduct, or has no way to a known pressure, is an error.
   subroutine add_sources(model, equations, source, errors)
      type(flow_domain_t), intent(in) :: model
      type(flow_equations_t), intent(in) :: equations
      real(wp), intent(inout) :: source(:)
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: what
      logical, allocatable :: conducts(:)
      real(wp) :: value
      integer :: i, lost

      do i = 1, size(model%boundary)
         associate (boundary => model%deck%flow_boundary(i), node => model%boundary(i)%node, share => model%boundary(i)%share)
            if (is_set(boundary%pressure) .or. .not. model%part(i) > 0.0_wp) cycle
            what = model%deck%path//':'//to_text(boundary%line)//': &flow_boundary group = '//quoted(boundary%group)
            conducts = equations%part(node) > 0
            value = boundary%flux
            if (is_set(boundary%rate)) then
               value = boundary%rate/real(max(1, count(conducts)), wp)
            else
               conducts = .true.
            end if
            if (count(conducts) == 0) call errors%add(what//', rate: nothing conducts at its nodes')
            lost = findloc(conducts .and. .not. equations%reached(node), .true., dim=1)
            if (lost > 0) call errors%add(what//', '//trim(merge('rate', 'flux', is_set(boundary%rate)))//': the node at '// &
                                          place_text(model%conductors%x(:, node(lost)), model%datum)//' is in a part of the '// &
                                          'network from which nothing leads to a prescribed pressure; it must be connected to one')
            where (conducts .and. .not. equations%fixed(node)) source(node) = source(node) + model%part(i)*value*share
         end associate
      end do
   end subroutine add_sources

   !> Equivalent permeability with the apertures there are now.
   subroutine solve_permeability(model, permeability, errors)
      type(flow_domain_t), intent(in) :: model
      type(permeability_t), intent(out) :: permeability
      type(error_list_t), intent(inout) :: errors
      integer :: status

      call find_permeability(model%conductors, model%outline, model%deck%fluid%viscosity, model%block_edge, permeability, status)
      if (status /= linear_ok) call errors%add('equivalent permeability: the linear solver failed')
   end subroutine solve_permeability

end module flow_domain_m
