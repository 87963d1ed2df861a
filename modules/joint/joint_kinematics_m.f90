!> Opening and shear of a four-noded joint element, eqs 27-30, at finite rotation.
module joint_kinematics_m
   use kinds_m, only: wp
   implicit none
   private

   public :: joint_kinematics

   !> Where the two walls of a joint element stand
   type, public :: joint_frame_t
      !> Opening w, positive when the walls part; shear u, positive when the upper wall moves along i [m]
      real(wp) :: opening = 0.0_wp, shear = 0.0_wp
      !> Length of the median line [m]
      real(wp) :: length = 0.0_wp
      !> Unit vectors i along the median line and j, i turned by +90 degrees (2)
      real(wp) :: i(2) = 0.0_wp, j(2) = 0.0_wp
   end type joint_frame_t

contains

   !> Opening and shear from the four nodes A, B, A', B'.
   !>
   !>       A'----C'--->B'      w = CC'.j, u = CC'.i; i runs from (A+A')/2 to (B+B')/2
   !>     j ^  :                The walls coincide before any motion, so that CC' follows from the displacements
   !>       |  A----C---->B     alone: no small difference of large coordinates.
   !>       +--> i
   pure function joint_kinematics(x, u) result(frame)
      !> Coordinates of A, B, A', B' before any motion (2, 4) [m]
      real(wp), intent(in) :: x(2, 4)
      !> Their displacements (2, 4) [m]
      real(wp), intent(in) :: u(2, 4)
      type(joint_frame_t) :: frame
      real(wp) :: median(2), gap(2)

      gap = 0.5_wp*((u(:, 3) - u(:, 1)) + (u(:, 4) - u(:, 2)))                                                ! (27)
      median = 0.5_wp*((x(:, 2) - x(:, 1)) + (x(:, 4) - x(:, 3)) + (u(:, 2) - u(:, 1)) + (u(:, 4) - u(:, 3)))  ! (28)
      frame%length = norm2(median)
      if (frame%length > 0.0_wp) then
         frame%i = median/frame%length                                                                        ! (29)
      else
         frame%i = [1.0_wp, 0.0_wp]
      end if
      frame%j = [-frame%i(2), frame%i(1)]                                                                     ! (29)
      frame%opening = dot_product(gap, frame%j)                                                               ! (30)
      frame%shear = dot_product(gap, frame%i)                                                                 ! (30)
   end function joint_kinematics

end module joint_kinematics_m
