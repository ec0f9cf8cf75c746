// The plausible ranges of optics, one table, and what was meant by a number outside of its range.
#include "plausible.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>

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
    // Of superposition eyes up to some millimetres.
    {"aperture diameter", 1e-6, 2e-2, "m"},
};

// Numbers in another unit, by what they must be multiplied with.
struct Unit {
  const char* unit;
  const char* other;
  double factor;
};
constexpr Unit units[] = {
    {"rad", "degrees", pi / 180},
    {"m", "mm", 1e-3},
    {"m", "\u00b5m", 1e-6},
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

const Range& range_of(Quantity quantity) {
  return ranges[static_cast<std::size_t>(quantity)];
}

// "; 2.6 degrees would be 0.04538 rad", "" where no other unit would do.
std::string meant_by(const Range& range, double value) {
  const double size = std::abs(value);
  for (const Unit& u : units)
    if (std::string(u.unit) == range.unit && size * u.factor >= range.least &&
        size * u.factor <= range.most)
      return "; " + show(value) + " " + u.other + " would be " + show(value * u.factor) + " " +
             range.unit;
  return "";
}

// A sentence on the values that lie outside of the range, the first of which is shown.
void look_at(Quantity quantity, const std::string& name, const std::vector<float>& values,
             const char* of_what, std::vector<std::string>& told) {
  const Range& range = range_of(quantity);
  std::size_t outside = 0;
  double first = 0;
  for (const float value : values) {
    // Limits are within, as floats have them.
    if (!(value > 0) ||
        (value >= static_cast<float>(range.least) && value <= static_cast<float>(range.most)))
      continue;
    if (outside++ == 0) first = value;
  }
  if (outside == 0) return;
  told.push_back(name + " of " + std::to_string(outside) + " of " + std::to_string(values.size()) +
                 " " + of_what + ": " + show(first) + " " + range.unit + " is no animal's (" +
                 range.quantity + ", " + show(range.least) + " to " + show(range.most) + " " +
                 range.unit + ")" + meant_by(range, first));
}

// Half the longest side of the box of each eye's positions.
std::vector<float> radii_of(const Eye& eye) {
  struct Box {
    Vec3 low, high;
  };
  std::map<std::int32_t, Box> boxes;
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3 p = eye.position_m[i];
    const auto [found, is_new] = boxes.try_emplace(eye.eye_id[i], Box{p, p});
    Box& b = found->second;
    b.low = {std::min(b.low.x, p.x), std::min(b.low.y, p.y), std::min(b.low.z, p.z)};
    b.high = {std::max(b.high.x, p.x), std::max(b.high.y, p.y), std::max(b.high.z, p.z)};
  }
  std::vector<float> radii;
  for (const auto& [id, b] : boxes)
    radii.push_back(
        0.5f * std::max({b.high.x - b.low.x, b.high.y - b.low.y, b.high.z - b.low.z}));
  return radii;
}

}  // namespace

std::vector<std::string> unusual_of(const Eye& eye) {
  std::vector<std::string> told;
  look_at(Quantity::acceptance_angle, "acceptance_angle_rad", eye.acceptance_angle_rad, "ommatidia",
          told);
  look_at(Quantity::facet_diameter, "facet_diameter_m", eye.facet_diameter_m, "ommatidia", told);
  look_at(Quantity::aperture_diameter, "aperture_diameter_m", eye.aperture_diameter_m, "ommatidia",
          told);
  look_at(Quantity::focal_length, "focal_offset_m", eye.focal_offset_m, "ommatidia", told);
  look_at(Quantity::eye_radius, "position_m", radii_of(eye), "eyes", told);
  return told;
}

void warn_of_unusual(const Eye& eye) {
  PyObject* const globals = PyEval_GetGlobals();  // of the line that calls; borrowed
  if (globals != nullptr) {
    PyObject* const name = PyDict_GetItemString(globals, "__name__");
    const char* const text = name == nullptr ? nullptr : PyUnicode_AsUTF8(name);
    if (text == nullptr) PyErr_Clear();
    if (text != nullptr && std::string_view(text).substr(0, 5) == "omma.") return;
  }
  for (const std::string& sentence : unusual_of(eye))
    if (PyErr_WarnEx(PyExc_UserWarning, ("Eye: " + sentence).c_str(), 1) < 0)
      throw nb::python_error();
}

void expect_plausible(Quantity quantity, const char* name, double value, bool allow_unusual) {
  const Range& range = range_of(quantity);
  const double size = std::abs(value);
  const bool angle = range.least == 0;  // either way round
  if (allow_unusual || !std::isfinite(value) || value == 0 || (value < 0 && !angle)) return;
  if (size >= range.least && size <= range.most) return;
  const std::string unit = *range.unit ? " " + std::string(range.unit) : "";
  throw Error(std::string(name) + ": expected " +
              (angle ? "-" + show(range.most) : show(range.least)) + " to " + show(range.most) +
              unit + " (" + range.quantity + "), found " + show(value) +
              meant_by(range, value) +
              "; if it is meant, say allow_unusual=True");
}

}  // namespace omma::python
