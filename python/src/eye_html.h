// What notebooks show of an eye.
#pragma once

#include <string>

#include "omma/eye.h"

namespace omma::python {

// HTML: a caption with counts, and where the ommatidia look as an SVG picture, less than 200 kB.
std::string eye_html(const Eye& eye);

}  // namespace omma::python
