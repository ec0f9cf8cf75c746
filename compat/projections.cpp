// The projections, see projections.h. Which pixel looks where, and which ommatidia it may show, are
// facts of BrainsOnBoard/compound-ray, libEyeRenderer3/shaders.cu.
#include "projections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "omma/projection.h"

namespace omma::compat {
namespace {

using Names = std::array<std::pair<const char*, Projection>, 8>;
constexpr Names names{{
    {"raw_ommatidial_samples", Projection::raw_ommatidial_samples},
    {"single_dimension", Projection::single_dimension},
    {"single_dimension_fast", Projection::single_dimension_fast},
    {"spherical_orientationwise", Projection::spherical_orientationwise},
    {"spherical_orientationwise_ids", Projection::spherical_orientationwise_ids},
    {"spherical_positionwise", Projection::spherical_positionwise},
    {"spherical_positionwise_ids", Projection::spherical_positionwise_ids},
    {"spherical_split_orientationwise", Projection::spherical_split_orientationwise},
}};

// The same map serves colours and ids.
Projection map_kind(Projection projection) {
  if (projection == Projection::spherical_orientationwise_ids)
    return Projection::spherical_orientationwise;
  if (projection == Projection::spherical_positionwise_ids)
    return Projection::spherical_positionwise;
  return projection;
}

// Which of the candidates' axes lies nearest each direction, as an index into `axes`.
std::vector<std::int32_t> nearest_among(const std::vector<Vec3>& axes,
                                        const std::vector<std::int32_t>& candidates,
                                        std::span<const Vec3> directions) {
  Eye eye;
  for (const std::int32_t candidate : candidates)
    eye.axis.push_back(axes[static_cast<std::size_t>(candidate)]);
  eye.position_m.resize(eye.axis.size());
  eye.acceptance_angle_rad.resize(eye.axis.size());
  eye.focal_offset_m.resize(eye.axis.size());
  eye.eye_id.resize(eye.axis.size());
  std::vector<std::int32_t> nearest = nearest_by_axis(eye, directions);
  for (std::int32_t& id : nearest) id = candidates[static_cast<std::size_t>(id)];
  return nearest;
}

std::vector<Vec3> directions_of(int columns, int rows, double first_x, double x_step, int height) {
  std::vector<Vec3> directions;
  directions.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      directions.push_back(
          panoramic_direction(first_x + column * x_step, static_cast<double>(row) / height));
  return directions;
}

std::vector<std::int32_t> orientationwise(const Eye& eye, int width, int height) {
  return nearest_by_axis(eye, directions_of(width, height, 0, 1.0 / width, height));
}

// By where the positions lie as seen from the eye's origin. One that lies in it has no direction
// and is never nearest; if it is the first, the comparison starts from it and nothing beats it.
std::vector<std::int32_t> positionwise(const Eye& eye, int width, int height) {
  const std::vector<Vec3> directions = directions_of(width, height, 0, 1.0 / width, height);
  if (!(dot(eye.position_m[0], eye.position_m[0]) > 0))
    return std::vector<std::int32_t>(directions.size());
  return nearest_by_position(eye, {}, directions);
}

// Two panoramas side by side, of the ommatidia left (x < 0) and right of the middle. The first
// ommatidium belongs to both, and a column exactly in the middle shows nothing else.
std::vector<std::int32_t> split_orientationwise(const Eye& eye, int width, int height) {
  std::vector<std::int32_t> ids(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (const bool right : {false, true}) {
    std::vector<std::int32_t> candidates{0};
    for (std::size_t i = 1; i < eye.size(); ++i)
      if (right ? eye.position_m[i].x > 0 : eye.position_m[i].x < 0)
        candidates.push_back(static_cast<std::int32_t>(i));
    const int first = right ? width / 2 + 1 : 0, end = right ? width : (width + 1) / 2;
    if (first >= end) continue;
    const double first_x = 2.0 * first / width - (right ? 1 : 0);
    const std::vector<std::int32_t> nearest = nearest_among(
        eye.axis, candidates, directions_of(end - first, height, first_x, 2.0 / width, height));
    for (int row = 0; row < height; ++row)
      std::copy_n(nearest.begin() + std::ptrdiff_t{row} * (end - first), end - first,
                  ids.begin() + std::ptrdiff_t{row} * width + first);
  }
  return ids;
}

std::size_t count(int pixels) {
  return static_cast<std::size_t>(pixels);
}

}  // namespace

std::optional<Projection> find_projection(const std::string& name) {
  for (const auto& [known, projection] : names)
    if (name == known) return projection;
  return {};
}

bool shows_ids(Projection projection) {
  return map_kind(projection) != projection;
}

Vec3 panoramic_direction(double x, double y) {
  // In float, as CompoundRay: the cosine at the poles is then some 1e-8, not exactly nothing.
  const auto azimuth = static_cast<float>((2 * x - 1) * pi);
  const auto elevation = static_cast<float>((y - 0.5) * pi);
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          -std::cos(azimuth) * std::cos(elevation)};
}

const std::vector<std::int32_t>& id_map_for(IdMap& map, const Eye& eye, Projection projection,
                                            int width, int height) {
  const Projection kind = map_kind(projection);
  if (map.projection == kind && map.width == width && map.height == height) return map.ids;
  if (kind == Projection::spherical_orientationwise)
    map.ids = orientationwise(eye, width, height);
  else if (kind == Projection::spherical_positionwise)
    map.ids = positionwise(eye, width, height);
  else
    map.ids = split_orientationwise(eye, width, height);
  map.projection = kind, map.width = width, map.height = height;
  return map.ids;
}

void paint(Frame& frame, Projection projection, const Eye& eye, std::span<const Rgba> colors,
           IdMap& map) {
  const std::size_t width = count(frame.width), height = count(frame.height);
  if (projection == Projection::single_dimension_fast) {
    // The bottom row only; what else is in the frame stays.
    std::copy_n(colors.begin(), std::min(width, colors.size()), frame.pixels.begin());
    return;
  }
  if (projection == Projection::single_dimension) {
    for (std::size_t row = 0; row < height; ++row)
      for (std::size_t column = 0; column < width; ++column)
        frame.pixels[row * width + column] = colors[column * colors.size() / width];
    return;
  }
  const std::vector<std::int32_t>& ids =
      id_map_for(map, eye, projection, frame.width, frame.height);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto id = static_cast<std::uint32_t>(ids[i]);
    const auto byte = [id](int shift) { return static_cast<std::uint8_t>(id >> shift); };
    frame.pixels[i] =
        shows_ids(projection) ? Rgba{byte(24), byte(16), byte(8), byte(0)} : colors[id];
  }
}

void paint_raw_samples(Frame& frame, int samples, std::span<const float> radiance) {
  const std::size_t rows = count(samples), columns = radiance.size() / 3 / rows;
  for (std::size_t row = 0; row < std::min(rows, count(frame.height)); ++row)
    for (std::size_t column = 0; column < std::min(columns, count(frame.width)); ++column) {
      // CompoundRay shows each sample as its share of the mean.
      float share[3];
      for (std::size_t k = 0; k < 3; ++k)
        share[k] = radiance[(column * rows + row) * 3 + k] / static_cast<float>(samples);
      frame.pixels[row * count(frame.width) + column] = display_color(share);
    }
}

}  // namespace omma::compat
