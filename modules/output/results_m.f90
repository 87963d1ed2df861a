!> The results directory of a run: history.csv, fields.h5 with fields.xdmf, edges.csv, checkpoint.h5, deck.nml.
module results_m
   use kinds_m, only: wp, i8
   use errors_m, only: error_list_t
   use files_m, only: file_exists
   use deck_m, only: deck_t
   use deck_record_m, only: deck_record_t, read_record
   use model_m, only: model_t
   use sparse_system_m, only: kept_matrix_t
   use implicit_m, only: implicit_solver_t
   use state_m, only: state_t
   use history_m, only: history_t, history_columns, column_length
   use fields_m, only: fields_t
   use field_list_m, only: field_list_t, on_nodes
   use crack_results_m, only: write_cracks, append_cracks
   use results_directory_m, only: effective_deck
   use result_values_m, only: history_row, joint_constants, length_there
   use edge_results_m, only: edge_sums, write_edges
   use provenance_m, only: provenance_t, provenance_of
   use flow_of_run_m, only: open_run_flow, write_run_flow, take_run_flow
   use flow_results_m, only: flow_results_t
   use run_checkpoint_m, only: place_t, save_run
   implicit none
   private

   !> A completed cycle, and whether history, fields and checkpoint have it
   type :: last_cycle_t
      type(state_t) :: state
      type(place_t) :: place
      real(wp) :: unbalanced = 0.0_wp
      logical :: row = .false., fields = .false., checkpoint = .false.
   end type last_cycle_t

   !> The open results of a run
   type, public :: results_t
      private
      character(len=:), allocatable :: directory
      type(history_t) :: history
      type(fields_t) :: fields
      type(flow_results_t) :: flow
      !> Cracks in their table
      integer :: cracks = 0
      !> Step of the run when it was last recorded
      integer(i8) :: recorded = -1_i8
      !> What of the deck checkpoints keep
      type(deck_record_t) :: deck
      !> Time of the last checkpoint (clock counts)
      integer(i8) :: last_checkpoint = 0_i8
      !> Matrix of the implicit solver at the end of that cycle, and which of its matrices it is
      type(kept_matrix_t) :: matrix
      integer(i8) :: matrix_number = -1_i8
      !> What is not written of the last cycle completed, for a run that fails in the next
      type(last_cycle_t), allocatable :: last
      !> The model then, where rock may break or is taken out, which changes it
      type(model_t), allocatable :: model
   contains
      procedure :: open => open_results
      procedure :: record
      procedure :: record_last_cycle
      procedure :: record_failure
      procedure :: close => close_results
   end type results_t

contains

   !> Create the directory and its files; with a restart, go on with those that are there.
   subroutine open_results(self, directory, model, state, command, restarted, place, notes, errors)
      class(results_t), intent(inout) :: self
      character(len=*), intent(in) :: directory
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> Command line of the run
      character(len=*), intent(in) :: command
      !> Does this run go on with an earlier one?
      logical, intent(in) :: restarted
      !> Stage and cycle that it goes on from
      type(place_t), intent(in) :: place
      !> What the user should know
      type(error_list_t), intent(inout) :: notes
      type(error_list_t), intent(inout) :: errors
      character(len=column_length), allocatable :: column(:)
      type(field_list_t) :: constant
      character(len=:), allocatable :: deck_text
      type(provenance_t) :: provenance

      self%directory = directory//'/'
      self%deck = read_record(model%deck)
      call effective_deck(self%directory//'deck.nml', model%deck, deck_text, errors)
      if (errors%any()) return
      column = history_columns(model%deck%joint%group)
      call joint_constants(model, constant)
      provenance = provenance_of(command, deck_text)
      associate (edge => model%topology%edge_of_joint)
         if (restarted) then
            call self%history%resume(self%directory//'history.csv', column, &
                                     latest(state%time, row_is_due(model%deck, place)), errors)
            call self%fields%resume(directory, model%split, edge, constant, provenance, &
                                    latest(state%time, snapshot_is_due(model%deck, place)), notes, errors)
         else
            call self%history%init(self%directory//'history.csv', column, errors)
            call self%fields%init(directory, model%split, edge, constant, provenance, errors)
         end if
      end associate
      ! Should this run end before its first cycle, that of the checkpoint is its last one, with all that was written of it
      if (restarted) self%last = last_cycle_t(state, place, row=.true., fields=snapshot_is_due(model%deck, place), &
                                              checkpoint=.true.)
      if (restarted) call keep_model(self, model)
      ! The table begins with what is known: nothing, or what had broken at the checkpoint
      if (model%can_break) then
         call write_cracks(self%directory//'cracks.csv', state%bonds%event, model%deck%stage%name, errors)
         self%cracks = size(state%bonds%event)
      end if
      call open_run_flow(self%flow, self%directory, model, restarted, latest(state%time, row_is_due(model%deck, place)), errors)
      call system_clock(self%last_checkpoint)
   end subroutine open_results

   !> Does the deck ask for a row of the history at the end of this cycle?
   pure logical function row_is_due(deck, place)
      type(deck_t), intent(in) :: deck
      type(place_t), intent(in) :: place

      row_is_due = mod(place%cycle, deck%output%history_every) == 0
      if (place%stage > 0) row_is_due = row_is_due .or. place%cycle == deck%stage(place%stage)%cycles
   end function row_is_due

   !> Does the deck ask for a snapshot of the fields at the end of this cycle?
   pure logical function snapshot_is_due(deck, place)
      type(deck_t), intent(in) :: deck
      type(place_t), intent(in) :: place

      snapshot_is_due = .false.
      if (place%stage > 0) snapshot_is_due = place%cycle == deck%stage(place%stage)%cycles
      if (deck%output%fields_every > 0) snapshot_is_due = snapshot_is_due .or. mod(place%cycle, deck%output%fields_every) == 0
   end function snapshot_is_due

   !> Latest time to keep of earlier results: that of the checkpoint, or all before it. What a run that was stopped has written
   !> there although the deck does not ask for it is dropped, so that a run that was stopped ends as one that was not.
   pure real(wp) function latest(time, due)
      real(wp), intent(in) :: time
      !> Does the deck ask for output at the time of the checkpoint?
      logical, intent(in) :: due
      !> Times in tables have twelve digits
      real(wp), parameter :: digits = 2.0e-10_wp

      latest = time
      if (.not. due) latest = time*(1.0_wp - digits)
   end function latest

   !> What has broken since the last look; nothing where nothing can.
   subroutine note_cracks_in_table(self, model, state, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(error_list_t), intent(inout) :: errors

      if (.not. model%can_break) return
      call append_cracks(self%directory//'cracks.csv', state%bonds%event(self%cracks + 1:), model%deck%stage%name, errors)
      self%cracks = size(state%bonds%event)
   end subroutine note_cracks_in_table

   !> What a finished cycle leaves behind, as often as the deck asks for it.
   subroutine record(self, model, state, solver, place, unbalanced, stage_is_over, run_is_over, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      !> The implicit solver: its matrix goes into checkpoints
      type(implicit_solver_t), intent(in) :: solver
      !> Stage and cycle just completed
      type(place_t), intent(in) :: place
      !> Unbalanced force ratio
      real(wp), intent(in) :: unbalanced
      logical, intent(in) :: stage_is_over, run_is_over
      type(error_list_t), intent(inout) :: errors
      integer(i8) :: now, rate
      logical :: to_history, snapshot, checkpoint

      self%recorded = state%step
      if (solver%matrix_number() /= self%matrix_number) self%matrix = solver%matrix()
      self%matrix_number = solver%matrix_number()
      call self%history%forget_dropped()
      call self%flow%forget_dropped()
      call check_still_there(self, errors)
      if (errors%any()) return
      associate (settings => model%deck%output)
         to_history = row_is_due(model%deck, place)
         if (to_history) call write_rows(self, model, state, place, unbalanced, errors)
         snapshot = snapshot_is_due(model%deck, place)
         if (snapshot .or. to_history) call note_cracks_in_table(self, model, state, errors)
         if (snapshot) call write_snapshot(self, model, state, place, errors)
         ! The checkpoint never goes beyond what the other files hold: a restart then writes them again
         if (errors%any()) then
            call check_still_there(self, errors)
            return
         end if
         call system_clock(now, rate)
         checkpoint = run_is_over .or. stage_is_over .or. &
                      real(now - self%last_checkpoint, wp) > 60.0_wp*settings%checkpoint_minutes*real(rate, wp)
         if (checkpoint) then
            call save_run(self%directory//'checkpoint.h5', self%deck, model, state, self%matrix, place, errors)
            self%last_checkpoint = now
         end if
      end associate
      if (to_history .and. snapshot .and. checkpoint) then
         if (allocated(self%last)) deallocate (self%last)
      else
         self%last = last_cycle_t(state, place, unbalanced, to_history, snapshot, checkpoint)
         call keep_model(self, model)
      end if
   end subroutine record

   !> Keep the model of the last cycle, for a run that fails in the next one after more rock has broken or been taken out.
   subroutine keep_model(self, model)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model

      if (.not. (model%can_break .or. any(model%deck%stage%remove /= ''))) return
      if (allocated(self%model)) then
         if (self%model%recuts == model%recuts) return
      end if
      self%model = model
   end subroutine keep_model

   !> Is there still a directory to write into? Its open files would go on without a word.
   subroutine check_still_there(self, errors)
      class(results_t), intent(in) :: self
      type(error_list_t), intent(inout) :: errors

      if (file_exists(self%directory//'history.csv')) return
      call errors%add('the results directory '//self%directory//', or history.csv in it, has been deleted or moved while '// &
                      'the run went on: there is nowhere to write to')
   end subroutine check_still_there

   !> A run has failed or is stopped: write what is missing of the last cycle completed, so that history, fields and checkpoint
   !> agree.
   subroutine record_last_cycle(self, model, errors)
      class(results_t), intent(inout) :: self
      !> Now
      type(model_t), intent(in) :: model
      !> It may hold why the run has failed: what fails here is told from that
      type(error_list_t), intent(inout) :: errors
      type(last_cycle_t), allocatable :: last
      type(model_t), allocatable :: model_then
      type(error_list_t) :: writing

      call move_alloc(self%last, last)
      if (.not. allocated(last)) return
      call move_alloc(self%model, model_then)
      if (allocated(model_then)) then
         call write_last_cycle(self, model_then, last, writing)
      else
         call write_last_cycle(self, model, last, writing)
      end if
      call errors%append(writing)
   end subroutine record_last_cycle

   !> What is missing of a cycle.
   subroutine write_last_cycle(self, model, last, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(last_cycle_t), intent(in) :: last
      !> None yet
      type(error_list_t), intent(inout) :: errors

      call check_still_there(self, errors)
      if (errors%any()) return
      call self%history%put_back(errors)
      call self%flow%put_back(errors)
      if (.not. last%row) call write_rows(self, model, last%state, last%place, last%unbalanced, errors)
      call note_cracks_in_table(self, model, last%state, errors)
      if (.not. last%fields) call write_snapshot(self, model, last%state, last%place, errors)
      if (errors%any() .or. last%checkpoint) return
      call save_run(self%directory//'checkpoint.h5', self%deck, model, last%state, self%matrix, last%place, errors)
   end subroutine write_last_cycle

   !> A row of the history, and of the tables of flow.
   subroutine write_rows(self, model, state, place, unbalanced, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      real(wp), intent(in) :: unbalanced
      type(error_list_t), intent(inout) :: errors

      call self%history%write_row(history_row(model, state, place, unbalanced), errors)
      call write_run_flow(self%flow, model, state, place, errors)
   end subroutine write_rows

   !> Fields and block edges.
   subroutine write_snapshot(self, model, state, place, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      type(error_list_t), intent(inout) :: errors

      call write_fields(self, model, state, place, errors)
      call write_edge_table(self, 'edges.csv', model, state%joint%u, state%aperture, errors)
   end subroutine write_snapshot

   !> Means over block edges in a table of the given name.
   subroutine write_edge_table(self, name, model, slip, aperture, errors)
      class(results_t), intent(in) :: self
      character(len=*), intent(in) :: name
      type(model_t), intent(in) :: model
      !> (joints) [mm]
      real(wp), intent(in) :: slip(:), aperture(:)
      type(error_list_t), intent(inout) :: errors

      call write_edges(self%directory//name, edge_sums(model%topology%edge_of_joint, model%split%joint_group, &
                                                       length_there(model%joints), slip, aperture), model%split%group, errors)
   end subroutine write_edge_table

   !> A cycle that found no rest: the state it ended with in history, fields and block edges, and what slipped after the last
   !> rest in collapse.csv. The checkpoint stays that of a completed cycle.
   subroutine record_failure(self, model, state, place, unbalanced, moved, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      real(wp), intent(in) :: unbalanced
      !> Slip since the last rest (joints) [mm]
      real(wp), intent(in) :: moved(:)
      type(error_list_t), intent(inout) :: errors

      call write_edge_table(self, 'collapse.csv', model, moved, state%aperture, errors)
      ! Nothing new where the last rest was the end of a cycle
      if (state%step == self%recorded .and. .not. model%can_break) return
      call write_rows(self, model, state, place, unbalanced, errors)
      call note_cracks_in_table(self, model, state, errors)
      call write_snapshot(self, model, state, place, errors)
   end subroutine record_failure

   !> One snapshot of all fields. A new field is one more line.
   subroutine write_fields(self, model, state, place, errors)
      class(results_t), intent(inout) :: self
      type(model_t), intent(in) :: model
      type(state_t), intent(in) :: state
      type(place_t), intent(in) :: place
      type(error_list_t), intent(inout) :: errors
      type(field_list_t) :: list, constant
      integer :: i

      if (.not. self%fields%is_on(model%split)) then
         ! Cracks or an excavation have changed it
         call joint_constants(model, constant)
         call self%fields%set_mesh(model%split, model%topology%edge_of_joint, constant, errors)
      end if
      call list%add('displacement', 'm', 'displacement', on_nodes, state%u)
      call list%add('velocity', 'm/s', 'velocity', on_nodes, state%v)
      do i = 1, size(model%term)
         call model%term(i)%raw%results(model, state, list)
      end do
      call take_run_flow(self%flow, model, state, place, errors)
      call self%flow%add_fields(model%split%origin, list)
      call self%fields%write(state%time, state%step, model%deck%stage(place%stage)%name, place%cycle, list, errors)
   end subroutine write_fields

   subroutine close_results(self)
      class(results_t), intent(inout) :: self

      call self%history%close()
      call self%flow%close()
   end subroutine close_results

end module results_m
