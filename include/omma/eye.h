// An eye, or all eyes of a head, as a structure of arrays over ommatidia. The frame is that of the
// head: right-handed, +X right, +Y up, looking along -Z (glTF's camera frame). `.eye` files use
// x right, y up, z forward; the loader turns their z round.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "omma/receptor.h"
#include "omma/vec.h"

namespace omma {

// A property that Omma itself does not use, kept through reading and writing: numbers or texts.
struct EyeColumn {
  std::string name;
  std::vector<double> numbers;     // [ommatidium], or empty
  std::vector<std::string> texts;  // [ommatidium], or empty
};

// After validate_eye every array "[ommatidium]" has an entry for each one; before, those marked
// "or empty" may be left out.
struct Eye {
  std::string path;                         // the file it came from, "" for one made in memory
  std::vector<Vec3> position_m;             // [ommatidium], nodal point, head frame
  std::vector<Vec3> axis;                   // [ommatidium], unit vector, head frame
  std::vector<float> acceptance_angle_rad;  // [ommatidium], full width at half maximum; or empty: 0
  std::vector<float> focal_offset_m;        // [ommatidium], ray origin behind the position
  std::vector<std::int32_t> eye_id;         // [ommatidium], which eye of the head it belongs to

  // The reference for what is not round: unit vector across the axis. Empty: default_up.
  std::vector<Vec3> up;                 // [ommatidium] or empty
  std::vector<float> facet_diameter_m;  // [ommatidium] or empty; 0: not known
  // Rays start all over a disc of this diameter about the position, as in superposition eyes, where
  // many facets serve one rhabdom.
  std::vector<float> aperture_diameter_m;  // [ommatidium] or empty; 0: from the position

  // Angular sensitivities that are not a round Gaussian of acceptance_angle_rad, and which one an
  // ommatidium has; acceptance_angle_rad is then its mean width, found by validate_eye where 0.
  std::vector<Acceptance> acceptances;
  std::vector<std::int32_t> acceptance_of;  // [ommatidium] or empty; -1: that Gaussian

  // Receptors: those of ommatidium i are first_receptor[i] to first_receptor[i + 1]. Empty: none
  // are described.
  std::vector<ReceptorType> receptor_types;
  std::vector<std::int32_t> first_receptor;  // [ommatidium + 1] or empty
  std::vector<std::int32_t> receptor_type;   // [receptor], index into receptor_types

  std::vector<EyeColumn> columns;

  std::size_t size() const { return axis.size(); }
};

// One eye and where it sits in the head.
struct PlacedEye {
  Eye eye;
  Mat4 head_from_eye;
};

// Checks array sizes and numbers, normalises the axes, makes the up vectors perpendicular to them
// and fills what is empty; throws omma::Error naming the place.
void validate_eye(Eye& eye);

// The up vector of an ommatidium of which nothing else is known: up in the head frame, across the
// axis; where it looks straight up, backwards.
Vec3 default_up(Vec3 axis);

// The angular sensitivity of an ommatidium of a validated eye.
Acceptance acceptance_at(const Eye& eye, std::size_t ommatidium);

// All eyes of a head as one; eye_id numbers them in the order given. A transform moves and scales
// positions, facets and apertures; angular sensitivities stay as they are. One that mirrors turns
// them over with the eye.
Eye merge_eyes(std::span<const PlacedEye> eyes);

// The ommatidia with these indices, in this order; eye_id stays.
Eye take_ommatidia(const Eye& eye, std::span<const std::int64_t> ommatidia);

// The ommatidia of one eye of a head.
Eye select_eye(const Eye& head, int eye_id);

// Local interommatidial angle of each ommatidium: the mean angle to its (up to) six nearest
// neighbours of the same eye. [ommatidium], rad; 0 where it has no neighbour.
std::vector<float> interommatidial_angle_rad(const Eye& eye);

// Azimuth and elevation of a direction in the head frame: azimuth 0 ahead (-Z), growing to the
// right (+X), in (-pi, pi]; elevation up from the horizon, in [-pi/2, pi/2].
Vec2 azimuth_elevation_rad(Vec3 direction);

}  // namespace omma
