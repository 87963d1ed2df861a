!> Anderson acceleration: iterations with a matrix that is not quite right, made to converge like a Krylov method.
!>
!> The corrections d = M^-1 r of the last iterations span what the matrix M misses: the step is the combination of past
!> steps whose predicted correction is least (Anderson 1965; Walker and Ni 2011, type II).
module anderson_m
   use kinds_m, only: wp
   implicit none
   private

   !> Past iterations that are looked at
   integer, parameter :: depth = 6
   !> A past change of the correction counts when this share of it is not spanned by later ones
   real(wp), parameter :: independent = 1.0e-6_wp

   type, public :: anderson_t
      private
      !> Number of past iterations kept; the newest is the first
      integer :: kept = 0
      !> Steps taken, and the changes of the correction over them (unknowns, depth)
      real(wp), allocatable :: step(:, :), change(:, :)
      !> Correction of the last iteration (unknowns), and whether its step was taken
      real(wp), allocatable :: correction(:)
      logical :: taken = .false.
   contains
      procedure :: forget
      procedure :: next_step
      procedure :: took
   end type anderson_t

contains

   !> Forget all past iterations: another matrix, another increment.
   pure subroutine forget(self, n)
      class(anderson_t), intent(inout) :: self
      !> Number of unknowns
      integer, intent(in) :: n

      self%kept = 0
      self%taken = .false.
      if (allocated(self%correction)) then
         if (size(self%correction) == n) return
         deallocate (self%step, self%change, self%correction)
      end if
      allocate (self%step(n, depth), self%change(n, depth), self%correction(n))
   end subroutine forget

   !> Step from the correction d = M^-1 r of the present iteration.
   pure subroutine next_step(self, correction, step)
      class(anderson_t), intent(inout) :: self
      !> Correction (unknowns)
      real(wp), intent(in) :: correction(:)
      !> Step to take (unknowns)
      real(wp), intent(out) :: step(:)
      real(wp) :: rest(size(correction), depth), share(depth, depth), part(depth), weight(depth), length
      integer :: i, k
      logical :: counts(depth)

      if (self%taken) self%change(:, 1) = correction - self%correction
      self%correction = correction
      self%taken = .false.
      step = correction
      ! Gram-Schmidt, the newest first
      counts = .false.
      do i = 1, self%kept
         rest(:, i) = self%change(:, i)
         length = norm2(rest(:, i))
         do k = 1, i - 1
            if (.not. counts(k)) cycle
            share(k, i) = dot_product(rest(:, k), rest(:, i))
            rest(:, i) = rest(:, i) - share(k, i)*rest(:, k)
         end do
         share(i, i) = norm2(rest(:, i))
         counts(i) = share(i, i) > independent*length
         if (counts(i)) rest(:, i) = rest(:, i)/share(i, i)
         if (counts(i)) part(i) = dot_product(rest(:, i), correction)
      end do
      weight = 0.0_wp
      do i = self%kept, 1, -1
         if (.not. counts(i)) cycle
         weight(i) = part(i)
         do k = i + 1, self%kept
            if (counts(k)) weight(i) = weight(i) - share(i, k)*weight(k)
         end do
         weight(i) = weight(i)/share(i, i)
         step = step - weight(i)*(self%step(:, i) + self%change(:, i))
      end do
   end subroutine next_step

   !> Remember the step that was taken in the end.
   pure subroutine took(self, step)
      class(anderson_t), intent(inout) :: self
      real(wp), intent(in) :: step(:)
      integer :: i

      self%kept = min(self%kept + 1, depth)
      do i = self%kept, 2, -1
         self%step(:, i) = self%step(:, i - 1)
         self%change(:, i) = self%change(:, i - 1)
      end do
      self%step(:, 1) = step
      self%taken = .true.
   end subroutine took

end module anderson_m
