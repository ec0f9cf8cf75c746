// What making pictures shares with making rays.
#pragma once

#include "omma/camera.h"

namespace omma {

// Throws omma::Error where a camera has no picture: a compound one, or numbers without sense.
void check_picture_camera(const Camera& camera);

// Appends a single ray to an eye: an ommatidium of acceptance angle 0.
void add_camera_ray(Eye& eye, const CameraRay& ray);

}  // namespace omma
