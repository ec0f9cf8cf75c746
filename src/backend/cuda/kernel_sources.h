// The sources of the kernels, as files: the library carries them, so that they can be compiled
// where it runs. cmake/embed_kernels.cmake writes kernel_sources.cpp.
#pragma once

#include <span>

namespace omma {

struct KernelSource {
  const char* name;  // by which includes know it
  const char* text;
};

// kernels.cu, then what it includes.
std::span<const KernelSource> kernel_sources();

}  // namespace omma
