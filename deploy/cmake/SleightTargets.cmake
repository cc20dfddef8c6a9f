# Functions by which a folder declares its targets.
#
#   sleight_library(SOURCES a.cpp b.cpp LINKS common_base Eigen... [DECIDES_NOTHING])   one per folder
#   sleight_program(sleight SOURCES main.cpp LINKS ...)               built in build/<preset>/bin
#   sleight_program_parts(mains SOURCES main_run.cpp LINKS ...)       parts that several programs share
#   sleight_test(SOURCES x_test.cpp LINKS common_math [ALL_SOURCES long_test.cpp] [ALL_TESTS Long.*:Suite.Name]
#                [LABELS slow] [TIMEOUT seconds] [COMPUTES])
#
# Sources of libraries, program parts and tests are compiled several at a time (SleightTogether.cmake).
#
# A test's own objects have less optimisation than the code under test, since compiling them takes longer than
# running them. COMPUTES marks tests that run longer than they compile.
#
# deploy/test --all compiles ALL_SOURCES and runs ALL_TESTS (a GoogleTest filter); deploy/test does neither
# (SLEIGHT_TESTS).
#
# A library's name is its folder with '/' as '_': common/math is common_math. DECIDES_NOTHING marks a library that
# only uses stored rows, so its changes don't change the results version (SleightResultsVersion.cmake).

function(sleight_folder_name out)
  file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  string(REPLACE "/" "_" name ${folder})
  set(${out} ${name} PARENT_SCOPE)
endfunction()

# Folders that mostly wait; all others compute.
set(SLEIGHT_SHELL_FOLDERS
  "^(clients|service)_|_readers$|^tests_(attacks|keepers|backends)$"
  "^common_(access|config|events|failure_file|json|logging|request|rpc|archive_reader_program)$")
string(REPLACE ";" "|" SLEIGHT_SHELL_FOLDERS "${SLEIGHT_SHELL_FOLDERS}")

# Flags and precompiled header of a folder's products.
function(sleight_product target)
  sleight_folder_name(name)
  if(name MATCHES "${SLEIGHT_SHELL_FOLDERS}" AND NOT name MATCHES "^(clients_browse|service_core)$")
    target_link_libraries(${target} PRIVATE sleight_options_shells)
    target_precompile_headers(${target} REUSE_FROM sleight_precompiled_shells)
  else()
    target_precompile_headers(${target} REUSE_FROM sleight_precompiled_products)
  endif()
endfunction()

function(sleight_library)
  cmake_parse_arguments(ARG "DECIDES_NOTHING" "" "SOURCES;LINKS" ${ARGN})
  sleight_folder_name(name)
  if(ARG_SOURCES)
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC sleight_options ${ARG_LINKS})
    sleight_product(${name})
    sleight_compile_together(${name})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE sleight_options ${ARG_LINKS})
  endif()
  set_target_properties(${name} PROPERTIES SLEIGHT_LINKS "${ARG_LINKS}"
    SLEIGHT_FOLDER ${CMAKE_CURRENT_SOURCE_DIR} SLEIGHT_DECIDES_NOTHING ${ARG_DECIDES_NOTHING})
endfunction()

function(sleight_program name)
  cmake_parse_arguments(ARG "NO_INSTALL" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE sleight_options ${ARG_LINKS})
  sleight_product(${name})
  if(NOT ARG_NO_INSTALL)
    install(TARGETS ${name} RUNTIME)
  endif()
endfunction()

# Parts that several programs' mains share, compiled once. Like mains, they may link all sides.
function(sleight_program_parts name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC sleight_options ${ARG_LINKS})
  sleight_product(${name})
  sleight_compile_together(${name})
endfunction()

function(sleight_test)
  cmake_parse_arguments(ARG "COMPUTES" "TIMEOUT;ALL_TESTS"
    "SOURCES;ALL_SOURCES;LINKS;LABELS" ${ARGN})
  sleight_folder_name(name)
  set(filter)
  if(NOT SLEIGHT_TESTS STREQUAL fast)
    list(APPEND ARG_SOURCES ${ARG_ALL_SOURCES})
  elseif(ARG_ALL_TESTS)
    set(filter TEST_FILTER "-${ARG_ALL_TESTS}")
  endif()
  set(kind tests)
  if(ARG_COMPUTES)
    set(kind computing_tests)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE sleight_options sleight_options_${kind} ${ARG_LINKS}
    tests_support)
  target_precompile_headers(${name} REUSE_FROM sleight_precompiled_${kind})
  sleight_compile_together(${name})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 ${filter}
    PROPERTIES LABELS ${ARG_LABELS} TIMEOUT ${ARG_TIMEOUT})
endfunction()
