!> Which solver a scene is run with. A deck may name one; with solver = 'auto' the least dear one that can do the scene is
!> taken: implicit where every increment ends at rest, relaxation where rest needs contact that the implicit solver leaves
!> out, explicit where something moves.
module solver_choice_m
   use kinds_m, only: wp
   use deck_m, only: deck_t
   use mesh_m, only: split_mesh_t, place_text
   use loads_m, only: loads_t, init_loads, start_stage
   use support_m, only: find_loose, assemblies
   implicit none
   private

   public :: choose_solver, solver_name

   !> Solvers. A new one is one more number and name here, and one case in the main program.
   integer, parameter, public :: solver_explicit = 1, solver_implicit = 2, solver_relaxation = 3
   character(len=*), parameter :: names(3) = [character(len=10) :: 'explicit', 'implicit', 'relaxation']

contains

   !> The solver that the deck asks for, or that suits the scene when it leaves the choice; and why.
   subroutine choose_solver(deck, split, solver, reason)
      type(deck_t), intent(in) :: deck
      !> The mesh cut along its fractures
      type(split_mesh_t), intent(in) :: split
      integer, intent(out) :: solver
      character(len=:), allocatable, intent(out) :: reason

      solver = findloc(names == deck%run%solver, .true., dim=1)
      reason = 'the deck names it'
      if (solver > 0) return
      solver = solver_explicit
      reason = motion_in_deck(deck)
      if (reason == '') reason = loose_body(deck, split)
      if (reason /= '') return
      solver = solver_relaxation
      reason = contact_beyond_walls(deck, split)
      if (reason == '' .and. deck%relaxation%line > 0) reason = 'the deck has settings for it (&relaxation)'
      if (reason /= '') return
      solver = solver_implicit
      reason = 'nothing in the deck is dynamic, every increment ends at rest'
   end subroutine choose_solver

   !> Name of a solver, as in a deck.
   pure function solver_name(solver) result(name)
      integer, intent(in) :: solver
      character(len=:), allocatable :: name

      name = trim(names(solver))
   end function solver_name

   !> What in a deck speaks of motion; '' when nothing does.
   pure function motion_in_deck(deck) result(reason)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable :: reason

      reason = ''
      if (deck%explicit%line > 0) reason = 'the deck has settings for it (&explicit)'
      if (deck%contact%friction == 'velocity' .or. any(deck%joint%friction == 'velocity')) &
         reason = 'friction follows the direction of motion (friction = ''velocity'')'
      if (any(deck%boundary%absorbing)) reason = 'waves leave through a side (&boundary absorbing)'
      if (size(deck%initial) > 0) reason = 'bodies have initial velocities (&initial)'
   end function motion_in_deck

   !> A body that the prescribed displacements of some stage leave free to move; '' when there is none. With weak springs
   !> (&implicit loose_bodies) its loads are said to be in balance.
   function loose_body(deck, split) result(reason)
      type(deck_t), intent(in) :: deck
      type(split_mesh_t), intent(in) :: split
      character(len=:), allocatable :: reason
      type(loads_t) :: loads
      real(wp) :: no_weight(2, size(split%x, 2))
      integer, allocatable :: loose(:)
      integer :: stage

      reason = ''
      if (deck%implicit%loose_bodies == 'hold') return
      no_weight = 0.0_wp
      call init_loads(split, deck%boundary, loads)
      do stage = 1, size(deck%stage)
         call start_stage(split, deck%boundary, deck%stage%name, stage, no_weight, loads)
         call find_loose(split%x, split%triangle, split%joint, loads%fixed, loose)
         if (size(loose) == 0) cycle
         reason = 'nothing holds the rock around '//place_text(split%x(:, loose(1)), split%datum)//': it may move'
         return
      end do
   end function loose_body

   !> Contact without which there is no rest and which the implicit solver leaves out; '' when there is none.
   function contact_beyond_walls(deck, split) result(reason)
      type(deck_t), intent(in) :: deck
      type(split_mesh_t), intent(in) :: split
      character(len=:), allocatable :: reason

      reason = ''
      if (any(deck%joint%contact == 'potential')) reason = 'joints are in potential contact'
      if (.not. deck%contact%active) return
      if (assemblies(size(split%x, 2), split%triangle, split%joint) > 1) reason = 'bodies that share no joint can meet'
   end function contact_beyond_walls

end module solver_choice_m
