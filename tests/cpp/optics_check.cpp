// What is refused as an acceptance, and how it is said.
#include <gtest/gtest.h>

#include <limits>

#include "omma/error.h"
#include "optics/footprint_width.h"
#include "optics_acceptances.h"

namespace omma::test {
namespace {

std::string message(const Acceptance& a) {
  try {
    validate_acceptance(a, "somewhere");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(OpticsCheck, GoodOnesPass) {
  for (const auto& [name, a] : acceptances_of_every_kind()) EXPECT_EQ(message(a), "") << name;
  EXPECT_EQ(message(round_acceptance(Kernel::gaussian, 0)), "");
  EXPECT_EQ(message(round_acceptance(Kernel::pillbox, 2 * pi)), "");
  EXPECT_EQ(message(lens_rhabdom(RhabdomModel::snyder, 25, 400, 300)), "");
}

TEST(OpticsCheck, MessagesNameTheParameterAndWhatWasFound) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(round_acceptance(Kernel::gaussian, -0.1)),
            "somewhere: width_rad must be from 0 to 2 pi rad, is -0.1");
  EXPECT_EQ(message(round_acceptance(Kernel::compoundray, 6.5)),
            "somewhere: width_rad must be from 0 to 2 pi rad, is 6.5");
  EXPECT_EQ(message(round_acceptance(Kernel::pillbox, nan)),
            "somewhere: width_rad must be from 0 to 2 pi rad, is nan");
  EXPECT_EQ(message(elliptical(0.1, 0.2, 0)),
            "somewhere: minor_width_rad must be more than 0 and at most width_rad (0.1), is 0.2");
  EXPECT_EQ(message(elliptical(1, 0.01, 0)),
            "somewhere: minor_width_rad must be at least a 50th of width_rad (1), is 0.01");
  EXPECT_EQ(message(elliptical(0.2, 0.1, nan)),
            "somewhere: major_angle_rad must be a number, is nan");
  EXPECT_EQ(message(airy(0, 500)),
            "somewhere: facet_diameter_m must be a length from 1e-9 to 1 m, is 0");
  EXPECT_EQ(message(airy(20, -1)), "somewhere: wavelength_nm must be from 1 to 100,000 nm, is -1");
}

// Finite numbers of which no table could be made: loops over them never ended, or what was made was
// not a number.
TEST(OpticsCheck, AbsurdNumbers) {
  EXPECT_EQ(message(airy(1e6, 1e-300)),
            "somewhere: wavelength_nm must be from 1 to 100,000 nm, is 1e-300");
  EXPECT_EQ(message(airy(1e6, 1)),
            "somewhere: facet_diameter_m must be from 0.1 to 10,000,000 wavelengths, is 1e+09");
  EXPECT_EQ(message(airy(0.001, 1e5)),
            "somewhere: facet_diameter_m must be from 0.1 to 10,000,000 wavelengths, is 1e-05");
  EXPECT_EQ(message(airy(1e-300, 500)),
            "somewhere: facet_diameter_m must be a length from 1e-9 to 1 m, is 1e-306");
  EXPECT_EQ(message(round_acceptance(Kernel::gaussian, 1e-300)),
            "somewhere: width_rad must be 0 or at least 1e-50 rad, is 1e-300");
  Acceptance wide = lens_rhabdom(RhabdomModel::snyder, 25, 2, 1.5);
  wide.focal_length_m = 1e-9;
  EXPECT_EQ(message(wide),
            "somewhere: the width of Snyder's Gaussian must be at most 2 pi rad, is 2000");
  EXPECT_EQ(
      message(measured({0, 1e-300, 1}, {1, 0, 0})).rfind("somewhere: sensitivity, entry 0", 0), 0u);
  EXPECT_EQ(message(measured({0, 1e-300}, {1, 1})).rfind("somewhere: sensitivity, entry 0", 0), 0u);
  EXPECT_NE(message(measured_2d(1e-60, 1, 3, 3, [](double, double) { return 1.0; })), "");
}

// What is passed is made, quickly, and finite: at the ends of what is allowed.
TEST(OpticsCheck, WhatPassesIsFinite) {
  const double width = 1e-48;
  const Acceptance ends[] = {
      airy(1e6, 100),
      airy(1e4, 1e5),
      airy(50, 1e5),
      airy(1e-3, 1),
      elliptical(width, width / 50, 1e300),
      round_acceptance(Kernel::gaussian, width),
      round_acceptance(Kernel::pillbox, width),
      round_acceptance(Kernel::compoundray, width),
      measured({0, 1e-9, 3}, {1, 0.3, 0}),
      measured({0, 1e-50}, {1, 1}),
      measured_2d(3, 3, 4, 4, [](double x, double y) { return x > 0 && y > 0 ? 1.0 : 0.0; }),
      lens_rhabdom(RhabdomModel::geometric, 1, 0.001, 1e-8),
      lens_rhabdom(RhabdomModel::snyder, 25, 2, 300),
  };
  for (const Acceptance& a : ends) {
    ASSERT_EQ(message(a), "");
    const double at = acceptance_width_rad(a, 0.3);
    EXPECT_TRUE(std::isfinite(at));
    EXPECT_TRUE(std::isfinite(pdf_one(a, 0.3 * at)));  // on the axis compoundray's is not
    for (const double cycles : {0.0, 1.0, 1e5, 1e12, 1e300})
      EXPECT_LE(std::fabs(mtf_one(a, cycles, 0.2)), 1 + 1e-9) << cycles;
    for (const Vec3& d : sample_acceptance(a, 50, 1))
      EXPECT_NEAR(dot(to_double(d), to_double(d)), 1, 1e-6);
    EXPECT_TRUE(std::isfinite(footprint_width_rad(make_sensitivity(a), 4)));
  }
}

TEST(OpticsCheck, LensAndRhabdom) {
  const auto changed = [](auto field, double value) {
    Acceptance a = lens_rhabdom(RhabdomModel::waveguide, 25, 2, 1.5);
    a.*field = value;
    return message(a);
  };
  EXPECT_EQ(changed(&Acceptance::focal_length_m, 0),
            "somewhere: focal_length_m must be a length from 1e-9 to 1 m, is 0");
  EXPECT_EQ(changed(&Acceptance::rhabdom_index, 1.33),
            "somewhere: rhabdom_index must be more than surround_index (1.34) for a waveguide, is "
            "1.33");
  EXPECT_EQ(changed(&Acceptance::surround_index, 0.9),
            "somewhere: surround_index must be from 1 to 4, is 0.9");
  EXPECT_NE(changed(&Acceptance::rhabdom_diameter_m, 2e-7).find("V of at least 1, gives 0.313"),
            std::string::npos);
  EXPECT_NE(message(lens_rhabdom(RhabdomModel::waveguide, 25, 30, 5)).find("V of at most 40"),
            std::string::npos);
  EXPECT_NE(message(lens_rhabdom(RhabdomModel::geometric, 25, 20, 40)).find("under 40: what"),
            std::string::npos);
}

TEST(OpticsCheck, Tables) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Acceptance none;
  none.kernel = Kernel::table;
  EXPECT_EQ(message(none), "somewhere: a table must be given");
  EXPECT_EQ(message(measured({0}, {1})),
            "somewhere: angle_rad must have at least 2 entries, has 1");
  EXPECT_EQ(message(measured({0, 0.1, 0.1}, {1, 1, 0})),
            "somewhere: angle_rad, entry 2: must be more than the entry before it (0.1), is 0.1");
  EXPECT_EQ(message(measured({-0.1, 0.1}, {1, 1})),
            "somewhere: angle_rad, entry 0: must be from 0 to pi rad, is -0.1");
  EXPECT_EQ(message(measured({0, 0.1}, {1, 1, 1})),
            "somewhere: sensitivity must have 2 entries, has 3");
  EXPECT_EQ(message(measured({0, 0.1}, {1, -0.5})),
            "somewhere: sensitivity, entry 1: must be 0 or more, is -0.5");
  EXPECT_EQ(message(measured({0, 0.1}, {1, nan})),
            "somewhere: sensitivity, entry 1: must be 0 or more, is nan");
  EXPECT_EQ(message(measured({0, 0.1}, {0, 0})), "somewhere: sensitivity must not be 0 everywhere");
  EXPECT_EQ(message(measured({0, 0.1}, {0.5, 0})),
            "somewhere: sensitivity must have 1 for its largest, has 0.5");
}

}  // namespace
}  // namespace omma::test
