# Writes version_m.f90 with the version and the git commit. Runs when configuring and again before every build, so
# that the commit in the results is the one that was compiled; the file changes only when its content does.
#   cmake -DSOURCE=dir -DTEMPLATE=version_m.f90.in -DTARGET=version_m.f90 -DFEMDEM_VERSION=x.y.z -P version.cmake
set(FEMDEM_COMMIT "unknown")
find_program(GIT_PROGRAM git)
if(GIT_PROGRAM AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND ${GIT_PROGRAM} describe --always --dirty
    WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE described RESULT_VARIABLE status
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(status EQUAL 0 AND described)
    set(FEMDEM_COMMIT "${described}")
  endif()
endif()
configure_file(${TEMPLATE} ${TARGET} @ONLY)
