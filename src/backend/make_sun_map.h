// Makes the shadow map of the sun (physics/light/sun_map.h) of a scene as it is placed now. Shared by all
// backends.
//
// What the map does not know: surfaces that let light through in part (BLEND, glass) would cast
// full shadows, so that worlds with any need shadow rays; may_have_sun_map says so. A surface of
// which one side alone is seen shades where the sun sees it, a shadow ray where it is seen from
// below: of closed bodies both are the same. Things that moved since are where they were.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "backend/clearance.h"
#include "model/long_work.h"
#include "model/scene_place.h"
#include "omma/scene.h"
#include "physics/light/sun_map.h"

namespace omma {

struct SunMapSettings {
  // Size of the finest texels across the light, m; 0: 5 mm, or a 2000th of a scene below 10 m. All
  // are as fine where that fits into `most_bytes`; else those are that have the most triangles.
  double texel_m = 0;
  std::size_t most_bytes = std::size_t{128} << 20;
};

struct alignas(64) SunTile {
  std::int32_t words[sun_tile_words];
};

// Owns what its `view` points to. May be moved, not copied.
struct SunMapData {
  SunMapData() = default;
  SunMapData(const SunMapData&) = delete;
  SunMapData& operator=(const SunMapData&) = delete;
  SunMapData(SunMapData&&) = default;
  SunMapData& operator=(SunMapData&&) = default;

  std::vector<SunPage> pages;
  std::vector<SunTile> tiles;
  SunMapView view;
  double finest_texel_m = 0, coarsest_texel_m = 0;  // of pages that have triangles

  std::size_t bytes() const {
    return tiles.size() * sizeof(SunTile) + pages.size() * sizeof(SunPage);
  }
};

// Whether a map can stand for shadow rays.
inline bool may_have_sun_map(const SceneView& view) {
  return !view.has_blend && !view.has_glass;
}

// `towards`: unit, to the middle of the sun's disc. Throws omma::Cancelled. The same bits for any
// number of threads.
SunMapData make_sun_map(const Tracing& tracing, const Scene& scene, const Placement& placement,
                        Vec3 towards, const SunMapSettings& settings = {},
                        const WorkPart& work = {});

}  // namespace omma
