!> Where the time of a run goes: one stopwatch that is always running for one kind of work. It is no part of model or state, so it
!> is the one thing that a module keeps to itself; nothing that is computed depends on it.
!>
!> Reading a clock takes some 30 ns, a step of a hundred triangles a microsecond. Explicit steps are therefore looked into one in
!> seven; the time of the others is shared out as that of those (begin_step). What few steps do is always timed.
module stopwatch_m
   use kinds_m, only: wp, i8
   use text_m, only: to_text
   implicit none
   private

   public :: now_doing, doing, begin_step, end_steps, time_lines

   !> Kinds of work
   integer, parameter, public :: work_other = 1, work_input = 2, work_loads = 3, work_rock = 4, work_bonds = 5, work_walls = 6, &
                                 work_laws = 7, work_search = 8, work_contact = 9, work_motion = 10, work_cracks = 11, &
                                 work_step = 12, work_assembly = 13, work_analysis = 14, work_factors = 15, work_solves = 16, &
                                 work_output = 17
   integer, parameter :: kinds = 17
   character(len=*), parameter :: name(kinds) = [ &
                                  'other   ', 'set-up  ', 'loads   ', 'rock    ', 'bonds   ', 'walls   ', 'laws    ', &
                                  'search  ', 'contact ', 'motion  ', 'cracks  ', 'step    ', 'assembly', 'analyse ', 'factor  ', &
                                  'solve   ', 'output  ']
   !> Kinds that few steps do
   integer, parameter :: rare(4) = [work_search, work_cracks, work_step, work_output]
   !> Of so many explicit steps one is looked into. No divisor of 10 or 100, after which steps often do more than others
   integer(i8), parameter :: steps_a_look = 7_i8
   !> Shares below this are not worth a line
   real(wp), parameter :: noticeable = 0.005_wp
   !> What speeds are told in
   real(wp), parameter :: million = 1.0e6_wp

   !> What it does now, since when (clock counts); is the present step looked into?
   integer, save :: present_work = work_other
   integer(i8), save :: since = -1_i8
   logical, save :: looking = .true., in_step = .false.
   !> Time of each kind outside steps and in steps that were looked into, and in those that were not (clock counts)
   integer(i8), save :: spent(kinds) = 0_i8, seen(kinds) = 0_i8, unseen = 0_i8

contains

   !> The kind of work that is being timed.
   integer function doing()
      doing = present_work
   end function doing

   !> Go over to another kind of work. In steps that are not looked into this is not heard, unless either is rare.
   subroutine now_doing(work)
      integer, intent(in) :: work

      if (looking .or. any(rare == work) .or. any(rare == present_work)) call go_over(work)
   end subroutine now_doing

   !> An explicit step begins.
   subroutine begin_step(step)
      !> Its number
      integer(i8), intent(in) :: step
      logical :: look

      look = mod(step, steps_a_look) == 0_i8
      if (in_step .and. (look .eqv. looking)) return
      call go_over(work_other)
      in_step = .true.
      looking = look
   end subroutine begin_step

   !> The explicit steps are over.
   subroutine end_steps()

      call go_over(work_other)
      in_step = .false.
      looking = .true.
   end subroutine end_steps

   !> Book the time since the last call.
   subroutine go_over(work)
      integer, intent(in) :: work
      integer(i8) :: now

      call system_clock(now)
      if (since >= 0_i8) then
         if (any(rare == present_work) .or. .not. in_step) then
            spent(present_work) = spent(present_work) + (now - since)
         else if (looking) then
            seen(present_work) = seen(present_work) + (now - since)
         else
            unseen = unseen + (now - since)
         end if
      end if
      since = now
      present_work = work
   end subroutine go_over

   !> A table of shares, a line each, largest first, and what the speed was but for set-up and output.
   function time_lines(amount, what) result(line)
      !> Work of the run: triangles times steps, or unknowns times iterations, and what that is called
      real(wp), intent(in) :: amount
      character(len=*), intent(in) :: what
      character(len=72), allocatable :: line(:)
      real(wp) :: seconds(kinds), total, stepping
      integer(i8) :: rate
      integer :: order(kinds), i, j

      call go_over(present_work)
      call system_clock(count_rate=rate)
      seconds = (real(spent, wp) + real(seen, wp))/real(rate, wp)
      if (sum(seen) > 0_i8) seconds = seconds + real(seen, wp)/real(sum(seen), wp)*real(unseen, wp)/real(rate, wp)
      if (sum(seen) == 0_i8) seconds(work_other) = seconds(work_other) + real(unseen, wp)/real(rate, wp)
      total = max(sum(seconds), tiny(total))
      stepping = max(total - seconds(work_input) - seconds(work_output), tiny(total))
      order = [(i, i=1, kinds)]
      do i = 2, kinds
         do j = i, 2, -1
            if (seconds(order(j)) <= seconds(order(j - 1))) exit
            order(j - 1:j) = order([j, j - 1])
         end do
      end do
      allocate (line(0))
      do i = 1, kinds
         associate (part => seconds(order(i)))
            if (part < noticeable*total) exit
            line = [character(len=72) :: line, &
                    'time      '//name(order(i))//aligned(part)//' s'//aligned(100.0_wp*part/total)//' %']
         end associate
      end do
      line = [character(len=72) :: line, 'speed     '//to_text(amount/million/stepping)//' million '//what//' a second']
   end function time_lines

   !> A number with one decimal in ten columns.
   pure function aligned(number) result(text)
      real(wp), intent(in) :: number
      character(len=10) :: text

      write (text, '(f10.1)') number
   end function aligned

end module stopwatch_m
