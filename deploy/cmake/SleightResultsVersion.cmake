# The results version: a hash of the sources and flags that decide what a run stores, so that a new
# page, service or document strands no run (docs/DETERMINISM.md).
#
# What decides is computed by the libraries that worker/run links, and by itself. The compiler has
# said which files went into their objects; deploy/version --results hashes these. Left out are the
# files of libraries that say DECIDES_NOTHING: worker/run hands their readers on, and no other library
# that computes may know them, which is checked here.

# All libraries of ours under one, itself included.
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
# Writes results_version() of clients/cli/results_version.h, when what `root` is made of has been
# compiled; results_version.json in the build's folder says what that is.
function(sleight_results_version root)
  cmake_parse_arguments(ARG "" "OUTPUT" "" ${ARGN})
  if(NOT CMAKE_GENERATOR STREQUAL "Ninja")
    message(FATAL_ERROR "Sleight is built by Ninja, whose record tells the results version: "
                        "cmake --preset release")
  endif()
  if(CMAKE_SOURCE_DIR STREQUAL CMAKE_BINARY_DIR)
    message(FATAL_ERROR "Build in another folder than the sources': cmake --preset release")
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
        message(FATAL_ERROR "${name} decides results and links ${link}, which says DECIDES_NOTHING")
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
