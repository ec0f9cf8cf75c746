// Kernels of a card from their sources, compiled once and kept.
#pragma once

#include <string>
#include <vector>

#include "backend/cuda/nvrtc.h"

namespace omma {

struct CompiledKernels {
  std::string cubin;
  std::string note;  // why they are not kept, or empty
};

// A program for a card of that compute capability, 90 for 9.0, by the NVRTC that is found (nvrtc.h)
// with `nvrtc_path`. Kept in `cache_folder`, which is made where it is not there; "" for none.
// Throws omma::Error where there is no NVRTC, it does not know the card, or it fails;
// omma::Cancelled.
CompiledKernels compile_kernels(int capability, const std::string& nvrtc_path,
                                const std::string& cache_folder,
                                const char* program = render_program);

// The options that kernels for a card are compiled with, but for that of threads, with which code
// differs a little. Throws omma::Error where NVRTC knows no architecture that runs on it.
std::vector<std::string> compile_options(const Nvrtc& nvrtc, int capability);

}  // namespace omma
