# Libraries of the system: HDF5 (Fortran), METIS, LAPACK, UMFPACK, MUMPS (sequential, double precision).
add_library(femdem_dependencies INTERFACE)

find_package(HDF5 REQUIRED COMPONENTS Fortran)
# SYSTEM include would hide the .mod files from gfortran: pass the directory as a plain include.
target_compile_options(femdem_dependencies INTERFACE "$<$<COMPILE_LANGUAGE:Fortran>:-I$<JOIN:${HDF5_Fortran_INCLUDE_DIRS},;-I>>")
target_link_libraries(femdem_dependencies INTERFACE ${HDF5_Fortran_LIBRARIES})

find_library(METIS_LIBRARY metis REQUIRED)
target_link_libraries(femdem_dependencies INTERFACE ${METIS_LIBRARY})

find_package(OpenMP REQUIRED COMPONENTS Fortran)
target_link_libraries(femdem_dependencies INTERFACE OpenMP::OpenMP_Fortran)

find_package(LAPACK REQUIRED)
target_link_libraries(femdem_dependencies INTERFACE ${LAPACK_LIBRARIES})

find_library(UMFPACK_LIBRARY umfpack REQUIRED)
target_link_libraries(femdem_dependencies INTERFACE ${UMFPACK_LIBRARY})

# Debian keeps the sequential library apart from the parallel one by its name; its mpif.h stands in for MPI's.
find_path(MUMPS_INCLUDE dmumps_struc.h REQUIRED)
find_path(MUMPS_MPI_INCLUDE mpif.h PATH_SUFFIXES mumps_seq REQUIRED)
foreach(library dmumps_seq mumps_common_seq pord_seq mpiseq_seq)
  find_library(MUMPS_${library} ${library} REQUIRED)
  target_link_libraries(femdem_dependencies INTERFACE ${MUMPS_${library}})
endforeach()
