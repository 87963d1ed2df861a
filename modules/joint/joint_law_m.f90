!> The joint laws behind one interface: one case a law in each verb below. A new law also needs its deck variables
!> (joint_group_m) and its scaling to a block edge (scene_m).
module joint_law_m
   use kinds_m, only: wp
   use joint_point_m, only: joint_point_t, joint_tangent_t, joint_slip_t, joint_dilation_t
   use jcm_m, only: jcm_edge_t, jcm_update, jcm_tangent, jcm_dilation, jcm_retrace
   use jcm_m, only: closure_stress, closure, normal_stiffness, elastic_shear_stiffness
   use coulomb_joint_m, only: coulomb_joint_t, coulomb_update, coulomb_tangent
   use coulomb_joint_m, only: coulomb_closure_stress, coulomb_closure, coulomb_normal_stiffness, coulomb_shear_stiffness
   implicit none
   private

   public :: joint_law_named, update_joint, joint_tangent
   public :: joint_dilation, joint_retrace
   public :: joint_closure_stress, joint_closure, joint_normal_stiffness, joint_shear_stiffness, joint_initial_aperture

   !> The laws. jcm_mean is jcm on edges that were all scaled to the mean block-edge length.
   integer, parameter, public :: law_unknown = 0, law_jcm = 1, law_jcm_mean = 2, law_coulomb = 3

   !> The law of one joint element (or of all joint elements of a block edge)
   type, public :: joint_law_t
      !> Which law
      integer :: kind = law_jcm
      !> Its parameters; only those of its kind count
      type(jcm_edge_t) :: jcm
      type(coulomb_joint_t) :: coulomb
   end type joint_law_t

contains

   !> The law a deck word names, law_unknown when it names none.
   pure integer function joint_law_named(word)
      !> Word from the deck, lower case
      character(len=*), intent(in) :: word

      select case (word)
      case ('jcm')
         joint_law_named = law_jcm
      case ('jcm_mean')
         joint_law_named = law_jcm_mean
      case ('coulomb')
         joint_law_named = law_coulomb
      case default
         joint_law_named = law_unknown
      end select
   end function joint_law_named

   !> Advance one joint element by a slip du to a new normal stress.
   pure subroutine update_joint(law, du, sn, state, path)
      type(joint_law_t), intent(in) :: law
      !> Slip of the step [mm], normal stress at its end (<= 0: open) [MPa]
      real(wp), intent(in) :: du, sn
      type(joint_point_t), intent(inout) :: state
      !> Stresses under which walls that ride on their asperities slip; the end's when not given
      type(joint_slip_t), intent(in), optional :: path

      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         call jcm_update(law%jcm, du, sn, state, path)
      case (law_coulomb)
         call coulomb_update(law%coulomb, du, sn, state)
      end select
   end subroutine update_joint

   !> Tangent of the last step.
   pure function joint_tangent(law, state, path) result(tangent)
      type(joint_law_t), intent(in) :: law
      type(joint_point_t), intent(in) :: state
      !> As for update_joint
      type(joint_slip_t), intent(in), optional :: path
      type(joint_tangent_t) :: tangent

      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         tangent = jcm_tangent(law%jcm, state, path)
      case (law_coulomb)
         tangent = coulomb_tangent(law%coulomb, state)
      end select
   end function joint_tangent

   !> Dilation of a slip beyond u_max at a normal stress.
   pure function joint_dilation(law, state, slip, sn) result(dilation)
      type(joint_law_t), intent(in) :: law
      !> State at the start of the slip
      type(joint_point_t), intent(in) :: state
      !> Slip beyond u_max [mm], normal stress [MPa]
      real(wp), intent(in) :: slip, sn
      type(joint_dilation_t) :: dilation

      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         dilation = jcm_dilation(law%jcm, state, slip, sn)
      end select
   end function joint_dilation

   !> Dilation [mm] of a joint whose |u| is at most u_max, or that slips on without contact, and its slope [-].
   pure subroutine joint_retrace(law, state, u, dilation, slope)
      type(joint_law_t), intent(in) :: law
      type(joint_point_t), intent(in) :: state
      !> Shear displacement [mm]
      real(wp), intent(in) :: u
      real(wp), intent(out) :: dilation, slope

      dilation = state%dilation
      slope = 0.0_wp
      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         call jcm_retrace(law%jcm, state, u, dilation, slope)
      end select
   end subroutine joint_retrace

   !> Normal stress of a closure vn [MPa].
   pure real(wp) function joint_closure_stress(law, vn) result(sn)
      type(joint_law_t), intent(in) :: law
      !> Closure by normal stress [mm]
      real(wp), intent(in) :: vn

      sn = 0.0_wp
      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         sn = closure_stress(law%jcm%kn0, law%jcm%vm, vn)
      case (law_coulomb)
         sn = coulomb_closure_stress(law%coulomb, vn)
      end select
   end function joint_closure_stress

   !> Closure under a normal stress [mm], the inverse of joint_closure_stress; none when open.
   pure real(wp) function joint_closure(law, sn) result(vn)
      type(joint_law_t), intent(in) :: law
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      vn = 0.0_wp
      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         vn = closure(law%jcm%kn0, law%jcm%vm, sn)
      case (law_coulomb)
         vn = coulomb_closure(law%coulomb, sn)
      end select
   end function joint_closure

   !> Normal stiffness at a normal stress, for the stable step; that of first touch when open [MPa/mm].
   pure real(wp) function joint_normal_stiffness(law, sn) result(stiffness)
      type(joint_law_t), intent(in) :: law
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      stiffness = 0.0_wp
      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         stiffness = normal_stiffness(law%jcm%kn0, law%jcm%vm, sn)
      case (law_coulomb)
         stiffness = coulomb_normal_stiffness(law%coulomb, sn)
      end select
   end function joint_normal_stiffness

   !> Elastic shear stiffness at a normal stress, for the stable step [MPa/mm].
   pure real(wp) function joint_shear_stiffness(law, sn) result(stiffness)
      type(joint_law_t), intent(in) :: law
      !> Normal stress [MPa]
      real(wp), intent(in) :: sn

      stiffness = 0.0_wp
      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         stiffness = elastic_shear_stiffness(law%jcm, sn)
      case (law_coulomb)
         stiffness = coulomb_shear_stiffness(law%coulomb, sn)
      end select
   end function joint_shear_stiffness

   !> Initial aperture [mm].
   pure real(wp) function joint_initial_aperture(law) result(a0)
      type(joint_law_t), intent(in) :: law

      a0 = 0.0_wp
      select case (law%kind)
      case (law_jcm, law_jcm_mean)
         a0 = law%jcm%a0
      case (law_coulomb)
         a0 = law%coulomb%a0
      end select
   end function joint_initial_aperture

end module joint_law_m
