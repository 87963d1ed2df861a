!> The scene plan: what this scene needs, what is skipped, and why; printed before the run.
module plan_m
   use text_m, only: to_text, quoted
   use log_m, only: log_t
   use scene_m, only: scene_t
   use solver_choice_m, only: solver_name, solver_explicit, solver_implicit
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
      call log%say('solver    '//solver_name(scene%solver)//': '//scene%solver_reason)
      call say_rock(scene, log)
      if (scene%has_walls) then
         call log%say('walls     '//to_text(size(scene%walls%joint))//' joint elements in wall contact, followed along the '// &
                      'walls: no search')
      else
         call log%say('walls     none in wall contact')
      end if
      if (scene%has_contact .and. scene%solver == solver_implicit) then
         call log%say('contact   other surfaces can meet: not in the equations, measured at the end of each cycle')
      else if (scene%deck%contact%search == 'always') then
         call log%say('contact   searched in every step, as the deck asks (&contact search)')
      else if (scene%has_contact) then
         call log%say('contact   other surfaces can meet: potential contact, searched again when one has moved half the skin')
      else if (.not. scene%deck%contact%active) then
         call log%say('contact   switched off in the deck (&contact active)')
      else
         call log%say('contact   no other surfaces can meet: never searched')
      end if
      if (scene%solver /= solver_explicit) then
         call log%say('motion    none: no inertia, no damping, no time step')
      else if (size(scene%damping_force, 2) == 0) then
         call log%say('motion    no viscous forces: damping is '//trim(scene%deck%explicit%damping))
      end if
   end subroutine say_plan

   !> Whether and where the rock can break, and what that saves.
   subroutine say_rock(scene, log)
      type(scene_t), intent(in) :: scene
      type(log_t), intent(in) :: log

      if (.not. scene%can_break) then
         call log%say('rock      nothing can break: no cohesive joint elements, triangles share their nodes ('// &
                      to_text(size(scene%split%x, 2))//' in place of '//to_text(3*size(scene%split%triangle, 2))//')')
         return
      end if
      if (size(scene%bonds%active) > 0) call log%say('rock      '//to_text(size(scene%bonds%active))// &
                                                     ' cohesive joint elements from the start')
      if (.not. scene%is_adaptive) return
      if (scene%solver == solver_explicit) then
         call log%say('rock      '//to_text(count(scene%breakable > 0))//' edges stay whole until their stress asks for a '// &
                      'joint (looked at every '//to_text(scene%check_every)//' steps)')
      else
         call log%say('rock      '//to_text(count(scene%breakable > 0))//' edges stay whole until their stress asks for a '// &
                      'joint (looked at whenever the rock is at rest)')
      end if
   end subroutine say_rock

end module plan_m
