// Pictures of responses. They only read responses; nothing here traces a ray.
#pragma once

#include <cstdint>
#include <span>
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

// Which ommatidium each pixel of an equirectangular picture shows: the one whose axis is nearest
// in angle (ties to the lower index). Azimuth -180 to 180 degrees from left to right with straight
// ahead in the middle and the animal's right to the right; elevation +90 at the top, -90 at the
// bottom. [height][width], index into the eye; -1 where the nearest axis is farther than
// `max_angle_rad`.
std::vector<std::int32_t> equirectangular_ids(const Eye& eye, int width, int height,
                                              float max_angle_rad = 7.0f);

// The same by position instead of axis: the ommatidium whose position, seen from the centroid of
// all positions, lies nearest in angle.
std::vector<std::int32_t> equirectangular_ids_by_position(const Eye& eye, int width, int height,
                                                          float max_angle_rad = 7.0f);

// 8-bit RGB picture of one pose's responses [ommatidium][channel] through an id map; -1 is painted
// mid grey. Display value = 255 * clamp(response)^(1/gamma).
std::vector<std::uint8_t> paint(std::span<const std::int32_t> ids, std::span<const float> responses,
                                double gamma = 2.2);

}  // namespace omma
