!> The sections of a gmsh file, formats 2.2 and 4.1, text and binary. Each reader begins behind the section's name and
!> leaves the buffer at its end mark; where something is missing the buffer is left bad.
module gmsh_section_m
   use file_buffer_m, only: file_buffer_t
   use gmsh_table_m, only: add_element, add_group, gmsh_table_t, no_group
   use kinds_m, only: i8
   implicit none
   private

   public :: read_names, read_nodes_2, read_parametric_nodes_2, read_elements_2, read_entities, read_nodes_4, read_elements_4

   !> Physical groups of the geometrical entities of one dimension (format 4.1)
   type, public :: entity_list_t
      !> Number of each entity (entities); its groups are physical(first(i):first(i+1)-1)
      integer, allocatable :: number(:), first(:), physical(:)
   end type entity_list_t

   !> Most tags and nodes of one element that are read (the 5th-order tetrahedron has 56 nodes)
   integer, parameter :: most_tags = 64, most_nodes = 64
   !> Nodes of gmsh's element types 1 to 31
   integer, parameter :: nodes_of_type(31) = [2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, &
                                              12, 15, 15, 21, 4, 5, 6, 20, 35, 56]
   !> Highest dimension of an entity
   integer, parameter :: volume = 3

contains

   !> $PhysicalNames: dimension, number and name of each group; text in binary files too.
   subroutine read_names(buffer, table)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table
      character(len=:), allocatable :: line
      integer(i8) :: names, i, dimension, tag
      integer :: first, last

      call buffer%get_text_integer(names)
      do i = 1, names
         call buffer%get_text_integer(dimension)
         call buffer%get_text_integer(tag)
         if (buffer%bad) return
         call buffer%get_line(line)
         first = index(line, '"')
         last = index(line, '"', back=.true.)
         buffer%bad = last <= first
         if (buffer%bad) return
         if (dimension < volume) call add_group(table, int(dimension), int(tag), line(first + 1:last - 1))
      end do
   end subroutine read_names

   !> $Nodes of format 2.2: number and coordinates of each.
   subroutine read_nodes_2(buffer, table)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table

      call read_nodes(buffer, .false., table)
   end subroutine read_nodes_2

   !> $ParametricNodes of format 2.2: the same with where each is on its entity.
   subroutine read_parametric_nodes_2(buffer, table)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table

      call read_nodes(buffer, .true., table)
   end subroutine read_parametric_nodes_2

   !> Nodes of format 2.2.
   subroutine read_nodes(buffer, is_parametric, table)
      type(file_buffer_t), intent(inout) :: buffer
      logical, intent(in) :: is_parametric
      type(gmsh_table_t), intent(inout) :: table
      integer(i8) :: nodes
      integer :: i, j

      call buffer%get_text_integer(nodes)
      call make_room_for_nodes(buffer, table, nodes)
      if (buffer%bad) return
      if (buffer%binary) call buffer%skip_line()
      do i = 1, size(table%node_number)
         call buffer%get_tag(.false., table%node_number(i))
         do j = 1, 3
            call buffer%get_real(table%x(j, i))
         end do
         if (buffer%bad) return
         if (is_parametric) call skip_parameters(buffer)
      end do
   end subroutine read_nodes

   !> Entity of a node, by dimension and number, and its one or two coordinates there.
   subroutine skip_parameters(buffer)
      type(file_buffer_t), intent(inout) :: buffer
      integer :: dimension, entity

      call buffer%get_integer(dimension)
      call buffer%get_integer(entity)
      if (dimension == 1 .or. dimension == 2) call skip_reals(buffer, dimension)
   end subroutine skip_parameters

   !> A number of nodes that the file has bytes for. A second $Nodes section is bad.
   subroutine make_room_for_nodes(buffer, table, nodes)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table
      integer(i8), intent(in) :: nodes

      buffer%bad = buffer%bad .or. nodes < 1_i8 .or. nodes > len(buffer%bytes, i8) .or. allocated(table%node_number)
      if (.not. buffer%bad) allocate (table%node_number(nodes), table%x(3, nodes))
   end subroutine make_room_for_nodes

   !> $Elements of format 2.2: each with its own tags, the first of them its physical group. An element of several
   !> groups stands there several times.
   subroutine read_elements_2(buffer, table)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table
      integer(i8) :: elements, done, number
      integer :: gmsh_type, tags, block_size, i

      call buffer%get_text_integer(elements)
      if (buffer%binary) call buffer%skip_line()
      done = 0_i8
      do while (done < elements .and. .not. buffer%bad)
         if (buffer%binary) then
            call buffer%get_integer(gmsh_type)
            call buffer%get_integer(block_size)
            call buffer%get_integer(tags)
         else
            block_size = 1
            call buffer%get_tag(.false., number)
            call buffer%get_integer(gmsh_type)
            call buffer%get_integer(tags)
         end if
         buffer%bad = buffer%bad .or. block_size < 1
         do i = 1, block_size
            if (buffer%binary) call buffer%get_tag(.false., number)
            call read_element_2(buffer, table, number, gmsh_type, tags)
            if (buffer%bad) return
         end do
         done = done + int(block_size, i8)
      end do
   end subroutine read_elements_2

   !> Tags and nodes of one element of format 2.2.
   subroutine read_element_2(buffer, table, number, gmsh_type, tags)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table
      !> Number of the element; its type, number of its tags
      integer(i8), intent(in) :: number
      integer, intent(in) :: gmsh_type, tags
      integer(i8) :: node(most_nodes)
      integer :: tag(most_tags), nodes, i

      nodes = node_count(gmsh_type)
      buffer%bad = buffer%bad .or. tags < 0 .or. tags > most_tags .or. nodes == 0
      if (buffer%bad) return
      tag(1) = no_group
      do i = 1, tags
         call buffer%get_integer(tag(i))
      end do
      do i = 1, nodes
         call buffer%get_tag(.false., node(i))
      end do
      if (.not. buffer%bad) call add_element(table, gmsh_type, number, tag(1), node(:min(nodes, 3)))
   end subroutine read_element_2

   !> Nodes of an element type (0: not known).
   pure integer function node_count(gmsh_type)
      integer, intent(in) :: gmsh_type

      node_count = 0
      if (gmsh_type >= 1 .and. gmsh_type <= size(nodes_of_type)) node_count = nodes_of_type(gmsh_type)
   end function node_count

   !> $Entities of format 4.1: which physical groups every geometrical entity is in.
   subroutine read_entities(buffer, entities)
      type(file_buffer_t), intent(inout) :: buffer
      !> Points, curves, surfaces, volumes
      type(entity_list_t), intent(inout) :: entities(0:)
      integer :: entity_count(0:volume), dimension

      do dimension = 0, volume
         call buffer%get_long(entity_count(dimension))
         buffer%bad = buffer%bad .or. entity_count(dimension) < 0
         buffer%bad = buffer%bad .or. int(entity_count(dimension), i8) > len(buffer%bytes, i8)
      end do
      do dimension = 0, volume
         if (.not. buffer%bad) call read_entity_list(buffer, dimension, entity_count(dimension), entities(dimension))
      end do
   end subroutine read_entities

   !> The entities of one dimension.
   subroutine read_entity_list(buffer, dimension, entities, list)
      type(file_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: dimension, entities
      type(entity_list_t), intent(out) :: list
      integer, allocatable :: physical(:)
      integer :: i, j, length, boundaries
      logical :: bounded

      bounded = dimension > 0
      allocate (list%number(entities), list%first(entities + 1), list%physical(0))
      list%first(1) = 1
      do i = 1, entities
         call buffer%get_integer(list%number(i))
         call skip_reals(buffer, merge(6, 3, bounded))
         call buffer%get_long(length)
         buffer%bad = buffer%bad .or. length < 0 .or. length > most_tags
         if (buffer%bad) return
         if (allocated(physical)) deallocate (physical)
         allocate (physical(length))
         do j = 1, length
            call buffer%get_integer(physical(j))
         end do
         if (length > 0) list%physical = [list%physical, physical]
         list%first(i + 1) = size(list%physical) + 1
         if (bounded) then
            call buffer%get_long(boundaries)
            do j = 1, boundaries
               call buffer%get_integer(length)
               if (buffer%bad) return
            end do
         end if
         if (buffer%bad) return
      end do
   end subroutine read_entity_list

   subroutine skip_reals(buffer, reals)
      type(file_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: reals
      character(len=:), allocatable :: word
      integer :: i

      ! Limits of an empty entity may be written as inf: the words are not looked at.
      do i = 1, reals
         if (buffer%binary) then
            buffer%at = buffer%at + 8_i8
         else
            call buffer%get_word(word)
         end if
      end do
   end subroutine skip_reals

   !> $Nodes of format 4.1: blocks of one entity each, first the numbers, then the coordinates.
   subroutine read_nodes_4(buffer, table)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table
      integer(i8) :: least, highest
      integer :: blocks, nodes, b, i, j, done, dimension, entity, parametric, block_nodes
      real(kind(table%x)) :: parameter_value

      call buffer%get_long(blocks)
      call buffer%get_long(nodes)
      call buffer%get_tag(.true., least)
      call buffer%get_tag(.true., highest)
      call make_room_for_nodes(buffer, table, int(nodes, i8))
      done = 0
      do b = 1, blocks
         call buffer%get_integer(dimension)
         call buffer%get_integer(entity)
         call buffer%get_integer(parametric)
         call buffer%get_long(block_nodes)
         buffer%bad = buffer%bad .or. block_nodes < 0 .or. block_nodes > nodes - done
         if (buffer%bad) return
         do i = done + 1, done + block_nodes
            call buffer%get_tag(.true., table%node_number(i))
         end do
         do i = done + 1, done + block_nodes
            do j = 1, 3
               call buffer%get_real(table%x(j, i))
            end do
            do j = 1, merge(dimension, 0, parametric /= 0)
               call buffer%get_real(parameter_value)
            end do
            if (buffer%bad) return
         end do
         done = done + block_nodes
      end do
      buffer%bad = buffer%bad .or. done /= nodes
   end subroutine read_nodes_4

   !> $Elements of format 4.1: blocks of one entity and one type each. An element is added once for every physical
   !> group of its entity, as it stands in a file of format 2.2.
   subroutine read_elements_4(buffer, table, entities)
      type(file_buffer_t), intent(inout) :: buffer
      type(gmsh_table_t), intent(inout) :: table
      type(entity_list_t), intent(in) :: entities(0:)
      integer(i8) :: least, highest, number, node(most_nodes)
      integer :: blocks, elements, b, i, j, dimension, entity, gmsh_type, block_elements, nodes, at(0:volume)
      integer, allocatable :: group(:)

      call buffer%get_long(blocks)
      call buffer%get_long(elements)
      call buffer%get_tag(.true., least)
      call buffer%get_tag(.true., highest)
      at = 1
      do b = 1, blocks
         call buffer%get_integer(dimension)
         call buffer%get_integer(entity)
         call buffer%get_integer(gmsh_type)
         call buffer%get_long(block_elements)
         nodes = node_count(gmsh_type)
         buffer%bad = buffer%bad .or. dimension < 0 .or. dimension > volume .or. nodes == 0
         if (buffer%bad) return
         call groups_of_entity(entities(dimension), entity, at(dimension), group)
         do i = 1, block_elements
            call buffer%get_tag(.true., number)
            do j = 1, nodes
               call buffer%get_tag(.true., node(j))
            end do
            if (buffer%bad) return
            do j = 1, size(group)
               call add_element(table, gmsh_type, number, group(j), node(:min(nodes, 3)))
            end do
         end do
      end do
   end subroutine read_elements_4

   !> Physical groups of an entity; no_group when it is in none. Blocks mostly follow the order of the entities, so the
   !> search goes on from the last one found.
   subroutine groups_of_entity(list, entity, at, group)
      type(entity_list_t), intent(in) :: list
      integer, intent(in) :: entity
      !> Where the last search ended
      integer, intent(inout) :: at
      integer, allocatable, intent(out) :: group(:)
      integer :: i

      group = [no_group]
      if (.not. allocated(list%number)) return
      do i = 1, size(list%number)
         if (at > size(list%number)) at = 1
         if (list%number(at) == entity) then
            if (list%first(at + 1) > list%first(at)) group = list%physical(list%first(at):list%first(at + 1) - 1)
            return
         end if
         at = at + 1
      end do
   end subroutine groups_of_entity

end module gmsh_section_m
