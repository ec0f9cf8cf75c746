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
  std::uintptr_t at = 0;
  std::size_t size = 0;  // numbers
  // In which it may be written to, 0 the default one. None: when all that was asked of the card
  // before is done.
  std::optional<std::uintptr_t> stream;
};

using HostOutput = nanobind::ndarray<nanobind::numpy, float, nanobind::ndim<3>, nanobind::c_contig>;
using Place = std::variant<HostOutput, CardSpan>;

// Whether a render writes its outputs on the card alone. Frames that last while things move, and
// errors of shared rays, are summed up by the host.
inline bool writes_on_card(const Renderer& renderer, bool with_error) {
  const RenderSettings& settings = renderer.settings();
  return renderer.backend().starts_with("cuda:") && settings.delays_s.empty() &&
         !(with_error && std::holds_alternative<Shared>(settings.sampling));
}

class Places {
 public:
  explicit Places(bool on_card) : on_card_(on_card) {}

  // Memory that the engine is to write into.
  std::span<float> add(const Place& place) {
    if (const auto* host = std::get_if<HostOutput>(&place)) return {host->data(), host->size()};
    const CardSpan& card = std::get<CardSpan>(place);
    waits_ = waits_ || !card.stream;
    if (!on_card_) {
      copies_.push_back({card, std::vector<float>(card.size)});
      return copies_.back().second;
    }
    there_.push_back({card.at, card.size * sizeof(float), card.stream.value_or(0)});
    return {reinterpret_cast<float*>(card.at), card.size};
  }

  // `work` writes into all that was added. Without the GIL.
  void run(const std::function<void()>& work) const {
    if (waits_) wait_for_card();
    const CardOutputs outputs(there_);
    work();
    for (const auto& [card, host] : copies_)
      write_to_card(card.at, host.data(), host.size() * sizeof(float));
  }

 private:
  bool on_card_, waits_ = false;
  std::vector<CardOutput> there_;
  std::deque<std::pair<CardSpan, std::vector<float>>> copies_;
};

}  // namespace omma::python
