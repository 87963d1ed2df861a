!> Processor time of the contact search against the number of segments. Writes a table to the screen and bench_nbs.csv.
!> Two scenes: segments of one size, and segments whose size spreads over a factor of 100; both have as many
!> neighbours a segment whatever their number.
program bench_nbs
   use, intrinsic :: iso_fortran_env, only: output_unit
   use kinds_m, only: wp
   use nbs_m, only: find_box_pairs
   implicit none

   integer, parameter :: counts(4) = [1000, 10000, 100000, 1000000]
   real(wp), parameter :: gradings(2) = [1.0_wp, 100.0_wp]
   !> Work of each measurement: at least this many boxes are searched
   integer, parameter :: least_work = 1000000
   !> Skin around each segment, of its length
   real(wp), parameter :: skin = 0.1_wp
   character(len=*), parameter :: path = 'bench_nbs.csv'
   real(wp), allocatable :: box(:, :)
   integer, allocatable :: pair(:, :)
   real(wp) :: start, finish, nanoseconds
   integer :: unit, i, k, repeat, repeats

   open (newunit=unit, file=path, action='write', status='replace')
   write (unit, '(a)') 'size_ratio,segments,pairs,time_per_segment_ns'
   write (output_unit, '(a)') ' size ratio   segments      pairs   ns a segment'
   do k = 1, size(gradings)
      do i = 1, size(counts)
         box = segments(counts(i), gradings(k))
         repeats = max(1, least_work/counts(i))
         call cpu_time(start)
         do repeat = 1, repeats
            call find_box_pairs(box, pair)
         end do
         call cpu_time(finish)
         nanoseconds = 1.0e9_wp*(finish - start)/real(repeats, wp)/real(counts(i), wp)
         write (output_unit, '(f11.0, 2i11, f15.1)') gradings(k), counts(i), size(pair, 2), nanoseconds
         write (unit, '(f0.0, 2(",", i0), ",", f0.1)') gradings(k), counts(i), size(pair, 2), nanoseconds
      end do
   end do
   close (unit)

contains

   !> Boxes (4, n) of random segments; the longest is 1, sizes spread evenly over their logarithm, and the square they
   !> lie in grows with their summed area so that the density stays the same.
   function segments(n, grading) result(box)
      integer, intent(in) :: n
      real(wp), intent(in) :: grading
      real(wp), allocatable :: box(:, :)
      real(wp), allocatable :: draw(:, :)
      real(wp) :: width, length, half(2)
      integer :: j

      allocate (box(4, n), draw(4, n))
      call random_number(draw)
      width = sqrt(sum(grading**(-2.0_wp*draw(3, :))))
      do j = 1, n
         length = grading**(-draw(3, j))
         half = 0.5_wp*length*[abs(cos(4.0_wp*draw(4, j))) + skin, abs(sin(4.0_wp*draw(4, j))) + skin]
         box(1:2, j) = width*draw(1, j) + half(1)*[-1.0_wp, 1.0_wp]
         box(3:4, j) = width*draw(2, j) + half(2)*[-1.0_wp, 1.0_wp]
      end do
   end function segments

end program bench_nbs
