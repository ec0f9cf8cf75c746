// Which camera is at hand and how it is moved; see state.h.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "state.h"

namespace omma::compat {

CompatCamera& current_camera(State& state) {
  if (state.cameras.empty()) {
    std::fputs("Initializing default camera\n", stderr);
    state.cameras.emplace_back().name = "Default Camera";
    state.current = 0;
  }
  return state.cameras[state.current];
}

CompoundEye* current_eye(State& state) {
  if (state.cameras.empty()) return nullptr;
  CompatCamera& camera = state.cameras[state.current];
  return camera.type == CameraType::compound ? &camera.compound : nullptr;
}

void go_to_camera(State& state, long long index) {
  current_camera(state);  // so that there is one
  const auto count = static_cast<long long>(state.cameras.size());
  state.current = static_cast<std::size_t>((index % count + count) % count);
}

bool go_to_camera(State& state, const char* name) {
  state.current = 0;
  if (name == nullptr) return false;
  for (std::size_t i = 0; i < state.cameras.size(); ++i)
    if (state.cameras[i].name == name) {
      state.current = i;
      return true;
    }
  return false;
}

void rotate_around(CompatCamera& camera, float angle_rad, Vec3 axis) {
  const float size = std::sqrt(dot(axis, axis));
  if (!(size > 0) || !std::isfinite(size))
    throw Error("the axis of a rotation must have a length; the camera stays as it was");
  const Vec3 unit = axis * (1 / size);
  const float c = std::cos(angle_rad), s = std::sin(angle_rad);
  // Rodrigues' rotation formula.
  const auto rotated = [&](Vec3 v) {
    const Vec3 sideways{unit.y * v.z - unit.z * v.y, unit.z * v.x - unit.x * v.z,
                        unit.x * v.y - unit.y * v.x};
    return v * c + sideways * s + unit * ((1 - c) * dot(unit, v));
  };
  camera.space = {rotated(camera.space.x), rotated(camera.space.y), rotated(camera.space.z)};
}

Vec3 to_world(const CompatCamera& camera, Vec3 local) {
  return camera.space.x * local.x + camera.space.y * local.y + camera.space.z * local.z;
}

Mat4 world_from_head(const CompatCamera& camera) {
  const Vec3 columns[4] = {camera.space.x, camera.space.y, camera.space.z * -1.0f, camera.position};
  Mat4 pose;
  for (int c = 0; c < 4; ++c) {
    pose.m[0][c] = columns[c].x;
    pose.m[1][c] = columns[c].y;
    pose.m[2][c] = columns[c].z;
  }
  const double volume = determinant(pose);
  if (!std::isfinite(volume) || volume == 0 ||
      !std::isfinite(pose.m[0][3] + pose.m[1][3] + pose.m[2][3]))
    throw Error("the camera '" + camera.name +
                "' has a local space that is flat or not finite; the frame stays as it was");
  return pose;
}

void set_samples(CompatCamera& camera, long long samples) {
  if (samples > max_samples)
    std::fprintf(stderr, "ERROR: %lld samples per ommatidium, at most %d are taken\n", samples,
                 max_samples);
  camera.compound.samples = static_cast<int>(std::clamp<long long>(samples, 1, max_samples));
}

void set_eye(CompatCamera& camera, Eye eye) {
  validate_eye(eye);
  camera.compound.eye = std::move(eye);
  camera.renderer.reset();
  camera.id_map = {};
}

}  // namespace omma::compat
