// Inverts the distribution of the polar angle at one azimuth.
#pragma once

#include <vector>

#include "physics/sampling/acceptance_sampling.h"

namespace omma {

// Cells that the polar density is smooth in.
struct PolarCells {
  std::vector<double> edge;  // ascending, rad
  double width = 0;          // of each; 0: they differ
};

PolarCells even_cells(double begin, double end, int count);

// Where a round sensitivity is not zero, or below 1e-17 of the whole.
PolarCells polar_cells(const SensitivityView& s);

// Integral of the polar density at an azimuth.
double polar_integral(const SensitivityView& s, double azimuth, const PolarCells& cells);

// Adds a row of theta(r) with that many intervals; the same integral.
double append_inverse(const SensitivityView& s, double azimuth, const PolarCells& cells,
                      int intervals, std::vector<double>& theta, std::vector<double>& dtheta);

}  // namespace omma
