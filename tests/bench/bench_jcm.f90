!> Joint updates a second of processor time, on one thread. Not a test: it prints, nothing is asserted.
!> Writes bench_jcm.csv (path of the joint, updates_per_second) and the same as a table.
program bench_jcm
   use, intrinsic :: iso_fortran_env, only: output_unit
   use kinds_m, only: wp
   use joint_point_m, only: joint_point_t
   use jcm_scale_m, only: jcm_parameters_t, jcm_edge_t, jcm_scale, post_peak_eq16
   use jcm_m, only: jcm_update
   implicit none

   integer, parameter :: joints = 1000, rounds = 2000
   type(jcm_edge_t) :: edge
   integer :: unit

   open (newunit=unit, file='bench_jcm.csv', action='write', status='replace')
   write (unit, '(a)') 'path,updates_per_second'
   edge = jcm_scale(limestone(), 1.0_wp)
   print '(a)', 'JCM updates, million a second (one thread)'
   call measure('loading, stress changing', 1.0e-4_wp, 1.0e-3_wp, 0, edge)
   call measure('loading, stress constant', 1.0e-4_wp, 0.0_wp, 0, edge)
   call measure('back and forth before the peak', 1.0e-5_wp, 1.0e-3_wp, 10, edge)
   call measure('back and forth after the peak', 1.0e-2_wp, 1.0e-3_wp, rounds/2, edge)
   call measure('open', 1.0e-4_wp, -10.0_wp, 0, edge)
   call measure('at rest', 0.0_wp, 0.0_wp, 0, edge)
   close (unit)

contains

   !> A limestone joint, with the power law after the peak (the dearer form).
   function limestone() result(parameters)
      type(jcm_parameters_t) :: parameters

      parameters%jrc0 = 9.7_wp
      parameters%jcs0 = 169.0_wp
      parameters%l0 = 0.2_wp
      parameters%phi_r = 31.0_wp
      parameters%post_peak = post_peak_eq16
   end function limestone

   !> Time one kind of step.
   subroutine measure(what, du, dsn, reverse_after, edge)
      !> Name of the measurement
      character(len=*), intent(in) :: what
      !> Slip a step [mm], change of normal stress a round, alternating in sign [MPa]
      real(wp), intent(in) :: du, dsn
      !> Number of rounds after which the slip changes direction (0: never)
      integer, intent(in) :: reverse_after
      type(jcm_edge_t), intent(in) :: edge
      real(wp), parameter :: stress = 5.0_wp, million = 1.0e6_wp
      type(joint_point_t), allocatable :: state(:)
      integer :: round, joint
      real(wp) :: slip, sn, start, finish, seconds

      allocate (state(joints))
      slip = du
      call cpu_time(start)
      do round = 1, rounds
         sn = stress + dsn*real(modulo(round, 2), wp)
         if (dsn < -stress) sn = stress + dsn
         if (reverse_after > 0) then
            if (modulo(round, reverse_after) == 0) slip = -slip
         end if
         do joint = 1, joints
            call jcm_update(edge, slip, sn, state(joint))
         end do
      end do
      call cpu_time(finish)
      seconds = finish - start
      write (unit, '("""", a, """,", es12.5)') what, real(joints*rounds, wp)/seconds
      write (output_unit, '(2x, a, t32, f8.1, 4x, a, es12.4)') what, real(joints*rounds, wp)/seconds/million, &
         &'tau [MPa]', state(joints)%tau
   end subroutine measure

end program bench_jcm
