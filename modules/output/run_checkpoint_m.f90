!> What a checkpoint keeps of a run: a pair of routines, save and load, for each part of it. Nothing is kept that follows from
!> deck and mesh, or that the first forces find anew.
module run_checkpoint_m
   use kinds_m, only: wp
   use errors_m, only: error_list_t
   use text_m, only: to_text
   use checkpoint_m, only: checkpoint_t, fingerprint_t, text_hash, numbers_hash
   use deck_record_m, only: deck_record, whole_record, compare_records
   use bonds_m, only: bond_values, restore_bonds, event_values, restore_events, bond_value_count
   use joint_point_m, only: joint_values, joint_from_values, joint_value_count
   use recut_m, only: recut, restore_walls
   use scene_m, only: scene_t
   use state_m, only: state_t
   use wall_contact_m, only: walls_touching
   implicit none
   private

   !> Where a run stands
   type, public :: place_t
      !> Stage and cycle that have been completed (0: none yet)
      integer :: stage = 0, cycle = 0
   end type place_t

   public :: save_run, load_run

contains

   !> Save all that changes during a run.
   subroutine save_run(path, scene, state, place, errors)
      character(len=*), intent(in) :: path
      type(scene_t), intent(in) :: scene
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      type(error_list_t), intent(inout) :: errors
      type(checkpoint_t) :: file

      call file%create(path, fingerprint_of(scene))
      call file%save('deck', deck_record(scene%deck, place%stage, place%cycle, has_cracks(scene)))
      call file%save('whole_deck', whole_record(scene%deck))
      call save_cracks(file, scene, state)
      call save_motion(file, state, place)
      call save_joints(file, state)
      call save_contact(file, scene, state)
      call file%close(errors)
   end subroutine save_run

   !> Take the state of a checkpoint, in the order of its parts: cracks come first, they make the mesh that the others are on.
   subroutine load_run(path, branch, scene, state, place, errors)
      character(len=*), intent(in) :: path
      !> May later stages, solver and its settings differ from those of the run that wrote it?
      logical, intent(in) :: branch
      !> As it was built from deck and mesh
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state
      !> Stage and cycle that were completed
      type(place_t), intent(out) :: place
      type(error_list_t), intent(inout) :: errors
      type(checkpoint_t) :: file

      call file%open(path, fingerprint_of(scene), errors)
      if (errors%any()) return
      call compare_decks(file, path, branch, scene, errors)
      call load_cracks(file, path, scene, state, errors)
      if (.not. errors%any()) call load_motion(file, state, place, errors)
      if (.not. errors%any()) call load_joints(file, state, errors)
      if (.not. errors%any()) call load_contact(file, path, scene, state, errors)
      call file%close(errors)
   end subroutine load_run

   !> The deck must agree with the one that the checkpoint was written with: in all that the results depend on, or, for a branch,
   !> in what its state depends on.
   subroutine compare_decks(file, path, branch, scene, errors)
      type(checkpoint_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      logical, intent(in) :: branch
      type(scene_t), intent(in) :: scene
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: before, whole
      integer, allocatable :: crack(:)
      type(place_t) :: place
      type(error_list_t) :: of_state

      call file%load('deck', before, errors)
      call file%load('whole_deck', whole, errors)
      call file%load('crack_edges', crack, errors)
      call file%load('stage', place%stage, errors)
      call file%load('cycle', place%cycle, errors)
      if (errors%any()) return
      if (place%stage > size(scene%deck%stage)) then
         call errors%add(path//': was written in stage '//to_text(place%stage)//', and this deck has '// &
                         to_text(size(scene%deck%stage))//' stages')
         return
      end if
      call compare_records(path, before, deck_record(scene%deck, place%stage, place%cycle, size(crack) > 0), .false., of_state)
      if (branch) then
         call errors%append(of_state)
         return
      end if
      call compare_records(path, whole, whole_record(scene%deck), .true., errors)
      if (errors%any() .and. .not. of_state%any()) &
         call errors%add(path//': --restart goes on with the same run; --branch in its place goes on with other stages, loads '// &
                         'to come, solver or settings of a solver on purpose')
   end subroutine compare_decks

   !> Are there cohesive joints?
   pure logical function has_cracks(scene)
      type(scene_t), intent(in) :: scene

      has_cracks = any(scene%cut%group == 0)
   end function has_cracks

   !> Sizes and content of the mesh before any crack, which a checkpoint must agree with.
   function fingerprint_of(scene) result(fingerprint)
      type(scene_t), intent(in) :: scene
      type(fingerprint_t) :: fingerprint
      character(len=:), allocatable :: names
      integer :: i, fractures

      associate (mesh => scene%whole)
         fractures = count(scene%cut%group > 0)
         fingerprint%nodes = size(mesh%x, 2)
         fingerprint%triangles = size(mesh%triangle, 2)
         fingerprint%joints = fractures
         fingerprint%places = numbers_hash([transfer(mesh%datum, [0]), transfer(mesh%x, [0])])
         fingerprint%corners = numbers_hash([reshape(mesh%triangle, [size(mesh%triangle)]), &
                                             reshape(scene%cut%node(:, :fractures), [2*fractures])])
         names = ''
         do i = 1, size(mesh%group)
            names = names//trim(mesh%group(i)%name)//new_line('a')//to_text(mesh%group(i)%dimension)//new_line('a')
         end do
         fingerprint%groups = text_hash(names//numbers_hash([mesh%triangle_group, scene%cut%group(:fractures), &
                                                             scene%split%surface_group(:count(scene%split%surface_joint == 0))]))
      end associate
   end function fingerprint_of

   ! ---- Cracks ------------------------------------------------------------------------------------------------------

   !> Edges of the mesh that became bonds, in their order; the bonds, what has broken, and forces not let go of yet.
   subroutine save_cracks(file, scene, state)
      type(checkpoint_t), intent(inout) :: file
      type(scene_t), intent(in) :: scene
      type(state_t), intent(in) :: state

      call file%save('crack_edges', pack(scene%cut%edge, scene%cut%group == 0))
      if (.not. scene%can_break) return
      call file%save('bonds', bond_values(scene%bonds, state%bonds))
      call file%save('crack_events', event_values(state%bonds))
      call file%save('release_start', state%release_start)
      call file%save('release_time', state%release_time)
      if (state%release_time > 0.0_wp) call file%save('release', state%release)
   end subroutine save_cracks

   !> Cut the mesh along the same edges in the same order, and put the bonds back into them.
   subroutine load_cracks(file, path, scene, state, errors)
      type(checkpoint_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: edge(:), at_start(:), later(:), parent(:)
      real(wp), allocatable :: bonds(:, :), events(:, :)

      call file%load('crack_edges', edge, errors)
      if (errors%any()) return
      at_start = pack(scene%cut%edge, scene%cut%group == 0)
      if (.not. starts_with(edge, at_start)) then
         call errors%add(path//': the run that wrote it had other cohesive joints from its start than this deck has ('// &
                         to_text(size(at_start))//'); group and insertion of every &fracture must be the same')
         return
      end if
      later = edge(size(at_start) + 1:)
      if (.not. can_be_cut(scene, later)) then
         call errors%add(path//': has cracks in rock that cannot break in this deck; give it the &fracture groups of the deck '// &
                         'that wrote the checkpoint')
         return
      end if
      if (.not. scene%can_break) return
      if (size(later) > 0) call recut(scene, state, later, parent)
      scene%breakable(later) = 0
      state%release = spread(0.0_wp*state%mass, 1, 2)
      ! A run that could not break may go on with rock that can
      if (.not. file%has('bonds')) return
      allocate (bonds(bond_value_count, size(edge)))
      call file%load('bonds', bonds, errors)
      call file%load('crack_events', events, errors)
      call file%load('release_start', state%release_start, errors)
      call file%load('release_time', state%release_time, errors)
      if (state%release_time > 0.0_wp) call file%load('release', state%release, errors)
      if (errors%any()) return
      call restore_bonds(bonds, scene%bonds, state%bonds)
      call restore_events(events, state%bonds)
      scene%joints%bonded(scene%bonds%fractures + 1:) = state%bonds%active
   end subroutine load_cracks

   !> Does a list start with another one?
   pure logical function starts_with(list, start)
      integer, intent(in) :: list(:), start(:)

      starts_with = size(list) >= size(start)
      if (starts_with) starts_with = all(list(:size(start)) == start)
   end function starts_with

   !> May these edges of the mesh be cut in this deck?
   pure logical function can_be_cut(scene, edge)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: edge(:)

      can_be_cut = all(edge >= 1 .and. edge <= size(scene%breakable))
      if (can_be_cut) can_be_cut = all(scene%breakable(edge) > 0)
   end function can_be_cut

   ! ---- Motion ------------------------------------------------------------------------------------------------------

   !> Where the run stands, motion and energies.
   subroutine save_motion(file, state, place)
      type(checkpoint_t), intent(inout) :: file
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place

      call file%save('stage', place%stage)
      call file%save('cycle', place%cycle)
      call file%save('time', state%time)
      call file%save('step', state%step)
      call file%save('displacement', state%u)
      call file%save('velocity', state%v)
      call file%save('mass', state%mass)
      associate (e => state%energy)
         call file%save('energy', [e%kinetic, e%strain, e%contact, e%friction, e%damping, e%fracture, e%external, e%initial])
      end associate
   end subroutine save_motion

   subroutine load_motion(file, state, place, errors)
      type(checkpoint_t), intent(inout) :: file
      type(state_t), intent(inout) :: state
      type(place_t), intent(out) :: place
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: energy(:)

      call file%load('stage', place%stage, errors)
      call file%load('cycle', place%cycle, errors)
      call file%load('time', state%time, errors)
      call file%load('step', state%step, errors)
      call file%load('displacement', state%u, errors)
      call file%load('velocity', state%v, errors)
      call file%load('mass', state%mass, errors)
      allocate (energy(8))
      call file%load('energy', energy, errors)
      if (errors%any()) return
      associate (e => state%energy)
         e%kinetic = energy(1); e%strain = energy(2); e%contact = energy(3); e%friction = energy(4)
         e%damping = energy(5); e%fracture = energy(6); e%external = energy(7); e%initial = energy(8)
      end associate
   end subroutine load_motion

   ! ---- Joints ------------------------------------------------------------------------------------------------------

   !> Joint elements: those of the fractures and those of cracks.
   subroutine save_joints(file, state)
      type(checkpoint_t), intent(inout) :: file
      type(state_t), intent(in) :: state
      real(wp) :: table(joint_value_count, size(state%joint))
      integer :: j

      do j = 1, size(state%joint)
         table(:, j) = joint_values(state%joint(j))
      end do
      call file%save('joints', table)
      call file%save('opening', state%opening)
      call file%save('aperture', state%aperture)
   end subroutine save_joints

   subroutine load_joints(file, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      real(wp), allocatable :: table(:, :)
      integer :: j

      allocate (table(joint_value_count, size(state%joint)))
      call file%load('joints', table, errors)
      call file%load('opening', state%opening, errors)
      call file%load('aperture', state%aperture, errors)
      if (errors%any()) return
      do j = 1, size(state%joint)
         state%joint(j) = joint_from_values(table(:, j))
      end do
   end subroutine load_joints

   ! ---- Contact -----------------------------------------------------------------------------------------------------

   !> What walls and surfaces remember of the contact.
   subroutine save_contact(file, scene, state)
      type(checkpoint_t), intent(inout) :: file
      type(scene_t), intent(in) :: scene
      type(state_t), intent(in) :: state

      call file%save('facing', state%walls%facing)
      call file%save('reached', state%walls%reached)
      call file%save('contact_stiffness', state%tractions%contact_stiffness)
      call file%save('corners', state%corners%held)
      call file%save('corners_passed', state%corners%passed)
      if (scene%has_contact) call file%save('contact', state%contact%values())
   end subroutine save_contact

   subroutine load_contact(file, path, scene, state, errors)
      type(checkpoint_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(scene_t), intent(inout) :: scene
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: facing(:)
      real(wp), allocatable :: contact(:), reached(:)

      allocate (facing(2*count(walls_touching(scene%joints%wall_handled, scene%joints%bonded))))
      call file%load('facing', facing, errors)
      allocate (reached(size(facing)))
      call file%load('reached', reached, errors)
      call file%load('contact_stiffness', state%tractions%contact_stiffness, errors)
      if (errors%any()) return
      call restore_walls(scene, facing, reached, state)
      call file%load('corners', state%corners%held, errors)
      call file%load('corners_passed', state%corners%passed, errors)
      if (errors%any()) return
      if (.not. scene%has_contact) return
      call file%load('contact', contact, errors)
      if (errors%any()) return
      if (.not. scene%contact%restore_state(scene%exposed, contact, state%contact)) &
         call errors%add(path//': the contact of the checkpoint does not fit this mesh')
   end subroutine load_contact

end module run_checkpoint_m
