!> The scene plan: what this scene needs, what is skipped, and why; printed before the run.
module plan_m
   use text_m, only: to_text, quoted
   use log_m, only: log_t
   use scene_m, only: scene_t
   use mesh_m, only: mesh_t
   implicit none
   private

   public :: say_plan

contains

   !> Tell the log what the program found and what it will do.
   subroutine say_plan(scene, mesh, log)
      type(scene_t), intent(in) :: scene
      !> The mesh as read
      type(mesh_t), intent(in) :: mesh
      type(log_t), intent(in) :: log

      call log%say('mesh      '//to_text(size(mesh%x, 2))//' nodes, '//to_text(size(mesh%triangle, 2))// &
                   ' triangles; after splitting '//to_text(size(scene%split%x, 2))//' nodes, '// &
                   to_text(size(scene%split%joint, 2))//' joint elements on '// &
                   to_text(size(scene%topology%edge_length))//' block edges')
      if (.not. scene%can_break) then
         call log%say('rock      triangles share their nodes: nothing can break, so no cohesive joint elements')
      else
         if (size(scene%bonds%active) > 0) call log%say('rock      '//to_text(size(scene%bonds%active))// &
                                                        ' cohesive joint elements from the start')
         if (scene%is_adaptive) call log%say('rock      '//to_text(count(scene%breakable > 0))// &
                                             ' edges stay whole until their stress reaches the strength (looked at every '// &
                                             to_text(scene%check_every)//' steps)')
      end if
      if (scene%has_walls) then
         call log%say('walls     '//to_text(size(scene%walls%joint))//' joint elements in wall contact, followed along the '// &
                      'walls: no search')
      else
         call log%say('walls     none in wall contact')
      end if
      if (scene%has_contact) then
         call log%say('contact   other surfaces can meet: potential contact, searched again when one has moved half the skin')
      else if (.not. scene%deck%contact%active) then
         call log%say('contact   switched off in the deck (&contact active)')
      else
         call log%say('contact   no other surfaces can meet: never searched')
      end if
   end subroutine say_plan

end module plan_m
