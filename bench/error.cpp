// Error against rays and against time. The error is the root mean square, over all ommatidia and
// channels, of what a render differs from a reference of 65,536 rays that has no footprints. Random
// sampling is CompoundRay's; its error is the measure for all others (bench/report.py).
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sampling/sampling_choice.h"
#include "scenes.h"

namespace omma::bench {
namespace {

struct Case {
  Setup setup;
  int reference_rays;
  double rays_per_point;  // that a point of a curve is averaged over, and timed with, about
};

struct Point {
  double rays = 0;  // mean, per ommatidium
  double rms = 0, bias = 0;
  double seconds = 0;  // per frame, in a batch
};

std::vector<float> make_reference(const Renderer& built, const Case& of) {
  RenderSettings settings;
  settings.sampling = Fixed{of.reference_rays};
  settings.footprints = false;
  settings.seed = 1;  // not the points that are measured
  std::vector<float> reference(of.setup.poses.size() * of.setup.eye.size() * rgb_bands);
  Renderer(built, of.setup.eye, settings).render(of.setup.poses, reference);
  return reference;
}

// The root mean square of what stays when noise is averaged away: over `repeats` renders the mean
// differs from the reference by the bias and by noise, whose share the scatter tells.
double measure_bias(const std::vector<float>& out, const std::vector<float>& reference,
                    std::size_t repeats) {
  double sum = 0;
  const std::size_t n = reference.size();
  const auto count = static_cast<double>(repeats);
  for (std::size_t i = 0; i < n; ++i) {
    double mean = 0, square = 0;
    for (std::size_t r = 0; r < repeats; ++r) {
      const double d = static_cast<double>(out[r * n + i]) - reference[i];
      mean += d / count;
      square += d * d / count;
    }
    sum += mean * mean - (square - mean * mean) / (count - 1);
  }
  return std::sqrt(std::max(0.0, sum / static_cast<double>(n)));
}

Point measure(const Renderer& built, const Case& of, const std::vector<float>& reference,
              RenderSettings settings, double least_s) {
  const std::vector<Mat4>& views = of.setup.poses;
  const std::size_t ommatidia = of.setup.eye.size();
  const bool to_error = std::holds_alternative<ToError>(settings.sampling);
  const double frame_rays = static_cast<double>(views.size() * ommatidia) *
                            (to_error ? 32 : first_samples(settings.sampling));
  const auto repeats =
      static_cast<std::size_t>(std::clamp(of.rays_per_point / frame_rays, 4.0, 16.0));
  std::vector<Mat4> poses;
  for (std::size_t r = 0; r < repeats; ++r) poses.insert(poses.end(), views.begin(), views.end());
  std::vector<float> out(poses.size() * ommatidia * rgb_bands);
  std::vector<std::int32_t> rays(poses.size() * ommatidia);
  RenderCall call;
  call.rays = rays;
  call.first_pose = 0;
  const Renderer renderer(built, of.setup.eye, settings);
  Point point;
  point.seconds = best_seconds(least_s, [&] { renderer.render(poses, out, call); }) /
                  static_cast<double>(poses.size());
  for (std::int32_t n : rays) point.rays += n;
  point.rays /= static_cast<double>(rays.size());
  if (shares_rays(settings.sampling)) {
    // Each ray serves several, and all poses have the same ones: other seeds make the repeats.
    point.rays = static_cast<double>(renderer.rays_per_frame()) / static_cast<double>(ommatidia);
    for (std::size_t r = 1; r < 4; ++r) {
      settings.seed = r + 1;
      const std::span part(out.data() + r * reference.size(), reference.size());
      Renderer(built, of.setup.eye, settings).render(views, part);
    }
    out.resize(4 * reference.size());
  }
  double sum = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double d = static_cast<double>(out[i]) - reference[i % reference.size()];
    sum += d * d;
  }
  point.rms = std::sqrt(sum / static_cast<double>(out.size()));
  point.bias = measure_bias(out, reference, out.size() / reference.size());
  return point;
}

void measure_case(const Case& of, bool quick) {
  const Renderer built(of.setup.scene, of.setup.eye);
  const std::vector<float> reference = make_reference(built, of);
  const double least_s = quick ? 0 : 0.25;
  const auto line = [&](const char* method, double setting, const RenderSettings& settings) {
    const Point p = measure(built, of, reference, settings, least_s);
    std::printf("%s,%zu,%d,%s,%.5g,%.4g,%.5g,%.3g,%.5g\n", of.setup.name.c_str(),
                of.setup.eye.size(), of.reference_rays, method, setting, p.rays, p.rms, p.bias,
                1e3 * p.seconds);
    std::fflush(stdout);
    return p;
  };
  RenderSettings settings;
  settings.points = Points::random;
  settings.footprints = false;
  settings.noise = Noise::new_every_frame;
  double random_100 = 0;
  for (int n : quick ? std::vector{25, 100} : std::vector{1, 4, 16, 50, 100, 256, 1024}) {
    settings.sampling = Fixed{n};
    const Point p = line("random", n, settings);
    if (n == 100) random_100 = p.rms;
  }
  settings.points = Points::low_discrepancy;
  for (const bool footprints : {false, true})
    for (int n : quick ? std::vector{4, 16, 64} : std::vector{1, 2, 4, 8, 16, 32, 64, 128, 256}) {
      settings.sampling = Fixed{n};
      settings.footprints = footprints;
      line(footprints ? "footprints" : "no footprints", n, settings);
    }
  settings.noise = Noise::frozen;
  for (int n : quick ? std::vector{4, 16} : std::vector{1, 2, 4, 8, 16, 32, 64}) {
    settings.sampling = Shared{n};
    line("shared rays", n, settings);
  }
  settings.noise = Noise::new_every_frame;
  for (int least : {4, 8}) {
    const std::string method = "target from " + std::to_string(least);
    for (double factor :
         quick ? std::vector{2.0, 1.0}
               : std::vector{16.0, 11.0, 8.0, 5.6, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5}) {
      const double target = factor * random_100;
      settings.sampling = ToError{target, least};
      line(method.c_str(), target, settings);
    }
  }
}

}  // namespace

void error(bool quick) {
  const int reference = quick ? 1024 : 65536;
  const double rays = quick ? 1e5 : 2e7;
  std::vector<Case> cases;
  if (have_data("errors in natural-standin-sky and ofstad-arena")) {
    cases.push_back({meadow(), reference, rays});
    cases.back().setup.name = "meadow";
    cases.push_back({arena(), reference, rays});
  }
  cases.push_back({checkerboard(), reference, rays});
  // Some 4 million rays/s: fewer of them.
  cases.push_back({bundled(), quick ? 256 : 16384, quick ? 1e4 : 2e6});
  Setup& grass = cases.back().setup;
  grass.name = "grass";
  grass.eye = sector(bee_eye(), quick ? 64 : 4);
  if (have_data("errors of 1,000 ommatidia in natural-standin-sky")) {
    Setup thousand = meadow();
    thousand.name = "meadow 1000";
    thousand.eye = thousand_eye();
    const std::vector<Mat4> poses = flight(thousand, 256);
    thousand.poses.clear();
    for (std::size_t i = 0; i < poses.size(); i += 32) thousand.poses.push_back(poses[i]);
    cases.push_back({std::move(thousand), reference, rays});
  }
  if (quick)
    for (Case& c : cases) c.setup.eye = sector(c.setup.eye, 4);
  std::printf("scene,ommatidia,reference_rays,method,setting,rays,rms,bias,ms_per_frame\n");
  for (const Case& c : cases) measure_case(c, quick);
}

}  // namespace omma::bench
