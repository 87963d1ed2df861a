!> JCM-FEMDEM: fractured rock in two dimensions, with its joints as they really behave.
program femdem
   implicit none

   print '(a)', 'femdem'

end program femdem
