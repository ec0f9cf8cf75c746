#include "sampling/sharing_densities.h"

#include <cmath>

#include "sampling/sphere_lattice.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Beyond this many standard deviations a Gaussian has 0.03 % of its weight; leaving it out raises
// the modulation transfer by 0.001 at most.
constexpr double reach_sigmas = 4;

// Largest angle from the axis at which rays count. A lens's dark rings go on to the side: what is
// left out beyond a few widths would be percents. Those share nothing, and have rays of their own.
double reach_rad(const Acceptance& a) {
  switch (a.kernel) {
    case Kernel::gaussian:
    case Kernel::compoundray:
      return std::min(reach_sigmas * sigma_per_fwhm * a.width_rad, pi);
    case Kernel::pillbox:
      return std::min(0.5 * a.width_rad, pi);
    case Kernel::table:
      return a.table->right_rad.back();
    case Kernel::airy:
    case Kernel::lens_rhabdom:
      return 0;
  }
  return 0;
}

DensityTable make_table(const AcceptanceWarp& warp, double reach_rad) {
  DensityTable table;
  const double chord = 2 * std::sin(std::min(reach_rad, pi) / 2);
  table.reach_chord2 = chord * chord;
  table.scale = static_cast<float>(density_intervals / table.reach_chord2);
  for (int i = 0; i <= density_intervals; ++i) {
    // A hair inside, where a pillbox has not ended yet.
    const double chord2 = table.reach_chord2 * (1 - 1e-12) * i / density_intervals;
    table.density[static_cast<std::size_t>(i)] = static_cast<float>(
        acceptance_pdf(view(warp), 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(chord2))), 0));
  }
  table.density[density_intervals + 1] = table.density[density_intervals];
  return table;
}

DensityTable largest_beyond(DensityTable table) {
  for (std::size_t i = density_intervals + 1; i-- > 0;)
    table.density[i] = std::max(table.density[i], table.density[i + 1]);
  return table;
}

SharingDensities make_densities(const AcceptanceWarp& warp, int samples) {
  SharingDensities made;
  const Acceptance& acceptance = warp.sensitivity.acceptance;
  const double reach = reach_rad(acceptance);
  // S is 1 at most, so that this is the densest that it asks for alone.
  if (!(reach > 0 && warp.integral_sr * most_lattice_points >= 4 * pi * samples)) return made;
  made.width_rad = width_rad(warp.sensitivity, 0);
  made.weight = make_table(warp, reach);
  made.demand = made.weight;
  if (acceptance.kernel == Kernel::pillbox) {
    // Discs overlap in many small pieces, each of which would have a lattice of its own; the border
    // of one is where points are too many or too few. Gaussians with 0.6 of the radius for standard
    // deviation are as wide, and add up smoothly.
    const double sigma = 0.6 * 0.5 * made.width_rad;
    Acceptance smooth;
    smooth.width_rad = sigma / sigma_per_fwhm;
    made.demand = make_table(make_acceptance_warp(smooth), std::min(3 * sigma, pi));
  }
  made.most = largest_beyond(made.demand);
  for (int i = 0; i < SharingDensities::polar_angles; ++i)
    made.polar_rad[static_cast<std::size_t>(i)] = sample_polar_angle(
        view(warp), std::sqrt(-2 * std::log1p(-(i + 0.5) / SharingDensities::polar_angles)), 0);
  return made;
}

}  // namespace

std::vector<SharingDensities> make_sharing_densities(const std::vector<AcceptanceWarp>& warps,
                                                     int samples) {
  std::vector<SharingDensities> all(warps.size());
  parallel_for(std::size_t{0}, warps.size(),
               [&](std::size_t w) { all[w] = make_densities(warps[w], samples); });
  return all;
}

}  // namespace omma
