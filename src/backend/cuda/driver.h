// The functions of NVIDIA's driver that Omma calls, loaded when a card is first asked for, so that
// neither building nor running without a card needs anything of CUDA. Names and numbers are those
// of the CUDA Driver API reference (docs.nvidia.com/cuda/cuda-driver-api).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "omma/error.h"

namespace omma {

// There is no card, or no driver for one: nothing is broken.
struct NoCard : Error {
  using Error::Error;
};

using CardPointer = std::uint64_t;  // CUdeviceptr

// All return CUresult, 0 where they succeed.
struct DriverFunctions {
  int (*init)(unsigned flags);
  int (*version)(int* version);  // 1000 * major + 10 * minor, of CUDA
  int (*card_count)(int* count);
  int (*card)(int* card, int ordinal);
  int (*card_name)(char* name, int bytes, int card);
  int (*attribute)(int* value, int attribute, int card);
  int (*retain_context)(void** context, int card);
  int (*set_context)(void* context);  // of this thread
  int (*memory_info)(std::size_t* free, std::size_t* total);
  int (*allocate)(CardPointer* at, std::size_t bytes);
  int (*free)(CardPointer at);
  int (*copy_to_card)(CardPointer to, const void* from, std::size_t bytes);
  int (*copy_from_card)(void* to, CardPointer from, std::size_t bytes);
  int (*load_module)(void** module, const void* cubin);
  int (*function)(void** function, void* module, const char* name);
  int (*blocks_at_once)(int* blocks, void* function, int threads, std::size_t shared_bytes);
  int (*launch)(void* function, unsigned grid_x, unsigned grid_y, unsigned grid_z, unsigned block_x,
                unsigned block_y, unsigned block_z, unsigned shared_bytes, void* stream,
                void** arguments, void** extra);
  int (*synchronize)();  // with all that was asked of the context
  int (*synchronize_stream)(void* stream);
  int (*pointer_attribute)(void* value, int attribute, CardPointer at);
  int (*error_name)(int error, const char** name);
  int (*error_text)(int error, const char** text);
};

// CUresult and CUdevice_attribute, as far as they are asked for.
enum DriverError : int {
  driver_out_of_memory = 2,
  driver_not_initialized = 3,
  driver_without_card = 100
};
enum CardAttribute : int { processor_count = 16, capability_major = 75, capability_minor = 76 };
enum PointerAttribute : int { pointer_ordinal = 9 };

// From the library at OMMA_CUDA_DRIVER or, where that is not set, at `path`. Throws omma::Error
// where there is no driver, or one that lacks a function.
DriverFunctions load_driver(const std::string& path);

// Throws an Error that names the call, the driver's own error and what it means here, unless result
// is 0. `who`: the card, or what else the message begins with.
void check_driver(const DriverFunctions& driver, int result, const char* call,
                  const std::string& who);

}  // namespace omma
