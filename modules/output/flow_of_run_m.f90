!> Flow through the apertures of a mechanical run: what of scene and state it takes.
module flow_of_run_m
   use kinds_m, only: wp
   use units_m, only: megapascal
   use errors_m, only: error_list_t
   use fluid_coupling_m, only: conducting_lines, mobilised_roughness
   use flow_domain_m, only: set_moment
   use flow_results_m, only: flow_results_t, flow_moment_t
   use run_checkpoint_m, only: place_t
   use model_m, only: model_t
   use solid_stress_m, only: solid_stress
   use state_m, only: state_t
   implicit none
   private

   public :: open_run_flow, take_run_flow, write_run_flow

contains

   !> Start the tables of flow, where the deck has a &flow.
   subroutine open_run_flow(flow, directory, model, restarted, time, errors)
      type(flow_results_t), intent(inout) :: flow
      !> Directory with a slash at its end
      character(len=*), intent(in) :: directory
      type(model_t), intent(in) :: model
      logical, intent(in) :: restarted
      !> Latest time to keep of earlier rows, with a restart [s]
      real(wp), intent(in) :: time
      type(error_list_t), intent(inout) :: errors

      call flow%open(directory, model%deck, model%whole, restarted, time, errors)
   end subroutine open_run_flow

   !> Solve the flow through the apertures of a state.
   subroutine take_run_flow(flow, model, state, place, errors)
      type(flow_results_t), intent(inout) :: flow
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      type(error_list_t), intent(inout) :: errors
      logical, allocatable :: filled(:)
      integer, allocatable :: line(:, :)

      if (.not. flow%active) return
      call set_moment(flow%model, place%stage, real(place%cycle, wp)/real(model%deck%stage(place%stage)%cycles, wp))
      call conducting_lines(model, state, line, filled)
      call flow%take(line, model%split%joint_group, model%topology%edge_of_joint, state%aperture, state%joint%ratio, &
                     mobilised_roughness(model%joints%law, state%joint%ratio, state%joint%sn), filled, errors, state%fluid)
   end subroutine take_run_flow

   !> A row in each table of flow.
   subroutine write_run_flow(flow, model, state, place, errors)
      type(flow_results_t), intent(inout) :: flow
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      type(error_list_t), intent(inout) :: errors
      type(flow_moment_t) :: moment

      if (.not. flow%active) return
      call take_run_flow(flow, model, state, place, errors)
      moment = flow_moment_t(state%time, [real(state%step, wp), real(place%stage, wp), real(place%cycle, wp)], &
                             mean_stress(model, state))
      call flow%write_row(moment, errors)
   end subroutine write_run_flow

   !> Mean stress of the rock, xx, yy, xy, compression positive [MPa].
   pure function mean_stress(model, state) result(mean)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      real(wp) :: mean(3)
      integer :: e

      mean = 0.0_wp
      do e = 1, size(model%solid%area)
         mean = mean - model%solid%area(e)*solid_stress(model%solid, e, state%u)
      end do
      mean = mean/sum(model%solid%area)/megapascal
   end function mean_stress

end module flow_of_run_m
