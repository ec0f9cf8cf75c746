// A card through the driver.
#include "backend/cuda/card.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <tuple>

#include "omma/error.h"
#include "physics/rays/replicates.h"

namespace omma {
namespace {

constexpr int least_version = 12000;  // of CUDA, that the driver knows
constexpr int threads = most_per_block;

// May be given before main begins.
struct GivenLibraries {
  std::mutex mutex;
  CardLibraries libraries;
};
GivenLibraries& given() {
  static GivenLibraries the_ones;
  return the_ones;
}

void check(const Card& card, int result, const char* call) {
  check_driver(card.driver, result, call, card.name);
}

std::string in_megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

// The kernels of a program, for the card's own architecture. Cards that are opened at once wait for
// each other, so that nothing is compiled twice.
const CompiledKernels& kernels_for(const Card& card, const char* program) {
  static std::mutex one_at_a_time;
  static std::map<std::tuple<KernelRequest, std::string>, CompiledKernels> known;
  const std::tuple key{kernel_request(card), std::string(program)};
  const std::lock_guard lock(one_at_a_time);
  auto found = known.find(key);
  if (found == known.end())
    found = known.emplace(key, compile_kernels(std::get<0>(key), program)).first;
  return found->second;
}

void load_kernels(Card& card, bool gathers) {
  const CompiledKernels& compiled = kernels_for(card, gathers ? gather_program : render_program);
  card.note = compiled.note;
  void* module = nullptr;
  check(card, card.driver.load_module(&module, compiled.cubin.data()), "cuModuleLoadData");
  for (int k = 0; k < card_kernel_count; ++k) {
    if ((k == static_cast<int>(CardKernel::gather)) != gathers) continue;
    void* function = nullptr;
    check(card, card.driver.function(&function, module, card_kernel_names[k]),
          "cuModuleGetFunction");
    int blocks = 0;
    check(card, card.driver.blocks_at_once(&blocks, function, threads, 0),
          "cuOccupancyMaxActiveBlocksPerMultiprocessor");
    card.blocks_at_once[k] = std::max(1, blocks * card.processors);
    card.functions[k] = function;
  }
}

// Of the driver, which has `count` cards.
Card find_driver(const CardLibraries& from, int& count) {
  Card card;
  card.libraries = from;
  card.name = "cuda";
  card.driver = load_driver(from.driver);
  const DriverFunctions& driver = card.driver;
  const int ready = driver.init(0);
  if (ready != driver_without_card) {
    check(card, ready, "cuInit");
    check(card, driver.version(&card.cuda_version), "cuDriverGetVersion");
    check(card, driver.card_count(&count), "cuDeviceGetCount");
  }
  if (count < 1) throw NoCard("cuda: expected a card, found a driver without one");
  return card;
}

// Makes a driver's card one of its cards.
void choose(Card& card, int ordinal) {
  check(card, card.driver.card(&card.device, ordinal), "cuDeviceGet");
  char name[256] = {};
  check(card, card.driver.card_name(name, sizeof name - 1, card.device), "cuDeviceGetName");
  card.name = "cuda:" + std::to_string(ordinal) + " (" + name + ")";
}

}  // namespace

void set_card_libraries(const CardLibraries& libraries) {
  const std::lock_guard lock(given().mutex);
  given().libraries = libraries;
}

CardLibraries card_libraries() {
  const std::lock_guard lock(given().mutex);
  return given().libraries;
}

std::vector<std::string> card_names(const CardLibraries& from) {
  int count = 0;
  const Card driver = find_driver(from, count);
  std::vector<std::string> names;
  for (int ordinal = 0; ordinal < count; ++ordinal) {
    Card card = driver;
    choose(card, ordinal);
    names.push_back(card.name);
  }
  return names;
}

Card find_card(const CardLibraries& from, int ordinal) {
  int count = 0;
  Card card = find_driver(from, count);
  choose(card, ordinal);
  if (card.cuda_version < least_version)
    throw Error(card.name + ": expected a driver for CUDA 12.0 or newer, found one for CUDA " +
                std::to_string(card.cuda_version / 1000) + "." +
                std::to_string(card.cuda_version % 1000 / 10) + "; update NVIDIA's driver");
  const auto ask = [&](int& value, CardAttribute attribute) {
    check(card, card.driver.attribute(&value, attribute, card.device), "cuDeviceGetAttribute");
  };
  int major = 0, minor = 0;
  ask(major, capability_major);
  ask(minor, capability_minor);
  ask(card.processors, processor_count);
  card.capability = 10 * major + minor;
  if (card.capability < 75)
    throw Error(card.name + ": expected compute capability 7.5 (Turing) or newer, found " +
                std::to_string(major) + "." + std::to_string(minor));
  return card;
}

KernelRequest kernel_request(const Card& card) {
  const CardLibraries& from = card.libraries;
  return {card.capability, from.nvrtc, from.kernel_cache, from.packaged_kernels,
          card.cuda_version / 1000};
}

Card open_card(const CardLibraries& from, int ordinal) {
  Card card = find_card(from, ordinal);
  check(card, card.driver.retain_context(&card.context, card.device), "cuDevicePrimaryCtxRetain");
  return card;
}

void use_card(const Card& card) {
  check(card, card.driver.set_context(card.context), "cuCtxSetCurrent");
}

CardPointer try_to_allocate(const Card& card, std::size_t bytes) {
  CardPointer at = 0;
  const int result = card.driver.allocate(&at, bytes);
  if (result == driver_out_of_memory) return 0;
  check(card, result, "cuMemAlloc");
  return at;
}

void fail_for_memory(const Card& card, std::size_t bytes) {
  std::size_t free = 0, total = 0;
  check(card, card.driver.memory_info(&free, &total), "cuMemGetInfo");
  // Launches have so many tasks that memory does not depend on how many poses there are.
  throw Error(card.name + ": expected " + in_megabytes(bytes) + " of memory, found " +
              in_megabytes(free) + " free of " + in_megabytes(total) +
              "; a smaller scene or fewer bands may fit, or backend=\"portable\" renders on the "
              "processor");
}

void free_memory(const Card& card, CardPointer at) {
  check(card, card.driver.free(at), "cuMemFree");
}

void copy_to_card(const Card& card, CardPointer to, const void* from, std::size_t bytes) {
  if (bytes > 0) check(card, card.driver.copy_to_card(to, from, bytes), "cuMemcpyHtoD");
}

void copy_from_card(const Card& card, void* to, CardPointer from, std::size_t bytes) {
  if (bytes > 0) check(card, card.driver.copy_from_card(to, from, bytes), "cuMemcpyDtoH");
}

void load_kernel(Card& card, CardKernel kernel) {
  if (card.functions[static_cast<int>(kernel)] == nullptr)
    load_kernels(card, kernel == CardKernel::gather);
}

void run(const Card& card, CardKernel kernel, int blocks, GridLaunch launch, void* stream) {
  // Copies may still be on their way when they return, in the default stream, which others need not
  // wait for (CUDA Driver API, "API synchronization behavior").
  if (stream != nullptr)
    check(card, card.driver.synchronize_stream(nullptr), "cuStreamSynchronize");
  void* arguments[] = {&launch};
  check(card,
        card.driver.launch(card.functions[static_cast<int>(kernel)], static_cast<unsigned>(blocks),
                           1, 1, threads, 1, 1, 0, stream, arguments, nullptr),
        "cuLaunchKernel");
  check(card, card.driver.synchronize_stream(stream), "cuStreamSynchronize");
}

void wait_for(const Card& card) {
  check(card, card.driver.synchronize(), "cuCtxSynchronize");
}

}  // namespace omma
