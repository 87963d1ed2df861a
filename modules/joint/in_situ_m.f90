!> Joints under in-situ stress: before anything has moved they are closed by the normal stress of the rock around them, and have
!> slipped as far as its shear stress takes them.
!>
!> Displacements count from that state. What a joint had closed and slipped in it is added to what its walls do later, so that its
!> law sees one way from the unstressed joint on.
module in_situ_m
   use kinds_m, only: wp
   use joint_point_m, only: joint_point_t
   use joint_law_m, only: joint_law_t
   implicit none
   private

   public :: resolve, close_joint

   !> Slip is found to this part of itself; halvings that are more than enough for it
   real(wp), parameter :: close_enough = 4.0_wp*epsilon(1.0_wp)
   integer, parameter :: most_halvings = 200

contains

   !> Normal stress, compression positive, and shear stress of the rock along a joint, with the sign of the slip that it
   !> drives [Pa].
   pure subroutine resolve(stress, along, sn, tau)
      !> sxx, syy, sxy, tension positive [Pa]; from A to B of the joint (2) [m]
      real(wp), intent(in) :: stress(3), along(2)
      real(wp), intent(out) :: sn, tau
      real(wp) :: i(2), j(2), traction(2)

      i = along/norm2(along)
      j = [-i(2), i(1)]
      traction = [stress(1)*j(1) + stress(3)*j(2), stress(3)*j(1) + stress(2)*j(2)]
      sn = -dot_product(traction, j)
      tau = dot_product(traction, i)
   end subroutine resolve

   !> Bring a joint that has never been loaded to a normal and a shear stress: closed first, then sheared. A joint that is weaker
   !> than the shear stress ends at its strength.
   pure subroutine close_joint(law, penalty, coupled, sn, tau, point, closed, slipped, too_weak)
      class(joint_law_t), intent(in) :: law
      !> Penalty stiffness of the walls; 0: the law's own [MPa/mm]
      real(wp), intent(in) :: penalty
      !> Does dilation push the walls?
      logical, intent(in) :: coupled
      !> Normal stress, compression positive, and shear stress [MPa]
      real(wp), intent(in) :: sn, tau
      type(joint_point_t), intent(out) :: point
      !> Overlap of the walls and slip that make these stresses [mm]
      real(wp), intent(out) :: closed, slipped
      logical, intent(out) :: too_weak

      closed = 0.0_wp
      slipped = 0.0_wp
      too_weak = sn <= 0.0_wp .and. abs(tau) > 0.0_wp
      if (sn <= 0.0_wp) return
      call law%update(0.0_wp, sn, point)
      if (abs(tau) > 0.0_wp) then
         call find_slip(law, point, sn, tau, slipped, too_weak)
         call law%update(slipped, sn, point)
      end if
      if (penalty > 0.0_wp) then
         closed = sn/penalty
      else
         closed = law%closure(point, sn)
      end if
      if (coupled) closed = closed - point%dilation
   end subroutine close_joint

   !> Slip of a closed joint that makes a shear stress, by halving: the stress grows with it up to the peak.
   pure subroutine find_slip(law, point, sn, tau, slip, too_weak)
      class(joint_law_t), intent(in) :: law
      type(joint_point_t), intent(in) :: point
      !> [MPa]
      real(wp), intent(in) :: sn, tau
      !> [mm]
      real(wp), intent(out) :: slip
      logical, intent(out) :: too_weak
      real(wp) :: least, most
      integer :: k

      most = law%slip_of_peak(sn)
      if (most <= 0.0_wp) most = abs(tau)/law%shear_stiffness(point, sn)
      slip = sign(most, tau)
      too_weak = stress_of(most) < abs(tau)*(1.0_wp - close_enough)
      if (too_weak) return
      least = 0.0_wp
      do k = 1, most_halvings
         if (most - least <= close_enough*most) exit
         slip = 0.5_wp*(least + most)
         if (stress_of(slip) < abs(tau)) then
            least = slip
         else
            most = slip
         end if
      end do
      slip = sign(most, tau)

   contains

      pure real(wp) function stress_of(size_of_slip)
         real(wp), intent(in) :: size_of_slip
         type(joint_point_t) :: trial

         trial = point
         call law%update(size_of_slip, sn, trial)
         stress_of = trial%tau
      end function stress_of

   end subroutine find_slip

end module in_situ_m
