!> Flow through the apertures of a finished run: every snapshot of its fields.h5, without running it again.
module flow_after_m
   use kinds_m, only: wp, i8
   use units_m, only: megapascal
   use deck_m, only: deck_t
   use errors_m, only: error_list_t
   use field_list_m, only: field_list_t
   use fields_m, only: fields_t
   use files_m, only: file_exists
   use flow_alone_m, only: as_network
   use flow_check_m, only: has_flow, is_flow_alone
   use fluid_coupling_m, only: mobilised_roughness
   use flow_domain_m, only: set_moment
   use flow_results_m, only: flow_results_t, flow_moment_t
   use hdf5_m, only: h5_file_t, h5_name_length
   use log_m, only: log_t
   use mesh_m, only: mesh_t, split_mesh_t
   use permeability_m, only: permeability_t
   use provenance_m, only: provenance_of
   use model_m, only: model_t
   use story_m, only: command_text
   use text_m, only: to_text
   implicit none
   private

   public :: check_flow_after, run_flow_after

   character(len=*), parameter :: step_prefix = '/step_'
   !> Nodes of results and mesh are one to this part of the mesh's size: coordinates of maps lose some digits
   real(wp), parameter :: closeness = 1.0e-8_wp

   !> The network of the run at a snapshot
   type :: lines_t
      !> Path of its mesh in the file
      character(len=:), allocatable :: mesh
      !> Nodes of the mesh as read (2, lines); group, 0 for cracks, block edge (lines)
      integer, allocatable :: node(:, :), group(:), block_edge(:)
   end type lines_t

contains

   !> The deck must ask for flow, and the results must be there.
   subroutine check_flow_after(results, deck, errors)
      character(len=*), intent(in) :: results
      type(deck_t), intent(in) :: deck
      type(error_list_t), intent(inout) :: errors

      if (.not. has_flow(deck)) call errors%add('option --flow: '//deck%path//' has no &flow')
      if (is_flow_alone(deck)) call errors%add('option --flow: '//deck%path//' has no stages; '// &
                                               'must be the deck of the run, with &flow')
      if (.not. file_exists(results//'/fields.h5')) &
         call errors%add('option --flow: there is no file '//results//'/fields.h5; must be the results directory of a run')
   end subroutine check_flow_after

   !> Go through the snapshots.
   subroutine run_flow_after(results, model, directory, log, errors)
      !> Directory of the results of the run
      character(len=*), intent(in) :: results
      !> As it was built from deck and mesh
      type(model_t), intent(in) :: model
      !> Where to write; it exists
      character(len=*), intent(in) :: directory
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      character(len=h5_name_length), allocatable :: name(:)
      type(h5_file_t) :: file
      type(flow_results_t) :: flow
      type(fields_t) :: fields
      type(lines_t) :: lines
      integer :: i, before

      before = errors%count()
      call flow%open(directory//'/', model%deck, model%whole, .false., 0.0_wp, errors)
      call file%open(results//'/fields.h5', writable=.false.)
      call file%members('/', name)
      lines%mesh = ''
      do i = 1, size(name)
         if (file%failed() .or. errors%count() > before) exit
         if (index('/'//name(i), step_prefix) /= 1) cycle
         call one_snapshot(file, '/'//trim(name(i)), model, directory, flow, fields, lines, log, errors)
      end do
      call file%close(errors)
      call flow%close()
   end subroutine run_flow_after

   !> Flow at one snapshot.
   subroutine one_snapshot(file, path, model, directory, flow, fields, lines, log, errors)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path, directory
      type(model_t), intent(in) :: model
      type(flow_results_t), intent(inout) :: flow
      type(fields_t), intent(inout) :: fields
      type(lines_t), intent(inout) :: lines
      type(log_t), intent(in) :: log
      type(error_list_t), intent(inout) :: errors
      type(split_mesh_t) :: network
      type(field_list_t) :: list, nothing
      type(flow_moment_t) :: moment
      type(permeability_t) :: permeability
      character(len=:), allocatable :: mesh, stage
      logical, allocatable :: filled(:)
      real(wp), allocatable :: aperture(:), slip(:), sn(:), damage(:), broken(:), ratio(:), roughness(:)
      real(wp) :: peak
      integer(i8) :: step
      integer :: cycle, j
      logical :: first

      call file%get(path, 'mesh', mesh)
      call file%get(path, 'time_s', moment%time)
      call file%get(path, 'step', step)
      call file%get(path, 'stage', stage)
      call file%get(path, 'cycle', cycle)
      moment%number = [real(step, wp), real(findloc(model%deck%stage%name == stage, .true., dim=1), wp), real(cycle, wp)]
      call file%read(path//'/aperture_mm', aperture)
      call file%read(path//'/shear_displacement_mm', slip)
      call file%read(path//'/normal_stress_MPa', sn)
      allocate (filled(size(aperture)), source=.true.)
      if (file%has(path//'/damage')) then
         call file%read(path//'/damage', damage)
         filled = damage >= model%deck%flow%fluid_enters
         if (file%has(path//'/broken')) then
            call file%read(path//'/broken', broken)
            filled = broken > 0.5_wp .or. (filled .and. model%deck%flow%fluid_enters < 1.0_wp)
         end if
      end if
      call read_mean_stress(file, path, model, moment%stress)
      if (file%failed()) return
      first = lines%mesh == ''
      if (lines%mesh /= mesh) then
         call read_lines(file, mesh, model%whole, lines, errors)
         if (errors%any()) return
         call as_network(model%deck, model%whole, lines%node, lines%group, network)
         if (first) then
            call fields%init(directory, network, lines%block_edge, nothing, provenance_of(command_text(), ''), errors)
         else
            call fields%set_mesh(network, lines%block_edge, nothing, errors)
         end if
      end if
      allocate (ratio(size(slip)), roughness(size(slip)), source=0.0_wp)
      do j = 1, min(size(slip), size(model%joints%law))
         peak = model%joints%law(j)%raw%slip_of_peak(sn(j))
         if (.not. peak > 0.0_wp) cycle
         ratio(j) = abs(slip(j))/peak
         roughness(j) = mobilised_roughness(model%joints%law(j), ratio(j), sn(j))
      end do
      j = nint(moment%number(2))
      if (j > 0) call set_moment(flow%model, j, real(cycle, wp)/real(model%deck%stage(j)%cycles, wp))
      call flow%take(lines%node, lines%group, lines%block_edge, aperture, ratio, roughness, &
                     filled, errors)
      call flow%write_row(moment, errors, permeability)
      if (errors%any()) return
      call flow%add_fields([(j, j=1, size(model%whole%x, 2))], list)
      call fields%write(moment%time, step, stage, cycle, list, errors)
      if (model%deck%flow%permeability) &
         call log%say('flow      '//stage//' '//to_text(cycle)//': kxx '//to_text(permeability%linear(1))//', kyy '// &
                      to_text(permeability%linear(2))//', kxy '//to_text(permeability%linear(3))//' m2')
   end subroutine one_snapshot

   !> Mean stress of the rock, xx, yy, xy, compression positive [MPa].
   subroutine read_mean_stress(file, path, model, stress)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(model_t), intent(in) :: model
      real(wp), intent(out) :: stress(3)
      character(len=*), parameter :: name(3) = ['stress_xx', 'stress_yy', 'stress_xy']
      real(wp), allocatable :: value(:)
      integer :: i

      stress = 0.0_wp
      do i = 1, 3
         call file%read(path//'/'//name(i), value)
         if (size(value) /= size(model%solid%area)) return
         stress(i) = dot_product(model%solid%area, value)/sum(model%solid%area)/megapascal
      end do
   end subroutine read_mean_stress

   !> Joint elements of a mesh of the results as lines of the mesh as read, whose nodes are at the same places.
   subroutine read_lines(file, path, mesh, lines, errors)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(mesh_t), intent(in) :: mesh
      type(lines_t), intent(inout) :: lines
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: x(:, :)
      integer, allocatable :: joint(:, :), group(:), origin(:)
      integer :: j

      lines%mesh = path
      call file%read(path//'/coordinates', x)
      call file%read(path//'/joints', joint)
      call file%read(path//'/joint_group', group)
      call file%read(path//'/block_edge', lines%block_edge)
      if (file%failed()) return
      call find_places(x - spread(mesh%datum, 2, size(x, 2)), mesh%x, origin)
      if (any(origin == 0)) then
         call errors%add('option --flow: '//to_text(count(origin == 0))//' nodes of the results are not at nodes of the mesh '// &
                         'of this deck; must be the mesh of the run')
         return
      end if
      ! The file counts from 0; -1 is no group
      lines%group = group + 1
      if (allocated(lines%node)) deallocate (lines%node)
      allocate (lines%node(2, size(joint, 2)))
      do j = 1, size(joint, 2)
         lines%node(:, j) = origin(joint(1:2, j) + 1)
      end do
   end subroutine read_lines

   !> Which of the known points each point is at, 0 where there is none. Known points are kept in strips of x.
   pure subroutine find_places(x, known, place)
      !> (2, points), (2, known points)
      real(wp), intent(in) :: x(:, :), known(:, :)
      integer, allocatable, intent(out) :: place(:)
      integer, allocatable :: first(:), next(:)
      real(wp) :: low, width, tolerance
      integer :: i, k, strip, strips

      strips = max(1, size(known, 2))
      low = minval(known(1, :))
      tolerance = closeness*max(maxval(known(1, :)) - low, maxval(known(2, :)) - minval(known(2, :)))
      width = (maxval(known(1, :)) - low)/real(strips, wp) + tolerance
      allocate (first(-1:strips + 1), next(size(known, 2)), place(size(x, 2)), source=0)
      do k = 1, size(known, 2)
         strip = int((known(1, k) - low)/width)
         next(k) = first(strip)
         first(strip) = k
      end do
      do i = 1, size(x, 2)
         do strip = max(-1, int((x(1, i) - low)/width) - 1), min(strips + 1, int((x(1, i) - low)/width) + 1)
            k = first(strip)
            do while (k > 0)
               if (all(abs(known(:, k) - x(:, i)) <= tolerance)) place(i) = k
               k = next(k)
            end do
         end do
      end do
   end subroutine find_places

end module flow_after_m
