# Precompiled headers: what other projects' headers cost to parse (2.5 MB of libstdc++, 1.7 MB of
# Eigen) is paid once for each set of flags, not once for each object.
#
# Sources don't see this: each includes what it uses, and `-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON`
# builds without. Headers of ours are not in it, or a change of one would build everything anew.
# GCC takes such a header only where flags and macros are those that it was made with, and says so
# (-Winvalid-pch), which is an error here.

set(SLEIGHT_PRECOMPILED
  <algorithm> <array> <atomic> <bit> <chrono> <cmath> <compare> <concepts> <cstdint> <cstdlib>
  <cstring> <deque> <filesystem> <fstream> <functional> <iterator> <limits> <map> <memory> <mutex>
  <numbers> <numeric> <optional> <ranges> <set> <span> <sstream> <string> <string_view> <thread>
  <tuple> <utility> <variant> <vector>
  <fmt/format.h> <fmt/ranges.h>
  <Eigen/Core> <Eigen/Geometry>)

#   sleight_precompiled(NAME LINKS libraries... [HEADERS more...] [OPTIONS flags...])
# An object library of no source of its own, whose precompiled header others use by REUSE_FROM.
function(sleight_precompiled name)
  cmake_parse_arguments(ARG "" "" "LINKS;HEADERS;OPTIONS" ${ARGN})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "// Only its precompiled header is used.\n")
  add_library(${name} OBJECT ${source})
  target_link_libraries(${name} PRIVATE sleight_options sleight_eigen fmt::fmt ${ARG_LINKS})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${SLEIGHT_PRECOMPILED} ${ARG_HEADERS})
endfunction()
