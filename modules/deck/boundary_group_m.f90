!> The group &boundary: a velocity, traction, pressure, far-field stress or dashpots on a physical group of the mesh.
module boundary_group_m
   use kinds_m, only: wp
   use constants_m, only: unset, is_set
   use bounds_m, only: least_size, fastest, most_stress
   use errors_m, only: error_list_t
   use text_m, only: quoted, to_text
   use deck_scan_m, only: group_slice_t
   use deck_variable_m, only: name_length, check_given, check_needed, check_size
   use group_variables_m, only: group_variables_t
   implicit none
   private

   public :: read_boundary, write_boundary, prescribed, check_clash, all_prescribed

   !> What a boundary can prescribe, and the indices of the velocity, of the loads on edges and of the far-field stress
   character(len=*), parameter, public :: prescribable(*) = &
                                          [character(len=9) :: 'vx', 'vy', 'tx', 'ty', 'pressure', 'sxx', 'syy', 'sxy', 'absorbing']
   integer, parameter :: velocities(*) = [1, 2], stresses(*) = [6, 7, 8]
   !> Indices of the loads, and of all that acts on edges
   integer, parameter, public :: loads(*) = [3, 4, 5, 6, 7, 8], on_edges(*) = [loads, 9]
   !> Stage of a boundary that acts in every stage
   character(len=*), parameter, public :: every_stage = 'all'

   !> &boundary
   type, public :: boundary_t
      !> Line of the deck on which the group starts (0: not in the deck)
      integer :: line = 0
      !> Physical point, curve or surface of the mesh
      character(len=name_length) :: group = ''
      !> Stage in which it acts
      character(len=name_length) :: stage = 'all'
      !> Prescribed velocity in x [m/s]
      real(wp) :: vx = unset
      !> Prescribed velocity in y [m/s]
      real(wp) :: vy = unset
      !> Traction in x [Pa]
      real(wp) :: tx = unset
      !> Traction in y [Pa]
      real(wp) :: ty = unset
      !> Pressure on the edges, compression positive [Pa]
      real(wp) :: pressure = unset
      !> Far-field stress xx, compression positive [Pa]
      real(wp) :: sxx = unset
      !> Far-field stress yy, compression positive [Pa]
      real(wp) :: syy = unset
      !> Far-field stress xy; 0 when only sxx and syy are given [Pa]
      real(wp) :: sxy = unset
      !> Do waves leave through the edges?
      logical :: absorbing = .false.
   end type boundary_t

contains

   !> Read and check the group.
   subroutine read_boundary(slice, boundary, errors)
      !> The group as written
      type(group_slice_t), intent(in) :: slice
      !> Its settings
      type(boundary_t), intent(out) :: boundary
      type(error_list_t), intent(inout) :: errors
      type(group_variables_t) :: variables

      boundary%line = slice%line
      call variables%read(slice)
      call name_variables(variables, boundary)
      call variables%end_reading(errors)
      if (is_set(boundary%sxx) .and. is_set(boundary%syy) .and. .not. is_set(boundary%sxy)) boundary%sxy = 0.0_wp
      call check_boundary(slice, boundary, errors)
   end subroutine read_boundary

   !> The variables, for reading and writing.
   subroutine name_variables(variables, boundary)
      type(group_variables_t), intent(inout) :: variables
      type(boundary_t), intent(inout) :: boundary

      call variables%keep('group', boundary%group)
      call variables%keep('stage', boundary%stage)
      call variables%keep('vx', boundary%vx, 'free in x')
      call variables%keep('vy', boundary%vy, 'free in y')
      call variables%keep('tx', boundary%tx)
      call variables%keep('ty', boundary%ty)
      call variables%keep('pressure', boundary%pressure)
      call variables%keep('sxx', boundary%sxx)
      call variables%keep('syy', boundary%syy)
      call variables%keep('sxy', boundary%sxy)
      call variables%keep('absorbing', boundary%absorbing)
   end subroutine name_variables

   !> The boundary has a place and a stage, prescribes something, and nothing twice.
   subroutine check_boundary(slice, boundary, errors)
      type(group_slice_t), intent(in) :: slice
      type(boundary_t), intent(in) :: boundary
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: place
      logical :: given(size(prescribable))

      place = slice%path//':'//to_text(slice%line)//': &boundary '
      given = prescribed(boundary)
      call check_given(errors, slice, 'group', boundary%group, 'a physical point, curve or surface of the mesh')
      call check_given(errors, slice, 'stage', boundary%stage, 'the name of a stage, or '//quoted(every_stage))
      if (.not. any(given)) call errors%add(place//'prescribes nothing: give at least one of '//all_prescribed())
      call check_size(errors, slice, 'vx', boundary%vx, least_size, fastest)
      call check_size(errors, slice, 'vy', boundary%vy, least_size, fastest)
      call check_size(errors, slice, 'tx', boundary%tx, least_size, most_stress)
      call check_size(errors, slice, 'ty', boundary%ty, least_size, most_stress)
      call check_size(errors, slice, 'pressure', boundary%pressure, least_size, most_stress)
      call check_size(errors, slice, 'sxx', boundary%sxx, least_size, most_stress)
      call check_size(errors, slice, 'syy', boundary%syy, least_size, most_stress)
      call check_size(errors, slice, 'sxy', boundary%sxy, least_size, most_stress)
      if (any(given(stresses))) then
         call check_needed(errors, slice, 'sxx', boundary%sxx, 'a far-field stress')
         call check_needed(errors, slice, 'syy', boundary%syy, 'a far-field stress')
      end if
      if (any(given(velocities)) .and. any(given(loads))) then
         call errors%add(place//'prescribes a velocity and a load: must be one or the other; write '// &
                         'two &boundary groups')
      else
         call check_clash(place, given, given, '', errors)
      end if
   end subroutine check_boundary

   !> Which of the prescribable variables does a boundary give?
   pure function prescribed(boundary)
      type(boundary_t), intent(in) :: boundary
      logical :: prescribed(size(prescribable))

      prescribed = [is_set([boundary%vx, boundary%vy, boundary%tx, boundary%ty, boundary%pressure, &
                            boundary%sxx, boundary%syy, boundary%sxy]), boundary%absorbing]
   end function prescribed

   !> Names of all prescribable variables, for a message.
   pure function all_prescribed() result(names)
      character(len=:), allocatable :: names
      integer :: i

      names = trim(prescribable(1))
      do i = 2, size(prescribable)
         names = names//', '//trim(prescribable(i))
      end do
   end function all_prescribed

   !> A velocity and a traction in the same direction or dashpots, or a far-field stress and any other load or velocity, cannot both
   !> hold.
   subroutine check_clash(place, mine, others, where, errors)
      !> Start of the message
      character(len=*), intent(in) :: place
      !> Variables that this boundary gives, and another one (or itself) (size(prescribable))
      logical, intent(in) :: mine(:), others(:)
      !> Where the other one stands, for the message
      character(len=*), intent(in) :: where
      type(error_list_t), intent(inout) :: errors
      !> Pairs that exclude each other, as indices into prescribable
      integer, parameter :: first(*) = [1, 2, 1, 2, 6, 6, 6, 6, 6], second(*) = [3, 4, 9, 9, 3, 4, 5, 1, 2]
      integer :: i

      do i = 1, size(first)
         if ((mine(first(i)) .and. others(second(i))) .or. (mine(second(i)) .and. others(first(i)))) then
            call errors%add(place//trim(prescribable(first(i)))//' and '//trim(prescribable(second(i)))//where// &
                            ': cannot both be prescribed; leave out one of them')
         end if
      end do
   end subroutine check_clash

   !> Write the effective group, every variable.
   subroutine write_boundary(boundary, unit)
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: unit
      type(group_variables_t) :: variables
      type(boundary_t) :: effective

      effective = boundary
      call variables%write(unit, 'boundary')
      call name_variables(variables, effective)
      call variables%end_writing()
   end subroutine write_boundary

end module boundary_group_m
