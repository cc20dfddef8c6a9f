# Unity builds: sources are compiled a dozen at a time. The compiler then reads headers and instantiates their
# templates (containers, formatting, Eigen, CLI11, GoogleTest) once. This takes half the time of compiling each source
# alone, which `-DSLEIGHT_TOGETHER=OFF` (preset debug) does.
option(SLEIGHT_TOGETHER "Compile sources a dozen at a time" ON)

#   sleight_compile_together(TARGET)
# Compiles twelve sources at a time, in the order of their list. So names in unnamed namespaces must be unique
# within a target. A test with common names (mostly seeds) uses a namespace with its file's name instead. CMake
# compiles a source with its own options alone.
function(sleight_compile_together target)
  if(NOT SLEIGHT_TOGETHER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
  # GCC mistakes included sources for headers and warns about unnamed namespaces in them.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()
