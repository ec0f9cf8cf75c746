// Tables of densities over the squared chord from the axis.
#include "sampling/sharing_densities.h"

#include <cmath>

#include "sampling/sphere_lattice.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Beyond this many standard deviations a Gaussian has 0.03 % of its weight; leaving it out raises
// the modulation transfer by 0.001 at most.
constexpr double reach_sigmas = 4;

// Largest angle from the axis at which rays count. The dark rings of lenses extend to the side, and
// cutting them off would cost percents: lenses share nothing.
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
    // Just inside the edge, where a pillbox is still 1.
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
  // S <= 1, so this is the largest density that it demands alone.
  if (!(reach > 0 && warp.integral_sr * most_lattice_points >= 4 * pi * samples)) return made;
  made.width_rad = width_rad(warp.sensitivity, 0);
  made.weight = make_table(warp, reach);
  made.demand = made.weight;
  if (acceptance.kernel == Kernel::pillbox) {
    // Overlapping discs would cut the sphere into many small pieces, each with a lattice of its own
    // and uneven points at its border. The demand is therefore a Gaussian of about the same width,
    // sigma = 0.6 of the radius; sums of these are smooth.
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
