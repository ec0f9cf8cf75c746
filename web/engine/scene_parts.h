// What a scene looks like, for a page that draws it itself: see scene_parts.cpp.
#pragma once

#include "handles.h"
#include "values.h"

namespace omma::web {

val parts_of(const SceneHandle& handle);
val image_of(const SceneHandle& handle, int image);
// Mean of the background over all directions, linear [r, g, b].
val background_of(const Scene& scene);

}  // namespace omma::web
