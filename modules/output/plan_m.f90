!> The scene plan: which solver and why, what the scene needs, what is skipped and what that saves; printed before the run.
module plan_m
   use text_m, only: to_text
   use log_m, only: log_t
   use model_m, only: model_t
   use solver_choice_m, only: solver_name, solver_explicit, solver_implicit
   use mesh_m, only: mesh_t, place_text
   use kinds_m, only: wp
   implicit none
   private

   public :: say_plan

contains

   !> Tell the log what the program found and what it will do.
   subroutine say_plan(model, mesh, log)
      type(model_t), intent(in) :: model
      !> The mesh as read
      type(mesh_t), intent(in) :: mesh
      type(log_t), intent(in) :: log

      call log%say('mesh      '//to_text(size(mesh%x, 2))//' nodes, '//to_text(size(mesh%triangle, 2))// &
                   ' triangles; after splitting '//to_text(size(model%split%x, 2))//' nodes, '// &
                   to_text(size(model%split%joint, 2))//' joint elements on '// &
                   to_text(size(model%topology%edge_length))//' block edges')
      call say_extent(model, mesh, log)
      call log%say('solver    '//solver_name(model%solver)//': '//model%solver_reason)
      call say_rock(model, log)
      call say_contact(model, log)
      if (model%solver == solver_explicit) call say_motion(model, log)
      if (model%solver /= solver_explicit) call say_rest(model, log)
      call say_checks(model, log)
   end subroutine say_plan

   !> How large the model is. A mesh drawn in millimetres, or a map in kilometres, shows in the block edges first.
   subroutine say_extent(model, mesh, log)
      type(model_t), intent(in) :: model
      type(mesh_t), intent(in) :: mesh
      type(log_t), intent(in) :: log
      !> Block edges that are meant are mostly between these lengths [m]
      real(wp), parameter :: shortest = 1.0e-3_wp, longest = 100.0_wp

      call log%say('extent    '//to_text(maxval(mesh%x(1, :)) - minval(mesh%x(1, :)))//' m by '// &
                   to_text(maxval(mesh%x(2, :)) - minval(mesh%x(2, :)))//' m, from '// &
                   place_text(minval(mesh%x, dim=2), mesh%datum))
      associate (length => model%topology%edge_length)
         if (size(length) == 0) return
         if (maxval(length) > longest .or. minval(length) < shortest) &
            call log%warn('block edges are '//to_text(minval(length))//' to '//to_text(maxval(length))//' m long: is the mesh '// &
                          'in metres?')
      end associate
   end subroutine say_extent

   !> Whether and where the rock can break, and what that saves.
   subroutine say_rock(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      character(len=:), allocatable :: unknowns

      unknowns = to_text(2*size(model%split%x, 2))//' unknowns in place of '//to_text(6*size(model%split%triangle, 2))// &
                 ' with a joint on every edge'
      if (.not. model%can_break) then
         call log%say('rock      nothing can break: no cohesive joint elements, triangles share their nodes, '//unknowns)
         return
      end if
      if (size(model%bonds%length) > 0) call log%say('rock      '//to_text(size(model%bonds%length))// &
                                                     ' cohesive joint elements from the start, '//unknowns)
      if (.not. model%is_adaptive) return
      if (model%solver == solver_explicit) then
         call log%say('rock      '//to_text(count(model%breakable > 0))//' edges stay whole until their stress asks for a '// &
                      'joint (looked at every '//to_text(model%check_every)//' steps), '//unknowns)
      else
         call log%say('rock      '//to_text(count(model%breakable > 0))//' edges stay whole until their stress asks for a '// &
                      'joint (looked at whenever the rock is at rest), '//unknowns)
      end if
   end subroutine say_rock

   !> Walls, and other surfaces that meet.
   subroutine say_contact(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log
      character(len=:), allocatable :: pushed

      if (model%has_walls) then
         call log%say('walls     '//to_text(size(model%walls%joint)/2)//' joint elements in wall contact, followed along the '// &
                      'walls: no search')
      else
         call log%say('walls     none in wall contact')
      end if
      pushed = to_text(size(model%touching))//' of '//to_text(size(model%split%x, 2))//' nodes can feel it'
      if (.not. model%deck%contact%active) then
         call log%say('contact   switched off in the deck (&contact active)')
      else if (.not. model%has_contact) then
         call log%say('contact   no other surfaces can meet: never searched')
      else if (model%solver == solver_implicit) then
         call log%say('contact   other surfaces can meet: not in the equations, measured at the end of each cycle')
      else if (model%deck%plan%skip_search) then
         call log%say('contact   other surfaces can meet: potential contact, searched again when one has moved half the '// &
                      'skin; '//pushed)
      else
         call log%say('contact   potential contact; '//pushed)
      end if
   end subroutine say_contact

   !> What the explicit solver does not do in every step.
   subroutine say_motion(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log

      if (any(model%deck%boundary%absorbing)) &
         call log%say('sides     waves leave through what &boundary absorbing names; the stable step is that without it')
      if (.not. model%has_damping) &
         call log%say('motion    no viscous forces: damping is '//trim(model%deck%explicit%damping))
      if (model%deck%plan%skip_step) &
         call log%say('step      found again only when contact finds new pairs, walls move on or a joint stiffens')
   end subroutine say_motion

   !> What solvers that know rest alone do without.
   subroutine say_rest(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log

      call log%say('motion    none: no inertia, no damping, no time step; '//to_text(sum(model%deck%stage%cycles))// &
                   ' load increments')
      if (model%solver == solver_implicit .and. model%deck%implicit%matrix == 'kept') &
         call log%say('matrix    kept for as long as iterations converge with it')
   end subroutine say_rest

   !> What would be skipped, but is done because the deck asks for it.
   subroutine say_checks(model, log)
      type(model_t), intent(in) :: model
      type(log_t), intent(in) :: log

      associate (plan => model%deck%plan)
         if (.not. plan%skip_contact) call say('skip_contact', 'contact is looked for where no two surfaces can meet')
         if (.not. plan%skip_search) call say('skip_search', 'contact is searched in every step')
         if (.not. plan%skip_nodes) call say('skip_nodes', 'contact forces are cleared at all nodes')
         if (.not. plan%skip_viscosity) call say('skip_viscosity', 'viscous forces are found even with no viscosity')
         if (.not. plan%skip_step) call say('skip_step', 'the stable step is found in every step')
         if (.not. plan%skip_loads) call say('skip_loads', 'nodal loads are found in every step')
      end associate

   contains

      subroutine say(switch, what)
         character(len=*), intent(in) :: switch, what

         call log%say('check     '//what//' (&plan '//switch//')')
      end subroutine say

   end subroutine say_checks

end module plan_m
