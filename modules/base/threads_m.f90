!> Number of threads that the kernels run on.
module threads_m
   use, intrinsic :: iso_c_binding, only: c_char, c_f_procpointer, c_funptr, c_associated, c_int, c_null_char, c_null_ptr, c_ptr
   use omp_lib, only: omp_set_num_threads
   implicit none
   private

   public :: use_threads

   interface
      !> Address of a procedure of the libraries that are loaded (POSIX; handle null: any of them)
      function dlsym(handle, name) bind(c, name='dlsym') result(address)
         import :: c_char, c_funptr, c_ptr
         implicit none
         type(c_ptr), value :: handle
         character(kind=c_char), intent(in) :: name(*)
         type(c_funptr) :: address
      end function dlsym
   end interface

   abstract interface
      subroutine set_number(threads) bind(c)
         import :: c_int
         implicit none
         integer(c_int), value :: threads
      end subroutine set_number
   end interface

contains

   !> Take as many threads as the deck says; without that what OMP_NUM_THREADS says, or one.
   subroutine use_threads(asked)
      !> 0: the deck says nothing
      integer, intent(in) :: asked

      if (asked > 0) then
         call omp_set_num_threads(asked)
      else if (.not. is_set('OMP_NUM_THREADS')) then
         call omp_set_num_threads(1)
      end if
      if (.not. is_set('OPENBLAS_NUM_THREADS')) call calm_openblas()
   end subroutine use_threads

   !> Is there such a variable in the environment?
   logical function is_set(variable)
      character(len=*), intent(in) :: variable
      integer :: length

      call get_environment_variable(variable, length=length)
      is_set = length > 0
   end function is_set

   !> One thread for OpenBLAS, where that is the BLAS: its threads wait for each other with their cores busy, and our own threads
   !> call it side by side.
   subroutine calm_openblas()
      type(c_funptr) :: address
      procedure(set_number), pointer :: set_threads

      address = dlsym(c_null_ptr, 'openblas_set_num_threads'//c_null_char)
      if (.not. c_associated(address)) return
      call c_f_procpointer(address, set_threads)
      call set_threads(1_c_int)
   end subroutine calm_openblas

end module threads_m
