!> Solutions for a matrix by the factors of an older one: generalised conjugate residuals (Eisenstat, Elman and Schultz 1983).
!>
!> Where some walls and bonds have changed their stiffness since the matrix was factored, the old factors and the new matrix
!> differ by little, or by much in few places: a step of the iteration for each of these gives the solution, to the tolerance
!> asked for, for the price of a solution with the factors and a product with the matrix. What the steps so far have left tells
!> how many it will take: where these are too many it is given up (a single stiff change, that two steps would mend, too).
module lagged_m
   use kinds_m, only: wp
   use sparse_system_m, only: sparse_system_t, multiply
   use sparse_lu_m, only: sparse_lu_t, linear_ok
   implicit none
   private

   public :: solve_lagged

contains

   !> Solve K x = b to |b - K x| <= tolerance |b| with the factors at hand.
   subroutine solve_lagged(system, lu, b, tolerance, most, x, steps, found)
      !> K; the older matrix has its pattern
      type(sparse_system_t), intent(in) :: system
      !> Factors of the older matrix
      type(sparse_lu_t), intent(inout) :: lu
      !> Right-hand side (unknowns) [N per m of thickness]
      real(wp), intent(in) :: b(:)
      real(wp), intent(in) :: tolerance
      !> Steps at the most
      integer, intent(in) :: most
      !> Solution (unknowns) [m]
      real(wp), intent(out) :: x(:)
      !> Steps taken
      integer, intent(out) :: steps
      !> Is the solution as good as that?
      logical, intent(out) :: found
      !> Directions, and what K makes of them, orthonormal
      real(wp) :: along(size(b), most), image(size(b), most)
      real(wp) :: rest(size(b)), share, least, length
      integer :: i, status

      x = 0.0_wp
      rest = b
      least = tolerance*norm2(b)
      found = .false.
      do steps = 1, most
         associate (z => along(:, steps), c => image(:, steps))
            z = rest
            call lu%solve(z, status)
            if (status /= linear_ok .or. .not. all(abs(z) < huge(1.0_wp))) return
            call multiply(system, z, c)
            do i = 1, steps - 1
               share = dot_product(image(:, i), c)
               c = c - share*image(:, i)
               z = z - share*along(:, i)
            end do
            length = norm2(c)
            if (length <= 0.0_wp) return
            c = c/length
            z = z/length
            share = dot_product(c, rest)
            x = x + share*z
            rest = rest - share*c
         end associate
         found = norm2(rest) <= least
         if (found .or. (norm2(rest)/norm2(b))**most > tolerance**steps) return
      end do
      steps = most
   end subroutine solve_lagged

end module lagged_m
