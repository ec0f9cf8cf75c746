// Means over bands, watts as photons, candelas as radiance.
#include <gtest/gtest.h>

#include "light/bands.h"
#include "model/spectrum_check.h"

namespace omma {
namespace {

// Neighbouring bands of so many samples each, all of one weight.
Bands even_bands(int count, int samples, double from_nm = 300, double to_nm = 700) {
  Bands bands;
  const int all = count * samples;
  for (int i = 0; i < all; ++i)
    bands.wavelength_nm.push_back(from_nm + (to_nm - from_nm) * (i + 0.5) / all);
  bands.weight.assign(static_cast<std::size_t>(count * all), 0.0);
  for (int b = 0; b < count; ++b)
    for (int i = 0; i < samples; ++i)
      bands.weight[static_cast<std::size_t>(b * all + b * samples + i)] = 1.0 / samples;
  return bands;
}

TEST(Bands, MeanOfALineIsItsValueInTheMiddle) {
  const Bands bands = even_bands(16, 5);
  const Spectrum line{{200, 800}, {2, 8}};
  const std::vector<double> mean = band_mean(bands, line);
  ASSERT_EQ(mean.size(), 16u);
  for (std::size_t b = 0; b < 16; ++b)
    EXPECT_NEAR(mean[b], (312.5 + 25 * static_cast<double>(b)) / 100, 1e-12);
}

TEST(Bands, SpectraAreNothingBeyondTheirEnds) {
  const Spectrum table{{400, 500}, {1, 3}};
  EXPECT_EQ(eval_spectrum(table, 399.9), 0);
  EXPECT_EQ(eval_spectrum(table, 400), 1);
  EXPECT_EQ(eval_spectrum(table, 425), 1.5);
  EXPECT_EQ(eval_spectrum(table, 500), 3);
  EXPECT_EQ(eval_spectrum(table, 500.1), 0);
  EXPECT_EQ(eval_spectrum({}, 450), 0);
}

// Each sample stands for what is about it: a step within one, and one within a band, are where they
// are. By samples alone the first would be off by 2 %.
TEST(Bands, MeansOfStepsAreExact) {
  Bands bands = even_bands(16, 25);
  bands.cell_nm.assign(16 * 25, 1.0);
  for (const double step_nm : {512.3, 519.95, 525.0}) {
    const Spectrum step{{300, step_nm, step_nm + 1e-6, 700}, {0, 0, 1, 1}};
    const std::vector<double> mean = band_mean(bands, step);
    EXPECT_NEAR(mean[8], (525 - step_nm) / 25, 1e-6) << step_nm;
    EXPECT_EQ(mean[7], 0);
    EXPECT_NEAR(mean[9], 1, 1e-7);  // the step at 525 nm has a width
  }
  const Spectrum tent{{510.2, 510.4, 510.6}, {0, 1, 0}};  // between two samples
  EXPECT_NEAR(band_mean(bands, tent)[8], 0.2 / 25, 1e-12);
  EXPECT_EQ(band_mean(even_bands(16, 20), tent)[8], 0);  // by wavelengths alone, beside it
  EXPECT_NEAR(mean_spectrum({{400, 500}, {1, 3}}, 400, 20, Beyond::nothing), 0.55, 1e-12);
  EXPECT_NEAR(mean_spectrum({{400, 500}, {1, 3}}, 400, 20, Beyond::nearest_knot), 1.05, 1e-12);
  EXPECT_NEAR(mean_spectrum({{400, 500}, {1, 3}}, 300, 20, Beyond::nearest_knot), 1, 1e-12);
  EXPECT_NEAR(mean_spectrum({{400, 500}, {1, 3}}, 300, 20, Beyond::nothing), 0, 1e-12);
}

TEST(Bands, AWattIsSoManyPhotons) {
  // 1 / (h c), CODATA 2018: 6.62607015e-34 J s, 299792458 m/s.
  const double per_joule_nm = 1e-9 / (6.62607015e-34 * 299792458);
  EXPECT_NEAR(unit_per_watt(LightUnit::photons, 550) / (550 * per_joule_nm), 1, 1e-12);
  EXPECT_NEAR(unit_per_watt(LightUnit::photons, 1) / 5.0341e15, 1, 1e-5);
  EXPECT_EQ(unit_per_watt(LightUnit::watts, 550), 1);
  const Bands one{{550}, {1}};
  EXPECT_DOUBLE_EQ(band_mean_of_watts(one, LightUnit::photons, {{500, 600}, {2, 2}})[0],
                   2 * 550 * photons_per_joule_nm);
}

TEST(Bands, EfficiencyOfTheEye) {
  EXPECT_EQ(luminous_efficiency(560), 0.995);
  EXPECT_EQ(luminous_efficiency(370), 0);
  EXPECT_EQ(luminous_efficiency(780), 0.000015);
  double sum = 0;
  for (int nm = 380; nm <= 780; ++nm) sum += luminous_efficiency(nm);
  EXPECT_NEAR(sum, 106.857, 0.001);  // as published
}

// White of one candela, seen through V and 683 lm/W, is one lumen again, and equal photons.
TEST(Bands, WhiteOfOneCandelaIsOneLumen) {
  const Bands bands = even_bands(300, 1, 400, 700);  // 1 nm
  const auto watts = primaries_per_lumen(bands, LightUnit::watts);
  const auto photons = primaries_per_lumen(bands, LightUnit::photons);
  double lumens = 0;
  for (std::size_t b = 0; b < watts.size(); ++b) {
    const double nm = bands.wavelength_nm[b];
    const double white = watts[b][0] + watts[b][1] + watts[b][2];
    const double counted = photons[b][0] + photons[b][1] + photons[b][2];
    lumens += 683 * luminous_efficiency(nm) * white;
    EXPECT_NEAR(counted / (photons[0][0] + photons[0][1] + photons[0][2]), 1, 1e-6);
    EXPECT_NEAR(counted / (white * unit_per_watt(LightUnit::photons, nm)), 1, 1e-12);
  }
  EXPECT_NEAR(lumens, 1, 1e-4);  // midpoints here, the trapezoidal rule there
  const auto ultraviolet = primaries_per_lumen({{350}, {1}}, LightUnit::photons);
  EXPECT_EQ(ultraviolet[0][2], 0);  // what RGB does not know
}

}  // namespace
}  // namespace omma
