!> edges.csv: one row a block edge (the chain of joint elements between two intersections, eqs of section 7).
module edge_results_m
   use errors_m, only: error_list_t
   use files_m, only: replace_file
   use kinds_m, only: wp
   use mesh_m, only: group_t
   use text_m, only: to_text, ten_digits, csv_text
   implicit none
   private

   public :: write_edges, edge_sums

   !> What the table says of each block edge
   type, public :: edge_results_t
      !> Group of the edge's joints, and how many there are (edges)
      integer, allocatable :: group(:), joints(:)
      !> Length [m] (edges)
      real(wp), allocatable :: length(:)
      !> Mean weighted by length, and largest, of the magnitude of the shear displacement [mm] (edges)
      real(wp), allocatable :: mean_shear(:), largest_shear(:)
      !> Mean weighted by length, and largest, aperture [mm] (edges)
      real(wp), allocatable :: mean_aperture(:), largest_aperture(:)
   end type edge_results_t

contains

   !> Sums over the joints of each block edge.
   pure function edge_sums(edge, joint_group, length, shear_mm, aperture_mm) result(table)
      !> Block edge of each joint, numbered from 1; smaller: none (joints)
      integer, intent(in) :: edge(:)
      !> Group of each joint (joints)
      integer, intent(in) :: joint_group(:)
      !> Length of each joint [m] (joints)
      real(wp), intent(in) :: length(:)
      !> Shear displacement and aperture [mm] (joints)
      real(wp), intent(in) :: shear_mm(:), aperture_mm(:)
      type(edge_results_t) :: table
      integer :: edges, i, k

      edges = max(0, maxval(edge))
      if (size(edge) == 0) edges = 0
      allocate (table%group(edges), table%joints(edges), source=0)
      allocate (table%length(edges), table%mean_shear(edges), table%largest_shear(edges), source=0.0_wp)
      allocate (table%mean_aperture(edges), table%largest_aperture(edges), source=0.0_wp)
      do i = 1, size(edge)
         k = edge(i)
         if (k < 1) cycle
         table%group(k) = joint_group(i)
         table%joints(k) = table%joints(k) + 1
         table%length(k) = table%length(k) + length(i)
         table%mean_shear(k) = table%mean_shear(k) + length(i)*abs(shear_mm(i))
         table%mean_aperture(k) = table%mean_aperture(k) + length(i)*aperture_mm(i)
         table%largest_shear(k) = max(table%largest_shear(k), abs(shear_mm(i)))
         table%largest_aperture(k) = max(table%largest_aperture(k), aperture_mm(i))
      end do
      where (table%length > 0.0_wp)
         table%mean_shear = table%mean_shear/table%length
         table%mean_aperture = table%mean_aperture/table%length
      end where
   end function edge_sums

   !> Write the table; a reader sees the old file or the new one, never half of one.
   subroutine write_edges(path, table, group, errors)
      character(len=*), intent(in) :: path
      type(edge_results_t), intent(in) :: table
      !> Groups of the mesh
      type(group_t), intent(in) :: group(:)
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: unit, status, i

      open (newunit=unit, file=trim(path)//'.part', action='write', status='replace', iostat=status, iomsg=message)
      if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) 'id,group,joints,length_m,'// &
         'mean_shear_displacement_mm,largest_shear_displacement_mm,mean_aperture_mm,largest_aperture_mm'
      do i = 1, size(table%length)
         if (status /= 0) exit
         write (unit, '(a)', iostat=status, iomsg=message) to_text(i)//','//csv_text(group_name(group, table%group(i)))//','// &
            to_text(table%joints(i))//','//ten_digits(table%length(i))//','//ten_digits(table%mean_shear(i))//','// &
            ten_digits(table%largest_shear(i))//','//ten_digits(table%mean_aperture(i))//','//ten_digits(table%largest_aperture(i))
      end do
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status == 0) then
         call replace_file(trim(path)//'.part', path, status)
         message = 'cannot replace the old file'
      end if
      if (status /= 0) call errors%add(trim(path)//': cannot write the table of block edges: '//trim(message))
   end subroutine write_edges

   !> Name of a group, or its number when it has none.
   pure function group_name(group, i) result(name)
      type(group_t), intent(in) :: group(:)
      integer, intent(in) :: i
      character(len=:), allocatable :: name

      name = ''
      if (i >= 1 .and. i <= size(group)) name = trim(group(i)%name)
      if (name == '') name = to_text(i)
   end function group_name

end module edge_results_m
