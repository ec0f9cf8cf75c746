// Pictures: their rays in bands of pixels, each band an eye that is traced and averaged. Bands go
// in parallel, so that laying out their rays is done by all threads too. The world keeps them for
// its next picture.
#include <algorithm>

#include "model/camera_check.h"
#include "omma/camera.h"
#include "physics/sampling/hash.h"
#include "physics/sampling/sobol.h"
#include "render/render_state.h"
#include "threads/parallel.h"
#include "world/camera_rays.h"
#include "world/traced_poses.h"

namespace omma {
namespace {

// Rays of a band: some ten milliseconds of work and a few megabytes.
constexpr std::size_t band_rays = 1u << 15;

// Rays that a world keeps at most: some 120 MB.
constexpr std::size_t most_kept_rays = 1u << 21;

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

// The rays of `count` pixels, [pixel][sample].
Eye rays_of_pixels(const CameraRays& rays, const std::vector<Bits2>& points, std::size_t first,
                   std::size_t count) {
  const PictureSize size = rays.settings.size;
  const std::uint64_t seed = rays.settings.seed;
  Eye eye;
  for (std::size_t pixel = first; pixel < first + count; ++pixel) {
    const double column = static_cast<double>(pixel % static_cast<std::size_t>(size.width));
    const double row = static_cast<double>(pixel / static_cast<std::size_t>(size.width));
    if (points.size() == 1) {
      add_camera_ray(eye, camera_ray(rays.lens, size, column + 0.5, row + 0.5));
      continue;
    }
    // A digital shift keeps the points as evenly spread as they are, and differs from pixel to
    // pixel so that what is left of an error is noise and not a pattern.
    const std::uint64_t shift = hash_combine(pose_hash(seed, 0), pixel);
    for (const Bits2 point : points) {
      const double x = (point.x ^ static_cast<std::uint32_t>(shift)) * 0x1p-32;
      const double y = (point.y ^ static_cast<std::uint32_t>(shift >> 32)) * 0x1p-32;
      add_camera_ray(eye, camera_ray(rays.lens, size, column + x, row + y));
    }
  }
  validate_eye(eye);
  return eye;
}

EyeArrays lay_out_band(const CameraRays& rays, const std::vector<Bits2>& points, std::size_t band) {
  const std::size_t first = band * rays.pixels_per_band;
  const std::size_t count = std::min(rays.pixels_per_band, rays.pixels() - first);
  return make_eye_arrays(rays_of_pixels(rays, points, first, count), rays.directions);
}

bool has_rays_of(const CameraRays& rays, const Camera& camera, const CameraSettings& settings) {
  const Camera& lens = rays.lens;
  return lens.type == camera.type && lens.yfov_rad == camera.yfov_rad &&
         lens.aspect_ratio == camera.aspect_ratio && lens.xmag_m == camera.xmag_m &&
         lens.ymag_m == camera.ymag_m && rays.settings.size.width == settings.size.width &&
         rays.settings.size.height == settings.size.height &&
         rays.settings.samples == settings.samples && rays.settings.seed == settings.seed;
}

// Without bands yet, which are laid out when they are first traced.
std::unique_ptr<CameraRays> new_camera_rays(const Camera& camera, const CameraSettings& settings,
                                            const std::vector<Bits2>& points) {
  auto rays = std::make_unique<CameraRays>();
  rays->lens = camera;
  rays->settings = settings;
  const auto samples = static_cast<std::size_t>(settings.samples);
  rays->pixels_per_band = std::max<std::size_t>(1, band_rays / samples);
  rays->directions = make_direction_tables(
      rays_of_pixels(*rays, points, 0, std::min(rays->pixels_per_band, rays->pixels())),
      {.seed = settings.seed}, 1);
  rays->bands.resize(
      std::min(rays->band_count(), most_kept_rays / (rays->pixels_per_band * samples)));
  return rays;
}

// Traces the rays of a band and averages those of each pixel into `out`, [pixel][radiance band].
// `number`: of the band, by which choices on the way of its rays differ from those of others.
void render_band(const World& world, const CameraRays& rays, const EyeArrays& band,
                 std::size_t number, const Mat4& world_from_camera, float* out) {
  const BuiltScene& built = *world.state().built;
  const std::vector<Mat4> pose =
      traced_poses(std::span(&world_from_camera, 1), band, built.placement.origin_m);
  const auto bands = static_cast<std::size_t>(world.bands());
  const auto samples = static_cast<std::size_t>(rays.settings.samples);
  const std::size_t pixels = band.size() / samples;
  const EyeView eye = view(band);
  const DirectionsView directions = view(rays.directions);
  Blocks blocks{{&world.state().view, &eye, &directions},
                &built,
                static_cast<int>(band.size()),
                most_per_block};
  blocks.frame.outputs = world.bands();
  blocks.frame.radiance_unit = world.state().radiance_unit;
  std::vector<float> radiance(band.size() * bands);
  std::vector<BlockTask> tasks(blocks.count());
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    tasks[i] = make_task(blocks, i, pose.front(), number);
    tasks[i].responses = radiance.data();
  }
  // Isolated: a thread that waits for its band would begin another.
  run_isolated([&] { trace_tasks(blocks, tasks); });
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    for (std::size_t b = 0; b < bands; ++b) {
      double sum = 0;
      for (std::size_t i = 0; i < samples; ++i) sum += radiance[(pixel * samples + i) * bands + b];
      out[pixel * bands + b] = static_cast<float>(sum / static_cast<double>(samples));
    }
}

void check(const Camera& camera, const CameraSettings& settings, int bands,
           std::span<float> picture) {
  check_picture_camera(camera);
  const auto [width, height] = settings.size;
  if (width < 1 || height < 1 || width > max_picture_extent || height > max_picture_extent)
    throw Error("picture: expected a width and height of 1 to " +
                std::to_string(max_picture_extent) + " pixels, found " + std::to_string(width) +
                " and " + std::to_string(height));
  if (settings.samples < 1 || settings.samples > max_samples)
    throw Error("samples: expected 1 to " + std::to_string(max_samples) + ", found " +
                std::to_string(settings.samples));
  const std::size_t expected = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                               static_cast<std::size_t>(bands);
  if (picture.size() != expected)
    throw Error("picture: expected room for " + std::to_string(expected) +
                " values (row x column x band), found " + std::to_string(picture.size()));
}

}  // namespace

void render_camera(const World& world, const Camera& camera, const CameraSettings& settings,
                   std::span<float> picture, const std::function<bool(double)>& progress) {
  check(camera, settings, world.bands(), picture);
  const Rendering rendering(world);
  const BuiltScene& built = *world.state().built;
  const std::vector<Bits2> points = points_within_pixel(settings.samples, settings.seed);
  // Taken out, so that another picture at the same time lays out its own; the last one's stay.
  std::unique_ptr<CameraRays> rays(built.camera_rays.exchange(nullptr));
  if (rays == nullptr || !has_rays_of(*rays, camera, settings))
    run_in_arena(*built.threads.arena, [&] { rays = new_camera_rays(camera, settings, points); });
  const auto run_band = [&](std::size_t band) {
    float* const out =
        picture.data() + band * rays->pixels_per_band * static_cast<std::size_t>(world.bands());
    const auto render = [&](const EyeArrays& of_band) {
      render_band(world, *rays, of_band, band, camera.world_from_camera, out);
    };
    if (band >= rays->bands.size()) return render(lay_out_band(*rays, points, band));
    EyeArrays& kept = rays->bands[band];
    if (kept.ommatidium.empty()) kept = lay_out_band(*rays, points, band);
    render(kept);
  };
  run_in_stretches(rays->band_count(), band_rays, built.threads.threads, progress,
                   [&](std::size_t begin, std::size_t end) {
                     run_in_arena(*built.threads.arena,
                                  [&] { parallel_for(begin, end, run_band); });
                   });
  delete built.camera_rays.exchange(rays.release());
}

}  // namespace omma
