// Modes of the rhabdom and the sensitivity that follows from them: published numbers, and the
// overlap of the Airy pattern with the modes, summed over the focal plane.
#include <gtest/gtest.h>

#include <map>

#include "optics/lens_rhabdom.h"
#include "optics_acceptances.h"

namespace omma::test {
namespace {

std::map<std::string, WaveguideMode> modes_of(double v) {
  std::map<std::string, WaveguideMode> modes;
  for (const WaveguideMode& mode : waveguide_modes(v))
    modes[std::to_string(mode.l) + std::to_string(mode.m)] = mode;
  return modes;
}

TEST(OpticsWaveguide, PublishedModes) {
  const Acceptance thin = lens_rhabdom(RhabdomModel::waveguide, 25, 1.4, 1.27);
  EXPECT_NEAR(waveguide_parameter(thin), 2.193, 0.002);
  auto modes = modes_of(waveguide_parameter(thin));
  ASSERT_EQ(modes.size(), 1u);
  EXPECT_NEAR(modes["01"].u, 1.589, 0.002);
  EXPECT_NEAR(modes["01"].core_power, 0.788, 0.002);

  const Acceptance thick = lens_rhabdom(RhabdomModel::waveguide, 25, 1.9, 1.73);
  EXPECT_NEAR(waveguide_parameter(thick), 2.977, 0.002);
  modes = modes_of(waveguide_parameter(thick));
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_NEAR(modes["01"].u, 1.767, 0.002);
  EXPECT_NEAR(modes["01"].core_power, 0.895, 0.002);
  EXPECT_NEAR(modes["11"].u, 2.710, 0.002);
  EXPECT_NEAR(modes["11"].core_power, 0.647, 0.002);
}

TEST(OpticsWaveguide, ModesBeginAtTheirCutOff) {
  // The zeros of J_0 and J_1.
  const std::pair<const char*, double> cutoffs[] = {
      {"11", 2.40483}, {"21", 3.83171}, {"02", 3.83171}, {"31", 5.13562}, {"12", 5.52008}};
  for (const auto& [name, v] : cutoffs) {
    EXPECT_EQ(modes_of(v - 1e-3).count(name), 0u) << name;
    EXPECT_EQ(modes_of(v + 1e-3).count(name), 1u) << name;
  }
}

// u and w of every mode solve the mode equation; none is found twice; their number is that of
// zeros.
TEST(OpticsWaveguide, ModesSolveTheirEquation) {
  for (const double v : {1.0, 2.4, 2.41, 3.8318, 3.835, 5.0, 7.02, 10.175, 12.5, 39.9}) {
    const std::vector<WaveguideMode> modes = waveguide_modes(v);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const auto& [l, m, u, w, core_power, norm] = modes[i];
      EXPECT_NEAR(u * u + w * w, v * v, 1e-9);
      if (w < 1e-99) {  // one that reaches out further than is looked for
        EXPECT_LT(core_power, 1e-99);
        continue;
      }
      const double left = u * std::cyl_bessel_j(l + 1.0, u) * std::cyl_bessel_k(l + 0.0, w);
      const double right = w * std::cyl_bessel_k(l + 1.0, w) * std::cyl_bessel_j(l + 0.0, u);
      const double scale = w * std::cyl_bessel_k(l + 1.0, w);
      // One that has just begun has a field of hardly any slope to find it by.
      EXPECT_NEAR(left / scale, right / scale, 1e-7) << "LP " << l << m << " of V " << v;
      EXPECT_GT(core_power, 0);
      EXPECT_LT(core_power, 1);
      if (i > 0 && modes[i - 1].l == l) {
        EXPECT_GT(u, modes[i - 1].u + 1.9);
      }
    }
  }
  // About V^2/8 pairs of l and m, and more.
  EXPECT_NEAR(static_cast<double>(waveguide_modes(39.9).size()), 39.9 * 39.9 / 8 + 39.9 / pi, 10);
}

// --- The slow way. Lengths are over (lambda f)/(pi D), as in optics/lens_rhabdom.h.
double field(const WaveguideMode& mode, double r) {
  return r < 1 ? std::cyl_bessel_j(mode.l, mode.u * r) / std::cyl_bessel_j(mode.l, mode.u)
               : std::cyl_bessel_k(mode.l, mode.w * r) / std::cyl_bessel_k(mode.l, mode.w);
}

// Power of an Airy pattern around x that the mode takes in and keeps inside.
double power_taken(const WaveguideMode& mode, double radius, double x) {
  // Out to where the field is below 1e-5; the border of the core is between two rings.
  constexpr int rings_of_core = 80, spokes = 64;
  const int rings = static_cast<int>(rings_of_core * (1 + 12 / mode.w));
  double overlap = 0, whole = 0, inside = 0;
  for (int i = 0; i < rings; ++i) {
    const double r = (i + 0.5) / rings_of_core, value = field(mode, r);
    for (int j = 0; j < spokes; ++j) {
      const double phi = 2 * pi * (j + 0.5) / spokes, lobe = std::cos(mode.l * phi);
      const double y = std::hypot(radius * r * std::cos(phi) - x, radius * r * std::sin(phi));
      overlap += 2 * std::cyl_bessel_j(1, y) / y * value * lobe * r;
      whole += value * value * lobe * lobe * r;
      if (r < 1) inside += value * value * lobe * lobe * r;
    }
  }
  return overlap * overlap / whole * inside / whole;
}

TEST(OpticsWaveguide, SensitivityIsTheOverlapOfPatternAndModes) {
  for (const double rhabdom_um : {1.4, 1.9, 2.7})
    for (const double wide : {0.8, 2.0}) {
      const Acceptance a = lens_rhabdom(RhabdomModel::waveguide, 250, rhabdom_um, wide);
      const double radius = 0.5 * pi * wide;
      const auto power = [&](double x) {
        double sum = 0;
        for (const WaveguideMode& mode : waveguide_modes(waveguide_parameter(a)))
          sum += power_taken(mode, radius, x);
        return sum;
      };
      const auto sensitivity = [&](double x) { return eval_one(a, std::asin(x * 0.002 / pi)); };
      for (const double x : {1.0, 2.5, 4.0})
        // The sum is a midpoint rule in steps of 1/80.
        EXPECT_NEAR(sensitivity(x) / sensitivity(0), power(x) / power(0), 2e-4)
            << rhabdom_um << " um, " << wide << " lambda/D, x " << x;
    }
}

// Against the pattern's whole power, 4 pi / radius^2 in the same units, ring by ring and spoke by
// spoke; the sum is a midpoint rule in steps of 1/80.
TEST(OpticsWaveguide, CouplingEfficiencyIsThePowerInside) {
  for (const double rhabdom_um : {1.4, 1.9, 2.7})
    for (const double wide : {0.8, 2.0}) {
      const Acceptance a = lens_rhabdom(RhabdomModel::waveguide, 250, rhabdom_um, wide);
      const double radius = 0.5 * pi * wide, cell = 1.0 / 80 * 2 * pi / 64;
      double sum = 0;
      for (const WaveguideMode& mode : waveguide_modes(waveguide_parameter(a)))
        sum += power_taken(mode, radius, 1e-9);
      EXPECT_NEAR(coupling_efficiency(a), sum * cell * radius * radius / (4 * pi), 2e-4)
          << rhabdom_um << " um, " << wide << " lambda/D";
    }
  EXPECT_EQ(coupling_efficiency(lens_rhabdom(RhabdomModel::snyder, 25, 1.4, 1)), 1);
}

// What docs/eyes.md says of S on the axis, over its largest.
TEST(OpticsWaveguide, LargestBesideTheAxis) {
  const auto on_axis = [](double v, double ratio) {
    Acceptance a = lens_rhabdom(RhabdomModel::waveguide, 250, 1, ratio);
    const double stretch = v / waveguide_parameter(a);
    a.rhabdom_diameter_m *= stretch;
    a.focal_length_m *= stretch;
    return eval_one(a, 0);
  };
  EXPECT_NEAR(on_axis(3.83, 2), 0.996, 0.0005);
  EXPECT_NEAR(on_axis(3.83, 3), 0.795, 0.001);
  EXPECT_NEAR(on_axis(3.832, 3), 0.751, 0.001);
}

// The limits: far from the lens's the mode's own far field; a wide rhabdom's is geometric, the
// steps of the modes aside.
TEST(OpticsWaveguide, Limits) {
  const double lambda_over_d = 500e-9 / 25e-6;
  // A narrow rhabdom behind a lens that hardly resolves it: diffraction alone.
  EXPECT_NEAR(
      acceptance_width_rad(lens_rhabdom(RhabdomModel::waveguide, 25, 1.4, 0.05), 0) / lambda_over_d,
      1.029, 0.003);
  // A waveguide is wider than its core by what its field reaches out, 1/W > 1/V of the radius. Away
  // from the border it takes all light there is.
  const Acceptance many = lens_rhabdom(RhabdomModel::waveguide, 25, 25, 10);
  const Acceptance geometric = lens_rhabdom(RhabdomModel::geometric, 25, 25, 10);
  EXPECT_NEAR(acceptance_width_rad(many, 0) / acceptance_width_rad(geometric, 0),
              1 + 1 / waveguide_parameter(many), 0.02);
  for (const double theta : {0.0, 0.03, 0.06, 0.15, 0.2})
    EXPECT_NEAR(eval_one(many, theta), eval_one(geometric, theta), 0.02) << theta;
  // One mode: near a Gaussian of the same width.
  const Acceptance one = lens_rhabdom(RhabdomModel::waveguide, 25, 1.4, 4);
  const double width = acceptance_width_rad(one, 0);
  for (const double part : {0.2, 0.4, 0.6, 0.8})
    EXPECT_NEAR(eval_one(one, part * width), std::exp(-4 * std::log(2.0) * part * part), 0.05);
}

}  // namespace
}  // namespace omma::test
