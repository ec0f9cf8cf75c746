// Pictures from an id map: responses as display values, or the ids themselves.
#include <algorithm>
#include <cmath>
#include <string>

#include "omma/error.h"
#include "omma/projection.h"
#include "omma/scene_kinds.h"
#include "threads/cancel.h"

namespace omma {
namespace {

constexpr std::uint8_t nothing_seen = 128;  // mid grey

}  // namespace

std::vector<std::uint8_t> paint(std::span<const std::int32_t> ids, std::span<const float> responses,
                                double gamma) {
  if (!(gamma > 0) || !std::isfinite(gamma))
    throw Error("paint: gamma must be positive and finite, is " + std::to_string(gamma));
  if (responses.size() % rgb_bands != 0)
    throw Error("paint: responses must be [ommatidium][" + std::to_string(rgb_bands) +
                "], have " + std::to_string(responses.size()) + " values");
  std::vector<std::uint8_t> display(responses.size());
  std::transform(responses.begin(), responses.end(), display.begin(), [&](float response) {
    if (!(response > 0)) return std::uint8_t{0};
    const double value = std::pow(std::min(1.0, static_cast<double>(response)), 1 / gamma);
    return static_cast<std::uint8_t>(std::lround(255 * value));
  });
  const std::size_t ommatidia = responses.size() / rgb_bands;
  std::vector<std::uint8_t> pixels;
  pixels.reserve(ids.size() * rgb_bands);
  for (const std::int32_t id : ids) {
    check_cancelled();
    if (id == -1) {
      pixels.insert(pixels.end(), rgb_bands, nothing_seen);
      continue;
    }
    if (id < 0 || static_cast<std::size_t>(id) >= ommatidia)
      throw Error("paint: id " + std::to_string(id) + " is not -1 and not one of the " +
                  std::to_string(ommatidia) + " ommatidia");
    const auto first = display.begin() + static_cast<std::ptrdiff_t>(id) * rgb_bands;
    pixels.insert(pixels.end(), first, first + rgb_bands);
  }
  return pixels;
}

std::vector<std::uint8_t> encode_ids(std::span<const std::int32_t> ids) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(ids.size() * 4);
  for (const std::int32_t id : ids) {
    check_cancelled();
    for (const int shift : {24, 16, 8, 0})
      pixels.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(id) >> shift));
  }
  return pixels;
}

}  // namespace omma
