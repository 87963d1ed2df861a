!> In which order the unknowns of a sparse system are eliminated, and in which groups (fronts).
!>
!> Nested dissection of the graph of the nodes by METIS gives the order; both components of a node go together. METIS starts from a
!> seed of its own: the same matrix gets the same order, in every run. The elimination tree (Liu 1990) says which unknown has to
!> wait for which; unknowns that are eliminated one after the other and reach the same others make a front, and small fronts
!> join that of their parent where that stores few zeros (Ashcraft and Grimes 1989).
module elimination_m
   use, intrinsic :: iso_c_binding, only: c_int32_t, c_null_ptr, c_ptr
   use kinds_m, only: wp
   use rows_m, only: fill_rows
   implicit none
   private

   public :: plan_elimination

   type, public :: elimination_t
      !> Place of each unknown in the order of elimination (unknowns)
      integer, allocatable :: place(:)
      !> Front f eliminates the places first(f) to first(f + 1) - 1 (fronts + 1)
      integer, allocatable :: first(:)
      !> Front that is eliminated next of those that the front reaches, after it; 0: it reaches none (fronts)
      integer, allocatable :: parent(:)
      !> Later places that front f reaches: border(border_first(f):border_first(f + 1) - 1), sorted
      integer, allocatable :: border_first(:), border(:)
   end type elimination_t

   !> The graph of the vertices: nodes with all their unknowns
   type :: graph_t
      integer :: vertices = 0
      !> Neighbours of vertex v: neighbour(first(v):first(v + 1) - 1)
      integer, allocatable :: first(:), neighbour(:)
      !> Unknowns of each (vertices)
      integer, allocatable :: unknowns(:)
   end type graph_t

   !> A child joins its parent when together they have no more pivots than the first number and zeros are no more than the second of
   !> what is stored (as in CHOLMOD; Chen and others 2008)
   integer, parameter :: few_pivots(3) = [4, 16, 48]
   real(wp), parameter :: zeros_then(3) = [1.0_wp, 0.8_wp, 0.1_wp], zeros_always = 0.05_wp

   integer(c_int32_t), parameter :: metis_ok = 1_c_int32_t

   interface
      !> Fill-reducing order of a graph (METIS 5, 32-bit indices from 0): of the vertex at each place, and place of each vertex
      function metis_node_nd(vertices, first, neighbour, weights, options, vertex_at, place) &
         bind(c, name='METIS_NodeND') result(status)
         import :: c_int32_t, c_ptr
         implicit none
         integer(c_int32_t), intent(in) :: vertices, first(*), neighbour(*)
         type(c_ptr), value :: weights, options
         integer(c_int32_t), intent(out) :: vertex_at(*), place(*)
         integer(c_int32_t) :: status
      end function metis_node_nd
   end interface

contains

   !> Order and fronts of a matrix whose pattern is the same across the diagonal.
   subroutine plan_elimination(row, column, vertex, plan)
      !> Places of the entries, from 1 (entries)
      integer, intent(in) :: row(:), column(:)
      !> Vertex of each unknown; those of one vertex have the same pattern and are all joined (unknowns)
      integer, intent(in) :: vertex(:)
      type(elimination_t), intent(out) :: plan
      type(graph_t) :: graph
      integer, allocatable :: place(:), parent(:), reach(:), front(:), front_parent(:)

      call make_graph(row, column, vertex, graph)
      call dissect(graph, place)
      call find_tree(graph, place, parent)
      call sort_tree(parent, place)
      call count_reach(graph, place, parent, reach)
      call make_fronts(graph, place, parent, reach, front, front_parent)
      call number_fronts(graph, place, front, front_parent, plan)
      call find_borders(graph, place, plan)
      call expand(graph, vertex, place, plan)
   end subroutine plan_elimination

   !> Neighbours of every vertex, each once.
   subroutine make_graph(row, column, vertex, graph)
      integer, intent(in) :: row(:), column(:), vertex(:)
      type(graph_t), intent(out) :: graph
      integer, allocatable :: first(:), item(:), seen(:), from(:), to(:)
      logical :: leads(size(vertex))
      integer :: i, k, v, n

      graph%vertices = maxval(vertex)
      allocate (graph%unknowns(graph%vertices), source=0)
      do i = 1, size(vertex)
         graph%unknowns(vertex(i)) = graph%unknowns(vertex(i)) + 1
         leads(i) = graph%unknowns(vertex(i)) == 1
      end do
      allocate (from(size(row)), to(size(row)))
      n = 0
      do k = 1, size(row)
         if (.not. (leads(row(k)) .and. leads(column(k))) .or. vertex(row(k)) == vertex(column(k))) cycle
         n = n + 1
         from(n) = vertex(row(k))
         to(n) = vertex(column(k))
      end do
      call fill_rows(from(:n), graph%vertices, first, item)
      allocate (graph%first(graph%vertices + 1), graph%neighbour(n), seen(graph%vertices))
      seen = 0
      n = 0
      do v = 1, graph%vertices
         graph%first(v) = n + 1
         do k = first(v), first(v + 1) - 1
            if (seen(to(item(k))) == v) cycle
            seen(to(item(k))) = v
            n = n + 1
            graph%neighbour(n) = to(item(k))
         end do
      end do
      graph%first(graph%vertices + 1) = n + 1
      graph%neighbour = graph%neighbour(:n)
   end subroutine make_graph

   !> Place of every vertex by nested dissection; as they are numbered where METIS finds none.
   subroutine dissect(graph, place)
      type(graph_t), intent(in) :: graph
      integer, allocatable, intent(out) :: place(:)
      integer(c_int32_t), allocatable :: vertex_at(:), place_of(:)
      integer(c_int32_t) :: status
      integer :: v

      place = [(v, v=1, graph%vertices)]
      if (size(graph%neighbour) == 0) return
      allocate (vertex_at(graph%vertices), place_of(graph%vertices))
      status = metis_node_nd(int(graph%vertices, c_int32_t), graph%first - 1_c_int32_t, graph%neighbour - 1_c_int32_t, c_null_ptr, &
                             c_null_ptr, vertex_at, place_of)
      if (status == metis_ok) place = place_of + 1
   end subroutine dissect

   !> Parent of each place in the elimination tree: the first later one that it reaches, 0 when it reaches none.
   pure subroutine find_tree(graph, place, parent)
      type(graph_t), intent(in) :: graph
      integer, intent(in) :: place(:)
      integer, allocatable, intent(out) :: parent(:)
      integer :: ancestor(graph%vertices), vertex_at(graph%vertices), i, j, k, next

      allocate (parent(graph%vertices), source=0)
      ancestor = 0
      vertex_at(place) = [(i, i=1, graph%vertices)]
      do i = 1, graph%vertices
         do k = graph%first(vertex_at(i)), graph%first(vertex_at(i) + 1) - 1
            j = place(graph%neighbour(k))
            if (j >= i) cycle
            do while (j /= i)
               next = ancestor(j)
               ancestor(j) = i
               if (next == 0) parent(j) = i
               if (next == 0) exit
               j = next
            end do
         end do
      end do
   end subroutine find_tree

   !> Number a tree anew so that all below a place come right before it. Parents have larger numbers before and after.
   pure subroutine sort_tree(parent, place)
      !> Parent of each place, in the new numbers on return
      integer, intent(inout) :: parent(:)
      !> Places of whatever stands there, to be changed to the new numbers
      integer, intent(inout) :: place(:)
      integer, dimension(size(parent)) :: below, new, last, sorted
      integer :: i, end_of_roots

      below = 1
      do i = 1, size(parent)
         if (parent(i) > 0) below(parent(i)) = below(parent(i)) + below(i)
      end do
      end_of_roots = size(parent)
      do i = size(parent), 1, -1
         if (parent(i) == 0) then
            new(i) = end_of_roots
            end_of_roots = end_of_roots - below(i)
         else
            new(i) = last(parent(i))
            last(parent(i)) = last(parent(i)) - below(i)
         end if
         last(i) = new(i) - 1
      end do
      do i = 1, size(parent)
         sorted(new(i)) = 0
         if (parent(i) > 0) sorted(new(i)) = new(parent(i))
      end do
      parent = sorted
      place = new(place)
   end subroutine sort_tree

   !> How many later places each one reaches when those before it are eliminated.
   subroutine count_reach(graph, place, parent, reach)
      type(graph_t), intent(in) :: graph
      integer, intent(in) :: place(:), parent(:)
      integer, allocatable, intent(out) :: reach(:)
      integer, allocatable :: pool(:), found(:)
      integer, dimension(graph%vertices) :: vertex_at, seen, begins, waiting
      integer :: i, k, child, children, count, top, other

      ! What the children reach stands on top of a pile, in the order in which they come
      vertex_at(place) = [(i, i=1, graph%vertices)]
      allocate (reach(graph%vertices), found(graph%vertices), pool(8*graph%vertices))
      seen = 0
      top = 0
      children = 0
      do i = 1, graph%vertices
         count = 0
         seen(i) = i
         child = children
         do while (child > 0)
            if (parent(waiting(child)) /= i) exit
            do k = begins(child) + 1, begins(child) + reach(waiting(child))
               call note(pool(k))
            end do
            child = child - 1
         end do
         do k = graph%first(vertex_at(i)), graph%first(vertex_at(i) + 1) - 1
            other = place(graph%neighbour(k))
            if (other > i) call note(other)
         end do
         if (child < children) top = begins(child + 1)
         children = child + 1
         waiting(children) = i
         begins(children) = top
         reach(i) = count
         if (top + count > size(pool)) pool = [pool(:top), spread(0, 1, max(size(pool), count))]
         pool(top + 1:top + count) = found(:count)
         top = top + count
      end do

   contains

      subroutine note(at)
         integer, intent(in) :: at

         if (seen(at) == i) return
         seen(at) = i
         count = count + 1
         found(count) = at
      end subroutine note

   end subroutine count_reach

   !> Join places to fronts, and fronts that are small.
   pure subroutine make_fronts(graph, place, parent, reach, front, front_parent)
      type(graph_t), intent(in) :: graph
      integer, intent(in) :: place(:), parent(:), reach(:)
      !> Front of each place, and parent of each front; fronts are numbered by a place in them, others have parent -1
      integer, allocatable, intent(out) :: front(:), front_parent(:)
      integer, dimension(graph%vertices) :: vertex_at, pivots, border, zeros, next, child
      integer :: i, f, above, more

      vertex_at(place) = [(i, i=1, graph%vertices)]
      allocate (front(graph%vertices), front_parent(graph%vertices))
      front_parent = -1
      ! A front bears the number of its last place
      do i = graph%vertices, 1, -1
         front(i) = i
         if (parent(i) == i + 1) then
            if (reach(i) == reach(i + 1) + 1) front(i) = front(i + 1)
         end if
      end do
      pivots = 0
      border = 0
      do i = 1, graph%vertices
         pivots(front(i)) = pivots(front(i)) + graph%unknowns(vertex_at(i))
         if (front(i) /= i) cycle
         front_parent(i) = 0
         if (parent(i) > 0) front_parent(i) = front(parent(i))
      end do
      ! Unknowns that a front reaches: two for each vertex, or nearly so
      where (front_parent >= 0) border = nint(real(reach, wp)*real(sum(graph%unknowns), wp)/real(graph%vertices, wp))
      zeros = 0
      child = 0
      do i = graph%vertices, 1, -1
         if (front_parent(i) <= 0) cycle
         next(i) = child(front_parent(i))
         child(front_parent(i)) = i
      end do
      do f = 1, graph%vertices
         if (front_parent(f) < 0) cycle
         i = child(f)
         do while (i > 0)
            more = zeros(i) + zeros(f) + pivots(i)*max(0, pivots(f) + border(f) - border(i))
            if (may_join(pivots(i) + pivots(f), border(f), more)) then
               pivots(f) = pivots(f) + pivots(i)
               zeros(f) = more
               front_parent(i) = -1
               front(i) = f
            end if
            i = next(i)
         end do
      end do
      do i = graph%vertices, 1, -1
         if (front(i) /= i) front(i) = front(front(i))
      end do
      do i = 1, graph%vertices
         if (front_parent(i) <= 0) cycle
         above = front(front_parent(i))
         front_parent(i) = above
      end do
   end subroutine make_fronts

   !> May a front be as large as that, with so many zeros?
   pure logical function may_join(pivots, border, zeros)
      integer, intent(in) :: pivots, border, zeros
      real(wp) :: share

      share = real(zeros, wp)/(0.5_wp*real(pivots, wp)*real(pivots + 1, wp) + real(pivots, wp)*real(border, wp))
      may_join = share <= zeros_always .or. any(pivots <= few_pivots .and. share <= zeros_then)
   end function may_join

   !> Number the fronts so that all below one come right before it, and their places.
   subroutine number_fronts(graph, place, front, front_parent, plan)
      type(graph_t), intent(in) :: graph
      !> Place of each vertex, in the new order on return
      integer, intent(inout) :: place(:)
      integer, intent(in) :: front(:), front_parent(:)
      type(elimination_t), intent(inout) :: plan
      integer, allocatable :: number(:), of_front(:), first(:), item(:)
      integer :: new(graph%vertices), i

      allocate (number(size(front)), source=0)
      of_front = pack([(i, i=1, size(front))], front_parent >= 0)
      number(of_front) = [(i, i=1, size(of_front))]
      plan%parent = front_parent(of_front)
      where (plan%parent > 0) plan%parent = number(max(1, plan%parent))
      of_front = [(i, i=1, size(of_front))]
      call sort_tree(plan%parent, of_front)
      ! Places of a front in the order in which they were
      call fill_rows(of_front(number(front)), size(of_front), first, item)
      new(item) = [(i, i=1, graph%vertices)]
      place = new(place)
      plan%first = first
   end subroutine number_fronts

   !> Later vertices that the fronts reach.
   subroutine find_borders(graph, place, plan)
      type(graph_t), intent(in) :: graph
      integer, intent(in) :: place(:)
      type(elimination_t), intent(inout) :: plan
      integer, allocatable :: found(:), child_first(:), child(:)
      integer, dimension(graph%vertices) :: vertex_at, seen
      integer :: f, i, k, count, total

      vertex_at(place) = [(i, i=1, graph%vertices)]
      call fill_rows(plan%parent, size(plan%parent), child_first, child)
      allocate (plan%border_first(size(plan%parent) + 1), plan%border(8*graph%vertices), found(graph%vertices))
      seen = 0
      total = 0
      do f = 1, size(plan%parent)
         plan%border_first(f) = total + 1
         count = 0
         do k = child_first(f), child_first(f + 1) - 1
            do i = plan%border_first(child(k)), plan%border_first(child(k) + 1) - 1
               call note(plan%border(i))
            end do
         end do
         do i = plan%first(f), plan%first(f + 1) - 1
            do k = graph%first(vertex_at(i)), graph%first(vertex_at(i) + 1) - 1
               call note(place(graph%neighbour(k)))
            end do
         end do
         call sort(found(:count))
         if (total + count > size(plan%border)) plan%border = [plan%border(:total), spread(0, 1, max(size(plan%border), count))]
         plan%border(total + 1:total + count) = found(:count)
         total = total + count
         plan%border_first(f + 1) = total + 1
      end do
      plan%border = plan%border(:total)

   contains

      subroutine note(at)
         integer, intent(in) :: at

         if (at < plan%first(f + 1) .or. seen(at) == f) return
         seen(at) = f
         count = count + 1
         found(count) = at
      end subroutine note

   end subroutine find_borders

   !> Sort a list (Shell 1959, gaps of Ciura 2001).
   pure subroutine sort(list)
      integer, intent(inout) :: list(:)
      integer, parameter :: gaps(9) = [1750, 701, 301, 132, 57, 23, 10, 4, 1]
      integer :: g, i, k, value

      do g = 1, size(gaps)
         do i = gaps(g) + 1, size(list)
            value = list(i)
            k = i - gaps(g)
            do while (k >= 1)
               if (list(k) <= value) exit
               list(k + gaps(g)) = list(k)
               k = k - gaps(g)
            end do
            list(k + gaps(g)) = value
         end do
      end do
   end subroutine sort

   !> From vertices to unknowns.
   subroutine expand(graph, vertex, place, plan)
      type(graph_t), intent(in) :: graph
      integer, intent(in) :: vertex(:), place(:)
      type(elimination_t), intent(inout) :: plan
      integer, allocatable :: border(:), border_first(:)
      integer :: begins(graph%vertices + 1), used(graph%vertices), f, i, k, total

      ! Places of the unknowns of the vertex at place i: begins(i) to begins(i + 1) - 1
      begins = 0
      begins(place + 1) = graph%unknowns
      begins(1) = 1
      do i = 1, graph%vertices
         begins(i + 1) = begins(i) + begins(i + 1)
      end do
      allocate (plan%place(size(vertex)))
      used = 0
      do i = 1, size(vertex)
         plan%place(i) = begins(place(vertex(i))) + used(vertex(i))
         used(vertex(i)) = used(vertex(i)) + 1
      end do
      allocate (border(sum(begins(plan%border + 1) - begins(plan%border))), border_first(size(plan%border_first)))
      total = 0
      do f = 1, size(plan%parent)
         border_first(f) = total + 1
         do k = plan%border_first(f), plan%border_first(f + 1) - 1
            do i = begins(plan%border(k)), begins(plan%border(k) + 1) - 1
               total = total + 1
               border(total) = i
            end do
         end do
      end do
      border_first(size(border_first)) = total + 1
      call move_alloc(border, plan%border)
      call move_alloc(border_first, plan%border_first)
      plan%first = begins(plan%first)
   end subroutine expand

end module elimination_m
