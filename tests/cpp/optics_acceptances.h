// Acceptances of every kind, for the tests of optics.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "omma/acceptance.h"

namespace omma::test {

inline Acceptance round_acceptance(Kernel kernel, double width_rad) {
  Acceptance a;
  a.kernel = kernel;
  a.width_rad = width_rad;
  return a;
}

inline Acceptance elliptical(double width_rad, double minor_width_rad, double major_angle_rad) {
  Acceptance a;
  a.width_rad = width_rad;
  a.minor_width_rad = minor_width_rad;
  a.major_angle_rad = major_angle_rad;
  return a;
}

inline Acceptance airy(double facet_um, double wavelength_nm) {
  Acceptance a;
  a.kernel = Kernel::airy;
  a.facet_diameter_m = facet_um * 1e-6;
  a.wavelength_nm = wavelength_nm;
  return a;
}

// `waves`: the angle under which the lens sees the rhabdom, over lambda/D.
inline Acceptance lens_rhabdom(RhabdomModel model, double facet_um, double rhabdom_um,
                               double waves) {
  Acceptance a = airy(facet_um, 500);
  a.kernel = Kernel::lens_rhabdom;
  a.model = model;
  a.rhabdom_diameter_m = rhabdom_um * 1e-6;
  a.focal_length_m = a.rhabdom_diameter_m / (waves * 500e-9 / a.facet_diameter_m);
  return a;
}

inline Acceptance measured(std::vector<double> angle_rad, std::vector<double> sensitivity) {
  Acceptance a;
  a.kernel = Kernel::table;
  a.table = std::make_shared<SensitivityTable>(
      SensitivityTable{"", std::move(angle_rad), {}, std::move(sensitivity)});
  return a;
}

// `of`(right_rad, up_rad) in `columns` by `rows` knots over +-width and +-height.
template <typename Function>
Acceptance measured_2d(double width_rad, double height_rad, int columns, int rows,
                       const Function& of) {
  SensitivityTable table;
  for (int i = 0; i < columns; ++i)
    table.right_rad.push_back(width_rad * (2.0 * i / (columns - 1) - 1));
  for (int j = 0; j < rows; ++j) table.up_rad.push_back(height_rad * (2.0 * j / (rows - 1) - 1));
  double largest = 0;
  for (const double up : table.up_rad)
    for (const double right : table.right_rad) {
      table.sensitivity.push_back(of(right, up));
      largest = std::fmax(largest, table.sensitivity.back());
    }
  for (double& s : table.sensitivity) s /= largest;
  Acceptance a;
  a.kernel = Kernel::table;
  a.table = std::make_shared<SensitivityTable>(std::move(table));
  return a;
}

struct NamedAcceptance {
  std::string name;
  Acceptance acceptance;
};

std::vector<NamedAcceptance> acceptances_of_every_kind();

// One value of the functions for many.
double eval_one(const Acceptance& acceptance, double theta_rad, double azimuth_rad = 0);
double pdf_one(const Acceptance& acceptance, double theta_rad, double azimuth_rad = 0);
double mtf_one(const Acceptance& acceptance, double cycles_per_rad, double azimuth_rad = 0);

}  // namespace omma::test
