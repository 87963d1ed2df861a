!> Prescribed inflows against the network: each must have a way to a prescribed pressure, or room to be stored in.
module inflow_check_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use deck_m, only: deck_t
   use edges_m, only: edge_table_t, build_edges
   use errors_m, only: error_list_t
   use flow_m, only: flow_equations_t, find_network
   use flow_domain_m, only: flow_domain_t, init_flow_domain, set_moment, set_lines, set_apertures, set_storage, boundary_values, &
                            add_sources
   use mesh_m, only: mesh_t, find_group, a_curve
   implicit none
   private

   public :: check_inflows

contains

   !> Find inflows that have nowhere to go at the end of a stage, though all conducted that ever may: the fractures, whatever their
   !> aperture, and every edge of rock that may break. What is lost for other reasons is found when the flow is solved.
   subroutine check_inflows(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors
      type(flow_domain_t) :: model
      type(flow_equations_t) :: equations
      integer, allocatable :: line(:, :), group(:), owner(:)
      logical, allocatable :: fixed(:)
      real(wp), allocatable :: pressure(:), source(:), nothing(:)
      integer :: stage, before, i

      if (all(is_set(deck%flow_boundary%pressure))) return
      call possible_lines(deck, mesh, line, group)
      call init_flow_domain(deck, mesh, model)
      call set_lines(model, mesh, line, group, [(0, i=1, size(group))])
      nothing = [(0.0_wp, i=1, size(group))]
      call set_apertures(model, 1.0_wp + nothing, nothing, nothing, nothing >= 0.0_wp)
      if (deck%transient%line > 0) then
         call set_storage(model, mesh)
         ! Walls and rock that give way take it up
         if (deck%flow%coupling == 'two-way') model%conductors%storage = 1.0_wp
      end if
      allocate (source(size(mesh%x, 2)), source=0.0_wp)
      before = errors%count()
      do stage = min(1, size(deck%stage)), size(deck%stage)
         call set_moment(model, stage, 1.0_wp)
         call boundary_values(model, fixed, pressure, owner)
         if (deck%transient%line > 0) then
            call find_network(model%conductors, fixed, equations, deck%transient%step)
         else
            call find_network(model%conductors, fixed, equations)
         end if
         call add_sources(model, equations, source, errors)
         if (errors%count() > before) return
      end do
   end subroutine check_inflows

   !> Lines that may conduct: of fractures and conduits, and where rock may break all edges of triangles.
   subroutine possible_lines(deck, mesh, line, group)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      !> Nodes (2, lines) and group of the mesh, 0 for cracks (lines)
      integer, allocatable, intent(out) :: line(:, :), group(:)
      type(edge_table_t) :: edges
      logical :: conducts(0:size(mesh%group))
      integer, allocatable :: chosen(:)
      integer :: i, fractures

      conducts = .false.
      do i = 1, size(deck%joint)
         conducts(find_group(mesh%group, deck%joint(i)%group, a_curve)) = .true.
      end do
      do i = 1, size(deck%conduit)
         conducts(find_group(mesh%group, deck%conduit(i)%group, a_curve)) = .true.
      end do
      conducts(0) = .false.
      allocate (chosen(count(conducts(mesh%line_group))))
      chosen = pack([(i, i=1, size(mesh%line_group))], conducts(mesh%line_group))
      line = mesh%line(:, chosen)
      group = mesh%line_group(chosen)
      if (size(deck%cohesive) == 0) return
      call build_edges(mesh%triangle, size(mesh%x, 2), edges)
      fractures = size(group)
      group = [group, [(0, i=1, size(edges%triangles))]]
      line = reshape([line, edges%node], [2, fractures + size(edges%triangles)])
   end subroutine possible_lines

end module inflow_check_m
