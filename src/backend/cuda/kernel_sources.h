// The sources of the kernels, as files: the library carries them, so that they can be compiled
// where it runs. What is declared here cmake/embed_kernels.cmake writes.
#pragma once

#include <span>

namespace omma {

struct KernelSource {
  const char* name;  // by which includes know it
  const char* text;
};

// The programs, each a source, then what they include.
inline constexpr const char* render_program = "backend/cuda/kernels.cu";
inline constexpr const char* gather_program = "backend/cuda/gather_kernel.cu";
std::span<const KernelSource> kernel_sources();

}  // namespace omma
