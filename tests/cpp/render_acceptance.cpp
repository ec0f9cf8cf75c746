// The acceptance function as an experimenter measures it: a point source swept across an
// ommatidium, and sine gratings of several frequencies, held against the closed forms.
#include <gtest/gtest.h>

#include "test_scenes.h"

namespace omma::test {
namespace {

// Where a straight line through (x, y) passes the level.
double crossing(const std::vector<double>& x, const std::vector<double>& y, double level) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return sx / n + (level - sy / n) / slope;
}

// Full width at half maximum from a sweep in the plane of the axis and `sideways`. Instead of
// moving the source past one ommatidium, many ommatidia look past one source.
double measured_width_rad(Kernel kernel, double acceptance_rad, double sweep_phi_rad) {
  const Vec3d towards = normalize(Vec3d{0.3, 0.5, -0.8});
  const auto [u, v] = tangents(towards);
  Scene scene;
  Material glow;
  glow.base_color = {0, 0, 0, 1};
  glow.emissive = {1, 1, 1};
  glow.double_sided = true;
  // A square of half side 0.05 acceptance, 1 m away. Convolution with it widens a Gaussian by
  // 0.5 (0.05^2 / 3) 8 ln2 = 0.23 %.
  const double half = std::tan(0.05 * acceptance_rad);
  add_quad(scene, towards, u * half, v * half, add_material(scene, glow));

  constexpr int per_side = 64, centre = 64;
  std::vector<Vec3d> axes(centre, towards);
  std::vector<double> angle;
  for (const double side : {-1.0, 1.0})
    for (int i = 0; i < per_side; ++i) {
      // A short piece around half maximum, where a Gaussian is straight to 0.1 % in width.
      const double theta = side * acceptance_rad * (0.45 + 0.1 * i / (per_side - 1));
      angle.push_back(theta);
      axes.push_back(direction_about(towards, theta, sweep_phi_rad));
    }
  const Result result = render(scene, make_eye(axes, acceptance_rad), {Fixed{1 << 15}, 3, kernel});
  double peak = 0;
  for (std::size_t i = 0; i < centre; ++i) peak += result.at(i) / centre;
  double width = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    std::vector<double> x, y;
    for (std::size_t i = side * per_side; i < (side + 1) * per_side; ++i)
      x.push_back(angle[i]), y.push_back(result.at(centre + i));
    width += crossing(x, y, peak / 2) * (side == 0 ? -1 : 1);
  }
  return width;
}

// The source's size and the straight line leave 0.3 % together; the source covers 0.9 % of the
// acceptance, so 32,768 samples put about 290 on it at the peak and 145 at half, each some 4 %
// uncertain with a low-discrepancy set; over 64 ommatidia a side, that is 0.3 % in width.
TEST(Acceptance, SweptSourceRecoversTheWidth) {
  for (const double acceptance_deg : {0.3, 1.0, 2.6, 10.0, 30.0, 60.0})
    for (const double phi : {0.2, 0.2 + pi / 2}) {
      const double width =
          measured_width_rad(Kernel::gaussian, acceptance_deg * degree, phi) / degree;
      EXPECT_NEAR(width / acceptance_deg, 1, 0.01) << acceptance_deg << " degrees";
    }
}

TEST(Acceptance, SweptSourceRecoversThePillboxDiameter) {
  for (const double acceptance_deg : {1.0, 10.0, 60.0}) {
    const double width = measured_width_rad(Kernel::pillbox, acceptance_deg * degree, 0.2) / degree;
    EXPECT_NEAR(width / acceptance_deg, 1, 0.01) << acceptance_deg << " degrees";
  }
}

// --- Gratings of `cycles` round the horizon (or, turned, from the horizon up and down), seen by
// ommatidia that look at the horizon with phases spread over one period.
double measured_modulation(Kernel kernel, double acceptance_rad, int cycles, bool vertical) {
  // A bilinear image of n pixels per period keeps sinc^2(1/n) of the modulation; 180 pixels and
  // more, as here, keep 0.9999.
  constexpr int pixels = 32768;
  const auto grating = [&](double azimuth_rad) {
    const auto value = static_cast<float>(0.5 + 0.5 * std::cos(cycles * azimuth_rad));
    return Vec4{value, value, value, 1};
  };
  const double step = 2 * pi / pixels;
  Scene scene;
  scene.background = image_background(
      vertical ? make_image(1, pixels / 2,
                            [&](int, int row) { return grating(pi / 2 - (row + 0.5) * step); })
               : make_image(pixels, 1,
                            [&](int column, int) { return grating((column + 0.5) * step - pi); }));
  constexpr int phases = 64;
  std::vector<Vec3d> axes;
  std::vector<double> phase;
  for (int i = 0; i < phases; ++i) {
    const double angle = 2 * pi / cycles * (static_cast<double>(i) / phases - 0.5);
    phase.push_back(cycles * angle);
    axes.push_back(vertical ? from_azimuth_elevation(1, angle) : from_azimuth_elevation(angle, 0));
  }
  const Result result = render(scene, make_eye(axes, acceptance_rad), {Fixed{8192}, 3, kernel});
  double modulation = 0;
  for (std::size_t i = 0; i < phases; ++i)
    modulation += 2.0 / phases * 2 * (result.at(i) - 0.5) * std::cos(phase[i]);
  return modulation;
}

double gaussian_law(double cycles_per_width) {
  return std::exp(-3.5597 * cycles_per_width * cycles_per_width);
}

double compoundray_law(double cycles_per_width) {
  const double x = 2 * pi * cycles_per_width / 2.35482;
  return std::exp(-x * x / 4) * std::cyl_bessel_i(0.0, x * x / 4);
}

// Fourier transform of an even disc, the Airy amplitude.
double pillbox_law(double cycles_per_width) {
  const double x = pi * cycles_per_width;
  return 2 * std::cyl_bessel_j(1.0, x) / x;
}

// The laws are those of a plane. On the sphere, off the horizon by the angle e, a period shrinks by
// cos e; at 2.6 degrees the mean of e^2/2 is 0.0003 (three times that for compoundray's tails),
// which moves the modulation by under 0.001. The sampling noise is 1e-4.
TEST(Acceptance, GratingsFollowEachKernelsLaw) {
  struct Law {
    Kernel kernel;
    double (*modulation)(double);
  };
  for (const Law& law :
       {Law{Kernel::gaussian, gaussian_law}, Law{Kernel::compoundray, compoundray_law},
        Law{Kernel::pillbox, pillbox_law}})
    for (const double acceptance_deg : {1.0, 2.6})
      for (const double cycles_per_width : {0.1, 0.25, 0.5, 0.75, 1.0})
        for (const bool vertical : {false, true}) {
          const int cycles =
              static_cast<int>(std::lround(360 / acceptance_deg * cycles_per_width / 2)) * 2;
          const double exact_cycles = cycles * acceptance_deg / 360;
          if (cycles > 182) continue;
          EXPECT_NEAR(measured_modulation(law.kernel, acceptance_deg * degree, cycles, vertical),
                      law.modulation(exact_cycles), 0.005)
              << name_of(law.kernel) << ' ' << acceptance_deg << " degrees, " << cycles
              << (vertical ? " cycles, vertical" : " cycles");
        }
}

// What the numbers of the design say: half of a Gaussian's light comes from within its half width
// (in the plane), 76 % of that of `compoundray`.
TEST(Acceptance, LightWithinTheWidth) {
  const double acceptance = 2.6 * degree;
  Scene scene;
  Mesh disc;
  disc.material = add_color(scene, {1, 1, 1});
  constexpr unsigned corners = 256;
  const double radius = std::tan(acceptance / 2);
  disc.positions.push_back({0, 0, -1});
  for (unsigned i = 0; i < corners; ++i) {
    const double phi = 2 * pi * i / corners;
    disc.positions.push_back(to_float({radius * std::cos(phi), radius * std::sin(phi), -1}));
    disc.triangles.push_back({0, i + 1, (i + 1) % corners + 1});
  }
  add_instance(scene, add_mesh(scene, disc));
  const Eye eye = make_eye(Vec3d{0, 0, -1}, acceptance, 64);
  const auto share = [&](Kernel kernel) {
    const Result result = render(scene, eye, {Fixed{4096}, 1, kernel});
    double sum = 0;
    for (std::size_t i = 0; i < 64; ++i) sum += result.at(i) / 64;
    return sum;
  };
  // A polygon of 256 corners lacks 0.01 % of its circle; noise 1e-4.
  EXPECT_NEAR(share(Kernel::gaussian), 0.5, 0.001);
  EXPECT_NEAR(share(Kernel::compoundray), std::erf(2.35482 / 2 / std::sqrt(2.0)), 0.001);
  EXPECT_NEAR(share(Kernel::pillbox), 1, 0.001);
}

}  // namespace
}  // namespace omma::test
