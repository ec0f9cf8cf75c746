// The rays of perspective, orthographic and panoramic cameras, and which camera is meant.
#include "omma/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "model/camera_check.h"
#include "model/pose_check.h"
#include "model/text.h"
#include "omma/error.h"

namespace omma {
namespace {

constexpr double aspect_where_none_is_given = 4.0 / 3.0;
constexpr int width_where_none_is_given = 1024;

double natural_aspect(const Camera& camera) {
  switch (camera.type) {
    case CameraType::perspective:
      return camera.aspect_ratio > 0 ? camera.aspect_ratio : aspect_where_none_is_given;
    case CameraType::orthographic:
      return std::fabs(camera.xmag_m / camera.ymag_m);
    case CameraType::panoramic:
    case CameraType::compound:
      break;
  }
  return 2;
}

void check_extent(int extent, int least, const char* what) {
  if (extent < least || extent > max_picture_extent)
    throw Error(std::string(what) + ": expected " + std::to_string(least) + " to " +
                std::to_string(max_picture_extent) + " pixels, found " + std::to_string(extent));
}

int extent_from(double pixels) {
  // A camera of no height or width at all, or a negligible one, still gets a row of pixels.
  if (!(pixels < max_picture_extent)) return max_picture_extent;
  return std::max(1, static_cast<int>(std::lround(pixels)));
}

}  // namespace

void check_picture_camera(const Camera& camera) {
  const auto refuse = [&](const std::string& why) {
    throw Error("camera \"" + camera.name + "\": " + why);
  };
  const std::string fault = pose_fault(camera.world_from_camera);
  if (!fault.empty()) refuse("its transform: " + fault);
  double reach_m = 0;
  for (int r = 0; r < 3; ++r)
    reach_m = std::max(reach_m, std::fabs(camera.world_from_camera.m[r][3]));
  if (camera.type == CameraType::orthographic)
    reach_m += most_stretch(camera.world_from_camera) *
               std::max(std::fabs(camera.xmag_m), std::fabs(camera.ymag_m));
  if (reach_m > most_distance_m)
    refuse("its rays must start within 1e18 m of the origin, start up to " + short_text(reach_m) +
           " m from it");
  switch (camera.type) {
    case CameraType::perspective:
      if (!(camera.yfov_rad > 0 && camera.yfov_rad < pi))
        refuse("its yfov must lie between 0 and pi, is " + short_text(camera.yfov_rad));
      if (!(camera.aspect_ratio >= 0) || !std::isfinite(camera.aspect_ratio))
        refuse("its aspect ratio must not be negative, is " + short_text(camera.aspect_ratio));
      return;
    case CameraType::orthographic:
      for (const double mag : {camera.xmag_m, camera.ymag_m})
        if (!std::isfinite(mag) || mag == 0)
          refuse("its xmag and ymag must be finite and not 0, are " + short_text(camera.xmag_m) +
                 " and " + short_text(camera.ymag_m));
      return;
    case CameraType::panoramic:
      return;
    case CameraType::compound:
      refuse("is a compound eye: its picture is a projection of what that eye sees");
  }
}

PictureSize picture_size(const Camera& camera, int width, int height) {
  check_extent(width, 0, "width");
  check_extent(height, 0, "height");
  const double aspect = natural_aspect(camera);
  if (width == 0 && height == 0) width = width_where_none_is_given;
  if (width == 0) width = extent_from(height * aspect);
  if (height == 0) height = extent_from(width / aspect);
  return {width, height};
}

CameraRay camera_ray(const Camera& camera, PictureSize size, double x, double y) {
  // From -1 at the left and the bottom to 1 at the right and the top.
  const double right = 2 * x / size.width - 1, up = 1 - 2 * y / size.height;
  switch (camera.type) {
    case CameraType::perspective: {
      const double aspect =
          camera.aspect_ratio > 0 ? camera.aspect_ratio : double(size.width) / size.height;
      const double half_height = std::tan(camera.yfov_rad / 2);
      return {{0, 0, 0}, normalize({right * aspect * half_height, up * half_height, -1})};
    }
    case CameraType::orthographic:
      return {{right * camera.xmag_m, up * camera.ymag_m, 0}, {0, 0, -1}};
    case CameraType::panoramic:
    case CameraType::compound:
      break;
  }
  const double azimuth = right * pi, elevation = up * pi / 2;
  return {{0, 0, 0},
          {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
           -std::cos(azimuth) * std::cos(elevation)}};
}

void add_camera_ray(Eye& eye, const CameraRay& ray) {
  eye.position_m.push_back(to_float(ray.origin_m));
  eye.axis.push_back(to_float(ray.direction));
  eye.acceptance_angle_rad.push_back(0);
  eye.focal_offset_m.push_back(0);
  eye.eye_id.push_back(0);
}

Eye camera_rays(const Camera& camera, PictureSize size, int first_row, int rows,
                Vec2 within_pixel) {
  check_picture_camera(camera);
  check_extent(size.width, 1, "width");
  check_extent(size.height, 1, "height");
  if (first_row < 0 || rows < 1 || rows > size.height - first_row)
    throw Error("rows: expected some of the " + std::to_string(size.height) +
                " rows of the picture, found " + std::to_string(rows) + " from row " +
                std::to_string(first_row));
  Eye eye;
  for (int row = first_row; row < first_row + rows; ++row)
    for (int column = 0; column < size.width; ++column)
      add_camera_ray(eye, camera_ray(camera, size, column + double(within_pixel.x),
                                     row + double(within_pixel.y)));
  return eye;
}

const Camera& choose_camera(const Scene& scene, std::string_view name_or_index) {
  const auto is_called_so = [&](const Camera& camera) {
    return camera.name == name_or_index || camera.data_name == name_or_index;
  };
  std::size_t index = 0;
  const char* end = name_or_index.data() + name_or_index.size();
  const auto [stop, failure] = std::from_chars(name_or_index.data(), end, index);
  const bool is_number = failure == std::errc() && stop == end;
  if (is_number && index < scene.cameras.size() &&
      std::none_of(scene.cameras.begin(), scene.cameras.end(), is_called_so))
    return scene.cameras[index];
  return find_camera(scene, name_or_index);
}

}  // namespace omma
