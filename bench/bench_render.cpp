// How close the whole render comes to what Embree can trace, in one run and on the same rays: the
// ceiling is rtcIntersect16, coherent, on prepared packets; the render adds directions, shading and
// reduction. Scenes: the meadow of natural-standin-sky.gltf with a real honeybee's eyes where that
// data is there (else the bundled example), and a rolling surface of a million triangles made here.
#include <benchmark/benchmark.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "backend/embree/block.h"
#include "backend/shading_data.h"
#include "omma/omma.h"

namespace {

using namespace omma;

struct Setup {
  std::string name;
  std::shared_ptr<const Scene> scene;
  Eye eye;
  Mat4 pose;
};

Setup load_meadow() {
  const std::string data = std::string(OMMA_SHARED_DATA) + "/compound-ray";
  if (!std::filesystem::exists(data)) {
    const std::string examples = OMMA_EXAMPLES;
    auto scene = std::make_shared<const Scene>(load_scene(examples + "/meadow.glb"));
    const PlacedEye eyes[] = {{load_eye(examples + "/honeybee_worker_left.eye"), {}},
                              {load_eye(examples + "/honeybee_worker_right.eye"), {}}};
    return {"bundled_meadow", scene, merge_eyes(eyes),
            find_camera(*scene, "bee").world_from_camera};
  }
  auto scene = std::make_shared<const Scene>(load_scene(data + "/scenes/natural-standin-sky.gltf"));
  // Just above the ground in the middle, where CompoundRay's cameras stand too.
  return {"meadow", scene, load_eye(data + "/bees/AM_60185-real.eye"),
          pose_from_quaternion({0.0, 0.15, 0.0}, 0, 0, 0, 1)};
}

// Hills of 1,002,528 triangles over a square kilometre, textured with a checkerboard.
Setup make_hills() {
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
  Setup meadow = load_meadow();
  return {"hills_1M", std::make_shared<const Scene>(std::move(scene)), std::move(meadow.eye),
          pose_from_quaternion({0, height(0, 0) + 2.0, 0}, 0, 0, 0, 1)};
}

constexpr int blocks_rays = 512;

// What a Renderer holds inside, for the ceiling.
struct Prepared {
  std::unique_ptr<ShadingData> shading;
  std::unique_ptr<EmbreeTracer> tracer;
  DirectionTables directions;
  EyeArrays eye;
  std::vector<std::vector<RTCRayHit16>> packets;  // [block]
};

Prepared prepare(const Setup& setup, int samples) {
  Prepared p;
  RenderSettings settings;
  settings.samples = samples;
  p.shading = make_shading_data(*setup.scene, setup.scene->background);
  p.tracer = make_embree_tracer(*setup.scene, p.shading->view);
  p.directions = make_direction_tables(setup.eye, settings);
  p.eye = make_eye_arrays(setup.eye, p.directions);
  const BlockContext context{p.tracer.get(), &p.shading->view, &p.eye, &p.directions, 1};
  const int per_block = std::clamp(blocks_rays / samples, 1, block_capacity);
  const int ommatidia = static_cast<int>(setup.eye.size());
  for (int first = 0; first < ommatidia; first += per_block) {
    BlockTask task;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        task.world_from_head[r][c] = static_cast<float>(setup.pose.m[r][c]);
    task.first = first;
    task.count = std::min(per_block, ommatidia - first);
    p.packets.emplace_back(static_cast<std::size_t>((task.count * samples + 15) / 16));
    choose_block_functions().prepare(context, task, p.packets.back().data());
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

template <typename Work>
void time_frames(benchmark::State& state, const std::string& key, std::size_t ommatidia,
                 int samples, const Work& work) {
  double best_s = 1e9;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const double s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best_s = std::min(best_s, s);
    state.SetIterationTime(s);
  }
  count_rays(state, key, ommatidia, samples, best_s);
}

void bench_ceiling(benchmark::State& state, const Setup& setup, int samples) {
  const Prepared p = prepare(setup, samples);
  time_frames(state, setup.name + "/" + std::to_string(samples) + "/ceiling", setup.eye.size(),
              samples, [&] {
                oneapi::tbb::parallel_for(std::size_t{0}, p.packets.size(), [&](std::size_t b) {
                  IntersectArguments arguments;
                  alignas(64) int valid[16];
                  for (int& v : valid) v = -1;
                  for (const RTCRayHit16& packet : p.packets[b]) {
                    RTCRayHit16 rays = packet;
                    intersect_16(p.tracer->scene, valid, rays, arguments);
                    benchmark::DoNotOptimize(rays.ray.tfar[0]);
                  }
                });
              });
}

void bench_render(benchmark::State& state, const Setup& setup, int samples) {
  RenderSettings settings;
  settings.samples = samples;
  const Renderer renderer(setup.scene, setup.eye, settings);
  std::vector<float> responses(setup.eye.size() * channel_count);
  time_frames(state, setup.name + "/" + std::to_string(samples) + "/render", setup.eye.size(),
              samples, [&] {
                renderer.render({&setup.pose, 1}, responses);
              });
}

void bench_build(benchmark::State& state, const Setup& setup) {
  BuildTimes times;
  for (auto _ : state) times = Renderer(setup.scene, setup.eye).build_times();
  state.counters["scene_ms"] = 1e3 * times.scene_s;
  state.counters["acceleration_ms"] = 1e3 * times.acceleration_s;
  state.counters["directions_ms"] = 1e3 * times.directions_s;
  state.counters["triangles"] = static_cast<double>(triangle_count(*setup.scene));
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::vector<Setup> setups = {load_meadow(), make_hills()};
  const int counts[] = {1, 4, 16, 64, 256};
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

  std::cout << "\nbest of each, " << oneapi::tbb::info::default_concurrency() << " threads\n"
            << "scene            rays/omm.   ceiling Mrays/s   render Mrays/s   ratio   frames/s\n";
  for (const Setup& setup : setups)
    for (int samples : counts) {
      const std::string key = setup.name + "/" + std::to_string(samples);
      const double ceiling = best_rays_per_s()[key + "/ceiling"];
      const double render = best_rays_per_s()[key + "/render"];
      if (ceiling == 0 || render == 0) continue;
      char line[160];
      std::snprintf(line, sizeof line, "%-16s %9d %17.1f %16.1f %7.3f %10.0f\n", setup.name.c_str(),
                    samples, ceiling * 1e-6, render * 1e-6, render / ceiling,
                    render / static_cast<double>(setup.eye.size()) / samples);
      std::cout << line;
    }
  return 0;
}
