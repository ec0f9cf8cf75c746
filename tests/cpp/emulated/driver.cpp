// A stand-in for NVIDIA's driver, as a shared library: cards whose threads run in processes of
// their own (device_main.cpp), which have nothing but their card's memory, so that a pointer into
// the host's or another card's ends them. Calls can be made to fail (emulated_driver.h).
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "backend/cuda/driver.h"
#include "emulated/device.h"
#include "emulated/emulated_driver.h"

namespace omma::test {
namespace {

constexpr int success = 0, invalid_value = 1, invalid_device = 101, invalid_context = 201;
constexpr int launch_failed = 719;

// A card, which is its context and its modules too.
struct Emulated {
  int ordinal = 0;
  int socket = -1;
  std::map<CardPointer, std::size_t> allocated;  // what is, in the order of addresses
  void* stream = nullptr;                        // of the last launch
};

// Of all cards.
struct Driver {
  std::mutex mutex;
  std::map<int, Emulated> cards;
  DeviceUse most;
  std::string fails;                    // the call that does
  int error = 0, times = 0, card = -1;  // that it fails
  std::size_t memory = device_bytes;    // of a card
};

Driver& driver() {
  static Driver the_one;
  return the_one;
}

thread_local Emulated* current = nullptr;

std::size_t allocated_bytes(const Emulated& card) {
  std::size_t bytes = 0;
  for (const auto& [begin, size] : card.allocated) bytes += size;
  return bytes;
}

int card_count() {
  const char* const given = std::getenv("OMMA_EMULATED_CARDS");
  return given != nullptr ? std::atoi(given) : 1;
}

// Whether this call is one that fails now, of that card.
int failure(const char* call, int card) {
  Driver& d = driver();
  const std::lock_guard lock(d.mutex);
  if (d.fails != call || d.times == 0 || (d.card >= 0 && d.card != card)) return success;
  --d.times;
  return d.error;
}

// Of the card of this thread, which it must have.
int failure(const char* call) {
  return current == nullptr ? invalid_context : failure(call, current->ordinal);
}

// Maps the memory and starts the card's process.
bool start(Emulated& e) {
  if (e.socket >= 0) return true;
  const int memory = memfd_create("emulated card", 0);
  int ends[2];
  void* const wanted = reinterpret_cast<void*>(device_address(e.ordinal));
  if (memory < 0 || ftruncate(memory, static_cast<off_t>(device_bytes)) != 0 ||
      socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0 ||
      mmap(wanted, device_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED_NOREPLACE, memory,
           0) != wanted)
    return false;
  const std::string ordinal_text = std::to_string(e.ordinal);
  const std::string memory_text = std::to_string(memory), end_text = std::to_string(ends[1]);
  if (fork() == 0) {
    close(ends[0]);
    execl(OMMA_EMULATED_DEVICE, OMMA_EMULATED_DEVICE, ordinal_text.c_str(), memory_text.c_str(),
          end_text.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  close(memory);
  e.socket = ends[0];
  fcntl(e.socket, F_SETFD, FD_CLOEXEC);
  return true;
}

// The first gap that is large enough; something lies between allocations.
CardPointer find_gap(const Emulated& e, std::size_t bytes) {
  CardPointer at = device_address(e.ordinal);
  for (const auto& [begin, size] : e.allocated) {
    if (begin - at >= bytes) return at;
    at = begin + size;
  }
  return device_address(e.ordinal) + device_bytes - at >= bytes ? at : 0;
}

// Whether it is in an allocation of this thread's card.
bool is_there(CardPointer at, std::size_t bytes) {
  const auto after = current->allocated.upper_bound(at);
  if (after == current->allocated.begin()) return false;
  const auto& [begin, size] = *std::prev(after);
  return at + bytes <= begin + size;
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
  const std::lock_guard lock(driver().mutex);
  return std::exchange(driver().most, {});
}

void* emulated_last_stream() {
  return driver().cards[0].stream;
}

void emulated_fail(const char* call, int error, int times, int card) {
  Driver& d = driver();
  const std::lock_guard lock(d.mutex);
  d.fails = call;
  d.error = error;
  d.times = times;
  d.card = card;
}

void emulated_limit_memory(std::size_t bytes) {
  driver().memory = bytes > 0 ? bytes : device_bytes;
}

int cuInit(unsigned) {
  return failure("cuInit", 0);
}
int cuDriverGetVersion(int* version) {
  *version = 13000;
  if (failure("cuDriverGetVersion", 0) != 0) *version = 11040;  // an old one
  return success;
}
int cuDeviceGetCount(int* count) {
  *count = failure("cuDeviceGetCount", 0) != 0 ? 0 : card_count();  // none
  return success;
}
int cuDeviceGet(int* device, int ordinal) {
  *device = ordinal;
  if (ordinal < 0 || ordinal >= card_count()) return invalid_device;
  return failure("cuDeviceGet", ordinal);
}
int cuDeviceGetName(char* name, int bytes, int device) {
  std::strncpy(name, "emulated card", static_cast<std::size_t>(bytes));
  return failure("cuDeviceGetName", device);
}
int cuDeviceGetAttribute(int* value, int attribute, int device) {
  *value = attribute == omma::capability_major ? 7 : attribute == omma::capability_minor ? 5 : 1;
  return failure("cuDeviceGetAttribute", device);
}
int cuDevicePrimaryCtxRetain(void** context, int device) {
  if (const int error = failure("cuDevicePrimaryCtxRetain", device)) return error;
  Driver& d = driver();
  const std::lock_guard lock(d.mutex);
  Emulated& e = d.cards[device];
  e.ordinal = device;
  *context = &e;
  return start(e) ? success : omma::driver_not_initialized;
}
int cuCtxSetCurrent(void* context) {
  current = static_cast<Emulated*>(context);
  return failure("cuCtxSetCurrent");
}
int cuMemGetInfo_v2(std::size_t* free, std::size_t* total) {
  if (const int error = failure("cuMemGetInfo")) return error;
  *total = driver().memory;
  *free = *total - std::min(*total, allocated_bytes(*current));
  return success;
}
int cuMemAlloc_v2(CardPointer* at, std::size_t bytes) {
  if (bytes == 0) return invalid_value;
  if (const int error = failure("cuMemAlloc")) return error;
  const std::size_t room = (bytes + 127) / 64 * 64;
  *at = find_gap(*current, room);
  if (*at == 0 || allocated_bytes(*current) + room > driver().memory)
    return omma::driver_out_of_memory;
  current->allocated.emplace(*at, room);
  return success;
}
int cuMemFree_v2(CardPointer at) {
  if (const int error = failure("cuMemFree")) return error;
  return current->allocated.erase(at) == 1 ? success : invalid_value;
}
int cuMemcpyHtoD_v2(CardPointer to, const void* from, std::size_t bytes) {
  if (const int error = failure("cuMemcpyHtoD")) return error;
  if (!is_there(to, bytes)) return invalid_value;
  std::memcpy(on_host(to), from, bytes);
  return success;
}
int cuMemcpyDtoH_v2(void* to, CardPointer from, std::size_t bytes) {
  if (const int error = failure("cuMemcpyDtoH")) return error;
  if (!is_there(from, bytes)) return invalid_value;
  std::memcpy(to, on_host(from), bytes);
  return success;
}
int cuModuleLoadData(void** module, const void*) {
  *module = current;
  return failure("cuModuleLoadData");
}
// Kernels by their number, from 1 on, those of a card after those of the one before.
int cuModuleGetFunction(void** function, void* module, const char* name) {
  const auto found = std::find(std::begin(omma::card_kernel_names),
                               std::end(omma::card_kernel_names), std::string(name));
  if (found == std::end(omma::card_kernel_names)) return 500;  // CUDA_ERROR_NOT_FOUND
  const int ordinal = static_cast<const Emulated*>(module)->ordinal;
  *function = reinterpret_cast<void*>(found - std::begin(omma::card_kernel_names) + 1 +
                                      std::intptr_t{ordinal} * omma::card_kernel_count);
  return failure("cuModuleGetFunction");
}
int cuOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, void*, int, std::size_t) {
  *blocks = 1;
  return failure("cuOccupancyMaxActiveBlocksPerMultiprocessor");
}
int cuLaunchKernel(void* function, unsigned grid_x, unsigned, unsigned, unsigned, unsigned,
                   unsigned, unsigned, void* stream, void** arguments, void**) {
  if (const int error = failure("cuLaunchKernel")) return error;
  const std::intptr_t number = reinterpret_cast<std::intptr_t>(function) - 1;
  if (number / omma::card_kernel_count != current->ordinal) return invalid_context;
  current->stream = stream;
  DeviceCall call{static_cast<omma::CardKernel>(number % omma::card_kernel_count),
                  static_cast<int>(grid_x),
                  {}};
  std::memcpy(&call.launch, arguments[0], sizeof call.launch);
  DeviceUse use;
  if (send(current->socket, &call, sizeof call, MSG_NOSIGNAL) != sizeof call ||
      read(current->socket, &use, sizeof use) != sizeof use)
    return launch_failed;  // the process has died of it
  Driver& d = driver();
  const std::lock_guard lock(d.mutex);
  d.most.stack = std::max(d.most.stack, use.stack);
  d.most.memory = std::max(d.most.memory, use.memory);
  return success;
}
int cuCtxSynchronize() {
  return failure("cuCtxSynchronize");
}
int cuStreamSynchronize(void*) {
  return failure("cuStreamSynchronize");
}
int cuPointerGetAttribute(void* value, int attribute, CardPointer at) {
  Driver& d = driver();
  const std::lock_guard lock(d.mutex);
  for (const auto& [ordinal, card] : d.cards) {
    const auto after = card.allocated.upper_bound(at);
    if (after == card.allocated.begin()) continue;
    const auto& [begin, size] = *std::prev(after);
    if (attribute != omma::pointer_ordinal || at >= begin + size) continue;
    *static_cast<int*>(value) = ordinal;
    return success;
  }
  return invalid_value;
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
