# Finds all external libraries; all are Debian 12 packages (deploy/install-deps).
# Libraries for physics, sampling, worlds and the scheduler.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(fmt REQUIRED)
find_package(tomlplusplus REQUIRED)
pkg_check_modules(SLEEF REQUIRED IMPORTED_TARGET sleef)

# Debian installs Eigen and Random123 as headers on the default path. SYSTEM silences warnings in them.
find_path(EIGEN_INCLUDE Eigen/Core PATH_SUFFIXES eigen3 REQUIRED)
add_library(sleight_eigen INTERFACE)
target_include_directories(sleight_eigen SYSTEM INTERFACE ${EIGEN_INCLUDE})
find_path(RANDOM123_INCLUDE Random123/philox.h REQUIRED)

# Libraries for the shells; tests/tidy checks which folder uses which.
if(SLEIGHT_SHELLS)
  find_package(CLI11 REQUIRED)
  find_package(CapnProto REQUIRED)
  # clang needs this to compile the headers of Cap'n Proto; see kj_comparisons.h.
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
  # "hdf5" may be the parallel build, so this names the serial one.
  pkg_check_modules(HDF5_SERIAL REQUIRED IMPORTED_TARGET hdf5-serial)
  find_library(HDF5_HL_LIBRARY hdf5_hl PATHS /usr/lib/x86_64-linux-gnu/hdf5/serial
               NO_DEFAULT_PATH REQUIRED)
  add_library(sleight_hdf5 INTERFACE)
  target_link_libraries(sleight_hdf5 INTERFACE ${HDF5_HL_LIBRARY} PkgConfig::HDF5_SERIAL)
  # Only the C interface: Open MPI's C++ bindings are no longer in the standard and need a library.
  target_compile_definitions(MPI::MPI_C INTERFACE OMPI_SKIP_MPICXX=1)
endif()
