!> The joint laws there are. A new law is one more `use` and one more case here.
module law_list_m
   use kinds_m, only: wp
   use coulomb_law_m, only: coulomb_law_t
   use dilatant_coulomb_law_m, only: dilatant_coulomb_law_t
   use jcm_law_m, only: jcm_law_t, jcm_mean_law_t
   use joint_law_m, only: joint_law_t
   use law_variable_m, only: law_variable_t, law_settings_t, same_variable, word_length
   implicit none
   private

   public :: new_law, scaled_law, all_variables

   !> Their names in the deck, the default first
   character(len=word_length), parameter, public :: law_names(*) = [character(len=word_length) :: &
                                                                    'jcm', 'jcm_mean', 'coulomb', 'dilatant_coulomb']

contains

   !> A law by its name, not scaled; not allocated when there is none of this name.
   subroutine new_law(name, law)
      !> Name in the deck, lower case
      character(len=*), intent(in) :: name
      class(joint_law_t), allocatable, intent(out) :: law

      select case (name)
      case ('jcm')
         allocate (jcm_law_t :: law)
      case ('jcm_mean')
         allocate (jcm_mean_law_t :: law)
      case ('coulomb')
         allocate (coulomb_law_t :: law)
      case ('dilatant_coulomb')
         allocate (dilatant_coulomb_law_t :: law)
      end select
   end subroutine new_law

   !> A law by its name, at the scale of a block edge.
   subroutine scaled_law(name, settings, edge_length, mean_length, law)
      !> Name in the deck
      character(len=*), intent(in) :: name
      type(law_settings_t), intent(in) :: settings
      !> Length of its block edge, mean length of the group's block edges [m]
      real(wp), intent(in) :: edge_length, mean_length
      class(joint_law_t), allocatable, intent(out) :: law

      call new_law(name, law)
      if (allocated(law)) call law%scale(settings, edge_length, mean_length)
   end subroutine scaled_law

   !> Variables of all laws, each once.
   function all_variables() result(variables)
      type(law_variable_t), allocatable :: variables(:), more(:)
      class(joint_law_t), allocatable :: law
      integer :: i, k

      allocate (variables(0))
      do i = 1, size(law_names)
         call new_law(law_names(i), law)
         more = law%variables()
         do k = 1, size(more)
            if (.not. any(same_variable(variables, more(k)))) variables = [variables, more(k)]
         end do
      end do
   end function all_variables

end module law_list_m
