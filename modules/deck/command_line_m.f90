!> The command line of the program.
module command_line_m
   use errors_m, only: error_list_t
   use text_m, only: nearest_word, quoted
   implicit none
   private

   public :: read_command_line, parse_command_line, help_text

   !> Longest argument
   integer, parameter, public :: argument_length = 1024

   !> What the user asks for
   type, public :: command_t
      !> Path of the deck; directory of the results, checkpoint to go on from, and results of a finished run whose apertures
      !> conduct (empty: not given)
      character(len=:), allocatable :: deck, output, restart, flow
      !> Check the input only; nothing but errors on the screen; print the version or the help, and nothing else
      logical :: check = .false., quiet = .false., version = .false., help = .false.
      !> Go on with other stages or another solver than the run that wrote the checkpoint?
      logical :: branch = .false.
   end type command_t

   character(len=*), parameter :: options(*) = &
                                  [character(len=9) :: '--check', '--output', '--restart', '--branch', '--flow', &
                                                        '--quiet', &
                                                        '--version', '--help', '-h']

contains

   !> Read the program's own arguments.
   subroutine read_command_line(command, errors)
      type(command_t), intent(out) :: command
      type(error_list_t), intent(inout) :: errors
      character(len=argument_length), allocatable :: argument(:)
      integer :: i, status

      allocate (argument(command_argument_count()))
      do i = 1, size(argument)
         call get_command_argument(i, argument(i), status=status)
         if (status /= 0) call errors%add('argument '//trim(argument(i))//'... is too long')
      end do
      call parse_command_line(argument, command, errors)
   end subroutine read_command_line

   !> Read the arguments of a command line.
   subroutine parse_command_line(argument, command, errors)
      character(len=*), intent(in) :: argument(:)
      type(command_t), intent(out) :: command
      type(error_list_t), intent(inout) :: errors
      integer :: i

      command%deck = ''
      command%output = ''
      command%restart = ''
      command%flow = ''
      i = 0
      do while (i < size(argument))
         i = i + 1
         select case (argument(i))
         case ('--check')
            command%check = .true.
         case ('--quiet')
            command%quiet = .true.
         case ('--version')
            command%version = .true.
         case ('--help', '-h')
            command%help = .true.
         case ('--output')
            call take_value(argument, i, 'a directory', command%output, errors)
         case ('--restart', '--branch')
            call take_checkpoint(argument, i, command, errors)
         case ('--flow')
            call take_value(argument, i, 'a directory of results', command%flow, errors)
         case default
            call take_deck(trim(argument(i)), command, errors)
         end select
      end do
      if (command%flow /= '' .and. (command%restart /= '' .or. command%check)) &
         call errors%add('option --flow takes results as they are: it goes with neither --restart nor --check')
      if (command%flow /= '' .and. (command%restart /= '' .or. command%check)) &
         call errors%add('option --flow takes results as they are: it goes with none of --restart, --branch and --check')
      if (command%deck == '' .and. .not. (command%help .or. command%version .or. errors%any())) then
         call errors%add('no deck given: femdem DECK.nml (femdem --help says more)')
      end if
   end subroutine parse_command_line

   !> The argument after an option is its value.
   subroutine take_value(argument, i, meaning, value, errors)
      character(len=*), intent(in) :: argument(:)
      !> In: the option; out: the last argument used
      integer, intent(inout) :: i
      !> What the option wants, for the message
      character(len=*), intent(in) :: meaning
      character(len=:), allocatable, intent(inout) :: value
      type(error_list_t), intent(inout) :: errors
      logical :: missing

      missing = i == size(argument)
      if (.not. missing) missing = argument(i + 1) == '' .or. index(argument(i + 1), '--') == 1
      if (missing) then
         call errors%add('option '//trim(argument(i))//' needs '//meaning//' after it')
      else
         if (value /= '') call errors%add('option '//trim(argument(i))//' is given twice')
         i = i + 1
         value = trim(argument(i))
      end if
   end subroutine take_value

   !> --restart or --branch, one of them.
   subroutine take_checkpoint(argument, i, command, errors)
      character(len=*), intent(in) :: argument(:)
      !> In: the option; out: the last argument used
      integer, intent(inout) :: i
      type(command_t), intent(inout) :: command
      type(error_list_t), intent(inout) :: errors
      logical :: branch

      branch = argument(i) == '--branch'
      if (command%restart /= '' .and. (branch .neqv. command%branch)) &
         call errors%add('options --restart and --branch go on from one checkpoint: give one of them')
      command%branch = branch
      call take_value(argument, i, 'a checkpoint file', command%restart, errors)
   end subroutine take_checkpoint

   !> An argument that is no known option is the deck.
   subroutine take_deck(argument, command, errors)
      character(len=*), intent(in) :: argument
      type(command_t), intent(inout) :: command
      type(error_list_t), intent(inout) :: errors
      character(len=:), allocatable :: nearest

      if (index(argument, '-') == 1) then
         nearest = nearest_word(argument, options)
         if (nearest /= '') nearest = '; did you mean '//nearest//'?'
         call errors%add('unknown option '//argument//nearest//' (femdem --help lists them)')
      else if (argument == '') then
         call errors%add('an argument is empty where the deck was expected')
      else if (command%deck /= '') then
         call errors%add('one deck at a time: found '//quoted(command%deck)//' and '//quoted(argument))
      else
         command%deck = argument
      end if
   end subroutine take_deck

   !> What --help prints.
   pure function help_text(version)
      !> Version of the program
      character(len=*), intent(in) :: version
      character(len=:), allocatable :: help_text
      character, parameter :: line = new_line('a')

      help_text = &
         'femdem '//version//': fractured rock in two dimensions by finite-discrete elements, with the'//line// &
         'empirical joint constitutive model (JCM) on its fractures.'//line// &
         line// &
         'usage: femdem [options] DECK.nml'//line// &
         line// &
         'DECK.nml is a Fortran namelist file: the mesh, the rock, the joints, the loads and what to write.'//line// &
         'Paths in a deck are relative to the deck.'//line// &
         line// &
         'options:'//line// &
         '  --check         read and check the input, report every error, say which solver would be taken and'//line// &
         '                  why, what would be skipped, and stop'//line// &
         '  --output DIR    write the results to DIR instead of the directory named in the deck;'//line// &
         '                  DIR is relative to the working directory'//line// &
         '  --restart FILE  go on from a checkpoint of an earlier run of the same deck'//line// &
         '  --branch FILE   go on from a checkpoint with other stages, loads to come or another solver'//line// &
         '  --flow DIR      solve the flow of the deck through the apertures of a finished run whose results are'//line// &
         '                  in DIR, at every snapshot; writes to DIR/flow unless --output is given'//line// &
         '  --quiet         print nothing but warnings and errors'//line// &
         '  --version       print the version and stop'//line// &
         '  --help, -h      print this text and stop'//line// &
         line// &
         'exit status: 0 done; 1 the run failed; 2 the input is wrong; 3 stopped by SIGTERM, SIGINT or SIGHUP, to go'//line// &
         'on with --restart.'//line// &
         'Results: history.csv, edges.csv, fields.h5 with fields.xdmf, checkpoint.h5, run.log, deck.nml.'//line// &
         'The manual explains every group and variable of a deck in manual/input.md.'
   end function help_text

end module command_line_m
