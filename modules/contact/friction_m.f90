!> Coulomb friction of one contact: a spring in series with a slider, which holds exactly, and the velocity law of the
!> paper, which has no stick. Both know only numbers of one contact, nothing of meshes.
module friction_m
   use kinds_m, only: wp
   implicit none
   private

   public :: slide, velocity_friction

   !> Friction laws
   integer, parameter, public :: friction_slider = 1, friction_velocity = 2

contains

   !> Spring-slider: stretch the spring by the step's slip; the slider gives way where the force passes the bound.
   pure subroutine slide(stiffness, bound, increment, elongation, force, stored, dissipated)
      !> Tangential stiffness kt (> 0) [N/m]
      real(wp), intent(in) :: stiffness
      !> Strength mu fn, taken as 0 when negative [N]
      real(wp), intent(in) :: bound
      !> Slip of this step [m]
      real(wp), intent(in) :: increment
      !> Elongation of the spring, carried from step to step [m]
      real(wp), intent(inout) :: elongation
      !> Friction force, which resists slip in the positive direction [N]
      real(wp), intent(out) :: force
      !> Change of the energy in the spring [J]
      real(wp), intent(out) :: stored
      !> Energy spent by the slider; with stored it makes up the work of the mean force of the step on the slip [J]
      real(wp), intent(out) :: dissipated
      real(wp) :: trial, limit, before, mean_force

      before = elongation
      trial = before + increment
      limit = max(bound, 0.0_wp)/stiffness
      elongation = max(-limit, min(limit, trial))
      force = stiffness*elongation
      mean_force = 0.5_wp*stiffness*(before + elongation)
      stored = mean_force*(elongation - before)
      dissipated = mean_force*(trial - elongation)
   end subroutine slide

   !> The paper's law (eq 4): the full strength against the slip velocity, none at rest, where its direction is 0/0.
   pure real(wp) function velocity_friction(bound, velocity) result(force)
      !> Strength mu fn, taken as 0 when negative [N]
      real(wp), intent(in) :: bound
      !> Slip velocity [m/s]
      real(wp), intent(in) :: velocity

      force = 0.0_wp
      ! Equation 4: f_t = mu |f_n| v_r/|v_r|; in the plane v_r/|v_r| is a sign, so no small number is needed
      if (velocity > 0.0_wp) force = max(bound, 0.0_wp)
      if (velocity < 0.0_wp) force = -max(bound, 0.0_wp)
   end function velocity_friction

end module friction_m
