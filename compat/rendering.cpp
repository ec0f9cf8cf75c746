// A frame of the camera at hand. A picture of a perspective, orthographic or panoramic camera is
// what an eye with one ommatidium per pixel sees, each a single ray along its axis.
#include <cmath>

#include "state.h"

namespace omma::compat {
namespace {

// A ray from `origin` in a camera's own frame; surfaces nearer than 0.01 times `direction` are not
// seen. (An ommatidium's rays start its focal offset behind its position.)
void add_ray(Eye& eye, Vec3d origin, Vec3d direction) {
  const double near_limit = 0.01 * length(direction);
  const Vec3d axis = normalize(direction);
  eye.position_m.push_back(to_float(origin + axis * near_limit));
  eye.axis.push_back(to_float(axis));
  eye.acceptance_angle_rad.push_back(0);
  eye.focal_offset_m.push_back(static_cast<float>(near_limit));
  eye.eye_id.push_back(0);
}

// A pixel looks through its lower left corner, as in CompoundRay, whatever the shape of the frame.
Eye picture_eye(const CompatCamera& camera, int width, int height) {
  Eye eye;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double x = static_cast<double>(column) / width, y = static_cast<double>(row) / height;
      const double across = (2 * x - 1) * camera.scale_x, up = (2 * y - 1) * camera.scale_y;
      if (camera.type == CameraType::panoramic)
        add_ray(eye, {}, to_double(panoramic_direction(x, y)));
      else if (camera.type == CameraType::orthographic)
        add_ray(eye, {across, up, 0}, {0, 0, -1});
      else
        add_ray(eye, {}, {across, up, -1});
    }
  return eye;
}

// CompoundRay makes the rays of a panorama unit vectors in the world, so that the scale of the
// camera plays no part, not even in what is too near.
Mat4 without_scale(Mat4 pose) {
  const double scale = std::cbrt(std::fabs(determinant(pose)));
  if (scale > 0)
    for (auto& row : pose.m)
      for (int c = 0; c < 3; ++c) row[c] /= scale;
  return pose;
}

RenderSettings settings_for(const State& state, int samples) {
  RenderSettings settings;
  settings.footprints = false;  // CompoundRay reads textures point by point
  settings.sampling = Fixed{samples};
  settings.kernel = state.kernel;
  settings.points = Points::random;
  settings.noise = Noise::new_every_frame;
  return settings;
}

void render_picture(State& state, CompatCamera& camera) {
  Frame& frame = state.frame;
  if (!camera.renderer || camera.picture_width != frame.width ||
      camera.picture_height != frame.height) {
    camera.renderer.emplace(*state.world, picture_eye(camera, frame.width, frame.height),
                            settings_for(state, 1));
    camera.picture_width = frame.width, camera.picture_height = frame.height;
  }
  Mat4 pose = world_from_head(camera);
  if (camera.type == CameraType::panoramic) pose = without_scale(pose);
  std::vector<float> radiance(frame.pixels.size() * 3);
  camera.renderer->render({&pose, 1}, radiance);
  for (std::size_t i = 0; i < frame.pixels.size(); ++i)
    frame.pixels[i] = display_color(&radiance[3 * i]);
}

void render_eye(State& state, CompatCamera& camera) {
  CompoundEye& compound = camera.compound;
  std::vector<Rgba> colors;
  if (!shows_ids(compound.projection)) {
    const RenderSettings settings = settings_for(state, compound.samples);
    if (!camera.renderer)
      camera.renderer.emplace(*state.world, compound.eye, settings);
    else if (camera.renderer->settings().sampling != settings.sampling)
      camera.renderer = Renderer(*camera.renderer, compound.eye, settings);
    const Mat4 pose = world_from_head(camera);
    std::vector<float> responses(compound.eye.size() * 3), rays;
    RenderCall call;
    call.first_pose = state.frames_rendered++;  // other random samples each time
    if (compound.projection == Projection::raw_ommatidial_samples) {
      rays.resize(responses.size() * static_cast<std::size_t>(compound.samples));
      call.ray_radiance = rays;
    }
    camera.renderer->render({&pose, 1}, responses, call);
    if (!rays.empty()) return paint_raw_samples(state.frame, compound.samples, rays);
    for (std::size_t i = 0; i < compound.eye.size(); ++i)
      colors.push_back(display_color(&responses[3 * i]));
  }
  paint(state.frame, compound.projection, compound.eye, colors, camera.id_map);
}

}  // namespace

void render_frame(State& state) {
  CompatCamera& camera = current_camera(state);
  if (!state.world) throw Error("there is no scene to render; the frame stays as it was");
  if (camera.type == CameraType::compound)
    render_eye(state, camera);
  else
    render_picture(state, camera);
}

}  // namespace omma::compat
