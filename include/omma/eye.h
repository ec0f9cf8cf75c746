// An eye, or all eyes of a head, as a structure of arrays over ommatidia. The frame is that of the
// head: right-handed, +X right, +Y up, looking along -Z (glTF's camera frame). `.eye` files use
// x right, y up, z forward; the loader turns their z round.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "omma/vec.h"

namespace omma {

struct Eye {
  std::string path;                         // the file it came from, "" for one made in memory
  std::vector<Vec3> position_m;             // [ommatidium], nodal point, head frame
  std::vector<Vec3> axis;                   // [ommatidium], unit vector, head frame
  std::vector<float> acceptance_angle_rad;  // [ommatidium], full width at half maximum
  std::vector<float> focal_offset_m;        // [ommatidium], ray origin behind the position
  std::vector<std::int32_t> eye_id;         // [ommatidium], which eye of the head it belongs to

  std::size_t size() const { return axis.size(); }
};

// One eye and where it sits in the head.
struct PlacedEye {
  Eye eye;
  Mat4 head_from_eye;
};

// Checks array sizes and numbers and normalises the axes; throws omma::Error naming the place.
void validate_eye(Eye& eye);

// All eyes of a head as one; eye_id numbers them in the order given.
Eye merge_eyes(std::span<const PlacedEye> eyes);

// The ommatidia of one eye of a head.
Eye select_eye(const Eye& head, int eye_id);

// Local interommatidial angle of each ommatidium: the mean angle to its (up to) six nearest
// neighbours of the same eye. [ommatidium], rad; 0 where it has no neighbour.
std::vector<float> interommatidial_angle_rad(const Eye& eye);

// Azimuth and elevation of a direction in the head frame: azimuth 0 ahead (-Z), growing to the
// right (+X), in (-pi, pi]; elevation up from the horizon, in [-pi/2, pi/2].
Vec2 azimuth_elevation_rad(Vec3 direction);

}  // namespace omma
