!> Reader of gmsh meshes: formats 2.2 and 4.1, text and binary.
module gmsh_m
   use errors_m, only: error_list_t
   use file_buffer_m, only: file_buffer_t
   use gmsh_section_m, only: entity_list_t, read_elements_2, read_elements_4, read_entities, read_names, read_nodes_2, &
                             read_parametric_nodes_2, read_nodes_4
   use gmsh_table_m, only: assemble, gmsh_table_t
   use mesh_m, only: mesh_t
   use text_m, only: quoted
   implicit none
   private

   public :: read_gmsh

   !> Letters of a wrong word that are shown
   integer, parameter :: longest_word = 20
   !> Formats read
   character(len=*), parameter :: format_2 = '2.2', format_4 = '4.1'

contains

   !> Read a mesh. Nodes that no triangle, and no line or point of a group, uses are dropped; triangles are turned
   !> anticlockwise. Whether the mesh makes sense is for mesh_check_m to say.
   subroutine read_gmsh(path, mesh, errors)
      !> Path of the mesh file
      character(len=*), intent(in) :: path
      !> The mesh; its arrays are allocated only when there is no error
      type(mesh_t), intent(out) :: mesh
      !> What is wrong with the file is added here
      type(error_list_t), intent(inout) :: errors
      type(file_buffer_t) :: buffer
      type(gmsh_table_t) :: table
      character(len=:), allocatable :: version
      integer :: before, status

      before = errors%count()
      call buffer%load(path, status)
      if (status /= 0) then
         call errors%add(path//': the mesh file cannot be read (does it exist?)')
         return
      end if
      call read_header(buffer, path, version, errors)
      if (errors%count() > before) return
      call read_sections(buffer, path, version, table, errors)
      if (errors%count() > before) return
      call assemble(table, path, version == format_2, mesh, errors)
   end subroutine read_gmsh

   !> $MeshFormat: the version, text or binary, and the order of bytes.
   subroutine read_header(buffer, path, version, errors)
      type(file_buffer_t), intent(inout) :: buffer
      character(len=*), intent(in) :: path
      !> '2.2' or '4.1'
      character(len=:), allocatable, intent(out) :: version
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: binary, real_size
      integer :: one

      call skip_to_header(buffer)
      if (buffer%bad) then
         call errors%add(path//': not a gmsh mesh (there is no $MeshFormat)')
         return
      end if
      call buffer%get_word(version)
      call buffer%get_word(binary)
      call buffer%get_word(real_size)
      if (version /= format_2 .and. version /= format_4) then
         call errors%add(path//': gmsh format '//quoted(version)//' is not read; write the mesh in format '// &
                         format_2//' or '//format_4)
         return
      end if
      if (verify(binary, '01') > 0 .or. len(binary) /= 1 .or. real_size /= '8') then
         call errors%add(path//': $MeshFormat says '//quoted(binary)//' and '//quoted(real_size)// &
                         '; valid are 0 (text) or 1 (binary), and 8-byte numbers')
         return
      end if
      if (binary == '1') then
         call buffer%skip_line()
         buffer%binary = .true.
         call buffer%get_integer(one)
         if (one /= 1) then
            call errors%add(path//': the file was written on a machine with another order of bytes, '// &
                            'or is cut short; write it as text')
            return
         end if
      end if
      call end_of_section(buffer, path, 'MeshFormat', errors)
   end subroutine read_header

   !> Go behind $MeshFormat. Lines before it, and comments, are passed over as gmsh does.
   subroutine skip_to_header(buffer)
      type(file_buffer_t), intent(inout) :: buffer
      character(len=:), allocatable :: word

      do while (.not. buffer%at_end() .and. .not. buffer%bad)
         call buffer%get_word(word)
         if (word == '$MeshFormat') return
         if (word(1:1) == '$') then
            call buffer%skip_to('$End'//word(2:))
         else
            call buffer%skip_line()
         end if
      end do
      buffer%bad = .true.
   end subroutine skip_to_header

   !> All sections behind the header; those that say nothing of the mesh are passed over.
   subroutine read_sections(buffer, path, version, table, errors)
      type(file_buffer_t), intent(inout) :: buffer
      character(len=*), intent(in) :: path
      !> '2.2' or '4.1'
      character(len=*), intent(in) :: version
      type(gmsh_table_t), intent(inout) :: table
      type(error_list_t), intent(inout) :: errors
      type(entity_list_t) :: entities(0:3)
      character(len=:), allocatable :: word
      integer :: before

      before = errors%count()
      do while (.not. buffer%at_end() .and. errors%count() == before)
         call buffer%get_word(word)
         ! gmsh passes over lines between sections
         if (word(1:1) /= '$') then
            call buffer%skip_line()
            cycle
         end if
         ! The binary numbers begin right behind the line end
         if (buffer%binary) call buffer%skip_line()
         select case (word//' '//version)
         case ('$PhysicalNames '//format_2, '$PhysicalNames '//format_4)
            call read_names(buffer, table)
         case ('$Nodes '//format_2)
            call read_nodes_2(buffer, table)
         case ('$ParametricNodes '//format_2)
            call read_parametric_nodes_2(buffer, table)
         case ('$Elements '//format_2)
            call read_elements_2(buffer, table)
         case ('$Entities '//format_4)
            call read_entities(buffer, entities)
         case ('$Nodes '//format_4)
            call read_nodes_4(buffer, table)
         case ('$Elements '//format_4)
            call read_elements_4(buffer, table, entities)
         case ('$PartitionedEntities '//format_4)
            call errors%add(path//': the mesh is partitioned; write it whole')
            return
         case default
            call buffer%skip_to('$End'//word(2:))
            if (.not. buffer%bad) cycle
         end select
         call end_of_section(buffer, path, word(2:), errors)
      end do
   end subroutine read_sections

   !> The section's end mark must be next.
   subroutine end_of_section(buffer, path, section, errors)
      type(file_buffer_t), intent(inout) :: buffer
      character(len=*), intent(in) :: path
      !> Name of the section without the $
      character(len=*), intent(in) :: section
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: word

      if (buffer%bad) then
         word = buffer%place()
         call errors%add(path//': section $'//section//' cannot be read at '//word//found_there(buffer))
         return
      end if
      call buffer%get_word(word)
      if (word /= '$End'//section) then
         call errors%add(path//': $End'//section//' is expected at '//buffer%place()// &
                         ' (is the file cut short, or a count wrong?)')
      end if
   end subroutine end_of_section

   !> What a text file has where a number is missing.
   function found_there(buffer) result(text)
      type(file_buffer_t), intent(inout) :: buffer
      character(len=:), allocatable :: text, word

      text = ' (is the file cut short?)'
      if (buffer%binary) return
      if (buffer%at_end()) return
      call buffer%get_word(word)
      text = ': a number is expected, but found '//quoted(word(:min(longest_word, len(word))))
   end function found_there

end module gmsh_m
