!> Leaving the program with an exit status and no noise (STOP would print the status).
module exit_m
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
   implicit none
   private

   public :: exit_with

   interface
      subroutine c_exit(status) bind(c, name='exit')
         import :: c_int
         !> Exit status
         integer(c_int), value :: status
      end subroutine c_exit
   end interface

contains

   !> End the program; only the program itself may.
   subroutine exit_with(status)
      !> Exit status
      integer, intent(in) :: status
      integer :: ignored

      flush (output_unit, iostat=ignored)
      flush (error_unit, iostat=ignored)
      call c_exit(int(status, c_int))
   end subroutine exit_with

end module exit_m
