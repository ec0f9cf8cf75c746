// Pictures of responses. They only read responses; nothing here traces a ray.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "omma/eye.h"

namespace omma {

// The ommatidium whose axis is nearest in angle to each direction (head frame, of any length); ties
// go to the lower index. [direction], index into the eye; -1 for a direction that is zero or not
// finite, and for all of them where the eye is empty.
std::vector<std::int32_t> nearest_by_axis(const Eye& eye, std::span<const Vec3> directions);

// The same by position as seen from `centre` (m, head frame). An ommatidium at the centre lies in
// no direction and is never nearest; where all lie there, every id is -1.
std::vector<std::int32_t> nearest_by_position(const Eye& eye, Vec3 centre,
                                              std::span<const Vec3> directions);

// How an eye is laid out in a picture. All pictures are of what the animal sees: its right to the
// right, up at the top; pixels are sampled at their centres. docs/looking-at-eyes.md shows
// them all.
enum class Projection : std::uint8_t {
  // Those of CompoundRay. They fill the whole picture.
  single_dimension,           // ommatidia in order from left to right, stretched to the width
  single_dimension_fast,      // ommatidium i in column i of the top row; nothing below
  raw_ommatidial_samples,     // ommatidium i in column i of all rows, row s for its ray s
  spherical_orientationwise,  // equirectangular: azimuth -180 to 180 degrees from left to right
                              // with straight ahead in the middle, elevation 90 at the top to -90;
                              // the ommatidium whose axis is nearest in angle
  spherical_positionwise,     // the same by position, as seen from the centroid of all positions
  spherical_split_orientationwise,  // two equirectangular pictures side by side: left the ommatidia
                                    // at x <= 0, right those at x >= 0
  // Ours. -1 outside the visual field: farther from the nearest axis than the interommatidial or
  // the acceptance angle there, whichever is larger.
  cylindrical,  // semi-orthogonal: azimuth of the axis from left to right as above (0 for one that
                // is straight up or down), against height of the position on the eye, the highest
                // at the top edge, the lowest at the bottom
  mollweide,    // the whole sphere in an ellipse, straight ahead in the middle; equal-area
  lambert,      // the whole sphere in a disc, straight ahead in the middle and straight behind all
                // around the rim; equal-area
  hemisphere,   // two discs: the left hemisphere as the eyes on the left see it, the right one as
                // those on the right do. Straight ahead is where the discs meet; equal-area
  facets,       // the surface of each eye from within, the eye that looks farthest left on the
                // left, all to one scale: each ommatidium is its own Voronoi cell on the sphere
                // through the eye's positions, laid flat around its middle, equal-area. By
                // position alone, so that skewed axes tear nothing
};

// The name of each projection, as CompoundRay and glTF files have it.
struct NamedProjection {
  const char* name;
  Projection projection;
};
std::span<const NamedProjection> named_projections();

// The projection of that name; the ending `_ids`, with which a picture shows ids instead of
// responses (encode_ids), is allowed and ignored. Throws omma::Error that lists the names.
Projection projection_from_name(std::string_view name);

// Which ommatidium each pixel shows: [height][width], index into the eye, -1 for none. Ellipses and
// discs are the largest that fit the size; the other projections are stretched to it but facets,
// which stay in proportion. Ties go to the lower index.
//
// Eyes are told apart by eye_id; a single one whose positions leave a wide gap around x = 0, as
// when one file holds both eyes, counts as a left and a right one.
//
// Throws omma::Error on an empty eye; a size that makes no sense or, for single_dimension_fast and
// raw_ommatidial_samples, is less wide than there are ommatidia; an eye that is one point
// (spherical_positionwise), has no height (cylindrical) or no surface (facets).
std::vector<std::int32_t> projection_ids(const Eye& eye, Projection projection, int width,
                                         int height);

// spherical_orientationwise and spherical_positionwise with -1 where the nearest ommatidium is
// farther than `max_angle_rad`.
std::vector<std::int32_t> equirectangular_ids(const Eye& eye, int width, int height,
                                              float max_angle_rad = 7.0f);
std::vector<std::int32_t> equirectangular_ids_by_position(const Eye& eye, int width, int height,
                                                          float max_angle_rad = 7.0f);

// spherical_orientationwise with -1 outside the visual field.
std::vector<std::int32_t> field_ids(const Eye& eye, int width, int height);

// The visual field of each eye of a head in a panel of its own, as field_ids draws it, next to each
// other: the eye that looks farthest to the left on the left. [height][eyes * width], index into
// the head.
std::vector<std::int32_t> side_by_side_ids(const Eye& eye, int width, int height);

// 8-bit RGB picture of one pose's responses [ommatidium][channel] through an id map; -1 is painted
// mid grey. Display value = 255 * clamp(response)^(1/gamma).
std::vector<std::uint8_t> paint(std::span<const std::int32_t> ids, std::span<const float> responses,
                                double gamma = 2.2);

// RGBA picture of an id map, 4 bytes per pixel: the id as a 32-bit number, its highest byte in R,
// its lowest in A, as CompoundRay's `_ids` projections have it. -1 is 255, 255, 255, 255.
std::vector<std::uint8_t> encode_ids(std::span<const std::int32_t> ids);

}  // namespace omma
