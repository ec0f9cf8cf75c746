// Whether the parameters of an acceptance can be meant.
#include <cmath>
#include <cstdio>

#include "omma/acceptance.h"
#include "omma/error.h"
#include "optics/lens_rhabdom.h"

namespace omma {
namespace {

std::string show(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

// Ellipses beyond this are thinner than the steps of the distribution over azimuth.
constexpr double most_axis_ratio = 50;

// Below this a waveguide's only mode has under 0.17 of its power inside and is wide.
constexpr double least_waveguide_parameter = 1;

// An angle whose square would still count for something in a double; floats end at 1e-45.
constexpr double least_angle_rad = 1e-50;

// What is smaller or larger is a slip, in units mostly; and what is made of it would take for ever.
constexpr double least_length_m = 1e-9, most_length_m = 1;
constexpr double least_wavelength_nm = 1, most_wavelength_nm = 1e5;
constexpr double least_facet_waves = 0.1, most_facet_waves = 1e7;

struct Check {
  const std::string& where;

  [[noreturn]] void fail(const std::string& what) const { throw Error(where + ": " + what); }

  void between(const char* name, double x, double least, double most, const char* expected) const {
    if (!(x >= least && x <= most))
      fail(std::string(name) + " must be " + expected + ", is " + show(x));
  }

  void knots(const char* name, const std::vector<double>& x, double least) const {
    if (x.size() < 2)
      fail(std::string(name) + " must have at least 2 entries, has " + std::to_string(x.size()));
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::string place = std::string(name) + ", entry " + std::to_string(i);
      if (!(x[i] >= least && x[i] <= pi))
        fail(place + ": must be from " + (least == 0 ? "0" : "-pi") + " to pi rad, is " +
             show(x[i]));
      if (i > 0 && !(x[i] > x[i - 1]))
        fail(place + ": must be more than the entry before it (" + show(x[i - 1]) + "), is " +
             show(x[i]));
    }
  }
};

// A waveguide or a disc that is wider than there are tables for.
void check_size(const Check& check, const Acceptance& a) {
  const double b = rhabdom_radius_x(a);
  if (!(b <= most_rhabdom_radius_x))
    check.fail("rhabdom_diameter_m must not be seen under more than " +
               show(2 / pi * most_rhabdom_radius_x) + " lambda/D from the lens, is under " +
               show(2 / pi * b) + ": what it accepts is its disc, a pillbox");
  if (a.model != RhabdomModel::waveguide) return;
  if (!(a.rhabdom_index > a.surround_index))
    check.fail("rhabdom_index must be more than surround_index (" + show(a.surround_index) +
               ") for a waveguide, is " + show(a.rhabdom_index));
  const double v = waveguide_parameter(a);
  if (!(v <= most_waveguide_parameter))
    check.fail("rhabdom_diameter_m must give a waveguide a parameter V of at most " +
               show(most_waveguide_parameter) + ", gives " + show(v) +
               ": with so many modes it is geometric");
  if (!(v >= least_waveguide_parameter))
    check.fail("rhabdom_diameter_m must give a waveguide a parameter V of at least " +
               show(least_waveguide_parameter) + ", gives " + show(v) +
               ": hardly any light would stay inside");
}

void check_table(const Check& check, const SensitivityTable* table) {
  if (table == nullptr) check.fail("a table must be given");
  const bool radial = table->up_rad.empty();
  check.knots(radial ? "angle_rad" : "right_rad", table->right_rad, radial ? 0 : -pi);
  if (!radial) check.knots("up_rad", table->up_rad, -pi);
  const std::size_t count = table->right_rad.size() * (radial ? 1 : table->up_rad.size());
  if (table->sensitivity.size() != count)
    check.fail("sensitivity must have " + std::to_string(count) + " entries, has " +
               std::to_string(table->sensitivity.size()));
  double largest = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = table->sensitivity[i];
    if (!(s >= 0 && std::isfinite(s)))
      check.fail("sensitivity, entry " + std::to_string(i) + ": must be 0 or more, is " + show(s));
    if (s > largest) at = i;
    largest = std::fmax(largest, s);
  }
  if (largest == 0) check.fail("sensitivity must not be 0 everywhere");
  if (largest != 1) check.fail("sensitivity must have 1 for its largest, has " + show(largest));
  // The peak may be as narrow as the knots allow, but not vanish.
  const auto reach = [](const std::vector<double>& x, std::size_t i) {
    return std::fmax(i > 0 ? x[i] - x[i - 1] : x[i], i + 1 < x.size() ? x[i + 1] - x[i] : 0);
  };
  const std::size_t columns = table->right_rad.size();
  if (!(reach(table->right_rad, at % columns) >= least_angle_rad &&
        (radial || reach(table->up_rad, at / columns) >= least_angle_rad)))
    check.fail("sensitivity, entry " + std::to_string(at) + ": the peak must be at least " +
               show(least_angle_rad) + " rad wide");
}

}  // namespace

void validate_acceptance(const Acceptance& a, const std::string& where) {
  const Check check{where};
  const auto length = [&](const char* name, double x) {
    check.between(name, x, least_length_m, most_length_m, "a length from 1e-9 to 1 m");
  };
  switch (a.kernel) {
    case Kernel::gaussian:
    case Kernel::pillbox:
    case Kernel::compoundray:
      check.between("width_rad", a.width_rad, 0, 2 * pi, "from 0 to 2 pi rad");
      if (a.width_rad > 0 && a.width_rad < least_angle_rad)
        check.fail("width_rad must be 0 or at least " + show(least_angle_rad) + " rad, is " +
                   show(a.width_rad));
      if (a.kernel != Kernel::gaussian || a.minor_width_rad == 0) return;
      if (!(a.minor_width_rad > 0 && a.minor_width_rad <= a.width_rad))
        check.fail("minor_width_rad must be more than 0 and at most width_rad (" +
                   show(a.width_rad) + "), is " + show(a.minor_width_rad));
      if (a.width_rad > most_axis_ratio * a.minor_width_rad)
        check.fail("minor_width_rad must be at least a " + show(most_axis_ratio) +
                   "th of width_rad (" + show(a.width_rad) + "), is " + show(a.minor_width_rad));
      if (!std::isfinite(a.major_angle_rad))
        check.fail("major_angle_rad must be a number, is " + show(a.major_angle_rad));
      return;
    case Kernel::airy:
    case Kernel::lens_rhabdom:
      length("facet_diameter_m", a.facet_diameter_m);
      check.between("wavelength_nm", a.wavelength_nm, least_wavelength_nm, most_wavelength_nm,
                    "from 1 to 100,000 nm");
      if (const double waves = a.facet_diameter_m / (a.wavelength_nm * 1e-9);
          !(waves >= least_facet_waves && waves <= most_facet_waves))
        check.fail("facet_diameter_m must be from 0.1 to 10,000,000 wavelengths, is " +
                   show(waves));
      if (a.kernel == Kernel::airy) return;
      length("focal_length_m", a.focal_length_m);
      length("rhabdom_diameter_m", a.rhabdom_diameter_m);
      for (const double index : {a.rhabdom_index, a.surround_index})
        if (!(index >= 1 && index <= 4))
          check.fail(std::string(index == a.rhabdom_index ? "rhabdom" : "surround") +
                     "_index must be from 1 to 4, is " + show(index));
      if (a.model != RhabdomModel::snyder)
        check_size(check, a);
      else
        check.between("the width of Snyder's Gaussian", snyder_width_rad(a), 0, 2 * pi,
                      "at most 2 pi rad");
      return;
    case Kernel::table:
      check_table(check, a.table.get());
      return;
  }
}

}  // namespace omma
