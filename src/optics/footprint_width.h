// How wide the rays of an acceptance may be and are; physics/surface/footprint.h says why.
#pragma once

#include "optics/acceptance_warp.h"

namespace omma {

// Widest footprint that changes the modulation transfer by under 0.01.
double widest_footprint_rad(const Sensitivity& sensitivity);

// Full width of the footprint of one of `samples` rays.
double footprint_width_rad(const Sensitivity& sensitivity, int samples);

}  // namespace omma
