// From what an eye sees to what its receptors answer. Receptors that look where their ommatidium
// looks share its rays; those beside the axis, or with an acceptance of their own, look through
// views: an eye with one entry for each different way of looking, which is rendered as any other.
#pragma once

#include <cstdint>
#include <vector>

#include "omma/eye.h"

namespace omma {

struct ReceptorViews {
  Eye eye;                                     // one entry for each view
  std::vector<std::int32_t> view_of_receptor;  // [receptor], index into it
};

// The views of a validated eye. Where a receptor looks with its ommatidium the first entries are
// the ommatidia as they are, and the others follow; so their rays are those of the eye itself. A
// view beside the axis is turned through the nodal point, its up vector with it. Throws omma::Error
// where there is no receptor.
ReceptorViews receptor_views(const Eye& eye);

}  // namespace omma
