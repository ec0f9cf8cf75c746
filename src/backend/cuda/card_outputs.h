// Outputs of a render that lie in a card's memory already, as those of a tensor on it: kernels
// write there, and nothing is brought back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace omma {

// An array of the caller's, by its address on the card.
struct CardOutput {
  std::uintptr_t at = 0;
  std::size_t bytes = 0;
  // CUstream, in which what the caller has asked of the card comes before what is written here; 0
  // is the default one.
  std::uintptr_t stream = 0;
};

// While this lives, launches write into these arrays where they are. Host code may not touch them.
class CardOutputs {
 public:
  explicit CardOutputs(std::vector<CardOutput> outputs);
  ~CardOutputs();
  CardOutputs(const CardOutputs&) = delete;
  CardOutputs& operator=(const CardOutputs&) = delete;

 private:
  std::vector<CardOutput> outputs_;
};

// The one that an array is of, or none.
std::optional<CardOutput> find_card_output(const void* array, std::size_t bytes);

}  // namespace omma
