#include "sampling/footprint_width.h"

#include "kernel/footprint.h"

namespace omma {

double widest_footprint_rad(const Acceptance& acceptance) {
  return widest_footprint(acceptance.kernel) * acceptance_width_rad(acceptance, 0);
}

double footprint_width_rad(const Acceptance& acceptance, int samples) {
  return footprint_width_rad(widest_footprint(acceptance.kernel), acceptance.width_rad, samples);
}

}  // namespace omma
