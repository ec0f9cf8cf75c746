// What must hold of a scene's materials and lamps before a world is lit by paths.
#pragma once

#include <string>

#include "omma/scene.h"

namespace omma {

// How a material scatters and shines, and a lamp: every number. Throws omma::Error that begins with
// `place`, such as "material 0: " or "", and the member. Handles are checked by validate_scene.
void check_scattering(const Material& material, const std::string& place);
void check_punctual_light(const PunctualLight& light, const std::string& place);

// Whether meshes of a material bound a volume, into which rays bend.
bool refracts(const Material& material);

// The emission (factor x texture) of a material, by each component where it is brightest.
Vec3 brightest_emission(const Scene& scene, const Material& material);

// A lit surface gives back no more than it gets: throws omma::Error that lists the materials in use
// which may reflect and transmit more than 1 by their base colour (factor x texture x vertex
// colour) or, without a texture, by their spectra. What spectra scaled by bright texels reach is
// not looked for.
void check_lit_scene(const Scene& scene);

}  // namespace omma
