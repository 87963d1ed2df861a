!> Excavation: which rock a stage takes out. What that changes is for recut_m.
!>
!> The triangles of a group leave at the start of their stage, with their mass, their stiffness and the joints in and beside
!> them. What they had exerted on the rest until then stays as a load and is let go of over the stage, as other loads change:
!> a stress release by ramp. At its start no force on any node jumps, at its end the new wall is free.
module excavation_m
   use kinds_m, only: wp
   use text_m, only: to_text, quoted
   use log_m, only: log_t
   use mesh_m, only: find_group, a_surface
   use cracks_m, only: breaks_t
   use model_m, only: model_t
   use state_m, only: state_t
   implicit none
   private

   public :: find_excavation, say_excavation, end_relief

contains

   !> What is to be taken out that is there still, when a stage begins or has begun.
   subroutine find_excavation(model, stage, breaks)
      type(model_t), intent(in) :: model
      !> Number of the stage (0: none yet)
      integer, intent(in) :: stage
      type(breaks_t), intent(inout) :: breaks
      logical :: taken(size(model%split%triangle_group))
      integer :: s

      taken = .false.
      do s = 1, stage
         if (model%deck%stage(s)%remove == '') cycle
         taken = taken .or. model%split%triangle_group == find_group(model%split%group, model%deck%stage(s)%remove, a_surface)
      end do
      taken = taken .and. model%split%present
      if (.not. any(taken)) return
      breaks%taken = taken
      if (.not. allocated(breaks%edge)) allocate (breaks%edge(0))
   end subroutine find_excavation

   !> Say what a stage takes out.
   subroutine say_excavation(model, stage, breaks, log)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(breaks_t), intent(in) :: breaks
      type(log_t), intent(in) :: log

      call log%say('stage     '//quoted(model%deck%stage(stage)%name)//' takes out '//to_text(count(breaks%taken))// &
                   ' triangles of '//quoted(model%deck%stage(stage)%remove)//', '// &
                   to_text(sum(model%solid%area, mask=breaks%taken))//' m2')
   end subroutine say_excavation

   !> A stage is over: nothing is left to let go of.
   pure subroutine end_relief(state)
      type(state_t), intent(inout) :: state

      state%relief = reshape([real(wp) ::], [2, 0])
   end subroutine end_relief

end module excavation_m
