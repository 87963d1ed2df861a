!> The table of what a snapshot holds: name, unit, description, place and values. One line adds a field.
module field_list_m
   use constants_m, only: radians
   use errors_m, only: error_list_t
   use kinds_m, only: wp
   use text_m, only: to_text, quoted
   implicit none
   private

   public :: principal_stresses

   !> Where the values of a field live
   integer, parameter, public :: on_nodes = 1, on_triangles = 2, on_joints = 3
   !> Their names in the file
   character(len=9), parameter, public :: place_name(3) = [character(len=9) :: 'nodes', 'triangles', 'joints']
   !> Components of a vector in the file: a zero third one, without which ParaView does not take it as a vector
   integer, parameter, public :: vector_components = 3

   !> One field
   type, public :: field_t
      character(len=:), allocatable :: name, unit, description
      !> on_nodes, on_triangles or on_joints
      integer :: place = on_nodes
      !> Values (1, entities) of a scalar, (3, entities) of a vector
      real(wp), allocatable :: value(:, :)
   end type field_t

   !> The table
   type, public :: field_list_t
      integer :: n = 0
      type(field_t), allocatable :: field(:)
   contains
      procedure, private :: add_scalar, add_vector
      !> add(name, unit, description, place, value): value(entities) or value(2, entities)
      generic :: add => add_scalar, add_vector
      procedure :: add_stress
      procedure :: check
   end type field_list_t

contains

   subroutine add_scalar(self, name, unit, description, place, value)
      class(field_list_t), intent(inout) :: self
      !> Name of the dataset, ending in its unit where that is not SI; unit; one line that says what it is
      character(len=*), intent(in) :: name, unit, description
      !> on_nodes, on_triangles or on_joints
      integer, intent(in) :: place
      !> One value an entity
      real(wp), intent(in) :: value(:)

      call make_room(self)
      self%n = self%n + 1
      self%field(self%n) = field_t(name, unit, description, place, reshape(value, [1, size(value)]))
   end subroutine add_scalar

   subroutine add_vector(self, name, unit, description, place, value)
      class(field_list_t), intent(inout) :: self
      character(len=*), intent(in) :: name, unit, description
      integer, intent(in) :: place
      !> x and y components (2, entities)
      real(wp), intent(in) :: value(:, :)
      real(wp), allocatable :: padded(:, :)

      allocate (padded(vector_components, size(value, 2)))
      padded(:2, :) = value(:2, :)
      padded(3, :) = 0.0_wp
      call make_room(self)
      self%n = self%n + 1
      self%field(self%n) = field_t(name, unit, description, place, padded)
   end subroutine add_vector

   !> Stresses of the triangles, their principal values and direction: six fields, all with compression positive.
   subroutine add_stress(self, stress)
      class(field_list_t), intent(inout) :: self
      !> sxx, syy, sxy, tension positive as the rock's law has them [Pa] (3, triangles)
      real(wp), intent(in) :: stress(:, :)
      real(wp) :: largest(size(stress, 2)), least(size(stress, 2)), angle(size(stress, 2))

      call principal_stresses(-stress, largest, least, angle)
      call self%add('stress_xx', 'Pa', 'Normal stress in x, compression positive', on_triangles, -stress(1, :))
      call self%add('stress_yy', 'Pa', 'Normal stress in y, compression positive', on_triangles, -stress(2, :))
      call self%add('stress_xy', 'Pa', 'Shear stress of the compression-positive tensor (minus the usual tau_xy)', &
                    on_triangles, -stress(3, :))
      call self%add('stress_1', 'Pa', 'Largest principal compression in the plane', on_triangles, largest)
      call self%add('stress_3', 'Pa', 'Least principal compression in the plane', on_triangles, least)
      call self%add('stress_1_angle_deg', 'degree', 'Direction of the largest compression, anticlockwise from x', &
                    on_triangles, angle)
   end subroutine add_stress

   !> Principal values and direction of plane stress tensors.
   pure subroutine principal_stresses(stress, largest, least, angle)
      !> sxx, syy, sxy (3, points)
      real(wp), intent(in) :: stress(:, :)
      !> Algebraically largest and least value, in the unit of the stress (points)
      real(wp), intent(out) :: largest(:), least(:)
      !> Direction of the largest, anticlockwise from x, above -90 to 90 [degrees] (points)
      real(wp), intent(out) :: angle(:)
      real(wp) :: mean, difference, radius
      integer :: i

      do i = 1, size(stress, 2)
         mean = 0.5_wp*(stress(1, i) + stress(2, i))
         difference = 0.5_wp*(stress(1, i) - stress(2, i))
         radius = hypot(difference, stress(3, i))
         largest(i) = mean + radius
         least(i) = mean - radius
         angle(i) = 0.0_wp
         if (radius > 0.0_wp) angle(i) = 0.5_wp*atan2(stress(3, i), difference)/radians
      end do
   end subroutine principal_stresses

   !> Every field must have as many values as its place has entities.
   subroutine check(self, entities, errors)
      class(field_list_t), intent(in) :: self
      !> Number of nodes, triangles, joints
      integer, intent(in) :: entities(3)
      type(error_list_t), intent(inout) :: errors
      integer :: i

      do i = 1, self%n
         associate (field => self%field(i))
            if (size(field%value, 2) /= entities(field%place)) call errors%add('field '//quoted(field%name)//': '// &
                                              to_text(size(field%value, 2))//' values for '//to_text(entities(field%place))//' '// &
                                                                               trim(place_name(field%place)))
         end associate
      end do
   end subroutine check

   !> Room for one more field.
   subroutine make_room(self)
      type(field_list_t), intent(inout) :: self
      integer, parameter :: room_at_start = 16
      type(field_t), allocatable :: longer(:)

      if (.not. allocated(self%field)) allocate (self%field(room_at_start))
      if (self%n < size(self%field)) return
      allocate (longer(2*self%n))
      longer(:self%n) = self%field
      call move_alloc(longer, self%field)
   end subroutine make_room

end module field_list_m
