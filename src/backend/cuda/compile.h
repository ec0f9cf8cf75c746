// Kernels of a card: those that came with Omma, or from their sources, compiled once and kept.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "backend/cuda/nvrtc.h"

namespace omma {

// For which card kernels are, and where they are looked for.
struct KernelRequest {
  int capability = 0;      // of the card, 90 for 9.0
  std::string nvrtc{};     // the compiler (nvrtc.h)
  std::string cache{};     // folder that they are kept in, made where it is not there; "": none
  std::string packaged{};  // folder of kernels that came with Omma, only read; "": none
  int newest_cuda = 0;     // major version of CUDA up to which the driver takes those

  auto operator<=>(const KernelRequest&) const = default;
};

struct CompiledKernels {
  std::string cubin;
  std::string note;  // why they are not kept, or empty
};

// A program that came with Omma or is kept, else compiled. Throws omma::Error where it is to be
// compiled and there is no NVRTC, it does not know the card, or it fails; omma::Cancelled, when
// NVRTC asks next, which may take half a minute.
CompiledKernels compile_kernels(const KernelRequest& request, const char* program = render_program);

// That came with Omma, of the same sources, for the latest architecture that runs on the card;
// nothing where there is none. Needs no NVRTC.
std::optional<std::string> packaged_kernels(const KernelRequest& request, const char* program);

// Whether a thread of this process is compiling kernels now, which takes a minute.
bool compiling_kernels();

// The options that kernels for a card are compiled with. Throws omma::Error where NVRTC knows no
// architecture that runs on it.
std::vector<std::string> compile_options(const Nvrtc& nvrtc, int capability);

}  // namespace omma
