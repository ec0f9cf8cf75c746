// Pictures of responses for JavaScript: which ommatidium each pixel shows.
#include <emscripten/bind.h>

#include "handles.h"
#include "omma/projection.h"
#include "values.h"

namespace omma::web {
namespace {

Picture make_projection(const EyeHandle& eye, const std::string& kind, int width, int height) {
  return checked(
      [&] { return Picture{projection_ids(*eye.eye, projection_from_name(kind), width, height)}; });
}

val pixels_of(const Picture& picture) {
  return array_of(picture.pixels);
}

val projections() {
  std::vector<std::string> names;
  for (const NamedProjection& named : named_projections()) names.emplace_back(named.name);
  return list_of(names);
}

}  // namespace

void bind_projection() {
  emscripten::class_<Picture>("Picture").function("pixels", &pixels_of);
  emscripten::function("make_projection", &make_projection);
  emscripten::function("projections", &projections);
}

}  // namespace omma::web
