// Equirectangular pictures of responses: which ommatidium each pixel shows, and painting them.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "model/nearest_axis.h"
#include "omma/error.h"
#include "omma/projection.h"
#include "omma/scene.h"

namespace omma {
namespace {

constexpr std::uint8_t nothing_seen = 128;  // mid grey

std::vector<std::int32_t> nearest_ids(std::vector<Vec3d> directions, int width, int height,
                                      float max_angle_rad) {
  // A gigapixel: far above any picture, and no overflow anywhere.
  constexpr std::int64_t most_pixels = std::int64_t{1} << 30;
  if (width < 1 || height < 1 || std::int64_t{width} * height > most_pixels)
    throw Error(
        "equirectangular picture: width and height must be at least 1 and their product at "
        "most 2^30, are " +
        std::to_string(width) + " and " + std::to_string(height));
  if (!(max_angle_rad >= 0))
    throw Error("equirectangular picture: max_angle_rad must not be negative, is " +
                std::to_string(max_angle_rad));
  const AxisTree tree(std::move(directions));
  std::vector<std::int32_t> ids(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const tbb::blocked_range<int>& rows) {
    std::int32_t id = 0;  // of the pixel before, the likely neighbour
    for (int row = rows.begin(); row < rows.end(); ++row) {
      const double elevation = (0.5 - (row + 0.5) / height) * pi;
      for (int column = 0; column < width; ++column) {
        const double azimuth = ((column + 0.5) / width - 0.5) * 2 * pi;
        const Vec3d direction{std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                              -std::cos(azimuth) * std::cos(elevation)};
        double chord_squared = 0;
        id = tree.nearest(direction, id, chord_squared);
        const bool near = angle_from_chord_squared(chord_squared) <= max_angle_rad;
        ids[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(column)] = near ? id : -1;
      }
    }
  });
  return ids;
}

void check_not_empty(const Eye& eye) {
  if (eye.size() == 0)
    throw Error("equirectangular picture: an eye must have at least one ommatidium");
}

}  // namespace

std::vector<std::int32_t> equirectangular_ids(const Eye& eye, int width, int height,
                                              float max_angle_rad) {
  check_not_empty(eye);
  std::vector<Vec3d> directions;
  directions.reserve(eye.size());
  for (const Vec3 axis : eye.axis) directions.push_back(normalize(to_double(axis)));
  return nearest_ids(std::move(directions), width, height, max_angle_rad);
}

std::vector<std::int32_t> equirectangular_ids_by_position(const Eye& eye, int width, int height,
                                                          float max_angle_rad) {
  check_not_empty(eye);
  Vec3d centroid;
  for (const Vec3 position : eye.position_m) centroid = centroid + to_double(position);
  centroid = centroid * (1.0 / static_cast<double>(eye.size()));
  std::vector<Vec3d> directions;
  directions.reserve(eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3d from_centroid = to_double(eye.position_m[i]) - centroid;
    if (!(length(from_centroid) > 0))
      throw Error("equirectangular picture by position: ommatidium " + std::to_string(i) +
                  " lies at the centroid of all positions and so in no direction from it");
    directions.push_back(normalize(from_centroid));
  }
  return nearest_ids(std::move(directions), width, height, max_angle_rad);
}

std::vector<std::uint8_t> paint(std::span<const std::int32_t> ids, std::span<const float> responses,
                                double gamma) {
  if (!(gamma > 0) || !std::isfinite(gamma))
    throw Error("paint: gamma must be positive and finite, is " + std::to_string(gamma));
  if (responses.size() % channel_count != 0)
    throw Error("paint: responses must be [ommatidium][" + std::to_string(channel_count) +
                "], have " + std::to_string(responses.size()) + " values");
  std::vector<std::uint8_t> display(responses.size());
  std::transform(responses.begin(), responses.end(), display.begin(), [&](float response) {
    if (!(response > 0)) return std::uint8_t{0};
    const double value = std::pow(std::min(1.0, static_cast<double>(response)), 1 / gamma);
    return static_cast<std::uint8_t>(std::lround(255 * value));
  });
  const std::size_t ommatidia = responses.size() / channel_count;
  std::vector<std::uint8_t> pixels;
  pixels.reserve(ids.size() * channel_count);
  for (const std::int32_t id : ids) {
    if (id == -1) {
      pixels.insert(pixels.end(), channel_count, nothing_seen);
      continue;
    }
    if (id < 0 || static_cast<std::size_t>(id) >= ommatidia)
      throw Error("paint: id " + std::to_string(id) + " is not -1 and not one of the " +
                  std::to_string(ommatidia) + " ommatidia");
    const auto first = display.begin() + static_cast<std::ptrdiff_t>(id) * channel_count;
    pixels.insert(pixels.end(), first, first + channel_count);
  }
  return pixels;
}

}  // namespace omma
