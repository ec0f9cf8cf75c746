#include "optics_acceptances.h"

#include "omma/vec.h"

namespace omma::test {

std::vector<NamedAcceptance> acceptances_of_every_kind() {
  const auto blob = [](double right, double up, double at_right, double at_up, double sigma) {
    return std::exp(-0.5 * (std::pow(right - at_right, 2) + std::pow(up - at_up, 2)) /
                    (sigma * sigma));
  };
  return {
      {"gaussian 0.3", round_acceptance(Kernel::gaussian, 0.3 * degree)},
      {"gaussian 120", round_acceptance(Kernel::gaussian, 120 * degree)},
      {"pillbox 10", round_acceptance(Kernel::pillbox, 10 * degree)},
      {"compoundray 10", round_acceptance(Kernel::compoundray, 10 * degree)},
      {"ellipse 5 x 2", elliptical(5 * degree, 2 * degree, 0.4)},
      {"ellipse 30 x 3", elliptical(30 * degree, 3 * degree, -1.2)},
      {"ellipse 240 x 100", elliptical(240 * degree, 100 * degree, 2.0)},
      {"ellipse 50 : 1", elliptical(50 * degree, 1 * degree, 0.1)},
      {"airy 25 um", airy(25, 500)},
      {"airy 200 um", airy(200, 400)},
      {"airy 1 um", airy(1, 700)},
      {"one mode", lens_rhabdom(RhabdomModel::waveguide, 25, 1.4, 1.27)},
      {"two modes", lens_rhabdom(RhabdomModel::waveguide, 25, 1.9, 1.73)},
      {"many modes", lens_rhabdom(RhabdomModel::waveguide, 36, 8, 8)},
      {"geometric", lens_rhabdom(RhabdomModel::geometric, 25, 2, 1.5)},
      {"geometric, wide", lens_rhabdom(RhabdomModel::geometric, 36, 20, 20)},
      {"snyder", lens_rhabdom(RhabdomModel::snyder, 25, 2, 1.5)},
      {"profile", measured({0, 0.01, 0.02, 0.04, 0.1}, {1, 0.9, 0.5, 0.1, 0})},
      {"profile, ring", measured({0, 0.1, 0.2, 0.3, 0.5, 0.6}, {0, 0, 1, 0, 0, 0.2})},
      {"profile, all round", measured({0, 3}, {1, 0.5})},
      {"map", measured_2d(0.3, 0.2, 31, 21,
                          [&](double x, double y) { return blob(x, y, 0.05, -0.03, 0.06); })},
      {"map, coarse",
       measured_2d(0.5, 0.5, 3, 4, [](double x, double y) { return 1 + x + 0.5 * y + x * y; })},
      {"map, two apart", measured_2d(0.5, 0.5, 41, 41,
                                     [&](double x, double y) {
                                       return std::fmax(0, 0.9 - std::hypot(x - 0.3, y) / 0.1) +
                                              std::fmax(0, 0.6 - std::hypot(x, y - 0.35) / 0.1);
                                     })},
  };
}

double eval_one(const Acceptance& acceptance, double theta_rad, double azimuth_rad) {
  double value = 0;
  eval_acceptance(acceptance, {&theta_rad, 1}, {&azimuth_rad, 1}, {&value, 1});
  return value;
}

double pdf_one(const Acceptance& acceptance, double theta_rad, double azimuth_rad) {
  double value = 0;
  acceptance_pdf(acceptance, {&theta_rad, 1}, {&azimuth_rad, 1}, {&value, 1});
  return value;
}

double mtf_one(const Acceptance& acceptance, double cycles_per_rad, double azimuth_rad) {
  double value = 0;
  acceptance_mtf(acceptance, {&cycles_per_rad, 1}, {&azimuth_rad, 1}, {&value, 1});
  return value;
}

}  // namespace omma::test
