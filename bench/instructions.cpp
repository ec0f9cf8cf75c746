// A fixed small render on one thread, whose instructions are counted (bench/run.py): a change that
// costs instructions is seen on any machine, however busy. It needs no files.
#include <cmath>

#include "scenes.h"

namespace omma::bench {
namespace {

// A thousand axes spread evenly over the sphere (a Fibonacci spiral), 3 degrees each.
Eye make_eye() {
  Eye eye;
  constexpr int n = 1000;
  for (int i = 0; i < n; ++i) {
    const double y = 1 - (2 * i + 1.0) / n, r = std::sqrt(1 - y * y);
    const double turn = i * pi * (3 - std::sqrt(5.0));
    eye.axis.push_back(to_float({r * std::cos(turn), y, r * std::sin(turn)}));
    eye.position_m.push_back({});
    eye.acceptance_angle_rad.push_back(static_cast<float>(3 * degree));
    eye.focal_offset_m.push_back(0);
    eye.eye_id.push_back(0);
  }
  return eye;
}

}  // namespace

void instructions(const std::string& which) {
  if (which != "1" && which != "16" && which != "16-plain" && which != "16-random" &&
      which != "16-shared" && which != "target")
    throw Error("expected 1, 16, 16-plain, 16-random, 16-shared or target, found " + which);
  const Setup setup = hills(100);
  RenderSettings settings;
  settings.threads = 1;
  if (which == "1") settings.sampling = Fixed{1};
  if (which == "16-shared") settings.sampling = Shared{16};
  if (which == "target") settings.sampling = ToError{0.02, 4};
  if (which == "16-random") settings.points = Points::random;
  settings.footprints = which != "16-plain" && which != "16-random";
  if (which != "16-shared") settings.noise = Noise::new_every_frame;
  const Renderer renderer(setup.scene, make_eye(), settings);
  const std::vector<Mat4> poses = flight(setup, 4);
  std::vector<float> out(poses.size() * renderer.eye().size() * rgb_bands);
  renderer.render(poses, out);
}

}  // namespace omma::bench
