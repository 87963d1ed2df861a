!> cracks.csv: one row a cohesive joint that broke, in the order of time.
module crack_results_m
   use bond_m, only: mode_i, mode_ii, mode_mixed
   use bonds_m, only: crack_event_t
   use errors_m, only: error_list_t
   use files_m, only: replace_file
   use text_m, only: ten_digits, exact_text, csv_text
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
            write (unit, '(a)', iostat=status, iomsg=message) ten_digits(e%time)//','//csv_text(stage_name(e%stage))//','// &
               exact_text(e%place(1))//','//exact_text(e%place(2))//','//ten_digits(e%angle)//','//ten_digits(e%length)//','// &
               trim(mode_name(e%mode))//','//ten_digits(e%energy)
         end associate
      end do
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status == 0) then
         call replace_file(trim(path)//'.part', path, status)
         message = 'cannot replace the old file'
      end if
      if (status /= 0) call errors%add(trim(path)//': cannot write the table of cracks: '//trim(message))
   end subroutine write_cracks

end module crack_results_m
