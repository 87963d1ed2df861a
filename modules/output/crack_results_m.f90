!> cracks.csv: one row a cohesive joint that broke, in the order of time.
module crack_results_m
   use bond_m, only: mode_i, mode_ii, mode_mixed
   use bonds_m, only: crack_event_t
   use errors_m, only: error_list_t
   use files_m, only: replace_file
   use kinds_m, only: wp
   implicit none
   private

   public :: write_cracks

   character(len=*), parameter :: mode_name(mode_i:mode_mixed) = [character(len=5) :: 'I', 'II', 'mixed']

contains

   !> Write the table; a reader sees the old file or the new one, never half of one.
   subroutine write_cracks(path, event, stage_name, errors)
      character(len=*), intent(in) :: path
      type(crack_event_t), intent(in) :: event(:)
      !> Names of all stages
      character(len=*), intent(in) :: stage_name(:)
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: unit, status, i

      open (newunit=unit, file=trim(path)//'.part', action='write', status='replace', iostat=status, iomsg=message)
      if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) &
         'time_s,stage,x_m,y_m,angle_deg,length_m,mode,energy_J'
      do i = 1, size(event)
         if (status /= 0) exit
         associate (e => event(i))
            write (unit, '(a)', iostat=status, iomsg=message) number(e%time)//','//trim(stage_name(e%stage))//','// &
               number(e%place(1))//','//number(e%place(2))//','//number(e%angle)//','//number(e%length)//','// &
               trim(mode_name(e%mode))//','//number(e%energy)
         end associate
      end do
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status == 0) then
         call replace_file(trim(path)//'.part', path, status)
         message = 'cannot replace the old file'
      end if
      if (status /= 0) call errors%add(trim(path)//': cannot write the table of cracks: '//trim(message))
   end subroutine write_cracks

   !> A number with ten digits.
   pure function number(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=20) :: buffer

      write (buffer, '(es18.9e3)') value
      text = trim(adjustl(buffer))
   end function number

end module crack_results_m
