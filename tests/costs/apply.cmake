# Included by ctest after all tests are known (CMakeLists.txt). A test that is gone, or is not in
# this preset, is passed over; one that COSTS doesn't have keeps what ctest measured here last.
file(STRINGS ${costs} lines REGEX "^[^#]")
foreach(line IN LISTS lines)
  if(line MATCHES "^ *([0-9.]+) +(.+)$")
    set_tests_properties("${CMAKE_MATCH_2}" PROPERTIES COST ${CMAKE_MATCH_1})
  endif()
endforeach()
