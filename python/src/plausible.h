// Whether numbers of optics can be meant: what is outside of the range of animals' eyes is nearly
// always given in another unit.
#pragma once

#include <string>
#include <vector>

#include "omma/eye.h"

namespace omma::python {

enum class Quantity {
  acceptance_angle,
  local_angle,
  offset_angle,
  facet_diameter,
  focal_length,
  rhabdom_diameter,
  rhabdom_length,
  absorption,
  wavelength,
  refractive_index,
  polarisation_sensitivity,
  eye_radius,
  aperture_diameter,
};

// Throws an Error that names the argument, the range, and what may have been meant. Zero, negative
// numbers and what is not finite are let through: whether they are possible is checked by those who
// take them.
void expect_plausible(Quantity quantity, const char* name, double value, bool allow_unusual);

// What of an eye is in no animal's range, a sentence for each array; empty where all can be meant.
// Files and arrays are data: they are told of, not refused.
std::vector<std::string> unusual_of(const Eye& eye);

// A UserWarning for each of these, at the Python line that made the eye; none where that is a line
// of the package itself, whose makers check what they are given.
void warn_of_unusual(const Eye& eye);

}  // namespace omma::python
