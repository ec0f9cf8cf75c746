// What a call asks of the ground truth, checked, as the physics reads it.
#pragma once

#include <vector>

#include "omma/truth.h"
#include "physics/views/truth_view.h"
#include "world/world_state.h"

namespace omma {

struct Truth {
  TruthView view;
  std::vector<TruthTask> tasks;  // [pose]; empty where nothing is asked for
  // What they point to.
  std::vector<std::int32_t> share_of_instance, object_of_instance;
  std::vector<float> objects;  // [pose][object][3][3]
};

// Throws omma::Error where outputs or motions are of the wrong size. The world must be at rest.
Truth checked_truth(const TruthCall& call, const BuiltScene& built, std::size_t poses,
                    std::size_t ommatidia);

}  // namespace omma
