// The Gaussian splats of a scene as the physics reads them: whitened, those of all clouds under one
// hierarchy of boxes.
#pragma once

#include <memory>
#include <vector>

#include "model/long_work.h"
#include "omma/scene.h"
#include "physics/search/splats_view.h"

namespace omma {

// Points into the scene's harmonics, which must outlive it. Not to be copied: the view is of
// addresses.
struct SplatData {
  SplatData() = default;
  SplatData(const SplatData&) = delete;
  SplatData& operator=(const SplatData&) = delete;

  std::vector<WideNode> nodes;
  std::vector<TracedSplat> splats;
  std::vector<SplatCloudView> clouds;
  SplatsView view;
  Bounds box;  // around their middles, in the world
};

// Null where the scene has none that counts. `origin_m`: of the traced frame; `first_origin_now_m`
// is where that is after things have moved, see SplatsView. Throws omma::Cancelled where `work` is
// cancelled.
std::unique_ptr<SplatData> make_splat_data(const Scene& scene, Vec3d origin_m,
                                           const float* first_origin_now_m, WorkState* work);

}  // namespace omma
