// Which arrays are in a card's memory. Addresses of the card and of the host are never the same, so
// that an address alone says which it is (CUDA C++ Programming Guide, unified virtual addressing).
#include "backend/cuda/card_outputs.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace omma {
namespace {

std::mutex mutex;
std::vector<CardOutput> known;

}  // namespace

CardOutputs::CardOutputs(std::vector<CardOutput> outputs) : outputs_(std::move(outputs)) {
  const std::lock_guard lock(mutex);
  known.insert(known.end(), outputs_.begin(), outputs_.end());
}

CardOutputs::~CardOutputs() {
  const std::lock_guard lock(mutex);
  for (const CardOutput& output : outputs_)
    known.erase(std::find_if(known.begin(), known.end(),
                             [&](const CardOutput& k) { return k.at == output.at; }));
}

std::optional<CardOutput> find_card_output(const void* array, std::size_t bytes) {
  const auto at = reinterpret_cast<std::uintptr_t>(array);
  const std::lock_guard lock(mutex);
  for (const CardOutput& output : known)
    if (at >= output.at && at + bytes <= output.at + output.bytes) return output;
  return {};
}

}  // namespace omma
