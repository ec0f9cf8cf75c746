// CompoundRay's eight projections of an eye onto the frame: which ommatidium a pixel shows.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "frame.h"
#include "omma/eye.h"

namespace omma::compat {

enum class Projection : std::uint8_t {
  raw_ommatidial_samples,
  single_dimension,
  single_dimension_fast,
  spherical_orientationwise,
  spherical_orientationwise_ids,
  spherical_positionwise,
  spherical_positionwise_ids,
  spherical_split_orientationwise,
};

// By its name in CompoundRay; nothing for a name it has not.
std::optional<Projection> find_projection(const std::string& name);

// The ids in place of the ommatidia's colours: nothing needs to be rendered.
bool shows_ids(Projection projection);

// Direction of a pixel in the head frame: azimuth from -pi at the left edge to pi, elevation from
// -pi/2 at the bottom to pi/2; at the pixel's lower left corner, as in CompoundRay.
Vec3 panoramic_direction(double x, double y);  // pixel over width, pixel over height

// Which ommatidium each pixel of a spherical projection shows. Made once per eye and size.
struct IdMap {
  std::optional<Projection> projection;  // that it was made for
  int width = 0, height = 0;
  std::vector<std::int32_t> ids;  // [height][width], bottom row first
};

// Makes the map where it does not fit yet.
const std::vector<std::int32_t>& id_map_for(IdMap& map, const Eye& eye, Projection projection,
                                            int width, int height);

// Paints all projections but raw_ommatidial_samples. `colors` [ommatidium] may be empty for ids.
void paint(Frame& frame, Projection projection, const Eye& eye, std::span<const Rgba> colors,
           IdMap& map);

// Column: ommatidium, row: sample. `radiance` [ommatidium][sample][3].
void paint_raw_samples(Frame& frame, int samples, std::span<const float> radiance);

}  // namespace omma::compat
