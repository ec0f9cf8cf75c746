// A graphics card of NVIDIA's as a backend: the hierarchy of `portable` in the card's memory, each
// ommatidium rendered by a thread in one lane, with the physics that processors run.
#pragma once

#include <cstddef>
#include <string>

#include "backend/backend.h"
#include "backend/cuda/driver.h"

namespace omma {

Backend cuda_backend();

// Whether there is a card that can be used.
struct CardState {
  std::string name;     // "cuda:0 (…)", or empty
  std::string driver;   // the CUDA that it is for, "13.0", or empty
  std::string why_not;  // empty where the card can be used
};
// Compiles nothing.
CardState card_state();

// What is to be known of the card's kernels, as that they could not be kept, or empty. Opens the
// card; throws omma::Error that says why there is none.
std::string card_note();

// Memory of the card for arrays of a caller's; addresses of CUDA. Each throws omma::Error where the
// driver fails, and returns when it is done.
CardPointer allocate_on_card(std::size_t bytes);
void free_on_card(CardPointer at);
void read_from_card(void* to, CardPointer from, std::size_t bytes);
void write_to_card(CardPointer to, const void* from, std::size_t bytes);
// For all that anybody has asked of the card by this process.
void wait_for_card();
// Throws omma::Error where an address is not of the card that Omma uses.
void check_on_card(CardPointer at);

// Bytes of arrays that were copied to stay since this was asked for last.
std::size_t take_kept_bytes();

}  // namespace omma
