!> What is said where a search for rest has failed: when, where, why, what moves, and what may help.
module rest_report_m
   use kinds_m, only: wp
   use text_m, only: to_text, quoted
   use mesh_m, only: place_text
   use model_m, only: model_t
   use state_m, only: state_t
   implicit none
   private

   public :: no_rest, no_factors

   !> Ends of a search for rest: found, moved too far, too heavy a drag, too many steps, no factors of the matrix, rock breaks,
   !> to be tried again otherwise
   integer, parameter, public :: end_rest = 0, end_far = 1, end_stuck = 2, end_long = 3, end_linear = 4, end_broken = 5, &
                                 end_again = 6
   !> Block edges named in the message of a collapse
   integer, parameter :: most_named = 3

contains

   !> No rest: when, where and what moves.
   function no_rest(model, stage, cycle, level, ending, weak_springs, began, moved, state) result(text)
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      !> Loads, 0 to 1 over the stage
      real(wp), intent(in) :: level
      !> How the way in pseudo-time ended
      integer, intent(in) :: ending
      !> Do springs without force hold what nothing else does?
      logical, intent(in) :: weak_springs
      !> Displacement where the way began (2, nodes) [m]
      real(wp), intent(in) :: began(:, :)
      !> Slip since the last rest (joints) [mm]
      real(wp), intent(in) :: moved(:)
      !> Where the way ended, with the time of the increment's start
      type(state_t), intent(in) :: state
      character(len=:), allocatable :: text, advice
      integer :: most

      text = ' in '//to_text(model%deck%implicit%max_pseudo_steps)//' steps of pseudo-time'
      advice = 'a larger &implicit max_pseudo_steps follows it further'
      select case (ending)
      case (end_far)
         text = ': nothing holds the load'
         advice = 'less load or other supports hold it; solver = ''explicit'' follows the motion'
      case (end_stuck)
         text = ', and steps of pseudo-time find no way on'
         advice = 'more cycles or solver = ''relaxation'' may find it'
      end select
      if (weak_springs) then
         advice = 'springs without force alone hold rock here (&implicit loose_bodies), and its loads are not in balance'
         if (size(model%loads%pressure_surface) > 0) &
            advice = advice//': &boundary pressure turns with the surface, and a body that turns in it may have no equilibrium'
         advice = advice//'; prescribe displacements that hold it, or give tractions (tx, ty), which do not turn'
      end if
      text = 'no rest at time '//to_text(state%time)//' s (stage '//quoted(model%deck%stage(stage)%name)//', cycle '// &
             to_text(cycle)//', load level '//to_text(level)//')'//text
      most = maxloc(sum((state%u - began)**2, dim=1, mask=.not. model%loads%fixed), dim=1)
      text = text//'; most moves the rock near '//place_text(model%split%x(:, most), model%split%datum)//', by '// &
             to_text(norm2(state%u(:, most) - began(:, most)))//' m'
      text = text//moving_edges(model, moved)//'; '//advice//'. The state written last is '// &
             trim(merge('that of the last step ', 'the last one at rest  ', model%can_break))
   end function no_rest

   !> The linear solver cannot go on.
   function no_factors(why, model, stage, cycle, level, state) result(text)
      !> What it says
      character(len=*), intent(in) :: why
      type(model_t), intent(in) :: model
      integer, intent(in) :: stage, cycle
      !> Loads, 0 to 1 over the stage
      real(wp), intent(in) :: level
      !> At the last rest
      type(state_t), intent(in) :: state
      character(len=:), allocatable :: text

      text = why//' at time '//to_text(state%time)//' s (stage '//quoted(model%deck%stage(stage)%name)// &
             ', cycle '//to_text(cycle)//', load level '//to_text(level)//'); a coarser mesh, a larger '// &
             '&implicit max_memory, a machine with more memory or solver = ''relaxation'', which needs no matrix, '// &
             'may help. What is written ends with the last cycle completed'
   end function no_factors

   !> The block edges that have slipped most.
   function moving_edges(model, moved) result(text)
      type(model_t), intent(in) :: model
      !> Slip since the last rest (joints) [mm]
      real(wp), intent(in) :: moved(:)
      character(len=:), allocatable :: text
      real(wp), allocatable :: slip(:)
      integer :: i, edge, joint

      text = ''
      if (size(model%topology%edge_length) == 0) return
      slip = [(mean_slip(i), i=1, size(model%topology%edge_length))]
      do i = 1, min(most_named, size(slip))
         edge = maxloc(slip, dim=1)
         if (slip(edge) <= 0.0_wp) exit
         joint = findloc(model%topology%edge_of_joint, edge, dim=1)
         if (i == 1) text = '; block edges that slip:'
         if (i > 1) text = text//','
         text = text//' '//to_text(edge)//' at '//place_text(model%split%x(:, model%split%joint(1, joint)), model%split%datum)// &
                ' ('//to_text(slip(edge))//' mm)'
         slip(edge) = 0.0_wp
      end do

   contains

      !> Mean slip of a block edge [mm].
      pure real(wp) function mean_slip(edge)
         integer, intent(in) :: edge
         logical :: member(size(moved))

         member = model%topology%edge_of_joint == edge
         mean_slip = 0.0_wp
         if (any(member)) mean_slip = sum(model%joints%length*abs(moved), mask=member)/sum(model%joints%length, mask=member)
      end function mean_slip

   end function moving_edges

end module rest_report_m
