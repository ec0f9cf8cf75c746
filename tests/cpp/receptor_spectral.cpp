// Spectral sensitivities and the matrix from RGB, against closed forms and integrals done by hand.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "omma/error.h"
#include "omma/receptor.h"

namespace omma {
namespace {

double sensitivity_at(const ReceptorType& type, double wavelength_nm) {
  double value = 0;
  eval_spectral_sensitivity(type, {&wavelength_nm, 1}, {&value, 1});
  return value;
}

ReceptorType pigment(double peak_nm) {
  ReceptorType type;
  type.name = "pigment";
  type.peak_wavelength_nm = peak_nm;
  return type;
}

ReceptorType table(std::vector<double> wavelength_nm, std::vector<double> sensitivity) {
  ReceptorType type;
  type.name = "table";
  type.wavelength_nm = std::move(wavelength_nm);
  type.sensitivity = std::move(sensitivity);
  return type;
}

// Peaks and widths of the alpha band of honeybee pigments, computed once from the template with
// another program: 0.998, 1.0006, 1.0008 and 63, 86.5, 108.5 nm.
TEST(Pigment, AlphaBandHasItsPeakAndWidth) {
  struct Case {
    double peak_nm, peak, width_nm;
  };
  for (const Case& c : {Case{344, 0.998, 63}, Case{436, 1.0006, 86.5}, Case{544, 1.0008, 108.5}}) {
    double largest = 0, below = 0, above = 0;
    const auto each = [&](const auto& look) {
      for (int i = 0; i < 50000; ++i) {
        const double nm = 250 + i * 0.01;
        look(nm, pigment_alpha_band(c.peak_nm, nm));
      }
    };
    each([&](double, double value) { largest = std::max(largest, value); });
    each([&](double nm, double value) {
      if (value < largest / 2) return;
      if (below == 0) below = nm;
      above = nm;
    });
    EXPECT_NEAR(largest, c.peak, 3e-4) << c.peak_nm;  // as it is printed
    // Within 0.2 % of 1, in tenths of a percent: the formula's own peak at 344 nm is 0.99783.
    EXPECT_LE(std::round(1000 * std::fabs(largest - 1)), 2) << c.peak_nm;
    EXPECT_NEAR(pigment_alpha_band(c.peak_nm, c.peak_nm), largest, 1e-3);
    EXPECT_NEAR(above - below, c.width_nm, 1) << c.peak_nm;  // known to 1 nm
  }
}

// At x = 1 the exponents of the alpha band are plain numbers: for a peak at 300 nm a is 0.9254, so
// 1 / (e^-5.19962 + e^-2.184 + e^-1.5496 + 0.674); far off 300 nm a is 0.8795.
TEST(Pigment, AlphaBandFollowsTheFormula) {
  EXPECT_NEAR(pigment_alpha_band(300, 300),
              1 / (std::exp(-5.19962) + std::exp(-2.184) + std::exp(-1.5496) + 0.674), 1e-12);
  // (800 - 300)^2 / 11940 = 20.938: a = 0.8795 + 0.0459 * 8.07e-10.
  EXPECT_NEAR(pigment_alpha_band(800, 800),
              1 / (std::exp(69.7 * -0.1205) + std::exp(-2.184) + std::exp(-1.5496) + 0.674), 1e-8);
  // (400 - 300)^2 / 11940 = 0.83752: a = 0.8795 + 0.0459 * 0.43278 = 0.899365.
  EXPECT_NEAR(pigment_alpha_band(400, 400),
              1 / (std::exp(69.7 * -0.100635) + std::exp(-2.184) + std::exp(-1.5496) + 0.674),
              1e-7);  // a is rounded at 5e-7, times 69.7 * 9e-4
  // At half the peak's wavelength x is 2: the first two exponentials are gone.
  EXPECT_NEAR(pigment_alpha_band(600, 300),
              1 / (std::exp(69.7 * (0.8795 + 0.0459 * std::exp(-90000.0 / 11940) - 2)) +
                   std::exp(28 * (0.922 - 2)) + std::exp(-14.9 * (1.104 - 2)) + 0.674),
              1e-15);
}

TEST(Pigment, BetaBandIsAGaussian) {
  // Peak at 189 + 0.315 * 500 = 346.5 nm, 1/e half width 0.195 * 500 - 40.5 = 57 nm.
  EXPECT_DOUBLE_EQ(pigment_beta_band(500, 346.5), 0.26);
  EXPECT_NEAR(pigment_beta_band(500, 346.5 + 57), 0.26 / std::exp(1), 1e-12);
  EXPECT_NEAR(pigment_beta_band(500, 346.5 - 57), 0.26 / std::exp(1), 1e-12);
}

TEST(Pigment, SensitivityIsBothBands) {
  for (const double nm : {310.0, 400.0, 500.0, 640.0})
    EXPECT_DOUBLE_EQ(sensitivity_at(pigment(500), nm),
                     pigment_alpha_band(500, nm) + pigment_beta_band(500, nm));
}

TEST(Pigment, ScreensItself) {
  ReceptorType type = pigment(540);
  type.absorption_per_m = 6700;
  EXPECT_DOUBLE_EQ(sensitivity_at(type, 600), sensitivity_at(pigment(540), 600))
      << "no length, no self-screening";
  type.length_m = 300e-6;  // k l = 2.01
  const double depth = 2.01;
  // Half of the most is absorbed where 1 - exp(-k l a) is half of 1 - exp(-k l).
  const double a_half = -std::log(1 - 0.5 * (1 - std::exp(-depth))) / depth;
  double nm = 540;
  while (sensitivity_at(pigment(540), nm) > a_half) nm += 0.001;
  EXPECT_NEAR(sensitivity_at(type, nm), 0.5, 1e-4);  // steps of 0.001 nm at 2 % a nanometre
  EXPECT_GT(sensitivity_at(type, 600), 1.1 * sensitivity_at(pigment(540), 600)) << "broader";
  type.length_m = 1e-9;  // thin: as the pigment
  EXPECT_NEAR(sensitivity_at(type, 600), sensitivity_at(pigment(540), 600), 1e-5);
}

TEST(Table, IsLinearBetweenItsKnotsAndZeroOutside) {
  const ReceptorType type = table({400, 500, 520}, {0.5, 1, 0.25});
  EXPECT_DOUBLE_EQ(sensitivity_at(type, 400), 0.5);
  EXPECT_DOUBLE_EQ(sensitivity_at(type, 450), 0.75);
  EXPECT_DOUBLE_EQ(sensitivity_at(type, 500), 1);
  EXPECT_DOUBLE_EQ(sensitivity_at(type, 516), 0.4);
  EXPECT_DOUBLE_EQ(sensitivity_at(type, 520), 0.25);
  EXPECT_EQ(sensitivity_at(type, 399.9), 0);
  EXPECT_EQ(sensitivity_at(type, 520.1), 0);
  ReceptorType thick = type;  // a table is the sensitivity itself
  thick.absorption_per_m = 6700;
  thick.length_m = 1e-3;
  EXPECT_DOUBLE_EQ(sensitivity_at(thick, 450), 0.75);
}

TEST(Primaries, ShareWhiteBetweenThem) {
  for (int nm = 400; nm <= 700; ++nm) {
    const auto s = primary_spectra(nm);
    EXPECT_NEAR(s[0] + s[1] + s[2], 1, 1e-6) << nm;
    for (const double share : s) EXPECT_TRUE(share >= 0 && share <= 1) << nm;
  }
  for (const double nm : {399.9, 700.1})
    EXPECT_EQ(primary_spectra(nm), (std::array<double, 3>{0, 0, 0})) << nm;
  EXPECT_GT(primary_spectra(650)[0], 0.9);
  EXPECT_GT(primary_spectra(540)[1], 0.9);
  EXPECT_GT(primary_spectra(440)[2], 0.9);
}

TEST(Matrix, OfAFlatReceptorIsTheMeanOfThePrimaries) {
  const ReceptorType flat = table({300, 700}, {1, 1});
  const auto plain = receptor_weights(flat);
  // 300 of its 400 nm are visible.
  EXPECT_NEAR(plain[0] + plain[1] + plain[2], 0.75, 1e-6);
  for (std::size_t c = 0; c < 3; ++c) {
    // Piecewise linear with knots at 10 nm: the trapezoidal rule is exact.
    double sum = 0;
    for (int k = 0; k <= 30; ++k)
      sum += (k == 0 || k == 30 ? 0.5 : 1) * primary_spectra(400 + 10 * k)[c] * 10;
    EXPECT_NEAR(plain[c], sum / 400, 1e-9) << c;
  }
  // A quarter of it is ultraviolet.
  const auto with = receptor_weights(flat, {0.2, 0, 2});
  EXPECT_NEAR(with[0], plain[0] + 0.05, 1e-9);
  EXPECT_NEAR(with[1], plain[1], 1e-12);
  EXPECT_NEAR(with[2], plain[2] + 0.5, 1e-9);
}

TEST(Matrix, OfANarrowReceptorIsThePrimariesThere) {
  const auto weights = receptor_weights(table({594, 595, 596}, {0, 1, 0}));
  const auto there = primary_spectra(595);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(weights[c], there[c], 1e-9) << c;
}

TEST(Matrix, WhatSeesUltravioletAloneGetsNothingUnlessTold) {
  const ReceptorType type = table({330, 360, 390}, {0, 1, 0});
  EXPECT_EQ(receptor_weights(type), (std::array<double, 3>{0, 0, 0}));
  const auto told = receptor_weights(type, {0.25, 0, 0.5});
  EXPECT_DOUBLE_EQ(told[0], 0.25);
  EXPECT_DOUBLE_EQ(told[2], 0.5);
}

TEST(Matrix, WhiteIsOneOnceUltravioletIsWhiteToo) {
  for (const double peak : {344.0, 436.0, 544.0, 640.0}) {
    const auto w = receptor_weights(pigment(peak), {1.0 / 3, 1.0 / 3, 1.0 / 3});
    EXPECT_NEAR(w[0] + w[1] + w[2], 1, 1e-12) << peak;
  }
  const auto uv = receptor_weights(pigment(344));
  EXPECT_LT(uv[0] + uv[1] + uv[2], 0.01);
}

TEST(Matrix, AskedForASensitivityItNames) {
  ReceptorType nothing;
  nothing.name = "R9";
  const auto message = [](const ReceptorType& type) -> std::string {
    try {
      receptor_weights(type);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(nothing),
            "receptor type 'R9': expected a peak wavelength or a table of sensitivities, found "
            "neither");
  EXPECT_EQ(message(table({710, 750}, {1, 1})),
            "receptor type 'table': expected a sensitivity between 300 and 700 nm, found none");
}

}  // namespace
}  // namespace omma
