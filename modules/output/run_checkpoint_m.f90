!> What a checkpoint keeps of a run: the deck it belongs to, the edges that became cracks, and all that the state remembers, by
!> one list that serves for saving and loading (keep_state). Nothing is kept that follows from deck and mesh, or that the first
!> forces find anew.
module run_checkpoint_m
   use errors_m, only: error_list_t
   use text_m, only: to_text
   use checkpoint_m, only: checkpoint_t, fingerprint_t, text_hash, numbers_hash
   use deck_record_m, only: deck_record_t, read_record, compare_records
   use bonds_m, only: bond_values, bond_value_count
   use cracks_m, only: breaks_t
   use excavation_m, only: find_excavation
   use fluid_coupling_m, only: is_two_way
   use model_m, only: model_t
   use sparse_system_m, only: kept_matrix_t
   use state_m, only: state_t
   implicit none
   private

   !> Where a run stands
   type, public :: place_t
      !> Stage and cycle that have been completed (0: none yet)
      integer :: stage = 0, cycle = 0
   end type place_t

   public :: save_run, open_run, load_run

contains

   !> Save all that changes during a run.
   subroutine save_run(path, record, model, state, matrix, place, errors)
      character(len=*), intent(in) :: path
      !> Of the deck
      type(deck_record_t), intent(in) :: record
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> What the implicit solver keeps of its matrix
      type(kept_matrix_t), intent(in) :: matrix
      type(place_t), intent(in) :: place
      type(error_list_t), intent(inout) :: errors
      type(checkpoint_t) :: file
      type(state_t) :: kept
      type(kept_matrix_t) :: kept_matrix

      call file%create(path, fingerprint_of(model))
      call file%save('deck', record%at(place%stage, place%cycle, has_cracks(model)))
      call file%save('whole_deck', record%whole)
      call file%save('crack_edges', pack(model%cut%edge, model%cut%group == 0))
      call file%save('stage', place%stage)
      call file%save('cycle', place%cycle)
      if (model%can_break) call file%save('bonds', bond_values(model%bonds, state%bonds))
      kept = state
      call keep_state(file, model, kept, errors)
      kept_matrix = matrix
      call keep_matrix(file, kept_matrix, errors)
      call file%close(errors)
   end subroutine save_run

   !> Open the checkpoint of a run that is to go on, and find what had broken or been taken out: that comes first (recut), it makes
   !> the mesh that the rest is on (load_run). After an error there is nothing to close.
   subroutine open_run(file, path, branch, model, breaks, errors)
      type(checkpoint_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      !> May later stages, solver and its settings differ from those of the run that wrote it?
      logical, intent(in) :: branch
      !> As it was built from deck and mesh
      type(model_t), intent(in) :: model
      type(breaks_t), intent(out) :: breaks
      type(error_list_t), intent(inout) :: errors
      integer :: stage

      call file%open(path, fingerprint_of(model), errors)
      if (errors%any()) return
      call compare_decks(file, path, branch, model, errors)
      call load_cracks(file, path, model, breaks, errors)
      call file%load('stage', stage, errors)
      if (errors%any()) call file%close(errors)
      if (.not. errors%any()) call find_excavation(model, stage, breaks)
   end subroutine open_run

   !> Take the state of a checkpoint that open_run has opened.
   subroutine load_run(file, model, state, matrix, place, errors)
      type(checkpoint_t), intent(inout) :: file
      !> With all cracks
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      !> What the implicit solver had of its matrix; not allocated when it had none
      type(kept_matrix_t), allocatable, intent(out) :: matrix
      !> Stage and cycle that were completed
      type(place_t), intent(out) :: place
      type(error_list_t), intent(inout) :: errors

      call file%load('stage', place%stage, errors)
      call file%load('cycle', place%cycle, errors)
      if (.not. errors%any()) call keep_state(file, model, state, errors)
      allocate (matrix)
      if (.not. errors%any()) call keep_matrix(file, matrix, errors)
      if (allocated(matrix%first)) then
         if (size(matrix%first) == 0) deallocate (matrix)
      end if
      call file%close(errors)
   end subroutine load_run

   !> All that the state remembers, saved to a checkpoint or loaded from it: what belongs to all terms here, the rest term by term.
   !> What is added to the state and not found anew by the first forces has its line in one of these lists.
   subroutine keep_state(file, model, state, errors)
      type(checkpoint_t), intent(inout) :: file
      type(model_t), intent(in) :: model
      type(state_t), intent(inout) :: state
      type(error_list_t), intent(inout) :: errors
      logical :: keeps_fluid, keeps_content
      integer :: i

      ! Motion
      call file%keep('time', state%time, errors)
      call file%keep('step', state%step, errors)
      call file%keep('displacement', state%u, errors)
      call file%keep('velocity', state%v, errors)
      call file%keep('mass', state%mass, errors)
      ! Energy account
      associate (energy => state%energy)
         call file%keep('energy_kinetic', energy%kinetic, errors)
         call file%keep('energy_strain', energy%strain, errors)
         call file%keep('energy_contact', energy%contact, errors)
         call file%keep('energy_friction', energy%friction, errors)
         call file%keep('energy_corners', energy%corners, errors)
         call file%keep('energy_surfaces', energy%surfaces, errors)
         call file%keep('energy_damping', energy%damping, errors)
         call file%keep('energy_fracture', energy%fracture, errors)
         call file%keep('energy_absorbed', energy%absorbed, errors)
         call file%keep('energy_external', energy%external, errors)
         call file%keep('energy_initial', energy%initial, errors)
      end associate
      ! What the implicit solver goes on from
      call file%keep('guess_known', state%guess%known, errors)
      call file%keep('guess_part', state%guess%part, errors)
      call file%keep('guess_slip_part', state%guess%slip_part, errors)
      call file%keep('guess_move', state%guess%move, errors)
      call file%keep('guess_move_part', state%guess%move_part, errors)
      keeps_fluid = is_two_way(model%deck)
      ! A run without fluid may go on with it
      if (keeps_fluid .and. .not. file%writing) keeps_fluid = file%has('fluid_pressure')
      if (keeps_fluid) then
         call file%keep('fluid_pressure', state%fluid%pressure, errors)
         call file%keep('fluid_rate', state%fluid%rate, errors)
         call file%keep('fluid_inflow', state%fluid%inflow, errors)
         call file%keep('fluid_filled', state%fluid%filled, errors)
         keeps_content = allocated(state%fluid%content)
         if (.not. file%writing) keeps_content = file%has('fluid_content')
         if (keeps_content) call file%keep('fluid_content', state%fluid%content, errors)
         call file%keep('fluid_last', state%fluid%last, errors)
         call file%keep('fluid_wanted', state%fluid%wanted, errors)
         call file%keep('fluid_range', state%fluid%range, errors)
         call file%keep('fluid_imbalance', state%fluid%imbalance, errors)
      end if
      do i = 1, size(model%term)
         if (.not. errors%any()) call model%term(i)%raw%keep(file, model, state, errors)
      end do
   end subroutine keep_state

   !> The matrix of the implicit solver: pattern and values in use, so that a restart goes on as if there had been none.
   subroutine keep_matrix(file, matrix, errors)
      type(checkpoint_t), intent(inout) :: file
      type(kept_matrix_t), intent(inout) :: matrix
      type(error_list_t), intent(inout) :: errors

      call file%keep('matrix_first', matrix%first, errors)
      call file%keep('matrix_column', matrix%column, errors)
      call file%keep('matrix_value', matrix%value, errors)
      call file%keep('matrix_outdated', matrix%outdated, errors)
   end subroutine keep_matrix

   !> The deck must agree with the one that the checkpoint was written with: in all that the results depend on, or, for a branch,
   !> in what its state depends on.
   subroutine compare_decks(file, path, branch, model, errors)
      type(checkpoint_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      logical, intent(in) :: branch
      type(model_t), intent(in) :: model
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: before, whole
      integer, allocatable :: crack(:)
      type(place_t) :: place
      type(deck_record_t) :: now
      type(error_list_t) :: of_state

      call file%load('deck', before, errors)
      call file%load('whole_deck', whole, errors)
      call file%load('crack_edges', crack, errors)
      call file%load('stage', place%stage, errors)
      call file%load('cycle', place%cycle, errors)
      if (errors%any()) return
      if (place%stage > size(model%deck%stage)) then
         call errors%add(path//': was written in stage '//to_text(place%stage)//', and this deck has '// &
                         to_text(size(model%deck%stage))//' stages')
         return
      end if
      now = read_record(model%deck)
      call compare_records(path, before, now%at(place%stage, place%cycle, size(crack) > 0), .false., of_state)
      if (branch) then
         call errors%append(of_state)
         return
      end if
      call compare_records(path, whole, now%whole, .true., errors)
      if (errors%any() .and. .not. of_state%any()) &
         call errors%add(path//': --restart goes on with the same run; --branch in its place goes on with other stages, loads '// &
                         'to come, solver or settings of a solver on purpose')
   end subroutine compare_decks

   !> Are there cohesive joints?
   pure logical function has_cracks(model)
      type(model_t), intent(in) :: model

      has_cracks = any(model%cut%group == 0)
   end function has_cracks

   !> Sizes and content of the mesh before any crack, which a checkpoint must agree with.
   function fingerprint_of(model) result(fingerprint)
      type(model_t), intent(in) :: model
      type(fingerprint_t) :: fingerprint
      character(len=:), allocatable :: names
      integer :: i, fractures

      associate (mesh => model%whole)
         fractures = count(model%cut%group > 0)
         fingerprint%nodes = size(mesh%x, 2)
         fingerprint%triangles = size(mesh%triangle, 2)
         fingerprint%joints = fractures
         fingerprint%places = numbers_hash([transfer(mesh%datum, [0]), transfer(mesh%x, [0])])
         fingerprint%corners = numbers_hash([reshape(mesh%triangle, [size(mesh%triangle)]), &
                                             reshape(model%cut%node(:, :fractures), [2*fractures])])
         names = ''
         do i = 1, size(mesh%group)
            names = names//trim(mesh%group(i)%name)//new_line('a')//to_text(mesh%group(i)%dimension)//new_line('a')
         end do
         fingerprint%groups = text_hash(names//numbers_hash([mesh%triangle_group, model%cut%group(:fractures), &
                                                             model%outer_group]))
      end associate
   end function fingerprint_of

   ! ---- Cracks ------------------------------------------------------------------------------------------------------

   !> Edges that were cut after the start, in the same order, and the bonds in all cuts.
   subroutine load_cracks(file, path, model, breaks, errors)
      type(checkpoint_t), intent(inout) :: file
      character(len=*), intent(in) :: path
      type(model_t), intent(in) :: model
      type(breaks_t), intent(out) :: breaks
      type(error_list_t), intent(inout) :: errors
      integer, allocatable :: edge(:), at_start(:)

      breaks%at_start = .true.
      call file%load('crack_edges', edge, errors)
      if (errors%any()) return
      at_start = pack(model%cut%edge, model%cut%group == 0)
      if (.not. starts_with(edge, at_start)) then
         call errors%add(path//': the run that wrote it had other cohesive joints from its start than this deck has ('// &
                         to_text(size(at_start))//'); group and insertion of every &cohesive must be the same')
         return
      end if
      breaks%edge = edge(size(at_start) + 1:)
      if (.not. can_be_cut(model, breaks%edge)) then
         call errors%add(path//': has cracks in rock that cannot break in this deck; give it the &cohesive groups of the deck '// &
                         'that wrote the checkpoint')
         return
      end if
      if (.not. model%can_break) return
      ! A run that could not break may go on with rock that can
      if (.not. file%has('bonds')) return
      allocate (breaks%bond(bond_value_count, size(edge)))
      call file%load('bonds', breaks%bond, errors)
   end subroutine load_cracks

   !> Does a list start with another one?
   pure logical function starts_with(list, start)
      integer, intent(in) :: list(:), start(:)

      starts_with = size(list) >= size(start)
      if (starts_with) starts_with = all(list(:size(start)) == start)
   end function starts_with

   !> May these edges of the mesh be cut in this deck?
   pure logical function can_be_cut(model, edge)
      type(model_t), intent(in) :: model
      integer, intent(in) :: edge(:)

      can_be_cut = all(edge >= 1 .and. edge <= size(model%breakable))
      if (can_be_cut) can_be_cut = all(model%breakable(edge) > 0)
   end function can_be_cut

end module run_checkpoint_m
