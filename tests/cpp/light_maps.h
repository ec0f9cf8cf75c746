// Lights made in memory for the tests of light from afar.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "backend/light_data.h"
#include "omma/light.h"
#include "physics/light/far_light.h"

namespace omma::test {

// Bands of a single wavelength each, in the visible.
inline Bands narrow_bands(int count) {
  Bands bands;
  for (int b = 0; b < count; ++b) bands.wavelength_nm.push_back(500 + 10 * b);
  bands.weight.assign(static_cast<std::size_t>(count * count), 0.0);
  for (int b = 0; b < count; ++b) bands.weight[static_cast<std::size_t>(b * (count + 1))] = 1;
  return bands;
}

inline double elevation_of_row(const SkyMap& sky, int half, int row) {
  return (half == 0 ? 1 : -1) * (pi / 2) * row / (sky.rows - 1);
}
inline double azimuth_of_column(const SkyMap& sky, int column) {
  return 2 * pi * column / sky.columns;
}

inline Vec3d direction_of(double azimuth_rad, double elevation_rad) {
  const double level = std::cos(elevation_rad);
  return {std::sin(azimuth_rad) * level, std::sin(elevation_rad), -std::cos(azimuth_rad) * level};
}

// value(half, row, column, component, channel) at each node.
template <typename Value>
std::shared_ptr<const SkyMap> made_sky(int columns, int rows, int components, int channels,
                                       const Value& value) {
  auto sky = std::make_shared<SkyMap>();
  sky->columns = columns;
  sky->rows = rows;
  sky->components = components;
  sky->channels = channels;
  for (int half = 0; half < 2; ++half)
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        for (int component = 0; component < components; ++component)
          for (int channel = 0; channel < channels; ++channel)
            sky->radiance.push_back(
                static_cast<float>(value(half, row, column, component, channel)));
  return sky;
}

// As the physics sees it, where there is no scene.
inline std::unique_ptr<LightData> light_alone(const Light& light) {
  return make_light_data(light, {}, {}, {});
}

// One direction of light from afar, as the physics has it for the rays of a packet.
struct OneDirection {
  using Ray = Lanes<1, 1>;
  float direction[3][1];
  SkyLookups<Ray> on_sky;

  OneDirection(const LightView& light, Vec3 d) : direction{{d.x}, {d.y}, {d.z}} {
    find_far<Ray>(light, direction, LaneMask<Ray>::all(), on_sky);
  }
};

// Radiance of sky and discs, [component][band].
inline std::vector<float> far_at(const LightData& data, Vec3 d, int components = 1) {
  using Ray = OneDirection::Ray;
  const OneDirection one(data.view, d);
  const auto all = LaneMask<Ray>::all();
  std::vector<float> stokes(static_cast<std::size_t>(components * data.view.bands), 7.0f);
  eval_sky_lanes<Ray>(
      data.view, {one.direction, one.on_sky, all, components > 1 ? all : LaneMask<Ray>{}, false},
      components, stokes.data());
  add_disc_light<Ray>(data.view, {one.direction, one.direction}, all, nullptr, stokes.data());
  return stokes;
}

// Probability per solid angle with which next-event estimation samples a direction.
inline float far_pdf(const LightView& light, Vec3 d) {
  using Ray = OneDirection::Ray;
  const OneDirection one(light, d);
  float pdf = 0;
  find_far_pdf<Ray>(light, one.direction, one.on_sky, LaneMask<Ray>::all(), &pdf);
  return pdf;
}

inline Vec3 sample_far_direction(const LightView& light, float u0, float u1) {
  using Ray = OneDirection::Ray;
  float direction[3][1];
  sample_far<Ray>(light, &u0, &u1, LaneMask<Ray>::all(), direction);
  return vec_at(direction, 0);
}

}  // namespace omma::test
