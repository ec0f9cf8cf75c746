// Surfaces that let light through and that the rays of a packet have passed: several may lie in one
// place, so a ray goes on from a little before the one it met, and those it had are left out.
#pragma once

namespace omma {

// A triangle as Embree names it, and where it was hit.
struct PassedSurface {
  unsigned instance, geometry, triangle;
  float t_m, u, v;
};

struct PassedSurfaces {
  // Most surfaces in one place, which is a hundred-thousandth of the distance (physics/path.h); a
  // ray goes on behind that place where there are more.
  static constexpr int room = 64;
  int count[16] = {};               // [ray]
  PassedSurface surface[16][room];  // [ray], in the order they were met
};

}  // namespace omma
