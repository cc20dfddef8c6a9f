# ctest includes this file when all tests are known (CMakeLists.txt). Tests that don't exist in this preset
# are ignored. Tests missing from COSTS keep the cost that ctest measured here last.
file(STRINGS ${costs} lines REGEX "^[^#]")
foreach(line IN LISTS lines)
  if(line MATCHES "^ *([0-9.]+) +(.+)$")
    set_tests_properties("${CMAKE_MATCH_2}" PROPERTIES COST ${CMAKE_MATCH_1})
  endif()
endforeach()
