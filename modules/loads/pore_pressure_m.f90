!> Fluid pressure in rock and fractures as nodal loads.
!>
!> The stresses the program computes are those of the skeleton: total stress = skeleton stress - biot p I in the rock,
!> and sn + p across a fracture, sn being what its walls press on each other with. So the pressure pushes the rock from
!> inside with biot p and the two walls of a fracture apart with p. Where the same pressure with Biot coefficient 1 is in
!> both, effective stress = total stress - p everywhere, in the rock and on the joints.
!> Like tractions, these are dead loads: they keep the direction that rock and walls had before any motion.
module pore_pressure_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t, find_group
   use pore_pressure_group_m, only: pore_pressure_t, every_place
   use loads_m, only: loads_t, stage_number
   implicit none
   private

   public :: add_pore_pressure

contains

   !> Add the pressures in force at the end of a stage to its loads: for each group what was given last, for this stage or
   !> one before it, else for all stages.
   subroutine add_pore_pressure(split, pore, stage_name, stage, loads)
      type(split_mesh_t), intent(in) :: split
      type(pore_pressure_t), intent(in) :: pore(:)
      !> Names of all stages in order, and the number of the one that starts
      character(len=*), intent(in) :: stage_name(:)
      integer, intent(in) :: stage
      type(loads_t), intent(inout) :: loads
      integer :: given_in(size(pore)), i

      if (size(pore) == 0) return
      given_in = [(stage_number(stage_name, pore(i)%stage), i=1, size(pore))]
      do i = 1, size(pore)
         if (given_in(i) > stage) cycle
         if (any(pore%group == pore(i)%group .and. given_in > given_in(i) .and. given_in <= stage)) cycle
         call press_rock(split, pore(i), loads%dead_end)
         call press_walls(split, pore(i), loads%dead_end)
      end do
      loads%dead_changes = any(abs(loads%dead_end - loads%dead_start) > 0.0_wp)
   end subroutine add_pore_pressure

   !> Push the rock of a group from inside: biot p A grad N at the corners of each triangle.
   subroutine press_rock(split, pore, force)
      type(split_mesh_t), intent(in) :: split
      type(pore_pressure_t), intent(in) :: pore
      !> Nodal loads (2, nodes) [N per m of thickness]
      real(wp), intent(inout) :: force(:, :)
      real(wp) :: opposite(2)
      integer :: e, i, group

      group = find_group(split%group, pore%group, 2)
      do e = 1, size(split%triangle, 2)
         if (pore%group /= every_place .and. split%triangle_group(e) /= group) cycle
         associate (node => split%triangle(:, e))
            do i = 1, 3
               opposite = split%x(:, node(mod(i + 1, 3) + 1)) - split%x(:, node(mod(i, 3) + 1))
               ! A grad N is half the opposite edge, turned inwards
               force(:, node(i)) = force(:, node(i)) + 0.5_wp*pore%biot*pore%pressure*[-opposite(2), opposite(1)]
            end do
         end associate
      end do
   end subroutine press_rock

   !> Push the walls of a group's fractures apart, each into its rock.
   subroutine press_walls(split, pore, force)
      type(split_mesh_t), intent(in) :: split
      type(pore_pressure_t), intent(in) :: pore
      !> Nodal loads (2, nodes) [N per m of thickness]
      real(wp), intent(inout) :: force(:, :)
      real(wp) :: along(2), half_push(2)
      integer :: e, i, group

      group = find_group(split%group, pore%group, 1)
      do e = 1, size(split%surface, 2)
         associate (joint => split%surface_joint(e))
            if (joint == 0) cycle
            if (pore%group /= every_place .and. split%joint_group(joint) /= group) cycle
         end associate
         along = split%x(:, split%surface(2, e)) - split%x(:, split%surface(1, e))
         ! The rock is on the left of the edge
         half_push = 0.5_wp*pore%pressure*[-along(2), along(1)]
         do i = 1, 2
            force(:, split%surface(i, e)) = force(:, split%surface(i, e)) + half_push
         end do
      end do
   end subroutine press_walls

end module pore_pressure_m
