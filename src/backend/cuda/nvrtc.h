// NVRTC, NVIDIA's compiler at run time, found where Omma runs: nothing of it is needed to build
// Omma. What is called of it is declared in nvrtc.cpp.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "backend/cuda/kernel_sources.h"

namespace omma {

class Nvrtc {
 public:
  // Loads the library at OMMA_NVRTC or, where that is not set, at `path` or, where that is empty,
  // where the system looks for libraries. It stays loaded. Throws omma::Error where there is none,
  // or it is none.
  explicit Nvrtc(const std::string& path);
  ~Nvrtc();
  Nvrtc(const Nvrtc&) = delete;
  Nvrtc& operator=(const Nvrtc&) = delete;

  const std::string& version() const { return version_; }  // as 13.5
  const std::string& path() const { return path_; }
  // Architectures that it compiles for, ascending, as 90 for sm_90.
  const std::vector<int>& architectures() const { return architectures_; }

  struct Compiled {
    std::string cubin;
    std::string log;  // warnings, and what options ask it to tell
  };
  // The source of that name, which includes others. Throws omma::Error with the log where it fails,
  // and omma::Cancelled.
  Compiled compile(std::span<const KernelSource> sources, std::string_view program,
                   const std::vector<std::string>& options) const;

 private:
  struct Functions;
  std::unique_ptr<const Functions> functions_;
  std::string path_, version_;
  std::vector<int> architectures_;
};

}  // namespace omma
