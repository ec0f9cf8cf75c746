// Accepts or rejects candidate hits: culled faces and cut-outs, and behind transparent surfaces
// those that the ray has passed already.
#include "backend/embree/filter.h"

#include "backend/embree/embree_tracer.h"
#include "physics/surface/surface.h"

namespace omma {
namespace {

Triangle triangle_of(const FilterData& data, unsigned index) {
  Triangle t;
  for (std::size_t k = 0; k < 3; ++k)
    t.corner[k] = to_double(data.position_m[data.triangles[index][k]]);
  return t;
}

// Whether a ray has passed the surface that a candidate belongs to.
bool has_passed(const RTCFilterFunctionNArguments& args, unsigned i, const PassedSurfaces& passed) {
  const auto& data = *static_cast<const FilterData*>(args.geometryUserPtr);
  const PassedSurface hit{RTCHitN_instID(args.hit, args.N, i, 0), RTCHitN_geomID(args.hit, args.N, i),
                          RTCHitN_primID(args.hit, args.N, i),    0,
                          RTCHitN_u(args.hit, args.N, i),         RTCHitN_v(args.hit, args.N, i)};
  const Vec3 direction{RTCRayN_dir_x(args.ray, args.N, i), RTCRayN_dir_y(args.ray, args.N, i),
                       RTCRayN_dir_z(args.ray, args.N, i)};
  const auto corners = [&](unsigned, unsigned geometry, unsigned triangle) {
    return triangle_of(geometry == hit.geometry ? data : *data.tracer->filter_of[geometry],
                       triangle);
  };
  return has_passed(passed, static_cast<int>(RTCRayN_id(args.ray, args.N, i)), hit, direction,
                    corners);
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
  const bool lets_through = lets_rays_on(material);
  if (may_reject(material)) return lets_through ? reject_unseen_and_passed : reject_unseen;
  return lets_through ? reject_passed : nullptr;
}

}  // namespace omma
