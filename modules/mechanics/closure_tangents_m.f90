!> Closure by tangents: what Newton's method takes in place of the closure curves of joints while it is far from rest.
!>
!> The curves have an asymptote. Walls that an iteration closes by much would press without bounds, and steps that avoid it are
!> short. Each integration point therefore remembers a pressure. The tangent that touches the curve there gives a pressure for
!> the overlap; the tangent that touches at that pressure is the one that is used (press_on_tangent of joint_border_m). Pressures
!> come to the curve from below and are on it where the iteration settles: Newton's method for pressures and displacements
!> as unknowns side by side (Magisano, Leonetti and Garcea 2017).
module closure_tangents_m
   use kinds_m, only: wp
   use wall_contact_m, only: wall_meeting_t
   implicit none
   private

   type, public :: closure_tangents_t
      !> Are they in use?
      logical :: on = .false.
      !> Pressure at which the tangent of each integration point touches its curve (points) [MPa]
      real(wp), allocatable :: touch(:)
      !> The same an iteration before, with the wall edge and the first node of the surface edge of each point (points then)
      real(wp), allocatable, private :: touched(:)
      integer, allocatable, private :: wall(:), node(:)
   contains
      procedure :: begin
      procedure :: advance
      procedure :: carry
   end type closure_tangents_t

contains

   !> Tangents from here on: they touch where the walls press now.
   pure subroutine begin(self, met, pressure)
      class(closure_tangents_t), intent(inout) :: self
      type(wall_meeting_t), intent(in) :: met
      !> (points) [MPa]
      real(wp), intent(in) :: pressure(:)

      self%on = .true.
      self%touch = pressure
      call self%advance(met)
   end subroutine begin

   !> Trials that follow start from the tangents of the present one.
   pure subroutine advance(self, met)
      class(closure_tangents_t), intent(inout) :: self
      type(wall_meeting_t), intent(in) :: met

      self%touched = self%touch
      self%wall = met%wall(:met%points)
      self%node = met%point_node(3, :met%points)
   end subroutine advance

   !> The pressures remembered, for the points of now: of the two on a wall and an edge each goes on from its own. A new point
   !> starts from no pressure.
   pure subroutine carry(self, met)
      class(closure_tangents_t), intent(inout) :: self
      type(wall_meeting_t), intent(in) :: met
      integer :: k, first, i
      logical :: second

      self%touch = [(0.0_wp, k=1, met%points)]
      first = 1
      do k = 1, met%points
         do while (first <= size(self%touched))
            if (self%wall(first) >= met%wall(k)) exit
            first = first + 1
         end do
         second = .false.
         if (k > 1) second = met%wall(k - 1) == met%wall(k) .and. met%point_node(3, k - 1) == met%point_node(3, k)
         do i = first, size(self%touched)
            if (self%wall(i) /= met%wall(k)) exit
            if (self%node(i) /= met%point_node(3, k)) cycle
            self%touch(k) = self%touched(i)
            if (.not. second) exit
            second = .false.
         end do
      end do
   end subroutine carry

end module closure_tangents_m
