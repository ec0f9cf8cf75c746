// Whole renders with any number of bands and with each backend, in one run: frames of all take turns,
// so that a disturbance meets all of them.
#include <algorithm>
#include <cstdio>

#include "backend/backend.h"
#include "scenes.h"

namespace omma::bench {
namespace {

constexpr int rays = 16;

struct Way {
  std::string backend;
  int bands;
  Renderer renderer;
  std::vector<float> out;
  double best_s = 1e9;
};

Way way_of(const Setup& setup, const std::string& backend, int bands) {
  WorldSettings settings;
  settings.backend = backend;
  for (int i = 0; bands != 3 && i < 3 * bands; ++i)
    settings.band_from_rgb.push_back(0.1 + 0.05 * (i % 7));
  RenderSettings of_eye;
  of_eye.sampling = Fixed{rays};
  return {backend, bands, Renderer(World(setup.scene, settings), setup.eye, of_eye),
          std::vector<float>(setup.poses.size() * setup.eye.size() *
                             static_cast<std::size_t>(bands))};
}

}  // namespace

void worlds(bool quick) {
  std::vector<Setup> setups;
  if (have_data("worlds in natural-standin-sky")) setups.push_back(meadow());
  setups.push_back(bundled());
  setups.push_back(hills(quick ? 100 : 708));
  std::printf("scene,backend,bands,mrays_per_s,of_embree_with_3\n");
  for (const Setup& setup : setups) {
    std::vector<Way> ways;
    for (const Backend& backend : backends())
      for (const int bands : {3, 4, 8, 16}) ways.push_back(way_of(setup, backend.name, bands));
    const auto start = Clock::now();
    for (int i = 0; i < 3 || seconds_since(start) < (quick ? 0.1 : 20); ++i)
      for (Way& way : ways) {
        const auto before = Clock::now();
        way.renderer.render(setup.poses, way.out);
        way.best_s = std::min(way.best_s, seconds_since(before));
      }
    const double mrays = 1e-6 * static_cast<double>(setup.poses.size() * setup.eye.size()) * rays;
    for (const Way& way : ways)
      std::printf("%s,%s,%d,%.2f,%.3f\n", setup.name.c_str(), way.backend.c_str(), way.bands,
                  mrays / way.best_s, ways.front().best_s / way.best_s);
    std::fflush(stdout);
  }
}

}  // namespace omma::bench
