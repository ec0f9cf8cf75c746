// Graphics cards of NVIDIA's as a backend: the hierarchy of `portable` in a card's memory, each
// ommatidium rendered by a thread in one lane, with the physics that processors run. Several cards
// share the poses of a launch; what comes out has the same bits.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "backend/backend.h"
#include "backend/cuda/driver.h"

namespace omma {

Backend cuda_backend();

// Whether a card can be used.
struct CardState {
  std::string name;     // "cuda:0 (…)", "a graphics card" of a driver that fails, or empty
  std::string driver;   // the CUDA that it is for, "13.0", or empty
  std::string why_not;  // empty where the card can be used
};
// Of all cards that the driver has, or one that says why there is none. Compiles nothing.
std::vector<CardState> card_states();

// What is to be known of the cards' kernels, as that they could not be kept, or empty. Opens the
// cards, as Backend::launches takes them; throws omma::Error that says why one cannot be used.
std::string card_note(std::span<const int> devices);

// Memory for arrays of a caller's, of the card of that ordinal; addresses of CUDA. Each throws
// omma::Error where the driver fails, and returns when it is done.
CardPointer allocate_on_card(int card, std::size_t bytes);
void free_on_card(int card, CardPointer at);
// These when all that anybody has asked of the card by this process is done.
void read_from_card(int card, void* to, CardPointer from, std::size_t bytes);
void write_to_card(int card, CardPointer to, const void* from, std::size_t bytes);
void wait_for_card(int card);
// The ordinal of the card that an address is on. Throws omma::Error where it is on none.
int card_of(CardPointer at);

// Bytes of arrays that were copied to stay since this was asked for last.
std::size_t take_kept_bytes();

}  // namespace omma
