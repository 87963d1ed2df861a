# Compiler flags shared by the library, the program and the tests.
add_library(femdem_flags INTERFACE)
target_compile_options(femdem_flags INTERFACE
  $<$<COMPILE_LANGUAGE:Fortran>:-std=f2008 -Wall -Wextra -Wimplicit-interface -Wimplicit-procedure -Wconversion-extra>)
if(FEMDEM_WERROR)
  target_compile_options(femdem_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:-Werror>)
endif()
# A maybe-uninitialized warning on an allocatable's descriptor is a known false alarm of gfortran 12.
target_compile_options(femdem_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:-Wno-maybe-uninitialized>)

set(CMAKE_Fortran_FLAGS_RELEASE "-O3 -g1 -fno-math-errno -fno-trapping-math")
# Array temporaries are no error, and their warnings would drown the program's own messages.
set(CMAKE_Fortran_FLAGS_DEBUG "-Og -g -fcheck=all,no-array-temps -fbacktrace -ffpe-trap=invalid,zero,overflow -finit-real=snan -finit-derived")
# What goes past the ends of arrays and allocations without a bounds check noticing, memory that is lost, and undefined arithmetic.
set(CMAKE_Fortran_FLAGS_SANITIZE "-O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer")
if(FEMDEM_NATIVE AND CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_options(femdem_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:-march=native>)
endif()
