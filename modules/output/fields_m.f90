!> fields.h5: the mesh and one group of arrays a snapshot; fields.xdmf and joints.xdmf beside it let ParaView open them. All are
!> complete and closed after every snapshot, so what is there can be read while the run goes on and after a kill.
module fields_m
   use complete_groups_m, only: complete_groups_t, was_left, copy_complete, forget_left
   use errors_m, only: error_list_t
   use field_list_m, only: field_list_t, on_nodes, on_joints, place_name, vector_components
   use files_m, only: delete_file, file_exists, replace_file
   use hash_m, only: numbers_hash
   use hdf5_m, only: h5_file_t, h5_name_length
   use kinds_m, only: wp, i8
   use mesh_m, only: split_mesh_t
   use provenance_m, only: provenance_t
   use text_m, only: to_text
   use xdmf_m, only: snapshot_t, write_xdmf, append_xdmf
   implicit none
   private

   !> Longest deck kept as an attribute: an object header of HDF5 holds 64 kB
   integer, parameter :: longest_attribute = 60000
   !> How the names of the groups of arrays start; a number follows
   character(len=*), parameter :: step_prefix = 'step_', mesh_prefix = 'mesh'

   !> The fields file
   type, public :: fields_t
      private
      !> fields.h5 and fields.xdmf
      character(len=:), allocatable :: path, xdmf_path
      !> Group of the mesh in use, and how many meshes there are (cracks that open change the mesh)
      character(len=:), allocatable :: mesh_group
      integer :: meshes = 0
      !> Numbers of nodes, triangles, joints
      integer :: entities(3) = 0
      !> Hash of what a crack or an excavation changes in the mesh
      character(len=:), allocatable :: fingerprint
      !> Fields of the mesh that do not change with time; how many snapshots have been written
      type(snapshot_t) :: constant
      integer :: snapshots = 0
      !> Meshes and snapshots that are complete
      type(complete_groups_t) :: complete
   contains
      procedure :: init
      procedure :: resume
      procedure :: set_mesh
      procedure :: is_on
      procedure :: write => write_snapshot
   end type fields_t

contains

   !> Start new files with the mesh in them.
   subroutine init(self, directory, mesh, block_edge, constant, provenance, errors)
      class(fields_t), intent(inout) :: self
      !> Results directory; it exists
      character(len=*), intent(in) :: directory
      type(split_mesh_t), intent(in) :: mesh
      !> Block edge of each joint, 0 for none (joints)
      integer, intent(in) :: block_edge(:)
      !> Fields that do not change with time, such as JRCn (may be empty)
      type(field_list_t), intent(in) :: constant
      type(provenance_t), intent(in) :: provenance
      type(error_list_t), intent(inout) :: errors
      type(h5_file_t) :: file
      integer :: before

      before = errors%count()
      call set_paths(self, directory)
      call forget_left(self%path)
      call file%create(self%path)
      call put_provenance(file, provenance)
      call file%close(errors)
      if (errors%count() > before) return
      call self%set_mesh(mesh, block_edge, constant, errors)
   end subroutine init

   !> Go on with the files of an interrupted run: snapshots later than the restart time are dropped, and the meshes that came
   !> with them. The mesh in use is that of the last snapshot kept, or the first one when there is none. A file that cannot be read
   !> is set aside, and a new one started.
   subroutine resume(self, directory, mesh, block_edge, constant, provenance, time, notes, errors)
      class(fields_t), intent(inout) :: self
      character(len=*), intent(in) :: directory
      type(split_mesh_t), intent(in) :: mesh
      integer, intent(in) :: block_edge(:)
      type(field_list_t), intent(in) :: constant
      type(provenance_t), intent(in) :: provenance
      !> Latest snapshot to keep [s]
      real(wp), intent(in) :: time
      !> What the user should know
      type(error_list_t), intent(inout) :: notes
      type(error_list_t), intent(inout) :: errors
      character(len=h5_name_length), allocatable :: name(:)
      type(error_list_t) :: damage
      character(len=:), allocatable :: program
      type(h5_file_t) :: file
      type(snapshot_t) :: found
      type(snapshot_t), allocatable :: kept(:)
      integer :: i, before

      before = errors%count()
      call set_paths(self, directory)
      if (was_left(self%path)) call rescue(self%path, provenance, notes, errors)
      if (errors%count() > before) return
      if (.not. file_exists(self%path)) then
         call self%init(directory, mesh, block_edge, constant, provenance, errors)
         return
      end if
      call file%open(self%path, writable=.true.)
      ! The library takes an empty file for a new one
      call file%get('/', 'program', program)
      call file%members('/', name)
      allocate (kept(size(name)))
      do i = 1, size(name)
         if (index(name(i), step_prefix) /= 1) cycle
         call read_snapshot(file, '/'//trim(name(i)), found)
         if (file%failed()) exit
         if (found%time > time) then
            call file%remove('/'//trim(name(i)))
         else
            self%snapshots = self%snapshots + 1
            kept(self%snapshots) = found
            call self%complete%add(file, '/'//trim(name(i)))
         end if
      end do
      do i = 1, size(name)
         if (index(name(i), mesh_prefix) /= 1) cycle
         if (is_needed('/'//trim(name(i)))) then
            self%meshes = self%meshes + 1
            call self%complete%add(file, '/'//trim(name(i)))
         else
            call file%remove('/'//trim(name(i)))
         end if
      end do
      if (allocated(self%mesh_group)) deallocate (self%mesh_group)
      if (self%snapshots > 0) then
         associate (last => kept(self%snapshots))
            self%mesh_group = last%mesh
            self%entities = last%entities
         end associate
         call self%constant%clear()
         call read_fields(file, self%mesh_group, self%constant)
      else if (self%meshes > 0) then
         self%mesh_group = '/'//mesh_prefix
         self%entities = mesh_entities(file, self%mesh_group)
         call self%constant%clear()
         call read_fields(file, self%mesh_group, self%constant)
      end if
      if (file%failed()) then
         call file%close(damage)
         call set_aside(self, damage%text(1), notes, errors)
         if (errors%count() == before) call self%init(directory, mesh, block_edge, constant, provenance, errors)
         return
      end if
      if (allocated(self%mesh_group)) self%fingerprint = fingerprint_in(file, self%mesh_group)
      call self%complete%close(file, self%path, errors)
      if (errors%count() > before) return
      if (self%snapshots > 0) call write_xdmf(self%xdmf_path, 'fields.h5', kept(:self%snapshots), errors)
      if (allocated(self%mesh_group)) return
      call self%set_mesh(mesh, block_edge, constant, errors)

   contains

      !> Is a mesh not later than that of the last snapshot, or the first of all? (Names are in the order of time.)
      pure logical function is_needed(mesh_group)
         character(len=*), intent(in) :: mesh_group

         is_needed = mesh_group == '/'//mesh_prefix
         if (self%snapshots > 0) is_needed = lle(mesh_group, kept(self%snapshots)%mesh)
      end function is_needed

   end subroutine resume

   !> Nodes, triangles and joints of a mesh in the file.
   function mesh_entities(file, mesh_group) result(entities)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: mesh_group
      integer :: entities(3)
      real(wp), allocatable :: place(:, :)
      integer, allocatable :: corner(:, :), wall(:, :)

      call file%read(mesh_group//'/coordinates', place)
      call file%read(mesh_group//'/triangles', corner)
      call file%read(mesh_group//'/joints', wall)
      entities = [size(place, 2), size(corner, 2), size(wall, 2)]
   end function mesh_entities

   !> Fingerprint of a mesh in the file.
   function fingerprint_in(file, mesh_group) result(fingerprint)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: mesh_group
      character(len=:), allocatable :: fingerprint
      integer, allocatable :: corner(:, :), wall(:, :), edge(:, :)

      call file%read(mesh_group//'/triangles', corner)
      call file%read(mesh_group//'/joints', wall)
      call file%read(mesh_group//'/surface', edge)
      fingerprint = fingerprint_of(corner + 1, wall + 1, edge + 1)
   end function fingerprint_in

   !> The same for what cracks and excavations change: nodes of triangles, joints and surface edges.
   function fingerprint_of(triangle, joint, surface) result(fingerprint)
      integer, intent(in) :: triangle(:, :), joint(:, :), surface(:, :)
      character(len=:), allocatable :: fingerprint

      fingerprint = numbers_hash([reshape(triangle, [size(triangle)]), reshape(joint, [size(joint)]), &
                                  reshape(surface, [size(surface)])])
   end function fingerprint_of

   !> Give a file that cannot be read another name.
   subroutine set_aside(self, damage, notes, errors)
      class(fields_t), intent(in) :: self
      !> What is wrong with it
      character(len=*), intent(in) :: damage
      type(error_list_t), intent(inout) :: notes, errors
      character(len=:), allocatable :: aside
      integer :: status, number

      number = 1
      aside = self%path//'.damaged'
      do while (file_exists(aside))
         number = number + 1
         aside = self%path//'.damaged_'//to_text(number)
      end do
      call replace_file(self%path, aside, status)
      if (status == 0) then
         call notes%add(damage//'; it is set aside as '//aside//', and the run goes on with a new fields.h5: '// &
                        'earlier snapshots are in the old file, as far as they can be read')
      else
         call errors%add(damage//'; it cannot be renamed either')
      end if
   end subroutine set_aside

   !> Is this the mesh in use? A crack adds joints, and rock that is taken out parts nodes and has other free edges.
   logical function is_on(self, mesh)
      class(fields_t), intent(in) :: self
      type(split_mesh_t), intent(in) :: mesh

      is_on = all(self%entities == entities_of(mesh))
      if (is_on) is_on = self%fingerprint == fingerprint_of(mesh%triangle, mesh%joint, mesh%surface)
   end function is_on

   !> Numbers of nodes, triangles, joints.
   pure function entities_of(mesh) result(entities)
      type(split_mesh_t), intent(in) :: mesh
      integer :: entities(3)

      entities = [size(mesh%x, 2), size(mesh%triangle, 2), size(mesh%joint, 2)]
   end function entities_of

   !> Take another mesh into use: later snapshots are on it. The first is /mesh, then /mesh_000002 and so on.
   subroutine set_mesh(self, mesh, block_edge, constant, errors)
      class(fields_t), intent(inout) :: self
      type(split_mesh_t), intent(in) :: mesh
      integer, intent(in) :: block_edge(:)
      type(field_list_t), intent(in) :: constant
      type(error_list_t), intent(inout) :: errors
      character(len=16) :: number
      type(h5_file_t) :: file
      integer :: before

      before = errors%count()
      self%meshes = self%meshes + 1
      write (number, '(a,i6.6)') '_', self%meshes
      if (self%meshes == 1) number = ''
      self%mesh_group = '/'//mesh_prefix//trim(number)
      self%entities = entities_of(mesh)
      self%fingerprint = fingerprint_of(mesh%triangle, mesh%joint, mesh%surface)
      call constant%check(self%entities, errors)
      if (size(block_edge) /= size(mesh%joint, 2)) call errors%add(self%path//': one block edge for each joint is expected')
      if (errors%count() > before) return

      call file%open(self%path, writable=.true.)
      call file%make_group(self%mesh_group)
      call write_mesh(file, self%mesh_group//'/', mesh, block_edge)
      call write_list(file, self%mesh_group, constant, self%constant)
      call close_with(self, file, self%mesh_group, errors)
   end subroutine set_mesh

   !> Write one snapshot.
   subroutine write_snapshot(self, time, step, stage, cycle, list, errors)
      class(fields_t), intent(inout) :: self
      !> Time [s], steps done
      real(wp), intent(in) :: time
      integer(i8), intent(in) :: step
      !> Name of the stage, and cycle in it
      character(len=*), intent(in) :: stage
      integer, intent(in) :: cycle
      !> What to write
      type(field_list_t), intent(in) :: list
      type(error_list_t), intent(inout) :: errors
      type(h5_file_t) :: file
      type(snapshot_t) :: new
      character(len=16) :: number
      integer :: before

      before = errors%count()
      call list%check(self%entities, errors)
      if (errors%count() > before) return
      write (number, '(i6.6)') self%snapshots + 1
      new%path = '/'//step_prefix//trim(number)
      new%time = time

      call file%open(self%path, writable=.true.)
      call file%make_group(new%path)
      call file%put(new%path, 'time_s', time)
      call file%put(new%path, 'step', step)
      call file%put(new%path, 'stage', stage)
      call file%put(new%path, 'cycle', cycle)
      call put_mesh_of(file, new, self%mesh_group, self%entities, self%constant)
      call write_list(file, new%path, list, new)
      call close_with(self, file, new%path, errors)
      if (errors%count() > before) return
      self%snapshots = self%snapshots + 1
      if (self%snapshots == 1) then
         call write_xdmf(self%xdmf_path, 'fields.h5', [new], errors)
      else
         call append_xdmf(self%xdmf_path, 'fields.h5', new, errors)
      end if
   end subroutine write_snapshot

   !> Close the file with a new group in it, which is complete then.
   subroutine close_with(self, file, group, errors)
      class(fields_t), intent(inout) :: self
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: group
      type(error_list_t), intent(inout) :: errors
      type(complete_groups_t) :: complete
      integer :: before

      before = errors%count()
      complete = self%complete
      call complete%add(file, group)
      call self%complete%close(file, self%path, errors)
      if (errors%count() == before) self%complete = complete
   end subroutine close_with

   !> A kill has left the file half-way: what was complete in it goes on in a new one. After an error all is as it was.
   subroutine rescue(path, provenance, notes, errors)
      character(len=*), intent(in) :: path
      type(provenance_t), intent(in) :: provenance
      type(error_list_t), intent(inout) :: notes, errors
      type(h5_file_t) :: new
      type(error_list_t) :: failure
      integer :: status

      call new%create(path//'.part')
      call put_provenance(new, provenance)
      call copy_complete(path, new)
      call new%close(failure)
      if (.not. failure%any()) then
         call replace_file(path//'.part', path, status)
         if (status /= 0) call failure%add(path//': cannot be replaced')
      end if
      if (failure%any()) then
         call delete_file(path//'.part')
         call errors%add(path//' was being written when the run was killed, and what was complete in it cannot be taken to a '// &
                         'new one ('//failure%text(1)//'); make room on the disk, or move it away to go on without it')
         return
      end if
      call notes%add(path//' was being written when the run was killed: all that was complete in it is kept')
      call forget_left(path)
   end subroutine rescue

   subroutine set_paths(self, directory)
      type(fields_t), intent(inout) :: self
      character(len=*), intent(in) :: directory

      self%path = trim(directory)//'/fields.h5'
      self%xdmf_path = trim(directory)//'/fields.xdmf'
      self%meshes = 0
      self%snapshots = 0
      self%complete = complete_groups_t()
   end subroutine set_paths

   subroutine put_provenance(file, provenance)
      type(h5_file_t), intent(inout) :: file
      type(provenance_t), intent(in) :: provenance

      call file%put('/', 'program', 'femdem')
      call file%put('/', 'version', provenance%version)
      call file%put('/', 'commit', provenance%commit)
      call file%put('/', 'compiler', provenance%compiler)
      call file%put('/', 'compiler_options', provenance%compiler_options)
      call file%put('/', 'command', provenance%command)
      call file%put('/', 'date', provenance%date)
      if (len(provenance%deck) <= longest_attribute) then
         call file%put('/', 'deck', provenance%deck)
      else
         call file%put('/', 'deck', provenance%deck(:longest_attribute)//new_line('a')//'! cut short here: see deck.nml')
      end if
      call file%put('/', 'conventions', 'SI units unless the name says otherwise; nodes, triangles, joints and groups '// &
                    'count from 0 (-1: none), block edges at 1 (0: none); compression is positive')
   end subroutine put_provenance

   !> Datasets of the mesh.
   subroutine write_mesh(file, at, mesh, block_edge)
      type(h5_file_t), intent(inout) :: file
      !> Group of the mesh, with a slash at its end
      character(len=*), intent(in) :: at
      type(split_mesh_t), intent(in) :: mesh
      integer, intent(in) :: block_edge(:)
      call file%write(at//'coordinates', mesh%x + spread(mesh%datum, 2, size(mesh%x, 2)), 'm', 'Nodes before any motion: x, y')
      call file%write(at//'triangles', mesh%triangle - 1, '1', 'Nodes of each triangle, anticlockwise, from 0')
      call file%write(at//'triangle_group', mesh%triangle_group - 1, '1', 'Group of each triangle, row of group_name')
      call file%write(at//'joints', mesh%joint - 1, '1', &
                      'Nodes of each joint element, from 0: A, B on the lower wall (right of A to B), A'', B'' on the upper')
      call file%write(at//'joint_lines', mesh%joint(:2, :) - 1, '1', 'Nodes A, B of each joint element, from 0')
      call file%write(at//'joint_group', mesh%joint_group - 1, '1', 'Group of each joint element, row of group_name')
      call file%write(at//'joint_triangles', mesh%joint_triangle - 1, '1', 'Triangles on the lower and upper wall, from 0')
      call file%write(at//'block_edge', block_edge, '1', 'Block edge of each joint element, id of edges.csv (0: none)')
      call file%write(at//'surface', mesh%surface - 1, '1', 'Free edges and fracture walls: two nodes, rock on the left')
      call file%write(at//'surface_joint', mesh%surface_joint - 1, '1', 'Joint element whose wall the edge is (-1: outside)')
      call file%write(at//'surface_group', mesh%surface_group - 1, '1', 'Group of each outer edge, row of group_name')
      call file%write(at//'group_name', mesh%group%name, '1', 'Names of the groups of the mesh file')
      call file%write(at//'group_dimension', mesh%group%dimension, '1', 'Dimension: 0 points, 1 lines, 2 surfaces')
      call file%write(at//'group_tag', mesh%group%tag, '1', 'Number of each group in the mesh file')
   end subroutine write_mesh

   !> Write all fields of a list into a group and note in the record what is there.
   subroutine write_list(file, path, list, record)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(field_list_t), intent(in) :: list
      type(snapshot_t), intent(inout) :: record
      character(len=:), allocatable :: dataset
      integer :: i

      call record%clear()
      record%path = path
      do i = 1, list%n
         associate (field => list%field(i))
            dataset = path//'/'//field%name
            if (size(field%value, 1) == 1) then
               call file%write(dataset, field%value(1, :), field%unit, field%description)
            else
               call file%write(dataset, field%value, field%unit, field%description)
            end if
            call file%put(dataset, 'place', place_name(field%place))
            call file%put(dataset, 'components', size(field%value, 1))
            call record%add(dataset, field%place, size(field%value, 1))
         end associate
      end do
   end subroutine write_list

   !> Say on which mesh a snapshot is.
   subroutine put_mesh_of(file, snapshot, mesh_group, entities, constant)
      type(h5_file_t), intent(inout) :: file
      type(snapshot_t), intent(inout) :: snapshot
      character(len=*), intent(in) :: mesh_group
      integer, intent(in) :: entities(3)
      type(snapshot_t), intent(in) :: constant
      integer :: i

      snapshot%mesh = mesh_group
      snapshot%entities = entities
      call file%put(snapshot%path, 'mesh', mesh_group)
      do i = on_nodes, on_joints
         call file%put(snapshot%path, trim(place_name(i)), entities(i))
      end do
      call snapshot%set_constant(constant)
   end subroutine put_mesh_of

   !> Read back what a snapshot holds.
   subroutine read_snapshot(file, path, snapshot)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(snapshot_t), intent(out) :: snapshot
      type(snapshot_t) :: constant
      integer :: i

      snapshot%path = path
      call file%get(path, 'time_s', snapshot%time)
      call file%get(path, 'mesh', snapshot%mesh)
      do i = on_nodes, on_joints
         call file%get(path, trim(place_name(i)), snapshot%entities(i))
      end do
      call read_fields(file, path, snapshot)
      call read_fields(file, snapshot%mesh, constant)
      call snapshot%set_constant(constant)
   end subroutine read_snapshot

   !> Fields in a group: the datasets that have a place.
   subroutine read_fields(file, path, record)
      type(h5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(snapshot_t), intent(inout) :: record
      character(len=h5_name_length), allocatable :: name(:)
      character(len=:), allocatable :: place, dataset
      integer :: i, k, components

      call file%members(path, name)
      do i = 1, size(name)
         dataset = path//'/'//trim(name(i))
         if (.not. file%has_attribute(dataset, 'place')) cycle
         call file%get(dataset, 'place', place)
         call file%get(dataset, 'components', components)
         do k = on_nodes, on_joints
            if (place_name(k) == place) call record%add(dataset, k, components)
         end do
      end do
   end subroutine read_fields

end module fields_m
