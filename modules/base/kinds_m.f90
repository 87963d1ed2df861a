!> Kinds used by every module.
module kinds_m
   use, intrinsic :: iso_fortran_env, only: real64, int32, int64
   implicit none
   private

   !> Working precision
   integer, parameter, public :: wp = real64
   !> Default and long integers
   integer, parameter, public :: i4 = int32, i8 = int64

end module kinds_m
