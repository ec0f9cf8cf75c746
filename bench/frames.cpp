// Frames per second in batches, the latency of single frames, and both by the number of threads,
// for 1,000 and 6,374 ommatidia in natural-standin-sky.
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scenes.h"

namespace omma::bench {
namespace {

// Without CompoundRay's data: the bundled bee, and a tenth of it, over the checkerboard, which is
// about as fast as their meadow.
std::vector<Setup> eyes_in_meadow(const char* what) {
  Setup small, large;
  if (have_data(what)) {
    large = meadow();
    small = large;
    small.eye = thousand_eye();
  } else {
    large = checkerboard();
    small = large;
    small.eye = sector(large.eye, 10);
  }
  return {small, large};
}

struct Job {
  Setup setup;
  int samples;
};

// What closed loops are measured with: the fewest rays, and the default.
std::vector<Job> jobs(const char* what) {
  const std::vector<Setup> setups = eyes_in_meadow(what);
  return {{setups[0], 1}, {setups[0], 16}, {setups[1], 16}};
}

// As many poses as keep a batch busy for about a tenth of a second.
std::size_t batch_size(const Setup& setup, int samples, bool quick) {
  const double rays = static_cast<double>(setup.eye.size()) * samples;
  return static_cast<std::size_t>(std::clamp((quick ? 1e5 : 5e6) / rays, 1.0, 1024.0));
}

double batch_seconds(const Renderer& renderer, const std::vector<Mat4>& poses, double least_s) {
  std::vector<float> out(poses.size() * renderer.eye().size() * rgb_bands);
  return best_seconds(least_s, [&] { renderer.render(poses, out); }) /
         static_cast<double>(poses.size());
}

// Each of many single frames, s, sorted. The first ones warm up and do not count.
std::vector<double> single_seconds(const Renderer& renderer, const std::vector<Mat4>& poses) {
  std::vector<float> out(renderer.eye().size() * rgb_bands);
  std::vector<double> seconds;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto start = Clock::now();
    renderer.render({&poses[i], 1}, out);
    seconds.push_back(seconds_since(start));
  }
  seconds.erase(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(poses.size() / 10));
  std::sort(seconds.begin(), seconds.end());
  return seconds;
}

RenderSettings with(int samples, int thread_count = 0) {
  RenderSettings settings;
  settings.sampling = Fixed{samples};
  settings.threads = thread_count;
  settings.noise = Noise::new_every_frame;
  return settings;
}

}  // namespace

void frames(bool quick) {
  std::printf("scene,ommatidia,rays,frames_per_s\n");
  for (const Setup& setup : eyes_in_meadow("frames/s in natural-standin-sky")) {
    const Renderer built(setup.scene, setup.eye);
    for (int samples : quick ? std::vector{1, 10} : std::vector{1, 10, 50, 100, 1000, 3200}) {
      const Renderer renderer(built, setup.eye, with(samples));
      const auto poses = flight(setup, batch_size(setup, samples, quick));
      const double s = batch_seconds(renderer, poses, quick ? 0 : 1.0);
      std::printf("%s,%zu,%d,%.1f\n", setup.name.c_str(), setup.eye.size(), samples, 1 / s);
      std::fflush(stdout);
    }
  }
}

void latency(bool quick) {
  std::printf("language,scene,ommatidia,rays,median_us,p99_us,batch_us\n");
  for (const Job& job : jobs("latency in natural-standin-sky")) {
    const Renderer renderer(job.setup.scene, job.setup.eye, with(job.samples));
    const auto poses = flight(job.setup, batch_size(job.setup, job.samples, quick));
    double batch_s = batch_seconds(renderer, poses, quick ? 0 : 1.0);
    const auto single = single_seconds(renderer, flight(job.setup, quick ? 100 : 4000));
    batch_s = std::min(batch_s, batch_seconds(renderer, poses, quick ? 0 : 1.0));
    std::printf("C++,%s,%zu,%d,%.1f,%.1f,%.1f\n", job.setup.name.c_str(), job.setup.eye.size(),
                job.samples, 1e6 * single[single.size() / 2],
                1e6 * single[single.size() * 99 / 100], 1e6 * batch_s);
    std::fflush(stdout);
  }
}

void threads(bool quick) {
  const int hardware = oneapi::tbb::info::default_concurrency();
  std::vector<int> counts;
  for (int n = 1; n < hardware; n *= 2) counts.push_back(n);
  counts.push_back(hardware);
  std::printf("scene,ommatidia,rays,threads,batch_us,single_us\n");
  for (const Job& job : jobs("threads in natural-standin-sky")) {
    const Renderer built(job.setup.scene, job.setup.eye);
    std::vector<Renderer> renderers;
    for (int n : counts) renderers.emplace_back(built, job.setup.eye, with(job.samples, n));
    const auto batch = flight(job.setup, batch_size(job.setup, job.samples, quick));
    const auto path = flight(job.setup, quick ? 50 : 1000);
    std::vector<double> batch_s(counts.size(), 1e9), single_s(counts.size(), 1e9);
    // In turns, so that a disturbance meets all numbers of threads.
    for (int round = 0; round < (quick ? 1 : 5); ++round)
      for (std::size_t i = 0; i < counts.size(); ++i) {
        batch_s[i] = std::min(batch_s[i], batch_seconds(renderers[i], batch, 0));
        const auto single = single_seconds(renderers[i], path);
        single_s[i] = std::min(single_s[i], single[single.size() / 2]);
      }
    for (std::size_t i = 0; i < counts.size(); ++i)
      std::printf("%s,%zu,%d,%d,%.2f,%.2f\n", job.setup.name.c_str(), job.setup.eye.size(),
                  job.samples, counts[i], 1e6 * batch_s[i], 1e6 * single_s[i]);
    std::fflush(stdout);
  }
}

}  // namespace omma::bench
