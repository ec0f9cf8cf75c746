// What the engine asks of RenderSettings::sampling, whichever it is.
#pragma once

#include "omma/render.h"

namespace omma {

inline bool shares_rays(const Sampling& sampling) {
  return std::holds_alternative<Shared>(sampling);
}

// Rays per ommatidium and scramble; where they go on to an error, those of the first round.
inline int first_samples(const Sampling& sampling) {
  if (const auto* target = std::get_if<ToError>(&sampling)) return target->least;
  if (const auto* shared = std::get_if<Shared>(&sampling)) return shared->samples;
  return std::get<Fixed>(sampling).samples;
}

}  // namespace omma
