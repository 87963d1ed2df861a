!> fields.xdmf: tells ParaView where in fields.h5 the meshes and arrays of each time are.
module xdmf_m
   use errors_m, only: error_list_t
   use field_list_m, only: on_nodes, on_triangles, on_joints
   use files_m, only: replace_file
   use kinds_m, only: wp, i8
   use text_m, only: to_text
   implicit none
   private

   public :: write_xdmf, append_xdmf

   !> How the file ends, with its last line end
   character(len=*), parameter :: tail = '</Grid>'//new_line('a')//'</Domain>'//new_line('a')//'</Xdmf>'//new_line('a')

   !> Corners of a triangle, ends of a joint line
   integer, parameter :: corners = 3, ends = 2

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

   !> Write the file; a reader sees the old one or the new one, never half of one.
   subroutine write_xdmf(path, data_file, snapshot, errors)
      character(len=*), intent(in) :: path
      !> Name of the fields file, in the same directory
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot(:)
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: unit, status, i

      open (newunit=unit, file=trim(path)//'.part', action='write', status='replace', iostat=status, iomsg=message)
      if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) '<?xml version="1.0"?>', &
         '<Xdmf Version="2.0">', '<Domain>', '<Grid Name="femdem" GridType="Collection" CollectionType="Temporal">'
      do i = 1, size(snapshot)
         if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) grids(data_file, snapshot(i))
      end do
      if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) tail(:len(tail) - 1)
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status == 0) then
         call replace_file(trim(path)//'.part', path, status)
         message = 'cannot replace the old file'
      end if
      if (status /= 0) call errors%add(trim(path)//': cannot write the index of the fields: '//trim(message))
   end subroutine write_xdmf

   !> Add one time at the end of the file, in one write: what it costs does not grow with the times that are there.
   subroutine append_xdmf(path, data_file, snapshot, errors)
      character(len=*), intent(in) :: path
      !> Name of the fields file, in the same directory
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
         write (unit, pos=length - len(tail) + 1, iostat=status, iomsg=message) &
            grids(data_file, snapshot)//new_line('a')//tail
      end if
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status /= 0) call errors%add(trim(path)//': cannot write the index of the fields: '//trim(message))
   end subroutine append_xdmf

   !> The two grids of one time: the rock, and the joints if there are any.
   function grids(data_file, snapshot) result(text)
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot
      character(len=:), allocatable :: text
      character(len=24) :: time
      character, parameter :: nl = new_line('a')

      write (time, '(es22.15e3)') snapshot%time
      text = '<Grid Name="'//snapshot%path(2:)//'" GridType="Collection" CollectionType="Spatial">'//nl// &
             '<Time Value="'//trim(adjustl(time))//'"/>'//nl// &
             grid(data_file, snapshot, 'rock', 'Triangle', on_triangles, 'triangles', corners)
      if (snapshot%entities(on_joints) > 0) text = text// &
                                                   grid(data_file, snapshot, 'joints', 'Polyline', on_joints, 'joint_lines', ends)
      text = text//'</Grid>'
   end function grids

   !> One grid with the arrays on its cells and on the nodes.
   function grid(data_file, snapshot, name, shape, place, cells, cell_nodes) result(text)
      character(len=*), intent(in) :: data_file
      type(snapshot_t), intent(in) :: snapshot
      !> Name of the grid, and what XDMF calls the cells
      character(len=*), intent(in) :: name, shape
      !> on_triangles or on_joints
      integer, intent(in) :: place
      !> Dataset of the cells in the group of the mesh, and nodes of each
      character(len=*), intent(in) :: cells
      integer, intent(in) :: cell_nodes
      character(len=:), allocatable :: text
      character, parameter :: nl = new_line('a')

      associate (n => snapshot%entities)
         text = '<Grid Name="'//name//'" GridType="Uniform">'//nl// &
                '<Topology TopologyType="'//shape//'" NodesPerElement="'//to_text(cell_nodes)// &
                '" NumberOfElements="'//to_text(n(place))//'">'//nl// &
                data_item(data_file, snapshot%mesh//'/'//cells, 'Int', 4, n(place), cell_nodes)//'</Topology>'//nl// &
                '<Geometry GeometryType="XY">'//nl// &
                data_item(data_file, snapshot%mesh//'/coordinates', 'Float', 8, n(on_nodes), 2)//'</Geometry>'//nl
         if (allocated(snapshot%constant)) text = text//attributes(data_file, snapshot%constant, n, place)
         if (allocated(snapshot%entry)) text = text//attributes(data_file, snapshot%entry, n, place)
      end associate
      text = text//'</Grid>'//nl
   end function grid

   !> The arrays on the nodes and on the given cells.
   function attributes(data_file, entry, entities, place) result(text)
      character(len=*), intent(in) :: data_file
      type(entry_t), intent(in) :: entry(:)
      integer, intent(in) :: entities(3), place
      character(len=:), allocatable :: text
      character, parameter :: nl = new_line('a')
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
             text//'">'//data_file//':'//dataset//'</DataItem>'//new_line('a')
   end function data_item

end module xdmf_m
