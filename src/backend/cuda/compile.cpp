// Kernels of a card: see compile.h.
#include "backend/cuda/compile.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string_view>
#include <utility>

#include "io/atomic_file.h"
#include "omma/error.h"

namespace omma {
namespace {

// In front of what is kept, with its check sum; raised where that changes.
constexpr std::string_view magic = "omma kernels 1\n";
constexpr std::size_t digits = 16;

// Nothing is fused and denormals are zeros, as on processors (backend/denormals.h). Lambdas are a
// card's without being marked, which NVRTC 12 does not know by itself. On one thread: NVRTC 13.5
// crashes where --split-compile is cancelled.
constexpr const char* common_options[] = {"-std=c++20", "--fmad=false", "--ftz=true",
                                          "-default-device"};

std::atomic<int> compiling = 0;

// By the standard library, of what nobody forges: another library's only compiles anew.
std::string hash_of(std::string_view bytes) {
  char text[digits + 1];
  std::snprintf(text, sizeof text, "%016zx", std::hash<std::string_view>{}(bytes));
  return text;
}

// How files of a program begin: its name, and a hash of all that it is made of. Behind it they have
// the architecture and NVRTC's version, "80-nvrtc13.5.cubin".
std::string name_of(const char* program) {
  // Each with an end, so that no two rows of texts read alike.
  std::string all;
  const auto add = [&](std::string_view text) { all.append(text).push_back('\0'); };
  add(program);
  for (const char* option : common_options) add(option);
  for (const KernelSource& source : kernel_sources()) {
    add(source.name);
    add(source.text);
  }
  return std::filesystem::path(program).stem().string() + "-" + hash_of(all) + "-sm_";
}

// A cubin runs on later cards of its generation.
bool runs_on(int architecture, int capability) {
  return architecture / 10 == capability / 10 && architecture <= capability;
}

int architecture_for(const Nvrtc& nvrtc, int capability) {
  int architecture = 0;
  for (const int known : nvrtc.architectures())
    if (runs_on(known, capability)) architecture = known;
  if (architecture == 0)
    throw Error("NVRTC " + nvrtc.version() + " does not compile for a card of compute capability " +
                std::to_string(capability / 10) + "." + std::to_string(capability % 10) +
                "; another version may: pip install --upgrade 'omma[cuda]'");
  return architecture;
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
  std::vector<std::string> options(std::begin(common_options), std::end(common_options));
  options.push_back("-arch=sm_" + std::to_string(architecture_for(nvrtc, capability)));
  return options;
}

std::optional<std::string> packaged_kernels(const KernelRequest& request, const char* program) {
  if (request.packaged.empty()) return {};
  std::vector<std::pair<std::array<int, 3>, std::string>> found;  // what they are for, the path
  const std::string start = name_of(program);
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(request.packaged, error)) {
    const std::string name = entry.path().filename().string();
    std::array<int, 3> of{};  // architecture, NVRTC's major and minor version
    int read = 0;
    if (!name.starts_with(start)) continue;
    std::sscanf(name.c_str() + start.size(), "%d-nvrtc%d.%d.cubin%n", &of[0], &of[1], &of[2],
                &read);
    if (start.size() + static_cast<std::size_t>(read) == name.size() &&
        runs_on(of[0], request.capability) && of[1] <= request.newest_cuda)
      found.emplace_back(of, entry.path().string());
  }
  std::sort(found.rbegin(), found.rend());
  for (const auto& [of, path] : found)
    if (std::optional<std::string> cubin = read_kept(path)) return cubin;
  return {};
}

bool compiling_kernels() {
  return compiling > 0;
}

CompiledKernels compile_kernels(const KernelRequest& request, const char* program) {
  if (std::optional<std::string> cubin = packaged_kernels(request, program))
    return {std::move(*cubin), {}};
  const Nvrtc nvrtc(request.nvrtc);
  const std::string name = name_of(program) +
                           std::to_string(architecture_for(nvrtc, request.capability)) + "-nvrtc" +
                           nvrtc.version() + ".cubin";
  const std::string path = (std::filesystem::path(request.cache) / name).string();
  if (!request.cache.empty())
    if (std::optional<std::string> kept = read_kept(path)) return {std::move(*kept), {}};
  const struct Counted {
    Counted() { ++compiling; }
    ~Counted() { --compiling; }
  } counted;
  CompiledKernels compiled{
      nvrtc.compile(kernel_sources(), program, compile_options(nvrtc, request.capability)).cubin,
      {}};
  if (request.cache.empty()) return compiled;
  try {
    keep(request.cache, path, compiled.cubin);
  } catch (const Error& error) {
    compiled.note = error.what();
  }
  return compiled;
}

}  // namespace omma
