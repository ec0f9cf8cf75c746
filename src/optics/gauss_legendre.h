// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
#pragma once

#include <cmath>
#include <vector>

#include "omma/vec.h"

namespace omma {

struct Quadrature {
  std::vector<double> node, weight;
};

inline Quadrature gauss_legendre(int count) {
  Quadrature q;
  for (int i = 0; i < count; ++i) {
    // Newton's method on the Legendre polynomial from the usual first guess.
    double x = std::cos(pi * (i + 0.75) / (count + 0.5)), slope = 1;
    for (int step = 0; step < 6; ++step) {
      double before = 1, value = x;
      for (int n = 2; n <= count; ++n) {
        const double next = ((2 * n - 1) * x * value - (n - 1) * before) / n;
        before = value;
        value = next;
      }
      slope = count * (x * value - before) / (x * x - 1);
      x -= value / slope;
    }
    q.node.push_back(0.5 * (1 - x));
    q.weight.push_back(1 / ((1 - x * x) * slope * slope));
  }
  return q;
}

}  // namespace omma
