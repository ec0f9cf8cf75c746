// The projections by name, and the pictures that are plain lists of ommatidia.
#include "omma/projection.h"

#include <string>

#include "omma/error.h"
#include "project/sites.h"

namespace omma {
namespace {

constexpr NamedProjection names[] = {
    {"single_dimension", Projection::single_dimension},
    {"single_dimension_fast", Projection::single_dimension_fast},
    {"raw_ommatidial_samples", Projection::raw_ommatidial_samples},
    {"spherical_orientationwise", Projection::spherical_orientationwise},
    {"spherical_positionwise", Projection::spherical_positionwise},
    {"spherical_split_orientationwise", Projection::spherical_split_orientationwise},
    {"cylindrical", Projection::cylindrical},
    {"mollweide", Projection::mollweide},
    {"lambert", Projection::lambert},
    {"hemisphere", Projection::hemisphere},
    {"facets", Projection::facets},
};

const char* name_of(Projection projection) {
  for (const NamedProjection& named : names)
    if (named.projection == projection) return named.name;
  throw Error("projection: there is none with the number " +
              std::to_string(static_cast<int>(projection)));
}

std::vector<std::int32_t> stretched_ids(const Eye& eye, int width, int height) {
  return fill_ids(width, height, [&](int column, int, std::int32_t&) {
    return static_cast<std::int32_t>(static_cast<std::int64_t>(column) *
                                     static_cast<std::int64_t>(eye.size()) / width);
  });
}

// Ommatidium i in column i of the first `rows` rows.
std::vector<std::int32_t> column_ids(const Eye& eye, Projection projection, int width, int height,
                                     int rows) {
  if (static_cast<std::size_t>(width) < eye.size())
    throw Error(std::string(name_of(projection)) +
                ": width must be at least the number of ommatidia, " + std::to_string(eye.size()) +
                ", is " + std::to_string(width));
  return fill_ids(width, height, [&](int column, int row, std::int32_t&) -> std::int32_t {
    return row < rows && static_cast<std::size_t>(column) < eye.size() ? column : -1;
  });
}

}  // namespace

std::span<const NamedProjection> named_projections() {
  return names;
}

Projection projection_from_name(std::string_view name) {
  std::string_view plain = name;
  if (plain.ends_with("_ids")) plain.remove_suffix(4);
  for (const NamedProjection& named : names)
    if (plain == named.name) return named.projection;
  std::string all;
  for (const NamedProjection& named : names)
    all += (all.empty() ? "" : ", ") + std::string(named.name);
  throw Error("projection: expected one of " + all + " (or one of them with _ids), found '" +
              std::string(name) + "'");
}

std::vector<std::int32_t> projection_ids(const Eye& eye, Projection projection, int width,
                                         int height) {
  check_picture(name_of(projection), eye, width, height);
  switch (projection) {
    case Projection::single_dimension:
      return stretched_ids(eye, width, height);
    case Projection::single_dimension_fast:
      return column_ids(eye, projection, width, height, 1);
    case Projection::raw_ommatidial_samples:
      return column_ids(eye, projection, width, height, height);
    case Projection::spherical_orientationwise:
      return equirectangular_ids(eye, width, height);
    case Projection::spherical_positionwise:
      return equirectangular_ids_by_position(eye, width, height);
    case Projection::spherical_split_orientationwise:
      return split_ids(eye, width, height);
    case Projection::cylindrical:
      return cylindrical_ids(eye, width, height);
    case Projection::mollweide:
      return mollweide_ids(eye, width, height);
    case Projection::lambert:
      return lambert_ids(eye, width, height);
    case Projection::hemisphere:
      return hemisphere_ids(eye, width, height);
    case Projection::facets:
      return facet_ids(eye, width, height);
  }
  return {};
}

}  // namespace omma
