// Kernels of a card: see compile.h.
#include "backend/cuda/compile.h"

#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include "io/atomic_file.h"
#include "omma/error.h"

namespace omma {
namespace {

// In front of what is kept, with its check sum; raised where that changes.
constexpr std::string_view magic = "omma kernels 1\n";
constexpr std::size_t digits = 16;

// By the standard library, of what nobody forges: another library's only compiles anew.
std::string hash_of(std::string_view bytes) {
  char text[digits + 1];
  std::snprintf(text, sizeof text, "%016zx", std::hash<std::string_view>{}(bytes));
  return text;
}

std::string cache_name(const Nvrtc& nvrtc, const std::vector<std::string>& options,
                       const char* program) {
  // Each with an end, so that no two rows of texts read alike.
  std::string all;
  const auto add = [&](std::string_view text) { all.append(text).push_back('\0'); };
  add(nvrtc.version());
  add(program);
  for (const std::string& option : options) add(option);
  for (const KernelSource& source : kernel_sources()) {
    add(source.name);
    add(source.text);
  }
  return "kernels-" + hash_of(all) + ".cubin";
}

// What is kept there; nothing where nothing is, or it is not whole.
std::optional<std::string> read_kept(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return {};
  try {
    const std::string kept = read_file(path);
    const std::size_t head = magic.size() + digits;
    if (kept.size() <= head || !kept.starts_with(magic)) return {};
    std::string cubin = kept.substr(head);
    if (kept.compare(magic.size(), digits, hash_of(cubin)) != 0) return {};
    return cubin;
  } catch (const Error&) {
    return {};  // it cannot be read
  }
}

void keep(const std::string& folder, const std::string& path, const std::string& cubin) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(folder + ": cannot be made: " + error.message());
  write_file_atomically(path, std::string(magic) + hash_of(cubin) + cubin);
}

}  // namespace

std::vector<std::string> compile_options(const Nvrtc& nvrtc, int capability) {
  // A cubin runs on later cards of its generation.
  int architecture = 0;
  for (const int known : nvrtc.architectures())
    if (known / 10 == capability / 10 && known <= capability) architecture = known;
  if (architecture == 0)
    throw Error("NVRTC " + nvrtc.version() + " does not compile for a card of compute capability " +
                std::to_string(capability / 10) + "." + std::to_string(capability % 10) +
                "; another version may: pip install --upgrade 'omma[cuda]'");
  // Nothing is fused and denormals are zeros, as on processors (backend/denormals.h). Lambdas are a
  // card's without being marked, which NVRTC 12 does not know by itself.
  return {"-std=c++20", "--fmad=false", "--ftz=true", "-default-device",
          "-arch=sm_" + std::to_string(architecture)};
}

CompiledKernels compile_kernels(int capability, const std::string& nvrtc_path,
                                const std::string& cache_folder, const char* program) {
  const Nvrtc nvrtc(nvrtc_path);
  std::vector<std::string> options = compile_options(nvrtc, capability);
  options.push_back("--split-compile=0");  // on all threads
  if (cache_folder.empty()) return {nvrtc.compile(kernel_sources(), program, options).cubin, {}};
  const std::string path =
      (std::filesystem::path(cache_folder) / cache_name(nvrtc, options, program)).string();
  if (std::optional<std::string> kept = read_kept(path)) return {std::move(*kept), {}};
  CompiledKernels compiled{nvrtc.compile(kernel_sources(), program, options).cubin, {}};
  try {
    keep(cache_folder, path, compiled.cubin);
  } catch (const Error& error) {
    compiled.note = error.what();
  }
  return compiled;
}

}  // namespace omma
