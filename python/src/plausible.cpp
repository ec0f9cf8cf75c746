// The plausible ranges of optics, one table, and what was meant by a number outside of its range.
#include "plausible.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>

#include "omma/error.h"
#include "omma/vec.h"

namespace nb = nanobind;

namespace omma::python {
namespace {

struct Range {
  const char* quantity;
  double least, most;
  const char* unit;
};

// In the order of Quantity. Wide on purpose, ten times and more beyond what animals have: they are
// to catch units, not to judge eyes. Numbers of animals without a source here: docs/species.md.
constexpr Range ranges[] = {
    // From 0.24 degrees (dragonflies) to tens of degrees (springtails): Land 1997, Annu Rev Entomol
    // 42:147. Up to 60 degrees, so that 1.1 and more, meant as degrees, are found out.
    {"acceptance angle", 0.02 * pi / 180, 60 * pi / 180, "rad"},
    // Azimuths in an ommatidium's frame: any, a turn either way.
    {"angle", 0, 2 * pi, "rad"},
    // Rhabdomeres look a few degrees beside the axis.
    {"offset from the axis", 0, 60 * pi / 180, "rad"},
    // 5 um to 0.3 mm (horseshoe crabs).
    {"facet diameter", 1e-6, 1e-3, "m"},
    {"focal length", 1e-6, 1e-2, "m"},
    // Below 0.2 um nothing is guided; fused rhabdoms of superposition eyes have tens of um.
    {"rhabdom diameter", 1e-7, 5e-4, "m"},
    // Up to a millimetre in dragonflies.
    {"rhabdom length", 1e-6, 1e-2, "m"},
    // 0.005 to 0.010 per um: Warrant and Nilsson 1998, Vision Res 38:195.
    {"absorption", 1e2, 1e5, "per m"},
    // Visual pigments peak between 300 and 800 nm.
    {"wavelength", 200, 1200, "nm"},
    // Water 1.33, chitin 1.57.
    {"refractive index", 1, 2, ""},
    // Up to about 20 in dorsal rims and in crustaceans.
    {"polarisation sensitivity", 1, 100, ""},
    // From 50 um to some millimetres.
    {"eye radius", 1e-6, 0.1, "m"},
};

// Numbers in another unit, by what they must be multiplied with.
struct Unit {
  const char* unit;
  const char* other;
  double factor;
};
constexpr Unit units[] = {
    {"rad", "degrees", pi / 180},
    {"m", "\u00b5m", 1e-6},
    {"m", "mm", 1e-3},
    {"m", "nm", 1e-9},
    {"nm", "m", 1e9},
    {"nm", "\u00b5m", 1e3},
    {"per m", "per \u00b5m", 1e6},
    {"per m", "per mm", 1e3},
};

std::string show(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

}  // namespace

void expect_plausible(Quantity quantity, const char* name, double value, bool allow_unusual) {
  const Range& range = ranges[static_cast<std::size_t>(quantity)];
  const double size = std::abs(value);
  const bool angle = range.least == 0;  // either way round
  if (allow_unusual || !std::isfinite(value) || value == 0 || (value < 0 && !angle)) return;
  if (size >= range.least && size <= range.most) return;
  const std::string unit = *range.unit ? " " + std::string(range.unit) : "";
  std::string meant;
  for (const Unit& u : units)
    if (meant.empty() && std::string(u.unit) == range.unit && size * u.factor >= range.least &&
        size * u.factor <= range.most)
      meant = "; " + show(value) + " " + u.other + " would be " + show(value * u.factor) + unit;
  throw Error(std::string(name) + ": expected " +
              (angle ? "-" + show(range.most) : show(range.least)) + " to " + show(range.most) +
              unit + " (" + range.quantity + "), found " + show(value) + meant +
              "; if it is meant, say allow_unusual=True");
}

}  // namespace omma::python
