// NVRTC: see nvrtc.h. Declared from its manual, https://docs.nvidia.com/cuda/nvrtc/.
#include "backend/cuda/nvrtc.h"

#include <dlfcn.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "omma/error.h"
#include "threads/parallel.h"

namespace omma {
namespace {

using Program = void*;
using Result = int;  // 0: success

constexpr const char* names[] = {"libnvrtc.so.13", "libnvrtc.so.12"};

std::string reason() {
  const char* said = dlerror();
  return said != nullptr ? said : "unknown error";
}

const char* named_by_user() {
  const char* named = std::getenv("OMMA_NVRTC");
  return named != nullptr && *named != '\0' ? named : nullptr;
}

// What a user can do about it.
std::string how() {
  if (named_by_user() != nullptr) return "; OMMA_NVRTC names it";
  return "; install it by pip install 'omma[cuda]' (with a driver for CUDA 12, 'omma[cuda12]'), or "
         "name the library by OMMA_NVRTC";
}

struct Library {
  void* handle;
  std::string path;
};

Library open_library(const std::string& path) {
  const char* named = named_by_user();
  const std::string chosen = named != nullptr ? named : path;
  if (!chosen.empty()) {
    if (void* handle = dlopen(chosen.c_str(), RTLD_NOW | RTLD_LOCAL)) return {handle, chosen};
    throw Error("NVRTC, the compiler of kernels, cannot be loaded: " + reason() + how());
  }
  for (const char* name : names)
    if (void* handle = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return {handle, name};
  throw Error("NVRTC, the compiler of kernels, is not here: " + reason() + how());
}

template <typename Function>
void find_function(const Library& library, const char* name, Function*& function) {
  function = reinterpret_cast<Function*>(dlsym(library.handle, name));
  if (function == nullptr)
    throw Error(library.path + ": is not NVRTC, or is too old: it has no function " + name +
                how());
}

// The compiler asks from any of its threads.
int is_cancelled(void* flag, void*) {
  return static_cast<const std::atomic<bool>*>(flag)->load() ? 1 : 0;
}

}  // namespace

struct Nvrtc::Functions {
  const char* (*error_string)(Result);
  Result (*version)(int*, int*);
  Result (*architecture_count)(int*);
  Result (*architectures)(int*);
  Result (*create)(Program*, const char*, const char*, int, const char* const*, const char* const*);
  Result (*destroy)(Program*);
  Result (*compile)(Program, int, const char* const*);
  Result (*cubin_size)(Program, std::size_t*);
  Result (*cubin)(Program, char*);
  Result (*log_size)(Program, std::size_t*);
  Result (*log)(Program, char*);
  Result (*set_flow_callback)(Program, int (*)(void*, void*), void*);

  void check(Result result, const std::string& what) const {
    if (result != 0) throw Error("NVRTC: " + what + ": " + error_string(result));
  }
};

Nvrtc::Nvrtc(const std::string& path) {
  const Library library = open_library(path);
  auto found = std::make_unique<Functions>();
  find_function(library, "nvrtcGetErrorString", found->error_string);
  find_function(library, "nvrtcVersion", found->version);
  find_function(library, "nvrtcGetNumSupportedArchs", found->architecture_count);
  find_function(library, "nvrtcGetSupportedArchs", found->architectures);
  find_function(library, "nvrtcCreateProgram", found->create);
  find_function(library, "nvrtcDestroyProgram", found->destroy);
  find_function(library, "nvrtcCompileProgram", found->compile);
  find_function(library, "nvrtcGetCUBINSize", found->cubin_size);
  find_function(library, "nvrtcGetCUBIN", found->cubin);
  find_function(library, "nvrtcGetProgramLogSize", found->log_size);
  find_function(library, "nvrtcGetProgramLog", found->log);
  find_function(library, "nvrtcSetFlowCallback", found->set_flow_callback);
  int major = 0, minor = 0, count = 0;
  found->check(found->version(&major, &minor), "its version");
  found->check(found->architecture_count(&count), "its architectures");
  architectures_.resize(static_cast<std::size_t>(count));
  found->check(found->architectures(architectures_.data()), "its architectures");
  version_ = std::to_string(major) + "." + std::to_string(minor);
  path_ = library.path;
  functions_ = std::move(found);
}

Nvrtc::~Nvrtc() = default;

Nvrtc::Compiled Nvrtc::compile(std::span<const KernelSource> sources, std::string_view program,
                               const std::vector<std::string>& options) const {
  const Functions& nvrtc = *functions_;
  std::vector<const char*> texts, included, given;
  const KernelSource* main = nullptr;
  for (const KernelSource& source : sources) {
    if (source.name == program) {
      main = &source;
      continue;
    }
    texts.push_back(source.text);
    included.push_back(source.name);
  }
  for (const std::string& option : options) given.push_back(option.c_str());

  struct Owned {
    const Functions& nvrtc;
    Program program = nullptr;
    ~Owned() { nvrtc.destroy(&program); }
  } of{nvrtc};
  nvrtc.check(nvrtc.create(&of.program, main->text, main->name, static_cast<int>(texts.size()),
                           texts.data(), included.data()),
              "a program");
  const std::atomic<bool>* const flag = cancel_flag();
  if (flag != nullptr)
    nvrtc.check(
        nvrtc.set_flow_callback(of.program, is_cancelled, const_cast<std::atomic<bool>*>(flag)),
        "cancelling");
  const Result result = nvrtc.compile(of.program, static_cast<int>(given.size()), given.data());
  check_cancelled();

  Compiled compiled;
  std::size_t size = 0;
  nvrtc.check(nvrtc.log_size(of.program, &size), "the log");
  compiled.log.resize(size);
  nvrtc.check(nvrtc.log(of.program, compiled.log.data()), "the log");
  while (!compiled.log.empty() && compiled.log.back() == '\0') compiled.log.pop_back();
  nvrtc.check(result, "the kernels do not compile: " + compiled.log);
  nvrtc.check(nvrtc.cubin_size(of.program, &size), "the cubin");
  compiled.cubin.resize(size);
  nvrtc.check(nvrtc.cubin(of.program, compiled.cubin.data()), "the cubin");
  return compiled;
}

}  // namespace omma
