# Sources that are compiled a few at a time, as one. Of shells and of tests, most of the time goes into
# what their libraries' headers make the compiler generate (CLI11, nlohmann's JSON, GoogleTest,
# Cap'n Proto), again in each object; together it is generated once.
#
# Sources don't see this: `-DSLEIGHT_TOGETHER=OFF` (preset debug) compiles each by itself, which is also
# what a change of one costs least with. Libraries that decide results are always compiled so, as
# their flags and files are read object by object (SleightResultsVersion.cmake).
option(SLEIGHT_TOGETHER "Compile sources of shells and tests a few at a time" ON)

#   sleight_compile_together(TARGET [APART a.cpp b.cpp])
# Eight at a time, in the order in which they are listed. Those that are APART have a name of their
# file's alone, in an unnamed namespace, that a neighbour has as well.
function(sleight_compile_together target)
  cmake_parse_arguments(ARG "" "" "APART" ${ARGN})
  if(NOT SLEIGHT_TOGETHER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
  # GCC takes a source's unnamed namespace for a header's when another file includes the source.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  if(ARG_APART)
    set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()
