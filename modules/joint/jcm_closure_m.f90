!> Closure of a rough joint: eqs 5 to 7 and 11, the curves of the loading cycles (Bandis et al. 1983), and the path over them
!> when unloading and reloading follow other curves (hysteresis). Units: MPa, mm.
!>
!>     sn |      1    2        Loading follows the curve of the cycle. Unloading follows the stiffer of this and the next
!>        |     /   .'         cycle, through the turn, and leaves a part of the closure. Once the stress has fallen below half
!>        |   .' .'            of that of the turn, reloading follows the curve of the next cycle, through the point it starts
!>        |.-'__'____ v        from. The third cycle is the last: it goes up and down one curve.
module jcm_closure_m
   use kinds_m, only: wp
   implicit none
   private

   public :: initial_stiffness, maximum_closure, closure_stress, closure, normal_stiffness
   public :: path_stress, path_closure, path_stiffness, follow_path

   !> Loading cycles with a curve; that of eqs 6 and 7
   integer, parameter, public :: cycles = 3, last_cycle = cycles
   !> Maximum closure A + B JRC + C (JCS/a0)^D of each cycle; the third is eq 7 [mm]
   real(wp), parameter :: constant(cycles) = [-0.2960_wp, -0.1005_wp, -0.1032_wp]
   real(wp), parameter :: by_roughness(cycles) = [-0.0056_wp, -0.0073_wp, -0.0074_wp]
   real(wp), parameter :: by_strength(cycles) = [2.2410_wp, 1.0082_wp, 1.1350_wp]
   real(wp), parameter :: exponent(cycles) = [-0.2450_wp, -0.2301_wp, -0.2510_wp]

   !> Beyond this share of vm the closure curve continues along its tangent, so that no overlap means an infinite stress
   real(wp), parameter, public :: closure_limit = 0.99_wp
   !> A cycle is over when the stress has fallen below this share of that of its turn: what trembles goes through no cycles
   real(wp), parameter :: fallen = 0.5_wp
   !> Largest closure that the curve is continued to [mm]
   real(wp), parameter :: largest_closure = 1.0e9_wp

   !> Curves of a joint
   type, public :: closure_curves_t
      !> Initial stiffness [MPa/mm], maximum closure by each cycle [mm]
      real(wp) :: kn0 = 1.0_wp, vm(cycles) = 1.0_wp
   end type closure_curves_t

   !> Places in a law's memory: stress [MPa] and closure [mm] of the turn, cycles whose curve is followed above and below it (0: at
   !> rest, the first), and the lowest stress since a cycle was over [MPa]
   integer, parameter :: turn_stress = 1, turn_closure = 2, cycle_above = 3, cycle_below = 4, lowest = 5

contains

   !> Eq 6: initial normal stiffness, for all loading cycles [MPa/mm].
   pure real(wp) function initial_stiffness(jrc, jcs, a0)
      !> JRC [-], JCS [MPa], initial aperture [mm]
      real(wp), intent(in) :: jrc, jcs, a0

      initial_stiffness = -7.15_wp + 1.75_wp*jrc + 0.02_wp*jcs/a0                                   ! (6)
   end function initial_stiffness

   !> Eq 7: maximum closure, third loading cycle or the one given [mm].
   pure real(wp) function maximum_closure(jrc, jcs, a0, cycle)
      !> JRC [-], JCS [MPa], initial aperture [mm]
      real(wp), intent(in) :: jrc, jcs, a0
      !> Loading cycle
      integer, intent(in), optional :: cycle
      integer :: c

      c = last_cycle
      if (present(cycle)) c = cycle
      maximum_closure = constant(c) + by_roughness(c)*jrc + by_strength(c)*(jcs/a0)**exponent(c)    ! (7)
   end function maximum_closure

   !> Eq 5a: normal stress of a closure [MPa]; none when the walls are apart, along the tangent beyond closure_limit*vm.
   pure real(wp) function closure_stress(kn0, vm, v)
      !> Initial stiffness [MPa/mm], maximum closure [mm]
      real(wp), intent(in) :: kn0, vm
      !> Closure [mm]
      real(wp), intent(in) :: v
      real(wp) :: bounded

      bounded = between(0.0_wp, v, closure_limit*vm)
      closure_stress = kn0*bounded/(1.0_wp - bounded/vm)                                            ! (5a)
      if (v > bounded .and. v > 0.0_wp) then
         closure_stress = closure_stress + kn0/(1.0_wp - closure_limit)**2*(min(v, largest_closure) - bounded)
      end if
   end function closure_stress

   !> Eq 5b: closure under a normal stress [mm], the inverse of closure_stress; none when open.
   pure real(wp) function closure(kn0, vm, sn)
      !> Initial stiffness [MPa/mm], maximum closure [mm]
      real(wp), intent(in) :: kn0, vm
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      real(wp) :: bounded

      bounded = between(0.0_wp, sn, limit_stress(kn0, vm))
      closure = bounded*vm/(kn0*vm + bounded)                                                       ! (5b)
      if (sn > bounded .and. sn > 0.0_wp) closure = closure + (sn - bounded)/(kn0/(1.0_wp - closure_limit)**2)
   end function closure

   !> Eq 11: normal stiffness [MPa/mm].
   pure real(wp) function normal_stiffness(kn0, vm, sn)
      !> Initial stiffness [MPa/mm], maximum closure [mm]
      real(wp), intent(in) :: kn0, vm
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      real(wp) :: bounded

      bounded = between(0.0_wp, sn, limit_stress(kn0, vm))
      normal_stiffness = (bounded + kn0*vm)**2/(kn0*vm**2)                                          ! (11)
   end function normal_stiffness

   !> Normal stress at closure_limit*vm [MPa].
   pure real(wp) function limit_stress(kn0, vm)
      !> Initial stiffness [MPa/mm], maximum closure [mm]
      real(wp), intent(in) :: kn0, vm

      limit_stress = kn0*vm*closure_limit/(1.0_wp - closure_limit)
   end function limit_stress

   !> The value, or the bound it exceeds.
   elemental real(wp) function between(lowest, value, highest)
      real(wp), intent(in) :: lowest, value, highest

      between = max(lowest, min(value, highest))
   end function between

   ! ---- The path over the curves of the cycles ---------------------------------------------------------------------

   !> Normal stress of a closure on the path [MPa].
   pure real(wp) function path_stress(curves, memory, v)
      type(closure_curves_t), intent(in) :: curves
      !> What the joint remembers of its path
      real(wp), intent(in) :: memory(:)
      !> Closure [mm]
      real(wp), intent(in) :: v
      real(wp) :: vm

      vm = curves%vm(cycle_at(memory, v >= memory(turn_closure)))
      path_stress = closure_stress(curves%kn0, vm, v - memory(turn_closure) + closure(curves%kn0, vm, memory(turn_stress)))
   end function path_stress

   !> Closure under a normal stress on the path [mm], the inverse of path_stress; what has set when open.
   pure real(wp) function path_closure(curves, memory, sn)
      type(closure_curves_t), intent(in) :: curves
      real(wp), intent(in) :: memory(:)
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn
      real(wp) :: vm

      vm = curves%vm(cycle_at(memory, sn > memory(turn_stress)))
      path_closure = memory(turn_closure) + (closure(curves%kn0, vm, sn) - closure(curves%kn0, vm, memory(turn_stress)))
   end function path_closure

   !> Normal stiffness on the path [MPa/mm]; at the turn that of unloading, the larger one.
   pure real(wp) function path_stiffness(curves, memory, sn)
      type(closure_curves_t), intent(in) :: curves
      real(wp), intent(in) :: memory(:)
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      path_stiffness = normal_stiffness(curves%kn0, curves%vm(cycle_at(memory, sn > memory(turn_stress))), sn)
   end function path_stiffness

   !> Cycle whose curve is followed above or below the turn.
   pure integer function cycle_at(memory, above)
      real(wp), intent(in) :: memory(:)
      logical, intent(in) :: above

      cycle_at = max(1, nint(merge(memory(cycle_above), memory(cycle_below), above)))
   end function cycle_at

   !> Move on along the path to a normal stress.
   pure subroutine follow_path(curves, sn, memory)
      type(closure_curves_t), intent(in) :: curves
      !> Normal stress, not negative [MPa]
      real(wp), intent(in) :: sn
      real(wp), intent(inout) :: memory(:)
      real(wp) :: v
      integer :: now, next

      v = path_closure(curves, memory, sn)
      now = cycle_at(memory, .true.)
      next = min(now + 1, cycles)
      if (sn > memory(turn_stress)) then
         memory(cycle_above) = real(now, wp)
         memory(cycle_below) = real(merge(now, next, curves%vm(now) < curves%vm(next)), wp)
      else if (sn < fallen*memory(turn_stress) .and. memory(lowest) < fallen*memory(turn_stress)) then
         memory(cycle_above) = real(next, wp)
         memory(lowest) = sn
      else if (sn < memory(lowest)) then
         memory(lowest) = sn
      else
         return
      end if
      memory(turn_stress) = sn
      memory(turn_closure) = v
   end subroutine follow_path

end module jcm_closure_m
