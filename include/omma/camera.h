// Pictures through a scene's perspective, orthographic and panoramic cameras. A picture is an eye
// with one ommatidium of acceptance angle 0 per ray. A compound camera has no picture of its own:
// its eye is rendered and projected (projection.h).
//
//   perspective   half the height is tan(yfov / 2) at distance 1, half the width aspect times that
//                 (glTF 2.0, 3.10.3), whatever the shape of the pixels; without an aspect ratio
//                 that of the picture counts, and pixels are square.
//   orthographic  xmag and ymag are half the width and half the height (glTF 2.0, 3.10.2); rays
//                 start in the camera's plane.
//   panoramic     equirectangular: straight ahead in the middle, the right to the right, up at the
//                 top, 360 x 180 degrees.
//
// The camera node's whole transform applies, its scale too. znear and zfar cut nothing off: like
// an eye, a camera sees everything in front of it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "omma/eye.h"
#include "omma/render.h"
#include "omma/scene.h"
#include "omma/vec.h"
#include "omma/world.h"

namespace omma {

inline constexpr int max_picture_extent = 1 << 15;  // pixels, of either side

struct PictureSize {
  int width = 0, height = 0;  // pixels
};

// A size in which the camera's pixels are square: the width and height given, or the one that
// follows from the other (0: not given), or 1024 pixels wide. A perspective camera without an
// aspect ratio is 4 to 3; a compound one, for its projection, is 2 to 1 like a panoramic one.
// Throws omma::Error on an extent below 0 or above max_picture_extent.
PictureSize picture_size(const Camera& camera, int width = 0, int height = 0);

struct CameraRay {
  Vec3d origin_m, direction;  // camera frame; the direction is a unit vector
};

// The ray through a point of the picture: x from 0 at its left edge to `size.width` at its right
// one, y from 0 at the top to `size.height` at the bottom.
CameraRay camera_ray(const Camera& camera, PictureSize size, double x, double y);

// An eye with one ommatidium per pixel of `rows` rows of the picture, [row][column], each a single
// ray through a point of its pixel, (0, 0) the upper left corner of that. Camera frame: render it
// at the pose camera.world_from_camera. Throws omma::Error on a compound camera, one whose
// projection makes no sense, or rows outside the picture.
Eye camera_rays(const Camera& camera, PictureSize size, int first_row, int rows,
                Vec2 within_pixel = {0.5f, 0.5f});

struct CameraSettings {
  PictureSize size;
  // Rays per pixel, 1 to max_samples. One goes through the middle; more are spread over the pixel
  // (Owen-scrambled Sobol points, shifted from pixel to pixel) and all count alike.
  int samples = 16;
  std::uint64_t seed = 0;
};

// The mean radiance in each pixel: picture [row][column][band], linear float32, never clipped;
// row 0 is the top. The same inputs and seed give the same bits whatever the number of threads. The
// world keeps the rays of its last picture: the next one of the same kind of camera, size, samples
// and seed, wherever that camera is, takes them up. `progress` is called from the calling thread
// several times a second with the finished fraction (0 to 1); false cancels. Throws omma::Error as
// camera_rays does, on a picture of the wrong size, and while things are being moved in the world;
// omma::Cancelled when the progress callback says so.
void render_camera(const World& world, const Camera& camera, const CameraSettings& settings,
                   std::span<float> picture, const std::function<bool(double)>& progress = {});

// The camera of that name as find_camera has it or, where none has it and it is a number, the
// camera with that index. Throws omma::Error that lists both.
const Camera& choose_camera(const Scene& scene, std::string_view name_or_index);

}  // namespace omma
