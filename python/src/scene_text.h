// A scene as text, for those who look at it: one line, and a table for notebooks.
#pragma once

#include <string>

#include "omma/scene.h"

namespace omma::python {

std::string scene_repr(const Scene& scene);
std::string scene_html(const Scene& scene);

}  // namespace omma::python
