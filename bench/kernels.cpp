// What other angular sensitivities cost: the bee in the meadow with Gaussians of one width, with
// one other sensitivity for all, with a mixture, with as many widths as ommatidia, with apertures.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "scenes.h"

namespace omma::bench {
namespace {

constexpr double width_rad = 2.6 * degree;

Acceptance of_kernel(Kernel kernel) {
  Acceptance acceptance;
  acceptance.kernel = kernel;
  acceptance.width_rad = width_rad;
  acceptance.wavelength_nm = 500;
  // A facet that is 2.6 degrees wide by diffraction alone, and a honeybee's lens and rhabdom.
  acceptance.facet_diameter_m = kernel == Kernel::airy ? 500e-9 / width_rad * 1.029 : 20e-6;
  acceptance.focal_length_m = 66e-6;
  acceptance.rhabdom_diameter_m = 1.9e-6;
  if (kernel == Kernel::table) {
    auto table = std::make_shared<SensitivityTable>();
    for (int k = 0; k <= 30; ++k) {
      const double theta = k * width_rad / 15;
      table->right_rad.push_back(theta);
      table->sensitivity.push_back(std::exp(-2.772588 * std::pow(theta / width_rad, 2)));
    }
    acceptance.table = table;
  }
  return acceptance;
}

Acceptance ellipse(double major_angle_rad) {
  Acceptance acceptance;
  acceptance.width_rad = width_rad * 1.5;
  acceptance.minor_width_rad = width_rad / 1.5;
  acceptance.major_angle_rad = major_angle_rad;
  return acceptance;
}

// A map that is half as wide as high.
Acceptance map() {
  auto table = std::make_shared<SensitivityTable>();
  for (int k = -20; k <= 20; ++k) {
    table->right_rad.push_back(k * width_rad / 20);
    table->up_rad.push_back(k * width_rad / 10);
  }
  for (const double up : table->up_rad)
    for (const double right : table->right_rad)
      table->sensitivity.push_back(
          std::exp(-2.772588 * (2 * right * right + up * up / 2) / (width_rad * width_rad)));
  Acceptance acceptance;
  acceptance.kernel = Kernel::table;
  acceptance.table = table;
  return acceptance;
}

// The bee's own ommatidia, the kinds in turn.
Eye eye_with(const Eye& bee, std::vector<Acceptance> kinds) {
  Eye eye = bee;
  eye.acceptance_of.clear();
  eye.acceptance_angle_rad.assign(bee.size(), 0.0f);
  for (std::size_t i = 0; i < bee.size(); ++i)
    eye.acceptance_of.push_back(static_cast<std::int32_t>(i % kinds.size()));
  eye.acceptances = std::move(kinds);
  return eye;
}

struct Kind {
  const char* name;
  Eye eye;
};

std::vector<Kind> all_kinds(const Eye& bee) {
  Eye gaussian = bee;
  gaussian.acceptance_angle_rad.assign(bee.size(), static_cast<float>(width_rad));
  Eye distinct = gaussian;
  for (std::size_t i = 0; i < bee.size(); ++i)
    distinct.acceptance_angle_rad[i] *=
        0.8f + 0.4f * static_cast<float>(i) / static_cast<float>(bee.size());
  Eye apertures = gaussian;
  apertures.aperture_diameter_m.assign(bee.size(), 200e-6f);
  const auto airy = of_kernel(Kernel::airy), lens = of_kernel(Kernel::lens_rhabdom);
  const auto table = of_kernel(Kernel::table), pillbox = of_kernel(Kernel::pillbox);
  return {{"gaussian", gaussian},
          {"mixed", eye_with(bee, {of_kernel(Kernel::gaussian), ellipse(0), ellipse(0.8), pillbox,
                                   of_kernel(Kernel::compoundray), airy, lens, table, map()})},
          {"elliptical", eye_with(bee, {ellipse(0.4)})},
          {"pillbox", eye_with(bee, {pillbox})},
          {"airy", eye_with(bee, {airy})},
          {"lens and rhabdom", eye_with(bee, {lens})},
          {"table", eye_with(bee, {table})},
          {"map", eye_with(bee, {map()})},
          {"a width each", distinct},
          {"apertures", apertures}};
}

}  // namespace

void kernels(bool quick) {
  Setup setup = have_data("natural-standin-sky") ? meadow() : checkerboard();
  const std::vector<Kind> kinds = all_kinds(setup.eye);
  const Renderer built(setup.scene, setup.eye);
  std::printf("scene,sensitivity,sampling,rays,frames_per_s,over_gaussian,tables_ms\n");
  struct Mode {
    Points points;
    int samples;
  };
  for (const Mode mode : {Mode{Points::low_discrepancy, 1}, Mode{Points::low_discrepancy, 16},
                          Mode{Points::low_discrepancy, 64}, Mode{Points::random, 16}}) {
    RenderSettings settings;
    settings.sampling = Fixed{mode.samples};
    settings.points = mode.points;
    std::vector<Renderer> renderers;
    for (const Kind& kind : kinds) renderers.emplace_back(built, kind.eye, settings);
    const auto poses = flight(setup, quick ? 1 : static_cast<std::size_t>(64 / mode.samples + 4));
    std::vector<float> out(poses.size() * setup.eye.size() * rgb_bands);
    std::vector<double> seconds(kinds.size(), 1e9);
    // In turns, so that a disturbance meets all.
    for (int round = 0; round < (quick ? 1 : 7); ++round)
      for (std::size_t k = 0; k < kinds.size(); ++k)
        seconds[k] =
            std::min(seconds[k], best_seconds(0, [&] { renderers[k].render(poses, out); }));
    for (std::size_t k = 0; k < kinds.size(); ++k)
      std::printf("%s,%s,%s,%d,%.1f,%.3f,%.1f\n", setup.name.c_str(), kinds[k].name,
                  mode.points == Points::random ? "random" : "low discrepancy", mode.samples,
                  static_cast<double>(poses.size()) / seconds[k], seconds[0] / seconds[k],
                  1e3 * renderers[k].build_times().directions_s);
    std::fflush(stdout);
  }
}

}  // namespace omma::bench
