!> Where results come from: program, commit, compiler, command, deck and date.
module provenance_m
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
   use version_m, only: program_commit, program_version
   implicit none
   private

   public :: provenance_of

   type, public :: provenance_t
      !> Version and commit of the program; compiler and its options; command line; text of the effective deck;
      !> date and time the run started, with the distance from UTC
      character(len=:), allocatable :: version, commit, compiler, compiler_options, command, deck, date
   end type provenance_t

contains

   !> The provenance of this run.
   function provenance_of(command, deck) result(provenance)
      !> Command line, and text of the effective deck
      character(len=*), intent(in) :: command, deck
      type(provenance_t) :: provenance
      character(len=8) :: date
      character(len=10) :: time
      character(len=5) :: zone

      call date_and_time(date=date, time=time, zone=zone)
      provenance%version = program_version
      provenance%commit = program_commit
      provenance%compiler = compiler_version()
      provenance%compiler_options = telling_options(compiler_options())
      provenance%command = command
      provenance%deck = deck
      provenance%date = date(1:4)//'-'//date(5:6)//'-'//date(7:8)//'T'//time(1:2)//':'//time(3:4)//':'//time(5:6)//zone
   end function provenance_of

   !> The compiler options that say how the program was built: no directories, and not the long list of what the
   !> processor cannot do that -march=native turns into.
   pure function telling_options(options) result(kept)
      !> Options separated by blanks
      character(len=*), intent(in) :: options
      character(len=:), allocatable :: kept
      integer :: first, last

      kept = ''
      first = 1
      do while (first <= len(options))
         last = first + index(options(first:)//' ', ' ') - 2
         associate (word => options(first:last))
            if (index(word, '-') == 1 .and. index(word, '/') == 0 .and. index(word, '-mno-') /= 1 .and. &
                index(word, '--param') /= 1 .and. word /= '-I' .and. word /= '-J') kept = kept//' '//word
         end associate
         first = last + 2
      end do
      if (kept /= '') kept = kept(2:)
   end function telling_options

end module provenance_m
