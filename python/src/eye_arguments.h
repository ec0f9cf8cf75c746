// An Eye from Python arguments: those of omma.Eye, and of its replace.
#pragma once

#include <nanobind/nanobind.h>

#include "omma/eye.h"

namespace omma::python {

// Changes the named properties of an eye and checks the whole; omma.Error or TypeError names what
// is wrong. All but `axis` and `position_m` may be left out of an eye that has none yet.
void change_eye(Eye& eye, const nanobind::kwargs& changes);

}  // namespace omma::python
