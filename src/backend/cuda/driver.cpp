// Finds the driver's functions, and puts its errors into words.
#include "backend/cuda/driver.h"

#include <dlfcn.h>

#include <cstdlib>

namespace omma {
namespace {

template <typename Function>
void find(void* library, const std::string& path, const char* name, Function*& function) {
  function = reinterpret_cast<Function*>(dlsym(library, name));
  if (function == nullptr)
    throw Error(path + ": expected a CUDA driver of version 12 or newer, found no " + name +
                "; update NVIDIA's driver");
}

// What a user can do about an error of the driver.
const char* help_for(int error) {
  switch (error) {
    case driver_not_initialized:
      return "; a process that was forked after its parent used the card cannot use it: start "
             "workers by spawn";
    case 803:  // CUDA_ERROR_SYSTEM_DRIVER_MISMATCH
    case 222:  // CUDA_ERROR_UNSUPPORTED_PTX_VERSION
    case 209:  // CUDA_ERROR_NO_BINARY_FOR_GPU
      return "; the driver is older than the compiler of the kernels: update it, or install an "
             "older nvidia-cuda-nvrtc";
    case 700:  // CUDA_ERROR_ILLEGAL_ADDRESS
    case 719:  // CUDA_ERROR_LAUNCH_FAILED
      return "; the card cannot be used any more by this process, which has to be started anew";
    default:
      return "";
  }
}

}  // namespace

DriverFunctions load_driver(const std::string& wanted) {
  const char* const named = std::getenv("OMMA_CUDA_DRIVER");
  const std::string path = named != nullptr && *named != '\0' ? named : wanted;
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const why = dlerror();
    throw NoCard("cuda: expected NVIDIA's driver, found none (" +
                 std::string(why != nullptr ? why : path) + ")");
  }
  DriverFunctions driver;
  const auto find_all = [&](const char* name, auto*& function) {
    find(library, path, name, function);
  };
  find_all("cuInit", driver.init);
  find_all("cuDriverGetVersion", driver.version);
  find_all("cuDeviceGetCount", driver.card_count);
  find_all("cuDeviceGet", driver.card);
  find_all("cuDeviceGetName", driver.card_name);
  find_all("cuDeviceGetAttribute", driver.attribute);
  find_all("cuDevicePrimaryCtxRetain", driver.retain_context);
  find_all("cuCtxSetCurrent", driver.set_context);
  find_all("cuMemGetInfo_v2", driver.memory_info);
  find_all("cuMemAlloc_v2", driver.allocate);
  find_all("cuMemFree_v2", driver.free);
  find_all("cuMemcpyHtoD_v2", driver.copy_to_card);
  find_all("cuMemcpyDtoH_v2", driver.copy_from_card);
  find_all("cuModuleLoadData", driver.load_module);
  find_all("cuModuleGetFunction", driver.function);
  find_all("cuOccupancyMaxActiveBlocksPerMultiprocessor", driver.blocks_at_once);
  find_all("cuLaunchKernel", driver.launch);
  find_all("cuCtxSynchronize", driver.synchronize);
  find_all("cuStreamSynchronize", driver.synchronize_stream);
  find_all("cuPointerGetAttribute", driver.pointer_attribute);
  find_all("cuGetErrorName", driver.error_name);
  find_all("cuGetErrorString", driver.error_text);
  return driver;
}

void check_driver(const DriverFunctions& driver, int result, const char* call,
                  const std::string& who) {
  if (result == 0) return;
  const char *name = nullptr, *text = nullptr;
  driver.error_name(result, &name);
  driver.error_text(result, &text);
  throw Error(who + ": " + call + " failed: " + (text != nullptr ? text : "unknown error") + " (" +
              (name != nullptr ? name : std::to_string(result)) + ")" + help_for(result));
}

}  // namespace omma
