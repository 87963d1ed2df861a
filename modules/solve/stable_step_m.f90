!> The stable time step, computed from rock, joints and contact; and mass scaling, its inverse.
!>
!> Every triangle, joint and contact adds a bound to its nodes such that u.K u <= sum s_i |u_i|^2 and the same with the
!> damping matrix, v.C v <= sum c_i |v_i|^2. The stepping is stable when s_i dt^2 + 2 c_i dt <= 4 m_i at every node
!> that moves: for c = 0 the familiar dt <= 2/omega. Nodes that are prescribed altogether count with what bonds, joints and
!> contact add to them: see longest_step.
module stable_step_m
   use kinds_m, only: wp
   use constants_m, only: is_set
   use errors_m, only: error_list_t
   use text_m, only: to_text, quoted
   use model_m, only: model_t
   use solver_choice_m, only: solver_explicit
   use state_m, only: state_t
   use forces_m, only: stiffness_bound
   implicit none
   private

   !> Differences of stiffness below this share are rounding errors
   real(wp), parameter :: rounding = 1.0e-9_wp

   public :: stable_step, first_step, check_given_step, scaled_mass, longest_stable_step

contains

   !> Step for the present state [s]: what the deck gives, else the stable step times the safety factor; with mass scaling
   !> the scaled step, after raising the masses that need it.
   real(wp) function stable_step(model, state) result(step)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp) :: stiffness(size(state%mass))

      call stiffness_bound(model, state, stiffness)
      associate (settings => model%deck%explicit)
         if (settings%mass_scaling == 'step') then
            call raise_masses(scaled_mass(stiffness, model%nodes%rock_damping, model%nodes%mass, &
                                          settings%scaled_step/settings%safety), state)
            step = settings%scaled_step
         else if (is_set(settings%step)) then
            step = settings%step
         else
            step = settings%safety*longest_step(model, stiffness, state)
         end if
      end associate
   end function stable_step

   !> The same before anything has been done, with the masses as they are: for an estimate [s].
   real(wp) function first_step(model, state) result(step)
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      real(wp) :: stiffness(size(state%mass))

      associate (settings => model%deck%explicit)
         if (settings%mass_scaling == 'step') then
            step = settings%scaled_step
         else if (is_set(settings%step)) then
            step = settings%step
         else
            call stiffness_bound(model, state, stiffness)
            step = settings%safety*longest_step(model, stiffness, state)
         end if
      end associate
   end function first_step

   !> The longest step of a scene [s]: stable for nodes that move freely, and short enough for what happens between walls whose
   !> nodes are all prescribed: nothing there can become unstable, but laws that know their past must be followed.
   real(wp) function longest_step(model, stiffness, state) result(step)
      type(model_t), intent(in) :: model
      !> Nodal bounds (nodes) [N/m per m of thickness]
      real(wp), intent(in) :: stiffness(:)
      type(state_t), intent(in) :: state
      real(wp), allocatable :: of_walls(:)
      logical, allocatable :: held(:, :)

      step = longest_stable_step(stiffness, model%nodes%rock_damping, state%mass, model%loads%fixed)
      held = spread(.not. all(model%loads%fixed, dim=1), 1, 2)
      if (all(held)) return
      ! What bonds, joints and contact add to the rock's own; less than a rounding error of that is nothing
      of_walls = stiffness - (1.0_wp + model%local_damping)*model%nodes%rock_stiffness
      where (of_walls < rounding*stiffness) of_walls = 0.0_wp
      step = min(step, longest_stable_step(of_walls, 0.0_wp*of_walls, state%mass, held))
      ! Neither: rock that is deformed by prescribed motion alone
      held = .false.
      if (step >= huge(step)) step = longest_stable_step(stiffness, model%nodes%rock_damping, state%mass, held)
   end function longest_step

   !> Raise masses to what the step needs. They never fall again: masses that went up and down would pump energy. Momentum
   !> is kept, and the kinetic energy this costs is booked with the damping.
   subroutine raise_masses(needed, state)
      !> Masses for a stable step (nodes) [kg per m]
      real(wp), intent(in) :: needed(:)
      type(state_t), intent(inout) :: state
      real(wp) :: share
      integer :: n

      do n = 1, size(needed)
         if (needed(n) <= state%mass(n)) cycle
         share = state%mass(n)/needed(n)
         state%energy%damping = state%energy%damping + 0.5_wp*state%mass(n)*(1.0_wp - share)*sum(state%v(:, n)**2)
         state%v(:, n) = share*state%v(:, n)
         state%mass(n) = needed(n)
      end do
   end subroutine raise_masses

   !> A step given in the deck must be stable at the start of a stage.
   subroutine check_given_step(model, stage, state, errors)
      type(model_t), intent(in) :: model
      !> Stage that starts
      integer, intent(in) :: stage
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp) :: stiffness(size(state%mass)), longest

      associate (settings => model%deck%explicit)
         if (.not. is_set(settings%step) .or. model%solver /= solver_explicit) return
         call stiffness_bound(model, state, stiffness)
         longest = longest_step(model, stiffness, state)
         if (settings%step <= longest) return
         call errors%add(model%deck%path//':'//to_text(settings%line)//': &explicit step = '//to_text(settings%step)// &
                         ' s: longer than the stable step, '//to_text(longest)//' s at the start of stage '// &
                         quoted(model%deck%stage(stage)%name)//'; must be less, or be left out: the program then finds it')
      end associate
   end subroutine check_given_step

   !> The longest step with s dt^2 + 2 c dt <= 4 m at every node that can move [s].
   pure real(wp) function longest_stable_step(stiffness, damping, mass, fixed) result(step)
      !> Nodal bounds s [N/m], c [N s/m] and mass [kg], each (nodes) per m of thickness
      real(wp), intent(in) :: stiffness(:), damping(:), mass(:)
      !> Prescribed components (2, nodes)
      logical, intent(in) :: fixed(:, :)
      integer :: n

      step = huge(step)
      do n = 1, size(mass)
         if (all(fixed(:, n)) .or. stiffness(n) <= 0.0_wp) cycle
         step = min(step, (sqrt(damping(n)**2 + 4.0_wp*stiffness(n)*mass(n)) - damping(n))/stiffness(n))
      end do
   end function longest_stable_step

   !> Masses raised where the step would not be stable (nodes) [kg per m].
   elemental real(wp) function scaled_mass(stiffness, damping, mass, step)
      !> Nodal bounds s [N/m], c [N s/m], true mass [kg], per m of thickness
      real(wp), intent(in) :: stiffness, damping, mass
      !> Step that has to be stable [s]
      real(wp), intent(in) :: step

      scaled_mass = max(mass, 0.25_wp*(stiffness*step**2 + 2.0_wp*damping*step))
   end function scaled_mass

end module stable_step_m
