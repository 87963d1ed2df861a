!> Flow without mechanics: a deck with a &flow and no stage. The mesh may be fractures alone, lines without rock.
module flow_alone_m
   use kinds_m, only: wp, i8
   use constants_m, only: is_set
   use deck_m, only: deck_t
   use errors_m, only: error_list_t
   use field_list_m, only: field_list_t
   use fields_m, only: fields_t
   use flow_check_m, only: check_flow_groups
   use flow_m, only: no_pressure
   use inflow_check_m, only: check_inflows
   use flow_domain_m, only: outer_edges
   use flow_results_m, only: flow_results_t, flow_moment_t
   use log_m, only: log_t
   use mesh_check_m, only: check_mesh
   use mesh_m, only: mesh_t, split_mesh_t, find_group, a_curve
   use outline_m, only: outline_t, find_outline
   use permeability_m, only: permeability_t
   use provenance_m, only: provenance_of
   use story_m, only: command_text
   use text_m, only: to_text
   use transient_flow_m, only: transient_flow_t, start_transient, advance, end_transient
   use topology_m, only: topology_t, scan_topology
   implicit none
   private

   !> A last interval that is rounding of the others [-]
   real(wp), parameter :: rounding = 1.0e-9_wp

   public :: check_flow_mesh, run_flow_alone, as_network

contains

   !> Check a mesh for flow alone.
   subroutine check_flow_mesh(deck, mesh, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      type(error_list_t), intent(inout) :: errors

      integer, allocatable :: edge(:, :)
      type(outline_t) :: outline

      if (size(mesh%triangle, 2) > 0) call check_mesh(mesh, errors)
      call check_flow_groups(deck, mesh, errors)
      if (.not. errors%any()) call check_inflows(deck, mesh, errors)
      if (errors%any() .or. size(mesh%triangle, 2) > 0 .or. .not. deck%flow%permeability) return
      call outer_edges(deck, mesh, edge)
      call find_outline(mesh%x, edge, 0.0_wp, outline)
   if (.not. outline%rectangle) call errors%add(deck%path//': &flow permeability: in a mesh of lines without rock the physical '// &
                                                   'curves that are no &conduit must make up a rectangle along the axes, the '// &
                                                   'outline; or permeability = .false.')
   end subroutine check_flow_mesh

   !> Solve once, write tables and fields.
   subroutine run_flow_alone(deck, mesh, directory, log, errors)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      !> Results directory; it exists
      character(len=*), intent(in) :: directory
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      type(flow_results_t) :: flow
      type(fields_t) :: fields
      type(field_list_t) :: nothing
      type(split_mesh_t) :: network
      type(topology_t) :: topology
      type(permeability_t) :: permeability
      type(flow_moment_t) :: moment
      real(wp), allocatable :: zero(:)
      integer, allocatable :: line(:)
      integer :: i

      call conduit_lines(deck, mesh, line)
      call as_network(deck, mesh, mesh%line(:, line), mesh%line_group(line), network)
      call scan_topology(network, topology)
      allocate (zero(size(network%joint, 2)), source=0.0_wp)
      call flow%open(directory//'/', deck, mesh, .false., 0.0_wp, errors)
      call flow%take(network%joint(1:2, :), network%joint_group, topology%edge_of_joint, zero, zero, zero, zero >= 0.0_wp, errors)
      moment%stress = no_pressure()
      call flow%write_row(moment, errors, permeability)
      if (.not. errors%any()) &
         call fields%init(directory, network, topology%edge_of_joint, nothing, provenance_of(command_text(), ''), errors)
      if (.not. errors%any()) then
         if (deck%transient%line > 0) then
            call run_in_time(flow, fields, moment, network%origin, log, errors)
         else
            call write_fields(flow, fields, moment, network%origin, errors)
         end if
      end if
      call flow%close()
      if (errors%any()) return
      call log%say('flow      '//to_text(count(flow%model%hydraulic > 0.0_wp))//' conducting lines on '// &
                   to_text(size(topology%edge_length))//' block edges, '// &
                   to_text(count(flow%model%conductors%mobility > 0.0_wp))//' conducting triangles')
      if (size(deck%flow_boundary) > 0) then
         do i = 1, size(deck%flow_boundary)
            call log%say('          inflow through '//trim(deck%flow_boundary(i)%group)//' '//to_text(flow%solution%inflow(i))// &
                         ' m2/s')
         end do
         if (flow%solution%parts_left_out > 0) &
            call log%say('          '//to_text(flow%solution%parts_left_out)//' of '//to_text(flow%solution%parts)// &
                         ' parts of the network ('//to_text(flow%solution%lines_left_out)//' lines) have no way to a '// &
                         'prescribed pressure: left out')
      end if
      if (deck%flow%permeability) call tell_permeability(permeability, log)
   end subroutine run_flow_alone

   !> A snapshot.
   subroutine write_fields(flow, fields, moment, origin, errors)
      type(flow_results_t), intent(in) :: flow
      type(fields_t), intent(inout) :: fields
      type(flow_moment_t), intent(in) :: moment
      integer, intent(in) :: origin(:)
      type(error_list_t), intent(inout) :: errors
      type(field_list_t) :: list

      call flow%add_fields(origin, list)
      call fields%write(moment%time, nint(moment%number(1), i8), 'flow', 0, list, errors)
   end subroutine write_fields

   !> Flow that changes with time, with a row and a snapshot at each output.
   subroutine run_in_time(flow, fields, moment, origin, log, errors)
      type(flow_results_t), intent(inout) :: flow
      type(fields_t), intent(inout) :: fields
      type(flow_moment_t), intent(inout) :: moment
      integer, intent(in) :: origin(:)
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      type(transient_flow_t) :: transient
      integer :: i, outputs
      real(wp) :: interval

      associate (settings => flow%model%deck%transient)
         interval = settings%duration
         if (is_set(settings%output_interval)) interval = min(settings%output_interval, interval)
         outputs = ceiling(settings%duration/interval - rounding)
         call start_transient(flow%model, transient)
         do i = 1, outputs
            call advance(flow%model, min(real(i, wp)*interval, settings%duration), transient, flow%solution, errors)
            if (errors%any()) exit
            moment%time = transient%time
            moment%number(1) = real(transient%steps, wp)
            call flow%write_flow_row(moment, errors)
            call write_fields(flow, fields, moment, origin, errors)
         end do
      end associate
      call log%say('transient '//to_text(transient%steps)//' steps, '//to_text(transient%redone)//' redone, to '// &
                   to_text(transient%time)//' s (last step '//to_text(transient%last)//' s)')
      call end_transient(transient)
   end subroutine run_in_time

   !> Say what was found of the permeability.
   subroutine tell_permeability(permeability, log)
      type(permeability_t), intent(in) :: permeability
      type(log_t), intent(in) :: log
      character(len=*), parameter :: axis(2) = ['x', 'y']
      integer :: i

      call log%say('k         linear pressure: kxx '//to_text(permeability%linear(1))//', kyy '//to_text(permeability%linear(2))// &
                   ', kxy '//to_text(permeability%linear(3))//' m2; principal '//to_text(permeability%principal(1))//', '// &
                   to_text(permeability%principal(2))//' m2, the larger at '//to_text(permeability%angle)//' degrees')
      do i = 1, 2
         if (permeability%percolates(i)) then
            call log%say('          sides closed: k'//axis(i)//' '//to_text(permeability%closed(i))//' m2; the top 10 % of the '// &
                         'block edges carry '//to_text(100.0_wp*permeability%top(i))//' % of the flow')
         else if (permeability%has_sides) then
            call log%say('          sides closed: k'//axis(i)//' = 0, nothing leads through along '//axis(i)// &
                         ' (the network does not percolate)')
         end if
      end do
      if (permeability%parts_left_out > 0) &
         call log%say('          '//to_text(permeability%parts_left_out)//' of '//to_text(permeability%parts)// &
                      ' parts of the network do not reach the boundary: left out')
   end subroutine tell_permeability

   !> The lines that conduct: those of the deck's conduits.
   subroutine conduit_lines(deck, mesh, line)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      integer, allocatable, intent(out) :: line(:)
      logical :: conduit(0:size(mesh%group))
      integer :: i

      conduit = .false.
      do i = 1, size(deck%conduit)
         conduit(find_group(mesh%group, deck%conduit(i)%group, a_curve)) = .true.
      end do
      allocate (line(count(conduit(mesh%line_group))))
      line = pack([(i, i=1, size(mesh%line_group))], conduit(mesh%line_group))
   end subroutine conduit_lines

   !> The mesh as read as one with joints, for the results: a joint is a line whose walls share their nodes.
   subroutine as_network(deck, mesh, line, group, network)
      type(deck_t), intent(in) :: deck
      type(mesh_t), intent(in) :: mesh
      !> Nodes of the mesh as read (2, lines), group (lines)
      integer, intent(in) :: line(:, :), group(:)
      type(split_mesh_t), intent(out) :: network
      integer :: i, n

      n = size(line, 2)
      network%x = mesh%x
      network%datum = mesh%datum
      network%origin = [(i, i=1, size(mesh%x, 2))]
      network%triangle = mesh%triangle
      network%triangle_group = mesh%triangle_group
      allocate (network%joint(4, n))
      network%joint(1:2, :) = line
      network%joint(3:4, :) = line
      network%joint_group = group
      network%group = mesh%group
      call outer_edges(deck, mesh, network%surface)
      allocate (network%joint_triangle(2, n), source=0)
      allocate (network%surface_triangle(size(network%surface, 2)), network%surface_joint(size(network%surface, 2)), &
                network%surface_side(size(network%surface, 2)), network%surface_group(size(network%surface, 2)), source=0)
      allocate (network%point(0), network%point_group(0))
   end subroutine as_network

end module flow_alone_m
