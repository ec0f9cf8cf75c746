// Tables of physics/surface/specular_albedo.h.
#pragma once

#include <vector>

namespace omma {

struct Albedo {
  double all;        // E
  double polarized;  // Q
};

// Directional albedo of a dielectric's rough boundary, seen from outside, by quadrature: within
// 2e-4. `roughness` as glTF has it, `cosine` of the direction to the normal, in (0, 1].
Albedo specular_albedo(double ior, double roughness, double cosine);

// [albedo_floats] for a dielectric of this refractive index, 1 or more; infinity: for facets that
// reflect all, as those of a white metal.
std::vector<float> make_specular_albedo(double ior);

}  // namespace omma
