// The round atmosphere of monte_carlo.cpp: shells, the way of a ray through them, and what is
// looked up of them, made before paths start.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sky {

constexpr int lanes = 8;       // wavelengths together
constexpr int components = 3;  // air, ozone, haze
constexpr int lattice_numbers = 14;
constexpr int angle_cells = 720;
constexpr int zenith_cells = 1024;
constexpr double pi = 3.14159265358979323846;

struct Vec {
  double x, y, z;
};
inline Vec operator+(Vec a, Vec b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(Vec a, Vec b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator*(double s, Vec a) {
  return {s * a.x, s * a.y, s * a.z};
}
double dot(Vec a, Vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec unit(Vec a) {
  return (1 / std::sqrt(dot(a, a))) * a;
}

using Lanes = std::array<float, lanes>;

struct Random {  // splitmix64
  std::uint64_t state;
  double operator()() {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }
};

// What the caller gives; arrays are his.
struct Air {
  int shells;
  const double* radius_m;  // [shell + 1], of the shells' borders, from the ground up
  const double* density;   // [component][shell], optical depth per m over that of the whole column
  const double* depth;     // [component][lanes + 1], of the whole column; the last is that of paths
  const double* scattered;  // [component][lanes + 1], share of it that is scattered
  const double* phase;      // [component][angle_cells + 1][lanes + 1][P11, P12, P22, P33]
};

struct Sky {
  Air air;
  std::vector<float> column;                // [component][border][zenith cell + 1], to the sun
  std::array<std::vector<double>, 3> draw;  // [component], share scattered up to each angle
  std::vector<float> phase;                 // [component][angle_cells + 1][P11, P12][lane]
};

inline double horizon_cosine(const Air& air,
                             double radius) {  // below which the ground hides the sun
  const double ratio = std::min(1.0, air.radius_m[0] / radius);
  return -std::sqrt(1 - ratio * ratio);
}

// Angles of scattering are tabulated evenly by the sine of their half.
double cell_cosine(double cell) {
  return 1 - 2 * (cell / angle_cells) * (cell / angle_cells);
}

inline std::size_t column_at(int borders, int component, int border, int cell) {
  return (static_cast<std::size_t>(component) * borders + border) * (zenith_cells + 1) + cell;
}

inline int shell_of(const Air& air, double radius) {
  const double* end = air.radius_m + air.shells + 1;
  const int above = static_cast<int>(std::upper_bound(air.radius_m, end, radius) - air.radius_m);
  return std::clamp(above - 1, 0, air.shells - 1);
}

// Goes along a ray through the shells, to the ground or out, and tells `visit(shell, length)` of
// each.
template <typename Visit>
inline void march(const Air& air, Vec from, Vec way, Visit visit) {
  const double r2 = dot(from, from), b = dot(from, way);
  const double nearest2 = r2 - b * b;  // squared, of the line to the centre
  const double r = std::sqrt(r2);
  int shell = shell_of(air, r);
  double at = b;  // along the line, from its nearest point
  bool down = b < 0;
  if (down && r <= air.radius_m[shell] * (1 + 1e-12) && shell > 0) --shell;
  for (;;) {
    double to;
    int next;
    const double inner2 = air.radius_m[shell] * air.radius_m[shell] - nearest2;
    if (down && inner2 > 0) {
      to = -std::sqrt(inner2);
      next = shell - 1;
    } else {
      const double outer = air.radius_m[shell + 1];
      to = std::sqrt(std::max(0.0, outer * outer - nearest2));
      next = shell + 1;
      down = false;
    }
    if (to > at) visit(shell, to - at);
    at = std::max(at, to);
    if (next < 0 || next == air.shells) return;
    shell = next;
  }
}

inline void make_columns(Sky& sky) {
  const Air& air = sky.air;
  const int borders = air.shells + 1;
  sky.column.assign(static_cast<std::size_t>(components) * borders * (zenith_cells + 1), 0.0f);
  for (int border = 0; border < borders; ++border) {
    const double r = air.radius_m[border];
    const double lowest = horizon_cosine(air, r);
    for (int cell = 0; cell <= zenith_cells; ++cell) {
      const double t = static_cast<double>(cell) / zenith_cells;
      const double up = std::min(1.0, lowest + (1 - lowest) * t * t + 1e-12);
      std::array<double, components> sum{};
      march(air, {0, r, 0}, {std::sqrt(1 - up * up), up, 0}, [&](int shell, double length) {
        for (int c = 0; c < components; ++c) sum[c] += length * air.density[c * air.shells + shell];
      });
      for (int c = 0; c < components; ++c) {
        sky.column[column_at(borders, c, border, cell)] = static_cast<float>(sum[c]);
      }
    }
  }
}

inline void make_draws(Sky& sky) {
  for (int c = 0; c < components; ++c) {
    std::vector<double>& share = sky.draw[c];
    share.assign(angle_cells + 1, 0.0);
    for (int i = 0; i < angle_cells; ++i) {
      const auto value = [&](int at) {
        return sky.air.phase[((c * (angle_cells + 1) + at) * (lanes + 1) + lanes) * 4];
      };
      const double width = cell_cosine(i) - cell_cosine(i + 1);
      share[i + 1] = share[i] + 0.5 * (value(i) + value(i + 1)) * width;
    }
    for (double& one : share) one /= share.back() > 0 ? share.back() : 1;
  }
}

inline void make_phase(Sky& sky) {
  for (int c = 0; c < components; ++c) {
    for (int i = 0; i <= angle_cells; ++i) {
      for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < lanes; ++l) {
          const double value =
              sky.air.phase[((c * (angle_cells + 1) + i) * (lanes + 1) + l) * 4 + k];
          sky.phase.push_back(static_cast<float>(value));
        }
      }
    }
  }
}

}  // namespace sky
