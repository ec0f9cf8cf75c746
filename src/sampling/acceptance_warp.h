// Makes the warp tables of kernel/acceptance.h: for one kernel and acceptance angle the polar angle
// as a function of the radius of a pair of standard normals, by inverting the exact distribution.
#pragma once

#include <vector>

#include "kernel/acceptance.h"

namespace omma {

struct AcceptanceWarp {
  Kernel kernel = Kernel::gaussian;
  double acceptance_rad = 0;
  double polar_integral = 0;   // of eval_polar_density over [0, pi]
  std::vector<double> theta;   // [AcceptanceWarpView::intervals + 1], rad
  std::vector<double> dtheta;  // [AcceptanceWarpView::intervals + 1], d theta / d knot
};

AcceptanceWarp make_acceptance_warp(Kernel kernel, double acceptance_rad);

AcceptanceWarpView view(const AcceptanceWarp& warp);

}  // namespace omma
