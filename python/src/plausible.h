// Whether numbers of optics can be meant: what is outside of the range of animals' eyes is nearly
// always given in another unit.
#pragma once

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
};

// Throws an Error that names the argument, the range, and what may have been meant. Zero, negative
// numbers and what is not finite are let through: whether they are possible is checked by those who
// take them.
void expect_plausible(Quantity quantity, const char* name, double value, bool allow_unusual);

}  // namespace omma::python
