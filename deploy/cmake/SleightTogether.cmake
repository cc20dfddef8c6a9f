# Sources are compiled a dozen at a time, as one: headers are read once, and what they make the compiler
# generate (containers, formatting, Eigen, CLI11, GoogleTest) is generated once. That takes half the
# time of compiling each by itself, which `-DSLEIGHT_TOGETHER=OFF` (preset debug) does.
option(SLEIGHT_TOGETHER "Compile sources a dozen at a time" ON)

#   sleight_compile_together(TARGET)
# Twelve at a time, in the order in which they are listed. So names in unnamed namespaces are unique
# within a target; a test whose names others have too (mostly seeds) is in a namespace of its file's
# name instead. CMake itself compiles a source alone that has options of its own.
function(sleight_compile_together target)
  if(NOT SLEIGHT_TOGETHER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
  # Sources that others include look like headers to GCC, which warns of unnamed namespaces in these.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()
