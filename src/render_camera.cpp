// Pictures: their rays in bands of pixels, each band an eye that is rendered and averaged. Bands go
// in parallel, one thread each, so that laying out their rays is done by all threads too.
#include <algorithm>
#include <chrono>

#include "physics/hash.h"
#include "physics/sobol.h"
#include "model/camera.h"
#include "omma/camera.h"
#include "threads/parallel.h"

namespace omma {
namespace {

using Clock = std::chrono::steady_clock;

// Rays of a band: some ten milliseconds of work and a few megabytes.
constexpr std::size_t band_rays = 1u << 15;

struct Bits2 {
  std::uint32_t x = 0, y = 0;
};

// The points of one pixel, before their shift: Owen-scrambled Sobol points.
std::vector<Bits2> points_within_pixel(int samples, std::uint64_t seed) {
  const std::uint64_t scramble = mix_bits(seed ^ 0x70697865ull);
  std::vector<Bits2> points;
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(samples); ++i)
    points.push_back({owen_scramble(sobol_0(i), hash_combine(scramble, 0)),
                      owen_scramble(sobol_1(i), hash_combine(scramble, 1))});
  return points;
}

struct Picture {
  const Camera* camera;
  const CameraSettings* settings;
  std::vector<Bits2> points;  // [sample]
  std::span<float> out;       // [pixel][channel]
};

// The rays of `count` pixels, [pixel][sample].
Eye rays_of_pixels(const Picture& picture, std::size_t first, std::size_t count) {
  const PictureSize size = picture.settings->size;
  const std::uint64_t seed = picture.settings->seed;
  Eye eye;
  for (std::size_t pixel = first; pixel < first + count; ++pixel) {
    const double column = static_cast<double>(pixel % static_cast<std::size_t>(size.width));
    const double row = static_cast<double>(pixel / static_cast<std::size_t>(size.width));
    if (picture.points.size() == 1) {
      add_camera_ray(eye, camera_ray(*picture.camera, size, column + 0.5, row + 0.5));
      continue;
    }
    // A digital shift keeps the points as evenly spread as they are, and differs from pixel to
    // pixel so that what is left of an error is noise and not a pattern.
    const std::uint64_t shift = hash_combine(pose_hash(seed, 0), pixel);
    for (const Bits2 point : picture.points) {
      const double x = (point.x ^ static_cast<std::uint32_t>(shift)) * 0x1p-32;
      const double y = (point.y ^ static_cast<std::uint32_t>(shift >> 32)) * 0x1p-32;
      add_camera_ray(eye, camera_ray(*picture.camera, size, column + x, row + y));
    }
  }
  return eye;
}

// Renders the rays of `count` pixels and averages them.
void render_pixels(const Renderer& renderer, const Picture& picture, std::size_t first,
                   std::size_t count) {
  std::vector<float> radiance(renderer.eye().size() * rgb_bands);
  renderer.render(std::span(&picture.camera->world_from_camera, 1), radiance);
  const std::size_t samples = picture.points.size();
  for (std::size_t pixel = 0; pixel < count; ++pixel)
    for (std::size_t c = 0; c < rgb_bands; ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < samples; ++i)
        sum += radiance[(pixel * samples + i) * rgb_bands + c];
      picture.out[(first + pixel) * rgb_bands + c] =
          static_cast<float>(sum / static_cast<double>(samples));
    }
}

void check(const Camera& camera, const CameraSettings& settings, std::span<float> picture) {
  check_picture_camera(camera);
  const auto [width, height] = settings.size;
  if (width < 1 || height < 1 || width > max_picture_extent || height > max_picture_extent)
    throw Error("picture: expected a width and height of 1 to " +
                std::to_string(max_picture_extent) + " pixels, found " + std::to_string(width) +
                " and " + std::to_string(height));
  if (settings.samples < 1 || settings.samples > max_samples)
    throw Error("samples: expected 1 to " + std::to_string(max_samples) + ", found " +
                std::to_string(settings.samples));
  const std::size_t expected =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * rgb_bands;
  if (picture.size() != expected)
    throw Error("picture: expected room for " + std::to_string(expected) +
                " values (row x column x channel), found " + std::to_string(picture.size()));
}

}  // namespace

void render_camera(const Renderer& same_scene, const Camera& camera, const CameraSettings& settings,
                   std::span<float> picture, const std::function<bool(double)>& progress) {
  check(camera, settings, picture);
  const Picture whole{&camera, &settings, points_within_pixel(settings.samples, settings.seed),
                      picture};
  const std::size_t pixels = picture.size() / rgb_bands;
  const std::size_t per_band =
      std::max<std::size_t>(1, band_rays / static_cast<std::size_t>(settings.samples));
  const std::size_t bands = (pixels + per_band - 1) / per_band;
  const auto run_band = [&](std::size_t band) {
    const std::size_t first = band * per_band;
    const std::size_t count = std::min(per_band, pixels - first);
    const Renderer renderer(same_scene, rays_of_pixels(whole, first, count), Renderer::OneThread{});
    render_pixels(renderer, whole, first, count);
  };
  // Stretches of about a fifth of a second, as Renderer::render has them.
  oneapi::tbb::task_arena arena(same_scene.threads());
  auto stretch = static_cast<std::size_t>(same_scene.threads());
  for (std::size_t done = 0; done < bands;) {
    const auto start = Clock::now();
    const std::size_t end = std::min(bands, done + stretch);
    run_in_arena(arena, [&] { parallel_for(done, end, run_band); });
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const double rate = static_cast<double>(end - done) / std::max(seconds, 1e-6);
    stretch = static_cast<std::size_t>(std::max(1.0, 0.2 * rate));
    done = end;
    const double share = static_cast<double>(done) / static_cast<double>(bands);
    if (progress && !progress(share)) throw Cancelled();
  }
}

}  // namespace omma
