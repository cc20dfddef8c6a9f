# Every outside library, found once; all are Debian 12 packages (deploy/install-deps).
# What physics, sampling, worlds and the scheduler need.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(fmt REQUIRED)
find_package(tomlplusplus REQUIRED)
pkg_check_modules(SLEEF REQUIRED IMPORTED_TARGET sleef)

# Debian ships Eigen and Random123 as headers on the default path; SYSTEM keeps our warnings ours.
find_path(EIGEN_INCLUDE Eigen/Core PATH_SUFFIXES eigen3 REQUIRED)
add_library(sleight_eigen INTERFACE)
target_include_directories(sleight_eigen SYSTEM INTERFACE ${EIGEN_INCLUDE})
find_path(RANDOM123_INCLUDE Random123/philox.h REQUIRED)

# What the shells need; tests/tidy knows which folder may use which.
if(SLEIGHT_SHELLS)
  find_package(CLI11 REQUIRED)
  find_package(CapnProto REQUIRED)
  # What clang needs to compile its headers: see there.
  add_library(sleight_kj_comparisons INTERFACE)
  target_compile_options(sleight_kj_comparisons INTERFACE
    "$<$<CXX_COMPILER_ID:Clang>:SHELL:-include ${CMAKE_SOURCE_DIR}/common/schema/wire/kj_comparisons.h>")
  find_package(nlohmann_json REQUIRED)
  find_package(spdlog REQUIRED)
  find_package(OpenSSL REQUIRED COMPONENTS Crypto SSL)
  find_package(SQLite3 REQUIRED)
  find_package(MPI REQUIRED COMPONENTS C)
  pkg_check_modules(KJ_TLS REQUIRED IMPORTED_TARGET kj-tls)
  pkg_check_modules(RSVG REQUIRED IMPORTED_TARGET librsvg-2.0)
  pkg_check_modules(PNG REQUIRED IMPORTED_TARGET libpng)
  pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
  pkg_check_modules(SECCOMP REQUIRED IMPORTED_TARGET libseccomp)
  # "hdf5" may name the parallel build: the serial one is asked for by its own name.
  pkg_check_modules(HDF5_SERIAL REQUIRED IMPORTED_TARGET hdf5-serial)
  find_library(HDF5_HL_LIBRARY hdf5_hl PATHS /usr/lib/x86_64-linux-gnu/hdf5/serial
               NO_DEFAULT_PATH REQUIRED)
  add_library(sleight_hdf5 INTERFACE)
  target_link_libraries(sleight_hdf5 INTERFACE ${HDF5_HL_LIBRARY} PkgConfig::HDF5_SERIAL)
  # The C interface alone: Open MPI's C++ bindings are gone from the standard and need a library.
  target_compile_definitions(MPI::MPI_C INTERFACE OMPI_SKIP_MPICXX=1)
endif()
