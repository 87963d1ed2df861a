# Libraries of the system: HDF5 (Fortran), METIS, LAPACK.
add_library(femdem_dependencies INTERFACE)

find_package(HDF5 REQUIRED COMPONENTS Fortran)
# SYSTEM include would hide the .mod files from gfortran: pass the directory as a plain include.
target_compile_options(femdem_dependencies INTERFACE "$<$<COMPILE_LANGUAGE:Fortran>:-I$<JOIN:${HDF5_Fortran_INCLUDE_DIRS},;-I>>")
target_link_libraries(femdem_dependencies INTERFACE ${HDF5_Fortran_LIBRARIES})

find_library(METIS_LIBRARY metis REQUIRED)
target_link_libraries(femdem_dependencies INTERFACE ${METIS_LIBRARY})

find_package(LAPACK REQUIRED)
target_link_libraries(femdem_dependencies INTERFACE ${LAPACK_LIBRARIES})
