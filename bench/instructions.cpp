// A fixed small render on one thread, whose instructions are counted (bench/run.py): a change that
// costs instructions is seen on any machine, however busy. It needs no files.
#include "scenes.h"

namespace omma::bench {
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
  const Renderer renderer(setup.scene, even_eye(1000), settings);
  const std::vector<Mat4> poses = flight(setup, 4);
  std::vector<float> out(poses.size() * renderer.eye().size() * rgb_bands);
  renderer.render(poses, out);
}

}  // namespace omma::bench
