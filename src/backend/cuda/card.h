// A graphics card: its context, kernels and memory, through the driver. Each is one for the
// process, made when it is first asked for. Calls of a card are one at a time, which the backend
// sees to.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "backend/cuda/compile.h"
#include "backend/cuda/driver.h"
#include "physics/views/grid_launch.h"

namespace omma {

// Where what a card needs is found, and where its compiled kernels are kept.
struct CardLibraries {
  std::string driver = "libcuda.so.1";
  std::string nvrtc{};         // the runtime compiler; "": where the system has it
  std::string kernel_cache{};  // a folder; "": kernels are compiled by each process
  std::string packaged_kernels{};  // a folder of kernels that came with Omma; "": none
  // Whether arrays that stay on the card are compared with the host's at each launch: an error
  // where one has changed under the version that it had. For tests.
  bool checks_copies = false;
};

// For cards that are opened from then on.
void set_card_libraries(const CardLibraries& libraries);
CardLibraries card_libraries();

// Entry points of kernels.cu, and of gather_kernel.cu the one that gathers.
enum class CardKernel : std::int32_t { render, discs, gather, weigh, closest, count };
inline constexpr int card_kernel_count = static_cast<int>(CardKernel::count);
inline constexpr const char* card_kernel_names[card_kernel_count] = {
    "omma_render", "omma_discs", "omma_gather", "omma_weigh", "omma_closest"};

struct Card {
  DriverFunctions driver;
  std::string name;  // "cuda:0 (NVIDIA H100 80GB HBM3)"
  int device = 0, processors = 0;
  int capability = 0;    // 90 for 9.0
  int cuda_version = 0;  // that the driver is for, 13000 for 13.0
  CardLibraries libraries;
  void* context = nullptr;
  std::string note;  // what a user should know of its kernels, or empty
  void* functions[card_kernel_count] = {};
  int blocks_at_once[card_kernel_count] = {};  // of the whole card
  // Of the threads of a launch; grows.
  CardPointer thread_memory = 0;
  std::size_t thread_memory_bytes = 0;
};

// Of all cards that the driver has, by their ordinals: "cuda:0 (…)". Throws an Error where there is
// none.
std::vector<std::string> card_names(const CardLibraries& libraries);

// Asks the driver alone; what comes before the context is there then. Throws an Error that says why
// the card cannot be used.
Card find_card(const CardLibraries& libraries, int ordinal);

KernelRequest kernel_request(const Card& card);

// Without kernels.
Card open_card(const CardLibraries& libraries, int ordinal);

// Makes the card this thread's. Before anything else of a call.
void use_card(const Card& card);

// 0 where there is not enough memory.
CardPointer try_to_allocate(const Card& card, std::size_t bytes);
// Of an allocation that failed: how much was asked for, and how much there is.
[[noreturn]] void fail_for_memory(const Card& card, std::size_t bytes);

void free_memory(const Card& card, CardPointer at);

void copy_to_card(const Card& card, CardPointer to, const void* from, std::size_t bytes);
void copy_from_card(const Card& card, void* to, CardPointer from, std::size_t bytes);

// Loads the program that a kernel is of, when one of them is first asked for, and compiles it where
// it has not been kept: a minute or so.
void load_kernel(Card& card, CardKernel kernel);

// Returns when all threads are done. On that stream, after what was asked of it before and after
// all copies; null is the default one.
void run(const Card& card, CardKernel kernel, int blocks, GridLaunch launch, void* stream);

// Returns when all that anybody has asked of the card by this process is done.
void wait_for(const Card& card);

}  // namespace omma
