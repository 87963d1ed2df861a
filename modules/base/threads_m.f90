!> Number of threads that the kernels run on.
module threads_m
   use omp_lib, only: omp_set_num_threads
   implicit none
   private

   public :: use_threads

contains

   !> Take as many threads as the deck says; without that what OMP_NUM_THREADS says, or one.
   subroutine use_threads(asked)
      !> 0: the deck says nothing
      integer, intent(in) :: asked
      integer :: length

      if (asked > 0) then
         call omp_set_num_threads(asked)
         return
      end if
      call get_environment_variable('OMP_NUM_THREADS', length=length)
      if (length == 0) call omp_set_num_threads(1)
   end subroutine use_threads

end module threads_m
