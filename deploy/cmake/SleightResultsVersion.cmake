# The results version: a hash of the sources and flags that determine what a run stores. Changes of pages,
# service or documents don't change it, so existing runs can still be resumed (docs/DETERMINISM.md).
#
# worker/run and the libraries that it links compute the results. deploy/version --results hashes the files
# that the compiler opened for their objects, except files of libraries marked DECIDES_NOTHING. worker/run
# only passes on the readers of those. No other library that computes may link them; this file checks that.

# All our libraries that `root` links, and itself.
function(sleight_libraries_under root out)
  set(all)
  set(next ${root})
  while(next)
    list(POP_FRONT next name)
    if(name IN_LIST all OR NOT TARGET ${name})
      continue()
    endif()
    get_target_property(folder ${name} SLEIGHT_FOLDER)
    if(NOT folder)
      continue()
    endif()
    list(APPEND all ${name})
    get_target_property(links ${name} SLEIGHT_LINKS)
    if(links)
      list(APPEND next ${links})
    endif()
  endwhile()
  set(${out} ${all} PARENT_SCOPE)
endfunction()

#   sleight_results_version(worker_run OUTPUT file.cpp)
# Writes results_version() of clients/cli/results_version.h, after the parts of `root` have been compiled.
# results_version.json in the build folder lists these parts.
function(sleight_results_version root)
  cmake_parse_arguments(ARG "" "OUTPUT" "" ${ARGN})
  if(NOT CMAKE_GENERATOR STREQUAL "Ninja")
    message(FATAL_ERROR "The generator is ${CMAKE_GENERATOR}, but the results version needs Ninja: "
                        "use cmake --preset release")
  endif()
  if(CMAKE_SOURCE_DIR STREQUAL CMAKE_BINARY_DIR)
    message(FATAL_ERROR "The build folder must not be the source folder: use cmake --preset release")
  endif()
  sleight_libraries_under(${root} libraries)
  set(deciding)
  set(left_out)
  foreach(name IN LISTS libraries)
    get_target_property(nothing ${name} SLEIGHT_DECIDES_NOTHING)
    if(nothing)
      get_target_property(folder ${name} SLEIGHT_FOLDER)
      list(APPEND left_out ${folder})
    else()
      list(APPEND deciding ${name})
    endif()
  endforeach()
  set(built)
  foreach(name IN LISTS deciding)
    get_target_property(links ${name} SLEIGHT_LINKS)
    foreach(link IN LISTS links)
      if(NOT TARGET ${link} OR name STREQUAL root)
        continue()
      endif()
      get_target_property(nothing ${link} SLEIGHT_DECIDES_NOTHING)
      if(nothing)
        message(FATAL_ERROR "${name} computes results, so it must not link ${link}, which is marked DECIDES_NOTHING")
      endif()
    endforeach()
    get_target_property(type ${name} TYPE)
    if(type STREQUAL STATIC_LIBRARY)
      list(APPEND built ${name})
    endif()
  endforeach()
  list(TRANSFORM deciding REPLACE ".+" "\"\\0\"")
  list(TRANSFORM left_out REPLACE ".+" "\"\\0\"")
  list(JOIN deciding ", " deciding)
  list(JOIN left_out ", " left_out)
  set(decides ${CMAKE_BINARY_DIR}/results_version.json)
  file(CONFIGURE OUTPUT ${decides} CONTENT "{\"libraries\": [${deciding}],
 \"left_out\": [${left_out}],
 \"source\": \"${CMAKE_SOURCE_DIR}\",
 \"linked\": [\"${SLEEF_LINK_LIBRARIES}\"],
 \"compiler\": \"${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}\"}\n")
  add_custom_command(OUTPUT ${ARG_OUTPUT}
    COMMAND ${CMAKE_SOURCE_DIR}/deploy/version --results ${CMAKE_BINARY_DIR} --cpp ${ARG_OUTPUT}
    DEPENDS ${built} ${decides} ${CMAKE_SOURCE_DIR}/deploy/version
            ${CMAKE_SOURCE_DIR}/deploy/cmake/results_version.py
    COMMENT "Results version" VERBATIM)
endfunction()
