// A graphics card of NVIDIA's as a backend: the hierarchy of `portable` in the card's memory, each
// ommatidium rendered by a thread in one lane, with the physics that processors run.
#pragma once

#include <cstddef>
#include <string>

#include "backend/backend.h"

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

// Bytes of arrays that were copied to stay since this was asked for last.
std::size_t take_kept_bytes();

}  // namespace omma
