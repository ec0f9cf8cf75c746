// What tests of worlds have in common: what single rays see.
#pragma once

#include <span>
#include <vector>

#include "test_scenes.h"

namespace omma::test {

// What single rays bring, [ray][band].
inline std::vector<float> seen(const Renderer& renderer, const Mat4& pose = {}) {
  return render(renderer, std::span(&pose, 1)).response;
}

inline std::vector<float> seen(const World& world, const Eye& eye, const Mat4& pose = {}) {
  return seen(Renderer(world, eye, {.sampling = Fixed{1}}), pose);
}

inline Eye single_rays(int count = 4000) {
  return make_eye(sphere_directions(count), 0);
}

}  // namespace omma::test
