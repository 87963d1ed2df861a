!> fields.xdmf and joints.xdmf: tell ParaView and meshio where in fields.h5 the meshes and arrays of each time are.
!>
!> XDMF 3.0. A file is a series in time of one part, the rock or the joints, which is what meshio reads; fields.xdmf, of the rock,
!> takes in the other one (XInclude), so that VTK's reader has both. joints.xdmf is empty until there are joints.
module xdmf_m
   use errors_m, only: error_list_t
   use field_list_m, only: on_nodes, on_triangles, on_joints
   use files_m, only: replace_file
   use kinds_m, only: wp, i8
   use text_m, only: to_text
   implicit none
   private

   public :: write_xdmf, append_xdmf

   !> File of the joints, beside that of the rock
   character(len=*), parameter :: joints_file = 'joints.xdmf'
   character, parameter :: nl = new_line('a')
   !> How a file begins, and how one ends in which nothing is
   character(len=*), parameter :: head = '<?xml version="1.0"?>'//nl// &
                                  '<Xdmf Version="3.0" xmlns:xi="http://www.w3.org/2001/XInclude">'//nl//'<Domain>'//nl
   character(len=*), parameter :: empty_tail = '</Domain>'//nl//'</Xdmf>'//nl

   !> The rock or the joints: its name and what XDMF calls its cells, on_triangles or on_joints, dataset of the cells in the group
   !> of the mesh, and nodes of each
   type :: part_t
      character(len=8) :: name, shape
      integer :: place
      character(len=11) :: cells
      integer :: cell_nodes
      !> What the file has at its end, besides the series
      character(len=:), allocatable :: more
   end type part_t

   !> Where an array is, and what it is on
   type :: entry_t
      !> Full path of the dataset
      character(len=:), allocatable :: dataset
      integer :: place = on_nodes
      integer :: components = 1
   end type entry_t

   !> What one time has in the fields file
   type, public :: snapshot_t
      !> Group of its arrays, and group of its mesh
      character(len=:), allocatable :: path, mesh
      !> Time [s]
      real(wp) :: time = 0.0_wp
      !> Numbers of nodes, triangles, joints
      integer :: entities(3) = 0
      !> Arrays of this time, and arrays of the mesh
      type(entry_t), allocatable, private :: entry(:), constant(:)
   contains
      procedure :: clear
      procedure :: add
      procedure :: set_constant
   end type snapshot_t

contains

   !> Forget the arrays.
   subroutine clear(self)
      class(snapshot_t), intent(inout) :: self

      if (allocated(self%entry)) deallocate (self%entry)
   end subroutine clear

   !> Add an array, in the order of the names: that in which HDF5 gives them back, so that a restart writes the same file.
   subroutine add(self, dataset, place, components)
      class(snapshot_t), intent(inout) :: self
      !> Full path of the dataset
      character(len=*), intent(in) :: dataset
      !> on_nodes, on_triangles or on_joints; values an entity
      integer, intent(in) :: place, components
      type(entry_t), allocatable :: longer(:)
      integer :: n, before

      n = 0
      if (allocated(self%entry)) n = size(self%entry)
      before = 0
      do while (before < n)
         if (lgt(self%entry(before + 1)%dataset, dataset)) exit
         before = before + 1
      end do
      allocate (longer(n + 1))
      if (before > 0) longer(:before) = self%entry(:before)
      longer(before + 1) = entry_t(dataset, place, components)
      if (before < n) longer(before + 2:) = self%entry(before + 1:)
      call move_alloc(longer, self%entry)
   end subroutine add

   !> Take over the arrays of the mesh.
   subroutine set_constant(self, constant)
      class(snapshot_t), intent(inout) :: self
      type(snapshot_t), intent(in) :: constant

      if (allocated(self%constant)) deallocate (self%constant)
      if (allocated(constant%entry)) self%constant = constant%entry
   end subroutine set_constant

   !> Write the files; a reader sees the old one or the new one, never half of one.
   subroutine write_xdmf(path, data_file, snapshot, errors)
      !> That of the rock
      character(len=*), intent(in) :: path
      !> Name of the fields file, in the same directory
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot(:)
      type(error_list_t), intent(inout) :: errors
      integer :: i
      logical :: jointed(size(snapshot))

      call write_series(path, rock(), data_file, snapshot, errors)
      jointed = [(snapshot(i)%entities(on_joints) > 0, i=1, size(snapshot))]
      call write_series(beside(path), joints(), data_file, pack(snapshot, jointed), errors)
   end subroutine write_xdmf

   !> Add one time at the end of the files, in one write each: what it costs does not grow with the times that are there.
   subroutine append_xdmf(path, data_file, snapshot, errors)
      !> That of the rock
      character(len=*), intent(in) :: path
      !> Name of the fields file, in the same directory
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot
      type(error_list_t), intent(inout) :: errors
      integer :: length

      call append_to_series(path, rock(), data_file, snapshot, errors)
      if (snapshot%entities(on_joints) == 0) return
      inquire (file=beside(path), size=length)
      if (length > len(head//empty_tail)) then
         call append_to_series(beside(path), joints(), data_file, snapshot, errors)
      else
         call write_series(beside(path), joints(), data_file, [snapshot], errors)
      end if
   end subroutine append_xdmf

   !> The rock, whose file takes in that of the joints if there is one.
   pure type(part_t) function rock()

      rock = part_t('rock', 'Triangle', on_triangles, 'triangles', 3, &
                    '<xi:include href="'//joints_file//'" xpointer="xpointer(/Xdmf/Domain/Grid)"><xi:fallback/></xi:include>'//nl)
   end function rock

   pure type(part_t) function joints()

      joints = part_t('joints', 'Polyline', on_joints, 'joint_lines', 2, '')
   end function joints

   !> Path of the file of the joints.
   pure function beside(path)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: beside

      beside = path(:index(path, '/', back=.true.))//joints_file
   end function beside

   !> How the file of a part ends, with its last line end.
   pure function tail_of(part) result(tail)
      type(part_t), intent(in) :: part
      character(len=:), allocatable :: tail

      tail = '</Grid>'//nl//part%more//empty_tail
   end function tail_of

   !> Write the file of a part.
   subroutine write_series(path, part, data_file, snapshot, errors)
      character(len=*), intent(in) :: path
      type(part_t), intent(in) :: part
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot(:)
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: unit, status, i

      open (newunit=unit, file=trim(path)//'.part', access='stream', form='unformatted', action='write', status='replace', &
            iostat=status, iomsg=message)
      if (status == 0) write (unit, iostat=status, iomsg=message) head
      if (size(snapshot) > 0) then
         if (status == 0) write (unit, iostat=status, iomsg=message) &
            '<Grid Name="'//trim(part%name)//'" GridType="Collection" CollectionType="Temporal">'//nl
         do i = 1, size(snapshot)
            if (status == 0) write (unit, iostat=status, iomsg=message) grid(data_file, snapshot(i), part)
         end do
         if (status == 0) write (unit, iostat=status, iomsg=message) tail_of(part)
      else
         if (status == 0) write (unit, iostat=status, iomsg=message) empty_tail
      end if
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status == 0) then
         call replace_file(trim(path)//'.part', path, status)
         message = 'cannot replace the old file'
      end if
      if (status /= 0) call errors%add(trim(path)//': cannot write the index of the fields: '//trim(message))
   end subroutine write_series

   !> Add one time to the file of a part.
   subroutine append_to_series(path, part, data_file, snapshot, errors)
      character(len=*), intent(in) :: path
      type(part_t), intent(in) :: part
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer(i8) :: length
      integer :: unit, status

      open (newunit=unit, file=trim(path), access='stream', form='unformatted', action='readwrite', status='old', &
            iostat=status, iomsg=message)
      if (status == 0) then
         inquire (unit=unit, size=length)
         write (unit, pos=length - len(tail_of(part), i8) + 1_i8, iostat=status, iomsg=message) &
            grid(data_file, snapshot, part)//tail_of(part)
      end if
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status /= 0) call errors%add(trim(path)//': cannot write the index of the fields: '//trim(message))
   end subroutine append_to_series

   !> The grid of one time, with the arrays on its cells and on the nodes.
   function grid(data_file, snapshot, part) result(text)
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot
      type(part_t), intent(in) :: part
      character(len=:), allocatable :: text
      character(len=24) :: time

      write (time, '(es22.15e3)') snapshot%time
      associate (n => snapshot%entities)
         text = '<Grid Name="'//snapshot%path(2:)//'" GridType="Uniform">'//nl// &
                '<Time Value="'//trim(adjustl(time))//'"/>'//nl// &
                '<Topology TopologyType="'//trim(part%shape)//'" NodesPerElement="'//to_text(part%cell_nodes)// &
                '" NumberOfElements="'//to_text(n(part%place))//'">'//nl// &
                data_item(data_file, snapshot%mesh//'/'//trim(part%cells), 'Int', 4, n(part%place), part%cell_nodes)// &
                '</Topology>'//nl// &
                '<Geometry GeometryType="XY">'//nl// &
                data_item(data_file, snapshot%mesh//'/coordinates', 'Float', 8, n(on_nodes), 2)//'</Geometry>'//nl
         if (allocated(snapshot%constant)) text = text//attributes(data_file, snapshot%constant, n, part%place)
         if (allocated(snapshot%entry)) text = text//attributes(data_file, snapshot%entry, n, part%place)
      end associate
      text = text//'</Grid>'//nl
   end function grid

   !> The arrays on the nodes and on the given cells.
   function attributes(data_file, entry, entities, place) result(text)
      character(len=*), intent(in) :: data_file
      type(entry_t), intent(in) :: entry(:)
      integer, intent(in) :: entities(3), place
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(entry)
         associate (e => entry(i))
            if (e%place /= on_nodes .and. e%place /= place) cycle
            text = text//'<Attribute Name="'//e%dataset(index(e%dataset, '/', back=.true.) + 1:)//'" AttributeType="'// &
                   trim(merge('Scalar', 'Vector', e%components == 1))//'" Center="'// &
                   trim(merge('Node', 'Cell', e%place == on_nodes))//'">'//nl// &
                   data_item(data_file, e%dataset, 'Float', 8, entities(e%place), e%components)//'</Attribute>'//nl
         end associate
      end do
   end function attributes

   !> Reference to a dataset.
   function data_item(data_file, dataset, type, precision, rows, columns) result(text)
      character(len=*), intent(in) :: data_file, dataset
      !> Int or Float, and its size in bytes
      character(len=*), intent(in) :: type
      integer, intent(in) :: precision
      !> Entities, and values of each
      integer, intent(in) :: rows, columns
      character(len=:), allocatable :: text

      text = to_text(rows)
      if (columns > 1) text = text//' '//to_text(columns)
      text = '<DataItem Format="HDF" NumberType="'//type//'" Precision="'//to_text(precision)//'" Dimensions="'// &
             text//'">'//data_file//':'//dataset//'</DataItem>'//nl
   end function data_item

end module xdmf_m
