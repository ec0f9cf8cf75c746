// Kernels of a card: see compile.h.
#include "backend/cuda/compile.h"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string_view>

#include "io/atomic_file.h"
#include "omma/error.h"

namespace omma {
namespace {

// In front of what is kept, with its check sum; raised where that changes.
constexpr std::string_view magic = "omma kernels 1\n";
constexpr std::size_t digits = 16;

// FNV-1a (Fowler, Noll, Vo), 64 bits: of what nobody forges.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes) step(static_cast<unsigned char>(byte));
  }
  // With an end, so that no two rows of texts read alike.
  void add_text(std::string_view text) {
    add(text);
    step(0);
  }
  std::string hexadecimal() const {
    char text[digits + 1];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
    return text;
  }

 private:
  void step(unsigned char byte) { hash_ = (hash_ ^ byte) * 0x100000001b3u; }

  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

std::string hash_of(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return hash.hexadecimal();
}

std::string cache_name(const Nvrtc& nvrtc, const std::vector<std::string>& options,
                       const char* program) {
  Hash hash;
  hash.add_text(nvrtc.version());
  hash.add_text(program);
  for (const std::string& option : options) hash.add_text(option);
  for (const KernelSource& source : kernel_sources()) {
    hash.add_text(source.name);
    hash.add_text(source.text);
  }
  return "kernels-" + hash.hexadecimal() + ".cubin";
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
