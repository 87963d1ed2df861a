!> Acoustic emission of a crack: the moment tensor of its displacement jump and its magnitude.
!>
!> A crack of length L (and of unit thickness) whose walls have parted by D, n the normal from the lower to the upper wall, has the
!> moment tensor of its displacement jump (Aki and Richards 2002, eq 3.21)
!>
!>     M = L (lambda D.n I + mu (D n + n D)),
!>
!> in plane strain lambda D.n L out of the plane. Its size is M0 = sqrt(sum of the squared principal moments/2) (Silver and Jordan
!> 1982), as Hazzard and Young (2004) take it for particles; its magnitude that of Hanks and Kanamori (1979), for a crack as wide as
!> it is long.
module emission_m
   use kinds_m, only: wp
   implicit none
   private

   public :: crack_moment, crack_magnitude

contains

   !> Moments xx, yy, xy, zz of a crack, opening positive [N m per m of thickness].
   pure function crack_moment(length, normal, jump, lambda, mu) result(moment)
      !> [m]; unit normal (2); displacement of the wall that it points to less that of the other (2) [m]
      real(wp), intent(in) :: length, normal(2), jump(2)
      !> Lame constants [Pa]
      real(wp), intent(in) :: lambda, mu
      real(wp) :: moment(4), volume

      volume = lambda*dot_product(jump, normal)
      moment = length*[volume + 2.0_wp*mu*jump(1)*normal(1), volume + 2.0_wp*mu*jump(2)*normal(2), &
                       mu*(jump(1)*normal(2) + jump(2)*normal(1)), volume]
   end function crack_moment

   !> Moment magnitude of a crack that is as wide as long: 2/3 (log10 M0 - 9.1), M0 in N m; that of 1 N mm where nothing has moved.
   pure real(wp) function crack_magnitude(length, moment) result(magnitude)
      !> [m]; moments xx, yy, xy, zz [N m per m of thickness]
      real(wp), intent(in) :: length, moment(4)
      real(wp), parameter :: least = 1.0e-3_wp
      real(wp) :: scalar

      scalar = length*sqrt(0.5_wp*(moment(1)**2 + moment(2)**2 + 2.0_wp*moment(3)**2 + moment(4)**2))
      magnitude = 2.0_wp/3.0_wp*(log10(max(scalar, least)) - 9.1_wp)
   end function crack_magnitude

end module emission_m
