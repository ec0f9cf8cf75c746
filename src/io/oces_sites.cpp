// Where the ommatidia of surface and spherical eyes sit. The standard gives a count and the facets'
// diameters over the surface, and leaves the placing to the reader. Here: many candidates, as many
// in an area as facets of that diameter fill it; the first is taken, then always the one furthest
// from those taken, distances counted in diameters (Eldar et al. 1997, farthest point sampling).
#include <algorithm>
#include <cmath>
#include <limits>

#include "io/csv_text.h"
#include "io/gltf_schema.h"
#include "io/oces_file.h"
#include "omma/error.h"
#include "threads/cancel.h"

namespace omma {

using nlohmann::json;

namespace {

constexpr std::uint64_t most_ommatidia = 200000;

struct Triangle {
  std::array<OcesSite, 3> corner;
};

std::size_t ommatidial_count(const json& eye, const std::string& place) {
  const json* value = oces_member(eye, "ommatidialCount");
  const std::uint64_t count = value == nullptr ? 0 : gltf_whole_number(*value).value_or(0);
  if (count < 1 || count > most_ommatidia)
    throw Error(place + ": ommatidialCount: expected a whole number from 1 to " +
                std::to_string(most_ommatidia) + ", found " +
                (value == nullptr ? "none" : shown_text(value->dump(-1, ' ', true))));
  return count;
}

// A point in a triangle by its barycentric weights.
OcesSite inside(const Triangle& triangle, double a, double b, double c) {
  const auto& [p, q, r] = triangle.corner;
  OcesSite site;
  site.position_m = p.position_m * a + q.position_m * b + r.position_m * c;
  site.normal = p.normal * a + q.normal * b + r.normal * c;
  site.vertex = {p.vertex[0], q.vertex[0], r.vertex[0]};
  site.weight = {a, b, c};
  site.u = p.u * a + q.u * b + r.u * c;
  site.v = p.v * a + q.v * b + r.v * c;
  return site;
}

double area(const Triangle& t) {
  return length(cross(t.corner[1].position_m - t.corner[0].position_m,
                      t.corner[2].position_m - t.corner[0].position_m)) /
         2;
}

double diameter_at(const OcesProperty& property, const OcesSite& site) {
  const double diameter_m = oces_scalar(property, site);
  if (!(diameter_m > 0) || !std::isfinite(diameter_m))
    throw Error(property.place + ": expected diameters above 0, found " +
                std::to_string(diameter_m));
  return diameter_m;
}

// Small pieces of triangles and how many facets fit into each, cumulated.
struct Pieces {
  const std::vector<Triangle>& triangles;
  std::size_t rows = 1;         // a triangle is cut into rows * rows pieces
  std::vector<double> up_to{};  // [piece], room of this and all before

  // A point of a piece; x and y from 0 to 1.
  OcesSite point(std::size_t piece, double x, double y) const {
    const std::size_t in_triangle = piece % (rows * rows);
    auto row = static_cast<std::size_t>(std::sqrt(static_cast<double>(in_triangle)));
    while (row * row > in_triangle) --row;
    while ((row + 1) * (row + 1) <= in_triangle) ++row;
    const std::size_t k = in_triangle - row * row;  // upright and upside down in turn
    if (x + y > 1) x = 1 - x, y = 1 - y;
    const auto r = static_cast<double>(row), j = static_cast<double>(k / 2),
               n = static_cast<double>(rows);
    double b = 0, c = 0;  // weights of the second and third corner
    if (k % 2 == 0) {
      b = r - j + x, c = j + y;
    } else {
      b = r - j - x, c = j + 1 - y;
    }
    return inside(triangles[piece / (rows * rows)], 1 - (b + c) / n, b / n, c / n);
  }
};

Pieces cut(const std::vector<Triangle>& triangles, const OcesProperty& diameter) {
  constexpr double enough = 20000;
  Pieces pieces{triangles};
  pieces.rows = static_cast<std::size_t>(
      std::ceil(std::sqrt(enough / static_cast<double>(triangles.size()))));
  const std::size_t each = pieces.rows * pieces.rows;
  double sum = 0;
  for (std::size_t piece = 0; piece < triangles.size() * each; ++piece) {
    check_cancelled();
    const double d = diameter_at(diameter, pieces.point(piece, 1.0 / 3, 1.0 / 3));
    sum += area(triangles[piece / each]) / static_cast<double>(each) / (d * d);
    pieces.up_to.push_back(sum);
  }
  return pieces;
}

// Candidates that lie near each other in the list.
struct Group {
  std::size_t begin, end;
  Vec3d center;
  double radius = 0, largest_diameter = 0;
  double furthest = std::numeric_limits<double>::infinity();
  std::size_t which = 0;  // the candidate that is the furthest
};

std::vector<OcesSite> spread(const std::vector<OcesSite>& candidates,
                             const std::vector<double>& diameter_m, std::size_t count) {
  constexpr std::size_t group_size = 128;
  std::vector<Group> groups;
  for (std::size_t begin = 0; begin < candidates.size(); begin += group_size) {
    Group group{begin, std::min(begin + group_size, candidates.size()), {}};
    for (std::size_t i = begin; i < group.end; ++i)
      group.center = group.center + candidates[i].position_m;
    group.center = group.center * (1.0 / static_cast<double>(group.end - begin));
    for (std::size_t i = begin; i < group.end; ++i) {
      group.radius = std::max(group.radius, length(candidates[i].position_m - group.center));
      group.largest_diameter = std::max(group.largest_diameter, diameter_m[i]);
    }
    group.which = begin;
    groups.push_back(group);
  }
  // Of each candidate the distance to the nearest one taken, in mean diameters of the two.
  std::vector<double> distance(candidates.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> taken;
  while (taken.size() < count) {
    check_cancelled();
    const Group& best =
        *std::max_element(groups.begin(), groups.end(),
                          [](const Group& a, const Group& b) { return a.furthest < b.furthest; });
    const std::size_t pick = best.which;
    taken.push_back(pick);
    const Vec3d at = candidates[pick].position_m;
    for (Group& group : groups) {
      const double nearest = (length(at - group.center) - group.radius) * 2 /
                             (diameter_m[pick] + group.largest_diameter);
      if (nearest > group.furthest) continue;
      group.furthest = -1;
      for (std::size_t i = group.begin; i < group.end; ++i) {
        const double d =
            length(at - candidates[i].position_m) * 2 / (diameter_m[pick] + diameter_m[i]);
        distance[i] = i == pick ? -1 : std::min(distance[i], d);
        if (distance[i] > group.furthest) {
          group.furthest = distance[i];
          group.which = i;
        }
      }
    }
  }
  std::sort(taken.begin(), taken.end());  // neighbours near each other, as their candidates are
  std::vector<OcesSite> sites;
  for (const std::size_t i : taken) sites.push_back(candidates[i]);
  return sites;
}

// `finish` moves a point of a flat triangle to where it belongs.
template <typename Finish>
std::vector<OcesSite> place(const std::vector<Triangle>& triangles, const OcesProperty& diameter,
                            std::size_t count, const std::string& where, Finish finish) {
  const Pieces pieces = cut(triangles, diameter);
  const double room = pieces.up_to.back();
  if (!(room > 0) || !std::isfinite(room)) throw Error(where + ": its surface has no area");
  const std::size_t candidate_count = std::max<std::size_t>(12 * count, 2000);
  std::vector<OcesSite> candidates;
  std::vector<double> diameter_m;
  for (std::size_t k = 0; k < candidate_count; ++k) {
    check_cancelled();
    const auto index = static_cast<double>(k);
    const double at = (index + 0.5) / static_cast<double>(candidate_count) * room;
    const auto found = std::lower_bound(pieces.up_to.begin(), pieces.up_to.end() - 1, at);
    // Additive recurrence of the plastic number (Roberts 2018): even in every stretch.
    constexpr double plastic = 1.32471795724474602596;
    const double x = std::fmod(0.5 + index / plastic, 1.0),
                 y = std::fmod(0.5 + index / (plastic * plastic), 1.0);
    OcesSite site = pieces.point(static_cast<std::size_t>(found - pieces.up_to.begin()), x, y);
    finish(site);
    candidates.push_back(site);
    diameter_m.push_back(diameter_at(diameter, site));
  }
  return spread(candidates, diameter_m, count);
}

struct Attribute {
  std::vector<double> values;
  std::uint64_t count = 0;
};

Attribute read_attribute(OcesFile& file, const json& surface, const char* name,
                         std::size_t components, const std::string& place) {
  const std::string where = place + ": surface." + name;
  const json* index = oces_member(surface, name);
  if (index == nullptr) throw Error(where + ": is missing, expected an accessor");
  GltfAccessor accessor;
  Attribute attribute;
  attribute.values = read_oces_accessor(file, *index, accessor, where);
  attribute.count = accessor.count;
  if (accessor.components != components || accessor.matrix)
    throw Error(where + ": expected " + std::to_string(components) + " numbers for each, found " +
                std::to_string(accessor.components));
  return attribute;
}

// Indices of three corners a triangle, each below `count`.
std::vector<std::uint32_t> read_corners(OcesFile& file, const json& surface, const char* name,
                                        std::size_t count, const std::string& place) {
  const Attribute indices = read_attribute(file, surface, name, 1, place);
  if (indices.count % 3 != 0)
    throw Error(place + ": surface." + name + ": expected three indices for each triangle, found " +
                std::to_string(indices.count));
  std::vector<std::uint32_t> corners;
  for (const double index : indices.values) {
    if (!(index >= 0 && index < static_cast<double>(count)) || index != std::floor(index))
      throw Error(place + ": surface." + name + ": expected indices below " +
                  std::to_string(count) + ", found " + decimal_text(index));
    corners.push_back(static_cast<std::uint32_t>(index));
  }
  return corners;
}

Vec3d vector_at(const Attribute& attribute, std::size_t i) {
  return {attribute.values[3 * i], attribute.values[3 * i + 1], attribute.values[3 * i + 2]};
}

const OcesProperty& diameter_of(const OcesProperties& properties, const std::string& place) {
  const auto found = properties.find("DIAMETER");
  if (found == properties.end()) throw Error(place + ": ommatidialProperties.DIAMETER: is missing");
  return found->second;
}

// Latitude and longitude as texture coordinates: +Z in the middle, +Y at the top; as a map seen
// from outside, +X to the right of the middle.
void set_map_coordinates(OcesSite& site) {
  const Vec3d d = normalize(site.normal);
  site.u = 0.5 + std::atan2(d.x, d.z) / (2 * pi);
  site.v = 0.5 - std::asin(std::clamp(d.y, -1.0, 1.0)) / pi;
}

}  // namespace

std::vector<OcesSite> oces_surface_sites(OcesFile& file, const json& eye,
                                         const OcesProperties& properties,
                                         const std::string& where) {
  const std::size_t count = ommatidial_count(eye, where);
  const json* surface = oces_member(eye, "surface");
  if (surface == nullptr || !surface->is_object())
    throw Error(where + ": surface: is missing, expected an object");
  const Attribute position = read_attribute(file, *surface, "POSITION", 3, where);
  const Attribute normal = read_attribute(file, *surface, "NORMAL", 3, where);
  const auto vertices = static_cast<std::size_t>(position.count);
  if (normal.count != position.count)
    throw Error(where + ": surface.NORMAL: expected as many as POSITION (" +
                std::to_string(vertices) + "), found " + std::to_string(normal.count));
  for (const auto& [name, property] : properties)
    if (!property.coarse && property.image == nullptr && oces_element_count(property) != vertices)
      throw Error(property.place + ": expected a value for each of the " +
                  std::to_string(vertices) + " vertices of the surface, found " +
                  std::to_string(oces_element_count(property)));
  const std::vector<std::uint32_t> corners =
      read_corners(file, *surface, "INDICES", vertices, where);

  const bool has_map = surface->contains("TEXTURE_COORD");
  if (has_map != surface->contains("TEXTURE_INDICES"))
    throw Error(where +
                ": surface: expected TEXTURE_COORD and TEXTURE_INDICES together, found one");
  Attribute map;
  std::vector<std::uint32_t> map_corners;
  if (has_map) {
    map = read_attribute(file, *surface, "TEXTURE_COORD", 2, where);
    map_corners =
        read_corners(file, *surface, "TEXTURE_INDICES", static_cast<std::size_t>(map.count), where);
    if (map_corners.size() != corners.size())
      throw Error(where + ": surface.TEXTURE_INDICES: expected as many as INDICES (" +
                  std::to_string(corners.size()) + "), found " +
                  std::to_string(map_corners.size()));
  } else {
    for (const auto& [name, property] : properties)
      if (property.image != nullptr)
        throw Error(property.place + ": a texture needs surface.TEXTURE_COORD, which is missing");
  }

  file.gltf.budget.spend(corners.size() / 3, sizeof(Triangle) + sizeof(double));
  std::vector<Triangle> triangles(corners.size() / 3);
  for (std::size_t t = 0; t < corners.size(); ++t) {
    OcesSite& corner = triangles[t / 3].corner[t % 3];
    corner.vertex[0] = corners[t];
    corner.position_m = vector_at(position, corners[t]);
    corner.normal = vector_at(normal, corners[t]);
    if (!has_map) continue;
    corner.u = map.values[2 * map_corners[t]];
    corner.v = map.values[2 * map_corners[t] + 1];
  }
  return place(triangles, diameter_of(properties, where), count, where, [](OcesSite&) {});
}

std::vector<OcesSite> oces_sphere_sites(const json& eye, const OcesProperties& properties,
                                        const std::string& where) {
  const std::size_t count = ommatidial_count(eye, where);
  const json* given = oces_member(eye, "radius");
  const double radius_m = given == nullptr ? 1 : oces_number(*given, where + ": radius");
  if (radius_m < 0)
    throw Error(where + ": radius: expected at least 0, found " + std::to_string(radius_m));
  // An octahedron, cut finer and blown up to the unit sphere at each step.
  std::vector<Triangle> triangles;
  for (int octant = 0; octant < 8; ++octant) {
    Triangle triangle;
    triangle.corner[0].position_m = {octant & 1 ? -1.0 : 1.0, 0, 0};
    triangle.corner[1].position_m = {0, octant & 2 ? -1.0 : 1.0, 0};
    triangle.corner[2].position_m = {0, 0, octant & 4 ? -1.0 : 1.0};
    triangles.push_back(triangle);
  }
  for (int level = 0; level < 5; ++level) {
    std::vector<Triangle> finer;
    for (const Triangle& t : triangles) {
      const auto middle = [&](std::size_t a, std::size_t b) {
        OcesSite site;
        site.position_m = normalize(t.corner[a].position_m + t.corner[b].position_m);
        return site;
      };
      const OcesSite ab = middle(0, 1), bc = middle(1, 2), ca = middle(2, 0);
      finer.insert(finer.end(), {{{t.corner[0], ab, ca}},
                                 {{ab, t.corner[1], bc}},
                                 {{ca, bc, t.corner[2]}},
                                 {{ab, bc, ca}}});
    }
    triangles = std::move(finer);
  }
  for (Triangle& triangle : triangles) {
    Vec3d middle{};
    for (const OcesSite& corner : triangle.corner) middle = middle + corner.position_m;
    for (OcesSite& corner : triangle.corner) {
      corner.normal = middle;  // for the map coordinates of the whole small triangle
      set_map_coordinates(corner);
      corner.normal = corner.position_m;
    }
  }
  std::vector<OcesSite> sites =
      place(triangles, diameter_of(properties, where), count, where, [](OcesSite& site) {
        site.position_m = site.normal = normalize(site.position_m);
        set_map_coordinates(site);
      });
  for (OcesSite& site : sites) site.position_m = site.position_m * radius_m;
  return sites;
}

}  // namespace omma
