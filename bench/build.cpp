// What it takes to load and build one scene, and the memory. One scene a process: the peak is that
// of the whole process, the library's code included.
#include <cstdio>
#include <fstream>

#include "scenes.h"

namespace omma::bench {
namespace {

// The most memory this process has held so far, MB (Linux). Not getrusage's number, which a child
// inherits from what started it.
double peak_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == "VmHWM:") {
      double kib = 0;
      status >> kib;
      return kib * 1024e-6;
    }
  return 0;
}

template <typename T>
double megabytes(const std::vector<T>& values) {
  return 1e-6 * static_cast<double>(values.size() * sizeof(T));
}

// Triangles, vertices and what belongs to them: what anybody has to hold.
double mesh_mb(const Scene& scene) {
  double sum = 0;
  for (const Mesh& mesh : scene.meshes)
    sum += megabytes(mesh.positions) + megabytes(mesh.triangles) + megabytes(mesh.texcoords[0]) +
           megabytes(mesh.texcoords[1]) + megabytes(mesh.colors);
  return sum;
}

double image_mb(const Scene& scene) {
  double sum = 0;
  for (const Image& image : scene.images)
    sum += megabytes(image.rgba_srgb8) + megabytes(image.rgba_linear);
  return sum;
}

}  // namespace

void build(const std::string& name, const std::string& scene_file) {
  const Eye eye = bee_eye();
  const double before_mb = peak_mb();
  const auto start = Clock::now();
  auto scene = std::make_shared<const Scene>(load_scene(scene_file));
  const double load_s = seconds_since(start);
  const double load_mb = peak_mb();
  const Renderer renderer(scene, eye);
  const double built_s = seconds_since(start);
  std::vector<float> out(eye.size() * rgb_bands);
  const Mat4 pose;
  renderer.render({&pose, 1}, out);
  const double first_frame_s = seconds_since(start);
  const BuildTimes& times = renderer.build_times();
  std::printf(
      "scene,triangles,mesh_mb,image_mb,load_ms,shading_ms,acceleration_ms,directions_ms,build_ms,"
      "first_frame_ms,peak_start_mb,peak_load_mb,peak_mb\n");
  std::printf("%s,%llu,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n", name.c_str(),
              static_cast<unsigned long long>(triangle_count(*scene)), mesh_mb(*scene),
              image_mb(*scene), 1e3 * load_s, 1e3 * times.scene_s, 1e3 * times.acceleration_s,
              1e3 * times.directions_s, 1e3 * (built_s - load_s), 1e3 * first_frame_s, before_mb,
              load_mb, peak_mb());
}

}  // namespace omma::bench
