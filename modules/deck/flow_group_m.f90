!> The group &flow: steady flow through fractures and rock. Without it nothing flows and nothing of it is written.
module flow_group_m
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: variable_t, a_number, a_count, a_switch, an_option, option_length, namelist_text, &
                              require_clean_read, check_choice, check_range, check_least
   use kinds_m, only: wp
   use deck_write_m, only: begin_group, put, end_group
   implicit none
   private

   public :: read_flow, write_flow

   !> &flow
   type, public :: flow_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> What flow and stress say to each other: the apertures conduct, and the pressure of the fluid does not push back or does
      character(len=option_length) :: coupling = 'one-way'
      !> Two-way: change of the fluid's loads over the largest at which pressure and apertures agree [-], and passes in a cycle
      real(wp) :: tolerance = 1.0e-4_wp
      integer :: max_passes = 30
      !> Hydraulic from mechanical aperture, where no &conduit says otherwise
      character(len=option_length) :: hydraulic = 'equal'
      !> Is the equivalent permeability of the model found at every output time?
      logical :: permeability = .true.
   end type flow_t

   type(variable_t), parameter :: variables(*) = [ &
                                  variable_t('coupling', an_option), &
                                  variable_t('tolerance', a_number), &
                                  variable_t('max_passes', a_count), &
                                  variable_t('hydraulic', an_option), &
                                  variable_t('permeability', a_switch)]
   character(len=*), parameter :: couplings(*) = ['one-way', 'two-way']
   !> Laws of the hydraulic aperture
   character(len=*), parameter, public :: hydraulic_laws(*) = ['equal        ', 'barton       ', 'olsson_barton']

contains

   !> Read and check the group.
   subroutine read_flow(slice, flow, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(flow_t), intent(out) :: flow
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: text
      character(len=256) :: message
      integer :: status
      namelist /settings/ flow

      flow%line = slice%line
      call namelist_text(slice, variables, text, errors)
      read (text, nml=settings, iostat=status, iomsg=message)
      call require_clean_read(slice, status, message, errors)
      call check_choice(errors, slice, 'coupling', flow%coupling, couplings)
      call check_range(errors, slice, 'tolerance', flow%tolerance, above=0.0_wp, below=1.0_wp)
      call check_least(errors, slice, 'max_passes', flow%max_passes, 1)
      call check_choice(errors, slice, 'hydraulic', flow%hydraulic, hydraulic_laws)
   end subroutine read_flow

   !> Write the effective group, every variable; nothing where the deck has none.
   subroutine write_flow(flow, unit)
      type(flow_t), intent(in) :: flow
      integer, intent(in) :: unit

      call begin_group(unit, 'flow')
      call put(unit, 'coupling', flow%coupling)
      call put(unit, 'tolerance', flow%tolerance)
      call put(unit, 'max_passes', flow%max_passes)
      call put(unit, 'hydraulic', flow%hydraulic)
      call put(unit, 'permeability', flow%permeability)
      call end_group(unit)
   end subroutine write_flow

end module flow_group_m
