// Backward Monte Carlo of the polarised sky over a black ground, in a round atmosphere of shells:
// what discrete ordinates cannot do, low suns and twilight.
//
// A path starts at the eye and goes from scattering to scattering; at each one the sun's light that
// is scattered into it is added, for all suns and all wavelengths at once, as neither changes the
// path. Wavelengths differ by weights, so they must be neighbours. From each scattering two rays
// leave: along one the path goes on as light does, the other, which adds the suns' light, is drawn
// more often near the horizon and far ahead, where the air is still lit in twilight. The first
// numbers of a path are a lattice, shifted anew for each batch, so that batches say how large the
// error is. Stokes frames: see include/omma/light.h.
#include "round_air.h"

namespace {

using namespace sky;

struct Path {
  Vec at, way, axis;  // where it is, where it looks, the axis of its Stokes vectors
  std::array<std::array<Lanes, 3>, 3> stokes;  // from light here to light at the eye
};

// The way ahead of a path, shell by shell.
struct Ahead {
  std::vector<int> shell;
  std::vector<double> length, depth, chance, root;  // chance: of scattering there
  double sum = 0, root_sum = 0;                     // of chances and of roots
};

void look_ahead(const Air& air, const Path& path, Ahead& ahead) {
  ahead.shell.clear(), ahead.length.clear(), ahead.depth.clear();
  ahead.chance.clear(), ahead.root.clear();
  ahead.sum = ahead.root_sum = 0;
  double through = 1;
  march(air, path.at, path.way, [&](int shell, double length) {
    double depth = 0;
    for (int c = 0; c < components; ++c) {
      depth += length * air.density[c * air.shells + shell] * air.depth[c * (lanes + 1) + lanes] *
               air.scattered[c * (lanes + 1) + lanes];
    }
    const double left = std::exp(-depth);
    const double chance = through * (depth > 1e-6 ? 1 - left : depth);
    ahead.shell.push_back(shell), ahead.length.push_back(length), ahead.depth.push_back(depth);
    ahead.chance.push_back(chance), ahead.root.push_back(std::sqrt(chance * length));
    ahead.sum += chance, ahead.root_sum += ahead.root.back();
    through *= left;
  });
}

struct Place {
  Vec at;
  int shell;
  Lanes weight;  // of light from there, over the density it was drawn with
};

// A place ahead; `even` is how much is drawn by roots, the rest by chances.
Place draw_place(const Air& air, const Path& path, const Ahead& ahead, double even, double choice) {
  double before = 0, chance = 0;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < ahead.depth.size(); ++i) {
    const double m =
        (1 - even) * ahead.chance[i] / ahead.sum + even * ahead.root[i] / ahead.root_sum;
    if (m > 0) chosen = i, chance = m;
    if (before + m > choice) break;
    before += m;
  }
  const double within = std::clamp((choice - before) / chance, 0.0, 1.0);
  const double depth = ahead.depth[chosen];
  const double share =
      depth > 1e-6 ? -std::log(1 - within * (1 - std::exp(-depth))) / depth : within;
  std::array<double, components> column{};
  double way = 0;
  for (std::size_t i = 0; i <= chosen; ++i) {
    const double length = i < chosen ? ahead.length[i] : share * ahead.length[i];
    way += length;
    for (int c = 0; c < components; ++c) {
      column[c] += length * air.density[c * air.shells + ahead.shell[i]];
    }
  }
  Place place{path.at + way * path.way, ahead.shell[chosen], {}};
  double rate = 0, passed = 0;
  for (int c = 0; c < components; ++c) {
    const double part = air.depth[c * (lanes + 1) + lanes] * air.scattered[c * (lanes + 1) + lanes];
    rate += air.density[c * air.shells + place.shell] * part;
    passed += column[c] * part;
  }
  const double drawn = chance / ahead.chance[chosen] * rate * std::exp(-passed);
  for (int l = 0; l < lanes; ++l) {
    double lost = 0;
    for (int c = 0; c < components; ++c) lost += column[c] * air.depth[c * (lanes + 1) + l];
    place.weight[l] = static_cast<float>(std::exp(-lost) / drawn);
  }
  return place;
}

// Scattering coefficients of what scatters there, per m, [component][lanes + 1].
using Rates = std::array<std::array<float, lanes + 1>, components>;
Rates rates_in(const Air& air, int shell) {
  Rates rates;
  for (int c = 0; c < components; ++c) {
    for (int l = 0; l <= lanes; ++l) {
      rates[c][l] =
          static_cast<float>(air.density[c * air.shells + shell] * air.depth[c * (lanes + 1) + l] *
                             air.scattered[c * (lanes + 1) + l]);
    }
  }
  return rates;
}

struct Suns {
  int count;
  std::vector<float> x, y, z;
  std::vector<float> lift, cosine, along, across;  // of the last scattering, see add_suns
};

// Adds the light that comes from the suns and is scattered once there into the path.
void add_suns(const Sky& sky, const Path& path, const Place& place, Suns& suns, float* sums) {
  const Air& air = sky.air;
  const int borders = air.shells + 1;
  const Rates rates = rates_in(air, place.shell);
  const double r = std::sqrt(dot(place.at, place.at));
  const Vec up = (1 / r) * place.at;
  const Vec side = cross(path.way, path.axis);
  const auto project = [&](Vec on, std::vector<float>& result) {
    const float x = static_cast<float>(on.x), y = static_cast<float>(on.y);
    const float z = static_cast<float>(on.z);
    for (int s = 0; s < suns.count; ++s) {
      result[s] = x * suns.x[s] + y * suns.y[s] + z * suns.z[s];
    }
  };
  project(up, suns.lift);
  project(path.way, suns.cosine);
  project(path.axis, suns.along);
  project(side, suns.across);
  const int shell = shell_of(air, r);
  const float above = static_cast<float>(std::clamp(
      (r - air.radius_m[shell]) / (air.radius_m[shell + 1] - air.radius_m[shell]), 0., 1.));
  const float lowest = static_cast<float>(horizon_cosine(air, r));
  Lanes depth[components];
  for (int c = 0; c < components; ++c) {
    for (int l = 0; l < lanes; ++l)
      depth[c][l] = static_cast<float>(air.depth[c * (lanes + 1) + l]);
  }
  for (int s = 0; s < suns.count; ++s) {
    if (suns.lift[s] <= lowest) continue;
    const float t = std::sqrt((suns.lift[s] - lowest) / (1 - lowest)) * zenith_cells;
    const int cell = std::min(static_cast<int>(t), zenith_cells - 1);
    const float f = t - static_cast<float>(cell);
    Lanes through{}, p11{}, p12{};
    const float angle = std::sqrt(std::max(0.0f, 0.5f - 0.5f * suns.cosine[s])) * angle_cells;
    const int step = std::min(static_cast<int>(angle), angle_cells - 1);
    const float g = angle - static_cast<float>(step);
    for (int c = 0; c < components; ++c) {
      const float* low = &sky.column[column_at(borders, c, shell, cell)];
      const float* high = low + zenith_cells + 1;
      const float column =
          (1 - above) * ((1 - f) * low[0] + f * low[1]) + above * ((1 - f) * high[0] + f * high[1]);
      for (int l = 0; l < lanes; ++l) through[l] -= column * depth[c][l];
      if (rates[c][lanes] == 0) continue;
      const float* table =
          &sky.phase[(static_cast<std::size_t>(c) * (angle_cells + 1) + step) * 2 * lanes];
      for (int l = 0; l < lanes; ++l) {
        p11[l] += rates[c][l] * ((1 - g) * table[l] + g * table[2 * lanes + l]);
        p12[l] += rates[c][l] * ((1 - g) * table[lanes + l] + g * table[3 * lanes + l]);
      }
    }
    for (int l = 0; l < lanes; ++l) through[l] = std::exp(through[l]) * place.weight[l];
    // cos and sin of twice the angle from the path's axis to the plane of scattering.
    const float a = suns.along[s], b = suns.across[s], ab = a * a + b * b + 1e-30f;
    const float c2 = (a * a - b * b) / ab, s2 = 2 * a * b / ab;
    for (int row = 0; row < 3; ++row) {
      float* sum = &sums[(s * 3 + row) * lanes];
      const auto& stokes = path.stokes[row];
      for (int l = 0; l < lanes; ++l) {
        sum[l] +=
            through[l] * (stokes[0][l] * p11[l] + p12[l] * (stokes[1][l] * c2 + stokes[2][l] * s2));
      }
    }
  }
}

// Directions just above the horizon, where twilight comes from: density exp(-x / low_sky) by the
// sine of elevation x, over that of even directions.
constexpr double low_sky = 0.15;
const double low_norm = low_sky * (1 - std::exp(-1 / low_sky));

double low_density(double x) {
  return x > 0 ? 2 * std::exp(-x / low_sky) / low_norm : 0;
}

Vec draw_low(Vec up, double choice, double round) {
  const double x = -low_sky * std::log(1 - choice * low_norm / low_sky);
  const Vec other = std::abs(up.z) < 0.9 ? Vec{0, 0, 1} : Vec{1, 0, 0};
  const Vec right = unit(cross(other, up)), ahead = cross(up, right);
  const double flat = std::sqrt(std::max(0.0, 1 - x * x));
  return x * up + flat * (std::cos(2 * pi * round) * right + std::sin(2 * pi * round) * ahead);
}

Vec draw_scattered(const Sky& sky, const Path& path, const Rates& rates, double total,
                   double choice, double round) {
  double u = choice * total;
  int by = 0;
  while (by < components - 1 && u >= rates[by][lanes]) u -= rates[by++][lanes];
  u = std::clamp(u / rates[by][lanes], 0.0, 1.0 - 1e-12);
  const std::vector<double>& share = sky.draw[by];
  const int cell = std::clamp(
      static_cast<int>(std::upper_bound(share.begin(), share.end(), u) - share.begin()) - 1, 0,
      angle_cells - 1);
  const double low = cell_cosine(cell), high = cell_cosine(cell + 1);
  const double f = (u - share[cell]) / std::max(1e-300, share[cell + 1] - share[cell]);
  const double cosine = low + f * (high - low);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const Vec side = cross(path.way, path.axis);
  const Vec across = std::cos(2 * pi * round) * path.axis + std::sin(2 * pi * round) * side;
  return unit(cosine * path.way + sine * across);
}

// Turns the path into a direction that is drawn, a share `low` of them just above the horizon;
// wavelengths get their matrices.
void turn(const Sky& sky, Path& path, const Rates& rates, double low, double choice, double round) {
  const Air& air = sky.air;
  double total = 0;
  for (int c = 0; c < components; ++c) total += rates[c][lanes];
  const Vec up = unit(path.at);
  const Vec way = choice < low
                      ? draw_low(up, choice / low, round)
                      : draw_scattered(sky, path, rates, total, (choice - low) / (1 - low), round);
  const double cosine = std::clamp(dot(path.way, way), -1.0, 1.0);
  const double angle = std::sqrt(std::max(0.0, 0.5 - 0.5 * cosine)) * angle_cells;
  const int step = std::min(static_cast<int>(angle), angle_cells - 1);
  const double g = angle - step;
  std::array<std::array<double, 4>, lanes + 1> matrix{};
  double drawn = 0;  // density of directions over an even one, constant within a cell
  for (int c = 0; c < components; ++c) {
    if (rates[c][lanes] == 0) continue;
    for (int l = 0; l <= lanes; ++l) {
      for (int k = 0; k < 4; ++k) {
        const auto at = [&](int i) {
          return air.phase[((c * (angle_cells + 1) + i) * (lanes + 1) + l) * 4 + k];
        };
        matrix[l][k] += rates[c][l] * ((1 - g) * at(step) + g * at(step + 1));
      }
    }
    const double width = cell_cosine(step) - cell_cosine(step + 1);
    drawn += rates[c][lanes] / total * (sky.draw[c][step + 1] - sky.draw[c][step]) * 2 / width;
  }
  drawn = (1 - low) * drawn + low * low_density(dot(up, way));
  // cos and sin of twice the angle from the path's axis to the plane of scattering.
  const double a = dot(way, path.axis), b = dot(way, cross(path.way, path.axis));
  const double ab = a * a + b * b + 1e-30;
  const float c2 = static_cast<float>((a * a - b * b) / ab),
              s2 = static_cast<float>(2 * a * b / ab);
  const float scale = static_cast<float>(1 / drawn);
  for (int l = 0; l < lanes; ++l) {
    const float p11 = static_cast<float>(matrix[l][0]) * scale;
    const float p12 = static_cast<float>(matrix[l][1]) * scale;
    const float p22 = static_cast<float>(matrix[l][2]) * scale;
    const float p33 = static_cast<float>(matrix[l][3]) * scale;
    for (auto& row : path.stokes) {
      const float i = row[0][l];
      const float q = row[1][l] * c2 + row[2][l] * s2;
      const float u = -row[1][l] * s2 + row[2][l] * c2;
      row[0][l] = i * p11 + q * p12;
      row[1][l] = i * p12 + q * p22;
      row[2][l] = u * p33;
    }
  }
  const Vec normal = unit(cross(path.way, way));
  path.way = way;
  path.axis = cross(normal, way);
}

}  // namespace

// Adds up to [batch][sun][I, Q, U][lane] of radiance over irradiance 1 of the sun, for an eye on
// the ground that looks along `way` ([x, y, z], y up); suns are [sun][x, y, z].
extern "C" void omma_sky_monte_carlo(int shells, const double* radius_m, const double* density,
                                     const double* depth, const double* scattered,
                                     const double* phase, const double* way, int suns,
                                     const double* sun, int batches, int paths,
                                     int most_scatterings, std::uint64_t seed, double* result) {
  Sky sky{{shells, radius_m, density, depth, scattered, phase}, {}, {}, {}};
  make_columns(sky);
  make_draws(sky);
  make_phase(sky);
  Suns all;
  all.count = suns;
  for (int s = 0; s < suns; ++s) {
    all.x.push_back(static_cast<float>(sun[3 * s]));
    all.y.push_back(static_cast<float>(sun[3 * s + 1]));
    all.z.push_back(static_cast<float>(sun[3 * s + 2]));
  }
  for (auto* part : {&all.lift, &all.cosine, &all.along, &all.across}) part->resize(suns);
  // A rank-1 sequence of good lattices: powers of the root of x^(n + 1) = x + 1 (Roberts 2018).
  std::array<double, lattice_numbers> step;
  double root = 1.5;
  for (int i = 0; i < 60; ++i) root = std::pow(1 + root, 1.0 / (lattice_numbers + 1));
  for (int i = 0; i < lattice_numbers; ++i) step[i] = std::fmod(std::pow(1 / root, i + 1), 1.0);
  Random random{seed};
  Ahead ahead;
  for (int batch = 0; batch < batches; ++batch) {
    std::array<double, lattice_numbers> shift;
    for (double& one : shift) one = random();
    double* sums = result + static_cast<std::size_t>(batch) * suns * 3 * lanes;
    std::vector<float> part(static_cast<std::size_t>(suns) * 3 * lanes, 0.0f);
    for (int index = 0; index < paths; ++index) {
      int used = 0;
      const auto number = [&] {
        if (used >= lattice_numbers) return random();
        const double value = shift[used] + index * step[used];
        ++used;
        return value - std::floor(value);
      };
      Path path;
      path.at = {0, radius_m[0] * (1 + 1e-9), 0};
      path.way = {way[0], way[1], way[2]};
      path.axis = unit(Vec{0, 1, 0} - path.way.y * path.way);
      path.stokes = {};
      for (int k = 0; k < 3; ++k) path.stokes[k][k].fill(1.0f);
      look_ahead(sky.air, path, ahead);
      if (!(ahead.sum > 1e-9)) continue;
      add_suns(sky, path, draw_place(sky.air, path, ahead, 0.5, number()), all, part.data());
      for (int order = 1; order < most_scatterings; ++order) {
        const Place place = draw_place(sky.air, path, ahead, order == 1 ? 0.3 : 0.0, number());
        path.at = place.at;
        for (auto& row : path.stokes) {
          for (auto& column : row) {
            for (int l = 0; l < lanes; ++l) column[l] *= place.weight[l];
          }
        }
        const Rates rates = rates_in(sky.air, place.shell);
        Path branch = path;
        double choice = number(), round = number();
        turn(sky, branch, rates, 0.5, choice, round);
        look_ahead(sky.air, branch, ahead);
        if (ahead.sum > 1e-9) {
          add_suns(sky, branch, draw_place(sky.air, branch, ahead, 0.5, number()), all,
                   part.data());
        }
        choice = number(), round = number();
        turn(sky, path, rates, 0.0, choice, round);
        look_ahead(sky.air, path, ahead);
        if (!(ahead.sum > 1e-9)) break;
        float largest = 0;
        for (int l = 0; l < lanes; ++l) largest = std::max(largest, path.stokes[0][0][l]);
        if (order >= 3 && largest < 0.3f) {
          if (random() >= largest / 0.3f) break;
          for (auto& row : path.stokes) {
            for (auto& column : row) {
              for (int l = 0; l < lanes; ++l) column[l] *= 0.3f / largest;
            }
          }
        }
      }
      if (index % 256 == 255 || index == paths - 1) {  // singles hold few, doubles the sum
        for (std::size_t i = 0; i < part.size(); ++i) sums[i] += part[i];
        std::fill(part.begin(), part.end(), 0.0f);
      }
    }
    for (int i = 0; i < suns * 3 * lanes; ++i) sums[i] /= 4 * pi * paths;
  }
}
