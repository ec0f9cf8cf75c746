// How close the whole render comes to what Embree can trace, in one run and on the same rays: the
// ceiling is rtcIntersect16, coherent, on prepared packets; the render adds directions, shading and
// reduction. Scenes: natural-standin-sky.gltf with a real honeybee's eyes where that data is there,
// the bundled meadow and honeybee, and a rolling surface of a million triangles made here.
#include <benchmark/benchmark.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/embree/block.h"
#include "backend/shading_data.h"
#include "omma/omma.h"

namespace {

using namespace omma;
using Clock = std::chrono::steady_clock;

int thread_count() {
  return oneapi::tbb::info::default_concurrency();
}

struct Setup {
  std::string name;
  std::shared_ptr<const Scene> scene;
  Eye eye;
  Mat4 pose;
  double load_s = 0;  // from file to Scene; 0 for a scene made here
};

// The bundled example: cut-outs, many meshes, much overlap.
Setup load_bundled() {
  const std::string examples = OMMA_EXAMPLES;
  const auto start = Clock::now();
  auto scene = std::make_shared<const Scene>(load_scene(examples + "/meadow.glb"));
  const double load_s = std::chrono::duration<double>(Clock::now() - start).count();
  const PlacedEye eyes[] = {{load_eye(examples + "/honeybee_worker_left.eye"), {}},
                            {load_eye(examples + "/honeybee_worker_right.eye"), {}}};
  return {"bundled meadow", scene, merge_eyes(eyes), find_camera(*scene, "bee").world_from_camera,
          load_s};
}

Setup load_meadow() {
  const std::string data = std::string(OMMA_SHARED_DATA) + "/compound-ray";
  const auto start = Clock::now();
  auto scene = std::make_shared<const Scene>(load_scene(data + "/scenes/natural-standin-sky.gltf"));
  const double load_s = std::chrono::duration<double>(Clock::now() - start).count();
  // Just above the ground in the middle, where CompoundRay's cameras stand too.
  return {"natural-standin-sky", scene, load_eye(data + "/bees/AM_60185-real.eye"),
          pose_from_quaternion({0.0, 0.15, 0.0}, 0, 0, 0, 1), load_s};
}

// Hills of 1,002,528 triangles over a square kilometre, textured with a checkerboard.
Setup make_hills(const Eye& eye) {
  constexpr std::uint32_t cells = 708;
  Scene scene;
  Mesh mesh;
  const auto height = [](double x, double z) {
    return 6 * std::sin(0.02 * x) * std::cos(0.017 * z) + 0.7 * std::sin(0.31 * x + 0.2 * z) +
           0.2 * std::sin(1.3 * x) * std::sin(1.1 * z);
  };
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i) {
      const double x = 1000.0 * i / cells - 500, z = 1000.0 * j / cells - 500;
      mesh.positions.push_back(to_float({x, height(x, z), z}));
      mesh.texcoords[0].push_back({static_cast<float>(0.1 * x), static_cast<float>(0.1 * z)});
    }
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  mesh.material = 0;
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({"hills", 0, {}});
  Image image;
  image.width = image.height = 256;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const auto value =
          static_cast<std::uint8_t>(((x / 32 + y / 32) % 2) * 120 + 60 + (x ^ y) % 32);
      image.rgba_srgb8.insert(image.rgba_srgb8.end(), {value, value, 90, 255});
    }
  scene.images.push_back(std::move(image));
  scene.textures.push_back({0, Wrap::repeat, Wrap::repeat, Filter::linear});
  Material material;
  material.base_color_texture.texture = 0;
  material.double_sided = true;
  scene.materials.push_back(material);
  scene.background.type = BackgroundType::simple_sky;
  return {"hills", std::make_shared<const Scene>(std::move(scene)), eye,
          pose_from_quaternion({0, height(0, 0) + 2.0, 0}, 0, 0, 0, 1)};
}

// What a Renderer holds inside, and its blocks at one pose.
struct Prepared {
  std::unique_ptr<ShadingData> shading;
  std::unique_ptr<EmbreeTracer> tracer;
  DirectionTables directions;
  EyeArrays eye;
  std::vector<BlockTask> tasks;
};

std::unique_ptr<Prepared> prepare(const Setup& setup, int samples) {
  auto p = std::make_unique<Prepared>();
  RenderSettings settings;
  settings.samples = samples;
  p->shading = make_shading_data(*setup.scene);
  p->tracer = make_embree_tracer(*setup.scene, p->shading->view);
  p->directions = make_direction_tables(setup.eye, settings);
  p->eye = make_eye_arrays(setup.eye, p->directions);
  const int per_block = std::clamp(block_rays / samples, 1, block_capacity);
  const int ommatidia = static_cast<int>(setup.eye.size());
  for (int first = 0; first < ommatidia; first += per_block) {
    BlockTask task;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        task.world_from_head[r][c] = static_cast<float>(setup.pose.m[r][c]);
    task.first = first;
    task.count = std::min(per_block, ommatidia - first);
    p->tasks.push_back(task);
  }
  return p;
}

std::map<std::string, double>& best_rays_per_s() {
  static std::map<std::string, double> rates;
  return rates;
}

void count_rays(benchmark::State& state, const std::string& key, std::size_t ommatidia, int samples,
                double best_s) {
  const double rays = static_cast<double>(ommatidia) * samples;
  state.counters["Mrays/s"] = rays / best_s * 1e-6;
  state.counters["frames/s"] = 1.0 / best_s;
  best_rays_per_s()[key] = std::max(best_rays_per_s()[key], rays / best_s);
}

// Tracing alone, timed block by block on packets just prepared, which are in the cache as they are
// in the render; the frame's time is the sum over all blocks shared by the threads.
void bench_ceiling(benchmark::State& state, const Setup& setup, int samples) {
  const auto p = prepare(setup, samples);
  const BlockContext context{p->tracer.get(), &p->shading->view, &p->eye, &p->directions, 1};
  const PrepareBlock prepare_block = choose_block_functions().prepare;
  double best_s = 1e9;
  for (auto _ : state) {
    std::atomic<std::int64_t> traced_ns{0};
    oneapi::tbb::parallel_for(std::size_t{0}, p->tasks.size(), [&](std::size_t t) {
      const BlockTask& task = p->tasks[t];
      thread_local std::vector<RTCRayHit16> packets;
      packets.resize(static_cast<std::size_t>((task.count * samples + 15) / 16));
      prepare_block(context, task, packets.data());
      const DenormalsAreZero denormals_are_zero;
      IntersectArguments arguments;
      alignas(64) int valid[16];
      for (int& v : valid) v = -1;
      const auto start = Clock::now();
      for (RTCRayHit16& rays : packets) intersect_16(p->tracer->scene, valid, rays, arguments);
      traced_ns += std::chrono::nanoseconds(Clock::now() - start).count();
      benchmark::DoNotOptimize(packets.data());
    });
    const double s = 1e-9 * static_cast<double>(traced_ns) / thread_count();
    best_s = std::min(best_s, s);
    state.SetIterationTime(s);
  }
  count_rays(state, setup.name + "/" + std::to_string(samples) + "/ceiling", setup.eye.size(),
             samples, best_s);
}

void bench_render(benchmark::State& state, const Setup& setup, int samples) {
  RenderSettings settings;
  settings.samples = samples;
  const Renderer renderer(setup.scene, setup.eye, settings);
  std::vector<float> responses(setup.eye.size() * channel_count);
  double best_s = 1e9;
  for (auto _ : state) {
    const auto start = Clock::now();
    renderer.render({&setup.pose, 1}, responses);
    const double s = std::chrono::duration<double>(Clock::now() - start).count();
    best_s = std::min(best_s, s);
    state.SetIterationTime(s);
  }
  count_rays(state, setup.name + "/" + std::to_string(samples) + "/render", setup.eye.size(),
             samples, best_s);
}

std::map<std::string, BuildTimes>& build_times() {
  static std::map<std::string, BuildTimes> times;
  return times;
}

void bench_build(benchmark::State& state, const Setup& setup) {
  BuildTimes& times = build_times()[setup.name];
  for (auto _ : state) times = Renderer(setup.scene, setup.eye).build_times();
  state.counters["scene_ms"] = 1e3 * times.scene_s;
  state.counters["acceleration_ms"] = 1e3 * times.acceleration_s;
  state.counters["directions_ms"] = 1e3 * times.directions_s;
  state.counters["triangles"] = static_cast<double>(triangle_count(*setup.scene));
}

// The tables of bench/RESULTS.md, in Markdown.
void print_results(const std::vector<Setup>& setups, std::span<const int> counts) {
  std::printf(
      "\n## Ceiling and whole render\n\n"
      "Best of each, %d threads. The ceiling is tracing alone: `rtcIntersect16`, coherent, on the\n"
      "render's own packets and its own scene, which is watertight (Embree's robust mode).\n\n"
      "| scene | triangles | ommatidia | rays each | ceiling, Mrays/s | render, Mrays/s | ratio "
      "| frames/s |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n",
      thread_count());
  for (const Setup& setup : setups)
    for (int samples : counts) {
      const std::string key = setup.name + "/" + std::to_string(samples);
      const double ceiling = best_rays_per_s()[key + "/ceiling"];
      const double render = best_rays_per_s()[key + "/render"];
      if (ceiling == 0 || render == 0) continue;
      std::printf("| %s | %llu | %zu | %d | %.1f | %.1f | %.3f | %.0f |\n", setup.name.c_str(),
                  static_cast<unsigned long long>(triangle_count(*setup.scene)), setup.eye.size(),
                  samples, ceiling * 1e-6, render * 1e-6, render / ceiling,
                  render / static_cast<double>(setup.eye.size()) / samples);
    }
  std::printf(
      "\n## Building\n\n"
      "| scene | file to Scene, ms | shading data, ms | acceleration structure, ms "
      "| direction tables (16 rays), ms |\n| --- | --- | --- | --- | --- |\n");
  for (const Setup& setup : setups) {
    const BuildTimes t = build_times()[setup.name];
    std::printf("| %s | %s | %.1f | %.1f | %.1f |\n", setup.name.c_str(),
                setup.load_s > 0 ? std::to_string(std::lround(1e3 * setup.load_s)).c_str() : "-",
                1e3 * t.scene_s, 1e3 * t.acceleration_s, 1e3 * t.directions_s);
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  std::vector<Setup> setups;
  if (std::filesystem::exists(OMMA_SHARED_DATA)) setups.push_back(load_meadow());
  setups.push_back(load_bundled());
  setups.push_back(make_hills(setups.front().eye));
  constexpr int counts[] = {1, 4, 16, 64, 256};
  for (const Setup& setup : setups) {
    benchmark::RegisterBenchmark(("build/" + setup.name).c_str(), [&](benchmark::State& s) {
      bench_build(s, setup);
    })->Unit(benchmark::kMillisecond);
    for (int samples : counts) {
      const std::string name = setup.name + "/" + std::to_string(samples);
      benchmark::RegisterBenchmark(("ceiling/" + name).c_str(),
                                   [&setup, samples](auto& s) { bench_ceiling(s, setup, samples); })
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond);
      benchmark::RegisterBenchmark(("render/" + name).c_str(),
                                   [&setup, samples](auto& s) { bench_render(s, setup, samples); })
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond);
    }
  }
  benchmark::RunSpecifiedBenchmarks();

  print_results(setups, counts);
  return 0;
}
