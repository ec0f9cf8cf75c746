# Writes a C++ file that holds the kernels' sources (src/backend/cuda/kernel_sources.h): the
# programs, all that they include, and the few headers that stand in for standard ones.
#   cmake -DROOT=<repository> -DOUTPUT=<file> -P embed_kernels.cmake
cmake_minimum_required(VERSION 3.22)
set(rows "")
set(waiting backend/cuda/kernels.cu backend/cuda/gather_kernel.cu)
set(known ${waiting})

function(add_row name file)
  file(READ ${file} text)
  set(rows "${rows}  {\"${name}\",\nR\"omma_kernels(${text})omma_kernels\"},\n" PARENT_SCOPE)
endfunction()

while(waiting)
  list(POP_FRONT waiting name)
  set(file ${ROOT}/src/${name})
  if(NOT EXISTS ${file})
    set(file ${ROOT}/include/${name})
  endif()
  if(NOT EXISTS ${file})
    message(FATAL_ERROR "kernels include ${name}, which is neither in src nor in include")
  endif()
  add_row(${name} ${file})
  file(STRINGS ${file} includes REGEX "^#include \"")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" include "${include}")
    if(NOT include IN_LIST known)
      list(APPEND known ${include})
      list(APPEND waiting ${include})
    endif()
  endforeach()
endwhile()
file(GLOB stand_ins ${ROOT}/src/backend/cuda/device_headers/*)
foreach(file IN LISTS stand_ins)
  get_filename_component(name ${file} NAME)
  add_row(${name} ${file})
endforeach()

file(WRITE ${OUTPUT}.new "// Written by cmake/embed_kernels.cmake.
#include \"backend/cuda/kernel_sources.h\"

namespace omma {
namespace {

const KernelSource sources[] = {
${rows}};

}  // namespace

std::span<const KernelSource> kernel_sources() {
  return sources;
}

}  // namespace omma
")
# Only where it has changed, so that nothing is compiled in vain.
execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different ${OUTPUT}.new ${OUTPUT})
file(REMOVE ${OUTPUT}.new)
