!> What the solvers that know rest alone look at: is everything held, and does no contact matter that is not in their equations?
module rest_checks_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use text_m, only: to_text
   use log_m, only: log_t
   use mesh_m, only: place_text
   use model_m, only: model_t
   use state_m, only: state_t
   use support_m, only: find_loose
   use contact_m, only: contact_energy_t
   implicit none
   private

   public :: check_support, check_other_contact

   !> Contact of other surfaces may carry this share of all forces before the answer is refused
   real(wp), parameter :: negligible = 1.0e-2_wp

contains

   !> Find what nothing holds: refuse it, or hold it by weak springs in the matrix alone, which carry no force.
   subroutine check_support(model, stage, log, weak_springs, errors)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(log_t), intent(in) :: log
      !> Do they hold something?
      logical, intent(out) :: weak_springs
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: loose(:), rock(:), joint(:)
      character(len=:), allocatable :: what
      integer :: i

      ! Bodies lean on each other at walls, and bonds hold them. What was taken out holds nothing
      rock = pack([(i, i=1, size(model%split%present))], model%split%present)
      joint = pack([(i, i=1, size(model%joints%gone))],.not. model%joints%gone)
      call find_loose(model%split%x, model%split%triangle(:, rock), model%split%joint(:, joint), model%loads%fixed, loose)
      weak_springs = size(loose) > 0
      do i = 1, size(loose)
         what = 'stage '''//trim(model%deck%stage(stage)%name)//''': nothing holds the rock around '// &
                place_text(model%split%x(:, loose(i)), model%split%datum)
         if (model%deck%implicit%loose_bodies == 'hold') then
            call log%warn(what//'; its loads must be in balance')
         else
            call errors%add(what//' against sliding or turning as a whole, and an implicit solver finds no equilibrium '// &
                            'there; prescribe displacements (&boundary vx, vy = 0), set &implicit loose_bodies = ''hold'' '// &
                            'if its loads are in balance, or use solver = ''explicit''')
         end if
      end do
   end subroutine check_support

   !> Do surfaces that are no fracture walls press on each other? That contact is not in the equations.
   subroutine check_other_contact(model, stage, log, warned, state, errors)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage
      type(log_t), intent(in) :: log
      !> Has it been warned of?
      logical, intent(inout) :: warned
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp) :: push(2, size(state%u, 2)), rub(2, size(state%u, 2)), share
      type(contact_energy_t) :: energy
      character(len=:), allocatable :: what
      integer :: node

      if (model%contact%needs_search(state%contact, state%u)) call model%contact%search(model%exposed, state%u, state%contact)
      push = 0.0_wp
      rub = 0.0_wp
      call model%contact%forces(model%exposed, state%u, state%v, state%surface_friction, state%contact, push, rub, energy)
      share = norm2(push)
      if (share <= 0.0_wp) return
      share = share/norm2([norm2(state%normal), norm2(state%friction), norm2(state%load), share])
      node = maxloc(push(1, :)**2 + push(2, :)**2, dim=1)
      what = 'surfaces that are not the two walls of a fracture overlap in stage '''// &
             trim(model%deck%stage(stage)%name)//''', most near '// &
             place_text(model%split%x(:, node), model%split%datum)//': their contact would be '// &
             to_text(100.0_wp*share)//' % of all forces'
      if (share > negligible) then
         call errors%add(what//', which the implicit solver leaves out; use solver = ''relaxation'' or ''explicit'', or '// &
                         '&contact active = .false. if this does not matter')
      else if (.not. warned) then
         call log%warn(what//'; it is left out')
         warned = .true.
      end if
   end subroutine check_other_contact

end module rest_checks_m
