# femdem_unit_test(test_xxx): build tests/unit/test_xxx.pf and register it with ctest.
# pFUnit runs the file where find_package finds it; elsewhere tests/pf_driver.py turns it into a plain program.
find_package(PFUNIT QUIET)
if(PFUNIT_FOUND)
  message(STATUS "Unit tests: pFUnit")
else()
  message(STATUS "Unit tests: stand-in for pFUnit (tests/pf_driver.py)")
  find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
  add_library(femdem_funit STATIC ${PROJECT_SOURCE_DIR}/tests/funit.f90)
  target_link_libraries(femdem_funit PRIVATE femdem_flags)
endif()

function(femdem_unit_test name)
  set(libraries femdem_core)
  if(TARGET femdem_test_support)
    list(APPEND libraries femdem_test_support)
  endif()
  if(PFUNIT_FOUND)
    add_pfunit_ctest(${name} TEST_SOURCES ${name}.pf LINK_LIBRARIES ${libraries})
    target_include_directories(${name} PRIVATE ${CMAKE_Fortran_MODULE_DIRECTORY})
    # pFUnit's generated code follows its own rules and writes a test's name twice in a line.
    # (Options of a source come last and win.)
    set_source_files_properties(
      ${CMAKE_CURRENT_BINARY_DIR}/${name}.F90 ${CMAKE_CURRENT_BINARY_DIR}/${name}_driver.F90
      PROPERTIES COMPILE_OPTIONS "-std=gnu;-Wno-error;-ffree-line-length-none")
  else()
    set(driver ${PROJECT_SOURCE_DIR}/tests/pf_driver.py)
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${name}.pf)
    set(generated ${CMAKE_CURRENT_BINARY_DIR}/${name}.f90)
    add_custom_command(OUTPUT ${generated}
      COMMAND ${Python3_EXECUTABLE} ${driver} ${source} ${generated}
      DEPENDS ${source} ${driver}
      COMMENT "Unit test ${name}.pf"
      VERBATIM)
    add_executable(${name} ${generated})
    target_link_libraries(${name} PRIVATE ${libraries} femdem_funit)
    # A test may compare reals exactly.
    target_compile_options(${name} PRIVATE -Wno-compare-reals -ffpe-summary=none)
    add_test(NAME ${name} COMMAND ${name})
    # The closing line, not the exit status alone: a `stop` inside the tested code would look like success.
    set_tests_properties(${name} PROPERTIES PASS_REGULAR_EXPRESSION "${name}: [0-9]+ passed, 0 failed")
  endif()
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  set_tests_properties(${name} PROPERTIES LABELS unit TIMEOUT 300)
endfunction()
