!> The sparse matrix of the implicit solver: which unknowns there are, where the entries stand, and how elements add.
!>
!> Every component of a node's displacement that is not prescribed is an unknown. The pattern joins the nodes of each group that
!> the terms say their tangents join (join_nodes of term_t).
module sparse_system_m
   use kinds_m, only: wp
   use rows_m, only: fill_rows
   implicit none
   private

   public :: build_system, matrix_of, restore_system, add_block, multiply, gather, scatter

   type, public :: sparse_system_t
      !> Number of unknowns; unknown of each displacement component, 0 when prescribed (2, nodes)
      integer :: unknowns = 0
      integer, allocatable :: number(:, :)
      !> Rows, sorted by column: entries of row i are first(i) to first(i + 1) - 1; row and column of each entry
      integer, allocatable :: first(:), row(:), column(:)
      real(wp), allocatable :: value(:)
      !> Entry of each element of the stiffness of a triangle, 0 when prescribed (36, triangles)
      integer, allocatable :: triangle_entry(:, :)
   end type sparse_system_t

   !> Groups of nodes that are all joined with each other
   type, public :: node_groups_t
      private
      !> Nodes of group g: node(first(g):first(g + 1) - 1); how many groups and nodes there are
      integer, allocatable :: first(:), node(:)
      integer :: number = 0, last = 0
   contains
      procedure :: begin
      procedure :: add
      procedure :: join
   end type node_groups_t

   !> Room for groups and their nodes at first
   integer, parameter :: first_room = 1024

   !> What a checkpoint keeps of a system: its pattern, laid out at some state before, and the matrix that is in use
   type, public :: kept_matrix_t
      !> Compressed rows, as in sparse_system_t; of size zero when there is no system
      integer, allocatable :: first(:), column(:)
      !> Of size zero when the matrix is to be made anew (entries) [N/m per m of thickness]
      real(wp), allocatable :: value(:)
      !> Does it belong to a state that has been left?
      logical :: outdated = .false.
   end type kept_matrix_t

contains

   !> What to keep of a system.
   pure function matrix_of(system, factored, outdated) result(matrix)
      type(sparse_system_t), intent(in) :: system
      !> The matrix that was factored (entries), of size zero when iterations go on with none; see kept_matrix_t
      real(wp), intent(in) :: factored(:)
      logical, intent(in) :: outdated
      type(kept_matrix_t) :: matrix

      allocate (matrix%first(0), matrix%column(0), matrix%value(0))
      if (.not. allocated(system%first)) return
      matrix%first = system%first
      matrix%column = system%column
      matrix%value = factored
      matrix%outdated = outdated
   end function matrix_of

   !> The system that was kept.
   pure subroutine restore_system(fixed, triangle, matrix, system)
      !> Prescribed components (2, nodes), corner nodes (3, triangles)
      logical, intent(in) :: fixed(:, :)
      integer, intent(in) :: triangle(:, :)
      type(kept_matrix_t), intent(in) :: matrix
      type(sparse_system_t), intent(out) :: system
      integer :: i

      call number_unknowns(fixed, system)
      system%first = matrix%first
      system%column = matrix%column
      allocate (system%row(size(system%column)))
      do i = 1, system%unknowns
         system%row(system%first(i):system%first(i + 1) - 1) = i
      end do
      allocate (system%value(size(system%column)), source=0.0_wp)
      if (size(matrix%value) > 0) system%value = matrix%value
      call place_triangles(triangle, system)
   end subroutine restore_system

   !> Every displacement component that is not prescribed is an unknown, node after node.
   pure subroutine number_unknowns(fixed, system)
      !> (2, nodes)
      logical, intent(in) :: fixed(:, :)
      type(sparse_system_t), intent(inout) :: system
      integer :: n, i

      allocate (system%number(2, size(fixed, 2)), source=0)
      do n = 1, size(fixed, 2)
         do i = 1, 2
            if (fixed(i, n)) cycle
            system%unknowns = system%unknowns + 1
            system%number(i, n) = system%unknowns
         end do
      end do
   end subroutine number_unknowns

   !> Number the unknowns and lay out the pattern.
   subroutine build_system(fixed, triangle, groups, system)
      !> Prescribed components (2, nodes), corner nodes (3, triangles)
      logical, intent(in) :: fixed(:, :)
      integer, intent(in) :: triangle(:, :)
      !> Nodes whose displacements are joined, those of the triangles among them
      type(node_groups_t), intent(in) :: groups
      type(sparse_system_t), intent(out) :: system
      integer, allocatable :: first(:), neighbour(:)

      call number_unknowns(fixed, system)
      call node_neighbours(size(fixed, 2), groups%first(:groups%number + 1), groups%node(:groups%last), first, neighbour)
      call expand(first, neighbour, system)
      allocate (system%value(size(system%column)), source=0.0_wp)
      call place_triangles(triangle, system)
   end subroutine build_system

   !> Begin another group of nodes.
   pure subroutine begin(self)
      class(node_groups_t), intent(inout) :: self

      if (.not. allocated(self%first)) allocate (self%first(first_room), self%node(first_room))
      if (self%number + 2 > size(self%first)) call make_room(self%first, 2*size(self%first))
      self%number = self%number + 1
      self%first(self%number:self%number + 1) = self%last + 1
   end subroutine begin

   !> Add nodes to the group that was begun last; one that is there already may come again.
   pure subroutine add(self, node)
      class(node_groups_t), intent(inout) :: self
      integer, intent(in) :: node(:)

      if (self%last + size(node) > size(self%node)) call make_room(self%node, 2*(self%last + size(node)))
      self%node(self%last + 1:self%last + size(node)) = node
      self%last = self%last + size(node)
      self%first(self%number + 1) = self%last + 1
   end subroutine add

   !> A whole group.
   pure subroutine join(self, node)
      class(node_groups_t), intent(inout) :: self
      integer, intent(in) :: node(:)

      call self%begin()
      call self%add(node)
   end subroutine join

   !> A longer list.
   pure subroutine make_room(list, room)
      integer, allocatable, intent(inout) :: list(:)
      integer, intent(in) :: room
      integer, allocatable :: longer(:)

      allocate (longer(room))
      longer(:size(list)) = list
      call move_alloc(longer, list)
   end subroutine make_room

   !> Neighbours of each node, itself included, sorted.
   subroutine node_neighbours(nodes, group_first, group_node, first, neighbour)
      integer, intent(in) :: nodes, group_first(:), group_node(:)
      !> Neighbours of node i: neighbour(first(i):first(i + 1) - 1)
      integer, allocatable, intent(out) :: first(:), neighbour(:)
      integer, allocatable :: start(:), of_node(:), seen(:), found(:)
      integer :: n, count, pass

      call groups_of_nodes(nodes, group_first, group_node, start, of_node)
      allocate (first(nodes + 1), found(nodes), seen(nodes), neighbour(0))
      ! Once to count, once to keep
      do pass = 1, 2
         seen = 0
         first(1) = 1
         do n = 1, nodes
            call meet(n)
            if (pass == 2) then
               call sort(found(:count))
               neighbour(first(n):first(n) + count - 1) = found(:count)
            end if
            first(n + 1) = first(n) + count
         end do
         if (pass == 1) then
            deallocate (neighbour)
            allocate (neighbour(first(nodes + 1) - 1))
         end if
      end do

   contains

      !> Distinct nodes of all groups of a node.
      subroutine meet(n)
         integer, intent(in) :: n
         integer :: k, i

         count = 0
         do k = start(n), start(n + 1) - 1
            do i = group_first(of_node(k)), group_first(of_node(k) + 1) - 1
               if (seen(group_node(i)) == n) cycle
               seen(group_node(i)) = n
               count = count + 1
               found(count) = group_node(i)
            end do
         end do
      end subroutine meet

   end subroutine node_neighbours

   !> Groups each node belongs to (compressed rows).
   pure subroutine groups_of_nodes(nodes, group_first, group_node, start, of_node)
      integer, intent(in) :: nodes, group_first(:), group_node(:)
      !> Groups of node n: of_node(start(n):start(n + 1) - 1)
      integer, allocatable, intent(out) :: start(:), of_node(:)
      integer, allocatable :: entry(:)
      integer :: group(group_first(size(group_first)) - 1), g

      do g = 1, size(group_first) - 1
         group(group_first(g):group_first(g + 1) - 1) = g
      end do
      call fill_rows(group_node(:size(group)), nodes, start, entry)
      of_node = group(entry)
   end subroutine groups_of_nodes

   !> Sort a short list by insertion.
   pure subroutine sort(list)
      integer, intent(inout) :: list(:)
      integer :: i, k, value

      do i = 2, size(list)
         value = list(i)
         k = i - 1
         do while (k >= 1)
            if (list(k) <= value) exit
            list(k + 1) = list(k)
            k = k - 1
         end do
         list(k + 1) = value
      end do
   end subroutine sort

   !> From nodes to unknowns. Unknowns are numbered node after node, so that sorted nodes give sorted columns.
   pure subroutine expand(first, neighbour, system)
      integer, intent(in) :: first(:), neighbour(:)
      type(sparse_system_t), intent(inout) :: system
      integer :: n, i, k, c, pass, entry

      allocate (system%first(system%unknowns + 1))
      do pass = 1, 2
         entry = 0
         do n = 1, size(first) - 1
            do i = 1, 2
               if (system%number(i, n) == 0) cycle
               system%first(system%number(i, n)) = entry + 1
               do k = first(n), first(n + 1) - 1
                  do c = 1, 2
                     if (system%number(c, neighbour(k)) == 0) cycle
                     entry = entry + 1
                     if (pass == 1) cycle
                     system%row(entry) = system%number(i, n)
                     system%column(entry) = system%number(c, neighbour(k))
                  end do
               end do
            end do
         end do
         if (pass == 1) allocate (system%row(entry), system%column(entry))
      end do
      system%first(system%unknowns + 1) = entry + 1
   end subroutine expand

   !> Entries of the triangles' stiffness.
   pure subroutine place_triangles(triangle, system)
      integer, intent(in) :: triangle(:, :)
      type(sparse_system_t), intent(inout) :: system
      integer :: e, i, j, unknown(6)

      allocate (system%triangle_entry(36, size(triangle, 2)))
      do e = 1, size(triangle, 2)
         unknown = reshape(system%number(:, triangle(:, e)), [6])
         do j = 1, 6
            do i = 1, 6
               system%triangle_entry(6*(j - 1) + i, e) = entry_of(system, unknown(i), unknown(j))
            end do
         end do
      end do
   end subroutine place_triangles

   !> Where an entry stands; 0 when a component is prescribed or the pattern has no such entry.
   pure integer function entry_of(system, row, column) result(entry)
      type(sparse_system_t), intent(in) :: system
      integer, intent(in) :: row, column
      integer :: low, high

      entry = 0
      if (row == 0 .or. column == 0) return
      low = system%first(row)
      high = system%first(row + 1) - 1
      do while (low < high)
         entry = (low + high)/2
         if (system%column(entry) < column) then
            low = entry + 1
         else
            high = entry
         end if
      end do
      entry = low
      if (low > high) then
         entry = 0
      else if (system%column(low) /= column) then
         entry = 0
      end if
   end function entry_of

   !> Add the stiffness of a group of nodes; outside says that the pattern has no room for it.
   pure subroutine add_block(system, node, stiffness, outside)
      type(sparse_system_t), intent(inout) :: system
      !> Nodes, and the stiffness of their components x, y of node after node
      integer, intent(in) :: node(:)
      real(wp), intent(in) :: stiffness(:, :)
      !> Set when an entry is not in the pattern; left as it is otherwise
      logical, intent(inout) :: outside
      integer :: sorted(size(node)), a, b, s, i, j, row, column, entry, at, many

      call sort_nodes(system, node, sorted, many)
      ! Rows of a node have the same columns, and columns of a node stand side by side: one entry tells where the four are
      do a = 1, many
         row = first_of(system%number(:, node(sorted(a))))
         entry = system%first(row)
         do s = 1, many
            b = sorted(s)
            column = first_of(system%number(:, node(b)))
            do while (entry < system%first(row + 1))
               if (system%column(entry) >= column) exit
               entry = entry + 1
            end do
            if (entry == system%first(row + 1)) then
               outside = .true.
               exit
            end if
            if (system%column(entry) /= column) then
               outside = .true.
               cycle
            end if
            do j = 1, 2
               if (system%number(j, node(b)) == 0) cycle
               do i = 1, 2
                  if (system%number(i, node(sorted(a))) == 0) cycle
                  at = entry + system%first(system%number(i, node(sorted(a)))) - system%first(row) &
                       + system%number(j, node(b)) - column
                  system%value(at) = system%value(at) + stiffness(2*(sorted(a) - 1) + i, 2*(b - 1) + j)
               end do
            end do
         end do
      end do
   end subroutine add_block

   !> The nodes of a group that move, in the order of their unknowns.
   pure subroutine sort_nodes(system, node, sorted, many)
      type(sparse_system_t), intent(in) :: system
      integer, intent(in) :: node(:)
      !> Places in the group (many)
      integer, intent(out) :: sorted(:), many
      integer :: a, k, row

      many = 0
      do a = 1, size(node)
         row = first_of(system%number(:, node(a)))
         if (row == 0) cycle
         k = many
         do while (k >= 1)
            if (first_of(system%number(:, node(sorted(k)))) <= row) exit
            sorted(k + 1) = sorted(k)
            k = k - 1
         end do
         sorted(k + 1) = a
         many = many + 1
      end do
   end subroutine sort_nodes

   !> The first of a node's unknowns, 0 when it has none.
   pure integer function first_of(number)
      integer, intent(in) :: number(2)

      first_of = number(1)
      if (first_of == 0) first_of = number(2)
   end function first_of

   !> Product of a matrix of the system's pattern with a vector.
   pure subroutine multiply(system, x, product)
      type(sparse_system_t), intent(in) :: system
      !> (unknowns)
      real(wp), contiguous, intent(in) :: x(:)
      real(wp), contiguous, intent(out) :: product(:)
      real(wp) :: total
      integer :: i, k

      do i = 1, system%unknowns
         total = 0.0_wp
         do k = system%first(i), system%first(i + 1) - 1
            total = total + system%value(k)*x(system%column(k))
         end do
         product(i) = total
      end do
   end subroutine multiply

   !> Unknowns of a nodal field.
   pure subroutine gather(system, field, vector)
      type(sparse_system_t), intent(in) :: system
      !> (2, nodes)
      real(wp), contiguous, intent(in) :: field(:, :)
      !> (unknowns)
      real(wp), intent(out) :: vector(:)
      integer :: n, i

      do n = 1, size(field, 2)
         do i = 1, 2
            if (system%number(i, n) > 0) vector(system%number(i, n)) = field(i, n)
         end do
      end do
   end subroutine gather

   !> Add a vector of unknowns, times a factor, to a nodal field.
   pure subroutine scatter(system, factor, vector, field)
      type(sparse_system_t), intent(in) :: system
      real(wp), intent(in) :: factor
      !> (unknowns)
      real(wp), intent(in) :: vector(:)
      !> (2, nodes)
      real(wp), contiguous, intent(inout) :: field(:, :)
      integer :: n, i

      do n = 1, size(field, 2)
         do i = 1, 2
            if (system%number(i, n) > 0) field(i, n) = field(i, n) + factor*vector(system%number(i, n))
         end do
      end do
   end subroutine scatter

end module sparse_system_m
