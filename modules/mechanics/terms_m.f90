!> The terms of the equations of motion, in the order in which their forces are added. A new one has its line here.
module terms_m
   use model_m, only: term_item_t
   use rock_term_m, only: rock_term_t
   use load_term_m, only: load_term_t
   use wall_term_m, only: wall_term_t
   use corner_term_m, only: corner_term_t
   use surface_term_m, only: surface_term_t
   use bond_term_m, only: bond_term_t
   use viscosity_term_m, only: viscosity_term_t
   implicit none
   private

   public :: all_terms

contains

   function all_terms() result(term)
      type(term_item_t) :: term(7)

      allocate (rock_term_t :: term(1)%raw)
      allocate (load_term_t :: term(2)%raw)
      allocate (wall_term_t :: term(3)%raw)
      allocate (corner_term_t :: term(4)%raw)
      allocate (surface_term_t :: term(5)%raw)
      allocate (bond_term_t :: term(6)%raw)
      allocate (viscosity_term_t :: term(7)%raw)
   end function all_terms

end module terms_m
