!> cracks.csv: one row a cohesive joint that broke, in the order of time.
module crack_results_m
   use bond_m, only: mode_i, mode_ii, mode_mixed
   use bonds_m, only: crack_event_t
   use emission_m, only: crack_magnitude
   use errors_m, only: error_list_t
   use files_m, only: replace_file
   use text_m, only: ten_digits, exact_text, csv_text
   implicit none
   private

   public :: write_cracks, append_cracks

   character(len=*), parameter :: mode_name(mode_i:mode_mixed) = [character(len=5) :: 'I', 'II', 'mixed']

contains

   !> Write the whole table; a reader sees the old file or the new one, never half of one.
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
         'time_s,stage,x_m,y_m,angle_deg,length_m,mode,energy_J,mxx_N,myy_N,mxy_N,mzz_N,magnitude'
      do i = 1, size(event)
         if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) row(event(i), stage_name)
      end do
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status == 0) then
         call replace_file(trim(path)//'.part', path, status)
         message = 'cannot replace the old file'
      end if
      if (status /= 0) call errors%add(trim(path)//': cannot write the table of cracks: '//trim(message))
   end subroutine write_cracks

   !> Add rows at the end of the table, each whole as soon as it is there.
   subroutine append_cracks(path, event, stage_name, errors)
      character(len=*), intent(in) :: path
      !> Those that are not in the table yet
      type(crack_event_t), intent(in) :: event(:)
      character(len=*), intent(in) :: stage_name(:)
      type(error_list_t), intent(inout) :: errors
      character(len=512) :: message
      integer :: unit, status, i

      if (size(event) == 0) return
      open (newunit=unit, file=trim(path), action='write', status='old', position='append', iostat=status, iomsg=message)
      do i = 1, size(event)
         if (status == 0) write (unit, '(a)', iostat=status, iomsg=message) row(event(i), stage_name)
         if (status == 0) flush (unit, iostat=status, iomsg=message)
      end do
      if (status == 0) close (unit, iostat=status, iomsg=message)
      if (status /= 0) call errors%add(trim(path)//': cannot write the table of cracks: '//trim(message))
   end subroutine append_cracks

   !> One row of the table.
   pure function row(event, stage_name) result(line)
      type(crack_event_t), intent(in) :: event
      character(len=*), intent(in) :: stage_name(:)
      character(len=:), allocatable :: line

      line = ten_digits(event%time)//','//csv_text(stage_name(event%stage))//','//exact_text(event%place(1))//','// &
             exact_text(event%place(2))//','//ten_digits(event%angle)//','//ten_digits(event%length)//','// &
             trim(mode_name(event%mode))//','//ten_digits(event%energy)//','//ten_digits(event%moment(1))//','// &
             ten_digits(event%moment(2))//','//ten_digits(event%moment(3))//','//ten_digits(event%moment(4))//','// &
             ten_digits(crack_magnitude(event%length, event%moment))
   end function row

end module crack_results_m
