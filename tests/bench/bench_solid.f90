!> Triangles a second of processor time that solid_forces works through, on one thread. Not a test: nothing is asserted.
!> Writes bench_solid.csv (triangles, triangle_steps_per_second) and the same as a table.
program bench_solid
   use kinds_m, only: wp
   use solid_m, only: solid_t, init_solid
   use solid_forces_m, only: solid_forces
   implicit none

   !> Triangles of the grids: powers of ten
   integer, parameter :: least_power = 3, most_power = 6
   !> Triangle-steps of one measurement, and measurements of which the best counts
   integer, parameter :: work = 20000000, repeats = 5
   real(wp), parameter :: million = 1.0e6_wp
   integer :: power, unit, cells
   real(wp) :: rate

   open (newunit=unit, file='bench_solid.csv', action='write', status='replace')
   write (unit, '(a)') 'triangles,triangle_steps_per_second'
   print '(a)', 'triangles   million triangle-steps a second'
   do power = least_power, most_power
      cells = nint(sqrt(0.5_wp*10.0_wp**power))
      rate = best_rate(cells)
      write (unit, '(i0, a, es12.5)') 2*cells**2, ',', rate
      print '(i9, f12.1)', 2*cells**2, rate/million
   end do
   close (unit)

contains

   !> Triangle-steps a second on a square of cells*cells squares of two triangles.
   real(wp) function best_rate(cells) result(rate)
      integer, intent(in) :: cells
      type(solid_t) :: solid
      real(wp), allocatable :: x(:, :), u(:, :), force(:, :), material(:)
      integer, allocatable :: triangle(:, :)
      real(wp) :: start, finish
      integer :: round, rounds, repeat

      call square(cells, x, triangle)
      allocate (material(size(triangle, 2)), source=1.0e9_wp)
      call init_solid(x, triangle, material, material, 0.25e-9_wp*material, solid)
      u = 1.0e-4_wp*sin(x)
      allocate (force(2, size(x, 2)), source=0.0_wp)
      rounds = max(1, work/size(triangle, 2))
      rate = 0.0_wp
      do repeat = 1, repeats
         call cpu_time(start)
         do round = 1, rounds
            call solid_forces(solid, u, force)
         end do
         call cpu_time(finish)
         rate = max(rate, real(rounds, wp)*real(size(triangle, 2), wp)/(finish - start))
      end do
      ! The result is needed, so that the work is not optimised away
      if (.not. all(abs(force) < huge(1.0_wp))) rate = 0.0_wp
   end function best_rate

   !> Unit squares with one diagonal each, nodes numbered row by row.
   subroutine square(cells, x, triangle)
      integer, intent(in) :: cells
      real(wp), allocatable, intent(out) :: x(:, :)
      integer, allocatable, intent(out) :: triangle(:, :)
      integer :: i, j, node, e

      allocate (x(2, (cells + 1)**2), triangle(3, 2*cells**2))
      e = 0
      do j = 0, cells
         do i = 0, cells
            node = j*(cells + 1) + i + 1
            x(:, node) = real([i, j], wp)
            if (i == cells .or. j == cells) cycle
            triangle(:, e + 1) = [node, node + 1, node + cells + 2]
            triangle(:, e + 2) = [node, node + cells + 2, node + cells + 1]
            e = e + 2
         end do
      end do
   end subroutine square

end program bench_solid
