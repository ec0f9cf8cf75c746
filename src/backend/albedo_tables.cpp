// Directional albedos by quadrature, and their tables.
#include "backend/albedo_tables.h"

#include <algorithm>
#include <cmath>

#include "optics/gauss_legendre.h"
#include "physics/surface/specular_albedo.h"

namespace omma {
namespace {

// Of facets: half of R_s + R_p, and of R_s - R_p.
Albedo reflectance(double cos_i, double ior) {
  if (std::isinf(ior)) return {1, 0};
  const double g = std::sqrt(ior * ior - 1 + cos_i * cos_i);
  if (g == 0) return {0, 0};
  const double s = (cos_i - g) / (cos_i + g);
  const double p = (ior * ior * cos_i - g) / (ior * ior * cos_i + g);
  return {0.5 * (s * s + p * p), 0.5 * (s * s - p * p)};
}

// Integrates F G2/G1 over the unit square of sample_microfacet's random numbers, in which the
// integrand is smooth. Half the azimuths suffice by symmetry.
class AlbedoQuadrature {
 public:
  AlbedoQuadrature() : height_(gauss_legendre(48)), azimuth_(gauss_legendre(24)) {
    for (const double t : azimuth_.node) cosine_.push_back(std::cos(pi * t));
    for (const double t : azimuth_.node) sine_.push_back(std::sin(pi * t));
  }

  Albedo eval(double ior, double alpha, double cos_o) const {
    const double alpha2 = alpha * alpha;
    const auto root = [&](double c) { return std::sqrt(alpha2 + (1 - alpha2) * c * c); };
    const double sin_o = std::sqrt(std::max(0.0, 1 - cos_o * cos_o)), root_o = root(cos_o);
    const double x = alpha * sin_o / root_o, z = cos_o / root_o;
    Albedo sum{0, 0};
    for (std::size_t k = 0; k < height_.node.size(); ++k) {
      const double below = height_.node[k] * (1 + z), radius = std::sqrt(below * (2 - below));
      const double hz = (1 + z) * (1 - height_.node[k]);
      for (std::size_t j = 0; j < cosine_.size(); ++j) {
        const double hx = alpha * (x + radius * cosine_[j]), hy = alpha * radius * sine_[j];
        const double length2 = hx * hx + hy * hy + hz * hz;
        const double along = sin_o * hx + cos_o * hz;
        const double cos_w = 2 * along * hz / length2 - cos_o;
        if (cos_w <= 0) continue;
        const double weight = height_.weight[k] * azimuth_.weight[j] * cos_w * (cos_o + root_o) /
                              (cos_w * root_o + cos_o * root(cos_w));
        const Albedo facet = reflectance(along / std::sqrt(length2), ior);
        sum.all += weight * facet.all;
        // cos^2 of the turn from the facet's plane of incidence to that of view and normal.
        const double across = sin_o * hz - cos_o * hx, whole = across * across + hy * hy;
        const double cos2 = whole > 0 ? across * across / whole : 0.5;
        sum.polarized += weight * facet.polarized * (2 * cos2 - 1);
      }
    }
    return sum;
  }

 private:
  Quadrature height_, azimuth_;
  std::vector<double> cosine_, sine_;  // of the azimuths
};

double alpha_of(double roughness) {
  return std::pow(std::max(roughness, static_cast<double>(least_roughness)), 2);
}

// 2 integral E(c) c dc of the table, which is linear in t between nodes, c = alpha (e^(s t) - 1).
// The integrand is smooth there: four nodes are exact to float.
double mean_of_row(const std::vector<double>& row, double alpha) {
  static constexpr int last = albedo_cosines - 1;
  const double s = std::log1p(1 / alpha) / last;
  const Quadrature q = gauss_legendre(4);
  double mean = 0;
  for (int k = 0; k < last; ++k)
    for (std::size_t i = 0; i < q.node.size(); ++i) {
      const double t = q.node[i], grown = std::exp(s * (k + t));
      const auto at = static_cast<std::size_t>(k);
      mean += 2 * q.weight[i] * ((1 - t) * row[at] + t * row[at + 1]) * alpha * (grown - 1) *
              alpha * s * grown;
    }
  return mean;
}

}  // namespace

Albedo specular_albedo(double ior, double roughness, double cosine) {
  return AlbedoQuadrature().eval(ior, alpha_of(roughness), cosine);
}

std::vector<float> make_specular_albedo(double ior) {
  const AlbedoQuadrature quadrature;
  const double first = std::pow(static_cast<double>(least_roughness), 0.25);
  std::vector<double> mean;
  std::vector<float> table, polarized;
  table.reserve(albedo_floats);
  const auto append = [](const std::vector<double>& values, std::vector<float>& to) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      to.push_back(static_cast<float>(values[i]));
      to.push_back(i + 1 < values.size() ? static_cast<float>(values[i + 1] - values[i]) : 0);
    }
  };
  for (int r = 0; r < albedo_rows; ++r) {
    const double alpha = alpha_of(std::pow(first + (1 - first) * r / (albedo_rows - 1), 4));
    const double s = std::log1p(1 / alpha) / (albedo_cosines - 1);
    std::vector<double> row, polarized_row;
    for (int k = 0; k < albedo_cosines; ++k) {
      // At cosine 0 the masking term vanishes: the limit is taken.
      const double cosine = std::clamp(alpha * std::expm1(s * k), 1e-9, 1.0);
      const Albedo albedo = quadrature.eval(ior, alpha, cosine);
      row.push_back(albedo.all);
      polarized_row.push_back(albedo.polarized);
    }
    append(row, table);
    append(polarized_row, polarized);
    mean.push_back(mean_of_row(row, alpha));
  }
  append(mean, table);
  table.insert(table.end(), polarized.begin(), polarized.end());
  return table;
}

}  // namespace omma
