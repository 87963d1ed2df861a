!> What flow leaves behind: permeability.csv, flow.csv and its fields. A deck without &flow writes none of it.
module flow_results_m
   use kinds_m, only: wp
   use units_m, only: millimetre
   use deck_m, only: deck_t
   use errors_m, only: error_list_t
   use field_list_m, only: field_list_t, on_nodes, on_triangles, on_joints
   use flow_check_m, only: has_flow, is_flow_alone
   use flow_m, only: no_pressure
   use fluid_front_m, only: find_capacity
   use flow_domain_m, only: flow_domain_t, boundary_flow_t, init_flow_domain, set_lines, set_apertures, set_storage, &
                            solve_boundary_flow, known_flow, solve_permeability
   use history_m, only: history_t, column_length
   use mesh_m, only: mesh_t
   use permeability_m, only: permeability_t
   use state_m, only: fluid_memory_t
   implicit none
   private

   !> Columns of both tables, and of permeability.csv; compression is positive
   character(len=*), parameter :: common(*) = [character(len=24) :: 'time_s', 'step', 'stage', 'cycle', 'stress_xx_MPa', &
                                                                                                   'stress_yy_MPa', 'stress_xy_MPa']
   character(len=*), parameter :: of_permeability(*) = &
                                  [character(len=24) :: 'kxx_m2', 'kyy_m2', 'kxy_m2', 'k1_m2', 'k2_m2', 'k1_angle_deg', &
                                                         'kx_closed_m2', 'ky_closed_m2', 'percolates_x', 'percolates_y', &
                                                         'top_share_x', 'top_share_y', 'parts', 'parts_left_out', 'imbalance', &
                                                         'mean_hydraulic_mm', 'largest_hydraulic_mm']
   character(len=*), parameter :: of_flow(*) = [character(len=24) :: 'parts', 'parts_left_out', 'lines_left_out', 'imbalance']

   !> Where a run is, and the mean stress of its rock
   type, public :: flow_moment_t
      real(wp) :: time = 0.0_wp
      !> Steps, stage, cycle
      real(wp) :: number(3) = 0.0_wp
      !> Mean of xx, yy, xy over the rock, compression positive [MPa]; not a number without mechanics
      real(wp) :: stress(3) = 0.0_wp
   end type flow_moment_t

   !> The open results
   type, public :: flow_results_t
      logical :: active = .false.
      type(flow_domain_t) :: model
      type(mesh_t) :: mesh
      type(history_t) :: permeability, flow
      !> The last solution for the boundary conditions
      type(boundary_flow_t) :: solution
      !> Part of what is open that is full of fluid, where it may lag behind the tip of a crack (nodes of the mesh as read) [-]
      real(wp), allocatable :: saturation(:)
   contains
      procedure :: open => open_flow_results
      procedure :: take
      procedure :: write_row
      procedure :: write_flow_row
      procedure :: add_fields
      procedure :: put_back
      procedure :: forget_dropped
      procedure :: close => close_flow_results
   end type flow_results_t

contains

   !> Build the model and start the tables; with a restart, go on with those that are there.
   subroutine open_flow_results(self, directory, deck, mesh, restarted, time, errors)
      class(flow_results_t), intent(inout) :: self
      !> Directory with a slash at its end
      character(len=*), intent(in) :: directory
      type(deck_t), intent(in) :: deck
      !> The mesh as read
      type(mesh_t), intent(in) :: mesh
      logical, intent(in) :: restarted
      !> Latest time to keep of earlier rows, with a restart [s]
      real(wp), intent(in) :: time
      type(error_list_t), intent(inout) :: errors

      self%active = has_flow(deck)
      if (.not. self%active) return
      self%mesh = mesh
      call init_flow_domain(deck, mesh, self%model)
      if (deck%flow%permeability) call start(self%permeability, 'permeability.csv', [common, of_permeability])
      if (has_pressure(deck)) call start(self%flow, 'flow.csv', flow_columns(deck))

   contains

      subroutine start(table, name, columns)
         type(history_t), intent(inout) :: table
         character(len=*), intent(in) :: name, columns(:)

         if (restarted) then
            call table%resume(directory//name, columns, time, errors)
         else
            call table%init(directory//name, columns, errors)
         end if
      end subroutine start

   end subroutine open_flow_results

   !> Is a pressure of the fluid found?
   pure logical function has_pressure(deck)
      type(deck_t), intent(in) :: deck

      has_pressure = size(deck%flow_boundary) > 0 .or. deck%transient%line > 0
   end function has_pressure

   !> Columns of flow.csv: the inflow of each &flow_boundary among them.
   pure function flow_columns(deck) result(column)
      type(deck_t), intent(in) :: deck
      character(len=column_length), allocatable :: column(:)
      integer :: i, n

      n = size(common) + size(of_flow)
      allocate (column(n + size(deck%flow_boundary)))
      column(:size(common)) = common
      column(size(common) + 1:n) = of_flow
      do i = 1, size(deck%flow_boundary)
         column(n + i) = trim(deck%flow_boundary(i)%group)//'.inflow_m2_s'
      end do
   end function flow_columns

   !> Take lines and apertures over, and solve for the boundary conditions.
   subroutine take(self, line, group, block_edge, aperture_mm, mobilisation, jrc_mobilised, filled, errors, fluid)
      class(flow_results_t), intent(inout) :: self
      !> As set_lines and set_apertures of flow_domain_m have them
      integer, intent(in) :: line(:, :), group(:), block_edge(:)
      real(wp), intent(in) :: aperture_mm(:), mobilisation(:), jrc_mobilised(:)
      logical, intent(in) :: filled(:)
      type(error_list_t), intent(inout) :: errors
      !> Of two-way coupling; with time its pressure is that to show
      type(fluid_memory_t), intent(in), optional :: fluid

      if (.not. self%active) return
      call set_lines(self%model, self%mesh, line, group, block_edge)
      call set_apertures(self%model, aperture_mm, mobilisation, jrc_mobilised, filled)
      if (self%model%deck%transient%line > 0) then
         if (present(fluid)) then
            call known_flow(self%model, fluid%pressure, fluid%inflow, fluid%imbalance, self%solution)
            if (allocated(fluid%content)) self%saturation = saturation_of(self%model, fluid%pressure, fluid%content)
            return
         end if
         call set_storage(self%model, self%mesh)
         return
      end if
      if (size(self%model%boundary) > 0) call solve_boundary_flow(self%model, self%solution, errors)
   end subroutine take

   !> Part of what is open at each node that is full (nodes) [-].
   function saturation_of(model, pressure, content) result(saturation)
      !> With its apertures
      type(flow_domain_t), intent(in) :: model
      !> (nodes) [Pa], [m2]
      real(wp), intent(in) :: pressure(:), content(:)
      real(wp) :: saturation(size(content))
      real(wp) :: capacity(size(content))

      capacity = find_capacity(model, pressure)
      saturation = no_pressure()
      where (capacity > 0.0_wp) saturation = content/capacity
   end function saturation_of

   !> A row in each table.
   subroutine write_row(self, moment, errors, permeability)
      class(flow_results_t), intent(inout) :: self
      type(flow_moment_t), intent(in) :: moment
      type(error_list_t), intent(inout) :: errors
      !> What was found, for who wants to tell it
      type(permeability_t), intent(out), optional :: permeability
      type(permeability_t) :: found

      if (.not. self%active .or. errors%any()) return
      if (self%model%deck%flow%permeability) then
         call solve_permeability(self%model, found, errors)
         if (errors%any()) return
         call self%permeability%write_row([place_of(moment), found%linear, found%principal, found%angle, found%closed, &
                                           merge(1.0_wp, 0.0_wp, found%percolates), found%top, &
                                           real([found%parts, found%parts_left_out], wp), found%imbalance, &
                                           aperture_statistics(self%model)/millimetre], errors)
      end if
      if (present(permeability)) permeability = found
      if (has_pressure(self%model%deck) .and. .not. (is_flow_alone(self%model%deck) .and. self%model%deck%transient%line > 0)) &
         call self%write_flow_row(moment, errors)
   end subroutine write_row

   !> A row of flow.csv.
   subroutine write_flow_row(self, moment, errors)
      class(flow_results_t), intent(inout) :: self
      type(flow_moment_t), intent(in) :: moment
      type(error_list_t), intent(inout) :: errors

      associate (solution => self%solution)
         call self%flow%write_row([place_of(moment), real([solution%parts, solution%parts_left_out, solution%lines_left_out], wp), &
                                   solution%field%imbalance, solution%inflow], errors)
      end associate
   end subroutine write_flow_row

   !> The first columns of both tables.
   pure function place_of(moment) result(place)
      type(flow_moment_t), intent(in) :: moment
      real(wp) :: place(size(common))

      place = [moment%time, moment%number, moment%stress]
   end function place_of

   !> Mean over the length of all lines that may conduct, and largest, hydraulic aperture [m].
   pure function aperture_statistics(model) result(statistics)
      type(flow_domain_t), intent(in) :: model
      real(wp) :: statistics(2)
      real(wp) :: length, total
      integer :: i

      statistics = 0.0_wp
      total = 0.0_wp
      associate (conductors => model%conductors)
         do i = 1, size(model%hydraulic)
            if (.not. model%hydraulic(i) > 0.0_wp) cycle
            length = norm2(conductors%x(:, conductors%line(2, i)) - conductors%x(:, conductors%line(1, i)))
            total = total + length
            statistics(1) = statistics(1) + length*model%hydraulic(i)
            statistics(2) = max(statistics(2), model%hydraulic(i))
         end do
      end associate
      if (total > 0.0_wp) statistics(1) = statistics(1)/total
   end function aperture_statistics

   !> Fields of flow for a snapshot on a mesh whose nodes are copies of those of the mesh as read.
   subroutine add_fields(self, origin, list)
      class(flow_results_t), intent(in) :: self
      !> Node of the mesh as read (nodes)
      integer, intent(in) :: origin(:)
      type(field_list_t), intent(inout) :: list

      if (.not. self%active) return
      call list%add('hydraulic_aperture_mm', 'mm', 'hydraulic aperture; 0 where nothing conducts', on_joints, &
                    self%model%hydraulic/millimetre)
      if (.not. has_pressure(self%model%deck)) return
      associate (field => self%solution%field)
         call list%add('fluid_pressure', 'Pa', 'pressure of the fluid; not a number where there is none', on_nodes, &
                       field%pressure(origin))
         if (allocated(self%saturation)) &
            call list%add('fluid_saturation', '-', 'part of what is open that fluid fills; not a number where nothing is', &
                          on_nodes, self%saturation(origin))
         call list%add('flow_along', 'm2/s', 'flow along each joint element from A to B, for a metre of thickness', on_joints, &
                       field%along)
         if (any(self%model%conductors%mobility > 0.0_wp)) &
            call list%add('darcy_flux', 'm/s', 'flux of the fluid in the rock', on_triangles, field%flux)
      end associate
   end subroutine add_fields

   !> Write the rows again that a restart has dropped, as those of the history.
   subroutine put_back(self, errors)
      class(flow_results_t), intent(inout) :: self
      type(error_list_t), intent(inout) :: errors

      call self%permeability%put_back(errors)
      call self%flow%put_back(errors)
   end subroutine put_back

   !> The run has gone on.
   pure subroutine forget_dropped(self)
      class(flow_results_t), intent(inout) :: self

      call self%permeability%forget_dropped()
      call self%flow%forget_dropped()
   end subroutine forget_dropped

   subroutine close_flow_results(self)
      class(flow_results_t), intent(inout) :: self

      if (.not. self%active) return
      call self%permeability%close()
      call self%flow%close()
   end subroutine close_flow_results

end module flow_results_m
