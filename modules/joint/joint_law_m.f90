!> What a joint law is: the type that every law extends, each in a file of its own (NAME_law_m). A law states its deck variables
!> and checks them, scales itself to a block edge, advances a joint and says how it answers. It works in MPa, mm and degrees;
!> everything else in SI units. law_list_m says which laws there are.
module joint_law_m
   use kinds_m, only: wp
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t, joint_dilation_t
   use law_variable_m, only: law_variable_t, law_settings_t, complaints_t, sentence_length, word_length
   implicit none
   private

   !> A value of a law that does not change, for the results
   type, public :: law_result_t
      !> Name of the dataset, with its unit where that is not SI; unit and description
      character(len=word_length) :: name = '', unit = ''
      character(len=sentence_length) :: description = ''
      real(wp) :: value = 0.0_wp
   end type law_result_t

   !> Where a law was kept within its bounds, and did it have to be?
   type, public :: guard_t
      character(len=2*sentence_length) :: text = ''
      logical :: acted = .false.
   end type guard_t

   !> The law of one joint element (or of all joint elements of a block edge)
   type, abstract, public :: joint_law_t
   contains
      ! Once: from the deck to the law of a block edge, and what it says of itself
      procedure(list_of_variables), deferred, nopass :: variables
      procedure(check_of_settings), deferred, nopass :: check
      procedure(scaling_to_edge), deferred :: scale
      procedure :: lend => needs_no_stiffness
      procedure :: guards => no_guards
      procedure :: own_closure => none_of_its_own
      procedure(list_of_results), deferred :: results
      procedure(value_of_law), deferred :: initial_aperture
      ! In every step
      procedure(advance), deferred :: update
      procedure(derivatives), deferred :: tangent
      procedure :: riding_slip => none_rides
      procedure :: end_share => middle
      procedure :: dilation => no_dilation
      procedure :: retrace => stay_dilated
      procedure :: mobilised_roughness => smooth
      procedure :: slip_of_peak => no_peak
      procedure(answer), deferred :: closure_stress
      procedure(answer), deferred :: closure
      procedure(answer), deferred :: normal_stiffness
      procedure(answer), deferred :: shear_stiffness
   end type joint_law_t

   !> A law in an array of laws of any kind
   type, public :: law_item_t
      class(joint_law_t), allocatable :: raw
   end type law_item_t

   abstract interface
      !> Deck variables of the law, those it shares with others too.
      function list_of_variables() result(variables)
         import :: law_variable_t
         type(law_variable_t), allocatable :: variables(:)
      end function list_of_variables

      !> What is wrong with the settings as a whole; ranges have been looked at.
      subroutine check_of_settings(settings, complaints)
         import :: law_settings_t, complaints_t
         type(law_settings_t), intent(in) :: settings
         type(complaints_t), intent(inout) :: complaints
      end subroutine check_of_settings

      !> The law at the scale of a block edge.
      pure subroutine scaling_to_edge(self, settings, edge_length, mean_length)
         import :: joint_law_t, law_settings_t, wp
         class(joint_law_t), intent(inout) :: self
         type(law_settings_t), intent(in) :: settings
         !> Length of the block edge, mean length of the block edges of the &joint [m]
         real(wp), intent(in) :: edge_length, mean_length
      end subroutine scaling_to_edge

      !> Values of the law for the results.
      pure function list_of_results(self) result(list)
         import :: joint_law_t, law_result_t
         class(joint_law_t), intent(in) :: self
         type(law_result_t), allocatable :: list(:)
      end function list_of_results

      !> A value of the law in mm.
      pure real(wp) function value_of_law(self)
         import :: joint_law_t, wp
         class(joint_law_t), intent(in) :: self
      end function value_of_law

      !> Advance one joint element by a slip du to a new normal stress.
      pure subroutine advance(self, du, sn, state, path)
         import :: joint_law_t, joint_point_t, joint_slip_t, wp
         class(joint_law_t), intent(in) :: self
         !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
         real(wp), intent(in) :: du, sn
         type(joint_point_t), intent(inout) :: state
         !> Stresses under which walls that ride on their asperities slip; the end's when not given
         type(joint_slip_t), intent(in), optional :: path
      end subroutine advance

      !> Tangent of the step that led to a state.
      pure function derivatives(self, state, path) result(tangent)
         import :: joint_law_t, joint_point_t, joint_slip_t, joint_tangent_t
         class(joint_law_t), intent(in) :: self
         type(joint_point_t), intent(in) :: state
         !> As for the update
         type(joint_slip_t), intent(in), optional :: path
         type(joint_tangent_t) :: tangent
      end function derivatives

      !> closure_stress: normal stress of a closure [MPa]; closure: its inverse, 0 or what has set when open [mm].
      !> normal_stiffness: at a normal stress, that of first touch when open; shear_stiffness: elastic [MPa/mm].
      pure real(wp) function answer(self, state, value)
         import :: joint_law_t, joint_point_t, wp
         class(joint_law_t), intent(in) :: self
         !> At the start of the step: it holds the curve that the closure is on
         type(joint_point_t), intent(in) :: state
         !> Closure by normal stress [mm] for closure_stress, normal stress [MPa] for the others
         real(wp), intent(in) :: value
      end function answer
   end interface

contains

   !> Most laws have a stiffness of their own.
   pure subroutine needs_no_stiffness(self, penalty)
      class(joint_law_t), intent(inout) :: self
      !> Penalty stiffness of the walls, for a law that has none [MPa/mm]
      real(wp), intent(in) :: penalty

      associate (unused => self, also => penalty)
      end associate
   end subroutine needs_no_stiffness

   !> JRC that a slip has mobilised [-]: most laws know no roughness.
   pure real(wp) function smooth(self, ratio, sn)
      class(joint_law_t), intent(in) :: self
      !> Slip over that of the peak [-], normal stress [MPa]
      real(wp), intent(in) :: ratio, sn

      associate (unused => self, also => [ratio, sn])
      end associate
      smooth = 0.0_wp
   end function smooth

   !> Slip at the peak [mm], 0 for laws that know none.
   pure real(wp) function no_peak(self, sn)
      class(joint_law_t), intent(in) :: self
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      associate (unused => self, also => sn)
      end associate
      no_peak = 0.0_wp
   end function no_peak

   !> Most laws need no bounds.
   pure function no_guards(self) result(guards)
      class(joint_law_t), intent(in) :: self
      type(guard_t), allocatable :: guards(:)

      associate (unused => self)
      end associate
      allocate (guards(0))
   end function no_guards

   !> Largest closure by a curve of the law's own [mm]; 0: walls press by a stiffness that the deck gives.
   pure real(wp) function none_of_its_own(self) result(largest)
      class(joint_law_t), intent(in) :: self

      associate (unused => self)
      end associate
      largest = 0.0_wp
   end function none_of_its_own

   !> The part of a slip whose dilation depends on the normal stress, for walls that ride on their asperities: none.
   pure subroutine none_rides(self, state, du, slip, rides)
      class(joint_law_t), intent(in) :: self
      !> State at the start of the step
      type(joint_point_t), intent(in) :: state
      !> Slip of the step, and of it what rides [mm]
      real(wp), intent(in) :: du
      real(wp), intent(out) :: slip
      !> Does it, or is it about to?
      logical, intent(out) :: rides

      associate (unused => self, also => state, too => du)
      end associate
      slip = 0.0_wp
      rides = .false.
   end subroutine none_rides

   !> Dilation is taken at the closure of the start and that of the end of a step: the share of the end.
   pure real(wp) function middle(self) result(share)
      class(joint_law_t), intent(in) :: self

      associate (unused => self)
      end associate
      share = 0.5_wp
   end function middle

   !> Dilation of a slip that rides at a normal stress, with the derivatives by |slip|: none.
   pure function no_dilation(self, state, slip, sn) result(dilation)
      class(joint_law_t), intent(in) :: self
      !> State at the start of the slip
      type(joint_point_t), intent(in) :: state
      !> Slip that rides [mm], normal stress [MPa]
      real(wp), intent(in) :: slip, sn
      type(joint_dilation_t) :: dilation

      associate (unused => self, also => state, too => slip, as_well => sn)
      end associate
      dilation = joint_dilation_t()
   end function no_dilation

   !> Dilation [mm] of a joint whose |u| is at most u_max, or that slips on without contact, and its slope [-]: it stays.
   pure subroutine stay_dilated(self, state, u, dilation, slope)
      class(joint_law_t), intent(in) :: self
      type(joint_point_t), intent(in) :: state
      !> Shear displacement [mm]
      real(wp), intent(in) :: u
      real(wp), intent(out) :: dilation, slope

      associate (unused => self, also => u)
      end associate
      dilation = state%dilation
      slope = 0.0_wp
   end subroutine stay_dilated

end module joint_law_m
