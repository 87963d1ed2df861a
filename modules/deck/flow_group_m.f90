!> The group &flow: steady flow through fractures and rock. Without it nothing flows and nothing of it is written.
module flow_group_m
   use errors_m, only: error_list_t
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: option_length, check_choice, check_range, check_least
   use kinds_m, only: wp
   use group_variables_m, only: group_variables_t
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
      !> Damage of a crack from which on fluid gets into it [-]: 1 when it has broken
      real(wp) :: fluid_enters = 1.0_wp
      !> May fluid lag behind the tip of a crack? What opens then fills only as fast as fluid gets there
      logical :: fluid_lag = .false.
      !> Is the equivalent permeability of the model found at every output time?
      logical :: permeability = .true.
   end type flow_t

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
      type(group_variables_t) :: variables

      flow%line = slice%line
      call variables%read(slice)
      call name_variables(variables, flow)
      call variables%end_reading(errors)
      call check_choice(errors, slice, 'coupling', flow%coupling, couplings)
      call check_range(errors, slice, 'tolerance', flow%tolerance, above=0.0_wp, below=1.0_wp)
      call check_least(errors, slice, 'max_passes', flow%max_passes, 1)
      call check_choice(errors, slice, 'hydraulic', flow%hydraulic, hydraulic_laws)
      call check_range(errors, slice, 'fluid_enters', flow%fluid_enters, above=0.0_wp, most=1.0_wp)
   end subroutine read_flow

   !> The variables, for reading and writing.
   subroutine name_variables(variables, flow)
      type(group_variables_t), intent(inout) :: variables
      type(flow_t), intent(inout) :: flow

      call variables%keep('coupling', flow%coupling)
      call variables%keep('tolerance', flow%tolerance)
      call variables%keep('max_passes', flow%max_passes)
      call variables%keep('hydraulic', flow%hydraulic)
      call variables%keep('fluid_enters', flow%fluid_enters)
      call variables%keep('fluid_lag', flow%fluid_lag)
      call variables%keep('permeability', flow%permeability)
   end subroutine name_variables

   !> Write the effective group, every variable; nothing where the deck has none.
   subroutine write_flow(flow, unit)
      type(flow_t), intent(in) :: flow
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(flow_t) :: effective

      effective = flow
      call variables%write(unit, 'flow')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_flow

end module flow_group_m
