# Precompiled headers: the compiler parses external headers (2.5 MB of libstdc++, 1.7 MB of Eigen) once
# per set of flags instead of once per object.
#
# Sources don't depend on this: each includes what it uses. `-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON` builds
# without precompiled headers. Our own headers are left out, since each change of one would rebuild everything.
# GCC uses a precompiled header only with the same flags and macros, and otherwise warns (-Winvalid-pch).

set(SLEIGHT_PRECOMPILED
  <algorithm> <array> <atomic> <bit> <chrono> <cmath> <compare> <concepts> <cstdint> <cstdlib>
  <cstring> <deque> <filesystem> <fstream> <functional> <iterator> <limits> <map> <memory> <mutex>
  <numbers> <numeric> <optional> <ranges> <set> <span> <sstream> <string> <string_view> <thread>
  <tuple> <utility> <variant> <vector>
  <fmt/format.h> <fmt/ranges.h>
  <Eigen/Core> <Eigen/Geometry>)

#   sleight_precompiled(NAME LINKS libraries... [HEADERS more...] [OPTIONS flags...])
# An object library without sources, whose precompiled header other targets use by REUSE_FROM.
function(sleight_precompiled name)
  cmake_parse_arguments(ARG "" "" "LINKS;HEADERS;OPTIONS" ${ARGN})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "// Only its precompiled header is used.\n")
  add_library(${name} OBJECT ${source})
  target_link_libraries(${name} PRIVATE sleight_options sleight_eigen fmt::fmt ${ARG_LINKS})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${SLEIGHT_PRECOMPILED} ${ARG_HEADERS})
endfunction()
