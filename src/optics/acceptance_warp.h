// Makes what physics/sampling/acceptance_sampling.h reads: the tables of a sensitivity, and its warp by
// inverting the exact distribution.
#pragma once

#include <memory>
#include <vector>

#include "omma/acceptance.h"
#include "optics/lens_rhabdom.h"
#include "physics/sampling/acceptance_sampling.h"

namespace omma {

// S with the tables it needs.
struct Sensitivity {
  Acceptance acceptance;                       // a lens_rhabdom of Snyder's model as its Gaussian
  std::shared_ptr<const LensProfile> profile;  // airy, lens_rhabdom
};

Sensitivity make_sensitivity(const Acceptance& acceptance);

SensitivityView view(const Sensitivity& sensitivity);

// As acceptance_width_rad and mean_acceptance_width_rad, with the tables at hand.
double width_rad(const Sensitivity& sensitivity, double azimuth_rad);
double mean_width_rad(const Sensitivity& sensitivity);

// Rows of theta(r).
struct WarpRows {
  int intervals = 0;
  std::vector<double> theta;   // [row][intervals + 1], rad
  std::vector<double> dtheta;  // [row][intervals + 1], d theta / d knot
};

struct AcceptanceWarp {
  Acceptance acceptance;
  Sensitivity sensitivity;
  bool round = true;
  double integral_sr = 0;                // of S over the sphere
  std::shared_ptr<const WarpRows> rows;  // none: all light comes along the axis
  std::vector<double> azimuth;           // as AcceptanceWarpView::azimuth; empty: round
};

AcceptanceWarp make_acceptance_warp(const Acceptance& acceptance);

AcceptanceWarpView view(const AcceptanceWarp& warp);

}  // namespace omma
