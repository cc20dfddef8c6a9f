# Language, warnings and the flags on which bit-equality rests (docs/DETERMINISM).
set(SLEIGHT_TESTS fast CACHE STRING
  "Tests to build. fast: those of deploy/test; all: those of deploy/test --all; shells: all but the computing libraries' unit tests; OFF: none")
set_property(CACHE SLEIGHT_TESTS PROPERTY STRINGS fast all shells OFF)
if(SLEIGHT_TESTS AND NOT SLEIGHT_TESTS MATCHES "^(fast|all|shells)$")
  message(FATAL_ERROR "SLEIGHT_TESTS is '${SLEIGHT_TESTS}'; it can be fast, all, shells or OFF")
endif()
option(SLEIGHT_WERROR "Treat compiler warnings as errors. CI does; other compilers warn of other things" OFF)
option(SLEIGHT_SHELLS "Build the programs and what touches files, MPI and disks; OFF: physics, sampling, worlds and the scheduler alone, on a machine that need not have those libraries" ON)
option(SLEIGHT_GALLERY "Build the page of `sleight gallery`, by npm's packages (deploy/install-deps); OFF: `sleight gallery` says that it isn't there" ON)
option(SLEIGHT_FUZZ "Build the fuzz targets instead of the programs' tests (clang only)" OFF)
set(SLEIGHT_SANITIZE "" CACHE STRING "Value for -fsanitize=, empty for none")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
# CHECK stays on in release, so NDEBUG only silences the libraries' own asserts.
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")

# Everything of ours is built with these; INTERFACE so that each target opts in by linking.
add_library(sleight_options INTERFACE)
target_compile_options(sleight_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor
  $<$<BOOL:${SLEIGHT_WERROR}>:-Werror>
  # A fused multiply-add rounds once where two instructions round twice: other bits on other CPUs.
  -ffp-contract=off
  # No code reads errno or floating-point exceptions after arithmetic. So square roots and roundings
  # are instructions, not calls. Results keep their bits; HI and a die take 2% fewer
  # instructions.
  -fno-math-errno -fno-trapping-math
  # For all, as some libraries ask for it: a precompiled header is for one set of macros.
  -pthread
  # The broad phase joins verdicts with & on purpose: without a branch.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>
  # GCC's own garbage collection costs a twelfth of its time; an object needs less than this many kB.
  $<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=1000000>)
target_include_directories(sleight_options INTERFACE ${CMAKE_SOURCE_DIR})
if(SLEIGHT_SANITIZE)
  target_compile_options(sleight_options INTERFACE
    -fsanitize=${SLEIGHT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(sleight_options INTERFACE -fsanitize=${SLEIGHT_SANITIZE})
  target_compile_definitions(sleight_options INTERFACE SLEIGHT_SANITIZED=1)
  if(SLEIGHT_SANITIZE MATCHES thread AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # GCC 12 takes a moved variant for uninitialised there.
    target_compile_options(sleight_options INTERFACE -Wno-maybe-uninitialized)
  endif()
endif()
if(SLEIGHT_FUZZ)
  target_compile_options(sleight_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# A test's own objects take two fifths less time to compile than with -O3. The libraries under test
# keep the flags that are shipped.
add_library(sleight_options_tests INTERFACE)
target_compile_options(sleight_options_tests INTERFACE $<$<CONFIG:Release>:-O1>)
add_library(sleight_options_computing_tests INTERFACE)
# With sanitizers GCC's -Og in place of -O1 saves three tenths of what a test's object takes to compile
# (six of them: 47 s of processor in place of 66 s), with all checks.
if(SLEIGHT_SANITIZE MATCHES undefined)
  foreach(kind IN ITEMS tests computing_tests)
    target_compile_options(sleight_options_${kind} INTERFACE
      $<IF:$<CXX_COMPILER_ID:Clang>,-O0,-Og>
      $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>)  # which GCC's -Wconversion doesn't warn of
  endforeach()
endif()

# Shells (SleightTargets.cmake) wait for files, sockets and people. With -O1 they compile in seven
# tenths of the time of -O3; with clang's sanitizers in half the time without any optimisation.
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
