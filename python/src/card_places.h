// Where a call's outputs go: into NumPy's memory, or into that of a graphics card, where kernels
// write them or, in renders that the host sums up, they are copied to.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "backend/cuda/card_outputs.h"
#include "backend/cuda/cuda_backend.h"
#include "omma/render.h"

namespace omma::python {

// float32 on a card, in C order.
struct CardSpan {
  int card = 0;  // its ordinal
  std::uintptr_t at = 0;
  std::size_t size = 0;  // numbers
  // In which it may be written to, 0 the default one. None: when all that was asked of the card
  // before is done.
  std::optional<std::uintptr_t> stream;
};

using HostOutput = nanobind::ndarray<nanobind::numpy, float, nanobind::ndim<3>, nanobind::c_contig>;
using Place = std::variant<HostOutput, CardSpan>;

// The card that alone writes the outputs of a render, or -1. Frames that last while things move,
// and errors of shared rays, are summed up by the host; what several cards share lies on none of
// them.
inline int card_that_writes(const Renderer& renderer, bool with_error) {
  const RenderSettings& settings = renderer.settings();
  if (!settings.delays_s.empty()) return -1;
  if (with_error && std::holds_alternative<Shared>(settings.sampling)) return -1;
  const std::vector<int> cards = renderer.world().cards();
  return cards.size() == 1 ? cards.front() : -1;
}

class Places {
 public:
  explicit Places(int card) : card_(card) {}

  // Memory that the engine is to write into.
  std::span<float> add(const Place& place) {
    if (const auto* host = std::get_if<HostOutput>(&place)) return {host->data(), host->size()};
    const CardSpan& card = std::get<CardSpan>(place);
    if (card.card != card_) {
      copies_.push_back({card, std::vector<float>(card.size)});
      return copies_.back().second;
    }
    const std::uintptr_t stream = card.stream.value_or(0);
    // A launch is on one stream.
    waits_ = waits_ || !card.stream || (!there_.empty() && there_.back().stream != stream);
    there_.push_back({card.at, card.size * sizeof(float), stream});
    return {reinterpret_cast<float*>(card.at), card.size};
  }

  // `work` writes into all that was added. Without the GIL.
  void run(const std::function<void()>& work) const {
    if (waits_) wait_for_card(card_);
    const CardOutputs outputs(there_);
    work();
    for (const auto& [card, host] : copies_)
      write_to_card(card.card, card.at, host.data(), host.size() * sizeof(float));
  }

 private:
  int card_;
  bool waits_ = false;
  std::vector<CardOutput> there_;
  std::deque<std::pair<CardSpan, std::vector<float>>> copies_;
};

}  // namespace omma::python
