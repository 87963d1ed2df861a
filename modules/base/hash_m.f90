!> Hashes by which a change is noticed: fingerprints, not secrets.
module hash_m
   use kinds_m, only: i8
   implicit none
   private

   public :: text_hash, numbers_hash

   !> Two primes below 2**31
   integer(i8), parameter :: prime(2) = [2147483647_i8, 2147483629_i8]

contains

   !> Hash of a text by which a change is noticed (a fingerprint, not a seal).
   pure function text_hash(text) result(hash)
      character(len=*), intent(in) :: text
      !> Sixteen hexadecimal digits
      character(len=16) :: hash
      !> Above the number of characters: products stay far below 2**63
      integer(i8), parameter :: base = 257_i8
      integer(i8) :: sum(2)
      integer :: i

      sum = 0_i8
      do i = 1, len(text)
         sum = mod(sum*base + int(ichar(text(i:i)), i8) + 1_i8, prime)
      end do
      write (hash, '(2z8.8)') sum
   end function text_hash

   !> The same of numbers, or of the bits of reals. One number that differs always shows: no difference of two is a multiple of
   !> both primes.
   pure function numbers_hash(number) result(hash)
      integer, intent(in) :: number(:)
      character(len=16) :: hash
      integer(i8), parameter :: base = 65599_i8
      integer(i8) :: sum(2)
      integer :: i

      sum = 0_i8
      do i = 1, size(number)
         ! Below 2**47 times a base below 2**17: no overflow
         sum = mod(sum*base + int(number(i), i8) + 2147483649_i8, prime)
      end do
      write (hash, '(2z8.8)') sum
   end function numbers_hash

end module hash_m
