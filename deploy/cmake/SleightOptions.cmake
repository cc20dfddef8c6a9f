# Language, warnings, and the flags that keep results bit-identical (docs/DETERMINISM.md).
set(SLEIGHT_TESTS fast CACHE STRING
  "Tests to build. fast: as for deploy/test; all: as for deploy/test --all; shells: all except unit tests of libraries that compute; OFF: none")
set_property(CACHE SLEIGHT_TESTS PROPERTY STRINGS fast all shells OFF)
if(SLEIGHT_TESTS AND NOT SLEIGHT_TESTS MATCHES "^(fast|all|shells)$")
  message(FATAL_ERROR "SLEIGHT_TESTS is '${SLEIGHT_TESTS}'; expected fast, all, shells or OFF")
endif()
option(SLEIGHT_WERROR "Treat compiler warnings as errors, as in CI. Other compilers may have other warnings" OFF)
option(SLEIGHT_SHELLS "Build the programs and all code that uses files, MPI and networks. OFF: only physics, sampling, worlds and the scheduler, which need fewer libraries" ON)
option(SLEIGHT_GALLERY "Build the page of `sleight gallery`, with npm packages (deploy/install-deps). OFF: `sleight gallery` reports that the page is missing" ON)
option(SLEIGHT_FUZZ "Build the fuzz targets instead of the other tests (clang only)" OFF)
set(SLEIGHT_SANITIZE "" CACHE STRING "Value for -fsanitize=; empty: none")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
# CHECK stays on in release builds; NDEBUG only disables the asserts of libraries.
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")

# All our targets link this interface library to get these options.
add_library(sleight_options INTERFACE)
target_compile_options(sleight_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor
  $<$<BOOL:${SLEIGHT_WERROR}>:-Werror>
  # A fused multiply-add rounds once, two instructions round twice. So fusing would change bits between CPUs.
  -ffp-contract=off
  # No code reads errno or floating-point exceptions after arithmetic, so square roots and roundings can be
  # instructions instead of calls. Results keep their bits, and hi.toml and die.toml
  # execute 2% fewer instructions.
  -fno-math-errno -fno-trapping-math
  # For all targets, since some libraries need it and a precompiled header fits one set of macros.
  -pthread
  # The broad phase combines verdicts with & to avoid a branch.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>
  # GCC's garbage collection takes a twelfth of its time. Each object needs less memory than this (kB).
  $<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=1000000>)
target_include_directories(sleight_options INTERFACE ${CMAKE_SOURCE_DIR})
if(SLEIGHT_SANITIZE)
  target_compile_options(sleight_options INTERFACE
    -fsanitize=${SLEIGHT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(sleight_options INTERFACE -fsanitize=${SLEIGHT_SANITIZE})
  target_compile_definitions(sleight_options INTERFACE SLEIGHT_SANITIZED=1)
  if(SLEIGHT_SANITIZE MATCHES thread AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # With TSan, GCC 12 reports a moved variant as uninitialised.
    target_compile_options(sleight_options INTERFACE -Wno-maybe-uninitialized)
  endif()
endif()
if(SLEIGHT_FUZZ)
  target_compile_options(sleight_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# A test's own objects use -O1, which takes two fifths less compile time than -O3. The libraries under test keep
# the release flags.
add_library(sleight_options_tests INTERFACE)
target_compile_options(sleight_options_tests INTERFACE $<$<CONFIG:Release>:-O1>)
add_library(sleight_options_computing_tests INTERFACE)
# With sanitizers, GCC's -Og takes three tenths less compile time than -O1 (47 s instead of 66 s of CPU time for six
# objects), with all checks.
if(SLEIGHT_SANITIZE MATCHES undefined)
  foreach(kind IN ITEMS tests computing_tests)
    target_compile_options(sleight_options_${kind} INTERFACE
      $<IF:$<CXX_COMPILER_ID:Clang>,-O0,-Og>
      $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>)  # not part of GCC's -Wconversion
  endforeach()
endif()

# Shells (SleightTargets.cmake) mostly wait for files, sockets and people. They use -O1, which takes seven tenths of the
# compile time of -O3. With clang's sanitizers they use -O0, which halves the compile time.
add_library(sleight_options_shells INTERFACE)
if(SLEIGHT_SANITIZE MATCHES undefined AND CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  target_compile_options(sleight_options_shells INTERFACE -O0)
else()
  target_compile_options(sleight_options_shells INTERFACE $<$<CONFIG:Release>:-O1>)
endif()

find_program(SLEIGHT_CCACHE ccache)
if(SLEIGHT_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SLEIGHT_CCACHE})
endif()
