// Densities of rays that an ommatidium demands and weights, by the distance from its axis, as
// tables per steradian.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "optics/acceptance_warp.h"

namespace omma {

// Intervals in a table of densities; between them they are within 2e-5.
inline constexpr int density_intervals = 512;

// Over the squared chord from the axis.
struct DensityTable {
  double reach_chord2 = -1;  // none count beyond
  float scale = 0;           // intervals per squared chord
  std::array<float, density_intervals + 2> density{};

  // The interval that a squared chord within reach is in, and where.
  float place(double chord2) const {
    return std::min(static_cast<float>(chord2) * scale, static_cast<float>(density_intervals));
  }
  float at(double chord2) const {
    const float x = place(chord2);
    const auto i = static_cast<std::size_t>(x);
    return density[i] + (x - static_cast<float>(i)) * (density[i + 1] - density[i]);
  }
};

// For one acceptance.
struct SharingDensities {
  double width_rad = 0;  // full width at half maximum; 0: it shares with nobody
  DensityTable weight;   // of its own sampling: what weighs rays
  DensityTable demand;   // what decides how many rays there are
  DensityTable most;     // the largest that `demand` is there or further out, by its intervals
  // Polar angles that share its sampling evenly.
  static constexpr int polar_angles = 12;
  std::array<double, polar_angles> polar_rad{};
};

// [warp]. Empty tables mean that it shares with nobody: lenses, whose dark rings extend to the
// side, and fields so narrow that no lattice over the sphere would have `samples` points in them.
std::vector<SharingDensities> make_sharing_densities(const std::vector<AcceptanceWarp>& warps,
                                                     int samples);

}  // namespace omma
