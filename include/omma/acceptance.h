// The angular sensitivity (acceptance function) of an ommatidium: a kernel and its parameters.
// Directions near the axis are given by their polar angle theta and their azimuth, which is 0
// towards the ommatidium's up vector and grows towards its right (axis x up).
//
// Formulas: physics/sampling/acceptance_sampling.h, optics/lens_rhabdom.h in src.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "omma/kernel.h"
#include "omma/vec.h"

namespace omma {

// How light reaches a rhabdom through its lens.
enum class RhabdomModel : std::uint8_t {
  waveguide,  // Airy pattern coupled into the modes that the rhabdom carries (Stavenga 2004)
  geometric,  // Airy pattern summed over the rhabdom's disc
  snyder,     // Snyder's rule: a Gaussian with the square of its width the sum of both
};

// A measured angular sensitivity, linear between its knots and 0 beyond the last.
struct SensitivityTable {
  std::string path;                 // the file it came from, "" for one made in memory
  std::vector<double> right_rad;    // [column], ascending; of a radial profile the polar angles
  std::vector<double> up_rad;       // [row], ascending; empty for a radial profile
  std::vector<double> sensitivity;  // [row][column], or [column]; not negative, the largest 1

  bool operator==(const SensitivityTable&) const = default;
};

// Only what the kernel needs is read of these.
struct Acceptance {
  Kernel kernel = Kernel::gaussian;
  // gaussian, pillbox, compoundray: full width at half maximum. A gaussian whose minor axis is
  // narrower is elliptical: theta is then measured along a great circle from the axis, and its
  // width at azimuth a is that of the ellipse.
  double width_rad = 0;
  double minor_width_rad = 0;  // gaussian; 0: round
  double major_angle_rad = 0;  // gaussian; azimuth of the major axis
  // airy, lens_rhabdom
  double facet_diameter_m = 0;
  double wavelength_nm = 0;  // in vacuum
  // lens_rhabdom
  RhabdomModel model = RhabdomModel::waveguide;
  double focal_length_m = 0;  // from the nodal point to the rhabdom's tip
  double rhabdom_diameter_m = 0;
  double rhabdom_index = 1.363;   // n1
  double surround_index = 1.340;  // n2
  // table
  std::shared_ptr<const SensitivityTable> table;

  bool operator==(const Acceptance&) const;
};

// Throws omma::Error naming the parameter; `where` begins the message.
void validate_acceptance(const Acceptance& acceptance, const std::string& where);

// Whether the sensitivity depends on the polar angle alone.
bool is_round(const Acceptance& acceptance);

// Full width at half maximum, rad: of the profile through the axis at an azimuth; and of the disc
// as large as all that has half the largest sensitivity, of an ellipse the geometric mean of its
// axes.
double acceptance_width_rad(const Acceptance& acceptance, double azimuth_rad);
double mean_acceptance_width_rad(const Acceptance& acceptance);

// Of many directions at once, as what a kernel needs is prepared once: polar angles and azimuths,
// rad, and as many values. Relative sensitivity, 1 at its largest (but for compoundray, infinite at
// the axis and not normalised); density of sample_acceptance per steradian.
void eval_acceptance(const Acceptance& acceptance, std::span<const double> theta_rad,
                     std::span<const double> azimuth_rad, std::span<double> sensitivity);
void acceptance_pdf(const Acceptance& acceptance, std::span<const double> theta_rad,
                    std::span<const double> azimuth_rad, std::span<double> per_sr);

// Directions drawn in proportion to the sensitivity, in a frame with x towards up, y right and z
// along the axis.
std::vector<Vec3> sample_acceptance(const Acceptance& acceptance, int count, std::uint64_t seed);

// Modulation transfer for sine gratings of so many cycles per radian that vary along an azimuth:
// the response's modulation over the grating's.
void acceptance_mtf(const Acceptance& acceptance, std::span<const double> cycles_per_rad,
                    std::span<const double> azimuth_rad, std::span<double> transfer);

}  // namespace omma
