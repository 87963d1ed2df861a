!> Fluid pressure in rock and fractures as nodal loads.
!>
!> The stresses the program computes are those of the skeleton: total stress = skeleton stress - biot p I in the rock,
!> and sn + p across a fracture, sn being what its walls press on each other with. So the pressure pushes the rock from
!> inside with biot p and the two walls of a fracture apart with p. Where the same pressure with Biot coefficient 1 is in
!> both, effective stress = total stress - p everywhere, in the rock and on the joints. Cracks belong to the rock they are in:
!> while a bond holds it carries what the rock would, and once it has broken the fluid of the rock is in the crack.
!> Like tractions, these are dead loads: they keep the direction that rock and walls had before any motion.
module pore_pressure_m
   use kinds_m, only: wp
   use mesh_m, only: split_mesh_t
   use pore_pressure_group_m, only: pore_pressure_t, every_place
   use loads_m, only: loads_t, stage_number
   implicit none
   private

   public :: add_pore_pressure, press_rock, press_walls, rock_growth

contains

   !> Add the pressures in force at the end of a stage to its loads.
   subroutine add_pore_pressure(split, pore, stage_name, stage, filled, loads)
      type(split_mesh_t), intent(in) :: split
      type(pore_pressure_t), intent(in) :: pore(:)
      !> Names of all stages in order, and the number of the one that starts
      character(len=*), intent(in) :: stage_name(:)
      integer, intent(in) :: stage
      !> Can fluid be between the walls? Not where a bond holds them together (joints)
      logical, intent(in) :: filled(:)
      type(loads_t), intent(inout) :: loads
      real(wp), allocatable :: in_rock(:), in_crack(:)

      if (size(pore) == 0) return
      call find_pressures(split, pore, stage_name, stage, in_rock, in_crack)
      call press_rock(split, in_rock, loads%dead_end)
      call press_walls(split, in_rock, in_crack, filled, loads%dead_end)
      loads%dead_changes = any(abs(loads%dead_end - loads%dead_start) > 0.0_wp)
   end subroutine add_pore_pressure

   !> Pressures in force: for each group what was given last, for this stage or one before it, else for all stages; a group
   !> that none is given for has that of 'all'.
   subroutine find_pressures(split, pore, stage_name, stage, in_rock, in_crack)
      type(split_mesh_t), intent(in) :: split
      type(pore_pressure_t), intent(in) :: pore(:)
      character(len=*), intent(in) :: stage_name(:)
      integer, intent(in) :: stage
      !> biot p in each triangle; p between the walls of each joint element, if fluid gets there [Pa]
      real(wp), allocatable, intent(out) :: in_rock(:), in_crack(:)
      real(wp) :: pressure(size(split%group)), biot(size(split%group))
      integer :: given_in(size(pore)), latest, latest_all, g, i

      given_in = [(stage_number(stage_name, pore(i)%stage), i=1, size(pore))]
      pressure = 0.0_wp
      biot = 0.0_wp
      latest_all = maxloc(given_in, mask=given_in <= stage .and. pore%group == every_place, dim=1)
      do g = 1, size(split%group)
         latest = maxloc(given_in, mask=given_in <= stage .and. pore%group == split%group(g)%name, dim=1)
         if (latest == 0) latest = latest_all
         if (latest == 0) cycle
         pressure(g) = pore(latest)%pressure
         biot(g) = pore(latest)%biot
      end do
      in_rock = biot(split%triangle_group)*pressure(split%triangle_group)
      allocate (in_crack(size(split%joint, 2)))
      do i = 1, size(in_crack)
         if (split%joint_group(i) > 0) then
            in_crack(i) = pressure(split%joint_group(i))
         else
            ! A crack on the border of two rocks is filled from the one with the higher pressure
            in_crack(i) = maxval(pressure(split%triangle_group(split%joint_triangle(:, i))))
         end if
      end do
   end subroutine find_pressures

   !> Push the rock from inside: biot p A grad N at the corners of each triangle.
   subroutine press_rock(split, in_rock, force)
      type(split_mesh_t), intent(in) :: split
      !> biot p (triangles) [Pa]
      real(wp), intent(in) :: in_rock(:)
      !> Nodal loads (2, nodes) [N per m of thickness]
      real(wp), intent(inout) :: force(:, :)
      real(wp) :: opposite(2)
      integer :: e, i

      do e = 1, size(split%triangle, 2)
         associate (node => split%triangle(:, e))
            do i = 1, 3
               opposite = split%x(:, node(mod(i + 1, 3) + 1)) - split%x(:, node(mod(i, 3) + 1))
               ! A grad N is half the opposite edge, turned inwards
               force(:, node(i)) = force(:, node(i)) + 0.5_wp*in_rock(e)*[-opposite(2), opposite(1)]
            end do
         end associate
      end do
   end subroutine press_rock

   !> What the triangles have gained in area, to first order: what press_rock does work on (triangles) [m2].
   pure function rock_growth(split, u) result(growth)
      type(split_mesh_t), intent(in) :: split
      !> Displacement (2, nodes) [m]
      real(wp), intent(in) :: u(:, :)
      real(wp) :: growth(size(split%triangle, 2))
      real(wp) :: opposite(2)
      integer :: e, i

      growth = 0.0_wp
      do e = 1, size(growth)
         associate (node => split%triangle(:, e))
            do i = 1, 3
               opposite = split%x(:, node(mod(i + 1, 3) + 1)) - split%x(:, node(mod(i, 3) + 1))
               growth(e) = growth(e) + 0.5_wp*(opposite(1)*u(2, node(i)) - opposite(2)*u(1, node(i)))
            end do
         end associate
      end do
   end function rock_growth

   !> Push walls apart, each into its rock: with the pressure of the fluid between them, or, where a bond still holds them
   !> together, with biot p, so that the bond carries the stress that the rock would carry in its place.
   subroutine press_walls(split, in_rock, in_crack, filled, force)
      type(split_mesh_t), intent(in) :: split
      !> biot p (triangles), p (joints) [Pa]
      real(wp), intent(in) :: in_rock(:), in_crack(:)
      logical, intent(in) :: filled(:)
      !> Nodal loads (2, nodes) [N per m of thickness]
      real(wp), intent(inout) :: force(:, :)
      real(wp) :: along(2), half_push(2), push
      integer :: e, i

      do e = 1, size(split%surface, 2)
         associate (joint => split%surface_joint(e))
            if (joint == 0) cycle
            push = in_crack(joint)
            ! Opposite on the two walls, so that the loads of rock that is whole stay what they are
            if (.not. filled(joint)) push = 0.5_wp*sum(in_rock(split%joint_triangle(:, joint)))
         end associate
         along = split%x(:, split%surface(2, e)) - split%x(:, split%surface(1, e))
         ! The rock is on the left of the edge
         half_push = 0.5_wp*push*[-along(2), along(1)]
         do i = 1, 2
            force(:, split%surface(i, e)) = force(:, split%surface(i, e)) + half_push
         end do
      end do
   end subroutine press_walls

end module pore_pressure_m
