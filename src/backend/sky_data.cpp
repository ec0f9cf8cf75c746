// Tables of the sky and of discs. Each band counts for as much as any other: directions are chosen
// by the mean over bands of their share in the band's flux.
#include "backend/sky_data.h"

#include <algorithm>
#include <cmath>

#include "physics/light/sky.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Share of the probability that is spread evenly over all cells with light (defensive sampling).
constexpr double even_part = 1.0 / 64;

// Least probability of the sky beside discs: two of 16 rays ask for it, or none.
constexpr double least_sky = 1.0 / 8;

// Of the nodes of a map, with what is the same for all of a row.
struct SkyNodes {
  const SkyMap& map;
  std::size_t rows = static_cast<std::size_t>(map.rows);
  std::size_t columns = static_cast<std::size_t>(map.columns);
  std::size_t channels = static_cast<std::size_t>(map.channels);

  // I of a node, [channel]; `row` counts through both halves.
  const float* intensity(std::size_t row, std::size_t column) const {
    const std::size_t node = channels * static_cast<std::size_t>(map.components);
    return map.radiance.data() + (row * columns + column) * node;
  }
};

// Solid angle of a cell between two rows of nodes of one half.
double cell_sr(const LightData& data, std::size_t row, std::size_t columns) {
  const double between = static_cast<double>(data.one_minus_sine[row]) -
                         static_cast<double>(data.one_minus_sine[row + 1]);
  return 2 * pi / static_cast<double>(columns) * between;
}

// I is stored apart from Q and U, which few paths read: maps are larger than caches.
void split_stokes(LightData& data, const SkyMap& map) {
  const auto channels = static_cast<std::ptrdiff_t>(map.channels);
  data.sky_intensity.reserve(map.radiance.size() / 3);
  data.sky_polarisation.reserve(map.radiance.size() / 3 * 2);
  for (auto at = map.radiance.begin(); at != map.radiance.end(); at += 3 * channels) {
    data.sky_intensity.insert(data.sky_intensity.end(), at, at + channels);
    data.sky_polarisation.insert(data.sky_polarisation.end(), at + channels, at + 3 * channels);
  }
  data.view.sky.radiance = data.sky_intensity.data();
  data.view.sky.polarisation = data.sky_polarisation.data();
}

// The flux of each channel, integrated as cells have it: their solid angle times the mean of their
// corners.
std::vector<double> channel_flux(const LightData& data, const SkyNodes& nodes) {
  std::vector<double> of_row(2 * nodes.rows * nodes.channels, 0.0), flux(nodes.channels, 0.0);
  parallel_for(std::size_t{0}, 2 * nodes.rows, [&](std::size_t row) {
    double* sums = of_row.data() + row * nodes.channels;
    for (std::size_t column = 0; column < nodes.columns; ++column) {
      const float* at = nodes.intensity(row, column);
      for (std::size_t k = 0; k < nodes.channels; ++k) sums[k] += static_cast<double>(at[k]);
    }
    const std::size_t r = row % nodes.rows;
    const double sr = (r > 0 ? cell_sr(data, r - 1, nodes.columns) : 0) +
                      (r + 1 < nodes.rows ? cell_sr(data, r, nodes.columns) : 0);
    for (std::size_t k = 0; k < nodes.channels; ++k) sums[k] *= sr / 2;
  });
  for (std::size_t i = 0; i < of_row.size(); ++i) flux[i % nodes.channels] += of_row[i];
  return flux;
}

// SkyView::row_guide or a row of column_guide. A little before j / count, as u may be rounded up.
void make_guide(const float* sum, std::size_t count, std::uint16_t* guide) {
  for (std::size_t j = 0, i = 0; j < count; ++j) {
    const double u = (static_cast<double>(j) - 0.01) / static_cast<double>(count);
    while (i + 1 < count && static_cast<double>(sum[i + 1]) <= u) ++i;
    guide[j] = static_cast<std::uint16_t>(i);
  }
}

// Rows and columns of cells by weight; `of_channel` is what a channel counts for.
void make_cells(LightData& data, const SkyNodes& nodes, const std::vector<double>& of_channel) {
  const std::size_t columns = nodes.columns, half = nodes.rows - 1;
  std::vector<float> value(2 * nodes.rows * columns);  // of nodes
  parallel_for(std::size_t{0}, 2 * nodes.rows, [&](std::size_t row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const float* at = nodes.intensity(row, column);
      double sum = 0;
      for (std::size_t k = 0; k < nodes.channels; ++k)
        sum += of_channel[k] * static_cast<double>(at[k]);
      value[row * columns + column] = static_cast<float>(sum);
    }
  });
  std::vector<double> row_weight(2 * half);
  data.column_sum.resize(2 * half * (columns + 1));
  data.column_guide.resize(2 * half * columns + 1);
  data.cell_density.resize(2 * half * columns);
  data.row_guide.resize(2 * half + 1);
  parallel_for(std::size_t{0}, 2 * half, [&](std::size_t row) {
    // A cell's weight is the mean of its corners: what is seen anywhere in it is at most four times
    // that.
    const float* lower = value.data() + (row + row / half) * columns;
    const float* upper = lower + columns;
    std::vector<double> weights(columns);
    double all = 0;
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t next = c + 1 < columns ? c + 1 : 0;
      weights[c] = (static_cast<double>(lower[c]) + static_cast<double>(lower[next]) +
                    static_cast<double>(upper[c]) + static_cast<double>(upper[next])) /
                   4;
      all += weights[c];
    }
    row_weight[row] = all * cell_sr(data, row % half, columns);
    const std::vector<float> sum = running_sum(weights);
    std::copy(sum.begin(), sum.end(),
              data.column_sum.begin() + static_cast<std::ptrdiff_t>(row * (columns + 1)));
    make_guide(sum.data(), columns, data.column_guide.data() + row * columns);
  });
  std::vector<double> row_sr(2 * half);
  for (std::size_t row = 0; row < 2 * half; ++row) row_sr[row] = cell_sr(data, row % half, columns);
  data.row_sum = running_sum(row_weight, row_sr);
  make_guide(data.row_sum.data(), 2 * half, data.row_guide.data());
  for (std::size_t row = 0; row < 2 * half; ++row) {
    const double of_row = static_cast<double>(data.row_sum[row + 1] - data.row_sum[row]) /
                          row_sr[row];
    const float* sum = data.column_sum.data() + row * (columns + 1);
    for (std::size_t c = 0; c < columns; ++c)
      data.cell_density[row * columns + c] =
          static_cast<float>(of_row * static_cast<double>(sum[c + 1] - sum[c]));
  }
}

// Total variation distance (0 to 1) of the density of directions from a uniform one, over the
// sphere or its upper half, whichever is nearer.
double unevenness(const LightData& data, const SkyView& sky) {
  const auto columns = static_cast<std::size_t>(sky.columns);
  const auto half = static_cast<std::size_t>(sky.rows - 1);
  double from_sphere = 0, from_half = 0;
  for (std::size_t row = 0; row < 2 * half; ++row) {
    const double sr = cell_sr(data, row % half, columns);
    for (std::size_t c = 0; c < columns; ++c) {
      const auto density = static_cast<double>(data.cell_density[row * columns + c]);
      from_sphere += std::fabs(density - 1 / (4 * pi)) * sr;
      from_half += std::fabs(density - (row < half ? 1 / (2 * pi) : 0)) * sr;
    }
  }
  return std::min(from_sphere, from_half) / 2;
}

// The mean of mu, the cosine at a disc's own surface, over a disc of this radius: the integral of
// sqrt(1 - sin^2 t / sin^2 r) over the cap, by its solid angle.
double mean_surface_cosine(double radius_rad) {
  const double s = std::sin(radius_rad);
  if (s < 1e-4) return 2.0 / 3;  // the next term is s^2 / 15
  const double a = std::cos(radius_rad), half = std::sin(radius_rad / 2);
  return (s - a * a * std::atanh(s)) / (4 * s * half * half);
}

// Solid angle of a disc of this radius.
double disc_sr(double radius_rad) {
  const double half = std::sin(radius_rad / 2);
  return 4 * pi * half * half;
}

void make_discs(LightData& data, const Light& light) {
  const std::size_t bands = light.bands.count();
  for (const Disc& disc : light.discs) {
    DiscView view;
    view.direction = to_float(normalize(to_double(disc.direction)));
    const double sine = std::sin(disc.angular_radius_rad);
    view.chord_2 = static_cast<float>(disc_sr(disc.angular_radius_rad) / pi);
    view.per_sine_2 = static_cast<float>(1 / (sine * sine));
    view.density = static_cast<float>(1 / disc_sr(disc.angular_radius_rad));
    const double lost = 1 - mean_surface_cosine(disc.angular_radius_rad);
    for (std::size_t b = 0; b < bands; ++b) {
      const double u = disc.limb_darkening.empty() ? 0 : disc.limb_darkening[b];
      data.disc_radiance.push_back(static_cast<float>(disc.radiance[b] / (1 - u * lost)));
      data.disc_limb.push_back(static_cast<float>(u));
    }
    data.discs.push_back(view);
  }
  for (std::size_t i = 0; i < data.discs.size(); ++i) {
    data.discs[i].radiance = data.disc_radiance.data() + i * bands;
    if (!light.discs[i].limb_darkening.empty())
      data.discs[i].limb = data.disc_limb.data() + i * bands;
  }
}

}  // namespace

std::vector<float> running_sum(const std::vector<double>& weights,
                               const std::vector<double>& even) {
  const auto even_weight = [&](std::size_t i) {
    return !(weights[i] > 0) ? 0.0 : even.empty() ? 1.0 : even[i];
  };
  double total = 0, even_total = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    total += weights[i];
    even_total += even_weight(i);
  }
  std::vector<float> sum(weights.size() + 1, 0.0f);
  if (!(total > 0)) return sum;
  double so_far = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    so_far += (1 - even_part) * weights[i] / total + even_part * even_weight(i) / even_total;
    sum[i + 1] = static_cast<float>(std::min(std::round(so_far * 0x1p24) * 0x1p-24, 1.0));
  }
  return sum;
}

std::vector<double> make_far(LightData& data, const Light& light) {
  const std::size_t bands = light.bands.count();
  std::vector<double> flux(bands, 0.0);
  std::vector<std::vector<double>> of_disc;
  make_discs(data, light);
  for (const Disc& disc : light.discs) {
    of_disc.push_back(disc.radiance);
    for (std::size_t b = 0; b < bands; ++b) {
      of_disc.back()[b] *= disc_sr(disc.angular_radius_rad);
      flux[b] += of_disc.back()[b];
    }
  }

  std::vector<double> of_channel, sky_flux(bands, 0.0);
  SkyView& sky = data.view.sky;
  if (light.sky != nullptr) {
    data.sky = light.sky;
    const SkyNodes nodes{*data.sky};
    const SkyMap& map = nodes.map;
    for (std::size_t r = 0; r < nodes.rows; ++r) {
      const double half_zenith =
          (1 - static_cast<double>(r) / static_cast<double>(nodes.rows - 1)) * pi / 4;
      data.one_minus_sine.push_back(
          static_cast<float>(2 * std::sin(half_zenith) * std::sin(half_zenith)));
    }
    for (const double x : map.band_from_channel)
      data.band_from_channel.push_back(static_cast<float>(x));
    const std::vector<double> channels = channel_flux(data, nodes);
    const auto weight = [&](std::size_t b, std::size_t k) {
      if (map.band_from_channel.empty()) return b == k ? 1.0 : 0.0;
      return map.band_from_channel[b * nodes.channels + k];
    };
    for (std::size_t b = 0; b < bands; ++b) {
      for (std::size_t k = 0; k < nodes.channels; ++k) sky_flux[b] += weight(b, k) * channels[k];
      flux[b] += sky_flux[b];
    }
    of_channel.assign(nodes.channels, 0.0);
    for (std::size_t b = 0; b < bands; ++b)
      for (std::size_t k = 0; k < nodes.channels; ++k)
        if (flux[b] > 0) of_channel[k] += weight(b, k) / flux[b];
    make_cells(data, nodes, of_channel);

    sky.columns = map.columns;
    sky.rows = map.rows;
    sky.channels = map.channels;
    sky.turns_axes = map.columns < even_columns;
    sky.radiance = map.radiance.data();
    if (map.components == 3) split_stokes(data, map);
    if (!data.band_from_channel.empty()) sky.band_from_channel = data.band_from_channel.data();
    sky.columns_per_rad = static_cast<float>(map.columns / (2 * pi));
    sky.rows_per_rad = static_cast<float>((map.rows - 1) / (pi / 2));
    sky.one_minus_sine = data.one_minus_sine.data();
    sky.row_sum = data.row_sum.data();
    sky.column_sum = data.column_sum.data();
    sky.row_guide = data.row_guide.data();
    sky.column_guide = data.column_guide.data();
    sky.cell_density = data.cell_density.data();
  }

  // Probabilities: the mean over bands of each one's share in the flux. Beside discs the sky's is
  // multiplied by its unevenness, as sampling the lobes finds an even sky just as well. A sky of
  // which little is left is not sampled: a ray in fifty that asks for it in place of the sun is off
  // by all of the sun, which a frame's few rays do not show in their standard error.
  double shining = 0, of_sky = 0;
  for (std::size_t b = 0; b < bands; ++b) {
    if (!(flux[b] > 0)) continue;
    ++shining;
    of_sky += sky_flux[b] / flux[b];
  }
  if (shining > 0) {
    double of_discs = 0;
    std::vector<double> shares;
    for (const std::vector<double>& disc : of_disc) {
      double share = 0;
      for (std::size_t b = 0; b < bands; ++b)
        if (flux[b] > 0) share += disc[b] / flux[b];
      shares.push_back(share);
      of_discs += share;
    }
    double from_sky = of_sky;
    if (of_sky > 0 && of_discs > 0) from_sky *= unevenness(data, sky);
    if (from_sky < least_sky * (from_sky + of_discs)) from_sky = 0;
    const double all = from_sky + of_discs;
    sky.probability = static_cast<float>(from_sky / all);
    for (std::size_t i = 0; i < shares.size(); ++i)
      data.discs[i].probability = static_cast<float>(shares[i] / all);
  }
  data.view.discs = data.discs.data();
  data.view.disc_count = static_cast<std::int32_t>(data.discs.size());
  return flux;
}

}  // namespace omma
