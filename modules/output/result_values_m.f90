!> Numbers that a run records of its model and state: a row of the history, and what of the joints does not change.
module result_values_m
   use kinds_m, only: wp
   use model_m, only: model_t
   use state_m, only: state_t
   use joints_m, only: joints_t
   use history_m, only: group_means, run_column, joint_column
   use field_list_m, only: field_list_t, on_joints
   use joint_law_m, only: law_result_t
   use run_checkpoint_m, only: place_t
   implicit none
   private

   public :: history_row, joint_constants, length_there

contains

   !> One row of the history, in the order of history_columns.
   pure function history_row(model, state, place, unbalanced) result(row)
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      real(wp), intent(in) :: unbalanced
      real(wp), allocatable :: row(:)
      real(wp), allocatable :: mean(:, :)
      real(wp) :: length(size(model%joints%length))

      length = length_there(model%joints)
      allocate (mean(size(joint_column), size(model%deck%joint)))
      associate (energy => state%energy, joint => state%joint)
         mean(1, :) = means(joint%u)
         ! Stresses are those on what is covered: so the means are force over length
         mean(2, :) = means(joint%tau*state%tractions%covered)
         mean(3, :) = means(joint%sn*state%tractions%covered)
         mean(4, :) = means(joint%dilation)
         mean(5, :) = means(joint%vn)
         mean(6, :) = means(state%aperture)
         allocate (row(size(run_column) + size(mean)))
         row = [state%time, real(state%step, wp), real(place%stage, wp), real(place%cycle, wp), energy%kinetic, &
                energy%strain, energy%contact, energy%friction, energy%walls(), energy%corners, energy%surfaces, &
                energy%fracture, energy%damping, energy%absorbed, energy%external, energy%residual(), unbalanced, mean]
      end associate

   contains

      pure function means(value)
         real(wp), intent(in) :: value(:)
         real(wp) :: means(size(model%deck%joint))

         means = group_means(size(model%deck%joint), model%joints%group, length, value)
      end function means

   end function history_row

   !> Properties of the joints that do not change: their law at the scale of their block edge.
   subroutine joint_constants(model, list)
      type(model_t), intent(in) :: model
      type(field_list_t), intent(out) :: list

      type(law_result_t), allocatable :: known(:), of_law(:)
      real(wp), allocatable :: value(:, :)
      integer :: i, j, k

      if (size(model%joints%law) == 0) return
      known = [law_result_t('effective_length', 'm', 'length Ln of the block edge: that used in the scaling, cracks their own')]
      do j = 1, size(model%joints%law)
         of_law = model%joints%law(j)%raw%results()
         do i = 1, size(of_law)
            if (.not. any(known%name == of_law(i)%name)) known = [known, of_law(i)]
         end do
      end do
      allocate (value(size(model%joints%law), size(known)), source=0.0_wp)
      do j = 1, size(model%joints%law)
         value(j, 1) = model%joints%length(j)
         associate (edge => model%topology%edge_of_joint(j))
            if (edge > 0) value(j, 1) = model%topology%edge_length(edge)
         end associate
         of_law = model%joints%law(j)%raw%results()
         do i = 1, size(of_law)
            k = findloc(known%name, of_law(i)%name, dim=1)
            value(j, k) = of_law(i)%value
            if (of_law(i)%name == 'kn_MPa_mm' .and. model%joints%penalty(j) > 0.0_wp) value(j, k) = model%joints%penalty(j)
         end do
      end do
      do k = 1, size(known)
         call list%add(trim(known(k)%name), trim(known(k)%unit), trim(known(k)%description)//of_others(k), on_joints, value(:, k))
      end do

   contains

      !> What joints have whose law does not know a value.
      function of_others(k) result(note)
         integer, intent(in) :: k
         character(len=:), allocatable :: note
         integer :: i

         note = ''
         do i = 1, size(model%joints%law)
            of_law = model%joints%law(i)%raw%results()
            if (k > 1 .and. .not. any(of_law%name == known(k)%name)) note = '; 0 on joints of other laws'
         end do
      end function of_others

   end subroutine joint_constants

   !> Length of each joint element, 0 where the rock beside it was taken out (joints) [m].
   pure function length_there(joints) result(length)
      type(joints_t), intent(in) :: joints
      real(wp) :: length(size(joints%length))

      length = merge(0.0_wp, joints%length, joints%gone)
   end function length_there

end module result_values_m
