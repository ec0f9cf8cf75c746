// A stand-in for NVIDIA's driver, as a shared library: a card whose threads run in a process of
// their own (device_main.cpp), which has nothing of the host but the card's memory, so that a
// pointer into the host's ends it. Calls can be made to fail (emulated_driver.h).
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "backend/cuda/driver.h"
#include "emulated/device.h"
#include "emulated/emulated_driver.h"

namespace omma::test {
namespace {

constexpr int success = 0, invalid_value = 1, launch_failed = 719;

struct Emulated {
  int socket = -1;
  std::map<CardPointer, std::size_t> allocated;  // what is, in the order of addresses
  DeviceUse most;
  void* stream = nullptr;  // of the last launch
  std::string fails;  // the call that does
  int error = 0, times = 0;  // that it fails
};

Emulated& emulated() {
  static Emulated the_one;
  return the_one;
}

// Whether this call is one that fails now.
int failure(const char* call) {
  Emulated& e = emulated();
  if (e.fails != call || e.times == 0) return success;
  --e.times;
  return e.error;
}

// Maps the memory and starts the card's process.
bool start() {
  Emulated& e = emulated();
  if (e.socket >= 0) return true;
  const int memory = memfd_create("emulated card", 0);
  int ends[2];
  void* const wanted = reinterpret_cast<void*>(device_address);
  if (memory < 0 || ftruncate(memory, static_cast<off_t>(device_bytes)) != 0 ||
      socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0 ||
      mmap(wanted, device_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED_NOREPLACE, memory,
           0) != wanted)
    return false;
  const std::string memory_text = std::to_string(memory), end_text = std::to_string(ends[1]);
  if (fork() == 0) {
    close(ends[0]);
    execl(OMMA_EMULATED_DEVICE, OMMA_EMULATED_DEVICE, memory_text.c_str(), end_text.c_str(),
          static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  close(memory);
  e.socket = ends[0];
  fcntl(e.socket, F_SETFD, FD_CLOEXEC);
  return true;
}

// The first gap that is large enough; something lies between allocations.
CardPointer find_gap(std::size_t bytes) {
  CardPointer at = device_address;
  for (const auto& [begin, size] : emulated().allocated) {
    if (begin - at >= bytes) return at;
    at = begin + size;
  }
  return device_address + device_bytes - at >= bytes ? at : 0;
}

void* on_host(CardPointer at) {
  return reinterpret_cast<void*>(at);
}

}  // namespace
}  // namespace omma::test

using namespace omma::test;
using omma::CardPointer;

extern "C" {

DeviceUse emulated_take_use() {
  return std::exchange(emulated().most, {});
}

void* emulated_last_stream() {
  return emulated().stream;
}

void emulated_fail(const char* call, int error, int times) {
  emulated().fails = call;
  emulated().error = error;
  emulated().times = times;
}

int cuInit(unsigned) {
  if (const int error = failure("cuInit")) return error;
  return start() ? success : omma::driver_not_initialized;
}
int cuDriverGetVersion(int* version) {
  *version = 13000;
  if (failure("cuDriverGetVersion") != 0) *version = 11040;  // an old one
  return success;
}
int cuDeviceGetCount(int* count) {
  *count = failure("cuDeviceGetCount") != 0 ? 0 : 1;  // none
  return success;
}
int cuDeviceGet(int* device, int ordinal) {
  *device = ordinal;
  return failure("cuDeviceGet");
}
int cuDeviceGetName(char* name, int bytes, int) {
  std::strncpy(name, "emulated card", static_cast<std::size_t>(bytes));
  return failure("cuDeviceGetName");
}
int cuDeviceGetAttribute(int* value, int attribute, int) {
  *value = attribute == omma::capability_major ? 7 : attribute == omma::capability_minor ? 5 : 1;
  return failure("cuDeviceGetAttribute");
}
int cuDevicePrimaryCtxRetain(void** context, int) {
  *context = &emulated();
  return failure("cuDevicePrimaryCtxRetain");
}
int cuCtxSetCurrent(void* context) {
  if (context != &emulated()) return invalid_value;
  return failure("cuCtxSetCurrent");
}
int cuMemGetInfo_v2(std::size_t* free, std::size_t* total) {
  *free = *total = device_bytes;
  for (const auto& [begin, size] : emulated().allocated) *free -= size;
  return failure("cuMemGetInfo");
}
int cuMemAlloc_v2(CardPointer* at, std::size_t bytes) {
  if (bytes == 0) return invalid_value;
  if (const int error = failure("cuMemAlloc")) return error;
  const std::size_t room = (bytes + 127) / 64 * 64;
  *at = find_gap(room);
  if (*at == 0) return omma::driver_out_of_memory;
  emulated().allocated.emplace(*at, room);
  return success;
}
int cuMemFree_v2(CardPointer at) {
  if (const int error = failure("cuMemFree")) return error;
  return emulated().allocated.erase(at) == 1 ? success : invalid_value;
}
int cuMemcpyHtoD_v2(CardPointer to, const void* from, std::size_t bytes) {
  if (const int error = failure("cuMemcpyHtoD")) return error;
  std::memcpy(on_host(to), from, bytes);
  return success;
}
int cuMemcpyDtoH_v2(void* to, CardPointer from, std::size_t bytes) {
  if (const int error = failure("cuMemcpyDtoH")) return error;
  std::memcpy(to, on_host(from), bytes);
  return success;
}
int cuModuleLoadData(void** module, const void*) {
  *module = &emulated();
  return failure("cuModuleLoadData");
}
// Kernels by their number, from 1 on.
int cuModuleGetFunction(void** function, void*, const char* name) {
  const auto found = std::find(std::begin(omma::card_kernel_names),
                               std::end(omma::card_kernel_names), std::string(name));
  if (found == std::end(omma::card_kernel_names)) return 500;  // CUDA_ERROR_NOT_FOUND
  *function = reinterpret_cast<void*>(found - std::begin(omma::card_kernel_names) + 1);
  return failure("cuModuleGetFunction");
}
int cuOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, void*, int, std::size_t) {
  *blocks = 1;
  return failure("cuOccupancyMaxActiveBlocksPerMultiprocessor");
}
int cuLaunchKernel(void* function, unsigned grid_x, unsigned, unsigned, unsigned, unsigned,
                   unsigned, unsigned, void* stream, void** arguments, void**) {
  if (const int error = failure("cuLaunchKernel")) return error;
  Emulated& e = emulated();
  e.stream = stream;
  DeviceCall call{static_cast<omma::CardKernel>(reinterpret_cast<std::intptr_t>(function) - 1),
                  static_cast<int>(grid_x),
                  {}};
  std::memcpy(&call.launch, arguments[0], sizeof call.launch);
  DeviceUse use;
  if (send(e.socket, &call, sizeof call, MSG_NOSIGNAL) != sizeof call ||
      read(e.socket, &use, sizeof use) != sizeof use)
    return launch_failed;  // the process has died of it
  e.most.stack = std::max(e.most.stack, use.stack);
  e.most.memory = std::max(e.most.memory, use.memory);
  return success;
}
int cuCtxSynchronize() {
  return failure("cuCtxSynchronize");
}
int cuStreamSynchronize(void*) {
  return failure("cuStreamSynchronize");
}
int cuPointerGetAttribute(void* value, int attribute, CardPointer at) {
  if (attribute != omma::pointer_ordinal || at < device_address ||
      at >= device_address + device_bytes)
    return invalid_value;
  *static_cast<int*>(value) = 0;
  return failure("cuPointerGetAttribute");
}
int cuGetErrorName(int error, const char** name) {
  *name = error == omma::driver_out_of_memory     ? "CUDA_ERROR_OUT_OF_MEMORY"
          : error == omma::driver_not_initialized ? "CUDA_ERROR_NOT_INITIALIZED"
          : error == launch_failed                ? "CUDA_ERROR_LAUNCH_FAILED"
                                                  : nullptr;
  return *name != nullptr ? success : invalid_value;
}
int cuGetErrorString(int error, const char** text) {
  return cuGetErrorName(error, text);
}

}  // extern "C"
