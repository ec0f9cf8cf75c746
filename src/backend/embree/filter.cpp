// Which candidates count: those that are seen at all, and behind surfaces that let light through
// those that the ray has not passed yet.
#include "backend/embree/filter.h"

#include "physics/surface.h"

namespace omma {
namespace {

// A hit this near to an edge, in barycentric weight, may be one of the neighbour too: watertight
// intersection counts both where a weight is within float's resolution of zero.
constexpr float on_edge = 1e-6f;

bool is_on_edge(float u, float v) {
  return u < on_edge || v < on_edge || u + v > 1 - on_edge;
}

struct Triangle {
  Vec3d corner[3];
};

Triangle triangle_of(const FilterData& data, unsigned index) {
  Triangle t;
  for (std::size_t k = 0; k < 3; ++k)
    t.corner[k] = to_double(data.position_m[data.triangles[index][k]]);
  return t;
}

// Whether a triangle that is hit on its edge covers what a ray sees that is moved a little. Where
// the first surface reaches to: a point well inside it, in no special place.
bool covers(const Triangle& t, float u, float v, Vec3d direction, Vec3d move) {
  const Vec3d e1 = t.corner[1] - t.corner[0], e2 = t.corner[2] - t.corner[0];
  const Vec3d p = cross(direction, e2);
  const double volume = dot(e1, p);
  if (volume == 0) return true;  // seen edge on
  // How the weights change (Moeller and Trumbore 1997).
  const double du = dot(move, p) / volume, dv = dot(direction, cross(move, e1)) / volume;
  return (u >= on_edge || du > 0) && (v >= on_edge || dv > 0) &&
         (u + v <= 1 - on_edge || du + dv < 0);
}

// A ray that hits an edge or a corner meets all the triangles about it, which are one surface and
// count once, while triangles that lie upon each other are several. So of those hit on an edge
// after a first one only those count that cover what it covers, as the ray sees it.
bool is_neighbour(const RTCFilterFunctionNArguments& args, unsigned i, const PassedSurface& first) {
  const auto& data = *static_cast<const FilterData*>(args.geometryUserPtr);
  const FilterData* first_data = &data;
  if (first.geometry != RTCHitN_geomID(args.hit, args.N, i)) {
    if (first.instance != RTC_INVALID_GEOMETRY_ID) return false;
    first_data = data.tracer->filter_of[first.geometry];
  }
  const Triangle a = triangle_of(*first_data, first.triangle);
  const double inside[3] = {0.5, 0.3, 0.2};
  const double weight[3] = {1.0 - static_cast<double>(first.u) - static_cast<double>(first.v),
                            static_cast<double>(first.u), static_cast<double>(first.v)};
  Vec3d move;
  for (std::size_t k = 0; k < 3; ++k) move = move + a.corner[k] * (inside[k] - weight[k]);
  const Vec3d direction =
      to_double({RTCRayN_dir_x(args.ray, args.N, i), RTCRayN_dir_y(args.ray, args.N, i),
                 RTCRayN_dir_z(args.ray, args.N, i)});
  return !covers(triangle_of(data, RTCHitN_primID(args.hit, args.N, i)),
                 RTCHitN_u(args.hit, args.N, i), RTCHitN_v(args.hit, args.N, i), direction, move);
}

// Whether a ray has passed the surface that a candidate belongs to.
bool has_passed(const RTCFilterFunctionNArguments& args, unsigned i, const PassedSurfaces& passed) {
  const unsigned instance = RTCHitN_instID(args.hit, args.N, i, 0);
  const unsigned geometry = RTCHitN_geomID(args.hit, args.N, i);
  const unsigned triangle = RTCHitN_primID(args.hit, args.N, i);
  const unsigned ray = RTCRayN_id(args.ray, args.N, i);
  const PassedSurface* first_on_edge = nullptr;
  for (int k = 0; k < passed.count[ray]; ++k) {
    const PassedSurface& s = passed.surface[ray][k];
    if (s.instance != instance) continue;
    if (s.geometry == geometry && s.triangle == triangle) return true;
    if (first_on_edge == nullptr && is_on_edge(s.u, s.v)) first_on_edge = &s;
  }
  return first_on_edge != nullptr &&
         is_on_edge(RTCHitN_u(args.hit, args.N, i), RTCHitN_v(args.hit, args.N, i)) &&
         is_neighbour(args, i, *first_on_edge);
}

void reject_unseen(const RTCFilterFunctionNArguments* args) {
  const auto& data = *static_cast<const FilterData*>(args->geometryUserPtr);
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] == 0) continue;
    const SurfaceHit hit{data.mesh, RTCHitN_primID(args->hit, n, i), RTCHitN_u(args->hit, n, i),
                         RTCHitN_v(args->hit, n, i)};
    // Ray and normal are in the mesh's frame here, where counter-clockwise triangles face the ray
    // whatever the transform (glTF 2.0, 3.7.4: a mirroring one turns the winding with it).
    const float facing = RTCRayN_dir_x(args->ray, n, i) * RTCHitN_Ng_x(args->hit, n, i) +
                         RTCRayN_dir_y(args->ray, n, i) * RTCHitN_Ng_y(args->hit, n, i) +
                         RTCRayN_dir_z(args->ray, n, i) * RTCHitN_Ng_z(args->hit, n, i);
    if (!accept_hit(*data.scene, hit, facing > 0)) args->valid[i] = 0;
  }
}

void reject_passed(const RTCFilterFunctionNArguments* args) {
  const PassedSurfaces* passed = static_cast<const QueryContext*>(args->context)->passed;
  for (unsigned i = 0; passed != nullptr && i < args->N; ++i)
    if (args->valid[i] != 0 && has_passed(*args, i, *passed)) args->valid[i] = 0;
}

void reject_unseen_and_passed(const RTCFilterFunctionNArguments* args) {
  reject_unseen(args);
  reject_passed(args);
}

}  // namespace

RTCFilterFunctionN filter_for(const MaterialView& material) {
  const bool lets_through = material.alpha_mode == AlphaMode::blend;
  if (may_reject(material)) return lets_through ? reject_unseen_and_passed : reject_unseen;
  return lets_through ? reject_passed : nullptr;
}

}  // namespace omma
